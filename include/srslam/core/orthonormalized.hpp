#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "srslam/core/pose.hpp"

namespace srslam {

/// `T` with its 3×3 part replaced by the nearest proper rotation (Frobenius norm); translation
/// unchanged. Removes the drift of long products. A matrix that is not finite is returned as it is.
inline Pose orthonormalized(const Pose& T) {
  const Eigen::Matrix3d linear = T.linear();
  if (!linear.allFinite()) return T;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  // The nearest orthogonal matrix may be a reflection; turning the direction of least singular
  // value around gives the nearest rotation.
  if (u.determinant() * svd.matrixV().determinant() < 0.0) u.col(2) = -u.col(2);
  const Eigen::Matrix3d rotation = u * svd.matrixV().transpose();
  Pose result = T;
  // One Newton step of the polar decomposition takes out the rounding of the one above.
  result.linear() = 1.5 * rotation - 0.5 * rotation * (rotation.transpose() * rotation);
  return result;
}

}  // namespace srslam
