#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "srslam/evaluation/trajectory_alignment.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

// Horn's method by quaternions (JOSA A 4(4), 1987) shares no step with the one under test.
TEST(AlignmentProperty, AgreesWithQuaternionMethod) {
  test::for_each_seed(200, [](test::Rng& rng) {
    const int size = rng.uniform_int(3, 50);
    const Pose T = rng.pose(5.0);
    const double noise_m = rng.uniform(0.0, 0.5);
    // A mirrored or flat cloud makes the sign of the determinant matter.
    const Eigen::Vector3d shape(1.0, rng.uniform(0.05, 1.0), rng.coin() ? rng.uniform(-1, 1) : 0.0);
    std::vector<Eigen::Vector3d> reference;
    std::vector<Eigen::Vector3d> estimate;
    for (int i = 0; i < size; ++i) {
      const Eigen::Vector3d point = rng.vector3(-2.0, 2.0);
      estimate.push_back(point);
      reference.push_back(T * point.cwiseProduct(shape) + rng.vector3(-noise_m, noise_m));
    }
    Eigen::Vector3d reference_mean = Eigen::Vector3d::Zero();
    Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
    for (int i = 0; i < size; ++i) {
      reference_mean += reference[static_cast<std::size_t>(i)] / size;
      estimate_mean += estimate[static_cast<std::size_t>(i)] / size;
    }
    Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < reference.size(); ++i) {
      S += (estimate[i] - estimate_mean) * (reference[i] - reference_mean).transpose();
    }
    Eigen::Matrix4d N;
    N(0, 0) = S.trace();
    const Eigen::Vector3d delta(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
    N.block<1, 3>(0, 1) = delta.transpose();
    N.block<3, 1>(1, 0) = delta;
    N.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(N);
    const Eigen::Vector4d q = solver.eigenvectors().col(3);
    const double gap = solver.eigenvalues()(3) - solver.eigenvalues()(2);
    if (gap < 1e-3) return;  // the best rotation is not unique enough to compare matrices
    const Eigen::Matrix3d expected = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix();

    const AlignmentResult alignment = align_trajectories(reference, estimate, false);
    ASSERT_TRUE(alignment.status.ok());
    EXPECT_LT((alignment.R_reference_estimate - expected).norm(), 1e-9);
    EXPECT_LT((alignment.t_reference_estimate - (reference_mean - expected * estimate_mean)).norm(),
              1e-9);
  });
}

TEST(AlignmentProperty, NoNeighbourOfTheAlignmentIsBetter) {
  test::for_each_seed(100, [](test::Rng& rng) {
    std::vector<Eigen::Vector3d> reference;
    std::vector<Eigen::Vector3d> estimate;
    const int size = rng.uniform_int(3, 30);
    for (int i = 0; i < size; ++i) {
      reference.push_back(rng.vector3(-1.0, 1.0));
      estimate.push_back(rng.vector3(-1.0, 1.0));
    }
    const auto cost = [&](double scale, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
      double sum = 0.0;
      for (std::size_t i = 0; i < reference.size(); ++i) {
        sum += (scale * (R * estimate[i]) + t - reference[i]).squaredNorm();
      }
      return sum;
    };
    for (const bool with_scale : {false, true}) {
      const AlignmentResult best = align_trajectories(reference, estimate, with_scale);
      ASSERT_TRUE(best.status.ok());
      EXPECT_NEAR(best.R_reference_estimate.determinant(), 1.0, 1e-12);
      const double best_cost =
          cost(best.scale, best.R_reference_estimate, best.t_reference_estimate);
      for (int k = 0; k < 50; ++k) {
        const double size_of_step = std::pow(10.0, rng.uniform(-4.0, 0.0));
        const Eigen::Matrix3d R =
            rng.rotation(0.0, size_of_step).toRotationMatrix() * best.R_reference_estimate;
        const Eigen::Vector3d t = best.t_reference_estimate + size_of_step * rng.vector3(-1.0, 1.0);
        const double scale =
            with_scale ? best.scale * (1.0 + size_of_step * rng.uniform(-0.9, 0.9)) : 1.0;
        EXPECT_GE(cost(scale, R, t), best_cost * (1 - 1e-12));
      }
    }
  });
}

}  // namespace
}  // namespace srslam
