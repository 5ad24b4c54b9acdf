#pragma once

#include <Eigen/Core>
#include <vector>

namespace srslam::detail {

struct Waypoint {
  double time_s = 0.0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

/// A walk over the floor: straight between waypoints, corners and starts rounded off. Before the
/// first and after the last waypoint it stands still.
class GroundPath {
 public:
  struct State {
    Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
    double yaw_rad = 0.0;   ///< heading; 0 along +x, counted towards +y
    double walked_m = 0.0;  ///< length of the way so far
    double speed_m_per_s = 0.0;
  };

  GroundPath() = default;
  /// `waypoints` in increasing order of time, at least one. `yaw_at_rest_rad` is the heading before
  /// the first step.
  GroundPath(const std::vector<Waypoint>& waypoints, double yaw_at_rest_rad);

  State at(double time_s) const;

 private:
  double begin_s_ = 0.0;
  std::vector<State> samples_;
};

/// A value that changes smoothly from each given time to the next and is constant outside.
class Timeline {
 public:
  struct Key {
    double time_s;
    double value;
  };
  Timeline() = default;
  Timeline(std::initializer_list<Key> keys) : keys_(keys) {}
  explicit Timeline(std::vector<Key> keys) : keys_(std::move(keys)) {}
  double operator()(double time_s) const;

 private:
  std::vector<Key> keys_;
};

}  // namespace srslam::detail
