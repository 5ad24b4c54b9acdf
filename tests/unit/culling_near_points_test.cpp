#include "srslam/culling/near_points.hpp"

#include <gtest/gtest.h>

#include "support/constants.hpp"

namespace srslam {
namespace {

TEST(NearPoints, AreWithinTheRadiusThatIsIncluded) {
  NearPoints points;
  EXPECT_FALSE(points.any_near(0.0F, 0.0F, 100.0F)) << "there are none";
  for (int i = 0; i < 7; ++i) points.add(10.0F * float(i), 0.0F);
  EXPECT_EQ(points.size(), 7U);
  EXPECT_TRUE(points.any_near(63.0F, 4.0F, 5.0F));
  EXPECT_FALSE(points.any_near(63.0F, 4.0F, 4.999F));
  EXPECT_FALSE(points.any_near(70.0F, 0.0F, 9.0F));
  points.clear();
  points.add(200.0F, 0.0F);
  EXPECT_FALSE(points.any_near(0.0F, 0.0F, 5.0F)) << "what was cleared is gone";
}

TEST(NearPoints, WithoutANumberAreNearNothing) {
  NearPoints points;
  points.add(float(test::kNan), 0.0F);
  points.add(float(test::kInf), 0.0F);
  EXPECT_FALSE(points.any_near(0.0F, 0.0F, 1e6F));
  points.add(0.0F, 0.0F);
  EXPECT_FALSE(points.any_near(float(test::kNan), 0.0F, 1e6F));
  EXPECT_TRUE(points.any_near(0.0F, 0.0F, 1e6F));
}

}  // namespace
}  // namespace srslam
