#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/evaluation/trajectory_error.hpp"
#include "support/constants.hpp"
#include "support/random_trajectory.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

std::vector<RpeOptions> rpe_variants() {
  std::vector<RpeOptions> variants;
  for (const RpeDefinition definition : {RpeDefinition::kMatchedPoses, RpeDefinition::kTumTool}) {
    for (const RpeDelta unit : {RpeDelta::kFrames, RpeDelta::kSeconds}) {
      RpeOptions options;
      options.definition = definition;
      options.unit = unit;
      variants.push_back(options);
    }
  }
  return variants;
}

TEST(RelativeErrorProperty, DoesNotDependOnEitherWorldFrame) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const test::TrajectoryPair pair = test::random_trajectory_pair(rng);
    for (const RpeOptions& options : rpe_variants()) {
      const RpeResult base = relative_pose_error(pair.reference, pair.estimate, options);
      ASSERT_TRUE(base.status.ok()) << base.status.reason;
      ASSERT_GT(base.translation_m.rmse, 1e-4);
      const RpeResult reference_moved =
          relative_pose_error(test::moved(rng.pose(10.0), pair.reference), pair.estimate, options);
      const RpeResult estimate_moved =
          relative_pose_error(pair.reference, test::moved(rng.pose(10.0), pair.estimate), options);
      test::expect_near(reference_moved.translation_m, base.translation_m, 1e-12);
      test::expect_near(estimate_moved.translation_m, base.translation_m, 1e-12);
      test::expect_near(reference_moved.rotation_deg, base.rotation_deg, 1e-11);
      test::expect_near(estimate_moved.rotation_deg, base.rotation_deg, 1e-11);

      Pose far = rng.pose(1.0);
      far.translation() += Eigen::Vector3d(1e6, -1e6, 1e6);
      const RpeResult far_away = relative_pose_error(test::moved(far, pair.reference),
                                                     test::moved(far, pair.estimate), options);
      test::expect_near(far_away.translation_m, base.translation_m, 1e-9);
      test::expect_near(far_away.rotation_deg, base.rotation_deg, 1e-11);
    }
  });
}

TEST(RelativeErrorProperty, IdenticalTrajectoriesHaveNoError) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const Trajectory trajectory = test::random_trajectory_pair(rng).reference;
    for (const RpeOptions& options : rpe_variants()) {
      const RpeResult result = relative_pose_error(trajectory, trajectory, options);
      ASSERT_TRUE(result.status.ok());
      EXPECT_LT(result.translation_m.max, 1e-13);
      EXPECT_LT(result.rotation_deg.max, 1e-11);
    }
  });
}

TEST(RelativeErrorProperty, StatisticsAreConsistent) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const test::TrajectoryPair pair =
        test::random_trajectory_pair(rng, 400, rng.uniform(1e-6, 1.0));
    for (const RpeOptions& options : rpe_variants()) {
      const RpeResult rpe = relative_pose_error(pair.reference, pair.estimate, options);
      ASSERT_TRUE(rpe.status.ok());
      test::expect_consistent(rpe.translation_m);
      test::expect_consistent(rpe.rotation_deg);
      EXPECT_EQ(rpe.pairs.size(), rpe.num_pairs);
    }
  });
}

// The default definition once more, from quaternions, one pair of poses after the other.
TEST(RelativeErrorProperty, AgreesWithQuaternionArithmetic) {
  test::for_each_seed(50, [](test::Rng& rng) {
    const test::TrajectoryPair pair = test::random_trajectory_pair(rng);
    const RpeDelta unit = rng.coin() ? RpeDelta::kFrames : RpeDelta::kSeconds;
    RpeOptions options;
    options.unit = unit;
    options.delta = unit == RpeDelta::kFrames ? rng.uniform_int(1, 10) : rng.uniform(0.1, 1.5);

    std::vector<const StampedPose*> partner(pair.estimate.size(), nullptr);
    for (const TrajectoryMatch& match : associate(pair.reference, pair.estimate).matches) {
      partner[match.estimate_index] = &pair.reference[match.reference_index];
    }
    std::vector<double> translations_m;
    std::vector<double> rotations_deg;
    for (std::size_t i = 0; i < pair.estimate.size(); ++i) {
      if (partner[i] == nullptr) continue;
      std::size_t best = i;
      double best_deviation = 1e300;
      for (std::size_t j = i + 1; j < pair.estimate.size(); ++j) {
        if (partner[j] == nullptr) continue;
        const double interval = unit == RpeDelta::kFrames
                                    ? static_cast<double>(j - i)
                                    : pair.estimate[j].timestamp_s - pair.estimate[i].timestamp_s;
        if (std::abs(interval - options.delta) < best_deviation) {
          best_deviation = std::abs(interval - options.delta);
          best = j;
        }
      }
      const double tolerance =
          unit == RpeDelta::kFrames ? 0.0 : options.relative_delta_tolerance * options.delta;
      if (best == i || best_deviation > tolerance) continue;
      if (partner[best]->timestamp_s <= partner[i]->timestamp_s) continue;
      const auto rotation_of = [](const StampedPose& pose) {
        return Eigen::Quaterniond(Eigen::Matrix3d(pose.T_world_camera.linear()));
      };
      const auto position_of = [](const StampedPose& pose) {
        return Eigen::Vector3d(pose.T_world_camera.translation());
      };
      const Eigen::Quaterniond reference_turn =
          rotation_of(*partner[i]).conjugate() * rotation_of(*partner[best]);
      const Eigen::Quaterniond estimate_turn =
          rotation_of(pair.estimate[i]).conjugate() * rotation_of(pair.estimate[best]);
      const Eigen::Vector3d reference_way =
          rotation_of(*partner[i]).conjugate() *
          (position_of(*partner[best]) - position_of(*partner[i]));
      const Eigen::Vector3d estimate_way =
          rotation_of(pair.estimate[i]).conjugate() *
          (position_of(pair.estimate[best]) - position_of(pair.estimate[i]));
      const Eigen::Quaterniond turn = reference_turn.conjugate() * estimate_turn;
      translations_m.push_back(
          (reference_turn.conjugate() * (estimate_way - reference_way)).norm());
      rotations_deg.push_back(2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w())) * 180.0 /
                              test::kPi);
    }
    const RpeResult result = relative_pose_error(pair.reference, pair.estimate, options);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    ASSERT_EQ(result.pairs.size(), translations_m.size());
    for (std::size_t i = 0; i < translations_m.size(); ++i) {
      EXPECT_NEAR(result.pairs[i].translation_m, translations_m[i], 1e-12);
      EXPECT_NEAR(result.pairs[i].rotation_deg, rotations_deg[i], 1e-10);
    }
  });
}

}  // namespace
}  // namespace srslam
