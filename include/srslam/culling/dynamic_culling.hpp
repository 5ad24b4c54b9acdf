#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/adaptive_dbscan.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/culling/near_points.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// What the refined branch clusters.
enum class ClusteredFeatures : std::uint8_t {
  kAnomalies,  ///< features that failed a test; a cluster of them is dynamic
  kPotential,  ///< all potential ones; a cluster is dynamic by its share of anomalies
};

/// Which motion residual chooses the branch.
enum class BranchResidual : std::uint8_t {
  kCompensated,  ///< what the camera's motion leaves of the image motion
  /// All image motion, as printed: at the paper's 60 px a camera that moves through a room where
  /// nothing else does would lose every other frame's potential features.
  kRaw,
};

/// Which part of Algorithm 1, stage 2, was taken.
enum class CullingBranch : std::uint8_t {
  kNothing,         ///< no potential feature
  kInitialization,  ///< no residual yet: refined, on the assumption that little moves
  kAggressive,      ///< high motion: all potential features
  kRefined,         ///< depth-assisted adaptive DBSCAN
  kSparing,         ///< the same at high motion, because too little is not potential
};

constexpr const char* to_string(CullingBranch branch) noexcept {
  switch (branch) {
    case CullingBranch::kNothing:
      return "nothing";
    case CullingBranch::kInitialization:
      return "initialization";
    case CullingBranch::kAggressive:
      return "aggressive";
    case CullingBranch::kRefined:
      return "refined";
    case CullingBranch::kSparing:
      return "sparing";
  }
  return "unknown";
}

struct DynamicCullingOptions {
  BranchResidual residual = BranchResidual::kCompensated;
  double high_motion_px = 5.0;       ///< of the compensated residual, exclusive; > 0
  double high_motion_raw_px = 60.0;  ///< of the raw residual, exclusive; > 0
  /// At high motion all potential features go only if at least this share of all features is left;
  /// else the branch is refined: boxes that fill the image hold background, too, and a tracker
  /// without features is lost. [0, 1], 0 as printed
  double min_kept_share = 0.1;
  ClusteredFeatures clustered = ClusteredFeatures::kAnomalies;
  /// Reach of a dynamic cluster around its core points, as a multiple of eps: potential features
  /// within it go unless they are seen to move with the camera. >= 0
  double cluster_reach = 3.0;
  double min_anomalous_share = 0.3;  ///< of a dynamic cluster (kPotential); [0, 1]
  AdaptiveDbscanOptions clustering;

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    for (const double limit_px : {high_motion_px, high_motion_raw_px}) {
      if (!(limit_px > 0.0) || !std::isfinite(limit_px)) {
        return bad("high_motion_px and high_motion_raw_px must be positive and finite");
      }
    }
    if (!(min_kept_share >= 0.0) || min_kept_share > 1.0) {
      return bad("min_kept_share must be in [0, 1]");
    }
    if (!(cluster_reach >= 0.0) || !std::isfinite(cluster_reach)) {
      return bad("cluster_reach must be finite and not negative");
    }
    if (!(min_anomalous_share >= 0.0) || min_anomalous_share > 1.0) {
      return bad("min_anomalous_share must be in [0, 1]");
    }
    return clustering.validate();
  }
};

/// What stage 2 reads beside the features.
struct CullingFrame {
  FrameReliability reliability;
  bool initializing = false;  ///< no reference frame yet, or no residual against it
  /// Motion residual (Eq. 6) by options.residual, at the reference width; not read while
  /// initializing.
  double residual_px = 0.0;
};

/// Why a feature was removed or kept.
enum class CullingVerdict : std::uint8_t {
  kStatic,       ///< not potential
  kKept,         ///< potential, but in no dynamic cluster
  kAggressive,   ///< removed with all potential ones
  kInCluster,    ///< removed: of a dynamic cluster
  kNearCluster,  ///< removed: potential, near a core point of a dynamic cluster, not moving
                 ///< with the camera
};

constexpr bool is_removed(CullingVerdict verdict) noexcept {
  return verdict != CullingVerdict::kStatic && verdict != CullingVerdict::kKept;
}

struct DynamicCullingResult {
  Status status;
  CullingBranch branch = CullingBranch::kNothing;
  AdaptiveDbscanResult clusters;  ///< of the refined branch and of initialization
  int num_dynamic_clusters = 0;
  int num_removed = 0;
  int num_removed_in_clusters = 0;
  int num_removed_near_clusters = 0;
  int num_kept_potential = 0;
};

/// Buffers of cull_dynamic_features(), kept by the caller so that a steady stream allocates
/// nothing.
struct DynamicCullingWorkspace {
  AdaptiveDbscanWorkspace dbscan;
  std::vector<FlowPoint> points;         ///< that were clustered
  std::vector<std::uint32_t> index;      ///< of each, among the features
  std::vector<std::int32_t> labels;      ///< cluster of each
  std::vector<std::uint8_t> is_dynamic;  ///< of each cluster
  std::vector<int> num_anomalous, num_members;
  std::vector<float> potential_depth_m;
  NearPoints core;  ///< core points of dynamic clusters
};

namespace detail {

/// The refined branch of Algorithm 1, stage 2.
class RefinedCulling {
 public:
  RefinedCulling(ArrayView<const FlowPoint> points, ArrayView<const FeatureSuspicion> features,
                 const PinholeCamera& camera, const CullingFrame& frame,
                 const DynamicCullingOptions& options, DynamicCullingWorkspace& workspace,
                 ArrayView<CullingVerdict> verdicts, DynamicCullingResult& result)
      : points_(points),
        features_(features),
        camera_(camera),
        frame_(frame),
        options_(options),
        w_(workspace),
        verdicts_(verdicts),
        result_(result) {}

  void run() {
    select_points();
    w_.labels.resize(w_.points.size());
    result_.clusters = adaptive_dbscan(w_.points, w_.potential_depth_m, camera_, frame_.reliability,
                                       options_.clustering, w_.dbscan, w_.labels);
    if (!result_.clusters.status.ok()) {
      result_.status = result_.clusters.status;
      return;
    }
    find_dynamic_clusters();
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (features_[i].potential()) verdicts_[i] = CullingVerdict::kKept;
    }
    remove_clusters();
    remove_neighbors();
  }

 private:
  void select_points() {
    w_.points.clear();
    w_.index.clear();
    w_.potential_depth_m.clear();
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (!features_[i].potential()) continue;
      w_.potential_depth_m.push_back(points_[i].depth_m);
      if (options_.clustered == ClusteredFeatures::kPotential || features_[i].anomalous()) {
        w_.points.push_back(points_[i]);
        w_.index.push_back(std::uint32_t(i));
      }
    }
  }

  void find_dynamic_clusters() {
    const auto num_clusters = std::size_t(result_.clusters.num_clusters);
    w_.is_dynamic.assign(num_clusters, 1);
    if (options_.clustered == ClusteredFeatures::kPotential) {
      w_.num_anomalous.assign(num_clusters, 0);
      w_.num_members.assign(num_clusters, 0);
      for (std::size_t k = 0; k < w_.labels.size(); ++k) {
        if (w_.labels[k] == kNoiseLabel) continue;
        ++w_.num_members[std::size_t(w_.labels[k])];
        if (features_[w_.index[k]].anomalous()) ++w_.num_anomalous[std::size_t(w_.labels[k])];
      }
      for (std::size_t c = 0; c < num_clusters; ++c) {
        w_.is_dynamic[c] = w_.num_anomalous[c] > 0 &&
                           w_.num_anomalous[c] >= options_.min_anomalous_share * w_.num_members[c];
      }
    }
    for (const std::uint8_t is_dynamic : w_.is_dynamic) result_.num_dynamic_clusters += is_dynamic;
  }

  bool in_dynamic_cluster(std::size_t k) const {
    return w_.labels[k] != kNoiseLabel && w_.is_dynamic[std::size_t(w_.labels[k])] != 0;
  }

  void remove_clusters() {
    for (std::size_t k = 0; k < w_.labels.size(); ++k) {
      if (!in_dynamic_cluster(k)) continue;
      verdicts_[w_.index[k]] = CullingVerdict::kInCluster;
      ++result_.num_removed_in_clusters;
    }
  }

  /// The final dynamic regions: what is potential, near a core point, and not seen to move with the
  /// camera. Depth has no say here: a corner on the contour of a mover moves with it and has the
  /// depth of what is behind, or none, so that no flow could be tested.
  void remove_neighbors() {
    const AdaptiveDbscanOptions& clustering = options_.clustering;
    // Metric eps is no distance in the image: there the base value in image widths bounds the
    // region.
    const bool metric = clustering.space == ClusterSpace::kMetric;
    const std::array<float, 2> unit =
        image_unit(metric ? ClusterSpace::kImageWidth : clustering.space, camera_);
    const auto reach = float(options_.cluster_reach *
                             (metric ? AdaptiveDbscanOptions{}.eps_base * result_.clusters.eps_scale
                                     : result_.clusters.eps));
    w_.core.clear();
    for (std::size_t k = 0; k < w_.points.size(); ++k) {
      if (!in_dynamic_cluster(k) || w_.dbscan.kinds[k] != PointKind::kCore) continue;
      w_.core.add(w_.points[k].u_px * unit[0], w_.points[k].v_px * unit[1]);
    }
    if (w_.core.size() == 0) return;
    for (std::size_t i = 0; i < points_.size; ++i) {
      if (!features_[i].potential() || features_[i].moves_with_camera || is_removed(verdicts_[i]) ||
          !w_.core.any_near(points_[i].u_px * unit[0], points_[i].v_px * unit[1], reach)) {
        continue;
      }
      verdicts_[i] = CullingVerdict::kNearCluster;
      ++result_.num_removed_near_clusters;
    }
  }

  ArrayView<const FlowPoint> points_;
  ArrayView<const FeatureSuspicion> features_;
  const PinholeCamera& camera_;
  const CullingFrame& frame_;
  const DynamicCullingOptions& options_;
  DynamicCullingWorkspace& w_;
  ArrayView<CullingVerdict> verdicts_;
  DynamicCullingResult& result_;
};

}  // namespace detail

/// Which potential features go (Algorithm 1, stage 2). While initializing, and when the residual is
/// not above the limit, anomalies are clustered (depth-assisted adaptive DBSCAN, Eq. 9-14):
/// clusters go, and with them the potential features near their core points unless they are seen to
/// move with the camera; anomalies that are noise and not near a cluster stay. At high motion every
/// potential feature goes, if that leaves enough.
///
/// `points` are the features of the frame, `features` what stage 1 says of them, `verdicts` has a
/// place for each. The same input gives the same bits; allocates only while the workspace grows.
/// kInvalidArgument for options, camera, sizes, a reliability or residual that is no number; every
/// verdict is then kStatic.
inline DynamicCullingResult cull_dynamic_features(
    ArrayView<const FlowPoint> points, ArrayView<const FeatureSuspicion> features,
    const PinholeCamera& camera, const CullingFrame& frame, const DynamicCullingOptions& options,
    DynamicCullingWorkspace& workspace, ArrayView<CullingVerdict> verdicts) {
  DynamicCullingResult result;
  std::fill(verdicts.begin(), verdicts.end(), CullingVerdict::kStatic);
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  if (!result.status.ok()) return result;
  const auto fail = [&](const char* reason) {
    result.status = Status::failure(StatusCode::kInvalidArgument, reason);
    return result;
  };
  if (features.size != points.size || verdicts.size != points.size) {
    return fail("features and verdicts must have a place for each point");
  }
  if (!frame.initializing && !(frame.residual_px >= 0.0)) {
    return fail("the motion residual must be a number and not negative");
  }
  const auto num_potential =
      int(std::count_if(features.begin(), features.end(),
                        [](const FeatureSuspicion& feature) { return feature.potential(); }));
  if (num_potential == 0) return result;

  const double limit_px = options.residual == BranchResidual::kRaw ? options.high_motion_raw_px
                                                                   : options.high_motion_px;
  if (frame.initializing) {
    result.branch = CullingBranch::kInitialization;
  } else if (!(frame.residual_px > limit_px)) {
    result.branch = CullingBranch::kRefined;
  } else {
    const double num_left = double(features.size) - num_potential;
    result.branch = num_left >= options.min_kept_share * double(features.size)
                        ? CullingBranch::kAggressive
                        : CullingBranch::kSparing;
  }
  if (result.branch == CullingBranch::kAggressive) {
    for (std::size_t i = 0; i < features.size; ++i) {
      if (features[i].potential()) verdicts[i] = CullingVerdict::kAggressive;
    }
    result.num_removed = num_potential;
    return result;
  }
  detail::RefinedCulling(points, features, camera, frame, options, workspace, verdicts, result)
      .run();
  if (!result.status.ok()) return result;
  result.num_removed = result.num_removed_in_clusters + result.num_removed_near_clusters;
  result.num_kept_potential = num_potential - result.num_removed;
  return result;
}

}  // namespace srslam
