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
#include "srslam/core/detection.hpp"
#include "srslam/core/random_stream.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/dbscan.hpp"
#include "srslam/culling/depth_groups.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/culling/near_points.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// Simpler ways to choose the features to remove, which the paper's is compared with. It defines
/// none of them; what is here follows the systems it names.
enum class RemovalBaseline : std::uint8_t {
  /// Box by box: all of it when the share of anomalies is large, else the anomalies alone.
  kProportion,
  kKMeans,      ///< two clusters of the potential features in (u, v, depth), by share of anomalies
  kConvexHull,  ///< what lies within the hull of a box's anomalies
  kDbscan,      ///< clusters of anomalies in the image, without depth and adaptation
};

constexpr const char* to_string(RemovalBaseline baseline) noexcept {
  switch (baseline) {
    case RemovalBaseline::kProportion:
      return "proportion";
    case RemovalBaseline::kKMeans:
      return "k_means";
    case RemovalBaseline::kConvexHull:
      return "convex_hull";
    case RemovalBaseline::kDbscan:
      return "dbscan";
  }
  return "unknown";
}

struct RemovalBaselineOptions {
  double min_anomalous_share = 0.3;  ///< of a box (kProportion) or a cluster (kKMeans); [0, 1]
  int max_iterations = 50;           ///< of k-means, >= 1
  std::uint64_t seed = 1;            ///< of k-means++
  DepthGroupOptions depth;  ///< kConvexHull: anomalies this far from their median are left out
  double eps = 0.02;        ///< kDbscan [image widths]; > 0
  int min_points = 3;       ///< kDbscan; >= 1

  Status validate() const noexcept {
    if (!(min_anomalous_share >= 0.0) || min_anomalous_share > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument, "min_anomalous_share must be in [0, 1]");
    }
    if (max_iterations < 1) {
      return Status::failure(StatusCode::kInvalidArgument, "max_iterations must be at least 1");
    }
    DbscanOptions dbscan_options;
    dbscan_options.eps = eps;
    dbscan_options.min_points = min_points;
    const Status status = dbscan_options.validate();
    return status.ok() ? depth.validate() : status;
  }
};

struct RemovalBaselineResult {
  Status status;
  int num_removed = 0;
};

/// Buffers of remove_by_baseline().
struct RemovalBaselineWorkspace {
  std::vector<std::uint32_t> index;
  std::vector<std::array<float, 2>> image_points;
  std::vector<std::array<float, 3>> points;
  std::vector<std::uint8_t> cluster;
  std::vector<std::int32_t> labels;
  std::vector<float> depth_m, depth_scratch_m;
  std::vector<std::array<float, 2>> hull;
  DbscanWorkspace<float> dbscan;
  NearPoints core;  ///< core points of its clusters
};

namespace detail {

/// Twice the area of a, b, c, positive when they turn to the left.
inline double turn(const std::array<float, 2>& a, const std::array<float, 2>& b,
                   const std::array<float, 2>& c) noexcept {
  return (double(b[0]) - double(a[0])) * (double(c[1]) - double(a[1])) -
         (double(b[1]) - double(a[1])) * (double(c[0]) - double(a[0]));
}

/// Corners of the convex hull, to the left all the way round; the points come back sorted
/// (Andrew's monotone chain).
inline void convex_hull(std::vector<std::array<float, 2>>& points,
                        std::vector<std::array<float, 2>>& hull) {
  std::sort(points.begin(), points.end());
  hull.clear();
  const auto add = [&](const std::array<float, 2>& point, std::size_t num_kept) {
    while (hull.size() >= num_kept + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const auto& point : points) add(point, 0);
  const std::size_t num_lower = hull.size();
  for (std::size_t i = points.size(); i-- > 0;) {
    if (i + 1 < points.size()) add(points[i], num_lower - 1);
  }
  if (hull.size() > 1) hull.pop_back();
}

inline bool in_hull(const std::vector<std::array<float, 2>>& hull,
                    const FlowPoint& point) noexcept {
  const std::array<float, 2> p = {point.u_px, point.v_px};
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (turn(hull[i], hull[(i + 1) % hull.size()], p) < 0.0) return false;
  }
  return hull.size() >= 3;
}

/// The baselines, a member each. They add to what is removed.
class BaselineRemoval {
 public:
  BaselineRemoval(ArrayView<const FlowPoint> points, ArrayView<const FeatureSuspicion> features,
                  ArrayView<const Detection> boxes, const PinholeCamera& camera,
                  const RemovalBaselineOptions& options, RemovalBaselineWorkspace& workspace,
                  ArrayView<std::uint8_t> removed)
      : points_(points),
        features_(features),
        boxes_(boxes),
        unit_(1.0F / float(camera.width_px)),
        options_(options),
        w_(workspace),
        removed_(removed) {}

  void by_proportion() {
    remove_anomalies();
    for (const Detection& box : boxes_) {
      int num_inside = 0;
      int num_anomalous = 0;
      for (std::size_t i = 0; i < points_.size; ++i) {
        if (!in_object_box(i, box)) continue;
        ++num_inside;
        num_anomalous += features_[i].anomalous() ? 1 : 0;
      }
      if (num_anomalous == 0 || num_anomalous < options_.min_anomalous_share * num_inside) continue;
      for (std::size_t i = 0; i < points_.size; ++i) {
        if (in_object_box(i, box)) removed_[i] = 1;
      }
    }
  }

  void by_convex_hull() {
    remove_anomalies();
    for (const Detection& box : boxes_) {
      collect_anomalies_of(box);
      if (w_.image_points.size() < 3) continue;
      convex_hull(w_.image_points, w_.hull);
      for (std::size_t i = 0; i < points_.size; ++i) {
        if (in_object_box(i, box) && in_hull(w_.hull, points_[i])) removed_[i] = 1;
      }
    }
  }

  void by_k_means() {
    select([](const FeatureSuspicion& feature) { return feature.potential(); });
    if (w_.index.size() < 2) {
      remove_anomalies();
      return;
    }
    describe_in_space();
    std::array<std::array<double, 3>, 2> centers = first_centers();
    w_.cluster.assign(w_.points.size(), 2);
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      if (!assign_to(centers)) break;
      centers = means(centers);
    }
    for (std::uint8_t cluster = 0; cluster < 2; ++cluster) {
      int num_members = 0;
      int num_anomalous = 0;
      for (std::size_t k = 0; k < w_.index.size(); ++k) {
        if (w_.cluster[k] != cluster) continue;
        ++num_members;
        num_anomalous += features_[w_.index[k]].anomalous() ? 1 : 0;
      }
      if (num_anomalous == 0 || num_anomalous < options_.min_anomalous_share * num_members) {
        continue;
      }
      for (std::size_t k = 0; k < w_.index.size(); ++k) {
        if (w_.cluster[k] == cluster) removed_[w_.index[k]] = 1;
      }
    }
  }

  Status by_dbscan() {
    select([](const FeatureSuspicion& feature) { return feature.anomalous(); });
    w_.image_points.clear();
    for (const std::uint32_t i : w_.index) {
      w_.image_points.push_back({points_[i].u_px * unit_, points_[i].v_px * unit_});
    }
    w_.labels.resize(w_.index.size());
    DbscanOptions options;
    options.eps = options_.eps;
    options.min_points = options_.min_points;
    const DbscanResult clusters = dbscan(w_.image_points, options, w_.dbscan, w_.labels);
    if (!clusters.status.ok()) return clusters.status;
    w_.core.clear();
    for (std::size_t k = 0; k < w_.index.size(); ++k) {
      if (w_.labels[k] != kNoiseLabel) removed_[w_.index[k]] = 1;
      if (w_.dbscan.kinds[k] != PointKind::kCore) continue;
      w_.core.add(w_.image_points[k][0], w_.image_points[k][1]);
    }
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (!features_[i].potential() || removed_[i] != 0) continue;
      if (w_.core.any_near(points_[i].u_px * unit_, points_[i].v_px * unit_, float(options_.eps))) {
        removed_[i] = 1;
      }
    }
    return Status::success();
  }

 private:
  bool in_object_box(std::size_t i, const Detection& box) const {
    return features_[i].in_object &&
           box_contains(box, double(points_[i].u_px), double(points_[i].v_px));
  }

  void remove_anomalies() {
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (features_[i].anomalous()) removed_[i] = 1;
    }
  }

  template <typename Choose>
  void select(const Choose& choose) {
    w_.index.clear();
    for (std::size_t i = 0; i < features_.size; ++i) {
      if (choose(features_[i])) w_.index.push_back(std::uint32_t(i));
    }
  }

  /// Anomalies within a box whose depth is near their median depth.
  void collect_anomalies_of(const Detection& box) {
    w_.index.clear();
    w_.depth_m.clear();
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (!features_[i].anomalous() || !in_object_box(i, box)) continue;
      w_.index.push_back(std::uint32_t(i));
      w_.depth_m.push_back(points_[i].depth_m);
    }
    w_.image_points.clear();
    std::vector<float>& depth_m = w_.depth_m;
    const DepthThresholdResult threshold =
        depth_threshold(w_.depth_m, options_.depth, w_.depth_scratch_m);
    depth_m.erase(std::remove_if(depth_m.begin(), depth_m.end(),
                                 [](float depth) { return !is_valid_depth(depth); }),
                  depth_m.end());
    const auto median_m = float(median_of(depth_m));
    for (const std::uint32_t i : w_.index) {
      const float depth = points_[i].depth_m;
      if (is_valid_depth(depth) && std::abs(depth - median_m) > threshold.threshold_m) continue;
      w_.image_points.push_back({points_[i].u_px, points_[i].v_px});
    }
  }

  /// (u / width, v / width, depth); a point without depth takes the mean of the others.
  void describe_in_space() {
    double sum_m = 0.0;
    std::size_t num_valid = 0;
    for (const std::uint32_t i : w_.index) {
      if (!is_valid_depth(points_[i].depth_m)) continue;
      sum_m += double(points_[i].depth_m);
      ++num_valid;
    }
    const float mean_m = num_valid > 0 ? float(sum_m / double(num_valid)) : 0.0F;
    w_.points.clear();
    for (const std::uint32_t i : w_.index) {
      const float depth_m = points_[i].depth_m;
      w_.points.push_back({points_[i].u_px * unit_, points_[i].v_px * unit_,
                           is_valid_depth(depth_m) ? depth_m : mean_m});
    }
  }

  static double squared_distance(const std::array<float, 3>& point,
                                 const std::array<double, 3>& center) noexcept {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum += (double(point[axis]) - center[axis]) * (double(point[axis]) - center[axis]);
    }
    return sum;
  }

  static std::array<double, 3> center_at(const std::array<float, 3>& point) noexcept {
    return {double(point[0]), double(point[1]), double(point[2])};
  }

  /// k-means++: any point, then one drawn by its squared distance from it.
  std::array<std::array<double, 3>, 2> first_centers() const {
    RandomStream random(options_.seed);
    std::array<std::array<double, 3>, 2> centers{};
    centers[0] = center_at(w_.points[std::size_t(random.integer(int(w_.points.size())))]);
    double sum = 0.0;
    for (const auto& point : w_.points) sum += squared_distance(point, centers[0]);
    double rest = random.uniform() * sum;
    centers[1] = center_at(w_.points.back());
    for (const auto& point : w_.points) {
      rest -= squared_distance(point, centers[0]);
      if (rest < 0.0) {
        centers[1] = center_at(point);
        break;
      }
    }
    return centers;
  }

  /// Whether anything changed.
  bool assign_to(const std::array<std::array<double, 3>, 2>& centers) {
    bool changed = false;
    for (std::size_t k = 0; k < w_.points.size(); ++k) {
      const std::uint8_t cluster =
          squared_distance(w_.points[k], centers[1]) < squared_distance(w_.points[k], centers[0])
              ? 1
              : 0;
      changed = changed || cluster != w_.cluster[k];
      w_.cluster[k] = cluster;
    }
    return changed;
  }

  std::array<std::array<double, 3>, 2> means(
      const std::array<std::array<double, 3>, 2>& before) const {
    std::array<std::array<double, 3>, 2> sums{};
    std::array<int, 2> counts{};
    for (std::size_t k = 0; k < w_.points.size(); ++k) {
      ++counts[w_.cluster[k]];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sums[w_.cluster[k]][axis] += double(w_.points[k][axis]);
      }
    }
    for (std::size_t cluster = 0; cluster < 2; ++cluster) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        sums[cluster][axis] =
            counts[cluster] > 0 ? sums[cluster][axis] / counts[cluster] : before[cluster][axis];
      }
    }
    return sums;
  }

  ArrayView<const FlowPoint> points_;
  ArrayView<const FeatureSuspicion> features_;
  ArrayView<const Detection> boxes_;
  float unit_;
  const RemovalBaselineOptions& options_;
  RemovalBaselineWorkspace& w_;
  ArrayView<std::uint8_t> removed_;
};

}  // namespace detail

/// Features that a baseline removes, from what stage 1 says of them: 1 in `removed`, which has a
/// place for each. `boxes` are those of objects that may move by themselves. The same input gives
/// the same bits. kInvalidArgument for options, camera or sizes; nothing is then removed.
inline RemovalBaselineResult remove_by_baseline(
    RemovalBaseline baseline, ArrayView<const FlowPoint> points,
    ArrayView<const FeatureSuspicion> features, ArrayView<const Detection> boxes,
    const PinholeCamera& camera, const RemovalBaselineOptions& options,
    RemovalBaselineWorkspace& workspace, ArrayView<std::uint8_t> removed) {
  RemovalBaselineResult result;
  std::fill(removed.begin(), removed.end(), std::uint8_t{0});
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  if (!result.status.ok()) return result;
  if (features.size != points.size || removed.size != points.size) {
    result.status = Status::failure(StatusCode::kInvalidArgument,
                                    "features and removed must have a place for each point");
    return result;
  }
  detail::BaselineRemoval removal(points, features, boxes, camera, options, workspace, removed);
  switch (baseline) {
    case RemovalBaseline::kProportion:
      removal.by_proportion();
      break;
    case RemovalBaseline::kKMeans:
      removal.by_k_means();
      break;
    case RemovalBaseline::kConvexHull:
      removal.by_convex_hull();
      break;
    case RemovalBaseline::kDbscan:
      result.status = removal.by_dbscan();
      break;
  }
  for (const std::uint8_t gone : removed) result.num_removed += gone;
  return result;
}

}  // namespace srslam
