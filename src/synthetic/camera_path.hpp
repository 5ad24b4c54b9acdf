#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "srslam/core/pose.hpp"
#include "synthetic/random.hpp"
#include "synthetic/smooth_signal.hpp"

namespace srslam::detail {

/// Camera pose at `position_m` that looks at `target_m`, upright but for `roll_rad` about the
/// optical axis (world z up).
Pose look_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m,
             double roll_rad = 0.0);

/// A path with the tremor of the hand that holds the camera.
class CameraPath {
 public:
  /// How much a hand trembles: RMS per axis.
  struct Tremor {
    double position_m = 0.0;
    double rotation_rad = 0.0;
  };
  CameraPath() = default;
  CameraPath(std::function<Pose(double time_s)> path, const Tremor& tremor, std::uint64_t seed);

  Pose T_world_camera(double time_s) const;

 private:
  std::function<Pose(double)> path_;
  bool trembles_ = false;
  SmoothSignal position_[3];
  SmoothSignal rotation_[3];
};

}  // namespace srslam::detail
