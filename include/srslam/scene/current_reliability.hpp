#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "srslam/core/status.hpp"
#include "srslam/scene/scene_metric.hpp"

namespace srslam {

enum class CurrentReliabilityForm : std::uint8_t {
  kDefault,        ///< weighted mean of the normalised metrics that are present, in [0, 1]
  kLiteral,        ///< plain sum of the metrics as printed, absent ones left out
  kMinimum,        ///< smallest normalised metric: one bad metric is enough
  kGeometricMean,  ///< weighted, between the two
};

struct SceneMetrics {
  SceneMetric confidence;  ///< Eq. 2
  SceneMetric spatial;     ///< Eq. 3
  SceneMetric feature;     ///< Eq. 4
  SceneMetric depth;       ///< Eq. 5
};

struct CurrentReliabilityOptions {
  CurrentReliabilityForm form = CurrentReliabilityForm::kDefault;
  double confidence_weight = 1.0;  ///< >= 0, not all 0
  double spatial_weight = 1.0;
  double feature_weight = 1.0;
  double depth_weight = 1.0;

  Status validate() const noexcept {
    double sum = 0.0;
    for (const double weight : {confidence_weight, spatial_weight, feature_weight, depth_weight}) {
      if (!(weight >= 0.0) || !std::isfinite(weight)) {
        return Status::failure(StatusCode::kInvalidArgument,
                               "weights must be finite and not negative");
      }
      sum += weight;
    }
    if (sum > 0.0) return Status::success();
    return Status::failure(StatusCode::kInvalidArgument, "at least one weight must be positive");
  }
};

struct CurrentReliabilityResult {
  Status status;  ///< kInsufficientData when no metric with a positive weight is present
  double value = std::numeric_limits<double>::quiet_NaN();
  int num_metrics = 0;  ///< that counted
};

/// The metrics of a frame in one number (Eq. 1). Metrics that are absent, failed or have weight 0
/// do not count.
inline CurrentReliabilityResult current_reliability(
    const SceneMetrics& metrics, const CurrentReliabilityOptions& options = {}) noexcept {
  CurrentReliabilityResult result;
  result.status = options.validate();
  if (!result.status.ok()) return result;
  const std::array<std::pair<const SceneMetric*, double>, 4> terms{
      {{&metrics.confidence, options.confidence_weight},
       {&metrics.spatial, options.spatial_weight},
       {&metrics.feature, options.feature_weight},
       {&metrics.depth, options.depth_weight}}};
  double weight_sum = 0.0;
  double sum = 0.0;
  double literal_sum = 0.0;
  double smallest = 1.0;
  double log_sum = 0.0;
  for (const auto& [metric, weight] : terms) {
    if (!metric->present || weight == 0.0) continue;
    const double normalized = metric->normalized();
    ++result.num_metrics;
    weight_sum += weight;
    sum += weight * normalized;
    literal_sum += metric->value;
    smallest = std::min(smallest, normalized);
    log_sum += weight * std::log(normalized);  // -infinity for 0, whose exponential is 0 again
  }
  if (result.num_metrics == 0) {
    result.status =
        Status::failure(StatusCode::kInsufficientData, "no metric with a weight is present");
    return result;
  }
  result.status = Status::success();
  switch (options.form) {
    case CurrentReliabilityForm::kDefault:
      result.value = sum / weight_sum;
      break;
    case CurrentReliabilityForm::kLiteral:
      result.value = literal_sum;
      break;
    case CurrentReliabilityForm::kMinimum:
      result.value = smallest;
      break;
    case CurrentReliabilityForm::kGeometricMean:
      result.value = std::exp(log_sum / weight_sum);
      break;
  }
  return result;
}

}  // namespace srslam
