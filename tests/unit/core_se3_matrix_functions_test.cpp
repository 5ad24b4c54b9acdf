// Exponential, logarithm and Jacobians against Eigen's general matrix functions, which know nothing
// of rotations. The reference runs in long double, so that its own rounding does not count.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <unsupported/Eigen/MatrixFunctions>

#include "srslam/core/se3.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using Matrix4l = Eigen::Matrix<long double, 4, 4>;
using Matrix6l = Eigen::Matrix<long double, 6, 6>;
using test::kPi;

/// Angles [rad] on which all of this must hold; π is the double nearest to it, i.e. half a turn to
/// the last bit.
std::vector<double> angles() {
  return {0.0,  1e-300, 1e-160, 1e-12, 1e-10, 1e-8,       1e-6,       1e-3,       0.1,         0.5,
          0.99, 1.01,   2.0,    3.0,   3.1,   kPi - 1e-3, kPi - 1e-6, kPi - 1e-9, kPi - 1e-12, kPi};
}

// Of one dynamic type, because every fixed size would be compiled anew, and slowly.
using MatrixXl = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
MatrixXl matrix_exp(const MatrixXl& m) { return m.exp(); }
MatrixXl matrix_log(const MatrixXl& m) { return m.log(); }

Matrix4l wedge(const Vector6& tangent) {
  Matrix4l m = Matrix4l::Zero();
  m.topLeftCorner<3, 3>() = hat(tangent.tail<3>()).cast<long double>();
  m.topRightCorner<3, 1>() = tangent.head<3>().cast<long double>();
  return m;
}

/// The matrix of the Lie bracket, ad(xi) eta = [xi, eta].
Matrix6l small_adjoint(const Vector6& tangent) {
  Matrix6l m = Matrix6l::Zero();
  m.topLeftCorner<3, 3>() = hat(tangent.tail<3>()).cast<long double>();
  m.topRightCorner<3, 3>() = hat(tangent.head<3>()).cast<long double>();
  m.bottomRightCorner<3, 3>() = m.topLeftCorner<3, 3>();
  return m;
}

/// Axes: the coordinate axes, both ways, and random ones.
template <typename Body>
void for_each_tangent(const Body& body) {
  for (const double angle : angles()) {
    SCOPED_TRACE("angle " + std::to_string(angle));
    for (int i = 0; i < 3; ++i) {
      for (const double sign : {-1.0, 1.0}) {
        Vector6 tangent;
        tangent << 1.0, -2.0, 0.5, sign * angle * Eigen::Vector3d::Unit(i);
        body(tangent, angle);
      }
    }
    test::for_each_seed(20, [&](test::Rng& rng) {
      Vector6 tangent;
      tangent << rng.vector3(-2.0, 2.0), angle * rng.unit_vector3();
      body(tangent, angle);
    });
  }
}

TEST(Se3AgainstMatrixFunctions, Exponential) {
  for_each_tangent([](const Vector6& tangent, double) {
    const Matrix4l expected = matrix_exp(wedge(tangent));
    const Matrix4l actual = se3_exp(tangent).matrix().cast<long double>();
    EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 2e-15L) << tangent.transpose();
  });
}

TEST(Se3AgainstMatrixFunctions, Logarithm) {
  for_each_tangent([](const Vector6& tangent, double angle) {
    // The reference loses digits in proportion to 1 / (π - angle), and half a turn is on the branch
    // cut of the matrix logarithm: there the exponential above and the round trips of the property
    // tests are the check.
    if (kPi - angle < 1e-4) return;
    const Matrix4l expected = matrix_log(matrix_exp(wedge(tangent)));
    const Vector6 actual = se3_log(se3_exp(tangent));
    EXPECT_LT((wedge(actual) - expected).cwiseAbs().maxCoeff(), 2e-12L) << tangent.transpose();
    if (kPi - angle < 0.01) return;
    EXPECT_LT((wedge(actual) - expected).cwiseAbs().maxCoeff(), 2e-14L) << tangent.transpose();
  });
}

TEST(Se3AgainstMatrixFunctions, AdjointIsTheExponentialOfTheBracket) {
  for_each_tangent([](const Vector6& tangent, double) {
    const Matrix6l expected = matrix_exp(small_adjoint(tangent));
    const Matrix6l actual = se3_adjoint(se3_exp(tangent)).cast<long double>();
    EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 5e-15L) << tangent.transpose();
  });
}

TEST(Se3AgainstMatrixFunctions, LeftJacobianIsTheIntegralOfTheAdjoint) {
  // J(xi) = ∫ exp(s ad(xi)) ds over [0, 1], which is the upper right block of the exponential of
  // [ad(xi) I; 0 0]. This checks every coefficient without any of their formulas.
  using Matrix12l = Eigen::Matrix<long double, 12, 12>;
  for_each_tangent([](const Vector6& tangent, double) {
    Matrix12l block = Matrix12l::Zero();
    block.topLeftCorner<6, 6>() = small_adjoint(tangent);
    block.topRightCorner<6, 6>().setIdentity();
    const Matrix12l exponential = matrix_exp(block);
    const Matrix6l expected = exponential.topRightCorner<6, 6>();
    const Matrix6l actual = se3_left_jacobian(tangent).cast<long double>();
    EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 5e-15L) << tangent.transpose();
    const Matrix6l inverse = se3_left_jacobian_inverse(tangent).cast<long double>();
    EXPECT_LT((inverse * expected - Matrix6l::Identity()).cwiseAbs().maxCoeff(), 2e-14L)
        << tangent.transpose();
  });
}

}  // namespace
}  // namespace srslam
