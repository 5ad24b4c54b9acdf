#include "srslam/culling/depth_groups.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/constants.hpp"

namespace srslam {
namespace {

using testing::ElementsAre;

DepthThresholdResult threshold_of(const std::vector<float>& depth_m,
                                  DepthThreshold form = DepthThreshold::kLiteral) {
  DepthGroupOptions options;
  options.threshold = form;
  std::vector<float> scratch;
  return depth_threshold(depth_m, options, scratch);
}

DepthGroups groups_of(const std::vector<float>& depth_m, float threshold_m,
                      DepthGrouping grouping = DepthGrouping::kGapLinkage) {
  DepthGroups groups;
  group_by_depth(depth_m, threshold_m, grouping, groups);
  return groups;
}

TEST(DepthThreshold, IsTheInterquartileRangeAsPrinted) {
  // Of 1, ..., n metres: ranks n/4 and 3n/4, rounded down, counted from 0.
  const float expected_m[] = {0, 1, 2, 2, 2, 3, 4, 4};
  for (std::size_t n = 1; n <= 8; ++n) {
    std::vector<float> depth_m;
    for (std::size_t i = n; i > 0; --i) depth_m.push_back(float(i));
    EXPECT_EQ(threshold_of(depth_m).threshold_m, expected_m[n - 1]) << n;
  }
  const DepthThresholdResult result = threshold_of({4.0F, 1.0F, 3.0F, 2.0F, 9.0F});
  EXPECT_EQ(result.lower_quartile_m, 2.0F);
  EXPECT_EQ(result.upper_quartile_m, 4.0F);
  EXPECT_EQ(result.interquartile_range_m, 2.0F);
  EXPECT_EQ(result.num_depths, 5U);
}

TEST(DepthThreshold, IsNotTheSameInAMirrorAsPrinted) {
  // 0, 1, 2, 10 and 10 minus them, a metre further so that all are valid.
  EXPECT_EQ(threshold_of({1.0F, 2.0F, 3.0F, 11.0F}).threshold_m, 9.0F);
  EXPECT_EQ(threshold_of({11.0F, 10.0F, 9.0F, 1.0F}).threshold_m, 2.0F);
}

TEST(DepthThreshold, IsKeptWithinItsLimits) {
  const std::vector<float> far_apart = {1.0F, 1.0F, 3.5F, 3.5F};
  EXPECT_EQ(threshold_of(far_apart).threshold_m, 2.5F);
  EXPECT_EQ(threshold_of(far_apart, DepthThreshold::kClamped).threshold_m, 0.2F);
  EXPECT_EQ(threshold_of({2.0F, 2.0F, 2.0F}).threshold_m, 0.0F);
  EXPECT_EQ(threshold_of({2.0F, 2.0F, 2.0F}, DepthThreshold::kClamped).threshold_m, 0.05F);
  EXPECT_EQ(threshold_of({2.0F, 2.125F}, DepthThreshold::kClamped).threshold_m, 0.125F);
}

TEST(DepthThreshold, LeavesOutWhatIsNoDepth) {
  const float nan = float(test::kNan);
  const float inf = float(test::kInf);
  const DepthThresholdResult result = threshold_of({0.0F, nan, 1.0F, -2.0F, inf, 2.0F, -inf, 3.0F});
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_depths, 3U);
  EXPECT_EQ(result.lower_quartile_m, 1.0F);
  EXPECT_EQ(result.upper_quartile_m, 3.0F);
  EXPECT_EQ(threshold_of({0.0F, nan}).status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(threshold_of({}).status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(threshold_of({}).threshold_m, 0.0F);
}

TEST(DepthThreshold, RefusesLimitsThatAreNone) {
  std::vector<float> scratch;
  for (const auto& [low, high] : {std::pair<double, double>{0.0, 0.2},
                                  {0.3, 0.2},
                                  {0.05, test::kInf},
                                  {test::kNan, 0.2},
                                  {0.05, test::kNan}}) {
    DepthGroupOptions options;
    options.min_threshold_m = low;
    options.max_threshold_m = high;
    EXPECT_EQ(depth_threshold({}, options, scratch).status.code, StatusCode::kInvalidArgument);
  }
}

TEST(DepthGroups, AreCutAtGaps) {
  const std::vector<float> depth_m = {3.5F, 1.0F, 0.0F, 1.25F, 3.25F, 1.5F};
  const DepthGroups groups = groups_of(depth_m, 0.25F);
  EXPECT_THAT(groups.group_of, ElementsAre(1, 0, kNoDepthGroup, 0, 1, 0));
  ASSERT_EQ(groups.groups.size(), 2U);
  EXPECT_EQ(groups.groups[0].num_points, 3U);
  EXPECT_EQ(groups.groups[0].min_depth_m, 1.0F);
  EXPECT_EQ(groups.groups[0].max_depth_m, 1.5F);
  EXPECT_EQ(groups.groups[1].num_points, 2U);
  EXPECT_EQ(groups.num_without_depth, 1U);
  // A body deeper than the threshold stays whole only without an anchor.
  EXPECT_THAT(groups_of(depth_m, 0.25F, DepthGrouping::kAnchored).group_of,
              ElementsAre(2, 0, kNoDepthGroup, 0, 2, 1));
}

TEST(DepthGroups, WithoutAThresholdEveryDepthIsItsOwn) {
  EXPECT_THAT(groups_of({2.0F, 1.0F, 2.0F, 1.5F}, 0.0F).group_of, ElementsAre(2, 0, 2, 1));
}

TEST(DepthGroups, OfNothingAreNone) {
  DepthGroups groups = groups_of({1.0F, 2.0F}, 0.1F);
  group_by_depth({}, 0.1F, DepthGrouping::kGapLinkage, groups);
  EXPECT_TRUE(groups.status.ok());
  EXPECT_TRUE(groups.groups.empty());
  EXPECT_TRUE(groups.group_of.empty());
  const DepthGroups without_depth = groups_of({0.0F, float(test::kNan)}, 0.1F);
  EXPECT_TRUE(without_depth.groups.empty());
  EXPECT_EQ(without_depth.num_without_depth, 2U);
}

TEST(DepthGroups, RefuseAThresholdThatIsNone) {
  for (const double threshold : {-0.1, test::kNan, test::kInf}) {
    EXPECT_EQ(groups_of({1.0F}, float(threshold)).status.code, StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace srslam
