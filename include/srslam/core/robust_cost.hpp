#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "srslam/core/status.hpp"

namespace srslam {

/// Shape of a robust cost function.
enum class RobustKind : std::uint8_t {
  kNone,      ///< least squares
  kHuber,     ///< quadratic, linear beyond the scale
  kCauchy,    ///< logarithmic
  kTukey,     ///< constant beyond the scale: gross outliers have no influence at all
  kStudentT,  ///< logarithmic, negative log-likelihood of the t-distribution
};

/// Stable lower-case name of `kind`.
constexpr const char* to_string(RobustKind kind) noexcept {
  switch (kind) {
    case RobustKind::kNone:
      return "none";
    case RobustKind::kHuber:
      return "huber";
    case RobustKind::kCauchy:
      return "cauchy";
    case RobustKind::kTukey:
      return "tukey";
    case RobustKind::kStudentT:
      return "student_t";
  }
  return "unknown";
}

/// Scales that keep 95 % of the efficiency of least squares when the residuals are normal with
/// unit standard deviation; multiply by the standard deviation of the residuals.
constexpr double kHuberScale95 = 1.345;
constexpr double kCauchyScale95 = 2.385;
constexpr double kTukeyScale95 = 4.685;

/// A robust cost ρ of the squared residual s = e², normalised so that ρ(s) → s as s → 0. A problem
/// minimises Σ ½ ρ(e²); in iteratively re-weighted least squares the residual's weight is dρ/ds.
/// With scale c:
///
///     none       ρ = s                                         weight 1
///     huber      ρ = s, and 2 c √s − c² for s > c²             weight 1, and c / √s
///     cauchy     ρ = c² ln(1 + s / c²)                         weight 1 / (1 + s / c²)
///     tukey      ρ = c²/3 (1 − (1 − s / c²)³), and c²/3        weight (1 − s / c²)², and 0
///     student_t  ρ = ν c² ln(1 + s / (ν c²))                   weight 1 / (1 + s / (ν c²))
///
/// The cost C(r) = ½ c² ln(1 + (r/c)²) that the paper takes from the dense visual odometry
/// literature is half of the Cauchy ρ, as it should be in a sum of ½ ρ. The t-distribution's
/// maximum-likelihood weight (ν + 1) / (ν + s / c²) differs from the weight here by the constant
/// (ν + 1) / ν, which the normalisation above takes out.
///
/// Constant time, no allocation. Members may be evaluated only when validate() is ok.
struct RobustCost {
  RobustKind kind = RobustKind::kNone;
  double scale = 1.0;  ///< c, in units of the residual, > 0; unused by kNone
  double dof = 5.0;    ///< ν of kStudentT, > 0; unused by the others

  /// Ok when `scale` and `dof` are positive and their products are representable.
  Status validate() const noexcept {
    switch (kind) {
      case RobustKind::kNone:
        return Status::success();
      case RobustKind::kHuber:
      case RobustKind::kCauchy:
      case RobustKind::kTukey:
      case RobustKind::kStudentT:
        break;
      default:
        return Status::failure(StatusCode::kInvalidArgument, "unknown kind of robust cost");
    }
    if (!(scale > 0.0) || !std::isnormal(scale * scale)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "robust cost scale must be positive and finite");
    }
    if (kind == RobustKind::kStudentT && (!(dof > 0.0) || !std::isnormal(dof * scale * scale))) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "degrees of freedom must be positive and finite");
    }
    return Status::success();
  }

  /// ρ(s). A negative value, as rounding makes of a quadratic form, counts as 0; NaN costs +∞, so
  /// that no step that leads there looks like progress.
  double rho(double squared_residual) const noexcept {
    if (std::isnan(squared_residual)) return std::numeric_limits<double>::infinity();
    const double s = squared_residual > 0.0 ? squared_residual : 0.0;
    const double c2 = scale * scale;
    switch (kind) {
      case RobustKind::kNone:
        return s;
      case RobustKind::kHuber:
        return s <= c2 ? s : 2.0 * scale * std::sqrt(s) - c2;
      case RobustKind::kCauchy:
        return c2 * std::log1p(s / c2);
      case RobustKind::kTukey: {
        if (s >= c2) return c2 / 3.0;
        // 1 − (1 − x)³ multiplied out: the difference would lose the digits of small residuals.
        const double x = s / c2;
        return s * (1.0 - x * (1.0 - x / 3.0));
      }
      case RobustKind::kStudentT:
        return dof * c2 * std::log1p(s / (dof * c2));
    }
    return s;
  }

  /// dρ/ds, in [0, 1] and never increasing. A negative value counts as 0; a residual that is not
  /// finite has weight 0 whatever the kind, i.e. is left out.
  double weight(double squared_residual) const noexcept {
    if (!std::isfinite(squared_residual)) return 0.0;
    const double s = squared_residual > 0.0 ? squared_residual : 0.0;
    const double c2 = scale * scale;
    switch (kind) {
      case RobustKind::kNone:
        return 1.0;
      case RobustKind::kHuber:
        return s <= c2 ? 1.0 : scale / std::sqrt(s);
      case RobustKind::kCauchy:
        return 1.0 / (1.0 + s / c2);
      case RobustKind::kTukey: {
        if (s >= c2) return 0.0;
        const double remainder = 1.0 - s / c2;
        return remainder * remainder;
      }
      case RobustKind::kStudentT:
        return 1.0 / (1.0 + s / (dof * c2));
    }
    return 1.0;
  }
};

}  // namespace srslam
