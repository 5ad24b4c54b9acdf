#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/nearest_rank.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/reliability.hpp"

namespace srslam {

/// What of the stable frames decides.
enum class CalibrationRule : std::uint8_t {
  kPercentiles,  ///< nearly the largest residual, nearly the smallest reliability
  kExtremes,     ///< the largest and the smallest, as in the paper: one bad track sets them
};

struct CalibrationOptions {
  CalibrationRule rule = CalibrationRule::kPercentiles;
  double residual_percentile = 99.0;    ///< becomes the residual scale R_cb; (0, 100]
  double reliability_percentile = 1.0;  ///< becomes the threshold th_scene; [0, 100)
  double min_residual_scale_px = 1.0;   ///< a scale below the noise of the tracks is no use; > 0
  int min_frames = 30;                  ///< judged by motion; fewer are no calibration; >= 2

  Status validate() const noexcept {
    if (!(residual_percentile > 0.0) || residual_percentile > 100.0 ||
        !(reliability_percentile >= 0.0) || !(reliability_percentile < 100.0)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "percentiles must be in (0, 100] and [0, 100)");
    }
    if (!(min_residual_scale_px > 0.0) || !std::isfinite(min_residual_scale_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "min_residual_scale_px must be positive and finite");
    }
    if (min_frames < 2) {
      return Status::failure(StatusCode::kInvalidArgument, "min_frames must be at least 2");
    }
    return Status::success();
  }
};

struct CalibrationResult {
  Status status;
  double residual_scale_px = 0.0;     ///< R_cb
  double threshold = 0.0;             ///< th_scene, for reliabilities with that scale
  std::size_t num_frames = 0;         ///< that were judged by motion
  double good_share = 0.0;            ///< of these, with the new values
  double high_motion_share = 0.0;     ///< of these, above the new scale
  std::vector<double> residuals_px;   ///< sorted
  std::vector<double> reliabilities;  ///< sorted, with the new scale
};

/// R_cb and th_scene from frames of stable sequences, in which nothing moves but the camera
/// (Sec. III-B): the scale is the largest motion residual seen, the threshold the smallest
/// reliability with that scale; by default nearly so, by percentiles. `frames` are terms of frames
/// as SceneReport has them, initial ones are ignored; `assessor` says how terms become
/// reliabilities. kInsufficientData below min_frames. O(n log n).
inline CalibrationResult calibrate_reliability(ArrayView<const ReliabilityTerms> frames,
                                               const SceneAssessorOptions& assessor,
                                               const CalibrationOptions& options = {}) {
  CalibrationResult result;
  result.status = options.validate();
  if (result.status.ok()) result.status = assessor.validate();
  if (!result.status.ok()) return result;
  std::vector<ReliabilityTerms> judged;
  for (const ReliabilityTerms& frame : frames) {
    if (frame.initial || !std::isfinite(frame.residual_px) || !std::isfinite(frame.current)) {
      continue;
    }
    judged.push_back(frame);
    result.residuals_px.push_back(frame.residual_px);
  }
  result.num_frames = result.residuals_px.size();
  if (result.num_frames < static_cast<std::size_t>(options.min_frames)) {
    result.status =
        Status::failure(StatusCode::kInsufficientData, "too few frames that were judged by motion");
    return result;
  }
  std::sort(result.residuals_px.begin(), result.residuals_px.end());
  const bool extremes = options.rule == CalibrationRule::kExtremes;
  result.residual_scale_px =
      std::max(options.min_residual_scale_px,
               nearest_rank(result.residuals_px, extremes ? 100.0 : options.residual_percentile));
  SceneAssessorOptions scaled = assessor;
  scaled.residual_scale_px = result.residual_scale_px;
  result.reliabilities.reserve(result.num_frames);
  for (const ReliabilityTerms& frame : judged) {
    result.reliabilities.push_back(scene_reliability(frame, scaled));
  }
  std::sort(result.reliabilities.begin(), result.reliabilities.end());
  result.threshold =
      nearest_rank(result.reliabilities, extremes ? 0.0 : options.reliability_percentile);
  const auto count = double(result.num_frames);
  result.good_share = double(result.reliabilities.end() -
                             std::lower_bound(result.reliabilities.begin(),
                                              result.reliabilities.end(), result.threshold)) /
                      count;
  result.high_motion_share =
      double(result.residuals_px.end() - std::upper_bound(result.residuals_px.begin(),
                                                          result.residuals_px.end(),
                                                          result.residual_scale_px)) /
      count;
  return result;
}

}  // namespace srslam
