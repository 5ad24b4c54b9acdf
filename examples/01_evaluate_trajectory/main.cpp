// Absolute and relative error of an estimated trajectory, with Eigen as the only dependency.

#include <cmath>
#include <cstdio>

#include "srslam/evaluation/trajectory_error.hpp"

namespace {

/// A camera that flies along a helix of radius 1 m, one pose every 0.1 s, always looking ahead.
srslam::Trajectory make_reference() {
  srslam::Trajectory trajectory;
  for (int i = 0; i < 60; ++i) {
    const double angle_rad = 0.1 * i;
    srslam::StampedPose pose;
    pose.timestamp_s = 0.1 * i;
    pose.T_world_camera.translation() << std::cos(angle_rad), std::sin(angle_rad), 0.02 * i;
    pose.T_world_camera.linear() =
        Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    trajectory.push_back(pose);
  }
  return trajectory;
}

/// The same flight as a SLAM system might report it: in a world frame of its own, with a clock that
/// runs 4 ms late, and 3 cm too far out in every second pose.
srslam::Trajectory make_estimate(const srslam::Trajectory& reference) {
  srslam::Pose T_estimate_reference = srslam::Pose::Identity();
  T_estimate_reference.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  T_estimate_reference.translation() << 5.0, -2.0, 1.0;

  srslam::Trajectory trajectory;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    srslam::StampedPose pose = reference[i];
    pose.timestamp_s += 0.004;
    if (i % 2 == 1) pose.T_world_camera.translation().head<2>() *= 1.03;
    pose.T_world_camera = T_estimate_reference * pose.T_world_camera;
    trajectory.push_back(pose);
  }
  return trajectory;
}

}  // namespace

int main() {
  const srslam::Trajectory reference = make_reference();
  const srslam::Trajectory estimate = make_estimate(reference);

  const srslam::AteResult ate = srslam::absolute_trajectory_error(reference, estimate);
  if (!ate.status.ok()) {
    std::printf("no absolute error: %s\n", ate.status.reason);
    return 1;
  }
  std::printf("matched %zu of %zu poses, largest time difference %.1f ms\n", ate.num_matched,
              ate.num_estimate, 1e3 * ate.max_abs_time_difference_s);
  std::printf("ATE after %s alignment: rmse %.2f cm, largest %.2f cm\n",
              srslam::to_string(ate.alignment), 1e2 * ate.translation_m.rmse,
              1e2 * ate.translation_m.max);

  srslam::RpeOptions per_second;
  per_second.unit = srslam::RpeDelta::kSeconds;
  per_second.relative_delta_tolerance = 0.05;  // at 10 Hz: no pair of 0.9 s or 1.1 s
  const srslam::RpeResult rpe = srslam::relative_pose_error(reference, estimate, per_second);
  if (!rpe.status.ok()) {
    std::printf("no relative error: %s\n", rpe.status.reason);
    return 1;
  }
  std::printf("RPE over 1 s: rmse %.2f cm and %.2f deg over %zu pairs\n",
              1e2 * rpe.translation_m.rmse, rpe.rotation_deg.rmse, rpe.num_pairs);

  // Half of the poses are 3 cm too far out, and a rigid alignment cannot shrink a circle: the rmse
  // is close to 3 cm / sqrt(2). Poses 1 s apart are ten apart, so both are right or both are wrong,
  // and then the chord of 1 rad between them, 2 sin(0.5) long, is 3 % too long. No rotation is
  // wrong.
  const bool right = ate.num_matched == 60 && std::abs(ate.translation_m.rmse - 0.0212) < 5e-4 &&
                     std::abs(rpe.translation_m.max - 0.06 * std::sin(0.5)) < 1e-9 &&
                     rpe.rotation_deg.max < 1e-5;
  std::printf("%s\n", right ? "as expected" : "NOT as expected");
  return right ? 0 : 1;
}
