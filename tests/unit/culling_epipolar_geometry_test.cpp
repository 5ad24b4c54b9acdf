#include "srslam/culling/epipolar_geometry.hpp"

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

PinholeCamera epipolar_camera() {
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 520.0;
  camera.fy_px = 515.0;
  camera.cx_px = 318.0;
  camera.cy_px = 243.0;
  return camera;
}

PixelPair pair_of(const Eigen::Vector3d& point_m, const Pose& T_current_reference,
                  const Eigen::Vector3d& motion_m = Eigen::Vector3d::Zero()) {
  Eigen::Vector2d reference;
  Eigen::Vector2d current;
  EXPECT_TRUE(epipolar_camera().project(point_m, &reference));
  EXPECT_TRUE(epipolar_camera().project(T_current_reference * (point_m + motion_m), &current));
  return {reference.x(), reference.y(), current.x(), current.y()};
}

Pose moved_camera() {
  Pose T = Pose::Identity();
  T.linear() =
      Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.2, 1.0, -0.4).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(-0.08, 0.01, 0.02);
  return T;
}

/// Points of a room, of which a share moves by itself.
std::vector<PixelPair> room(test::Rng& rng, std::size_t n, double mover_share, double noise_px) {
  std::vector<PixelPair> pairs;
  for (std::size_t i = 0; i < n; ++i) {
    const double depth_m = rng.uniform(1.0, 5.0);
    const double x_m = rng.uniform(-0.5, 0.5) * depth_m;
    const double y_m = rng.uniform(-0.35, 0.35) * depth_m;
    const bool moves = double(i) < mover_share * double(n);
    PixelPair pair =
        pair_of({x_m, y_m, depth_m}, moved_camera(),
                moves ? Eigen::Vector3d(0.02, 0.1 * depth_m, 0.0) : Eigen::Vector3d::Zero());
    for (double* pixel :
         {&pair.reference_u_px, &pair.reference_v_px, &pair.current_u_px, &pair.current_v_px}) {
      *pixel += noise_px * rng.normal();
    }
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(SampsonDistance, OfASidewaysCameraIsTheRowsDifferenceOverRootTwo) {
  // A camera that moves along x sees every point in the same row: F = [[0 0 0] [0 0 -1] [0 1 0]].
  FundamentalMatrix F;
  F << 0, 0, 0, 0, 0, -1, 0, 1, 0;
  EXPECT_NEAR(sampson_distance_px(F, {100.0, 50.0, 130.0, 50.0}), 0.0, 1e-12);
  EXPECT_NEAR(sampson_distance_px(F, {100.0, 50.0, 130.0, 54.0}), 4.0 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(sampson_distance_px(F, {100.0, 50.0, 130.0, 46.0}), 4.0 / std::sqrt(2.0), 1e-12);
  EXPECT_EQ(sampson_distance_px(FundamentalMatrix::Zero(), {1.0, 2.0, 3.0, 4.0}), 0.0);
}

TEST(SampsonDistance, DoesNotDependOnScaleOrDirection) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const FundamentalMatrix F = fundamental_from_pose(rng.pose(0.3, 0.5), epipolar_camera());
    const PixelPair pair = {rng.uniform(0.0, 640.0), rng.uniform(0.0, 480.0),
                            rng.uniform(0.0, 640.0), rng.uniform(0.0, 480.0)};
    const double distance_px = sampson_distance_px(F, pair);
    EXPECT_NEAR(sampson_distance_px(-7.0 * F, pair), distance_px, 1e-9 * (1.0 + distance_px));
    const PixelPair swapped = {pair.current_u_px, pair.current_v_px, pair.reference_u_px,
                               pair.reference_v_px};
    EXPECT_NEAR(sampson_distance_px(F.transpose(), swapped), distance_px,
                1e-9 * (1.0 + distance_px));
  });
}

TEST(FundamentalFromPose, IsFulfilledByWhatStands) {
  test::for_each_seed(20, [](test::Rng& rng) {
    const FundamentalMatrix F = fundamental_from_pose(moved_camera(), epipolar_camera());
    for (const PixelPair& pair : room(rng, 50, 0.0, 0.0)) {
      EXPECT_LT(sampson_distance_px(F, pair), 1e-9);
    }
    int num_far = 0;
    for (const PixelPair& pair : room(rng, 50, 1.0, 0.0)) {
      if (sampson_distance_px(F, pair) > 3.0) ++num_far;
    }
    EXPECT_GT(num_far, 45) << "movers across the epipolar lines";
  });
  Pose turned = moved_camera();
  turned.translation().setZero();
  EXPECT_EQ(fundamental_from_pose(turned, epipolar_camera()).norm(), 0.0);
}

TEST(FundamentalFromPose, DoesNotSeeMotionAlongEpipolarLines) {
  // Known and stated: what moves as the camera does is not told from another depth.
  Pose sideways = Pose::Identity();
  sideways.translation().x() = -0.1;
  const FundamentalMatrix F = fundamental_from_pose(sideways, epipolar_camera());
  EXPECT_LT(sampson_distance_px(F, pair_of({0.1, 0.2, 2.0}, sideways, {0.3, 0.0, 0.0})), 1e-9);
  EXPECT_GT(sampson_distance_px(F, pair_of({0.1, 0.2, 2.0}, sideways, {0.0, 0.1, 0.0})), 10.0);
}

TEST(EstimateFundamental, FindsTheGeometryAmongMovers) {
  test::for_each_seed(10, [](test::Rng& rng) {
    const std::vector<PixelPair> pairs = room(rng, 600, 0.3, 0.2);
    FundamentalWorkspace workspace;
    const FundamentalResult result = estimate_fundamental(pairs, {}, workspace);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_NEAR(result.F.norm(), 1.0, 1e-12);
    EXPECT_NEAR(result.F.determinant(), 0.0, 1e-12);
    EXPECT_GT(result.inlier_share, 0.68);
    EXPECT_LT(result.inlier_share, 0.8);
    for (const PixelPair& pair : room(rng, 100, 0.0, 0.0)) {
      EXPECT_LT(sampson_distance_px(result.F, pair), 0.7);
    }
  });
}

TEST(EstimateFundamental, IsExactWithoutNoise) {
  test::Rng rng(3);
  FundamentalWorkspace workspace;
  const FundamentalResult result = estimate_fundamental(room(rng, 60, 0.0, 0.0), {}, workspace);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_inliers, 60);
  for (const PixelPair& pair : room(rng, 100, 0.0, 0.0)) {
    EXPECT_LT(sampson_distance_px(result.F, pair), 1e-5);
  }
}

TEST(EstimateFundamental, GivesTheSameBitsAgain) {
  test::Rng rng(4);
  const std::vector<PixelPair> pairs = room(rng, 200, 0.3, 0.3);
  FundamentalWorkspace workspace;
  const FundamentalResult first = estimate_fundamental(pairs, {}, workspace);
  const FundamentalResult second = estimate_fundamental(pairs, {}, workspace);
  EXPECT_EQ(first.F, second.F);
  EXPECT_EQ(first.num_samples, second.num_samples);
}

TEST(EstimateFundamental, RefusesWhatDoesNotDetermineIt) {
  FundamentalWorkspace workspace;
  test::Rng rng(5);
  const auto code_of = [&](const std::vector<PixelPair>& pairs,
                           const FundamentalOptions& options = {}) {
    const FundamentalResult result = estimate_fundamental(pairs, options, workspace);
    EXPECT_TRUE(result.F.allFinite());
    return result.status.code;
  };
  EXPECT_EQ(code_of({}), StatusCode::kInsufficientData);
  EXPECT_EQ(code_of(room(rng, 19, 0.0, 0.0)), StatusCode::kInsufficientData);
  // All pairs the same, and pairs at random.
  EXPECT_EQ(code_of(std::vector<PixelPair>(50, PixelPair{1.0, 2.0, 3.0, 4.0})),
            StatusCode::kDegenerate);
  std::vector<PixelPair> random_pairs;
  for (int i = 0; i < 200; ++i) {
    PixelPair pair;
    pair.reference_u_px = rng.uniform(0.0, 640.0);
    pair.reference_v_px = rng.uniform(0.0, 480.0);
    pair.current_u_px = rng.uniform(0.0, 640.0);
    pair.current_v_px = rng.uniform(0.0, 480.0);
    random_pairs.push_back(pair);
  }
  EXPECT_EQ(code_of(random_pairs), StatusCode::kDegenerate);
  random_pairs[7].current_u_px = test::kNan;
  EXPECT_EQ(code_of(random_pairs), StatusCode::kInvalidArgument);
  FundamentalOptions bad[7];
  bad[0].inlier_px = 0.0;
  bad[1].min_pairs = 7;
  bad[2].min_inlier_share = 1.5;
  bad[3].max_samples = 0;
  bad[4].sample_confidence = 1.0;
  bad[5].inlier_px = test::kInf;
  bad[6].min_inlier_share = test::kNan;
  for (const FundamentalOptions& options : bad) {
    EXPECT_EQ(code_of(room(rng, 50, 0.0, 0.0), options), StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace srslam
