#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/evaluation/association.hpp"
#include "support/constants.hpp"

namespace srslam {
namespace {

using test::kEpoch_s;

Trajectory at_times(const std::vector<double>& timestamps_s) {
  Trajectory trajectory;
  for (const double timestamp_s : timestamps_s) {
    trajectory.push_back({timestamp_s, Pose::Identity()});
  }
  return trajectory;
}

AssociationOptions within(double max_time_difference_s, double estimate_time_offset_s = 0.0) {
  AssociationOptions options;
  options.max_time_difference_s = max_time_difference_s;
  options.estimate_time_offset_s = estimate_time_offset_s;
  return options;
}

struct IndexPair {
  std::size_t reference_index;
  std::size_t estimate_index;
};

void expect_matches(const AssociationResult& result, const std::vector<IndexPair>& expected) {
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  ASSERT_EQ(result.matches.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(result.matches[i].reference_index, expected[i].reference_index) << "match " << i;
    EXPECT_EQ(result.matches[i].estimate_index, expected[i].estimate_index) << "match " << i;
  }
}

TEST(Associate, ResultStartsAsNotRun) {
  EXPECT_EQ(AssociationResult{}.status.code, StatusCode::kNotRun);
}

TEST(Associate, DefaultToleranceIsTwentyMilliseconds) {
  EXPECT_EQ(AssociationOptions{}.max_time_difference_s, 0.02);
  EXPECT_EQ(AssociationOptions{}.estimate_time_offset_s, 0.0);
}

TEST(Associate, MatchesEqualTimeStamps) {
  const AssociationResult result = associate(at_times({1, 2, 3}), at_times({1, 2, 3}));
  expect_matches(result, {{0, 0}, {1, 1}, {2, 2}});
  EXPECT_EQ(result.num_reference, 3U);
  EXPECT_EQ(result.num_estimate, 3U);
  EXPECT_EQ(result.max_abs_time_difference_s, 0.0);
}

TEST(Associate, TakesTheNearestNotTheFirst) {
  // Both estimates could take the reference at 10; the nearer one gets it, the other one gets 0.
  const AssociationResult result = associate(at_times({0, 10, 30}), at_times({7, 9}), within(8));
  expect_matches(result, {{0, 0}, {1, 1}});
  EXPECT_EQ(result.matches[0].time_difference_s, 7.0);
  EXPECT_EQ(result.matches[1].time_difference_s, -1.0);
  EXPECT_EQ(result.max_abs_time_difference_s, 7.0);
}

TEST(Associate, IsOneToOne) {
  expect_matches(associate(at_times({10}), at_times({8, 9, 11.5}), within(5)), {{0, 1}});
  expect_matches(associate(at_times({8, 9, 11.5}), at_times({10}), within(5)), {{1, 0}});
}

TEST(Associate, ToleranceItselfIsExcluded) {
  expect_matches(associate(at_times({0, 8}), at_times({2, 9}), within(2)), {{1, 1}});
  expect_matches(associate(at_times({0, 8}), at_times({2, 9}), within(2.5)), {{0, 0}, {1, 1}});
}

TEST(Associate, TiesGoToTheSmallerReferenceThenEstimateIndex) {
  expect_matches(associate(at_times({0, 2}), at_times({1}), within(2)), {{0, 0}});
  expect_matches(associate(at_times({1}), at_times({0, 2}), within(2)), {{0, 0}});
  expect_matches(associate(at_times({0, 2}), at_times({1, 3}), within(2)), {{0, 0}, {1, 1}});
}

TEST(Associate, MayCrossAsNearestFirstMust) {
  const AssociationResult result = associate(at_times({0, 10}), at_times({11, 15}), within(20));
  expect_matches(result, {{0, 1}, {1, 0}});
}

TEST(Associate, AddsTheOffsetToTheEstimate) {
  const AssociationResult result =
      associate(at_times({100, 101, 102}), at_times({0.25, 1.25}), within(0.5, 100.0));
  expect_matches(result, {{0, 0}, {1, 1}});
  EXPECT_EQ(result.matches[0].time_difference_s, 0.25);
  EXPECT_EQ(result.max_abs_time_difference_s, 0.25);
  EXPECT_FALSE(associate(at_times({100, 101}), at_times({0, 1}), within(0.5, -100.0)).status.ok());
}

TEST(Associate, WorksWithTimeStampsOfTheEpoch) {
  Trajectory reference;
  Trajectory estimate;
  for (int i = 0; i < 200; ++i) {
    reference.push_back({kEpoch_s + 0.01 * i, Pose::Identity()});
    if (i % 3 == 0) estimate.push_back({kEpoch_s + 0.01 * i + 0.004, Pose::Identity()});
  }
  const AssociationResult result = associate(reference, estimate);
  ASSERT_TRUE(result.status.ok());
  ASSERT_EQ(result.matches.size(), estimate.size());
  for (const TrajectoryMatch& match : result.matches) {
    EXPECT_EQ(match.reference_index, 3 * match.estimate_index);
    EXPECT_NEAR(match.time_difference_s, 0.004, 1e-6);
  }
}

TEST(Associate, RefusesEmptyTrajectories) {
  const AssociationResult no_reference = associate({}, at_times({1}));
  EXPECT_EQ(no_reference.status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(std::string(no_reference.status.reason), "the reference has no poses");
  EXPECT_EQ(no_reference.num_estimate, 1U);
  const AssociationResult no_estimate = associate(at_times({1}), {});
  EXPECT_EQ(no_estimate.status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(std::string(no_estimate.status.reason), "the estimate has no poses");
  EXPECT_EQ(no_estimate.num_reference, 1U);
}

TEST(Associate, SaysWhenNothingIsWithinTheTolerance) {
  const AssociationResult result = associate(at_times({0, 1}), at_times({0.5}));
  EXPECT_EQ(result.status.code, StatusCode::kInsufficientData);
  EXPECT_NE(std::string(result.status.reason).find("max_time_difference_s"), std::string::npos);
  EXPECT_TRUE(result.matches.empty());
  EXPECT_EQ(result.num_reference, 2U);
  EXPECT_EQ(result.num_estimate, 1U);
}

TEST(Associate, RefusesBadTrajectoriesAndNamesThem) {
  const AssociationResult reference = associate(at_times({1, 0}), at_times({1}));
  EXPECT_EQ(reference.status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(std::string(reference.status.reason).rfind("reference: ", 0), 0U);
  const AssociationResult estimate = associate(at_times({1}), at_times({2, 2}));
  EXPECT_EQ(estimate.status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(std::string(estimate.status.reason).rfind("estimate: ", 0), 0U);
  EXPECT_TRUE(estimate.matches.empty());
}

TEST(Associate, RefusesBadOptions) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const AssociationOptions& options :
       {within(0.0), within(-1.0), within(nan), within(infinity), within(0.02, nan),
        within(0.02, infinity)}) {
    EXPECT_EQ(options.validate().code, StatusCode::kInvalidArgument);
    EXPECT_EQ(associate(at_times({1}), at_times({1}), options).status.code,
              StatusCode::kInvalidArgument);
  }
}

TEST(Associate, RefusesAnOffsetThatSwallowsTheTimeStamps) {
  const AssociationResult result = associate(at_times({1}), at_times({1, 2}), within(0.02, 1e18));
  EXPECT_EQ(result.status.code, StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(result.status.reason).find("offset"), std::string::npos);

  const double huge = std::numeric_limits<double>::max();
  const AssociationResult overflow =
      associate(at_times({1}), at_times({0, huge}), within(0.02, huge));
  EXPECT_EQ(overflow.status.code, StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace srslam
