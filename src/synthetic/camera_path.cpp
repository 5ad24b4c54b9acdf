#include "synthetic/camera_path.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "srslam/core/se3.hpp"

namespace srslam::detail {

Pose look_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m, double roll_rad) {
  const Eigen::Vector3d forward = (target_m - position_m).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose pose = Pose::Identity();
  pose.translation() = position_m;
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.linear() =
      pose.linear() * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

CameraPath::CameraPath(std::function<Pose(double time_s)> path, const Tremor& tremor,
                       std::uint64_t seed)
    : path_(std::move(path)), trembles_(tremor.position_m > 0.0 || tremor.rotation_rad > 0.0) {
  if (!trembles_) return;
  // Hands tremble up to some 8 Hz, slowly most of all.
  RandomStream random(seed, 61);
  for (SmoothSignal& signal : position_) {
    signal = SmoothSignal(&random, tremor.position_m, 0.3, 6.0);
  }
  for (SmoothSignal& signal : rotation_) {
    signal = SmoothSignal(&random, tremor.rotation_rad, 0.4, 8.0);
  }
}

Pose CameraPath::T_world_camera(double time_s) const {
  Pose pose = path_(time_s);
  if (!trembles_) return pose;
  Vector6 tangent;
  for (int axis = 0; axis < 3; ++axis) {
    tangent[axis] = position_[axis](time_s);
    tangent[3 + axis] = rotation_[axis](time_s);
  }
  return pose * se3_exp(tangent);
}

}  // namespace srslam::detail
