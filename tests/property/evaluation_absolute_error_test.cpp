#include <cmath>
#include <cstddef>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "srslam/evaluation/trajectory_error.hpp"
#include "support/random_trajectory.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

AteOptions aligned(Alignment alignment) {
  AteOptions options;
  options.alignment = alignment;
  return options;
}

TEST(AbsoluteErrorProperty, DoesNotDependOnEitherWorldFrame) {
  test::for_each_seed(100, [](test::Rng& rng) {
    const test::TrajectoryPair pair = test::random_trajectory_pair(rng);
    for (const Alignment alignment : {Alignment::kSE3, Alignment::kSim3}) {
      const AteOptions options = aligned(alignment);
      const AteResult base = absolute_trajectory_error(pair.reference, pair.estimate, options);
      ASSERT_TRUE(base.status.ok()) << base.status.reason;
      ASSERT_GT(base.translation_m.rmse, 1e-4);
      const AteResult reference_moved = absolute_trajectory_error(
          test::moved(rng.pose(10.0), pair.reference), pair.estimate, options);
      const AteResult estimate_moved = absolute_trajectory_error(
          pair.reference, test::moved(rng.pose(10.0), pair.estimate), options);
      test::expect_near(reference_moved.translation_m, base.translation_m, 1e-12);
      test::expect_near(estimate_moved.translation_m, base.translation_m, 1e-12);
      EXPECT_NEAR(reference_moved.scale, base.scale, 1e-12);
    }
  });
}

TEST(AbsoluteErrorProperty, StandsCoordinatesFarFromTheOrigin) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const test::TrajectoryPair pair = test::random_trajectory_pair(rng);
    const AteResult base = absolute_trajectory_error(pair.reference, pair.estimate);
    Pose far = rng.pose(1.0);
    far.translation() += Eigen::Vector3d(1e6, -1e6, 1e6);
    const AteResult result = absolute_trajectory_error(test::moved(far, pair.reference),
                                                       test::moved(far, pair.estimate));
    ASSERT_TRUE(result.status.ok());
    // Coordinates of 1e6 m are themselves rounded to 1e-10 m.
    test::expect_near(result.translation_m, base.translation_m, 1e-9);
    EXPECT_NEAR(result.T_reference_estimate.linear().determinant(), 1.0, 1e-12);
  });
}

TEST(AbsoluteErrorProperty, IdenticalTrajectoriesHaveNoError) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const Trajectory trajectory = test::random_trajectory_pair(rng).reference;
    EXPECT_EQ(absolute_trajectory_error(trajectory, trajectory, aligned(Alignment::kNone))
                  .translation_m.max,
              0.0);
    for (const Alignment alignment : {Alignment::kSE3, Alignment::kSim3}) {
      const AteResult result =
          absolute_trajectory_error(trajectory, trajectory, aligned(alignment));
      ASSERT_TRUE(result.status.ok());
      EXPECT_LT(result.translation_m.max, 1e-13);
      EXPECT_NEAR(result.scale, 1.0, 1e-14);
    }
  });
}

TEST(AbsoluteErrorProperty, StatisticsAreConsistent) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const test::TrajectoryPair pair =
        test::random_trajectory_pair(rng, 400, rng.uniform(1e-6, 1.0));
    const AteResult ate = absolute_trajectory_error(pair.reference, pair.estimate);
    ASSERT_TRUE(ate.status.ok());
    test::expect_consistent(ate.translation_m);
    EXPECT_EQ(ate.errors_m.size(), ate.num_matched);
  });
}

TEST(AbsoluteErrorProperty, MoreFreedomNeverGivesALargerError) {
  test::for_each_seed(100, [](test::Rng& rng) {
    test::TrajectoryPair pair = test::random_trajectory_pair(rng, 200, rng.uniform(1e-4, 2.0));
    // Also where the frames are close to each other, and nothing is to be gained.
    if (rng.coin())
      pair.estimate =
          test::moved(pair.reference[0].T_world_camera * pair.estimate[0].T_world_camera.inverse(),
                      pair.estimate);
    double previous_m = std::numeric_limits<double>::infinity();
    for (const Alignment alignment : {Alignment::kNone, Alignment::kSE3, Alignment::kSim3}) {
      const AteResult result =
          absolute_trajectory_error(pair.reference, pair.estimate, aligned(alignment));
      ASSERT_TRUE(result.status.ok());
      EXPECT_LE(result.translation_m.rmse, previous_m * (1 + 1e-13));
      previous_m = result.translation_m.rmse;
    }
  });
}

TEST(AbsoluteErrorProperty, Sim3RecoversTheScale) {
  test::for_each_seed(100, [](test::Rng& rng) {
    const Trajectory reference = test::random_trajectory_pair(rng).reference;
    const double scale = std::pow(10.0, rng.uniform(-3.0, 3.0));
    Trajectory estimate = test::moved(rng.pose(3.0), reference);
    for (StampedPose& pose : estimate) pose.T_world_camera.translation() /= scale;
    const AteResult result =
        absolute_trajectory_error(reference, estimate, aligned(Alignment::kSim3));
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_NEAR(result.scale / scale, 1.0, 1e-12);
    EXPECT_LT(result.translation_m.max, 1e-12);
  });
}

TEST(AbsoluteErrorProperty, CollinearPathsGetAProperRotation) {
  test::for_each_seed(200, [](test::Rng& rng) {
    const Eigen::Vector3d direction = rng.unit_vector3();
    const double length_m = std::pow(10.0, rng.uniform(-3.0, 4.0));
    const double across = rng.coin() ? 0.0 : 1e-6 * length_m;
    Trajectory reference;
    for (int i = 0; i < rng.uniform_int(3, 40); ++i) {
      StampedPose pose;
      pose.timestamp_s = i;
      pose.T_world_camera.translation() =
          rng.uniform(-1.0, 1.0) * length_m * direction + rng.vector3(-across, across);
      reference.push_back(pose);
    }
    if (reference.size() < 3) return;
    const Trajectory estimate = test::moved(rng.pose(10.0), reference);
    const AteResult result = absolute_trajectory_error(reference, estimate);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_TRUE(result.collinear);
    EXPECT_NEAR(result.T_reference_estimate.linear().determinant(), 1.0, 1e-12);
    EXPECT_LT(result.translation_m.rmse, 4 * across + 1e-12 * (length_m + 10.0));
  });
}

}  // namespace
}  // namespace srslam
