#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/bundle_adjustment.hpp"
#include "pipeline/keyframe_decision.hpp"
#include "pipeline/pose_solver.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/pipeline/pipeline_options.hpp"
#include "support/numeric_jacobian.hpp"
#include "support/tracking_frames.hpp"

namespace srslam::detail {
namespace {

using test::for_each_seed;
using test::Rng;

const TrackingCamera& camera() {
  static const TrackingCamera instance = test::tracking_camera(test::ideal_camera());
  return instance;
}

Measurement measure(const Eigen::Vector3d& point_camera_m, bool with_depth) {
  const Eigen::Vector3d projected = camera().project(point_camera_m);
  Measurement measurement;
  measurement.pixel = projected.head<2>();
  if (with_depth) {
    measurement.disparity_px = projected.z();
    measurement.depth_m = point_camera_m.z();
  }
  return measurement;
}

/// A point that the camera sees at a random pixel.
Eigen::Vector3d point_in_view(Rng& rng) {
  return camera().unproject({rng.uniform(0.0, 640.0), rng.uniform(0.0, 480.0)},
                            rng.uniform(0.8, 4.0));
}

std::vector<PoseObservation> exact_observations(Rng& rng, const Pose& T_world_camera, int count,
                                                double share_with_depth) {
  std::vector<PoseObservation> observations;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d point_camera_m = point_in_view(rng);
    PoseObservation observation;
    observation.position_m = T_world_camera * point_camera_m;
    observation.measurement = measure(point_camera_m, rng.uniform(0.0, 1.0) < share_with_depth);
    observation.inverse_sigma = 1.0 / std::pow(1.2, rng.uniform_int(0, 7));
    observations.push_back(observation);
  }
  return observations;
}

/// Gaussian noise of the stated standard deviation.
void add_noise(Rng& rng, double factor, std::vector<PoseObservation>* observations) {
  for (PoseObservation& observation : *observations) {
    const double sigma = factor / observation.inverse_sigma;
    observation.measurement.pixel.x() += sigma * rng.normal();
    observation.measurement.pixel.y() += sigma * rng.normal();
    if (observation.measurement.has_depth()) {
      observation.measurement.disparity_px =
          std::max(0.5, observation.measurement.disparity_px + sigma * rng.normal());
    }
  }
}

Pose perturbed(Rng& rng, const Pose& pose, double max_m, double max_rad) {
  Vector6 tangent;
  tangent << rng.vector3(-max_m, max_m), rng.vector3(-max_rad, max_rad);
  return pose * se3_exp(tangent);
}

Vector6 error(const Pose& estimate, const Pose& truth) {
  return se3_log(truth.inverse() * estimate);
}

/// Whitened residual, written down independently of the solver.
Eigen::Vector3d residual(const PoseObservation& observation, const Pose& T_world_camera) {
  const Eigen::Vector3d p = T_world_camera.inverse() * observation.position_m;
  const Measurement& m = observation.measurement;
  Eigen::Vector3d r(520.0 * p.x() / p.z() + 319.0 - m.pixel.x(),
                    525.0 * p.y() / p.z() + 241.0 - m.pixel.y(),
                    m.has_depth() ? 0.0775 * 520.0 / p.z() - m.disparity_px : 0.0);
  return r * observation.inverse_sigma;
}

double gate_of(const PoseObservation& observation) {
  return observation.measurement.has_depth() ? 7.815 : 5.991;
}

TEST(SolvePose, RecoversThePoseFromExactObservations) {
  for (const double share_with_depth : {1.0, 0.5, 0.0}) {
    for_each_seed(25, [&](Rng& rng) {
      const Pose truth = rng.pose(3.0);
      std::vector<PoseObservation> observations =
          exact_observations(rng, truth, 60, share_with_depth);
      const PoseSolution solution =
          solve_pose(camera(), perturbed(rng, truth, 0.05, 0.05), &observations);
      ASSERT_TRUE(solution.status.ok()) << solution.status.reason;
      EXPECT_EQ(solution.num_inliers, 60);
      EXPECT_LT(error(solution.T_world_camera, truth).norm(), 1e-7);
    });
  }
}

TEST(SolvePose, ErrorIsAsLargeAsTheInformationSays) {
  double sum = 0.0;
  int count = 0;
  for_each_seed(40, [&](Rng& rng) {
    const Pose truth = rng.pose(3.0);
    std::vector<PoseObservation> observations = exact_observations(rng, truth, 300, 0.7);
    add_noise(rng, 1.0, &observations);
    const PoseSolution solution =
        solve_pose(camera(), perturbed(rng, truth, 0.05, 0.05), &observations);
    ASSERT_TRUE(solution.status.ok()) << solution.status.reason;
    // The gates are 95 % quantiles.
    EXPECT_GT(solution.num_inliers, 265);
    EXPECT_LT(solution.num_inliers, 300);
    const Vector6 e = error(solution.T_world_camera, truth);
    const double mahalanobis = e.dot(solution.information * e);
    EXPECT_LT(mahalanobis, 33.0);  // χ² of six degrees of freedom: one in 10^5
    sum += mahalanobis;
    ++count;
  });
  if (count == 40) {
    // Mean 6 and standard deviation sqrt(12 / 40) when the model is right.
    EXPECT_GT(sum / count, 3.5);
    EXPECT_LT(sum / count, 8.5);
  }
}

TEST(SolvePose, WithstandsThirtyPercentOutliers) {
  for (const double share_with_depth : {1.0, 0.0}) {
    for_each_seed(25, [&](Rng& rng) {
      const Pose truth = rng.pose(3.0);
      std::vector<PoseObservation> observations =
          exact_observations(rng, truth, 200, share_with_depth);
      add_noise(rng, 0.5, &observations);
      for (std::size_t i = 0; i < 60; ++i) {
        observations[i].measurement = measure(point_in_view(rng), share_with_depth > 0.5);
      }
      const PoseSolution solution =
          solve_pose(camera(), perturbed(rng, truth, 0.03, 0.03), &observations);
      ASSERT_TRUE(solution.status.ok()) << solution.status.reason;
      const Vector6 e = error(solution.T_world_camera, truth);
      EXPECT_LT(e.head<3>().norm(), 0.01);
      EXPECT_LT(e.tail<3>().norm(), 0.005);
      int num_outliers_kept = 0;
      int num_inliers_dropped = 0;
      for (std::size_t i = 0; i < observations.size(); ++i) {
        if (i < 60 && observations[i].inlier) ++num_outliers_kept;
        if (i >= 60 && !observations[i].inlier) ++num_inliers_dropped;
      }
      EXPECT_LE(num_outliers_kept, 2);
      EXPECT_LE(num_inliers_dropped, 2);
    });
  }
}

TEST(SolvePose, FlagsAreTheGateAtTheSolution) {
  for_each_seed(20, [](Rng& rng) {
    const Pose truth = rng.pose(3.0);
    std::vector<PoseObservation> observations = exact_observations(rng, truth, 150, 0.5);
    add_noise(rng, 1.3, &observations);
    for (std::size_t i = 0; i < 20; ++i)
      observations[i].measurement = measure(point_in_view(rng), true);
    for (PoseObservation& observation : observations) observation.inlier = rng.coin();  // ignored
    const PoseSolution solution =
        solve_pose(camera(), perturbed(rng, truth, 0.03, 0.03), &observations);
    ASSERT_TRUE(solution.status.ok()) << solution.status.reason;
    int num_inliers = 0;
    for (const PoseObservation& observation : observations) {
      num_inliers += observation.inlier ? 1 : 0;
      const double squared = residual(observation, solution.T_world_camera).squaredNorm();
      if (std::abs(squared - gate_of(observation)) < 1e-6) continue;
      EXPECT_EQ(observation.inlier, squared < gate_of(observation)) << squared;
    }
    EXPECT_EQ(num_inliers, solution.num_inliers);
  });
}

TEST(SolvePose, GateDependsOnWhetherThereIsDepth) {
  // sqrt(5.991) = 2.448 and sqrt(7.815) = 2.796 standard deviations: 2.62 of them are too many
  // without depth and few enough with it. The rest hold the pose in place.
  Rng rng(7);
  const Pose truth = rng.pose(1.0);
  for (const bool with_depth : {false, true}) {
    for (const double scale : {1.0, 2.0}) {
      std::vector<PoseObservation> observations = exact_observations(rng, truth, 1000, 1.0);
      const Eigen::Vector3d point(0.05, -0.1, 2.0);
      PoseObservation odd;
      odd.position_m = truth * point;
      odd.measurement = measure(point, with_depth);
      odd.inverse_sigma = 1.0 / scale;
      odd.measurement.pixel.x() += 2.62 * scale;
      observations.push_back(odd);
      const PoseSolution solution = solve_pose(camera(), truth, &observations);
      ASSERT_TRUE(solution.status.ok());
      EXPECT_EQ(observations.back().inlier, with_depth) << scale;
      EXPECT_EQ(solution.num_inliers, with_depth ? 1001 : 1000);

      observations.back().measurement.pixel.x() += (2.95 - 2.62) * scale;
      EXPECT_TRUE(solve_pose(camera(), truth, &observations).status.ok());
      EXPECT_FALSE(observations.back().inlier);
      observations.back().measurement.pixel.x() -= (2.95 - 2.3) * scale;
      EXPECT_TRUE(solve_pose(camera(), truth, &observations).status.ok());
      EXPECT_TRUE(observations.back().inlier);
    }
  }
}

TEST(SolvePose, InformationIsThatOfNumericJacobians) {
  for_each_seed(10, [](Rng& rng) {
    const Pose truth = rng.pose(3.0);
    std::vector<PoseObservation> observations = exact_observations(rng, truth, 40, 0.5);
    const PoseSolution solution =
        solve_pose(camera(), perturbed(rng, truth, 0.02, 0.02), &observations);
    ASSERT_TRUE(solution.status.ok());
    Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
    for (const PoseObservation& observation : observations) {
      const auto moved = [&](const Eigen::Matrix<double, 6, 1>& tangent) {
        return residual(observation, solution.T_world_camera * se3_exp(tangent));
      };
      const Eigen::Matrix<double, 3, 6> J = test::numeric_jacobian(
          moved, Eigen::Matrix<double, 6, 1>(Eigen::Matrix<double, 6, 1>::Zero()), 1e-3);
      expected += J.transpose() * J;
    }
    EXPECT_TRUE(test::matrices_near(solution.information, expected, 1e-6));
  });
}

TEST(SolvePose, GradientVanishesAtTheSolution) {
  for_each_seed(20, [](Rng& rng) {
    const Pose truth = rng.pose(3.0);
    std::vector<PoseObservation> observations = exact_observations(rng, truth, 200, 0.6);
    add_noise(rng, 0.6, &observations);  // hardly any near the gate: the inliers stay the same
    const PoseSolution solution =
        solve_pose(camera(), perturbed(rng, truth, 0.03, 0.03), &observations);
    ASSERT_TRUE(solution.status.ok());
    const auto half_cost = [&](const Eigen::Matrix<double, 6, 1>& tangent) {
      double sum = 0.0;
      for (const PoseObservation& observation : observations) {
        if (!observation.inlier) continue;
        sum +=
            0.5 * residual(observation, solution.T_world_camera * se3_exp(tangent)).squaredNorm();
      }
      return Eigen::Matrix<double, 1, 1>(sum);
    };
    const Eigen::Matrix<double, 6, 1> zero = Eigen::Matrix<double, 6, 1>::Zero();
    const Eigen::Matrix<double, 1, 6> gradient = test::numeric_jacobian(half_cost, zero, 1e-4);
    // What another Newton step would gain, as a share of the cost.
    const Eigen::Matrix<double, 6, 6> information = solution.information;
    const double gain = 0.5 * (gradient * information.inverse() * gradient.transpose()).value();
    EXPECT_LT(gain, 1e-6 * half_cost(zero).value());
  });
}

TEST(SolvePose, TooFewUsableObservations) {
  Rng rng(3);
  const Pose guess = rng.pose(1.0);
  for (const int count : {0, 1, 2}) {
    std::vector<PoseObservation> observations = exact_observations(rng, guess, count, 1.0);
    const PoseSolution solution = solve_pose(camera(), guess, &observations);
    EXPECT_EQ(solution.status.code, StatusCode::kInsufficientData) << count;
    EXPECT_EQ(solution.num_inliers, 0);
    EXPECT_TRUE(solution.T_world_camera.matrix().allFinite());
  }
  std::vector<PoseObservation> behind = exact_observations(rng, guess, 50, 1.0);
  for (PoseObservation& observation : behind) {
    observation.position_m = guess * Eigen::Vector3d(rng.uniform(-1, 1), 0.2, rng.uniform(-4, 0));
  }
  const PoseSolution solution = solve_pose(camera(), guess, &behind);
  EXPECT_EQ(solution.status.code, StatusCode::kInsufficientData);
  EXPECT_TRUE(solution.T_world_camera.matrix().allFinite());

  // Enough to start with, but nothing agrees.
  std::vector<PoseObservation> random = exact_observations(rng, guess, 6, 1.0);
  for (PoseObservation& observation : random)
    observation.measurement = measure(point_in_view(rng), true);
  const PoseSolution unexplained = solve_pose(camera(), guess, &random);
  EXPECT_TRUE(unexplained.T_world_camera.matrix().allFinite());
  EXPECT_EQ(unexplained.status.ok(), unexplained.num_inliers >= 3);
}

TEST(SolvePose, PointsThatDetermineNoPoseAreDegenerate) {
  for_each_seed(20, [](Rng& rng) {
    const Pose truth = rng.pose(1.0);
    const Eigen::Vector3d start(rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4), 2.0);
    const Eigen::Vector3d direction = rng.vector3(-0.1, 0.1);
    for (const bool with_depth : {true, false}) {
      for (const bool collinear : {true, false}) {
        std::vector<PoseObservation> observations;
        for (int i = 0; i < 30; ++i) {
          Eigen::Vector3d point = start;
          if (collinear) point += i * 0.2 * direction;
          PoseObservation observation;
          observation.position_m = truth * point;
          observation.measurement = measure(point, with_depth);
          observations.push_back(observation);
        }
        const PoseSolution solution =
            solve_pose(camera(), perturbed(rng, truth, 0.01, 0.01), &observations);
        EXPECT_EQ(to_string(solution.status.code), std::string("degenerate"))
            << solution.status.reason << (collinear ? " collinear" : " identical")
            << (with_depth ? " with depth" : "");
        EXPECT_TRUE(solution.T_world_camera.matrix().allFinite());
      }
    }
  });
}

TEST(SolvePose, NanNeverComesOut) {
  Rng rng(11);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Pose truth = rng.pose(1.0);
  std::vector<PoseObservation> observations = exact_observations(rng, truth, 50, 0.5);
  Pose bad_guess = truth;
  bad_guess.translation().x() = nan;
  EXPECT_FALSE(solve_pose(camera(), bad_guess, &observations).status.ok());

  observations[3].position_m.y() = nan;
  observations[9].measurement.pixel.x() = nan;
  const PoseSolution solution = solve_pose(camera(), truth, &observations);
  EXPECT_TRUE(solution.T_world_camera.matrix().allFinite());
  if (solution.status.ok()) {
    EXPECT_LT(error(solution.T_world_camera, truth).norm(), 1e-6);
    EXPECT_FALSE(observations[3].inlier);
    EXPECT_FALSE(observations[9].inlier);
  }
}

// ---------------------------------------------------------------------------------------------

struct BundleScene {
  BundleProblem problem;  ///< perturbed
  std::vector<Pose> true_poses;
  std::vector<Eigen::Vector3d> true_points;
};

BundleScene make_bundle(Rng& rng, int num_views, int num_points, int num_fixed,
                        std::size_t min_views_per_point = 3) {
  BundleScene scene;
  for (int i = 0; i < num_views; ++i) {
    Vector6 tangent;
    tangent << 0.12 * i, 0.02 * std::sin(i), 0.01 * i, 0.01 * i, -0.03 * i, 0.02 * std::cos(i);
    scene.true_poses.push_back(se3_exp(tangent));
    BundleProblem::View view;
    view.keyframe = 10 + i;
    view.fixed = i < num_fixed;
    view.T_world_camera =
        view.fixed ? scene.true_poses.back() : perturbed(rng, scene.true_poses.back(), 0.02, 0.01);
    scene.problem.views.push_back(view);
  }
  while (static_cast<int>(scene.true_points.size()) < num_points) {
    const Eigen::Vector3d point(rng.uniform(-1.2, 1.8), rng.uniform(-0.8, 0.8),
                                rng.uniform(1.5, 4.0));
    const auto landmark = static_cast<std::int32_t>(scene.true_points.size());
    std::vector<BundleProblem::Edge> edges;
    for (int i = 0; i < num_views; ++i) {
      const Eigen::Vector3d in_camera =
          scene.true_poses[static_cast<std::size_t>(i)].inverse() * point;
      BundleProblem::Edge edge;
      edge.view = i;
      edge.landmark = landmark;
      edge.measurement = measure(in_camera, rng.uniform(0.0, 1.0) < 0.7);
      if (!camera().in_image(edge.measurement.pixel.x(), edge.measurement.pixel.y())) continue;
      edge.inverse_sigma = 1.0 / std::pow(1.2, rng.uniform_int(0, 4));
      edges.push_back(edge);
    }
    if (edges.size() < min_views_per_point) continue;
    scene.true_points.push_back(point);
    scene.problem.edges.insert(scene.problem.edges.end(), edges.begin(), edges.end());
    scene.problem.landmarks.push_back({{landmark, 1}, point + rng.vector3(-0.02, 0.02)});
  }
  return scene;
}

bool same_bits(const BundleProblem& a, const BundleProblem& b) {
  bool same = a.views.size() == b.views.size() && a.landmarks.size() == b.landmarks.size() &&
              a.edges.size() == b.edges.size();
  for (std::size_t i = 0; same && i < a.views.size(); ++i) {
    same = a.views[i].T_world_camera.matrix() == b.views[i].T_world_camera.matrix();
  }
  for (std::size_t i = 0; same && i < a.landmarks.size(); ++i) {
    same = a.landmarks[i].position_m == b.landmarks[i].position_m;
  }
  for (std::size_t i = 0; same && i < a.edges.size(); ++i) {
    same = a.edges[i].inlier == b.edges[i].inlier;
  }
  return same;
}

void expect_truth(const BundleScene& scene) {
  for (std::size_t i = 0; i < scene.problem.views.size(); ++i) {
    const Vector6 e = error(scene.problem.views[i].T_world_camera, scene.true_poses[i]);
    EXPECT_LT(e.norm(), 1e-4) << "view " << i;
  }
  for (std::size_t i = 0; i < scene.problem.landmarks.size(); ++i) {
    EXPECT_LT((scene.problem.landmarks[i].position_m - scene.true_points[i]).norm(), 1e-3)
        << "landmark " << i;
  }
}

TEST(SolveBundle, ConvergesBackToThePerturbedScene) {
  for_each_seed(5, [](Rng& rng) {
    BundleScene scene = make_bundle(rng, 7, 150, 1);
    solve_bundle(camera(), 10, &scene.problem);
    ASSERT_TRUE(scene.problem.usable);
    EXPECT_GT(scene.problem.num_iterations, 0);
    expect_truth(scene);
    for (const BundleProblem::Edge& edge : scene.problem.edges) EXPECT_TRUE(edge.inlier);
  });
}

TEST(SolveBundle, FlagsOutliersAndRecoversWithoutThem) {
  for_each_seed(5, [](Rng& rng) {
    BundleScene scene = make_bundle(rng, 7, 150, 1, 6);
    std::vector<bool> is_outlier(scene.problem.edges.size(), false);
    for (std::size_t i = 0; i < is_outlier.size(); i += 40) {
      is_outlier[i] = true;
      scene.problem.edges[i].measurement.pixel.x() += rng.coin() ? 35.0 : -35.0;
    }
    solve_bundle(camera(), 15, &scene.problem);
    ASSERT_TRUE(scene.problem.usable);
    // A good edge may fail beside an outlier of the same point, an outlier never passes.
    int num_good_dropped = 0;
    for (std::size_t i = 0; i < is_outlier.size(); ++i) {
      const bool inlier = scene.problem.edges[i].inlier;
      if (is_outlier[i]) {
        EXPECT_FALSE(inlier) << i;
      } else if (!inlier) {
        ++num_good_dropped;
      }
    }
    EXPECT_LE(num_good_dropped, static_cast<int>(is_outlier.size() / 100));
    // Without what it flagged, as the mapper goes on, nothing is left of the outliers' pull.
    std::vector<BundleProblem::Edge>& edges = scene.problem.edges;
    edges.erase(std::remove_if(edges.begin(), edges.end(),
                               [](const BundleProblem::Edge& edge) { return !edge.inlier; }),
                edges.end());
    solve_bundle(camera(), 15, &scene.problem);
    ASSERT_TRUE(scene.problem.usable);
    expect_truth(scene);
  });
}

TEST(SolveBundle, LeavesFixedViewsInPlace) {
  Rng rng(5);
  BundleScene scene = make_bundle(rng, 6, 100, 3);
  const BundleProblem before = scene.problem;
  solve_bundle(camera(), 10, &scene.problem);
  ASSERT_TRUE(scene.problem.usable);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.problem.views[i].T_world_camera.matrix(),
              before.views[i].T_world_camera.matrix());
  }
  for (std::size_t i = 3; i < 6; ++i) {
    EXPECT_NE(scene.problem.views[i].T_world_camera.matrix(),
              before.views[i].T_world_camera.matrix());
  }
  expect_truth(scene);
}

TEST(SolveBundle, OneFixedViewHoldsTheWholeScene) {
  // The same scene elsewhere gives the same solution there.
  Rng rng(6);
  const Pose T_other_world = rng.pose(4.0);
  Rng rng_a(9);
  Rng rng_b(9);
  BundleScene here = make_bundle(rng_a, 5, 80, 1);
  BundleScene there = make_bundle(rng_b, 5, 80, 1);
  for (BundleProblem::View& view : there.problem.views) {
    view.T_world_camera = T_other_world * view.T_world_camera;
  }
  for (BundleProblem::Landmark& landmark : there.problem.landmarks) {
    landmark.position_m = T_other_world * landmark.position_m;
  }
  solve_bundle(camera(), 10, &here.problem);
  solve_bundle(camera(), 10, &there.problem);
  ASSERT_TRUE(here.problem.usable && there.problem.usable);
  for (std::size_t i = 0; i < here.problem.views.size(); ++i) {
    EXPECT_LT(error(there.problem.views[i].T_world_camera,
                    T_other_world * here.problem.views[i].T_world_camera)
                  .norm(),
              1e-5);
  }
}

TEST(SolveBundle, GivesTheSameBitsTwice) {
  Rng rng(8);
  BundleScene scene = make_bundle(rng, 8, 200, 2);
  for (BundleProblem::Edge& edge : scene.problem.edges) {
    edge.measurement.pixel += Eigen::Vector2d(rng.normal(), rng.normal());
  }
  BundleProblem first = scene.problem;
  BundleProblem second = scene.problem;
  solve_bundle(camera(), 5, &first);
  solve_bundle(camera(), 5, &second);
  ASSERT_TRUE(first.usable);
  EXPECT_TRUE(same_bits(first, second));
  EXPECT_FALSE(same_bits(first, scene.problem));
}

TEST(SolveBundle, UnusableProblemKeepsItsInitialValues) {
  Rng rng(4);
  BundleScene scene = make_bundle(rng, 5, 60, 1);
  scene.problem.landmarks[7].position_m = {0.1, 0.1, -2.0};  // behind every camera
  const BundleProblem before = scene.problem;
  testing::internal::CaptureStderr();
  solve_bundle(camera(), 5, &scene.problem);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // Ceres must not talk either
  EXPECT_FALSE(scene.problem.usable);
  EXPECT_TRUE(same_bits(scene.problem, before));

  scene.problem.landmarks[7].position_m.x() = std::numeric_limits<double>::quiet_NaN();
  testing::internal::CaptureStderr();
  solve_bundle(camera(), 5, &scene.problem);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(scene.problem.usable);

  BundleProblem empty;
  solve_bundle(camera(), 5, &empty);
  EXPECT_TRUE(empty.views.empty() && empty.landmarks.empty() && empty.edges.empty());
}

// ---------------------------------------------------------------------------------------------

KeyframeEvidence comfortable() {
  KeyframeEvidence evidence;
  evidence.frames_since_last = 5;
  evidence.mapper_idle = true;
  evidence.num_inliers = 100;
  evidence.num_tracked_well_observed = 80;
  evidence.num_reference_points = 100;
  evidence.num_tracked_close = 200;
  evidence.num_untracked_close = 0;
  evidence.num_keyframes = 5;
  return evidence;
}

TEST(KeyframeDecision, TruthTable) {
  struct Case {
    const char* what;
    std::function<void(KeyframeEvidence*, KeyframeOptions*)> change;
    bool insert;
    const char* reason;
  };
  const char* const kWell = "reference still well tracked";
  const char* const kFew = "too few inliers to build on";
  const char* const kBusy = "wanted, but the mapper is busy";
  const char* const kWeaker = "tracking weaker than the reference";
  const char* const kMuchWeaker = "tracking much weaker than the reference";
  const char* const kClose = "few close points tracked, more in view";
  using E = KeyframeEvidence;
  using O = KeyframeOptions;
  const std::vector<Case> cases = {
      {"comfortable", [](E*, O*) {}, false, kWell},
      {"at the ratio", [](E* e, O*) { e->num_tracked_well_observed = 75; }, false, kWell},
      {"below the ratio", [](E* e, O*) { e->num_tracked_well_observed = 74; }, true, kWeaker},
      {"long ago alone", [](E* e, O*) { e->frames_since_last = 500; }, false, kWell},
      {"busy",
       [](E* e, O*) {
         e->num_tracked_well_observed = 74;
         e->mapper_idle = false;
       },
       false, kBusy},
      {"busy, one frame short of long ago",
       [](E* e, O*) {
         e->num_tracked_well_observed = 74;
         e->mapper_idle = false;
         e->frames_since_last = 29;
       },
       false, kBusy},
      {"busy, but long ago",
       [](E* e, O*) {
         e->num_tracked_well_observed = 74;
         e->mapper_idle = false;
         e->frames_since_last = 30;
       },
       true, kWeaker},
      {"idle, but too soon",
       [](E* e, O* o) {
         e->num_tracked_well_observed = 74;
         o->min_frames = 6;
       },
       false, kBusy},
      {"idle and just late enough",
       [](E* e, O* o) {
         e->num_tracked_well_observed = 74;
         o->min_frames = 5;
       },
       true, kWeaker},
      {"at the weak ratio, busy",
       [](E* e, O*) {
         e->num_tracked_well_observed = 25;
         e->mapper_idle = false;
       },
       false, kBusy},
      {"below the weak ratio, busy",
       [](E* e, O*) {
         e->num_tracked_well_observed = 24;
         e->mapper_idle = false;
       },
       true, kMuchWeaker},
      {"close points",
       [](E* e, O*) {
         e->num_tracked_close = 99;
         e->num_untracked_close = 71;
         e->mapper_idle = false;
       },
       true, kClose},
      {"enough close points tracked",
       [](E* e, O*) {
         e->num_tracked_close = 100;
         e->num_untracked_close = 71;
       },
       false, kWell},
      {"few more in view",
       [](E* e, O*) {
         e->num_tracked_close = 99;
         e->num_untracked_close = 70;
       },
       false, kWell},
      {"young map, above its ratio",
       [](E* e, O*) {
         e->num_keyframes = 1;
         e->num_tracked_well_observed = 40;
       },
       false, kWell},
      {"young map, below its ratio",
       [](E* e, O*) {
         e->num_keyframes = 1;
         e->num_tracked_well_observed = 39;
       },
       true, kWeaker},
      {"two keyframes are not young",
       [](E* e, O*) {
         e->num_keyframes = 2;
         e->num_tracked_well_observed = 40;
       },
       true, kWeaker},
      {"just enough inliers",
       [](E* e, O*) {
         e->num_inliers = 16;
         e->num_tracked_well_observed = 10;
       },
       true, kMuchWeaker},
      {"too few inliers",
       [](E* e, O*) {
         e->num_inliers = 15;
         e->num_tracked_well_observed = 10;
         e->num_tracked_close = 0;
         e->num_untracked_close = 500;
         e->frames_since_last = 100;
       },
       false, kFew},
  };
  for (const Case& test_case : cases) {
    KeyframeEvidence evidence = comfortable();
    KeyframeOptions options;
    test_case.change(&evidence, &options);
    const KeyframeDecision decision = decide_keyframe(evidence, options, 15);
    EXPECT_EQ(decision.insert, test_case.insert) << test_case.what;
    EXPECT_STREQ(decision.reason, test_case.reason) << test_case.what;
  }
}

TEST(PipelineOptions, DefaultsAndLimitsAreValid) {
  EXPECT_TRUE(PipelineOptions{}.validate().ok());
  PipelineOptions options;
  options.features = {50, 1, 1.05, 1, 1};
  options.tracking.min_inliers = 4;
  options.tracking.min_depth_m = 0.0;
  options.keyframes.max_frames = 1;
  options.mapping = {2, 0, 1, 3, 1, 1.0};
  options.num_threads = 1;
  EXPECT_TRUE(options.validate().ok()) << options.validate().reason;
}

TEST(PipelineOptions, EveryValueOutsideItsDomainIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  using O = PipelineOptions;
  const std::vector<std::pair<const char*, std::function<void(O*)>>> cases = {
      {"num_features", [](O* o) { o->features.num_features = 49; }},
      {"num_features", [](O* o) { o->features.num_features = 20001; }},
      {"num_levels", [](O* o) { o->features.num_levels = 0; }},
      {"num_levels", [](O* o) { o->features.num_levels = 13; }},
      {"scale_factor", [](O* o) { o->features.scale_factor = 1.0; }},
      {"scale_factor", [](O* o) { o->features.scale_factor = 2.1; }},
      {"scale_factor", [=](O* o) { o->features.scale_factor = nan; }},
      {"fast_threshold", [](O* o) { o->features.fast_threshold = 0; }},
      {"fast_threshold", [](O* o) { o->features.fast_threshold = 256; }},
      {"min_fast_threshold", [](O* o) { o->features.min_fast_threshold = 0; }},
      {"min_fast_threshold", [](O* o) { o->features.min_fast_threshold = 21; }},
      {"min_inliers", [](O* o) { o->tracking.min_inliers = 3; }},
      {"min_relocalized_inliers", [](O* o) { o->tracking.min_relocalized_inliers = 14; }},
      {"min_initial_points", [](O* o) { o->tracking.min_initial_points = 14; }},
      {"depth range", [](O* o) { o->tracking.min_depth_m = -0.1; }},
      {"depth range", [](O* o) { o->tracking.max_depth_m = 0.1; }},
      {"depth range", [=](O* o) { o->tracking.max_depth_m = infinity; }},
      {"depth range", [=](O* o) { o->tracking.min_depth_m = nan; }},
      {"close_depth_m", [](O* o) { o->tracking.close_depth_m = 0.0; }},
      {"close_depth_m", [=](O* o) { o->tracking.close_depth_m = nan; }},
      {"virtual_baseline_m", [](O* o) { o->tracking.virtual_baseline_m = 0.0; }},
      {"virtual_baseline_m", [=](O* o) { o->tracking.virtual_baseline_m = infinity; }},
      {"max_frames", [](O* o) { o->keyframes.max_frames = 0; }},
      {"min_frames", [](O* o) { o->keyframes.min_frames = -1; }},
      {"ratios", [](O* o) { o->keyframes.weak_ratio = 0.0; }},
      {"ratios", [](O* o) { o->keyframes.reference_ratio = 1.1; }},
      {"ratios", [=](O* o) { o->keyframes.young_reference_ratio = nan; }},
      {"counts", [](O* o) { o->keyframes.min_tracked_close = -1; }},
      {"counts", [](O* o) { o->keyframes.min_untracked_close = -1; }},
      {"window_size", [](O* o) { o->mapping.window_size = 1; }},
      {"max_fixed_keyframes", [](O* o) { o->mapping.max_fixed_keyframes = -1; }},
      {"max_iterations", [](O* o) { o->mapping.max_iterations = 0; }},
      {"max_keyframes", [](O* o) { o->mapping.max_keyframes = 2; }},
      {"apply_after_frames", [](O* o) { o->mapping.apply_after_frames = 0; }},
      {"redundant_share", [](O* o) { o->mapping.redundant_share = 0.0; }},
      {"redundant_share", [=](O* o) { o->mapping.redundant_share = nan; }},
      {"num_threads", [](O* o) { o->num_threads = 0; }},
      {"num_threads", [](O* o) { o->num_threads = 3; }},
  };
  for (const auto& [name, change] : cases) {
    PipelineOptions options;
    change(&options);
    const Status status = options.validate();
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument) << name;
    EXPECT_NE(std::string(status.reason).find(name), std::string::npos)
        << name << " in: " << status.reason;
  }
}

}  // namespace
}  // namespace srslam::detail
