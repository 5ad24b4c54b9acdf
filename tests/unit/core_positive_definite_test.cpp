#include "srslam/core/positive_definite.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4>;
using Matrix42 = Eigen::Matrix<double, 4, 2>;

TEST(PositiveDefinite, SolvesFromTheLowerTriangle) {
  test::for_each_seed(20, [](test::Rng& rng) {
    Matrix4 root;
    Matrix42 solution;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) root(i, j) = rng.uniform(-1.0, 1.0) + (i == j ? 3.0 : 0.0);
      for (int j = 0; j < 2; ++j) solution(i, j) = rng.uniform(-5.0, 5.0);
    }
    const Matrix4 A = root * root.transpose();
    Matrix42 B = A * solution;
    Matrix4 lower = A;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) lower(i, j) = test::kNan;
    }
    ASSERT_TRUE(detail::solve_positive_definite(1e-14, &lower, &B));
    EXPECT_LT((B - solution).cwiseAbs().maxCoeff(), 1e-12);
  });
}

TEST(PositiveDefinite, RefusesWhatIsNot) {
  const auto solved = [](const Matrix4& matrix, double min_pivot_share) {
    Matrix4 A = matrix;
    Matrix42 B = Matrix42::Ones();
    return detail::solve_positive_definite(min_pivot_share, &A, &B);
  };
  const Matrix4 identity = Matrix4::Identity();
  EXPECT_TRUE(solved(identity, 1e-14));
  EXPECT_FALSE(solved(Matrix4::Zero(), 1e-14));
  EXPECT_FALSE(solved(-identity, 1e-14));
  EXPECT_FALSE(solved(Matrix4::Ones(), 1e-14));
  // A direction without any weight, up to rounding.
  const Eigen::Vector4d a(0.3, 0.1, 0.7, -0.9);
  const Eigen::Vector4d b(-0.2, 0.6, 0.1, 0.4);
  const Eigen::Vector4d c = 0.3 * a - 0.7 * b;
  const Matrix4 of_rank_2 = a * a.transpose() + b * b.transpose() + c * c.transpose();
  EXPECT_FALSE(solved(of_rank_2, 1e-14));
  Matrix4 uneven = identity;
  uneven(2, 2) = 1e-10;
  EXPECT_TRUE(solved(uneven, 1e-12));
  EXPECT_FALSE(solved(uneven, 1e-8));
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j <= i; ++j) {
      Matrix4 bad = identity;
      bad(i, j) = test::kNan;
      EXPECT_FALSE(solved(bad, 1e-14)) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace srslam
