#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "srslam/core/status.hpp"

namespace srslam {

/// Which reading of an equation of the paper is computed.
enum class EquationForm : std::uint8_t {
  kDefault,  ///< what the equation must mean
  kLiteral,  ///< the equation exactly as printed
};

struct ImprovementResult {
  Status status;
  double percent = std::numeric_limits<double>::quiet_NaN();  ///< NaN unless the status is ok
};

/// Improvement of an error `value` over the `baseline`'s [%]; negative when it is worse (Eq. 25).
///
/// kDefault: 100 · (1 - value / baseline). kLiteral: 1 - value / baseline · 100 as printed, with
/// the parenthesis misplaced: a value of a tenth of the baseline gives -9 instead of 90.
///
/// Both errors in the same unit, finite and not negative (kInvalidArgument). A baseline of 0, or
/// one so small that the ratio overflows, has no improvement (kDegenerate).
inline ImprovementResult improvement_percent(double value, double baseline,
                                             EquationForm form = EquationForm::kDefault) noexcept {
  ImprovementResult result;
  if (!std::isfinite(value) || !std::isfinite(baseline) || value < 0.0 || baseline < 0.0) {
    result.status =
        Status::failure(StatusCode::kInvalidArgument, "errors must be finite and not negative");
    return result;
  }
  const double ratio = baseline > 0.0 ? value / baseline : std::numeric_limits<double>::infinity();
  const double percent =
      form == EquationForm::kLiteral ? 1.0 - ratio * 100.0 : 100.0 * (1.0 - ratio);
  if (!std::isfinite(percent)) {
    result.status = Status::failure(StatusCode::kDegenerate,
                                    "no improvement is defined over a baseline of zero");
    return result;
  }
  result.status = Status::success();
  result.percent = percent;
  return result;
}

}  // namespace srslam
