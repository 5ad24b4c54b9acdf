#pragma once

#include "srslam/core/pose.hpp"
#include "srslam/evaluation/trajectory.hpp"

namespace srslam {

/// Pose of the camera from a pose of the BONN dataset's ground truth, which is that of the marker
/// body. Without this the axes are not the camera's and relative pose errors mean nothing; the
/// absolute error after a rigid alignment does not need it.
Pose camera_pose_from_bonn_marker(const Pose& T_recorded);

/// The same for every pose of a trajectory.
Trajectory camera_trajectory_from_bonn_marker(const Trajectory& recorded);

}  // namespace srslam
