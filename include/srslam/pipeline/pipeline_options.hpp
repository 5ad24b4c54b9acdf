#pragma once

#include <cstdint>

#include "srslam/core/feature_options.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/dynamic_culling.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/scene/reliability.hpp"
#include "srslam/scene/scene_flow_options.hpp"

namespace srslam {

/// Matching and pose solving.
struct TrackingOptions {
  int min_inliers = 15;              ///< fewer map points in the solved pose: LOST, >= 4
  int min_relocalized_inliers = 30;  ///< the same for a pose found by relocalisation
  int min_initial_points = 100;      ///< features with depth that start a map
  double min_depth_m = 0.1;          ///< valid depth, exclusive
  double max_depth_m = 8.0;          ///< valid depth, exclusive
  double close_depth_m = 3.1;        ///< nearer points are well placed by one depth reading
  /// Baseline of the virtual stereo camera whose disparity stands for depth in residuals: depth
  /// and pixel errors weigh the same. 0.0775 m is the Kinect's 40 m px at 516 px focal length.
  double virtual_baseline_m = 0.0775;
  std::uint32_t seed = 1;  ///< of the random samples of relocalisation
};

/// When a tracked frame becomes a keyframe (docs/pipeline.md).
struct KeyframeOptions {
  int max_frames = 30;                 ///< since the last one: need not wait for the mapper
  int min_frames = 0;                  ///< since the last one, while the mapper is idle
  double weak_ratio = 0.25;            ///< inliers below this share of the reference's: urgent
  double reference_ratio = 0.75;       ///< inliers below this share of the reference's: wanted
  double young_reference_ratio = 0.4;  ///< the same while the map has fewer than two keyframes
  int min_tracked_close = 100;         ///< fewer close points tracked ...
  int min_untracked_close = 70;        ///< ... and more close points untracked: urgent
};

/// Local map and bundle adjustment.
struct MappingOptions {
  int window_size = 10;          ///< keyframes adjusted together, >= 2
  int max_fixed_keyframes = 20;  ///< neighbours that hold them in place, >= 0
  int max_iterations = 8;        ///< of the solver
  int max_keyframes = 200;       ///< in the map; beyond it the most redundant one leaves, >= 3
  int apply_after_frames = 3;    ///< frames from an insertion to the use of its adjustment, >= 1
  double redundant_share = 0.9;  ///< of a keyframe's points seen by others: it leaves, (0, 1]
};

/// Module S: judges every frame (docs/scene_reliability.md). By itself it changes no pose.
struct SceneOptions {
  bool enabled = false;
  SceneAssessorOptions assessor;
  SceneFlowOptions flow;
};

/// Module D: removes the features that move by themselves before the frame is tracked
/// (docs/dynamic_culling.md). Needs module S.
struct CullingOptions {
  bool enabled = false;
  LucasKanadeOptions flow;        ///< of the features back into the previous frame
  DynamicRegionOptions regions;   ///< stage 1: which features may move
  DynamicCullingOptions removal;  ///< stage 2: which of these go
};

struct PipelineOptions {
  FeatureOptions features;  ///< ORB
  TrackingOptions tracking;
  KeyframeOptions keyframes;
  MappingOptions mapping;
  SceneOptions scene;
  CullingOptions culling;
  int num_threads = 2;  ///< 1 or 2: with 2, bundle adjustment overlaps tracking; same bits

  /// Ok, or the first value outside its domain.
  Status validate() const noexcept;
};

}  // namespace srslam
