#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace srslam {

/// Rigid motion. `T_a_b` maps points of frame b into frame a: `p_a = T_a_b * p_b`. Trajectories
/// hold `T_world_camera`. Unaligned, so that its layout is the same under every `-m` flag and it
/// may cross a compiled boundary; converts implicitly from and to `Eigen::Isometry3d`.
using Pose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

/// Tangent vector or other 6-vector, order: translation (3), rotation (3).
using Vector6 = Eigen::Matrix<double, 6, 1, Eigen::DontAlign>;
/// 6×6 covariance, information or adjoint matrix in the same order, column-major.
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;

}  // namespace srslam
