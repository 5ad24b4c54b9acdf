#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Where a group of depths ends and the next begins.
enum class DepthGrouping : std::uint8_t {
  kGapLinkage,  ///< at every gap between neighbouring depths that is wider than the threshold
  kAnchored,    ///< where a depth is further than the threshold from the group's smallest
};

/// The threshold of Eq. 11.
enum class DepthThreshold : std::uint8_t {
  kClamped,  ///< the interquartile range within limits
  kLiteral,  ///< the interquartile range: with two bodies in view it reaches from one to the other,
             ///< and everything becomes one group
};

struct DepthGroupOptions {
  DepthThreshold threshold = DepthThreshold::kClamped;
  DepthGrouping grouping = DepthGrouping::kGapLinkage;
  double min_threshold_m = 0.05;  ///< three sigma of a Kinect at 3.3 m; > 0
  double max_threshold_m = 0.20;  ///< keeps two bodies apart that stand 0.4 m apart; >= the minimum

  Status validate() const noexcept {
    if (!(min_threshold_m > 0.0) || !std::isfinite(max_threshold_m) ||
        !(max_threshold_m >= min_threshold_m)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "depth thresholds must be positive, finite and in order");
    }
    return Status::success();
  }
};

/// Eq. 9-11.
struct DepthThresholdResult {
  Status status;
  std::size_t num_depths = 0;          ///< that are valid
  float lower_quartile_m = 0.0F;       ///< Eq. 9
  float upper_quartile_m = 0.0F;       ///< Eq. 10
  float interquartile_range_m = 0.0F;  ///< Eq. 11
  float threshold_m = 0.0F;            ///< what groups are cut by
};

struct DepthGroup {
  std::size_t num_points = 0;
  float min_depth_m = 0.0F;
  float max_depth_m = 0.0F;
};

/// Group of points without a valid depth.
constexpr std::int32_t kNoDepthGroup = -1;

/// Result and buffers of group_by_depth(), kept by the caller so that a steady stream allocates
/// nothing.
struct DepthGroups {
  Status status;
  std::vector<std::int32_t> group_of;  ///< of each point, by ascending depth, or kNoDepthGroup
  std::vector<DepthGroup> groups;
  std::size_t num_without_depth = 0;

  std::vector<std::pair<float, std::uint32_t>> sorted;  ///< scratch: depth and index
};

/// Depths of nothing are 0, negative or not finite.
inline bool is_valid_depth(float depth_m) noexcept {
  return depth_m > 0.0F && std::isfinite(depth_m);
}

/// Threshold between groups of depth from the quartiles of the potential dynamic points' depths
/// (Eq. 9-11): with the n valid depths sorted, D[n/4] and D[3n/4], rounded down. `scratch` keeps
/// its memory. Fails with kInvalidArgument for options, kInsufficientData when no depth is valid:
/// then there is nothing to group. O(n).
inline DepthThresholdResult depth_threshold(ArrayView<const float> depth_m,
                                            const DepthGroupOptions& options,
                                            std::vector<float>& scratch) {
  DepthThresholdResult result;
  result.status = options.validate();
  if (!result.status.ok()) return result;
  scratch.clear();
  for (const float depth : depth_m) {
    if (is_valid_depth(depth)) scratch.push_back(depth);
  }
  const std::size_t n = scratch.size();
  result.num_depths = n;
  if (n == 0) {
    result.status = Status::failure(StatusCode::kInsufficientData, "no point has a valid depth");
    return result;
  }
  const auto place = [&](std::size_t index) { return scratch.begin() + std::ptrdiff_t(index); };
  std::nth_element(scratch.begin(), place(n / 4), scratch.end());
  result.lower_quartile_m = scratch[n / 4];
  std::nth_element(place(n / 4), place(3 * n / 4), scratch.end());
  result.upper_quartile_m = scratch[3 * n / 4];
  result.interquartile_range_m = result.upper_quartile_m - result.lower_quartile_m;
  result.threshold_m = result.interquartile_range_m;
  if (options.threshold == DepthThreshold::kClamped) {
    result.threshold_m = std::clamp(result.threshold_m, float(options.min_threshold_m),
                                    float(options.max_threshold_m));
  }
  return result;
}

/// Groups of similar depth, the nearest first ("group points by depth similarity", Algorithm 1).
/// Every point with a valid depth is in exactly one; equal depths are in the same. Fails with
/// kInvalidArgument for a threshold that is negative or not finite. O(n log n).
inline void group_by_depth(ArrayView<const float> depth_m, float threshold_m,
                           DepthGrouping grouping, DepthGroups& result) {
  result.groups.clear();
  result.num_without_depth = 0;
  result.group_of.assign(depth_m.size, kNoDepthGroup);
  if (!(threshold_m >= 0.0F) || !std::isfinite(threshold_m)) {
    result.status = Status::failure(StatusCode::kInvalidArgument,
                                    "the depth threshold must be finite and not negative");
    return;
  }
  result.sorted.clear();
  for (std::size_t i = 0; i < depth_m.size; ++i) {
    if (is_valid_depth(depth_m[i])) result.sorted.emplace_back(depth_m[i], std::uint32_t(i));
  }
  result.num_without_depth = depth_m.size - result.sorted.size();
  std::sort(result.sorted.begin(), result.sorted.end());
  for (const auto& [depth, index] : result.sorted) {
    const bool starts = result.groups.empty() || depth - (grouping == DepthGrouping::kAnchored
                                                              ? result.groups.back().min_depth_m
                                                              : result.groups.back().max_depth_m) >
                                                     threshold_m;
    if (starts) result.groups.push_back({0, depth, depth});
    DepthGroup& group = result.groups.back();
    ++group.num_points;
    group.max_depth_m = depth;
    result.group_of[index] = std::int32_t(result.groups.size()) - 1;
  }
  result.status = Status::success();
}

}  // namespace srslam
