#include "srslam/core/se3.hpp"

#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/core/orthonormalized.hpp"
#include "support/constants.hpp"
#include "support/numeric_jacobian.hpp"

namespace srslam {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using test::kInf;
using test::kNan;
using test::kPi;
using test::matrices_near;

Vector6 make_tangent(double x, double y, double z, double rx, double ry, double rz) {
  Vector6 tangent;
  tangent << x, y, z, rx, ry, rz;
  return tangent;
}

TEST(Hat, IsTheCrossProduct) {
  const Eigen::Vector3d a(1.0, -2.0, 3.0);
  const Eigen::Vector3d b(0.5, 4.0, -7.0);
  EXPECT_EQ(Eigen::Vector3d(hat(a) * b), a.cross(b));
  EXPECT_EQ(Eigen::Matrix3d(hat(a).transpose()), Eigen::Matrix3d(-hat(a)));
}

TEST(SafeNorm, NeitherUnderflowsNorOverflowsNorHidesANan) {
  for (const double scale : {1e-320, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e307}) {
    EXPECT_DOUBLE_EQ(detail::safe_norm(scale * Eigen::Vector3d(2.0, -3.0, 6.0)), 7.0 * scale);
  }
  EXPECT_EQ(detail::safe_norm(Eigen::Vector3d::Zero()), 0.0);
  EXPECT_TRUE(std::isnan(detail::safe_norm({1.0, kNan, 0.0})));
  EXPECT_EQ(detail::safe_norm({1.0, kInf, 0.0}), kInf);
}

TEST(So3Exp, QuarterTurnAboutZTakesXToY) {
  const Eigen::Matrix3d rotation = so3_exp(Eigen::Vector3d(0.0, 0.0, kPi / 2));
  EXPECT_TRUE(matrices_near(rotation * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 1e-15));
}

TEST(So3Exp, ZeroAndSubnormalVectors) {
  EXPECT_EQ(so3_exp(Eigen::Vector3d::Zero()), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  const double tiny = std::numeric_limits<double>::denorm_min();
  const Eigen::Matrix3d rotation = so3_exp(Eigen::Vector3d(0.0, 0.0, tiny));
  EXPECT_EQ(rotation(1, 0), tiny);
  EXPECT_EQ(rotation(0, 1), -tiny);
  const Eigen::Vector3d smallest_normal(0.0, 0.0, std::numeric_limits<double>::min());
  EXPECT_EQ(so3_log(so3_exp(smallest_normal)), smallest_normal);
}

TEST(So3Exp, HugeVectorsStillGiveRotations) {
  for (const double length : {1e3, 1e30, 1e154, 1e200, 1e307}) {
    const Eigen::Matrix3d rotation = so3_exp(length * Eigen::Vector3d(0.6, 0.0, -0.8));
    EXPECT_TRUE(matrices_near(rotation.transpose() * rotation, Eigen::Matrix3d::Identity(), 1e-14))
        << length;
    EXPECT_NEAR(rotation.determinant(), 1.0, 1e-14) << length;
  }
}

TEST(So3Log, AnglesFromTinyToHalfATurn) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  for (const double angle : {1e-300, 1e-160, 1e-100, 1e-12, 1e-8, 1e-4, 0.1, 1.0, 2.0, 3.0,
                             kPi - 1e-3, kPi - 1e-6, kPi - 1e-9, kPi - 1e-12}) {
    const Eigen::Matrix3d rotation = so3_exp(angle * axis);
    EXPECT_NEAR(so3_log(rotation).stableNorm() / angle, 1.0, 1e-15) << angle;
    EXPECT_TRUE(matrices_near(so3_log(rotation) / angle, axis, 1e-15)) << angle;
    EXPECT_NEAR(rotation_angle_rad(rotation) / angle, 1.0, 1e-15) << angle;
  }
}

TEST(So3Log, ExactHalfTurnTakesTheAxisWithAPositiveLargestComponent) {
  const std::vector<Eigen::Vector3d> axes = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0},
                                             {0.6, 0.8, 0.0}, {0.6, 0.0, 0.8}, {0.0, 0.6, 0.8},
                                             {0.6, -0.8, 0.0}};
  for (const Eigen::Vector3d& axis : axes) {
    // 2 a aᵀ - I is the half turn without rounding for these axes (up to that of 0.6 and 0.8).
    const Eigen::Matrix3d rotation =
        2.0 * axis * axis.transpose() - Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    const Eigen::Vector3d expected = kPi * (axis[largest] > 0.0 ? axis : Eigen::Vector3d(-axis));
    EXPECT_TRUE(matrices_near(so3_log(rotation), expected, 1e-15)) << axis.transpose();
    EXPECT_NEAR(rotation_angle_rad(rotation), kPi, 1e-15);
    EXPECT_TRUE(matrices_near(so3_exp(so3_log(rotation)), rotation, 1e-15));
  }
}

TEST(So3Log, AngleNeverLeavesZeroToPi) {
  for (int i = 0; i <= 2000; ++i) {
    const double angle = -4.0 * kPi + 8.0 * kPi * i / 2000.0;
    const Eigen::Matrix3d rotation = so3_exp(angle * Eigen::Vector3d(0.0, 0.6, 0.8));
    const double logged = so3_log(rotation).norm();
    EXPECT_LE(logged, kPi + 1e-15);
    EXPECT_NEAR(logged, std::abs(std::remainder(angle, 2.0 * kPi)), 4e-15) << angle;
  }
}

TEST(RotationAngle, IsAccurateWhereTheTraceIsNot) {
  // The trace of a rotation by 1e-9 rad is 3 to the last bit.
  const Eigen::Matrix3d rotation = so3_exp(Eigen::Vector3d(1e-9, 0.0, 0.0));
  ASSERT_EQ(rotation.trace(), 3.0);
  EXPECT_NEAR(rotation_angle_rad(rotation), 1e-9, 1e-24);
}

TEST(UnitQuaternion, HasANonNegativeRealPartAndUnitNorm) {
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = unit_quaternion(so3_exp(Eigen::Vector3d(0.1 * i, -0.07 * i, 0.3)));
    EXPECT_GE(q.w(), 0.0);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
  }
}

TEST(So3LeftJacobian, AtZeroIsIdentity) {
  EXPECT_EQ(so3_left_jacobian(Eigen::Vector3d::Zero()),
            Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(so3_left_jacobian_inverse(Eigen::Vector3d::Zero()),
            Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
}

// The coefficient functions switch from a series to a closed form at 1; a wrong coefficient shows
// as a jump there.
TEST(Se3Coefficients, SeriesAndClosedFormsMeet) {
  const double below = std::nextafter(1.0, 0.0);
  EXPECT_NEAR(detail::a_minus_sin_over_a3(below), detail::a_minus_sin_over_a3(1.0), 1e-15);
  EXPECT_NEAR(detail::one_minus_half_cot_over_a2(below), detail::one_minus_half_cot_over_a2(1.0),
              1e-15);
  EXPECT_NEAR(detail::cos_remainder_over_a4(below), detail::cos_remainder_over_a4(1.0), 1e-15);
  EXPECT_NEAR(detail::sin_cos_remainder_over_a5(below), detail::sin_cos_remainder_over_a5(1.0),
              2e-15);
}

TEST(Se3Coefficients, HandComputedValues) {
  EXPECT_DOUBLE_EQ(detail::one_minus_cos_over_a2(0.0), 0.5);
  EXPECT_DOUBLE_EQ(detail::a_minus_sin_over_a3(0.0), 1.0 / 6.0);
  EXPECT_DOUBLE_EQ(detail::one_minus_half_cot_over_a2(0.0), 1.0 / 12.0);
  EXPECT_DOUBLE_EQ(detail::cos_remainder_over_a4(0.0), 1.0 / 24.0);
  EXPECT_DOUBLE_EQ(detail::sin_cos_remainder_over_a5(0.0), 1.0 / 120.0);
  const double pi2 = kPi * kPi;
  EXPECT_NEAR(detail::one_minus_cos_over_a2(kPi), 2.0 / pi2, 1e-16);
  EXPECT_NEAR(detail::a_minus_sin_over_a3(kPi), 1.0 / pi2, 1e-16);
  EXPECT_NEAR(detail::one_minus_half_cot_over_a2(kPi), 1.0 / pi2, 1e-16);
  EXPECT_NEAR(detail::cos_remainder_over_a4(kPi), (pi2 / 2.0 - 2.0) / (pi2 * pi2), 1e-16);
  EXPECT_NEAR(detail::sin_cos_remainder_over_a5(kPi), 1.0 / (2.0 * pi2 * pi2), 1e-16);
}

TEST(Se3Exp, PureTranslationIsExact) {
  const Pose T = se3_exp(make_tangent(1.0, -2.0, 3.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(Eigen::Matrix3d(T.linear()), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(Eigen::Vector3d(T.translation()), Eigen::Vector3d(1.0, -2.0, 3.0));
}

TEST(Se3Exp, DrivesAQuarterCircle) {
  // Forward speed π/2 and turn rate π/2 for one unit of time: a quarter of a circle of radius 1.
  const Pose T = se3_exp(make_tangent(kPi / 2, 0.0, 0.0, 0.0, 0.0, kPi / 2));
  EXPECT_TRUE(matrices_near(T.translation(), Eigen::Vector3d(1.0, 1.0, 0.0), 1e-15));
  EXPECT_TRUE(
      matrices_near(T.linear() * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 1e-15));
}

TEST(Se3Exp, TakesEveryAlignmentAndExpression) {
  const Vector6 unaligned = make_tangent(0.1, 0.2, 0.3, -0.1, 0.2, 0.4);
  const Vector6d aligned = unaligned;
  EXPECT_EQ(se3_exp(unaligned).matrix(), se3_exp(aligned).matrix());
  EXPECT_EQ(se3_exp(2.0 * unaligned - aligned).matrix(), se3_exp(aligned).matrix());
  const Eigen::Isometry3d isometry = se3_exp(aligned);
  EXPECT_EQ(se3_log(isometry), se3_log(se3_exp(aligned)));
  const Matrix6d adjoint = se3_adjoint(isometry);
  EXPECT_EQ(adjoint, Matrix6d(se3_adjoint(se3_exp(unaligned))));
}

// T_world_camera and tangent vectors in the camera frame: a camera that moves along +x of its own
// axes sees a fixed point move along -x.
TEST(Conventions, CameraMovingRightSeesThePointMoveLeft) {
  const Pose T_world_camera = Pose::Identity();
  const Eigen::Vector3d p_world(0.0, 0.0, 2.0);
  const Pose T_world_moved = T_world_camera * se3_exp(make_tangent(0.1, 0.0, 0.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(Eigen::Vector3d(T_world_moved.translation()), Eigen::Vector3d(0.1, 0.0, 0.0));
  const Eigen::Vector3d before = T_world_camera.inverse() * p_world;
  const Eigen::Vector3d after = T_world_moved.inverse() * p_world;
  EXPECT_TRUE(matrices_near(after - before, Eigen::Vector3d(-0.1, 0.0, 0.0), 1e-15));
}

// Positive rotation about the camera's y axis (down) turns the view from z towards x, i.e. to the
// right, so that the point ahead moves to the left.
TEST(Conventions, CameraTurningRightSeesThePointMoveLeft) {
  const Pose T_world_camera = se3_exp(make_tangent(0.0, 0.0, 0.0, 0.0, 0.1, 0.0));
  const Eigen::Vector3d ahead = T_world_camera.linear() * Eigen::Vector3d::UnitZ();
  EXPECT_GT(ahead.x(), 0.09);
  const Eigen::Vector3d seen = T_world_camera.inverse() * Eigen::Vector3d(0.0, 0.0, 2.0);
  EXPECT_LT(seen.x(), -0.19);
}

TEST(Se3Adjoint, MovesATwistBetweenFrames) {
  // Body b is 1 m along x of a and turned by 90° about z. Rotation about b's z axis is, seen from
  // a, rotation about a's z axis plus the velocity of the point at a's origin, -z × (1, 0, 0).
  Pose T_a_b = Pose::Identity();
  T_a_b.linear() = so3_exp(Eigen::Vector3d(0.0, 0.0, kPi / 2));
  T_a_b.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
  const Vector6d turn = se3_adjoint(T_a_b) * make_tangent(0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
  EXPECT_TRUE(matrices_near(turn, make_tangent(0.0, -1.0, 0.0, 0.0, 0.0, 1.0), 1e-15));
  const Vector6d forward = se3_adjoint(T_a_b) * make_tangent(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  EXPECT_TRUE(matrices_near(forward, make_tangent(0.0, 1.0, 0.0, 0.0, 0.0, 0.0), 1e-15));
}

TEST(Se3Interpolate, MidwayOnAQuarterCircle) {
  const Pose end = se3_exp(make_tangent(kPi / 2, 0.0, 0.0, 0.0, 0.0, kPi / 2));
  const Pose middle = se3_interpolate(Pose::Identity(), end, 0.5);
  const double c = std::sqrt(0.5);
  EXPECT_TRUE(matrices_near(middle.translation(), Eigen::Vector3d(c, 1.0 - c, 0.0), 1e-15));
}

TEST(Orthonormalized, KeepsARotationAndItsTranslation) {
  const Pose T = se3_exp(make_tangent(1.0, 2.0, 3.0, 0.4, -0.5, 0.6));
  const Pose result = orthonormalized(T);
  EXPECT_TRUE(matrices_near(result.matrix(), T.matrix(), 1e-15));
  EXPECT_EQ(Eigen::Vector3d(result.translation()), Eigen::Vector3d(T.translation()));
}

TEST(Orthonormalized, RemovesScaleAndNeverReturnsAReflection) {
  Pose T = se3_exp(make_tangent(0.0, 0.0, 0.0, 0.4, -0.5, 0.6));
  const Eigen::Matrix3d rotation = T.linear();
  T.linear() *= 1.7;
  EXPECT_TRUE(matrices_near(orthonormalized(T).linear(), rotation, 1e-15));
  T.linear() = rotation * Eigen::Vector3d(1.0, 1.0, -0.5).asDiagonal();  // det < 0
  const Eigen::Matrix3d result = orthonormalized(T).linear();
  EXPECT_NEAR(result.determinant(), 1.0, 1e-14);
  EXPECT_TRUE(matrices_near(result, rotation, 1e-15));
}

TEST(Orthonormalized, DegenerateMatricesGiveSomeProperRotation) {
  for (const double scale : {0.0, 1e-300, 1e200}) {
    for (int rank = 0; rank <= 2; ++rank) {
      Pose T = Pose::Identity();
      T.linear().setZero();
      for (int i = 0; i < rank; ++i) T.linear()(i, i) = scale;
      const Eigen::Matrix3d result = orthonormalized(T).linear();
      EXPECT_TRUE(matrices_near(result.transpose() * result, Eigen::Matrix3d::Identity(), 1e-14));
      EXPECT_NEAR(result.determinant(), 1.0, 1e-14);
    }
  }
}

TEST(PoseFromQuaternion, NormalisesAndPlacesTheTranslation) {
  Pose T = Pose::Identity();
  const double s = std::sqrt(0.5);
  const Eigen::Quaterniond three_times(3.0 * s, 0.0, 0.0, 3.0 * s);
  ASSERT_TRUE(pose_from_quaternion({1.0, 2.0, 3.0}, three_times, &T).ok());
  EXPECT_TRUE(matrices_near(T * Eigen::Vector3d::UnitX(), Eigen::Vector3d(1.0, 3.0, 3.0), 1e-15));
  EXPECT_EQ(T.matrix().row(3), Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0));
}

TEST(PoseFromQuaternion, RefusesWhatIsNoRotation) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Pose before = se3_exp(make_tangent(1.0, 2.0, 3.0, 0.1, 0.2, 0.3));
  Pose T = before;
  for (const Eigen::Quaterniond& q :
       {Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), Eigen::Quaterniond(1e-9, 0.0, 0.0, 0.0),
        Eigen::Quaterniond(kNan, 0.0, 0.0, 1.0), Eigen::Quaterniond(1.0, kInf, 0.0, 0.0)}) {
    const Status status = pose_from_quaternion(zero, q, &T);
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
    EXPECT_STRNE(status.reason, "");
  }
  const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
  EXPECT_FALSE(pose_from_quaternion({0.0, kNan, 0.0}, identity, &T).ok());
  EXPECT_FALSE(pose_from_quaternion({-kInf, 0.0, 0.0}, identity, &T).ok());
  EXPECT_FALSE(pose_from_quaternion(zero, identity, nullptr).ok());
  EXPECT_EQ(T.matrix(), before.matrix()) << "a refused input must not touch the output";
}

// These functions cannot report an error; a bad number must stay visible and must neither crash nor
// loop.
TEST(NonFiniteInput, ComesOutNonFinite) {
  for (const double bad : {kNan, kInf, -kInf}) {
    for (int i = 0; i < 6; ++i) {
      Vector6 tangent = make_tangent(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
      tangent[i] = bad;
      EXPECT_FALSE(se3_exp(tangent).matrix().allFinite());
      EXPECT_FALSE(se3_left_jacobian(tangent).allFinite());
      EXPECT_FALSE(se3_left_jacobian_inverse(tangent).allFinite());
    }
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 3; ++col) {
        Pose T = Pose::Identity();
        T.matrix()(row, col) = bad;
        EXPECT_FALSE(se3_log(T).allFinite()) << row << " " << col;
        EXPECT_FALSE(std::isfinite(rotation_angle_rad(T.linear()))) << row << " " << col;
        EXPECT_FALSE(orthonormalized(T).matrix().allFinite());
      }
      Pose T = Pose::Identity();
      T.translation()[row] = bad;
      EXPECT_FALSE(se3_log(T).allFinite());
    }
    const Pose T = se3_exp(make_tangent(1.0, 2.0, 3.0, 0.1, 0.2, 0.3));
    EXPECT_FALSE(se3_interpolate(Pose::Identity(), T, bad).matrix().allFinite());
  }
}

}  // namespace
}  // namespace srslam
