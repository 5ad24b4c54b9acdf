#include "pipeline/local_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "pipeline/pose_solver.hpp"

namespace srslam::detail {
namespace {

// At least this many points are made from depth even where they are far.
constexpr int kMinPointsFromDepth = 100;
constexpr std::size_t kNumFusedNeighbours = 10;
constexpr double kFuseRadius_px = 3.0;
// Keyframes that share fewer points with the newest one are not adjusted with it.
constexpr int kMinSharedInWindow = 15;
// A point is on probation until this many keyframes after its creation.
constexpr std::int32_t kProbationKeyframes = 2;
constexpr double kMinFoundShare = 0.25;
// Observation score that a point needs after probation.
constexpr int kMinObservationScore = 4;
// A point is no loss to a keyframe when so many others see it as sharply.
constexpr int kRedundantObservers = 3;

}  // namespace

LocalMapper::~LocalMapper() {
  if (solve_.valid()) solve_.wait();
}

double LocalMapper::take_solve_ms() {
  const double solve_ms = last_solve_ms_;
  last_solve_ms_ = 0.0;
  return solve_ms;
}

bool LocalMapper::advance_frame() {
  if (!pending_) return false;
  if (--frames_until_applied_ > 0) return false;
  return apply_pending();
}

bool LocalMapper::apply_pending() {
  if (!pending_) return false;
  if (solve_.valid()) solve_.get();
  pending_ = false;
  last_solve_ms_ = problem_.solve_ms;
  if (!problem_.usable) {
    // The map's bound holds whatever came of the solve.
    cull_keyframes();
    return true;
  }
  for (const BundleProblem::View& view : problem_.views) {
    Keyframe* keyframe = map_->keyframe(view.keyframe);
    if (!view.fixed && keyframe != nullptr) keyframe->T_world_camera = view.T_world_camera;
  }
  for (const BundleProblem::Landmark& landmark : problem_.landmarks) {
    MapPoint* point = map_->point(landmark.handle);
    if (point != nullptr) point->position_m = landmark.position_m;
  }
  for (const BundleProblem::Edge& edge : problem_.edges) {
    if (edge.inlier) continue;
    const std::int32_t view = problem_.views[static_cast<std::size_t>(edge.view)].keyframe;
    if (map_->keyframe(view) == nullptr) continue;
    map_->remove_observation(problem_.landmarks[static_cast<std::size_t>(edge.landmark)].handle,
                             view);
  }
  for (const BundleProblem::Landmark& landmark : problem_.landmarks) {
    MapPoint* point = map_->point(landmark.handle);
    if (point != nullptr) map_->refresh_point_geometry(point);
  }
  cull_keyframes();
  return true;
}

std::int32_t LocalMapper::insert(double timestamp_s, const Pose& T_world_camera,
                                 const FeatureFrame& frame, std::vector<std::uint8_t> thumbnail) {
  apply_pending();
  Keyframe* keyframe = map_->add_keyframe(timestamp_s, T_world_camera, frame);
  keyframe->thumbnail = std::move(thumbnail);
  const std::int32_t index = keyframe->index;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const PointHandle& handle = frame.points[i];
    const MapPoint* point = map_->point(handle);
    if (point != nullptr && map_->observing_feature(*point, index) < 0) {
      map_->add_observation(handle, index, static_cast<std::int32_t>(i));
    }
  }
  cull_recent_points(index);
  create_points(keyframe);
  if (map_->keyframe_indices().size() > 1) fuse_with_neighbours(index);
  refresh_points_of(*keyframe);
  newest_keyframe_ = index;
  if (map_->keyframe_indices().size() < 2) return index;

  build_problem(index);
  pending_ = true;
  frames_until_applied_ = options_.mapping.apply_after_frames;
  const auto solve = [this] {
    solve_bundle(map_->camera(), options_.mapping.max_iterations, &problem_);
  };
  if (options_.num_threads > 1) {
    try {
      solve_ = std::async(std::launch::async, solve);
      return index;
    } catch (const std::system_error&) {
      // No thread to be had: the result is the same, only later.
    }
  }
  solve();
  return index;
}

void LocalMapper::create_points(Keyframe* keyframe) {
  by_depth_.clear();
  for (std::size_t i = 0; i < keyframe->frame.size(); ++i) {
    const Measurement& measurement = keyframe->frame.measurements[i];
    if (measurement.has_depth()) {
      by_depth_.emplace_back(measurement.depth_m, static_cast<std::int32_t>(i));
    }
  }
  std::sort(by_depth_.begin(), by_depth_.end());
  int num_points = 0;
  for (const auto& [depth_m, feature] : by_depth_) {
    if (depth_m > options_.tracking.close_depth_m && num_points >= kMinPointsFromDepth) break;
    ++num_points;
    const auto i = static_cast<std::size_t>(feature);
    if (map_->point(keyframe->frame.points[i]) != nullptr) continue;
    const Eigen::Vector3d point_camera_m =
        map_->camera().unproject(keyframe->frame.measurements[i].pixel, depth_m);
    const PointHandle handle =
        map_->add_point(keyframe->T_world_camera * point_camera_m, keyframe->index);
    map_->add_observation(handle, keyframe->index, feature);
    map_->refresh_point(handle);
    recent_points_.push_back(handle);
  }
}

void LocalMapper::fuse_with_neighbours(std::int32_t index) {
  const Keyframe& keyframe = *map_->keyframe(index);
  map_->count_shared(keyframe.frame.points, index, &neighbours_);
  if (neighbours_.size() > kNumFusedNeighbours) neighbours_.resize(kNumFusedNeighbours);
  const std::vector<Map::Neighbour> neighbours = neighbours_;

  const std::vector<PointHandle> own_points = keyframe.frame.points;
  for (const Map::Neighbour& neighbour : neighbours) fuse_into(own_points, neighbour.keyframe);

  collected_.clear();
  const std::uint32_t mark = map_->next_visit_mark();
  for (const Map::Neighbour& neighbour : neighbours) {
    for (const PointHandle& handle : map_->keyframe(neighbour.keyframe)->frame.points) {
      MapPoint* point = map_->point(handle);
      if (point == nullptr || point->visit_mark == mark) continue;
      point->visit_mark = mark;
      collected_.push_back(handle);
    }
  }
  fuse_into(collected_, index);
}

void LocalMapper::fuse_into(const std::vector<PointHandle>& points, std::int32_t index) {
  const TrackingCamera& camera = map_->camera();
  const Keyframe& keyframe = *map_->keyframe(index);
  const Pose T_camera_world = keyframe.T_world_camera.inverse();
  for (const PointHandle& handle : points) {
    const MapPoint* point = map_->point(handle);
    if (point == nullptr || map_->observing_feature(*point, index) >= 0) continue;
    const Eigen::Vector3d point_camera_m = T_camera_world * point->position_m;
    if (point_camera_m.z() <= 0.0) continue;
    const Eigen::Vector3d predicted = camera.project(point_camera_m);
    if (!camera.in_image(predicted.x(), predicted.y())) continue;
    const Eigen::Vector3d ray = point->position_m - keyframe.T_world_camera.translation();
    const double distance_m = ray.norm();
    if (distance_m < 0.8 * point->min_distance_m || distance_m > 1.2 * point->max_distance_m) {
      continue;
    }
    if (ray.dot(point->mean_direction) < 0.5 * distance_m) continue;
    const int octave = map_->predicted_octave(*point, distance_m);
    const double radius_px =
        kFuseRadius_px * double(camera.level_scales[static_cast<std::size_t>(octave)]);
    int best_distance = kMaxHammingUnpredicted + 1;
    std::int32_t best_feature = -1;
    keyframe.frame.for_each_near(
        predicted.x(), predicted.y(), radius_px, octave - 1, octave, [&](std::size_t feature) {
          const Measurement& measurement = keyframe.frame.measurements[feature];
          const double sigma = double(
              camera
                  .level_scales[static_cast<std::size_t>(keyframe.frame.features[feature].octave)]);
          double squared = (measurement.pixel - predicted.head<2>()).squaredNorm();
          double gate = kChi2Pixel;
          if (measurement.has_depth()) {
            const double disparity_error = measurement.disparity_px - predicted.z();
            squared += disparity_error * disparity_error;
            gate = kChi2PixelDepth;
          }
          if (squared > gate * sigma * sigma) return;
          const int distance =
              hamming_distance(point->descriptor, keyframe.frame.descriptors[feature]);
          if (distance < best_distance) {
            best_distance = distance;
            best_feature = static_cast<std::int32_t>(feature);
          }
        });
    if (best_feature < 0) continue;
    const PointHandle present = keyframe.frame.points[static_cast<std::size_t>(best_feature)];
    const MapPoint* other = map_->point(present);
    if (other == nullptr) {
      map_->add_observation(handle, index, best_feature);
    } else if (other->observations.size() >= point->observations.size()) {
      map_->merge_points(present, handle);
      map_->refresh_point(present);
    } else {
      map_->merge_points(handle, present);
      map_->refresh_point(handle);
    }
  }
}

void LocalMapper::refresh_points_of(const Keyframe& keyframe) {
  for (const PointHandle& handle : keyframe.frame.points) map_->refresh_point(handle);
}

void LocalMapper::cull_recent_points(std::int32_t newest_keyframe) {
  std::size_t kept = 0;
  for (const PointHandle& handle : recent_points_) {
    const MapPoint* point = map_->point(handle);
    if (point == nullptr) continue;
    const std::int32_t age = newest_keyframe - point->created_by;
    const bool rarely_found = point->num_found < kMinFoundShare * point->num_visible;
    const bool rarely_observed =
        age >= kProbationKeyframes && map_->observation_score(*point) < kMinObservationScore;
    if (rarely_found || rarely_observed) {
      map_->remove_point(handle);
    } else if (age <= kProbationKeyframes) {
      recent_points_[kept++] = handle;
    }
  }
  recent_points_.resize(kept);
}

double LocalMapper::redundancy(const Keyframe& keyframe) const {
  int num_points = 0;
  int num_redundant = 0;
  for (std::size_t i = 0; i < keyframe.frame.size(); ++i) {
    const MapPoint* point = map_->point(keyframe.frame.points[i]);
    if (point == nullptr) continue;
    const Measurement& measurement = keyframe.frame.measurements[i];
    if (!measurement.has_depth() || measurement.depth_m > options_.tracking.close_depth_m) continue;
    ++num_points;
    const int octave = keyframe.frame.features[i].octave;
    int num_others = 0;
    for (const Observation& observation : point->observations) {
      if (observation.keyframe == keyframe.index) continue;
      const FeatureFrame& other = map_->keyframe(observation.keyframe)->frame;
      if (other.features[static_cast<std::size_t>(observation.feature)].octave <= octave + 1 &&
          ++num_others >= kRedundantObservers) {
        break;
      }
    }
    if (num_others >= kRedundantObservers) ++num_redundant;
  }
  return num_points == 0 ? 1.0 : double(num_redundant) / num_points;
}

void LocalMapper::cull_keyframes() {
  // The first keyframe is the world's origin, the newest is what tracking refers to.
  const auto may_leave = [&](std::int32_t index) { return index > 0 && index != newest_keyframe_; };
  const Keyframe* newest = map_->keyframe(newest_keyframe_);
  map_->count_shared(newest->frame.points, newest_keyframe_, &neighbours_);
  std::sort(
      neighbours_.begin(), neighbours_.end(),
      [](const Map::Neighbour& a, const Map::Neighbour& b) { return a.keyframe < b.keyframe; });
  const std::vector<Map::Neighbour> neighbours = neighbours_;
  for (const Map::Neighbour& neighbour : neighbours) {
    if (!may_leave(neighbour.keyframe)) continue;
    if (redundancy(*map_->keyframe(neighbour.keyframe)) > options_.mapping.redundant_share) {
      map_->remove_keyframe(neighbour.keyframe);
    }
  }
  while (static_cast<int>(map_->keyframe_indices().size()) > options_.mapping.max_keyframes) {
    std::int32_t most_redundant = -1;
    double most = -1.0;
    for (const std::int32_t index : map_->keyframe_indices()) {
      if (!may_leave(index)) continue;
      const double share = redundancy(*map_->keyframe(index));
      if (share > most) {
        most = share;
        most_redundant = index;
      }
    }
    map_->remove_keyframe(most_redundant);
  }
}

void LocalMapper::build_problem(std::int32_t index) {
  problem_.clear();
  const TrackingCamera& camera = map_->camera();
  map_->count_shared(map_->keyframe(index)->frame.points, index, &neighbours_);
  std::vector<std::int32_t> window = {index};
  for (const Map::Neighbour& neighbour : neighbours_) {
    if (static_cast<int>(window.size()) >= options_.mapping.window_size) break;
    if (neighbour.shared_points < kMinSharedInWindow && window.size() > 1) break;
    window.push_back(neighbour.keyframe);
  }
  std::sort(window.begin(), window.end());

  // Points of the window, each once.
  collected_.clear();
  const std::uint32_t mark = map_->next_visit_mark();
  for (const std::int32_t keyframe : window) {
    for (const PointHandle& handle : map_->keyframe(keyframe)->frame.points) {
      MapPoint* point = map_->point(handle);
      if (point == nullptr || point->visit_mark == mark) continue;
      point->visit_mark = mark;
      collected_.push_back(handle);
    }
  }

  // Views: the window, then the outside keyframes that see most of its points, held fixed.
  map_->count_shared(collected_, -1, &neighbours_);
  std::vector<std::int32_t> view_of_keyframe(static_cast<std::size_t>(index) + 1, -1);
  const auto add_view = [&](std::int32_t keyframe, bool fixed) {
    view_of_keyframe[static_cast<std::size_t>(keyframe)] =
        static_cast<std::int32_t>(problem_.views.size());
    problem_.views.push_back({keyframe, map_->keyframe(keyframe)->T_world_camera, fixed});
  };
  for (const std::int32_t keyframe : window) add_view(keyframe, keyframe == 0);
  int num_fixed = 0;
  for (const Map::Neighbour& neighbour : neighbours_) {
    if (num_fixed >= options_.mapping.max_fixed_keyframes) break;
    if (view_of_keyframe[static_cast<std::size_t>(neighbour.keyframe)] >= 0) continue;
    add_view(neighbour.keyframe, true);
    ++num_fixed;
  }
  // Without a fixed view the window could move as a whole: its oldest keyframe holds it.
  if (num_fixed == 0) problem_.views.front().fixed = true;

  for (const PointHandle& handle : collected_) {
    const MapPoint& point = *map_->point(handle);
    const auto landmark = static_cast<std::int32_t>(problem_.landmarks.size());
    bool used = false;
    for (const Observation& observation : point.observations) {
      const std::int32_t view = view_of_keyframe[static_cast<std::size_t>(observation.keyframe)];
      if (view < 0) continue;
      const Keyframe& keyframe = *map_->keyframe(observation.keyframe);
      // The solver cannot start from a point behind a camera; such an observation is wrong.
      if ((keyframe.T_world_camera.inverse() * point.position_m).z() <= 0.0) continue;
      const auto feature = static_cast<std::size_t>(observation.feature);
      BundleProblem::Edge edge;
      edge.view = view;
      edge.landmark = landmark;
      edge.measurement = keyframe.frame.measurements[feature];
      edge.inverse_sigma = 1.0 / double(camera.level_scales[static_cast<std::size_t>(
                                     keyframe.frame.features[feature].octave)]);
      problem_.edges.push_back(edge);
      used = true;
    }
    if (used) problem_.landmarks.push_back({handle, point.position_m});
  }
}

}  // namespace srslam::detail
