#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/evaluation/trajectory_error.hpp"
#include "support/constants.hpp"

namespace srslam {
namespace {

using test::kEpoch_s;
using test::kPi;

Eigen::Matrix3d about_z(double angle_deg) {
  return Eigen::AngleAxisd(angle_deg * kPi / 180.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Pose pose_of(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = translation;
  return pose;
}

/// Still at the origin, one pose each `interval_s`.
Trajectory still(std::size_t size, double interval_s = 0.125) {
  Trajectory trajectory(size);
  for (std::size_t i = 0; i < size; ++i) {
    trajectory[i].timestamp_s = kEpoch_s + interval_s * static_cast<double>(i);
  }
  return trajectory;
}

/// At the time stamps (after the epoch), x growing by 1 m a second.
Trajectory moving_at(const std::vector<double>& timestamps_s) {
  Trajectory trajectory;
  for (const double timestamp_s : timestamps_s) {
    trajectory.push_back(
        {kEpoch_s + timestamp_s, pose_of(Eigen::Matrix3d::Identity(), {timestamp_s, 0, 0})});
  }
  return trajectory;
}

RpeOptions over(double delta, RpeDelta unit, RpeDefinition definition) {
  RpeOptions options;
  options.delta = delta;
  options.unit = unit;
  options.definition = definition;
  return options;
}

std::vector<std::pair<std::size_t, std::size_t>> estimate_pairs(const RpeResult& result) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const RpePair& pair : result.pairs) pairs.emplace_back(pair.estimate_from, pair.estimate_to);
  return pairs;
}

using IndexPairs = std::vector<std::pair<std::size_t, std::size_t>>;

TEST(RelativePoseError, ResultStartsAsNotRun) {
  EXPECT_EQ(RpeResult{}.status.code, StatusCode::kNotRun);
}

TEST(RelativePoseError, AgreesWithHandComputedValues) {
  // Motions of the estimate: 0.1 m, 0.3 m and 10°, 0.2 m; the reference stands still.
  Trajectory estimate = still(4);
  estimate[1].T_world_camera = pose_of(about_z(0), {0.1, 0, 0});
  estimate[2].T_world_camera = pose_of(about_z(10), {0.1, 0.3, 0});
  estimate[3].T_world_camera = pose_of(about_z(10), {0.1, 0.3, 0.2});
  const RpeResult result = relative_pose_error(still(4), estimate);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(estimate_pairs(result), (IndexPairs{{0, 1}, {1, 2}, {2, 3}}));
  EXPECT_NEAR(result.pairs[0].translation_m, 0.1, 1e-15);
  EXPECT_NEAR(result.pairs[1].translation_m, 0.3, 1e-15);
  EXPECT_NEAR(result.pairs[2].translation_m, 0.2, 1e-15);
  EXPECT_NEAR(result.pairs[1].rotation_deg, 10.0, 1e-12);
  EXPECT_NEAR(result.pairs[2].rotation_deg, 0.0, 1e-12);
  EXPECT_NEAR(result.translation_m.mean, 0.2, 1e-15);
  EXPECT_NEAR(result.translation_m.median, 0.2, 1e-15);
  EXPECT_NEAR(result.translation_m.rmse, std::sqrt(0.14 / 3.0), 1e-15);
  EXPECT_NEAR(result.translation_m.std, std::sqrt(0.02 / 3.0), 1e-15);
  EXPECT_NEAR(result.rotation_deg.rmse, 10.0 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(result.rotation_deg.max, 10.0, 1e-12);
  EXPECT_EQ(result.num_pairs, 3U);
  EXPECT_EQ(result.num_matched, 4U);
  EXPECT_EQ(result.num_reference, 4U);
  EXPECT_EQ(result.num_estimate, 4U);
  EXPECT_EQ(result.delta, 1.0);
  EXPECT_EQ(result.unit, RpeDelta::kFrames);
  EXPECT_EQ(result.median_interval_s, 0.125);
  EXPECT_EQ(result.max_interval_s, 0.125);
  EXPECT_EQ(result.pairs[1].from_timestamp_s, kEpoch_s + 0.125);
  EXPECT_EQ(result.pairs[1].to_timestamp_s, kEpoch_s + 0.25);
}

TEST(RelativePoseError, DefinitionsDifferInTheOrderOfTheMotions) {
  // Each step the reference goes 1 m ahead; the estimate does too, but has turned by 90° after it.
  Trajectory reference = still(4);
  Trajectory estimate = still(4);
  for (std::size_t i = 1; i < 4; ++i) {
    reference[i].T_world_camera = reference[i - 1].T_world_camera * pose_of(about_z(0), {1, 0, 0});
    estimate[i].T_world_camera = estimate[i - 1].T_world_camera * pose_of(about_z(90), {1, 0, 0});
  }
  const RpeResult ours = relative_pose_error(reference, estimate);
  ASSERT_TRUE(ours.status.ok());
  EXPECT_NEAR(ours.translation_m.max, 0.0, 1e-15);
  EXPECT_NEAR(ours.rotation_deg.mean, 90.0, 1e-12);
  const RpeResult tool =
      relative_pose_error(reference, estimate, over(1, RpeDelta::kFrames, RpeDefinition::kTumTool));
  ASSERT_TRUE(tool.status.ok());
  EXPECT_NEAR(tool.translation_m.min, std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(tool.translation_m.max, std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(tool.rotation_deg.mean, 90.0, 1e-12);
}

TEST(RelativePoseError, AnglesAreAccurateNearZeroAndNearHalfATurn) {
  for (const double angle_deg : {1e-9, 1e-5, 1.0, 179.0, 180.0 - 1e-5, 180.0}) {
    Trajectory estimate = still(3);
    estimate[1].T_world_camera.linear() = about_z(angle_deg);
    estimate[2].T_world_camera.linear() = about_z(2 * angle_deg);
    const RpeResult result = relative_pose_error(still(3), estimate);
    ASSERT_TRUE(result.status.ok());
    EXPECT_NEAR(result.rotation_deg.mean, angle_deg, 1e-13 + 4e-14 * angle_deg);
  }
}

TEST(RelativePoseError, FramesAreCountedInTheEstimate) {
  // Pose 2 of the estimate has no reference, so no pair may begin or end there.
  const Trajectory estimate = still(6);
  Trajectory reference = still(6);
  reference.erase(reference.begin() + 2);
  RpeOptions options = over(1, RpeDelta::kFrames, RpeDefinition::kMatchedPoses);
  EXPECT_EQ(estimate_pairs(relative_pose_error(reference, estimate, options)),
            (IndexPairs{{0, 1}, {3, 4}, {4, 5}}));
  options.delta = 2;
  EXPECT_EQ(estimate_pairs(relative_pose_error(reference, estimate, options)),
            (IndexPairs{{1, 3}, {3, 5}}));
  options.delta = 5;
  EXPECT_EQ(estimate_pairs(relative_pose_error(reference, estimate, options)),
            (IndexPairs{{0, 5}}));
}

TEST(RelativePoseError, APairOverLostFramesShowsInItsInterval) {
  Trajectory estimate = still(10);
  estimate.erase(estimate.begin() + 4, estimate.begin() + 8);
  const RpeResult result = relative_pose_error(still(10), estimate);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_pairs, 5U);
  EXPECT_EQ(result.median_interval_s, 0.125);
  EXPECT_EQ(result.max_interval_s, 5 * 0.125);
}

TEST(RelativePoseError, SecondsTakeTheNearestPoseWithinTheTolerance) {
  // One second after 0: 0.95 and 1.1 are near, the first nearer; after 0.5: nothing within 0.1.
  const Trajectory trajectory = moving_at({0.0, 0.5, 0.95, 1.1, 2.0, 2.2});
  const RpeResult result = relative_pose_error(
      trajectory, trajectory, over(1, RpeDelta::kSeconds, RpeDefinition::kMatchedPoses));
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(estimate_pairs(result), (IndexPairs{{0, 2}, {2, 4}, {3, 4}}));
  EXPECT_EQ(result.translation_m.max, 0.0);
  EXPECT_NEAR(result.max_interval_s, 1.05, 1e-6);

  RpeOptions wide = over(1, RpeDelta::kSeconds, RpeDefinition::kMatchedPoses);
  wide.relative_delta_tolerance = 0.45;
  EXPECT_EQ(estimate_pairs(relative_pose_error(trajectory, trajectory, wide)),
            (IndexPairs{{0, 2}, {1, 3}, {2, 4}, {3, 4}}));
}

TEST(RelativePoseError, SecondsNeverPairAPoseWithItself) {
  const Trajectory trajectory = moving_at({0.0, 0.01, 10.0, 10.02, 20.0});
  RpeOptions options = over(0.05, RpeDelta::kSeconds, RpeDefinition::kMatchedPoses);
  options.relative_delta_tolerance = 0.9;
  EXPECT_EQ(estimate_pairs(relative_pose_error(trajectory, trajectory, options)),
            (IndexPairs{{0, 1}, {2, 3}}));
}

TEST(RelativePoseError, TumToolLeavesOutPairsThatEndAtTheLastPose) {
  const Trajectory trajectory = still(6);
  const RpeResult frames = relative_pose_error(trajectory, trajectory,
                                               over(2, RpeDelta::kFrames, RpeDefinition::kTumTool));
  EXPECT_EQ(estimate_pairs(frames), (IndexPairs{{0, 2}, {1, 3}, {2, 4}}));
  const RpeResult seconds = relative_pose_error(
      trajectory, trajectory, over(0.25, RpeDelta::kSeconds, RpeDefinition::kTumTool));
  EXPECT_EQ(estimate_pairs(seconds), (IndexPairs{{0, 2}, {1, 3}, {2, 4}}));
}

TEST(RelativePoseError, TumToolPairsAPoseWithItselfBeforeAGap) {
  // Nearest to 1 s after 0.1 is 0.1 itself when the next pose is 5 s away.
  const Trajectory trajectory = moving_at({0.0, 0.1, 5.0, 6.0, 7.0});
  const RpeResult result = relative_pose_error(
      trajectory, trajectory, over(1, RpeDelta::kSeconds, RpeDefinition::kTumTool));
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(estimate_pairs(result), (IndexPairs{{0, 1}, {1, 1}, {2, 3}}));
}

TEST(RelativePoseError, TumToolAcceptsReferencesWithinTwiceTheirMedianInterval) {
  Trajectory reference = still(20);
  Trajectory estimate = still(20);
  for (StampedPose& pose : estimate) pose.timestamp_s += 0.03125;
  // Poses 8..12 lack a reference: the nearest ones are 7 (0.03125 s before pose 7) and 13.
  reference.erase(reference.begin() + 8, reference.begin() + 13);
  const RpeOptions options = over(1, RpeDelta::kFrames, RpeDefinition::kTumTool);
  const RpeResult result = relative_pose_error(reference, estimate, options);
  ASSERT_TRUE(result.status.ok());
  // At most 0.25 s away: poses 8 (0.15625 after 7), 11 (0.21875 before 13), 12; not 9 (0.28125
  // after 7) and 10 (0.34375 before 13).
  EXPECT_EQ(result.num_matched, 18U);
  EXPECT_EQ(result.num_pairs, 18U - 3U);
  EXPECT_EQ(result.max_abs_time_difference_s, 0.21875);
  for (const RpePair& pair : result.pairs) {
    EXPECT_NE(pair.estimate_from, 9U);
    EXPECT_NE(pair.estimate_to, 9U);
    EXPECT_NE(pair.estimate_from, 10U);
    EXPECT_NE(pair.estimate_to, 10U);
  }
}

TEST(RelativePoseError, BothDefinitionsAddTheOffset) {
  const Trajectory reference = moving_at({0, 1, 2, 3, 4, 5});
  Trajectory estimate = reference;
  for (StampedPose& pose : estimate) pose.timestamp_s -= 100.0;
  for (const RpeDefinition definition : {RpeDefinition::kMatchedPoses, RpeDefinition::kTumTool}) {
    RpeOptions options = over(1, RpeDelta::kFrames, definition);
    EXPECT_FALSE(relative_pose_error(reference, estimate, options).status.ok());
    options.association.estimate_time_offset_s = 100.0;
    const RpeResult result = relative_pose_error(reference, estimate, options);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_EQ(result.num_matched, 6U);
    EXPECT_EQ(result.translation_m.max, 0.0);
    EXPECT_EQ(result.max_abs_time_difference_s, 0.0);
  }
}

TEST(RelativePoseError, CrossedMatchesFormNoPair) {
  // Nearest first matches (1, 0) and then (0, 1): forwards in one trajectory, backwards in the
  // other.
  const Trajectory reference = moving_at({0.0, 0.010, 1.0, 2.0});
  const Trajectory estimate = moving_at({0.011, 0.015, 1.0, 2.0});
  const RpeResult result = relative_pose_error(reference, estimate);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_matched, 4U);
  EXPECT_EQ(estimate_pairs(result), (IndexPairs{{1, 2}, {2, 3}}));
}

TEST(RelativePoseError, RefusesTooFewPoses) {
  for (const RpeDefinition definition : {RpeDefinition::kMatchedPoses, RpeDefinition::kTumTool}) {
    const RpeOptions options = over(1, RpeDelta::kFrames, definition);
    for (std::size_t size = 0; size < 3; ++size) {
      const RpeResult result = relative_pose_error(still(5), still(size), options);
      EXPECT_EQ(result.status.code, StatusCode::kInsufficientData) << size;
      EXPECT_EQ(result.num_estimate, size);
      EXPECT_EQ(result.num_reference, 5U);
    }
    // Two reference poses are enough for the tool, which may use one for several estimates.
    const std::size_t too_few = definition == RpeDefinition::kTumTool ? 1 : 2;
    EXPECT_EQ(relative_pose_error(still(too_few), still(5), options).status.code,
              StatusCode::kInsufficientData);
    // Enough poses, but none that far apart.
    const RpeResult far =
        relative_pose_error(still(5), still(5), over(60, RpeDelta::kSeconds, definition));
    EXPECT_EQ(far.status.code, StatusCode::kInsufficientData);
    EXPECT_EQ(far.num_matched, 5U);
    EXPECT_TRUE(far.pairs.empty());
  }
}

TEST(RelativePoseError, TumToolRefusesTrajectoriesThatDoNotOverlap) {
  Trajectory reference = still(5, 100.0);
  const RpeResult result = relative_pose_error(reference, still(20),
                                               over(1, RpeDelta::kFrames, RpeDefinition::kTumTool));
  EXPECT_EQ(result.status.code, StatusCode::kInsufficientData);
  EXPECT_NE(std::string(result.status.reason).find("overlap"), std::string::npos);
}

TEST(RelativePoseError, RefusesBadTrajectories) {
  Trajectory nan_pose = still(5);
  nan_pose[2].T_world_camera.linear()(0, 0) = std::numeric_limits<double>::quiet_NaN();
  Trajectory duplicate = still(5);
  duplicate[2].timestamp_s = duplicate[1].timestamp_s;
  Trajectory unsorted = still(5);
  std::swap(unsorted[1].timestamp_s, unsorted[2].timestamp_s);
  for (const RpeDefinition definition : {RpeDefinition::kMatchedPoses, RpeDefinition::kTumTool}) {
    const RpeOptions options = over(1, RpeDelta::kFrames, definition);
    for (const Trajectory& bad : {nan_pose, duplicate, unsorted}) {
      const RpeResult as_reference = relative_pose_error(bad, still(5), options);
      EXPECT_EQ(as_reference.status.code, StatusCode::kInvalidArgument);
      EXPECT_EQ(std::string(as_reference.status.reason).rfind("reference: ", 0), 0U);
      const RpeResult as_estimate = relative_pose_error(still(5), bad, options);
      EXPECT_EQ(as_estimate.status.code, StatusCode::kInvalidArgument);
      EXPECT_EQ(std::string(as_estimate.status.reason).rfind("estimate: ", 0), 0U);
    }
  }
}

TEST(RelativePoseError, RefusesPositionsThatOverflow) {
  Trajectory huge = still(5);
  for (std::size_t i = 0; i < huge.size(); ++i) {
    huge[i].T_world_camera.translation().x() = i % 2 == 0 ? 1.5e308 : -1.5e308;
  }
  for (const RpeDefinition definition : {RpeDefinition::kMatchedPoses, RpeDefinition::kTumTool}) {
    const RpeResult result =
        relative_pose_error(still(5), huge, over(1, RpeDelta::kFrames, definition));
    EXPECT_EQ(result.status.code, StatusCode::kInvalidArgument);
    EXPECT_TRUE(result.pairs.empty());
    EXPECT_EQ(result.translation_m.count, 0U);
  }
}

TEST(RelativePoseError, RefusesBadOptions) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const RpeOptions& options) {
    return options.validate().code == StatusCode::kInvalidArgument &&
           relative_pose_error(still(5), still(5), options).status.code ==
               StatusCode::kInvalidArgument;
  };
  for (const double delta : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(refused(over(delta, RpeDelta::kFrames, RpeDefinition::kMatchedPoses)));
    EXPECT_TRUE(refused(over(delta, RpeDelta::kSeconds, RpeDefinition::kTumTool)));
  }
  EXPECT_TRUE(refused(over(1.5, RpeDelta::kFrames, RpeDefinition::kMatchedPoses)));
  EXPECT_TRUE(refused(over(1e12, RpeDelta::kFrames, RpeDefinition::kMatchedPoses)));
  EXPECT_TRUE(over(1.5, RpeDelta::kSeconds, RpeDefinition::kMatchedPoses).validate().ok());
  for (const double tolerance : {-0.1, 1.0, nan}) {
    RpeOptions options;
    options.relative_delta_tolerance = tolerance;
    EXPECT_TRUE(refused(options));
  }
  RpeOptions options;
  options.association.max_time_difference_s = -1.0;
  EXPECT_TRUE(refused(options));
}

TEST(RelativePoseError, NamesForTables) {
  EXPECT_EQ(std::string(to_string(RpeDelta::kFrames)), "frames");
  EXPECT_EQ(std::string(to_string(RpeDelta::kSeconds)), "s");
  EXPECT_EQ(std::string(to_string(RpeDefinition::kMatchedPoses)), "matched_poses");
  EXPECT_EQ(std::string(to_string(RpeDefinition::kTumTool)), "tum_tool");
}

}  // namespace
}  // namespace srslam
