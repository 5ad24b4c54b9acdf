#include "srslam/io/bonn_groundtruth.hpp"

#include <Eigen/SVD>

namespace srslam {
namespace {

/// The axes of the motion capture system against those of ROS.
Pose bonn_ros_axes() {
  Pose T = Pose::Identity();
  T.linear() << -1.0, 0.0, 0.0,  //
      0.0, 0.0, 1.0,             //
      0.0, 1.0, 0.0;
  return T;
}

/// The dataset's calibrated transform between marker body and camera. Its published rotation is a
/// rotation only to about 0.05; the nearest one in the Frobenius norm is used (U Vᵀ of its SVD,
/// whose determinant is positive here).
Pose bonn_marker_calibration() {
  Eigen::Matrix3d published;
  published << 1.0157, 0.1828, -0.2389,  //
      0.0009, -0.8431, -0.6413,          //
      -0.3009, 0.6147, -0.8085;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(published, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Pose T = Pose::Identity();
  T.linear() = svd.matrixU() * svd.matrixV().transpose();
  T.translation() << 0.0113, -0.0098, 0.0111;
  return T;
}

}  // namespace

Pose camera_pose_from_bonn_marker(const Pose& T_recorded) {
  const Pose axes = bonn_ros_axes();
  return axes * T_recorded * axes * bonn_marker_calibration();
}

Trajectory camera_trajectory_from_bonn_marker(const Trajectory& recorded) {
  const Pose axes = bonn_ros_axes();
  const Pose right = axes * bonn_marker_calibration();
  Trajectory converted = recorded;
  for (StampedPose& pose : converted) {
    pose.T_world_camera = axes * pose.T_world_camera * right;
  }
  return converted;
}

}  // namespace srslam
