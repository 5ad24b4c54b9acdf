// Identities of SO(3) and SE(3) that hold for every input, on random inputs with fixed seeds.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/core/conventions.hpp"
#include "srslam/core/orthonormalized.hpp"
#include "srslam/core/se3.hpp"
#include "support/constants.hpp"
#include "support/numeric_jacobian.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::kPi;
using test::matrices_near;
using test::numeric_jacobian;
using test::Rng;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The regimes of the rotation angle [rad].
const std::vector<double>& angles() {
  static const std::vector<double> values = {0.0, 1e-12, 1e-8,       1e-3,       0.3,
                                             1.5, 3.0,   kPi - 1e-3, kPi - 1e-9, kPi};
  return values;
}

Vector6 random_tangent(Rng& rng, double angle) {
  Vector6 tangent;
  tangent << rng.vector3(-3.0, 3.0), angle * rng.unit_vector3();
  return tangent;
}

TEST(Se3Properties, ExpGivesProperRotations) {
  for_each_seed(100, [](Rng& rng) {
    for (const double angle : angles()) {
      const Eigen::Matrix3d rotation = se3_exp(random_tangent(rng, angle)).linear();
      EXPECT_TRUE(
          matrices_near(rotation.transpose() * rotation, Eigen::Matrix3d::Identity(), 2e-15));
      EXPECT_NEAR(rotation.determinant(), 1.0, 2e-15);
    }
  });
}

TEST(Se3Properties, LogInvertsExpBelowHalfATurn) {
  for_each_seed(200, [](Rng& rng) {
    for (const double angle : angles()) {
      if (angle == kPi) continue;  // either sign of the axis is right there
      const Vector6 tangent = random_tangent(rng, angle);
      const Vector6 result = se3_log(se3_exp(tangent));
      EXPECT_LE((result - tangent).head<3>().norm(), 5e-15) << tangent.transpose();
      // Relative: a rotation of 1e-12 rad keeps its digits.
      EXPECT_LE((result - tangent).tail<3>().norm(), 1e-15 * angle) << tangent.transpose();
    }
  });
}

TEST(Se3Properties, ExpInvertsLogEverywhere) {
  for_each_seed(200, [](Rng& rng) {
    for (const double angle : angles()) {
      const Pose T = se3_exp(random_tangent(rng, angle));
      EXPECT_TRUE(matrices_near(se3_exp(se3_log(T)).matrix(), T.matrix(), 3e-15));
    }
    // Half a turn about a random axis, with the rounding that a product leaves.
    const Pose G = rng.pose(2.0);
    const Pose T = G * se3_exp(random_tangent(rng, kPi)) * G.inverse();
    EXPECT_TRUE(matrices_near(se3_exp(se3_log(T)).matrix(), T.matrix(), 1e-14));
  });
}

TEST(Se3Properties, LogSurvivesTheDriftOfLongProducts) {
  for_each_seed(50, [](Rng& rng) {
    Pose T = rng.pose(1.0);
    for (int i = 0; i < 9; ++i) T.linear()(i / 3, i % 3) += rng.uniform(-1e-9, 1e-9);
    const Pose nearest = orthonormalized(T);
    EXPECT_LE((so3_log(T.linear()) - so3_log(nearest.linear())).norm(), 1e-8);
    EXPECT_NEAR(rotation_angle_rad(T.linear()), rotation_angle_rad(nearest.linear()), 1e-8);
  });
}

TEST(Se3Properties, LogOfTheInverseIsTheNegativeLog) {
  for_each_seed(200, [](Rng& rng) {
    const Pose T = rng.pose(2.0);
    EXPECT_TRUE(matrices_near(se3_log(T.inverse()), -se3_log(T), 1e-14));
  });
}

TEST(Se3Properties, RotationAngleIsTheNormOfTheLog) {
  for_each_seed(200, [](Rng& rng) {
    for (const double angle : angles()) {
      const Eigen::Matrix3d rotation = so3_exp(angle * rng.unit_vector3());
      EXPECT_NEAR(rotation_angle_rad(rotation), so3_log(rotation).norm(), 1e-15 * (1.0 + angle));
      EXPECT_NEAR(rotation_angle_rad(rotation), angle, 1e-15 * angle);
    }
  });
}

TEST(Se3Properties, AdjointConjugates) {
  // T exp(xi) T^-1 = exp(Ad xi).
  for_each_seed(200, [](Rng& rng) {
    const Pose T_a_b = rng.pose(2.0);
    for (const double angle : angles()) {
      const Vector6 xi_b = random_tangent(rng, angle);
      const Vector6 xi_a = se3_adjoint(T_a_b) * xi_b;
      const Pose left = T_a_b * se3_exp(xi_b) * T_a_b.inverse();
      EXPECT_TRUE(matrices_near(left.matrix(), se3_exp(xi_a).matrix(), 2e-14));
    }
  });
}

TEST(Se3Properties, AdjointIsAHomomorphism) {
  for_each_seed(200, [](Rng& rng) {
    const Pose A = rng.pose(2.0);
    const Pose B = rng.pose(2.0);
    EXPECT_TRUE(matrices_near(se3_adjoint(A * B), se3_adjoint(A) * se3_adjoint(B), 1e-14));
    EXPECT_TRUE(
        matrices_near(se3_adjoint(A.inverse()) * se3_adjoint(A), Matrix6d::Identity(), 1e-14));
  });
}

TEST(Se3Properties, So3LeftJacobianMatchesDifferences) {
  for_each_seed(50, [](Rng& rng) {
    for (const double angle : angles()) {
      const Eigen::Vector3d v = angle * rng.unit_vector3();
      const Eigen::Matrix3d inverse_of_exp = so3_exp(v).transpose();
      const Eigen::Matrix3d numeric = numeric_jacobian(
          [&](const Eigen::Vector3d& at) { return so3_log(so3_exp(at) * inverse_of_exp); }, v,
          1e-3);
      EXPECT_TRUE(matrices_near(so3_left_jacobian(v), numeric, 1e-11)) << v.transpose();
      EXPECT_TRUE(matrices_near(so3_left_jacobian_inverse(v) * so3_left_jacobian(v),
                                Eigen::Matrix3d::Identity(), 1e-14))
          << v.transpose();
    }
  });
}

TEST(Se3Properties, Se3LeftJacobianMatchesDifferences) {
  for_each_seed(50, [](Rng& rng) {
    for (const double angle : angles()) {
      const Vector6d tangent = random_tangent(rng, angle);
      const Pose inverse_of_exp = se3_exp(tangent).inverse();
      const Matrix6d numeric = numeric_jacobian(
          [&](const Vector6d& at) -> Vector6d { return se3_log(se3_exp(at) * inverse_of_exp); },
          tangent, 1e-3);
      EXPECT_TRUE(matrices_near(se3_left_jacobian(tangent), numeric, 1e-11)) << tangent.transpose();
      EXPECT_TRUE(matrices_near(se3_left_jacobian_inverse(tangent) * se3_left_jacobian(tangent),
                                Matrix6d::Identity(), 2e-14))
          << tangent.transpose();
    }
  });
}

TEST(Se3Properties, LeftAndRightJacobianDifferByTheAdjoint) {
  // J_l(xi) = Ad(exp xi) J_r(xi) with J_r(xi) = J_l(-xi).
  for_each_seed(100, [](Rng& rng) {
    for (const double angle : angles()) {
      const Vector6 tangent = random_tangent(rng, angle);
      const Vector6 negative = -tangent;
      EXPECT_TRUE(matrices_near(se3_left_jacobian(tangent),
                                se3_adjoint(se3_exp(tangent)) * se3_left_jacobian(negative),
                                1e-14));
    }
  });
}

TEST(Se3Properties, InterpolationEndsAreExact) {
  for_each_seed(100, [](Rng& rng) {
    const Pose A = rng.pose(2.0);
    const Pose B = rng.pose(2.0);
    EXPECT_EQ(se3_interpolate(A, B, 0.0).matrix(), A.matrix());
    EXPECT_EQ(se3_interpolate(A, B, 1.0).matrix(), B.matrix());
    // And the way there is continuous.
    EXPECT_TRUE(matrices_near(se3_interpolate(A, B, 1e-15).matrix(), A.matrix(), 1e-13));
    EXPECT_TRUE(matrices_near(se3_interpolate(A, B, 1.0 - 1e-15).matrix(), B.matrix(), 1e-13));
    EXPECT_TRUE(
        matrices_near(se3_interpolate(A, A, rng.uniform(0.0, 1.0)).matrix(), A.matrix(), 1e-15));
  });
}

TEST(Se3Properties, InterpolationHasConstantVelocity) {
  for_each_seed(100, [](Rng& rng) {
    const Pose A = rng.pose(2.0);
    // Up to near half a turn between the ends.
    const Pose B = A * se3_exp(random_tangent(rng, rng.uniform(0.0, kPi - 1e-6)));
    const Vector6 whole = se3_log(A.inverse() * B);
    constexpr int kSteps = 8;
    Pose previous = A;
    for (int i = 1; i <= kSteps; ++i) {
      const Pose next = se3_interpolate(A, B, i / static_cast<double>(kSteps));
      EXPECT_TRUE(matrices_near(se3_log(previous.inverse() * next), whole / kSteps, 1e-14));
      previous = next;
    }
  });
}

TEST(Se3Properties, InterpolationIsEquivariant) {
  for_each_seed(100, [](Rng& rng) {
    const Pose A = rng.pose(2.0);
    const Pose B = A * se3_exp(random_tangent(rng, rng.uniform(0.0, 3.1)));
    const Pose G = rng.pose(5.0);
    const double fraction = rng.uniform(0.0, 1.0);
    const Pose middle = se3_interpolate(A, B, fraction);
    // Another world frame, another body frame, and the inverse poses.
    EXPECT_TRUE(matrices_near(se3_interpolate(G * A, G * B, fraction).matrix(),
                              (G * middle).matrix(), 1e-13));
    EXPECT_TRUE(matrices_near(se3_interpolate(A * G, B * G, fraction).matrix(),
                              (middle * G).matrix(), 1e-13));
    EXPECT_TRUE(matrices_near(se3_interpolate(A.inverse(), B.inverse(), fraction).matrix(),
                              middle.inverse().matrix(), 1e-13));
    EXPECT_TRUE(
        matrices_near(se3_interpolate(B, A, 1.0 - fraction).matrix(), middle.matrix(), 1e-13));
  });
}

TEST(Se3Properties, InterpolationAtHalfATurnTakesAShortestWay) {
  for_each_seed(100, [](Rng& rng) {
    for (const double angle : {kPi - 1e-9, kPi - 1e-12, kPi}) {
      const Pose A = rng.pose(2.0);
      const Pose B = A * se3_exp(random_tangent(rng, angle));
      const Pose middle = se3_interpolate(A, B, 0.5);
      EXPECT_NEAR(rotation_angle_rad((A.inverse() * middle).linear()), kPi / 2, 1e-8);
      EXPECT_NEAR(rotation_angle_rad((middle.inverse() * B).linear()), kPi / 2, 1e-8);
    }
  });
}

TEST(Se3Properties, OrthonormalizedIsNearestAndIdempotent) {
  for_each_seed(100, [](Rng& rng) {
    Pose T = rng.pose(2.0);
    for (int i = 0; i < 9; ++i) T.linear()(i / 3, i % 3) += rng.uniform(-0.05, 0.05);
    const Pose nearest = orthonormalized(T);
    const Eigen::Matrix3d rotation = nearest.linear();
    EXPECT_TRUE(matrices_near(rotation.transpose() * rotation, Eigen::Matrix3d::Identity(), 2e-15));
    EXPECT_NEAR(rotation.determinant(), 1.0, 2e-15);
    EXPECT_TRUE(matrices_near(orthonormalized(nearest).matrix(), nearest.matrix(), 2e-15));
    const double distance = (T.linear() - rotation).norm();
    for (int i = 0; i < 20; ++i) {
      const Eigen::Matrix3d other = so3_exp(rng.vector3(-0.1, 0.1)) * rotation;
      EXPECT_LE(distance, (T.linear() - other).norm() + 1e-15);
    }
  });
}

TEST(Se3Properties, QuaternionRoundTrip) {
  for_each_seed(200, [](Rng& rng) {
    const Pose T = rng.pose(2.0, kPi);
    Pose back = Pose::Identity();
    ASSERT_TRUE(pose_from_quaternion(T.translation(), unit_quaternion(T.linear()), &back).ok());
    EXPECT_TRUE(matrices_near(back.matrix(), T.matrix(), 2e-15));
  });
}

// A covariance moved to the other side describes the same random poses.
TEST(ConventionProperties, CovarianceChangesFrame) {
  for_each_seed(100, [](Rng& rng) {
    const Pose T_a_b = rng.pose(2.0);
    Matrix6d root;
    for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = rng.uniform(-1.0, 1.0);
    const Matrix6d covariance_b = root * root.transpose();
    const Matrix6d covariance_a = covariance_in_frame_a(T_a_b, covariance_b);
    EXPECT_EQ(covariance_a, Matrix6d(covariance_a.transpose()));
    // Sigma points of b, expressed in a through the poses themselves.
    Matrix6d moved = Matrix6d::Zero();
    for (int i = 0; i < 6; ++i) {
      const Vector6 xi_b = 1e-3 * root.col(i);
      const Pose moved_pose = T_a_b * se3_exp(xi_b);
      const Vector6d xi_a = 1e3 * se3_log(moved_pose * T_a_b.inverse());
      moved += xi_a * xi_a.transpose();
    }
    EXPECT_TRUE(matrices_near(covariance_a, moved, 1e-10));
    // Information matrices go the inverse way.
    const Matrix6d regular = covariance_b + Matrix6d::Identity();
    const Matrix6d information_b = regular.inverse();
    const Matrix6d product = Matrix6d(information_in_frame_a(T_a_b, information_b)) *
                             Matrix6d(covariance_in_frame_a(T_a_b, regular));
    EXPECT_TRUE(matrices_near(product, Matrix6d::Identity(), 1e-10));
  });
}

}  // namespace
}  // namespace srslam
