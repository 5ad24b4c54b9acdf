#include "pipeline/tracker.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/stopwatch.hpp"
#include "srslam/core/se3.hpp"

namespace srslam::detail {
namespace {

constexpr double kLastFrameRadius_px = 15.0;
constexpr double kWideRadius_px = 30.0;
constexpr int kMinMatchesFromLast = 20;
constexpr int kMinMatchesByDescriptor = 15;
constexpr int kMinInliersFromLast = 10;
constexpr double kDescriptorRatio = 0.7;
constexpr double kLocalRatio = 0.8;
constexpr double kLocalRadius_px = 12.0;
// Nearly head-on views are predicted better.
constexpr double kHeadOnRadius_px = 7.5;
constexpr double kHeadOnCosine = 0.998;
constexpr double kMinViewCosine = 0.5;
constexpr double kDistanceMargin = 0.2;
constexpr std::size_t kMaxLocalKeyframes = 40;
// A gap longer than this many frame intervals says nothing about the velocity after it.
constexpr double kMaxPredictionGap_s = 0.5;

}  // namespace

bool Tracker::can_predict(double gap_s) const {
  return has_velocity_ && gap_s > 0.0 && gap_s <= kMaxPredictionGap_s;
}

Pose Tracker::predict(double timestamp_s) const {
  Pose T_world_last_frame = T_world_last();
  const double gap_s = timestamp_s - last_timestamp_s_;
  if (!can_predict(gap_s)) return T_world_last_frame;
  const Vector6 motion = velocity_per_s_ * gap_s;
  const Pose predicted = T_world_last_frame * se3_exp(motion);
  // Time stamps a hair apart make a velocity that overflows.
  return predicted.matrix().allFinite() ? predicted : T_world_last_frame;
}

bool Tracker::predict_step(double timestamp_s, Pose* T_current_previous) const {
  if (!can_predict(timestamp_s - last_timestamp_s_)) return false;
  *T_current_previous = predict(timestamp_s).inverse() * T_world_last();
  return true;
}

bool Tracker::solve_matches(const Pose& T_world_camera_guess, FeatureFrame* frame,
                            Pose* T_world_camera) {
  const TrackingCamera& camera = map_->camera();
  observations_.clear();
  for (const Match& match : matches_) {
    observations_.push_back(
        make_pose_observation(camera, *frame, static_cast<std::size_t>(match.feature),
                              candidates_[static_cast<std::size_t>(match.candidate)].position_m));
  }
  const PoseSolution solution = solve_pose(camera, T_world_camera_guess, &observations_);
  frame->points.assign(frame->size(), PointHandle{});
  if (!solution.status.ok()) return false;
  int num_map_inliers = 0;
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (!observations_[i].inlier) continue;
    const PointHandle handle = candidates_[static_cast<std::size_t>(matches_[i].candidate)].handle;
    if (!handle.assigned()) continue;
    frame->points[static_cast<std::size_t>(matches_[i].feature)] = handle;
    ++num_map_inliers;
  }
  *T_world_camera = solution.T_world_camera;
  return num_map_inliers >= kMinInliersFromLast;
}

bool Tracker::track_from_last(const Pose& T_world_camera_guess, double radius_px,
                              FeatureFrame* frame, Pose* T_world_camera) {
  const TrackingCamera& camera = map_->camera();
  const Pose T_world_last_frame = T_world_last();
  candidates_.clear();
  for (std::size_t i = 0; i < last_frame_.size(); ++i) {
    const Measurement& measurement = last_frame_.measurements[i];
    MatchCandidate candidate;
    const MapPoint* point = map_->point(last_frame_.points[i]);
    if (point != nullptr) {
      candidate.position_m = point->position_m;
      candidate.handle = last_frame_.points[i];
    } else if (measurement.has_depth() && measurement.depth_m < options_.tracking.close_depth_m) {
      // Not in the map, but one depth reading is good enough for one frame's motion.
      candidate.position_m =
          T_world_last_frame * camera.unproject(measurement.pixel, measurement.depth_m);
    } else {
      continue;
    }
    candidate.descriptor = last_frame_.descriptors[i];
    candidate.octave = last_frame_.features[i].octave;
    candidate.angle_rad = last_frame_.features[i].angle_rad;
    candidate.radius_px = radius_px;
    candidates_.push_back(candidate);
  }
  taken_.clear();
  match_by_projection(camera, *frame, T_world_camera_guess.inverse(), candidates_, taken_,
                      ProjectionMatchOptions{}, &workspace_, &matches_);
  if (static_cast<int>(matches_.size()) < kMinMatchesFromLast) return false;
  return solve_matches(T_world_camera_guess, frame, T_world_camera);
}

bool Tracker::track_by_descriptor(const Pose& T_world_camera_guess, FeatureFrame* frame,
                                  Pose* T_world_camera) {
  const Keyframe& reference = *map_->keyframe(map_->living_keyframe(last_reference_));
  candidates_.clear();
  for (std::size_t i = 0; i < reference.frame.size(); ++i) {
    const MapPoint* point = map_->point(reference.frame.points[i]);
    if (point == nullptr) continue;
    MatchCandidate candidate;
    candidate.position_m = point->position_m;
    candidate.handle = reference.frame.points[i];
    candidate.descriptor = reference.frame.descriptors[i];
    candidate.octave = reference.frame.features[i].octave;
    candidate.angle_rad = reference.frame.features[i].angle_rad;
    candidates_.push_back(candidate);
  }
  match_by_descriptor(*frame, candidates_, kDescriptorRatio, &workspace_, &matches_);
  if (static_cast<int>(matches_.size()) < kMinMatchesByDescriptor) return false;
  return solve_matches(T_world_camera_guess, frame, T_world_camera);
}

void Tracker::collect_local_points(const Pose& T_world_camera, const FeatureFrame& frame) {
  const TrackingCamera& camera = map_->camera();
  map_->count_shared(frame.points, -1, &neighbours_);
  if (neighbours_.size() > kMaxLocalKeyframes) neighbours_.resize(kMaxLocalKeyframes);

  const std::uint32_t mark = map_->next_visit_mark();
  for (const PointHandle& handle : frame.points) {
    MapPoint* point = map_->point(handle);
    if (point == nullptr) continue;
    point->visit_mark = mark;  // already matched
    ++point->num_visible;
  }
  const Pose T_camera_world = T_world_camera.inverse();
  const Eigen::Vector3d centre = T_world_camera.translation();
  candidates_.clear();
  for (const Map::Neighbour& neighbour : neighbours_) {
    const FeatureFrame& neighbour_frame = map_->keyframe(neighbour.keyframe)->frame;
    for (const PointHandle& handle : neighbour_frame.points) {
      MapPoint* point = map_->point(handle);
      if (point == nullptr || point->visit_mark == mark) continue;
      point->visit_mark = mark;
      const Eigen::Vector3d point_camera_m = T_camera_world * point->position_m;
      if (point_camera_m.z() <= 0.0) continue;
      const Eigen::Vector3d predicted = camera.project(point_camera_m);
      if (!camera.in_image(predicted.x(), predicted.y())) continue;
      const Eigen::Vector3d ray = point->position_m - centre;
      const double distance_m = ray.norm();
      if (distance_m < (1.0 - kDistanceMargin) * point->min_distance_m ||
          distance_m > (1.0 + kDistanceMargin) * point->max_distance_m) {
        continue;
      }
      const double view_cosine = ray.dot(point->mean_direction) / distance_m;
      if (view_cosine < kMinViewCosine) continue;
      ++point->num_visible;
      MatchCandidate candidate;
      candidate.position_m = point->position_m;
      candidate.descriptor = point->descriptor;
      candidate.handle = handle;
      candidate.octave = map_->predicted_octave(*point, distance_m);
      candidate.radius_px = view_cosine > kHeadOnCosine ? kHeadOnRadius_px : kLocalRadius_px;
      candidates_.push_back(candidate);
    }
  }
}

bool Tracker::track_local_map(int min_inliers, FeatureFrame* frame,
                              std::vector<FeatureLabel>* labels, TrackingOutcome* outcome) {
  const TrackingCamera& camera = map_->camera();
  collect_local_points(outcome->T_world_camera, *frame);
  taken_.resize(frame->size());
  for (std::size_t i = 0; i < frame->size(); ++i) {
    taken_[i] = map_->point(frame->points[i]) != nullptr ? 1 : 0;
  }
  ProjectionMatchOptions projection;
  projection.levels_below = 1;
  projection.levels_above = 0;
  projection.max_ratio = kLocalRatio;
  projection.check_rotation = false;
  match_by_projection(camera, *frame, outcome->T_world_camera.inverse(), candidates_, taken_,
                      projection, &workspace_, &matches_);
  for (const Match& match : matches_) {
    frame->points[static_cast<std::size_t>(match.feature)] =
        candidates_[static_cast<std::size_t>(match.candidate)].handle;
  }

  observations_.clear();
  observed_features_.clear();
  for (std::size_t i = 0; i < frame->size(); ++i) {
    const MapPoint* point = map_->point(frame->points[i]);
    if (point == nullptr) continue;
    observations_.push_back(make_pose_observation(camera, *frame, i, point->position_m));
    observed_features_.push_back(static_cast<std::int32_t>(i));
  }
  const PoseSolution solution = solve_pose(camera, outcome->T_world_camera, &observations_);
  outcome->num_matches = static_cast<int>(observations_.size());
  outcome->num_inliers = solution.status.ok() ? solution.num_inliers : 0;
  labels->assign(frame->size(), FeatureLabel::kUnmatched);
  if (outcome->num_inliers < min_inliers) return false;

  outcome->T_world_camera = solution.T_world_camera;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const auto feature = static_cast<std::size_t>(observed_features_[i]);
    if (observations_[i].inlier) {
      (*labels)[feature] = FeatureLabel::kInlier;
      ++map_->point(frame->points[feature])->num_found;
    } else {
      (*labels)[feature] = FeatureLabel::kOutlier;
      frame->points[feature] = PointHandle{};
    }
  }
  map_->count_shared(frame->points, -1, &neighbours_);
  outcome->reference_keyframe = neighbours_.front().keyframe;
  return true;
}

TrackingOutcome Tracker::track(double timestamp_s, const std::vector<std::uint8_t>& thumbnail,
                               FeatureFrame* frame, std::vector<FeatureLabel>* labels,
                               StageTimes* times) {
  ++frame_number_;
  TrackingOutcome outcome;
  const Pose predicted = predict(timestamp_s);
  outcome.T_world_camera = predicted;
  outcome.reference_keyframe = map_->living_keyframe(last_reference_);
  labels->assign(frame->size(), FeatureLabel::kUnmatched);

  Stopwatch stopwatch;
  bool found = has_last_ &&
               (track_from_last(predicted, kLastFrameRadius_px, frame, &outcome.T_world_camera) ||
                track_from_last(predicted, kWideRadius_px, frame, &outcome.T_world_camera) ||
                track_by_descriptor(T_world_last(), frame, &outcome.T_world_camera));
  times->tracking_ms += stopwatch.lap_ms();
  if (found) {
    found = track_local_map(options_.tracking.min_inliers, frame, labels, &outcome);
    times->local_map_ms += stopwatch.lap_ms();
  }
  if (!found) {
    const Relocalization relocalization = relocalizer_.find(
        *map_, map_->living_keyframe(last_reference_), frame_number_, thumbnail, frame);
    times->relocalization_ms += stopwatch.lap_ms();
    if (relocalization.status.ok()) {
      outcome.T_world_camera = relocalization.T_world_camera;
      found = track_local_map(options_.tracking.min_relocalized_inliers, frame, labels, &outcome);
      outcome.relocalized = found;
      times->local_map_ms += stopwatch.lap_ms();
    }
  }
  outcome.tracked = found;
  if (!found) {
    outcome.T_world_camera = predicted;
    outcome.num_inliers = 0;
    frame->points.assign(frame->size(), PointHandle{});
  }
  return outcome;
}

void Tracker::remember(double timestamp_s, const Pose& T_world_camera,
                       std::int32_t reference_keyframe, bool tracked, FeatureFrame* frame) {
  if (tracked && has_last_) {
    const double gap_s = timestamp_s - last_timestamp_s_;
    has_velocity_ = gap_s > 0.0 && gap_s <= kMaxPredictionGap_s;
    if (has_velocity_) {
      velocity_per_s_ = se3_log(T_world_last().inverse() * T_world_camera) / gap_s;
    }
  } else {
    has_velocity_ = false;
  }
  has_last_ = tracked;
  if (!tracked) return;  // keep what was last known, as a place to start from
  last_timestamp_s_ = timestamp_s;
  last_reference_ = reference_keyframe;
  T_reference_last_ = map_->T_world_keyframe(reference_keyframe).inverse() * T_world_camera;
  std::swap(last_frame_, *frame);
}

}  // namespace srslam::detail
