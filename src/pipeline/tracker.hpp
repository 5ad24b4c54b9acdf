#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/map.hpp"
#include "pipeline/matching.hpp"
#include "pipeline/pose_solver.hpp"
#include "pipeline/relocalization.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::detail {

struct TrackingOutcome {
  bool tracked = false;
  bool relocalized = false;
  Pose T_world_camera = Pose::Identity();  ///< the prediction when not tracked
  std::int32_t reference_keyframe = -1;    ///< shares most points with the frame
  int num_matches = 0;                     ///< map points matched
  int num_inliers = 0;                     ///< map points in the solved pose
};

/// Follows the camera from frame to frame against the local map.
class Tracker {
 public:
  Tracker(const PipelineOptions& options, Map* map)
      : options_(options), map_(map), relocalizer_(options) {}

  /// Solves the pose of `frame`, whose points are filled with the inliers' map points and whose
  /// `labels` say what became of every feature.
  TrackingOutcome track(double timestamp_s, const std::vector<std::uint8_t>& thumbnail,
                        FeatureFrame* frame, std::vector<FeatureLabel>* labels, StageTimes* times);

  /// Makes `frame` the one that the next is tracked from. Swaps its buffers away.
  void remember(double timestamp_s, const Pose& T_world_camera, std::int32_t reference_keyframe,
                bool tracked, FeatureFrame* frame);

  /// Motion of the camera from the last frame to this one [T_current_previous] if it moves on as it
  /// did; false when the last two frames were not both tracked.
  bool predict_step(double timestamp_s, Pose* T_current_previous) const;

  const FeatureFrame& last_frame() const { return last_frame_; }

 private:
  Pose T_world_last() const { return map_->T_world_keyframe(last_reference_) * T_reference_last_; }
  /// Whether the velocity says something about a frame so long after the last one.
  bool can_predict(double gap_s) const;
  Pose predict(double timestamp_s) const;
  bool track_from_last(const Pose& T_world_camera_guess, double radius_px, FeatureFrame* frame,
                       Pose* T_world_camera);
  bool track_by_descriptor(const Pose& T_world_camera_guess, FeatureFrame* frame,
                           Pose* T_world_camera);
  bool solve_matches(const Pose& T_world_camera_guess, FeatureFrame* frame, Pose* T_world_camera);
  bool track_local_map(int min_inliers, FeatureFrame* frame, std::vector<FeatureLabel>* labels,
                       TrackingOutcome* outcome);
  void collect_local_points(const Pose& T_world_camera, const FeatureFrame& frame);

  const PipelineOptions options_;
  Map* map_;
  Relocalizer relocalizer_;

  bool has_last_ = false;  ///< the last frame was tracked
  FeatureFrame last_frame_;
  double last_timestamp_s_ = 0.0;
  std::int32_t last_reference_ = 0;
  Pose T_reference_last_ = Pose::Identity();
  bool has_velocity_ = false;
  Vector6 velocity_per_s_ = Vector6::Zero();  ///< of the camera in its own frame
  std::uint32_t frame_number_ = 0;

  // Reused between frames.
  std::vector<Map::Neighbour> neighbours_;
  std::vector<MatchCandidate> candidates_;
  std::vector<Match> matches_;
  std::vector<std::uint8_t> taken_;
  std::vector<PoseObservation> observations_;
  std::vector<std::int32_t> observed_features_;
  MatchWorkspace workspace_;
};

}  // namespace srslam::detail
