#include <ceres/gradient_checker.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "srslam/interop/ceres.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::Rng;
using PoseBlock = std::array<double, kPoseBlockSize>;

PoseBlock block_of(const Pose& pose) {
  PoseBlock block{};
  pose_to_block(pose, block.data());
  return block;
}

double distance(const Pose& a, const Pose& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(PoseBlock, KeepsThePose) {
  for_each_seed(200, [](Rng& rng) {
    const Pose pose = rng.pose(5.0);
    PoseBlock block = block_of(pose);
    EXPECT_EQ(Eigen::Vector3d(block.data()), pose.translation());
    EXPECT_LT(distance(pose_from_block(block.data()), pose), 1e-14);
    // Any length and either sign of the quaternion mean the same rotation.
    for (std::size_t i = 3; i < 7; ++i) block[i] *= -2.5;
    EXPECT_LT(distance(pose_from_block(block.data()), pose), 1e-14);
  });
}

TEST(TangentPoseManifold, PlusIsAPerturbationOnTheCamerasSide) {
  for_each_seed(200, [](Rng& rng) {
    const TangentPoseManifold manifold;
    const Pose pose = rng.pose(3.0);
    const PoseBlock x = block_of(pose);
    Vector6 delta;
    delta << rng.vector3(-1.0, 1.0), rng.vector3(-1.0, 1.0);
    PoseBlock y{};
    ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), y.data()));
    EXPECT_LT(distance(pose_from_block(y.data()), pose * se3_exp(delta)), 1e-14);
  });
}

TEST(TangentPoseManifold, PlusAndMinusAreInverse) {
  for_each_seed(300, [](Rng& rng) {
    const TangentPoseManifold manifold;
    const PoseBlock x = block_of(rng.pose(3.0));
    const double size = rng.coin() ? 1.5 : 1e-6;
    Vector6 delta;
    delta << rng.vector3(-size, size), rng.vector3(-size, size);
    PoseBlock moved{};
    ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), moved.data()));
    Vector6 back;
    ASSERT_TRUE(manifold.Minus(moved.data(), x.data(), back.data()));
    EXPECT_LT((back - delta).cwiseAbs().maxCoeff(), 1e-13);

    const Pose target = rng.pose(3.0);
    const PoseBlock y = block_of(target);
    ASSERT_TRUE(manifold.Minus(y.data(), x.data(), delta.data()));
    ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), moved.data()));
    EXPECT_LT(distance(pose_from_block(moved.data()), target), 1e-12);
  });
}

TEST(RgbdReprojectionCost, HandComputedResiduals) {
  const RgbdIntrinsics camera{500.0, 510.0, 320.0, 240.0, 40.0};
  const PoseBlock pose = block_of(Pose::Identity());
  const Eigen::Vector3d point(0.1, -0.2, 2.0);  // pixel (345, 189), disparity 20
  RgbdObservation observation{344.0, 191.0, 19.0, 0.5};
  const RgbdReprojectionCost cost(&observation, &camera);
  const std::array<const double*, 2> parameters = {pose.data(), point.data()};
  Eigen::Vector3d residual;
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residual.data(), nullptr));
  EXPECT_NEAR(residual[0], 0.5, 1e-12);
  EXPECT_NEAR(residual[1], -1.0, 1e-12);
  EXPECT_NEAR(residual[2], 0.5, 1e-12);

  observation.disparity_px = -1.0;  // no depth
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residual.data(), nullptr));
  EXPECT_NEAR(residual[0], 0.5, 1e-12);
  EXPECT_EQ(residual[2], 0.0);
}

TEST(RgbdReprojectionCost, FailsUnlessThePointIsInFrontOfTheCamera) {
  const RgbdIntrinsics camera{500.0, 510.0, 320.0, 240.0, 40.0};
  const RgbdObservation observation{320.0, 240.0, 20.0, 1.0};
  const RgbdReprojectionCost cost(&observation, &camera);
  const PoseBlock pose = block_of(Pose::Identity());
  for (const double z : {-2.0, 0.0, std::nan("")}) {
    const Eigen::Vector3d point(0.1, 0.2, z);
    const std::array<const double*, 2> parameters = {pose.data(), point.data()};
    Eigen::Vector3d residual;
    EXPECT_FALSE(cost.Evaluate(parameters.data(), residual.data(), nullptr)) << z;
  }
}

/// The cost as a function of the tangent vector at a fixed pose. TangentPoseManifold's Jacobian is
/// that of the tangent space, so that derivatives by the seven numbers are never formed, and
/// numeric ones by them could not be compared.
class TangentCost final : public ceres::SizedCostFunction<3, 6, 3> {
 public:
  TangentCost(const RgbdReprojectionCost& cost, const Pose& pose)
      : cost_(cost), base_(block_of(pose)) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    PoseBlock moved{};
    const TangentPoseManifold manifold;
    manifold.Plus(base_.data(), parameters[0], moved.data());
    const std::array<const double*, 2> inner = {moved.data(), parameters[1]};
    if (jacobians == nullptr) return cost_.Evaluate(inner.data(), residuals, nullptr);
    Eigen::Matrix<double, 3, kPoseBlockSize, Eigen::RowMajor> by_block;
    std::array<double*, 2> inner_jacobians = {by_block.data(), jacobians[1]};
    if (!cost_.Evaluate(inner.data(), residuals, inner_jacobians.data())) return false;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, kPoseBlockSize, 6, Eigen::RowMajor> plus;
      manifold.PlusJacobian(moved.data(), plus.data());
      Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> by_tangent(jacobians[0]);
      by_tangent = by_block * plus;
    }
    return true;
  }

 private:
  const RgbdReprojectionCost& cost_;
  PoseBlock base_;
};

TEST(RgbdReprojectionCost, JacobiansAgreeWithNumericOnes) {
  const RgbdIntrinsics camera{517.3, 516.5, 318.6, 255.3, 40.0};
  for_each_seed(60, [&](Rng& rng) {
    const Pose pose = rng.pose(2.0);
    const Eigen::Vector3d in_camera(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0),
                                    rng.uniform(0.5, 5.0));
    const Eigen::Vector3d point = pose * in_camera;
    RgbdObservation observation{rng.uniform(0, 640), rng.uniform(0, 480), rng.uniform(5, 60),
                                rng.uniform(0.3, 1.0)};
    const int variant = rng.uniform_int(0, 2);
    if (variant == 1) observation.disparity_px = -1.0;
    if (variant == 2) observation.inverse_sigma = 0.0;
    const RgbdReprojectionCost cost(&observation, &camera);
    const TangentCost tangent_cost(cost, pose);
    const ceres::NumericDiffOptions numeric;
    const ceres::GradientChecker checker(
        &tangent_cost, static_cast<const std::vector<const ceres::Manifold*>*>(nullptr), numeric);
    const Vector6 zero = Vector6::Zero();
    const std::array<const double*, 2> parameters = {zero.data(), point.data()};
    ceres::GradientChecker::ProbeResults results;
    EXPECT_TRUE(checker.Probe(parameters.data(), 1e-8, &results)) << results.error_log;
    EXPECT_TRUE(results.return_value);
  });
}

TEST(RgbdReprojectionCost, CeresFindsThePoseWithTheManifold) {
  const RgbdIntrinsics camera{500.0, 510.0, 320.0, 240.0, 40.0};
  for_each_seed(10, [&](Rng& rng) {
    const Pose truth = rng.pose(2.0);
    std::deque<RgbdObservation> observations;
    std::deque<RgbdReprojectionCost> costs;
    std::deque<Eigen::Vector3d> points;
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    TangentPoseManifold manifold;
    Pose guess = Pose::Identity();
    guess.linear() = truth.linear() * rng.rotation(0.05, 0.1).toRotationMatrix();
    guess.translation() = truth.translation() + rng.vector3(-0.1, 0.1);
    PoseBlock block = block_of(guess);
    problem.AddParameterBlock(block.data(), kPoseBlockSize, &manifold);
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d p(rng.uniform(-1.0, 1.0), rng.uniform(-0.8, 0.8),
                              rng.uniform(1.0, 4.0));
      points.push_back(truth * p);
      observations.push_back({500.0 * p.x() / p.z() + 320.0, 510.0 * p.y() / p.z() + 240.0,
                              i % 3 == 0 ? -1.0 : 40.0 / p.z(), 1.0});
      costs.emplace_back(&observations.back(), &camera);
      problem.AddResidualBlock(&costs.back(), nullptr, block.data(), points.back().data());
      problem.SetParameterBlockConstant(points.back().data());
    }
    ceres::Solver::Options solver;
    solver.logging_type = ceres::SILENT;
    solver.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    ASSERT_TRUE(summary.IsSolutionUsable()) << summary.BriefReport();
    EXPECT_LT(distance(pose_from_block(block.data()), truth), 1e-8) << summary.BriefReport();
    // Exact derivatives converge in a handful of steps; inconsistent ones crawl.
    EXPECT_LE(summary.iterations.size(), 10U);
  });
}

}  // namespace
}  // namespace srslam
