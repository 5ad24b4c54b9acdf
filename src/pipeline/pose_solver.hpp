#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/feature_frame.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"

namespace srslam::detail {

/// 95 % quantiles of χ² for two and three degrees of freedom: gates on squared, whitened residuals.
constexpr double kChi2Pixel = 5.991;
constexpr double kChi2PixelDepth = 7.815;

/// A point of known position and what the camera measured of it.
struct PoseObservation {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< world
  Measurement measurement;
  double inverse_sigma = 1.0;  ///< 1 / standard deviation of the pixel [1/px]
  bool inlier = true;          ///< result: passed the χ² gate at the last round
};

struct PoseSolution {
  Status status;
  Pose T_world_camera = Pose::Identity();
  Matrix6 information = Matrix6::Zero();  ///< of a perturbation on the camera's side, inliers only
  int num_inliers = 0;
};

/// Pose that minimises the Huber cost of reprojection and disparity errors, points fixed:
/// Gauss-Newton rounds between which observations beyond the χ² gate are set aside and may come
/// back. `observations[i].inlier` says how each ended. kInsufficientData below three usable
/// observations, kDegenerate when the normal equations are singular. Allocates nothing.
PoseSolution solve_pose(const TrackingCamera& camera, const Pose& T_world_camera_guess,
                        std::vector<PoseObservation>* observations);

}  // namespace srslam::detail
