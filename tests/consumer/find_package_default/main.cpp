#include <srslam/srslam.hpp>

#include <cstdio>

int main() {
  srslam::Pose T_world_camera = srslam::Pose::Identity();
  T_world_camera.translation() << 1.0, 2.0, 3.0;
  srslam::PinholeCamera camera;
  const srslam::Status status = camera.validate();
  std::printf("a camera without intrinsics: %s\n", status.reason);
  const srslam::AteResult result = srslam::absolute_trajectory_error({}, {});
  std::printf("no trajectory: %s\n", result.status.reason);
  const double distance = (T_world_camera.inverse() * T_world_camera.translation()).norm();
  return !status.ok() && !result.status.ok() && distance < 1e-12 ? 0 : 1;
}
