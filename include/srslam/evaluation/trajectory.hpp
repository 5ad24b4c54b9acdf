#pragma once

#include <vector>

#include "srslam/core/pose.hpp"

namespace srslam {

/// Pose of the camera at one time. `T_world_camera` maps camera coordinates (x right, y down,
/// z forward, metres) into the world frame.
struct StampedPose {
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();
};

/// Poses in strictly increasing order of time.
using Trajectory = std::vector<StampedPose>;

}  // namespace srslam
