#pragma once

#include <algorithm>
#include <limits>

#include "srslam/core/status.hpp"

namespace srslam {

/// A metric of one frame. Without `present` it has no value, which is not the same as zero.
struct SceneMetric {
  Status status;                                            ///< kOk also when the metric is absent
  bool present = false;                                     ///< false: absent, `value` is NaN
  double value = std::numeric_limits<double>::quiet_NaN();  ///< in [0, upper_bound]
  double upper_bound = 1.0;

  /// Value in [0, 1]; NaN when absent.
  double normalized() const noexcept { return value / upper_bound; }
};

namespace detail {

inline SceneMetric metric_of(double value, double upper_bound) noexcept {
  SceneMetric metric;
  metric.status = Status::success();
  metric.present = true;
  metric.value = std::clamp(value, 0.0, upper_bound);
  metric.upper_bound = upper_bound;
  return metric;
}

inline SceneMetric failed_metric(const Status& status, double upper_bound) noexcept {
  SceneMetric metric;
  metric.status = status;
  metric.upper_bound = upper_bound;
  return metric;
}

}  // namespace detail

}  // namespace srslam
