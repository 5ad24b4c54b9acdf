#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "srslam/evaluation/trajectory.hpp"

namespace srslam {
namespace {

Trajectory three_poses() {
  Trajectory trajectory(3);
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    trajectory[i].timestamp_s = 1548339827.04 + 0.033 * static_cast<double>(i);
    trajectory[i].T_world_camera.translation() =
        Eigen::Vector3d(1e6 + static_cast<double>(i), -2.0, 0.5);
    trajectory[i].T_world_camera.linear() =
        Eigen::AngleAxisd(0.3 * static_cast<double>(i), Eigen::Vector3d::UnitY())
            .toRotationMatrix();
  }
  return trajectory;
}

void expect_refused(const Trajectory& trajectory, std::size_t pose_index, const char* part) {
  const TrajectoryCheck check = check_trajectory(trajectory, TrajectoryRole::kEstimate);
  EXPECT_EQ(check.status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(check.pose_index, pose_index);
  const std::string reason = check.status.reason;
  EXPECT_NE(reason.find(part), std::string::npos) << reason;
  EXPECT_EQ(reason.rfind("estimate: ", 0), 0U) << reason;
}

TEST(CheckTrajectory, AcceptsValidOnesAndTheEmptyOne) {
  EXPECT_TRUE(check_trajectory(three_poses()).status.ok());
  EXPECT_TRUE(check_trajectory({}).status.ok());
}

TEST(CheckTrajectory, StatusStartsAsNotRun) {
  EXPECT_EQ(TrajectoryCheck{}.status.code, StatusCode::kNotRun);
}

TEST(CheckTrajectory, RefusesTimeStampsThatAreNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (std::size_t i = 0; i < 3; ++i) {
      Trajectory trajectory = three_poses();
      trajectory[i].timestamp_s = bad;
      expect_refused(trajectory, i, "not finite");
    }
  }
}

TEST(CheckTrajectory, RefusesARepeatedTimeStamp) {
  Trajectory trajectory = three_poses();
  trajectory[2].timestamp_s = trajectory[1].timestamp_s;
  expect_refused(trajectory, 2, "occurs twice");
}

TEST(CheckTrajectory, RefusesUnsortedTimeStamps) {
  Trajectory trajectory = three_poses();
  trajectory[1].timestamp_s = trajectory[0].timestamp_s - 1.0;
  expect_refused(trajectory, 1, "not sorted");
}

TEST(CheckTrajectory, RefusesEveryEntryOfAPoseThatIsNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        Trajectory trajectory = three_poses();
        trajectory[1].T_world_camera.matrix()(row, column) = bad;
        expect_refused(trajectory, 1, "a pose is not finite");
      }
    }
  }
}

TEST(CheckTrajectory, RefusesWhatIsNoRotation) {
  Trajectory scaled = three_poses();
  scaled[0].T_world_camera.linear() *= 1.00001;
  expect_refused(scaled, 0, "orthonormal");

  Trajectory mirrored = three_poses();
  mirrored[2].T_world_camera.linear().col(0) *= -1.0;
  expect_refused(mirrored, 2, "orthonormal");

  Trajectory zero = three_poses();
  zero[2].T_world_camera.linear().setZero();
  expect_refused(zero, 2, "orthonormal");
}

TEST(CheckTrajectory, AcceptsRotationsThatAreRoundedToSinglePrecision) {
  Trajectory trajectory = three_poses();
  for (StampedPose& pose : trajectory) {
    pose.T_world_camera.linear() = pose.T_world_camera.linear().cast<float>().cast<double>().eval();
  }
  EXPECT_TRUE(check_trajectory(trajectory).status.ok());
}

TEST(CheckTrajectory, NamesTheRoleInTheReason) {
  Trajectory trajectory = three_poses();
  trajectory[1].timestamp_s = 0.0;
  EXPECT_EQ(std::string(check_trajectory(trajectory, TrajectoryRole::kReference).status.reason)
                .rfind("reference: ", 0),
            0U);
  EXPECT_EQ(std::string(check_trajectory(trajectory).status.reason).rfind("time stamps", 0), 0U);
}

}  // namespace
}  // namespace srslam
