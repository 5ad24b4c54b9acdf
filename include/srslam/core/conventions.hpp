#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/pose.hpp"
#include "srslam/core/se3.hpp"

// Converters between this library's conventions and those of others; docs/conventions.md has the
// table. None of them includes a foreign header. All are constant time and allocate nothing.

namespace srslam {

/// Coefficients in the order x, y, z, w: TUM trajectory files, ROS, g2o files, Eigen's memory and
/// `ceres::EigenQuaternionManifold`.
inline std::array<double, 4> quaternion_to_xyzw(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
inline Eigen::Quaterniond quaternion_from_xyzw(const std::array<double, 4>& xyzw) {
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

/// Coefficients in the order w, x, y, z: `ceres::QuaternionManifold`, ceres/rotation.h and the
/// constructors of Eigen and of GTSAM's `Rot3::Quaternion`.
inline std::array<double, 4> quaternion_to_wxyz(const Eigen::Quaterniond& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}
inline Eigen::Quaterniond quaternion_from_wxyz(const std::array<double, 4>& wxyz) {
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

/// Tangent vector with the rotation first, as in GTSAM's `Pose3` and g2o's `VertexSE3Expmap`. The
/// frame it is expressed in stays the same.
inline Vector6 tangent_to_rotation_first(const Vector6& tangent) {
  Vector6 swapped;
  swapped << tangent.tail<3>(), tangent.head<3>();
  return swapped;
}
inline Vector6 tangent_from_rotation_first(const Vector6& tangent) {
  return tangent_to_rotation_first(tangent);
}

/// Covariance or information matrix with the rotation first, as in GTSAM's noise models for `Pose3`
/// and in g2o's `VertexSE3Expmap` and `EdgeSE3Expmap`.
inline Matrix6 matrix_to_rotation_first(const Matrix6& matrix) {
  Matrix6 swapped;
  swapped << matrix.bottomRightCorner<3, 3>(), matrix.bottomLeftCorner<3, 3>(),
      matrix.topRightCorner<3, 3>(), matrix.topLeftCorner<3, 3>();
  return swapped;
}
inline Matrix6 matrix_from_rotation_first(const Matrix6& matrix) {
  return matrix_to_rotation_first(matrix);
}

/// Information matrix for g2o's `EdgeSE3` and its `EDGE_SE3:QUAT` lines, whose error is translation
/// and vector part of the unit quaternion. The latter is half of the rotation vector to first
/// order, so that a unit of it weighs twice as much.
inline Matrix6 information_to_g2o_edge_se3(const Matrix6& information) {
  Matrix6 scaled = information;
  scaled.rightCols<3>() *= 2.0;
  scaled.bottomRows<3>() *= 2.0;
  return scaled;
}
inline Matrix6 information_from_g2o_edge_se3(const Matrix6& information) {
  Matrix6 scaled = information;
  scaled.rightCols<3>() *= 0.5;
  scaled.bottomRows<3>() *= 0.5;
  return scaled;
}

/// Covariance of `T_a_b` with the error expressed in frame a (T = exp(xi_a) T_a_b) from that with
/// the error in frame b (T = T_a_b exp(xi_b)). Exactly symmetric if the input is.
inline Matrix6 covariance_in_frame_a(const Pose& T_a_b, const Matrix6& covariance_b) {
  const Matrix6 adjoint = se3_adjoint(T_a_b);
  const Matrix6 result = adjoint * covariance_b * adjoint.transpose();
  return 0.5 * (result + result.transpose());
}

/// The same for an information matrix.
inline Matrix6 information_in_frame_a(const Pose& T_a_b, const Matrix6& information_b) {
  const Matrix6 inverse_adjoint = se3_adjoint(T_a_b.inverse());
  const Matrix6 result = inverse_adjoint.transpose() * information_b * inverse_adjoint;
  return 0.5 * (result + result.transpose());
}

}  // namespace srslam
