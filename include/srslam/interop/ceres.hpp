#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>
#include <ceres/version.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/pose.hpp"
#include "srslam/core/se3.hpp"

#if CERES_VERSION_MAJOR < 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR < 1)
#error "srslam/interop/ceres.hpp needs Ceres 2.1 or later (ceres::Manifold)"
#endif

namespace srslam {

/// A pose as a Ceres parameter block: translation x y z [m], then quaternion x y z w.
constexpr int kPoseBlockSize = 7;

/// Writes `pose` into the seven doubles of a block.
inline void pose_to_block(const Pose& pose, double* block) {
  Eigen::Map<Eigen::Vector3d> translation(block);
  Eigen::Map<Eigen::Quaterniond> rotation(block + 3);
  translation = pose.translation();
  rotation = Eigen::Quaterniond(pose.linear()).normalized();
}

/// Reads a block; its quaternion need not be of unit norm but must not be zero.
inline Pose pose_from_block(const double* block) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Map<const Eigen::Quaterniond>(block + 3).normalized().toRotationMatrix();
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(block);
  return pose;
}

/// Perturbs a pose block on the camera's side: `T ⊞ ξ = T · exp(ξ)`, ξ = (translation, rotation).
///
/// Cost functions of this header return, in the first six of the seven pose columns, derivatives
/// with respect to ξ, and zero in the last; `PlusJacobian` is the matching [I; 0]. Ceres only ever
/// multiplies the two, so the product is the exact tangent Jacobian and the chain rule through
/// the quaternion is never evaluated. Do not combine this manifold with cost functions that return
/// derivatives by the seven numbers themselves (such as automatic differentiation).
class TangentPoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseBlockSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> tangent(delta);
    pose_to_block(pose_from_block(x) * se3_exp(tangent), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseBlockSize, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 1>> tangent(y_minus_x);
    tangent = se3_log(pose_from_block(x).inverse() * pose_from_block(y));
    return true;
  }
  bool MinusJacobian(const double* /*x*/, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, kPoseBlockSize, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

/// What a rectified RGB-D camera measured of a point: the pixel and the disparity of a virtual
/// stereo baseline, `baseline_fx / z`, in which depth errors are uniform. Standard deviation of
/// all three is `1 / inverse_sigma`.
struct RgbdObservation {
  double u_px = 0.0;
  double v_px = 0.0;
  double disparity_px = -1.0;  ///< <= 0: no depth, the third residual is 0
  double inverse_sigma = 1.0;  ///< [1/px]; 0 switches the observation off
};

/// Pinhole intrinsics of an undistorted image plus virtual baseline times focal length [m px].
struct RgbdIntrinsics {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double baseline_fx_m_px = 0.0;
};

/// Whitened reprojection and disparity error of a world point in a camera.
/// Blocks: `T_world_camera` (7, of unit norm, with TangentPoseManifold) and the point in the world
/// (3) [m]. Evaluation fails for a point that is not in front of the camera.
class RgbdReprojectionCost final : public ceres::SizedCostFunction<3, kPoseBlockSize, 3> {
 public:
  /// Both must outlive the cost; the observation may be changed between solves.
  RgbdReprojectionCost(const RgbdObservation* observation, const RgbdIntrinsics* intrinsics)
      : observation_(observation), intrinsics_(intrinsics) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> t_world_camera(parameters[0]);
    const Eigen::Map<const Eigen::Quaterniond> q_world_camera(parameters[0] + 3);
    const Eigen::Map<const Eigen::Vector3d> point_world(parameters[1]);
    const Eigen::Matrix3d R_camera_world = q_world_camera.toRotationMatrix().transpose();
    const Eigen::Vector3d p = R_camera_world * (point_world - t_world_camera);
    if (!(p.z() > 1e-6)) return false;

    const RgbdIntrinsics& camera = *intrinsics_;
    const double inverse_z = 1.0 / p.z();
    const double x = p.x() * inverse_z;
    const double y = p.y() * inverse_z;
    const double s = observation_->inverse_sigma;
    const bool has_depth = observation_->disparity_px > 0.0;
    residuals[0] = s * (camera.fx_px * x + camera.cx_px - observation_->u_px);
    residuals[1] = s * (camera.fy_px * y + camera.cy_px - observation_->v_px);
    residuals[2] =
        has_depth ? s * (camera.baseline_fx_m_px * inverse_z - observation_->disparity_px) : 0.0;
    if (jacobians == nullptr) return true;

    Eigen::Matrix3d J_camera;  // by the point in the camera's frame
    J_camera << camera.fx_px, 0.0, -camera.fx_px * x, 0.0, camera.fy_px, -camera.fy_px * y, 0.0,
        0.0, has_depth ? -camera.baseline_fx_m_px * inverse_z : 0.0;
    J_camera *= s * inverse_z;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, kPoseBlockSize, Eigen::RowMajor>> J_pose(jacobians[0]);
      J_pose.leftCols<3>() = -J_camera;
      J_pose.middleCols<3>(3) = J_camera * hat(p);
      J_pose.col(6).setZero();
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J_point(jacobians[1]);
      J_point = J_camera * R_camera_world;
    }
    return true;
  }

 private:
  const RgbdObservation* observation_;
  const RgbdIntrinsics* intrinsics_;
};

}  // namespace srslam
