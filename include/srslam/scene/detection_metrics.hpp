#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "srslam/core/array_view.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/scene_metric.hpp"

namespace srslam {

/// What a metric over detections says of a frame without any. A frame without detections is no
/// worse and no better than others, so that the default leaves the metric out.
enum class NoDetections : std::uint8_t {
  kAbsent,  ///< the metric does not count for this frame
  kZero,    ///< as the printed sum over nothing
  kOne,     ///< the upper end of the metric's range
};

struct DetectionConfidenceOptions {
  double min_score = 0.25;  ///< detections below are left out; [0, 1]
  NoDetections no_detections = NoDetections::kAbsent;

  Status validate() const noexcept {
    if (min_score >= 0.0 && min_score <= 1.0) return Status::success();
    return Status::failure(StatusCode::kInvalidArgument, "min_score must be between 0 and 1");
  }
};

struct DetectionConfidenceResult {
  SceneMetric metric;  ///< in [0, 1]
  std::size_t num_used = 0;
  std::size_t num_ignored = 0;  ///< below min_score, or with a score that is no number in [0, 1]
};

/// What the distance between an object and the image's centre is divided by.
enum class CenterDistanceScale : std::uint8_t {
  kDiagonal,      ///< the image's diagonal, as printed: the term stays in [0.5, 1]
  kHalfDiagonal,  ///< the largest distance inside the image: the term uses [0, 1]
};

/// Whether a central object makes a frame more reliable or less.
enum class CenterMeaning : std::uint8_t {
  kAttention,  ///< more, as printed: what is central is what the camera attends to
  kOcclusion,  ///< less: what is central hides the most
};

struct SpatialDistributionOptions {
  double min_score = 0.25;  ///< detections below are left out; [0, 1]
  CenterDistanceScale distance_scale = CenterDistanceScale::kDiagonal;
  CenterMeaning center = CenterMeaning::kAttention;
  NoDetections no_detections = NoDetections::kAbsent;

  Status validate() const noexcept {
    return DetectionConfidenceOptions{min_score, no_detections}.validate();
  }
};

struct SpatialDistributionResult {
  SceneMetric metric;               ///< in [0, 2]
  double mean_area_term = 0.0;      ///< of 1 - area / image area
  double mean_distance_term = 0.0;  ///< of 1 - distance / scale, or of distance / scale
  std::size_t num_used = 0;
  std::size_t num_ignored = 0;  ///< below min_score, without number, or outside the image
};

namespace detail {

inline SceneMetric metric_without_detections(NoDetections rule, double upper_bound) noexcept {
  if (rule == NoDetections::kZero) return metric_of(0.0, upper_bound);
  if (rule == NoDetections::kOne) return metric_of(upper_bound, upper_bound);
  return failed_metric(Status::success(), upper_bound);
}

inline bool counts(const Detection& detection, double min_score) noexcept {
  return detection.score >= min_score && detection.score <= 1.0;
}

}  // namespace detail

/// Mean score of the detections (Eq. 2). O(n), allocates nothing. kInvalidArgument for options out
/// of range.
inline DetectionConfidenceResult detection_confidence(
    ArrayView<const Detection> detections,
    const DetectionConfidenceOptions& options = {}) noexcept {
  DetectionConfidenceResult result;
  const Status status = options.validate();
  if (!status.ok()) {
    result.metric = detail::failed_metric(status, 1.0);
    return result;
  }
  double sum = 0.0;
  for (const Detection& detection : detections) {
    if (!detail::counts(detection, options.min_score)) {
      ++result.num_ignored;
      continue;
    }
    sum += detection.score;
    ++result.num_used;
  }
  result.metric = result.num_used == 0
                      ? detail::metric_without_detections(options.no_detections, 1.0)
                      : detail::metric_of(sum / double(result.num_used), 1.0);
  return result;
}

/// How little of the image objects take, and how central they are (Eq. 3): the mean over objects of
/// (1 - area / image area) + (1 - distance of the centre / scale). Boxes are clipped to the image.
/// `mask_areas_px`, if not empty, has one area a detection [px²], negative where there is none, and
/// takes the place of the boxes' areas. O(n), allocates nothing. kInvalidArgument for options out
/// of range, an image without size, or another number of areas than detections.
inline SpatialDistributionResult spatial_distribution(
    ArrayView<const Detection> detections, int width_px, int height_px,
    const SpatialDistributionOptions& options = {},
    ArrayView<const double> mask_areas_px = {}) noexcept {
  SpatialDistributionResult result;
  constexpr double kUpperBound = 2.0;
  Status status = options.validate();
  if (status.ok() && (width_px <= 0 || height_px <= 0)) {
    status = Status::failure(StatusCode::kInvalidArgument, "image size must be positive");
  }
  if (status.ok() && !mask_areas_px.empty() && mask_areas_px.size != detections.size) {
    status = Status::failure(StatusCode::kInvalidArgument, "one mask area a detection is needed");
  }
  if (!status.ok()) {
    result.metric = detail::failed_metric(status, kUpperBound);
    return result;
  }
  // Pixel centres are integers: the image reaches half a pixel beyond them.
  const double right = width_px - 0.5;
  const double bottom = height_px - 0.5;
  const double center_u = 0.5 * (width_px - 1);
  const double center_v = 0.5 * (height_px - 1);
  const double diagonal = std::hypot(double(width_px), double(height_px));
  const double scale =
      options.distance_scale == CenterDistanceScale::kDiagonal ? diagonal : 0.5 * diagonal;
  const double image_area = double(width_px) * double(height_px);
  double area_sum = 0.0;
  double distance_sum = 0.0;
  for (std::size_t i = 0; i < detections.size; ++i) {
    const Detection& detection = detections[i];
    const double u_min = std::clamp(detection.x_min_px, -0.5, right);
    const double u_max = std::clamp(detection.x_max_px, -0.5, right);
    const double v_min = std::clamp(detection.y_min_px, -0.5, bottom);
    const double v_max = std::clamp(detection.y_max_px, -0.5, bottom);
    // Negated, so that a box with a NaN is ignored, too.
    if (!detail::counts(detection, options.min_score) || !(u_max > u_min) || !(v_max > v_min)) {
      ++result.num_ignored;
      continue;
    }
    double area = (u_max - u_min) * (v_max - v_min);
    if (!mask_areas_px.empty() && mask_areas_px[i] >= 0.0) area = mask_areas_px[i];
    const double distance =
        std::hypot(0.5 * (u_min + u_max) - center_u, 0.5 * (v_min + v_max) - center_v);
    const double away = std::min(1.0, distance / scale);
    area_sum += std::max(0.0, 1.0 - area / image_area);
    distance_sum += options.center == CenterMeaning::kAttention ? 1.0 - away : away;
    ++result.num_used;
  }
  if (result.num_used == 0) {
    result.metric = detail::metric_without_detections(options.no_detections, kUpperBound);
    return result;
  }
  result.mean_area_term = area_sum / double(result.num_used);
  result.mean_distance_term = distance_sum / double(result.num_used);
  result.metric = detail::metric_of(result.mean_area_term + result.mean_distance_term, kUpperBound);
  return result;
}

}  // namespace srslam
