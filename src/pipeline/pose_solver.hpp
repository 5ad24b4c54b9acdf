#pragma once

#include <Eigen/Core>
#include <cstddef>
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

/// Feature `feature` of `frame` as an observation of the point at `position_m` (world).
inline PoseObservation make_pose_observation(const TrackingCamera& camera,
                                             const FeatureFrame& frame, std::size_t feature,
                                             const Eigen::Vector3d& position_m) {
  PoseObservation observation;
  observation.position_m = position_m;
  observation.measurement = frame.measurements[feature];
  const auto octave = static_cast<std::size_t>(frame.features[feature].octave);
  observation.inverse_sigma = 1.0 / double(camera.level_scales[octave]);
  return observation;
}

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
