#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "srslam/io/depth_check.hpp"

namespace srslam {
namespace {

TEST(DepthCheck, SummaryIgnoresInvalidPixels) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  // The last column is padding that the view does not cover.
  const std::vector<float> pixels = {1.0F, nan,  2.0F,  99.0F,  //
                                     0.0F, 5.0F, -1.0F, 99.0F,  //
                                     inf,  3.0F, 0.0F,  99.0F};
  const DepthSummary summary =
      summarize_depth({pixels.data(), 3, 3, 4 * static_cast<std::ptrdiff_t>(sizeof(float))});
  EXPECT_DOUBLE_EQ(summary.valid_share, 4.0 / 9.0);
  EXPECT_EQ(summary.median_m, 3.0);  // upper middle of 1 2 3 5
}

TEST(DepthCheck, NothingValidGivesZeros) {
  const std::vector<float> zeros(12, 0.0F);
  for (const ImageView<const float>& view :
       {ImageView<const float>(), ImageView<const float>(zeros.data(), 4, 3)}) {
    const DepthSummary summary = summarize_depth(view);
    EXPECT_EQ(summary.valid_share, 0.0);
    EXPECT_EQ(summary.median_m, 0.0);
    EXPECT_EQ(check_depth_plausible(summary).code, StatusCode::kInsufficientData);
  }
}

TEST(DepthCheck, FindsUnitsTakenForOthers) {
  EXPECT_TRUE(check_depth_plausible({0.8, 1.5}).ok());
  EXPECT_TRUE(check_depth_plausible({0.1, 0.3}).ok());
  EXPECT_TRUE(check_depth_plausible({1.0, 10.0}).ok());
  // 1.5 m in millimetres read as metres, and the other way round.
  EXPECT_EQ(check_depth_plausible({0.8, 1500.0}).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(check_depth_plausible({0.8, 0.0015}).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(check_depth_plausible({0.05, 1.5}).code, StatusCode::kInsufficientData);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check_depth_plausible({nan, 1.5}).ok());
  EXPECT_FALSE(check_depth_plausible({0.8, nan}).ok());
}

}  // namespace
}  // namespace srslam
