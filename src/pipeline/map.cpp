#include "pipeline/map.hpp"

#include <algorithm>
#include <cmath>

namespace srslam::detail {
namespace {

// Descriptors compared when a point's most typical one is chosen; more change little and the cost
// is quadratic.
constexpr std::size_t kMaxDescriptorsCompared = 16;

}  // namespace

Keyframe* Map::add_keyframe(double timestamp_s, const Pose& T_world_camera,
                            const FeatureFrame& frame) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->index = static_cast<std::int32_t>(keyframes_.size());
  keyframe->timestamp_s = timestamp_s;
  keyframe->T_world_camera = T_world_camera;
  keyframe->frame = frame;
  keyframe->frame.points.assign(frame.size(), PointHandle{});
  alive_keyframes_.push_back(keyframe->index);
  keyframes_.push_back(std::move(keyframe));
  stands_.push_back({});
  shared_count_.push_back(0);
  return keyframes_.back().get();
}

void Map::remove_keyframe(std::int32_t index) {
  Keyframe& keyframe = *keyframes_[static_cast<std::size_t>(index)];
  std::vector<Neighbour> neighbours;
  count_shared(keyframe.frame.points, index, &neighbours);
  std::int32_t parent = neighbours.empty() ? -1 : neighbours.front().keyframe;
  if (parent < 0) {
    // Nothing shared: the nearest in time still moves with the same part of the map.
    for (const std::int32_t other : alive_keyframes_) {
      if (other != index && (parent < 0 || std::abs(other - index) < std::abs(parent - index))) {
        parent = other;
      }
    }
  }
  const std::vector<PointHandle> handles = keyframe.frame.points;
  for (const PointHandle& handle : handles) {
    if (point(handle) != nullptr) remove_observation(handle, index);
  }
  Stand& stand = stands_[static_cast<std::size_t>(index)];
  stand.parent = parent;
  stand.T_parent_self = keyframes_[static_cast<std::size_t>(parent)]->T_world_camera.inverse() *
                        keyframe.T_world_camera;
  keyframes_[static_cast<std::size_t>(index)].reset();
  alive_keyframes_.erase(std::find(alive_keyframes_.begin(), alive_keyframes_.end(), index));
}

Pose Map::T_world_keyframe(std::int32_t index) const {
  Pose T_stand_self = Pose::Identity();
  while (keyframes_[static_cast<std::size_t>(index)] == nullptr) {
    const Stand& stand = stands_[static_cast<std::size_t>(index)];
    T_stand_self = stand.T_parent_self * T_stand_self;
    index = stand.parent;
  }
  return keyframes_[static_cast<std::size_t>(index)]->T_world_camera * T_stand_self;
}

std::int32_t Map::living_keyframe(std::int32_t index) const {
  while (keyframes_[static_cast<std::size_t>(index)] == nullptr) {
    index = stands_[static_cast<std::size_t>(index)].parent;
  }
  return index;
}

PointHandle Map::add_point(const Eigen::Vector3d& position_m, std::int32_t created_by) {
  if (free_points_.empty()) {
    free_points_.push_back(static_cast<std::int32_t>(points_.size()));
    points_.emplace_back();
  }
  const std::int32_t slot = free_points_.back();
  free_points_.pop_back();
  MapPoint& point = points_[static_cast<std::size_t>(slot)];
  const std::uint32_t generation = point.generation + 1;
  point.observations.clear();
  point.position_m = position_m;
  point.created_by = created_by;
  point.num_visible = 1;
  point.num_found = 1;
  point.generation = generation;
  point.visit_mark = 0;
  point.alive = true;
  ++num_points_;
  return {slot, generation};
}

void Map::remove_point(const PointHandle& handle) {
  MapPoint* removed = point(handle);
  if (removed == nullptr) return;
  for (const Observation& observation : removed->observations) {
    keyframe(observation.keyframe)->frame.points[static_cast<std::size_t>(observation.feature)] =
        PointHandle{};
  }
  removed->observations.clear();
  removed->alive = false;
  free_points_.push_back(handle.slot);
  --num_points_;
}

void Map::merge_points(const PointHandle& keep, const PointHandle& drop) {
  MapPoint* kept = point(keep);
  MapPoint* dropped = point(drop);
  if (kept == nullptr || dropped == nullptr || keep == drop) return;
  const std::vector<Observation> moved = dropped->observations;
  kept->num_visible += dropped->num_visible;
  kept->num_found += dropped->num_found;
  remove_point(drop);
  for (const Observation& observation : moved) {
    if (observing_feature(*kept, observation.keyframe) < 0) {
      add_observation(keep, observation.keyframe, observation.feature);
    }
  }
}

void Map::add_observation(const PointHandle& handle, std::int32_t keyframe_index,
                          std::int32_t feature) {
  MapPoint* seen = point(handle);
  const Observation observation{keyframe_index, feature};
  const auto position = std::lower_bound(
      seen->observations.begin(), seen->observations.end(), observation,
      [](const Observation& a, const Observation& b) { return a.keyframe < b.keyframe; });
  seen->observations.insert(position, observation);
  keyframe(keyframe_index)->frame.points[static_cast<std::size_t>(feature)] = handle;
}

void Map::remove_observation(const PointHandle& handle, std::int32_t keyframe_index) {
  MapPoint* seen = point(handle);
  if (seen == nullptr) return;
  for (auto it = seen->observations.begin(); it != seen->observations.end(); ++it) {
    if (it->keyframe != keyframe_index) continue;
    keyframe(keyframe_index)->frame.points[static_cast<std::size_t>(it->feature)] = PointHandle{};
    seen->observations.erase(it);
    break;
  }
  if (seen->observations.empty()) remove_point(handle);
}

std::int32_t Map::observing_feature(const MapPoint& seen, std::int32_t keyframe_index) const {
  for (const Observation& observation : seen.observations) {
    if (observation.keyframe == keyframe_index) return observation.feature;
  }
  return -1;
}

int Map::observation_score(const MapPoint& seen) const {
  int score = 0;
  for (const Observation& observation : seen.observations) {
    const FeatureFrame& frame = keyframe(observation.keyframe)->frame;
    score += frame.measurements[static_cast<std::size_t>(observation.feature)].has_depth() ? 2 : 1;
  }
  return score;
}

void Map::refresh_point_geometry(MapPoint* refreshed) const {
  if (refreshed->observations.empty()) return;
  Eigen::Vector3d direction_sum = Eigen::Vector3d::Zero();
  for (const Observation& observation : refreshed->observations) {
    const Eigen::Vector3d ray =
        refreshed->position_m - keyframe(observation.keyframe)->T_world_camera.translation();
    direction_sum += ray.normalized();
  }
  refreshed->mean_direction = direction_sum.normalized();
  // The newest observation gives the scale: it is the one that tracking will compare with.
  const Observation& newest = refreshed->observations.back();
  const Keyframe& observer = *keyframe(newest.keyframe);
  const double distance_m = (refreshed->position_m - observer.T_world_camera.translation()).norm();
  const auto octave = static_cast<std::size_t>(
      observer.frame.features[static_cast<std::size_t>(newest.feature)].octave);
  refreshed->max_distance_m = distance_m * double(camera_.level_scales[octave]);
  refreshed->min_distance_m = refreshed->max_distance_m / double(camera_.level_scales.back());
}

void Map::refresh_point(const PointHandle& handle) {
  MapPoint* refreshed = point(handle);
  if (refreshed == nullptr) return;
  refresh_point_geometry(refreshed);
  // The descriptor with the least median distance to the others stands for the point.
  const std::size_t count = std::min(refreshed->observations.size(), kMaxDescriptorsCompared);
  const std::size_t first = refreshed->observations.size() - count;
  const auto descriptor = [&](std::size_t i) -> const BinaryDescriptor& {
    const Observation& observation = refreshed->observations[first + i];
    return keyframe(observation.keyframe)
        ->frame.descriptors[static_cast<std::size_t>(observation.feature)];
  };
  int best_median = 257;
  std::size_t best = 0;
  std::array<int, kMaxDescriptorsCompared> distances{};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      distances[j] = hamming_distance(descriptor(i), descriptor(j));
    }
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>((count - 1) / 2);
    std::nth_element(distances.begin(), middle,
                     distances.begin() + static_cast<std::ptrdiff_t>(count));
    if (*middle < best_median) {
      best_median = *middle;
      best = i;
    }
  }
  refreshed->descriptor = descriptor(best);
}

int Map::predicted_octave(const MapPoint& seen, double distance_m) const {
  const double ratio = seen.max_distance_m / distance_m;
  const int octave = static_cast<int>(std::ceil(std::log(ratio) / camera_.log_scale_factor));
  return std::clamp(octave, 0, static_cast<int>(camera_.level_scales.size()) - 1);
}

void Map::count_shared(const std::vector<PointHandle>& points, std::int32_t exclude,
                       std::vector<Neighbour>* neighbours) {
  neighbours->clear();
  std::fill(shared_count_.begin(), shared_count_.end(), 0);
  for (const PointHandle& handle : points) {
    const MapPoint* seen = point(handle);
    if (seen == nullptr) continue;
    for (const Observation& observation : seen->observations) {
      ++shared_count_[static_cast<std::size_t>(observation.keyframe)];
    }
  }
  for (const std::int32_t index : alive_keyframes_) {
    const int shared = shared_count_[static_cast<std::size_t>(index)];
    if (shared > 0 && index != exclude) neighbours->push_back({index, shared});
  }
  std::sort(neighbours->begin(), neighbours->end(), [](const Neighbour& a, const Neighbour& b) {
    return a.shared_points != b.shared_points ? a.shared_points > b.shared_points
                                              : a.keyframe > b.keyframe;
  });
}

}  // namespace srslam::detail
