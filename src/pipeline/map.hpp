#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "pipeline/feature_frame.hpp"

namespace srslam::detail {

/// Feature `feature` of keyframe `keyframe` shows a point.
struct Observation {
  std::int32_t keyframe = -1;
  std::int32_t feature = -1;
};

/// A triangulated corner of the world.
struct MapPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();      ///< world
  Eigen::Vector3d mean_direction = Eigen::Vector3d::Zero();  ///< unit, from cameras to the point
  double min_distance_m = 0.0;  ///< range in which the pyramid can show it
  double max_distance_m = 0.0;
  BinaryDescriptor descriptor{};
  std::vector<Observation> observations;  ///< by increasing keyframe
  std::int32_t created_by = -1;           ///< keyframe
  std::int32_t num_visible = 1;           ///< frames in whose view it was predicted ...
  std::int32_t num_found = 1;             ///< ... and in how many it was an inlier
  std::uint32_t generation = 0;
  std::uint32_t visit_mark = 0;  ///< scratch of whoever collects points
  bool alive = false;
};

/// A frame kept in the map. Indices of keyframes count up and are never used again.
struct Keyframe {
  std::int32_t index = -1;
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();
  FeatureFrame frame;
  std::vector<std::uint8_t> thumbnail;  ///< for relocalisation
};

/// Keyframes and points that see each other.
class Map {
 public:
  explicit Map(const TrackingCamera& camera) : camera_(camera) {}

  const TrackingCamera& camera() const { return camera_; }

  /// Living keyframes by increasing index.
  const std::vector<std::int32_t>& keyframe_indices() const { return alive_keyframes_; }
  Keyframe* keyframe(std::int32_t index) {
    return keyframes_[static_cast<std::size_t>(index)].get();
  }
  const Keyframe* keyframe(std::int32_t index) const {
    return keyframes_[static_cast<std::size_t>(index)].get();
  }
  Keyframe* add_keyframe(double timestamp_s, const Pose& T_world_camera, const FeatureFrame& frame);
  /// Its points lose their observations; points left without any leave the map.
  void remove_keyframe(std::int32_t index);
  /// Pose of any keyframe that ever was, carried along with the living one that replaced it.
  Pose T_world_keyframe(std::int32_t index) const;
  /// Nearest living stand-in of a keyframe, itself while it lives.
  std::int32_t living_keyframe(std::int32_t index) const;

  std::size_t num_points() const { return num_points_; }
  /// nullptr when the point has left the map.
  MapPoint* point(const PointHandle& handle) {
    if (!handle.assigned()) return nullptr;
    MapPoint& point = points_[static_cast<std::size_t>(handle.slot)];
    return point.alive && point.generation == handle.generation ? &point : nullptr;
  }
  const MapPoint* point(const PointHandle& handle) const {
    return const_cast<Map*>(this)->point(handle);
  }
  PointHandle add_point(const Eigen::Vector3d& position_m, std::int32_t created_by);
  void remove_point(const PointHandle& handle);
  /// Joins two points that turned out to be one: `keep` takes over the observations of `drop` in
  /// keyframes that do not see it yet.
  void merge_points(const PointHandle& keep, const PointHandle& drop);

  void add_observation(const PointHandle& handle, std::int32_t keyframe, std::int32_t feature);
  /// Removes the point when too few observations are left.
  void remove_observation(const PointHandle& handle, std::int32_t keyframe);
  /// Feature of `keyframe` that shows the point, -1 when none does.
  std::int32_t observing_feature(const MapPoint& point, std::int32_t keyframe) const;
  /// Views that constrain the point: an observation with depth is worth two without.
  int observation_score(const MapPoint& point) const;

  /// Recomputes viewing direction, distance range and descriptor from the observations.
  void refresh_point(const PointHandle& handle);
  /// The part of refresh_point() that depends on poses.
  void refresh_point_geometry(MapPoint* point) const;

  /// Pyramid level at which the point should appear from `distance_m`.
  int predicted_octave(const MapPoint& point, double distance_m) const;

  struct Neighbour {
    std::int32_t keyframe = -1;
    int shared_points = 0;
  };
  /// Keyframes that share points with `points` (those in `exclude` aside), most shared first, then
  /// newest first.
  void count_shared(const std::vector<PointHandle>& points, std::int32_t exclude,
                    std::vector<Neighbour>* neighbours);

  /// A number that no point's visit_mark has yet.
  std::uint32_t next_visit_mark() { return ++visit_mark_; }

 private:
  struct Stand {
    std::int32_t parent = -1;  ///< keyframe that stands in for a removed one
    Pose T_parent_self = Pose::Identity();
  };

  TrackingCamera camera_;
  std::vector<std::unique_ptr<Keyframe>> keyframes_;  ///< by index; empty when removed
  std::vector<Stand> stands_;                         ///< by index
  std::vector<std::int32_t> alive_keyframes_;
  std::vector<MapPoint> points_;
  std::vector<std::int32_t> free_points_;
  std::size_t num_points_ = 0;
  std::uint32_t visit_mark_ = 0;
  std::vector<int> shared_count_;  ///< scratch, by keyframe index
};

}  // namespace srslam::detail
