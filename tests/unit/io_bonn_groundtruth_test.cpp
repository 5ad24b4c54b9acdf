#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>

#include "srslam/io/bonn_groundtruth.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

Pose marker_calibration() {
  // With the identity recorded, T_ros² = I leaves the calibration alone.
  return camera_pose_from_bonn_marker(Pose::Identity());
}

TEST(BonnGroundtruth, CalibrationIsTheNearestRotationToThePublishedMatrix) {
  Eigen::Matrix3d published;
  published << 1.0157, 0.1828, -0.2389, 0.0009, -0.8431, -0.6413, -0.3009, 0.6147, -0.8085;
  const Pose T = marker_calibration();
  const Eigen::Matrix3d R = T.linear();
  EXPECT_NEAR((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-14);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  EXPECT_EQ(T.translation(), Eigen::Vector3d(0.0113, -0.0098, 0.0111));
  // Optimality: Rᵀ M of the nearest rotation is symmetric, and no other rotation is nearer.
  const Eigen::Matrix3d S = R.transpose() * published;
  EXPECT_NEAR((S - S.transpose()).norm(), 0.0, 1e-13);
  const double distance = (R - published).norm();
  test::for_each_seed(200, [&](test::Rng& rng) {
    const Eigen::Matrix3d other = R * rng.rotation(1e-4, 3.0).toRotationMatrix();
    EXPECT_GT((other - published).norm(), distance);
  });
}

TEST(BonnGroundtruth, MotionIsCarriedOver) {
  // A pure translation of the recorded frame is turned by the axes of ROS: x -> -x, y -> z, z -> y.
  Pose T = Pose::Identity();
  T.translation() << 1.0, 2.0, 3.0;
  const Eigen::Vector3d moved = camera_pose_from_bonn_marker(T).translation() -
                                camera_pose_from_bonn_marker(Pose::Identity()).translation();
  EXPECT_NEAR((moved - Eigen::Vector3d(-1.0, 3.0, 2.0)).norm(), 0.0, 1e-15);
}

TEST(BonnGroundtruth, WholeTrajectoriesAreConvertedAlike) {
  test::for_each_seed(20, [](test::Rng& rng) {
    Trajectory recorded;
    for (int i = 0; i < 10; ++i) recorded.push_back({static_cast<double>(i), rng.pose(5.0)});
    const Trajectory converted = camera_trajectory_from_bonn_marker(recorded);
    ASSERT_EQ(converted.size(), recorded.size());
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      EXPECT_EQ(converted[i].timestamp_s, recorded[i].timestamp_s);
      const Pose expected = camera_pose_from_bonn_marker(recorded[i].T_world_camera);
      EXPECT_NEAR((converted[i].T_world_camera.matrix() - expected.matrix()).norm(), 0.0, 1e-13);
    }
  });
  EXPECT_TRUE(camera_trajectory_from_bonn_marker({}).empty());
}

}  // namespace
}  // namespace srslam
