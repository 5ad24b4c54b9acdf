#pragma once

#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/evaluation/error_statistics.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam::test {

struct TrajectoryPair {
  Trajectory reference;
  Trajectory estimate;
};

/// A wandering camera at 100 Hz and a noisy estimate of it at about 30 Hz with some frames lost, in
/// a world frame of its own.
inline TrajectoryPair random_trajectory_pair(Rng& rng, int size = 400, double noise_m = 0.02) {
  TrajectoryPair pair;
  const double start_s = kEpoch_s + rng.uniform(0.0, 1000.0);
  Pose T_world_camera = rng.pose(2.0);
  const Pose T_other_world = rng.pose(5.0);
  const Eigen::Vector3d drift = rng.vector3(-0.01, 0.01);
  const bool turns = rng.coin();
  for (int i = 0; i < size; ++i) {
    StampedPose pose;
    pose.timestamp_s = start_s + 0.01 * i;
    pose.T_world_camera = T_world_camera;
    pair.reference.push_back(pose);
    if (i % 3 == 0 && rng.uniform_int(0, 9) != 0) {
      pose.timestamp_s += rng.uniform(-0.004, 0.004);
      Pose noise = Pose::Identity();
      noise.translation() = rng.vector3(-noise_m, noise_m);
      noise.linear() = rng.rotation(0.0, noise_m).toRotationMatrix();
      pose.T_world_camera = T_other_world * T_world_camera * noise;
      pose.T_world_camera.translation() += i * 0.01 * drift;
      pair.estimate.push_back(pose);
    }
    Pose step = Pose::Identity();
    step.translation() = rng.vector3(-0.02, 0.03);
    if (turns) step.linear() = rng.rotation(0.0, 0.05).toRotationMatrix();
    T_world_camera = T_world_camera * step;
    T_world_camera.linear() =
        Eigen::Quaterniond(T_world_camera.linear()).normalized().toRotationMatrix();
  }
  return pair;
}

/// The same motion in a world frame of its own: every pose becomes T * pose.
inline Trajectory moved(const Pose& T, const Trajectory& trajectory) {
  Trajectory result = trajectory;
  for (StampedPose& pose : result) pose.T_world_camera = T * pose.T_world_camera;
  return result;
}

inline void expect_consistent(const ErrorStatistics& statistics) {
  EXPECT_LE(statistics.std, statistics.rmse * (1 + 1e-14));
  EXPECT_LE(statistics.mean, statistics.rmse * (1 + 1e-14));
  EXPECT_NEAR(statistics.rmse * statistics.rmse,
              statistics.mean * statistics.mean + statistics.std * statistics.std,
              1e-13 * statistics.rmse * statistics.rmse);
  EXPECT_LE(statistics.min, statistics.median);
  EXPECT_LE(statistics.median, statistics.max);
  EXPECT_LE(statistics.min, statistics.mean * (1 + 1e-14));
  EXPECT_LE(statistics.mean, statistics.max * (1 + 1e-14));
}

inline void expect_near(const ErrorStatistics& a, const ErrorStatistics& b, double tolerance) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_NEAR(a.rmse, b.rmse, tolerance);
  EXPECT_NEAR(a.mean, b.mean, tolerance);
  EXPECT_NEAR(a.median, b.median, tolerance);
  EXPECT_NEAR(a.std, b.std, tolerance);
  EXPECT_NEAR(a.min, b.min, tolerance);
  EXPECT_NEAR(a.max, b.max, tolerance);
}

}  // namespace srslam::test
