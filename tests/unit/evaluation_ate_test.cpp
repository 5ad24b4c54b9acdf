#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "srslam/evaluation/trajectory_error.hpp"
#include "support/constants.hpp"

namespace srslam {
namespace {

using test::kEpoch_s;

Trajectory through(const std::vector<Eigen::Vector3d>& positions) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    StampedPose pose;
    pose.timestamp_s = kEpoch_s + 0.1 * static_cast<double>(i);
    pose.T_world_camera.translation() = positions[i];
    trajectory.push_back(pose);
  }
  return trajectory;
}

/// Corners of a square of side 2, and the same lifted alternately by `height_m`. Every coordinate
/// of the lift is uncorrelated with the square, so that no rotation reduces it.
Trajectory square() { return through({{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}}); }
Trajectory lifted(double height_m) {
  return through({{1, 1, height_m}, {-1, 1, -height_m}, {-1, -1, height_m}, {1, -1, -height_m}});
}

AteOptions aligned(Alignment alignment) {
  AteOptions options;
  options.alignment = alignment;
  return options;
}

TEST(AbsoluteTrajectoryError, ResultStartsAsNotRun) {
  EXPECT_EQ(AteResult{}.status.code, StatusCode::kNotRun);
}

TEST(AbsoluteTrajectoryError, WithoutAlignmentAgreesWithHandComputedValues) {
  // Errors 5, 0, 2, 1.
  const Trajectory estimate = through({{1 + 3, 1 + 4, 0}, {-1, 1, 0}, {-1, -1, 2}, {1, -2, 0}});
  const AteResult result = absolute_trajectory_error(square(), estimate, aligned(Alignment::kNone));
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.errors_m, (std::vector<double>{5, 0, 2, 1}));
  EXPECT_DOUBLE_EQ(result.translation_m.rmse, std::sqrt(30.0 / 4.0));
  EXPECT_DOUBLE_EQ(result.translation_m.mean, 2.0);
  EXPECT_DOUBLE_EQ(result.translation_m.median, 1.5);
  EXPECT_DOUBLE_EQ(result.translation_m.std, std::sqrt(14.0 / 4.0));
  EXPECT_EQ(result.translation_m.min, 0.0);
  EXPECT_EQ(result.translation_m.max, 5.0);
  EXPECT_EQ(result.alignment, Alignment::kNone);
  EXPECT_TRUE(result.T_reference_estimate.matrix().isIdentity(0.0));
  EXPECT_EQ(result.scale, 1.0);
}

TEST(AbsoluteTrajectoryError, AlignedAgreesWithHandComputedValues) {
  Trajectory estimate = lifted(0.25);
  Pose T_world_other = Pose::Identity();
  T_world_other.linear() =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 1, -1).normalized()).toRotationMatrix();
  T_world_other.translation() = Eigen::Vector3d(10, 20, 30);
  for (StampedPose& pose : estimate) pose.T_world_camera = T_world_other * pose.T_world_camera;

  const AteResult result = absolute_trajectory_error(square(), estimate);
  ASSERT_TRUE(result.status.ok());
  for (const double error_m : result.errors_m) EXPECT_NEAR(error_m, 0.25, 1e-14);
  EXPECT_NEAR(result.translation_m.rmse, 0.25, 1e-14);
  EXPECT_NEAR(result.translation_m.std, 0.0, 1e-14);
  EXPECT_TRUE(
      result.T_reference_estimate.matrix().isApprox(T_world_other.inverse().matrix(), 1e-13));
  EXPECT_FALSE(result.collinear);
  EXPECT_FALSE(result.fixed_camera);
  EXPECT_NEAR(result.reference_rms_displacement_m, std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(result.estimate_rms_displacement_m, std::sqrt(2.0 + 0.0625), 1e-13);
}

TEST(AbsoluteTrajectoryError, Sim3TakesOutTheScaleAndSE3DoesNot) {
  Trajectory estimate = square();
  for (StampedPose& pose : estimate) pose.T_world_camera.translation() *= 1.25;
  const AteResult rigid = absolute_trajectory_error(square(), estimate);
  ASSERT_TRUE(rigid.status.ok());
  EXPECT_NEAR(rigid.translation_m.rmse, 0.25 * std::sqrt(2.0), 1e-14);
  EXPECT_EQ(rigid.scale, 1.0);
  const AteResult similar =
      absolute_trajectory_error(square(), estimate, aligned(Alignment::kSim3));
  ASSERT_TRUE(similar.status.ok());
  EXPECT_NEAR(similar.translation_m.rmse, 0.0, 1e-14);
  EXPECT_NEAR(similar.scale, 0.8, 1e-14);
  EXPECT_EQ(similar.alignment, Alignment::kSim3);
}

TEST(AbsoluteTrajectoryError, TheTransformGivenMapsTheEstimateOntoTheReference) {
  Trajectory estimate = lifted(0.1);
  for (StampedPose& pose : estimate) {
    pose.T_world_camera.translation() =
        2.0 * pose.T_world_camera.translation().eval() + Eigen::Vector3d(1, 2, 3);
  }
  for (const Alignment alignment : {Alignment::kNone, Alignment::kSE3, Alignment::kSim3}) {
    const AteResult result = absolute_trajectory_error(square(), estimate, aligned(alignment));
    ASSERT_TRUE(result.status.ok());
    for (std::size_t i = 0; i < result.matches.size(); ++i) {
      const Eigen::Vector3d p_reference =
          square()[result.matches[i].reference_index].T_world_camera.translation();
      const Eigen::Vector3d p_estimate =
          estimate[result.matches[i].estimate_index].T_world_camera.translation();
      EXPECT_NEAR((result.T_reference_estimate * (result.scale * p_estimate) - p_reference).norm(),
                  result.errors_m[i], 1e-14);
    }
  }
}

TEST(AbsoluteTrajectoryError, CountsWhatDoesNotMatch) {
  Trajectory reference = square();
  Trajectory estimate = lifted(0.25);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate[i].timestamp_s += 0.004 * static_cast<double>(i);
  }
  StampedPose late;
  late.timestamp_s = kEpoch_s + 100.0;
  estimate.push_back(late);
  late.timestamp_s += 50.0;
  reference.push_back(late);
  reference.push_back(late);
  reference.back().timestamp_s += 1.0;
  const AteResult result = absolute_trajectory_error(reference, estimate);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_matched, 4U);
  EXPECT_EQ(result.num_reference, 6U);
  EXPECT_EQ(result.num_estimate, 5U);
  EXPECT_NEAR(result.max_abs_time_difference_s, 0.012, 1e-6);
  EXPECT_NEAR(result.translation_m.rmse, 0.25, 1e-14);
}

TEST(AbsoluteTrajectoryError, RefusesFewerThanThreeMatches) {
  for (std::size_t size = 1; size < 3; ++size) {
    Trajectory estimate = square();
    estimate.resize(size);
    for (const Alignment alignment : {Alignment::kNone, Alignment::kSE3, Alignment::kSim3}) {
      const AteResult result = absolute_trajectory_error(square(), estimate, aligned(alignment));
      EXPECT_EQ(result.status.code, StatusCode::kInsufficientData);
      EXPECT_NE(std::string(result.status.reason).find("three"), std::string::npos);
      EXPECT_EQ(result.num_matched, size);
      EXPECT_EQ(result.num_reference, 4U);
      EXPECT_EQ(result.num_estimate, size);
      EXPECT_EQ(result.translation_m.count, 0U);
    }
  }
  Trajectory three = square();
  three.resize(3);
  EXPECT_TRUE(absolute_trajectory_error(square(), three).status.ok());
}

TEST(AbsoluteTrajectoryError, RefusesEmptyAndBadTrajectories) {
  EXPECT_EQ(absolute_trajectory_error({}, square()).status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(absolute_trajectory_error(square(), {}).status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(absolute_trajectory_error({}, {}).status.code, StatusCode::kInsufficientData);

  Trajectory nan_pose = square();
  nan_pose[2].T_world_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  Trajectory duplicate = square();
  duplicate[2].timestamp_s = duplicate[1].timestamp_s;
  Trajectory unsorted = square();
  std::swap(unsorted[1].timestamp_s, unsorted[2].timestamp_s);
  Trajectory no_rotation = square();
  no_rotation[3].T_world_camera.linear().setZero();
  for (const Trajectory& bad : {nan_pose, duplicate, unsorted, no_rotation}) {
    const AteResult as_reference = absolute_trajectory_error(bad, square());
    EXPECT_EQ(as_reference.status.code, StatusCode::kInvalidArgument);
    EXPECT_EQ(std::string(as_reference.status.reason).rfind("reference: ", 0), 0U);
    const AteResult as_estimate = absolute_trajectory_error(square(), bad);
    EXPECT_EQ(as_estimate.status.code, StatusCode::kInvalidArgument);
    EXPECT_EQ(std::string(as_estimate.status.reason).rfind("estimate: ", 0), 0U);
    EXPECT_TRUE(as_estimate.errors_m.empty());
  }
}

TEST(AbsoluteTrajectoryError, RefusesPositionsThatOverflow) {
  Trajectory huge = square();
  for (StampedPose& pose : huge) pose.T_world_camera.translation() *= 1e300;
  for (const Alignment alignment : {Alignment::kNone, Alignment::kSE3, Alignment::kSim3}) {
    EXPECT_EQ(absolute_trajectory_error(huge, huge, aligned(alignment)).status.code,
              StatusCode::kInvalidArgument);
  }
}

TEST(AbsoluteTrajectoryError, RefusesBadOptions) {
  AteOptions options;
  options.association.max_time_difference_s = 0.0;
  EXPECT_EQ(absolute_trajectory_error(square(), square(), options).status.code,
            StatusCode::kInvalidArgument);
  for (const double bad : {-0.1, std::numeric_limits<double>::quiet_NaN()}) {
    options = {};
    options.fixed_camera_radius_m = bad;
    EXPECT_EQ(absolute_trajectory_error(square(), square(), options).status.code,
              StatusCode::kInvalidArgument);
  }
}

TEST(AbsoluteTrajectoryError, AStraightPathIsAlignedProperlyAndFlagged) {
  std::vector<Eigen::Vector3d> line;
  std::vector<Eigen::Vector3d> other_line;
  for (int i = 0; i < 20; ++i) {
    line.emplace_back(0.1 * i, 0, 0);
    other_line.emplace_back(5, 0.1 * i, 0.002 * (i % 2));
  }
  const AteResult result = absolute_trajectory_error(through(line), through(other_line));
  ASSERT_TRUE(result.status.ok());
  EXPECT_TRUE(result.collinear);
  EXPECT_FALSE(result.fixed_camera);
  EXPECT_NEAR(result.T_reference_estimate.linear().determinant(), 1.0, 1e-12);
  EXPECT_LE(result.translation_m.rmse, 0.001 + 1e-12);
  EXPECT_FALSE(
      absolute_trajectory_error(through(line), through(other_line), aligned(Alignment::kNone))
          .collinear);
}

TEST(AbsoluteTrajectoryError, AFixedCameraIsFlaggedWithItsDisplacement) {
  // The reference stands still; the estimate drifts along x and back: 0, 0.3, 0, -0.3.
  const Trajectory reference = through({{7, 7, 7}, {7, 7, 7}, {7, 7, 7}, {7, 7, 7}});
  const Trajectory estimate = through({{0, 0, 0}, {0.3, 0, 0}, {0, 0, 0}, {-0.3, 0, 0}});
  const AteResult result = absolute_trajectory_error(reference, estimate);
  ASSERT_TRUE(result.status.ok());
  EXPECT_TRUE(result.fixed_camera);
  EXPECT_TRUE(result.collinear);
  EXPECT_EQ(result.reference_rms_displacement_m, 0.0);
  EXPECT_NEAR(result.estimate_rms_displacement_m, 0.3 / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(result.translation_m.rmse, 0.3 / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(result.T_reference_estimate.linear().determinant(), 1.0, 1e-12);

  const AteResult similar =
      absolute_trajectory_error(reference, estimate, aligned(Alignment::kSim3));
  EXPECT_EQ(similar.status.code, StatusCode::kDegenerate);
  EXPECT_TRUE(similar.fixed_camera);
  EXPECT_NEAR(similar.estimate_rms_displacement_m, 0.3 / std::sqrt(2.0), 1e-15);
  EXPECT_TRUE(similar.errors_m.empty());
}

TEST(AbsoluteTrajectoryError, FixedMeansWithinTheRadiusAboutTheMean) {
  const Trajectory reference = through({{0.1, 0, 0}, {-0.1, 0, 0}, {0, 0.1, 0}, {0, -0.1, 0}});
  AteOptions options;
  EXPECT_FALSE(absolute_trajectory_error(reference, reference, options).fixed_camera);
  options.fixed_camera_radius_m = 0.1001;
  EXPECT_TRUE(absolute_trajectory_error(reference, reference, options).fixed_camera);
  options.fixed_camera_radius_m = 0.0999;
  EXPECT_FALSE(absolute_trajectory_error(reference, reference, options).fixed_camera);
}

TEST(AbsoluteTrajectoryError, NamesOfTheAlignments) {
  EXPECT_EQ(std::string(to_string(Alignment::kNone)), "none");
  EXPECT_EQ(std::string(to_string(Alignment::kSE3)), "SE3");
  EXPECT_EQ(std::string(to_string(Alignment::kSim3)), "Sim3");
}

}  // namespace
}  // namespace srslam
