#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/dbscan.hpp"
#include "srslam/culling/depth_groups.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// How a reliability scales a parameter of the clustering (Eq. 12).
enum class AdaptationForm : std::uint8_t {
  /// min + (max - min) / (1 + k exp(-steepness (x - anchor))), with k such that the scale is 1 at
  /// the
  /// anchor: the base value holds there, and the bounds are bounds.
  kAnchored,
  /// As printed: (min + max) / (1 + exp(-steepness x)). For x >= 0 it lies in [1.25, 2.5) at the
  /// paper's bounds of 0.5 and 2.
  kLiteral,
  kLiteralClamped,  ///< the printed value within the bounds
  /// min + (max - min) / (1 + exp(-steepness x)): the printed formula with its likely typing error
  /// mended.
  kMinMaxSigmoid,
};

struct AdaptationOptions {
  AdaptationForm form = AdaptationForm::kAnchored;
  double min_scale = 0.5;  ///< in (0, 1)
  double max_scale = 2.0;  ///< > 1
  double steepness = 5.0;  ///< finite, > 0
  double anchor = 0.2;     ///< reliability at which the scale is 1 (kAnchored); finite

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (!(min_scale > 0.0) || !(min_scale < 1.0)) return bad("min_scale must be between 0 and 1");
    if (!(max_scale > 1.0) || !std::isfinite(max_scale)) {
      return bad("max_scale must be above 1 and finite");
    }
    if (!(steepness > 0.0) || !std::isfinite(steepness)) {
      return bad("steepness must be positive and finite");
    }
    if (!std::isfinite(anchor)) return bad("anchor must be finite");
    return Status::success();
  }
};

/// Factor of a parameter at a reliability (Eq. 12). Rises with it; in (min_scale, max_scale) but
/// for kLiteral.
inline double adaptive_scale(double reliability, const AdaptationOptions& options) noexcept {
  const double low = options.min_scale;
  const double high = options.max_scale;
  const double literal = (low + high) / (1.0 + std::exp(-options.steepness * reliability));
  switch (options.form) {
    case AdaptationForm::kAnchored: {
      const double k = (high - 1.0) / (1.0 - low);
      return low + (high - low) /
                       (1.0 + k * std::exp(-options.steepness * (reliability - options.anchor)));
    }
    case AdaptationForm::kLiteral:
      return literal;
    case AdaptationForm::kLiteralClamped:
      return std::clamp(literal, low, high);
    case AdaptationForm::kMinMaxSigmoid:
      return low + (high - low) / (1.0 + std::exp(-options.steepness * reliability));
  }
  return 1.0;
}

/// Space in which features are clustered, and so the unit of eps.
enum class ClusterSpace : std::uint8_t {
  kImageWidth,     ///< pixels / image width
  kImageDiagonal,  ///< pixels / image diagonal
  kFocalLength,    ///< pixels / focal length, each axis by its own
  kMetric,         ///< metres in the camera frame; points without depth are noise
};

struct AdaptiveDbscanOptions {
  /// In the unit of `space`; > 0. The paper has 0.02 of an unnamed unit; with image widths that
  /// leaves half the anomalies of a walking person as noise (docs/dynamic_culling.md).
  double eps_base = 0.06;
  double min_points_base = 3.0;        ///< >= 1
  AdaptationOptions eps_adaptation{};  ///< by the scene reliability (Eq. 13)
  /// By the feature quality on a scale of 0 to 1 (Eq. 14).
  AdaptationOptions min_points_adaptation{AdaptationForm::kAnchored, 0.5, 2.0, 10.0, 0.5};
  ClusterSpace space = ClusterSpace::kImageWidth;
  bool group_depths = true;  ///< false: plain DBSCAN over all points
  DepthGroupOptions depth_groups{};
  NeighborSearch search = NeighborSearch::kAutomatic;

  Status validate() const noexcept {
    if (!(eps_base > 0.0) || !std::isfinite(eps_base)) {
      return Status::failure(StatusCode::kInvalidArgument, "eps_base must be positive and finite");
    }
    if (!(min_points_base >= 1.0) || !(min_points_base <= 1e6)) {
      return Status::failure(StatusCode::kInvalidArgument, "min_points_base must be 1 to 1e6");
    }
    for (const Status& status :
         {eps_adaptation.validate(), min_points_adaptation.validate(), depth_groups.validate()}) {
      if (!status.ok()) return status;
    }
    return Status::success();
  }
};

/// What adapts the clustering to the frame.
struct FrameReliability {
  double scene = 0.0;     ///< R of Eq. 7, in [0, 1] as a rule
  double features = 0.0;  ///< feature quality of Eq. 4, in [0, 2]
};

/// One depth group, clustered by itself.
struct GroupClusters {
  std::size_t num_points = 0;
  int num_clusters = 0;
  std::uint64_t num_comparisons = 0;  ///< distances looked at
  float min_depth_m = 0.0F;           ///< 0 for the group without depth
  float max_depth_m = 0.0F;
};

struct AdaptiveDbscanResult {
  Status status;
  double eps_scale = 0.0;         ///< Eq. 12
  double min_points_scale = 0.0;  ///< Eq. 12
  double eps = 0.0;               ///< Eq. 13
  int min_points = 0;             ///< Eq. 14, rounded up, at least 2
  DepthThresholdResult depth;     ///< Eq. 9-11; kInsufficientData when no point has depth
  int num_clusters = 0;
  std::uint64_t num_comparisons = 0;  ///< over all groups
};

/// Buffers of adaptive_dbscan(), kept by the caller so that a steady stream allocates nothing.
struct AdaptiveDbscanWorkspace {
  std::vector<PointKind> kinds;       ///< of the points of the last call
  std::vector<GroupClusters> groups;  ///< by ascending depth, then those without depth, if any
  DepthGroups depth_groups;

  std::vector<float> depth_m, depth_scratch;
  std::vector<std::uint32_t> group_begin, order;
  std::vector<std::array<float, 2>> image_points;
  std::vector<std::array<float, 3>> metric_points;
  std::vector<std::int32_t> group_labels;
  DbscanWorkspace<float> dbscan;
};

namespace detail {

/// The points of each depth group one after the other, in their order.
inline void order_by_group(AdaptiveDbscanWorkspace& workspace) {
  const auto& group_of = workspace.depth_groups.group_of;
  const std::size_t num_groups = workspace.depth_groups.groups.size();
  const auto bucket = [&](std::size_t i) {
    return group_of[i] == kNoDepthGroup ? num_groups : std::size_t(group_of[i]);
  };
  workspace.group_begin.assign(num_groups + 2, 0);
  for (std::size_t i = 0; i < group_of.size(); ++i) ++workspace.group_begin[bucket(i) + 1];
  for (std::size_t i = 1; i < workspace.group_begin.size(); ++i) {
    workspace.group_begin[i] += workspace.group_begin[i - 1];
  }
  workspace.order.resize(group_of.size());
  for (std::size_t i = 0; i < group_of.size(); ++i) {
    workspace.order[workspace.group_begin[bucket(i)]++] = std::uint32_t(i);
  }
  // Each begin has moved to its end, which is where the next one was.
  for (std::size_t i = workspace.group_begin.size(); i-- > 1;) {
    workspace.group_begin[i] = workspace.group_begin[i - 1];
  }
  workspace.group_begin[0] = 0;
}

/// Factors from pixels to the unit of the space.
inline std::array<float, 2> image_unit(ClusterSpace space, const PinholeCamera& camera) noexcept {
  const double width = camera.width_px;
  const double height = camera.height_px;
  switch (space) {
    case ClusterSpace::kImageDiagonal: {
      const float unit = float(1.0 / std::hypot(width, height));
      return {unit, unit};
    }
    case ClusterSpace::kFocalLength:
    case ClusterSpace::kMetric:
      return {float(1.0 / camera.fx_px), float(1.0 / camera.fy_px)};
    case ClusterSpace::kImageWidth:
      break;
  }
  return {float(1.0 / width), float(1.0 / width)};
}

}  // namespace detail

/// Depth-assisted adaptive DBSCAN (Eq. 9-14): points are grouped by depth, and within each group
/// clustered by DBSCAN whose eps follows the scene reliability and whose min_points follows the
/// feature quality. No cluster has points of two groups. Points without depth are a group of their
/// own.
///
/// `potential_depth_m`: depths of all potential dynamic points, from which the threshold between
/// groups comes; empty: those of `points`. `labels` has a place for each point: its cluster, or
/// kNoiseLabel; clusters are numbered group by group. Lens distortion is not removed.
///
/// Cost without search: n²/N comparisons for N groups of the same size; up to n² when one group
/// holds nearly all; up to twice that in groups of more than 512. Fails with kInvalidArgument
/// (options, camera, reliability that is no number, size of labels); labels are then untouched.
inline AdaptiveDbscanResult adaptive_dbscan(ArrayView<const FlowPoint> points,
                                            ArrayView<const float> potential_depth_m,
                                            const PinholeCamera& camera,
                                            const FrameReliability& reliability,
                                            const AdaptiveDbscanOptions& options,
                                            AdaptiveDbscanWorkspace& workspace,
                                            ArrayView<std::int32_t> labels) {
  AdaptiveDbscanResult result;
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  const auto fail = [&](const char* reason) {
    result.status = Status::failure(StatusCode::kInvalidArgument, reason);
    return result;
  };
  if (!result.status.ok()) return result;
  if (!std::isfinite(reliability.scene) || !std::isfinite(reliability.features)) {
    return fail("scene and feature reliability must be finite");
  }
  if (labels.size != points.size) return fail("labels must have a place for each point");

  result.eps_scale = adaptive_scale(reliability.scene, options.eps_adaptation);
  result.min_points_scale =
      adaptive_scale(0.5 * reliability.features, options.min_points_adaptation);
  DbscanOptions dbscan_options;
  dbscan_options.eps = result.eps = options.eps_base * result.eps_scale;
  dbscan_options.min_points = result.min_points =
      std::max(2, int(std::ceil(options.min_points_base * result.min_points_scale)));
  dbscan_options.search = options.search;

  workspace.depth_m.clear();
  for (const FlowPoint& point : points) workspace.depth_m.push_back(point.depth_m);
  result.depth = depth_threshold(
      potential_depth_m.empty() ? ArrayView<const float>(workspace.depth_m) : potential_depth_m,
      options.depth_groups, workspace.depth_scratch);
  const float threshold_m =
      !options.group_depths ? std::numeric_limits<float>::max() : result.depth.threshold_m;
  group_by_depth(workspace.depth_m, threshold_m, options.depth_groups.grouping,
                 workspace.depth_groups);
  if (!options.group_depths) {
    // One group, whether or not a point has depth.
    workspace.depth_groups.groups.clear();
    std::fill(workspace.depth_groups.group_of.begin(), workspace.depth_groups.group_of.end(),
              kNoDepthGroup);
  }
  detail::order_by_group(workspace);

  const std::array<float, 2> unit = detail::image_unit(options.space, camera);
  workspace.kinds.assign(points.size, PointKind::kNoise);
  workspace.groups.clear();
  for (std::size_t group = 0; group + 1 < workspace.group_begin.size(); ++group) {
    const std::size_t begin = workspace.group_begin[group];
    const std::size_t size = workspace.group_begin[group + 1] - begin;
    if (size == 0) continue;
    workspace.image_points.clear();
    workspace.metric_points.clear();
    for (std::size_t i = 0; i < size; ++i) {
      const FlowPoint& point = points[workspace.order[begin + i]];
      if (options.space == ClusterSpace::kMetric) {
        const float depth_m =
            is_valid_depth(point.depth_m) ? point.depth_m : std::numeric_limits<float>::quiet_NaN();
        workspace.metric_points.push_back({(point.u_px - float(camera.cx_px)) * unit[0] * depth_m,
                                           (point.v_px - float(camera.cy_px)) * unit[1] * depth_m,
                                           depth_m});
      } else {
        workspace.image_points.push_back({point.u_px * unit[0], point.v_px * unit[1]});
      }
    }
    workspace.group_labels.resize(size);
    const DbscanResult clusters = options.space == ClusterSpace::kMetric
                                      ? dbscan(workspace.metric_points, dbscan_options,
                                               workspace.dbscan, workspace.group_labels)
                                      : dbscan(workspace.image_points, dbscan_options,
                                               workspace.dbscan, workspace.group_labels);
    if (!clusters.status.ok()) {
      result.status = clusters.status;
      return result;
    }
    for (std::size_t i = 0; i < size; ++i) {
      const std::int32_t label = workspace.group_labels[i];
      const std::size_t point = workspace.order[begin + i];
      labels[point] = label == kNoiseLabel ? kNoiseLabel : result.num_clusters + label;
      workspace.kinds[point] = workspace.dbscan.kinds[i];
    }
    GroupClusters summary;
    summary.num_points = size;
    summary.num_clusters = clusters.num_clusters;
    summary.num_comparisons = clusters.num_comparisons;
    if (group < workspace.depth_groups.groups.size()) {
      summary.min_depth_m = workspace.depth_groups.groups[group].min_depth_m;
      summary.max_depth_m = workspace.depth_groups.groups[group].max_depth_m;
    }
    workspace.groups.push_back(summary);
    result.num_clusters += clusters.num_clusters;
    result.num_comparisons += clusters.num_comparisons;
  }
  return result;
}

}  // namespace srslam
