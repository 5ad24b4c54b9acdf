#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Pose of the camera at one time. `T_world_camera` maps camera coordinates (x right, y down,
/// z forward, metres) into the world frame.
struct StampedPose {
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();
};

/// Poses in strictly increasing order of time.
using Trajectory = std::vector<StampedPose>;

/// Which trajectory a reason speaks of.
enum class TrajectoryRole : std::uint8_t { kUnnamed, kReference, kEstimate };

/// What check_trajectory() found.
struct TrajectoryCheck {
  Status status;
  std::size_t pose_index = 0;  ///< the first pose that is wrong, when the status is not ok
};

/// Whether a trajectory is what the evaluation may be given: finite time stamps that increase
/// strictly, finite positions, and rotations that are orthonormal with determinant +1 (each entry
/// of RᵀR within 1e-6 of the identity's, which a normalised quaternion meets by far). `role` only
/// puts a name into the reason.
///
/// An empty trajectory passes. Fails with kInvalidArgument. Linear time, no allocation.
inline TrajectoryCheck check_trajectory(const Trajectory& trajectory,
                                        TrajectoryRole role = TrajectoryRole::kUnnamed) noexcept {
  constexpr double kOrthonormalTolerance = 1e-6;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const StampedPose& pose = trajectory[i];
    const auto failure = [i, role](const char* unnamed, const char* reference,
                                   const char* estimate) {
      const char* reason = role == TrajectoryRole::kReference  ? reference
                           : role == TrajectoryRole::kEstimate ? estimate
                                                               : unnamed;
      return TrajectoryCheck{Status::failure(StatusCode::kInvalidArgument, reason), i};
    };
    if (!std::isfinite(pose.timestamp_s)) {
      return failure("a time stamp is not finite", "reference: a time stamp is not finite",
                     "estimate: a time stamp is not finite");
    }
    if (i > 0 && pose.timestamp_s == trajectory[i - 1].timestamp_s) {
      return failure("a time stamp occurs twice; they must increase strictly",
                     "reference: a time stamp occurs twice; they must increase strictly",
                     "estimate: a time stamp occurs twice; they must increase strictly");
    }
    if (i > 0 && pose.timestamp_s < trajectory[i - 1].timestamp_s) {
      return failure("time stamps are not sorted; they must increase strictly",
                     "reference: time stamps are not sorted; they must increase strictly",
                     "estimate: time stamps are not sorted; they must increase strictly");
    }
    const Eigen::Matrix3d rotation = pose.T_world_camera.linear();
    const Eigen::Vector3d position = pose.T_world_camera.translation();
    if (!position.allFinite() || !rotation.allFinite()) {
      return failure("a pose is not finite", "reference: a pose is not finite",
                     "estimate: a pose is not finite");
    }
    const Eigen::Matrix3d gram = rotation.transpose() * rotation;
    const double deviation = (gram - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(deviation <= kOrthonormalTolerance) || !(rotation.determinant() > 0.0)) {
      return failure("a rotation is not orthonormal with determinant +1",
                     "reference: a rotation is not orthonormal with determinant +1",
                     "estimate: a rotation is not orthonormal with determinant +1");
    }
  }
  return TrajectoryCheck{Status::success(), 0};
}

}  // namespace srslam
