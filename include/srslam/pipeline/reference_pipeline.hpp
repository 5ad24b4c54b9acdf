#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/dynamic_culling.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/pipeline/pipeline_options.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/reliability.hpp"

namespace srslam {

/// One RGB-D frame as the pipeline takes it; views are read during process() only.
struct PipelineFrame {
  double timestamp_s = 0.0;
  ImageView<const std::uint8_t> gray;  ///< camera's size
  ImageView<const float> depth_m;      ///< camera's size; invalid where <= 0 or not finite
  /// Optional, camera's size: no feature is taken where it is 0.
  ImageView<const std::uint8_t> feature_mask;
  /// Boxes of this frame, read only when has_detections, by the paper's modules alone; the baseline
  /// does not mask by them.
  ArrayView<const Detection> detections;
  bool has_detections = false;
  /// Optional, camera's size: not 0 on what may move by itself. Then module D does not look at the
  /// boxes.
  ImageView<const std::uint8_t> object_mask;
};

enum class TrackingState : std::uint8_t {
  kNotInitialized,  ///< no frame with enough depth yet
  kTracked,         ///< pose solved with at least min_inliers inliers
  kLost,            ///< pose is a prediction
};

constexpr const char* to_string(TrackingState state) noexcept {
  switch (state) {
    case TrackingState::kNotInitialized:
      return "NOT_INITIALIZED";
    case TrackingState::kTracked:
      return "TRACKED";
    case TrackingState::kLost:
      return "LOST";
  }
  return "UNKNOWN";
}

/// Wall time of one frame by stage [ms]; a stage that did not run is 0.
struct StageTimes {
  double features_ms = 0.0;
  double scene_ms = 0.0;      ///< module S: optical flow and assessment
  double culling_ms = 0.0;    ///< module D: flow of the features, regions and removal
  double tracking_ms = 0.0;   ///< matching and pose solving against the last frame
  double local_map_ms = 0.0;  ///< projection of the local map and the final pose
  double relocalization_ms = 0.0;
  double keyframe_ms = 0.0;           ///< decision, insertion, new points, culling
  double bundle_adjustment_ms = 0.0;  ///< the solve itself; overlaps later frames with two threads
  double total_ms = 0.0;              ///< of process()
};

/// What became of a feature in this frame.
enum class FeatureLabel : std::uint8_t {
  kUnmatched,  ///< no map point found
  kInlier,     ///< matched and consistent with the pose
  kOutlier,    ///< matched, rejected by the χ² gate
  kCulled,     ///< removed by module D before the frame was tracked
};

/// What module D saw in a frame and did. The views have a place for each of
/// PipelineResult::features and are valid until the next process().
struct CullingReport {
  Status status;                 ///< not ok: nothing was removed
  DynamicRegionsResult regions;  ///< stage 1; its status says when the camera's motion is unknown
  DynamicCullingResult removal;  ///< stage 2
  ArrayView<const FlowPoint> points;  ///< where the features are, with their depth
  ArrayView<const FeatureSuspicion> suspicions;
  ArrayView<const CullingVerdict> verdicts;
  /// Removed features that had failed no test themselves and came back, because the frame could not
  /// be tracked without them; such a frame makes no keyframe.
  int num_restored = 0;
};

struct PipelineResult {
  Status status;  ///< not ok: the frame was refused (size, time stamp); nothing was changed
  TrackingState state = TrackingState::kNotInitialized;
  Pose T_world_camera = Pose::Identity();  ///< a prediction unless kTracked
  int num_features = 0;
  int num_features_with_depth = 0;
  int num_matches = 0;
  int num_inliers = 0;
  bool relocalized = false;
  bool is_keyframe = false;
  const char* keyframe_reason = "";  ///< why this frame did or did not become one
  int num_keyframes = 0;             ///< in the map after this frame
  int num_map_points = 0;
  bool has_scene = false;  ///< module S has judged the frame
  SceneReport scene;
  bool has_culling = false;  ///< module D has looked at the frame
  CullingReport culling;
  StageTimes times;
  /// Features of this frame and what became of each, valid until the next process().
  ArrayView<const Feature> features;
  ArrayView<const FeatureLabel> labels;
};

/// The baseline RGB-D SLAM front end and local mapping into which the paper's modules are wired.
/// Deterministic: equal inputs give equal bits, whatever `PipelineOptions::num_threads` is.
/// One instance serves one thread of the caller. No loop closing.
class ReferencePipeline {
 public:
  explicit ReferencePipeline(const PinholeCamera& camera, const PipelineOptions& options = {});
  ~ReferencePipeline();
  ReferencePipeline(ReferencePipeline&&) noexcept;
  ReferencePipeline& operator=(ReferencePipeline&&) noexcept;

  /// Whether camera and options are valid; process() refuses every frame while not ok.
  Status status() const;

  /// Time stamps must increase strictly.
  PipelineResult process(const PipelineFrame& frame);

  /// Waits for mapping that is under way and applies it.
  void finish();

  /// Poses of the keyframes in the map, as bundle adjustment left them.
  Trajectory keyframes() const;

  /// Every tracked frame, carried along with the keyframe it was tracked against, so that later
  /// bundle adjustment moves it too; process() results are the causal counterpart.
  Trajectory optimized_trajectory() const;

 private:
  struct Impl;
  Status status_;
  std::unique_ptr<Impl> impl_;  ///< empty while status_ is not ok
};

}  // namespace srslam
