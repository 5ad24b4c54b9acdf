#include <cmath>
#include <cstdio>

#include "srslam/evaluation/trajectory_error.hpp"

// The estimate is twice as large as the reference: Sim(3) finds the scale, SE(3) cannot.
int main() {
  srslam::Trajectory reference;
  srslam::Trajectory estimate;
  for (int i = 0; i < 8; ++i) {
    srslam::StampedPose pose;
    pose.timestamp_s = 0.1 * i;
    pose.T_world_camera.translation() << std::cos(i), std::sin(i), 0.1 * i;
    reference.push_back(pose);
    pose.T_world_camera.translation() *= 2.0;
    estimate.push_back(pose);
  }
  srslam::AteOptions options;
  const double rigid =
      srslam::absolute_trajectory_error(reference, estimate, options).translation_m.rmse;
  options.alignment = srslam::Alignment::kSim3;
  const srslam::AteResult similar = srslam::absolute_trajectory_error(reference, estimate, options);
  std::printf("rmse: SE(3) %g m, Sim(3) %g m at scale %g\n", rigid, similar.translation_m.rmse,
              similar.scale);
  const bool right = similar.status.ok() && similar.translation_m.rmse < 1e-9 &&
                     std::abs(similar.scale - 0.5) < 1e-9 && rigid > 0.1;
  return right ? 0 : 1;
}
