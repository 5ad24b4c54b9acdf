#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"

// Rotations and rigid motions with their tangent spaces. The formulas are those of T. Barfoot,
// "State Estimation for Robotics" (2017), chapter 7, with the coefficients rewritten so that no
// digit is lost near 0 or near π. Everything is constant time and allocates nothing.
//
// Tangent vectors are [translation; rotation]. Functions that take a `Vector6` or `Matrix6` take
// any Eigen expression of that size too. A NaN or an infinity in an argument comes out as a NaN:
// these functions have no other way to report it, and a finite answer would hide it.

namespace srslam {

namespace detail {

/// Below this squared angle the coefficient functions use their Taylor series; above it the closed
/// forms lose at most a few units in the last place.
constexpr double kSeriesSquaredAngle = 1.0;

/// c[0] + x (c[1] + x (c[2] + ...)).
template <std::size_t N>
constexpr double polynomial(const double (&coefficients)[N], double x) noexcept {
  double value = coefficients[N - 1];
  for (std::size_t i = N - 1; i > 0; --i) value = value * x + coefficients[i - 1];
  return value;
}

/// Euclidean norm that neither underflows nor overflows where the result is representable.
inline double safe_norm(const double* v, int size) noexcept {
  double squared = 0.0;
  double largest = 0.0;
  for (int i = 0; i < size; ++i) {
    squared += v[i] * v[i];
    largest = std::abs(v[i]) > largest ? std::abs(v[i]) : largest;
  }
  if (std::isnan(squared) || std::isinf(largest) || largest == 0.0) return squared;
  if (squared > 1e-200 && squared < 1e200) return std::sqrt(squared);
  squared = 0.0;
  for (int i = 0; i < size; ++i) squared += (v[i] / largest) * (v[i] / largest);
  return largest * std::sqrt(squared);
}
inline double safe_norm(const Eigen::Vector3d& v) noexcept { return safe_norm(v.data(), 3); }

/// (1 - cos a) / a².
inline double one_minus_cos_over_a2(double a) noexcept {
  const double half = 0.5 * a;
  const double sinc = half == 0.0 ? 1.0 : std::sin(half) / half;
  return 0.5 * sinc * sinc;
}

/// (a - sin a) / a³.
inline double a_minus_sin_over_a3(double a) noexcept {
  constexpr double kSeries[] = {1.0 / 6.0,
                                -1.0 / 120.0,
                                1.0 / 5040.0,
                                -1.0 / 362880.0,
                                1.0 / 39916800.0,
                                -1.0 / 6227020800.0,
                                1.0 / 1307674368000.0,
                                -1.0 / 355687428096000.0,
                                1.0 / 121645100408832000.0};
  if (a * a < kSeriesSquaredAngle) return polynomial(kSeries, a * a);
  return (1.0 - std::sin(a) / a) / (a * a);
}

/// (1 - (a/2) cot(a/2)) / a².
inline double one_minus_half_cot_over_a2(double a) noexcept {
  // |B_2k| / (2k)! with the Bernoulli numbers B.
  constexpr double kSeries[] = {1.0 / 12.0,
                                1.0 / 720.0,
                                1.0 / 30240.0,
                                1.0 / 1209600.0,
                                1.0 / 47900160.0,
                                691.0 / 1307674368000.0,
                                1.0 / 74724249600.0,
                                3617.0 / 10670622842880000.0,
                                43867.0 / 5109094217170944000.0,
                                174611.0 / 802857662698291200000.0,
                                77683.0 / 14101100039391805440000.0};
  if (a * a < kSeriesSquaredAngle) return polynomial(kSeries, a * a);
  const double half = 0.5 * a;
  return (1.0 - half * std::cos(half) / std::sin(half)) / (a * a);
}

/// (a² / 2 + cos a - 1) / a⁴.
inline double cos_remainder_over_a4(double a) noexcept {
  constexpr double kSeries[] = {1.0 / 24.0,
                                -1.0 / 720.0,
                                1.0 / 40320.0,
                                -1.0 / 3628800.0,
                                1.0 / 479001600.0,
                                -1.0 / 87178291200.0,
                                1.0 / 20922789888000.0,
                                -1.0 / 6402373705728000.0,
                                1.0 / 2432902008176640000.0};
  if (a * a < kSeriesSquaredAngle) return polynomial(kSeries, a * a);
  return (0.5 - one_minus_cos_over_a2(a)) / (a * a);
}

/// (2 a - 3 sin a + a cos a) / (2 a⁵).
inline double sin_cos_remainder_over_a5(double a) noexcept {
  // (-1)^n (n - 1) / (2n + 1)! for n = 2, 3, ...
  constexpr double kSeries[] = {1.0 / 120.0,
                                -2.0 / 5040.0,
                                3.0 / 362880.0,
                                -4.0 / 39916800.0,
                                5.0 / 6227020800.0,
                                -6.0 / 1307674368000.0,
                                7.0 / 355687428096000.0,
                                -8.0 / 121645100408832000.0,
                                9.0 / 51090942171709440000.0};
  if (a * a < kSeriesSquaredAngle) return polynomial(kSeries, a * a);
  return (2.0 + std::cos(a) - 3.0 * std::sin(a) / a) / (2.0 * a * a * a * a);
}

}  // namespace detail

/// Skew-symmetric matrix with `hat(a) * b == a.cross(b)`.
inline Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

namespace detail {

/// 1 + a hat(v) + b hat(v)². Element by element: products of matrices that are half zeros would
/// take longer, to compile too.
inline Eigen::Matrix3d rotation_polynomial(const Eigen::Vector3d& v, double a, double b) noexcept {
  const double x = v.x();
  const double y = v.y();
  const double z = v.z();
  Eigen::Matrix3d m;
  m(0, 0) = 1.0 - b * (y * y + z * z);
  m(1, 1) = 1.0 - b * (x * x + z * z);
  m(2, 2) = 1.0 - b * (x * x + y * y);
  m(0, 1) = b * (x * y) - a * z;
  m(1, 0) = b * (x * y) + a * z;
  m(0, 2) = b * (x * z) + a * y;
  m(2, 0) = b * (x * z) - a * y;
  m(1, 2) = b * (y * z) - a * x;
  m(2, 1) = b * (y * z) + a * x;
  return m;
}

}  // namespace detail

/// Unit quaternion of a rotation with w >= 0. Half a turn (w = 0) has two of them; the one whose
/// largest component is positive is returned. Precondition: `rotation` is a proper rotation up to
/// rounding; see orthonormalized().
inline Eigen::Quaterniond unit_quaternion(const Eigen::Matrix3d& rotation) {
  // An infinity could leave no trace in the quotients below.
  if (!rotation.allFinite()) {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    return {undefined, undefined, undefined, undefined};
  }
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  q.normalize();
  return q;
}

/// Rotation matrix of a rotation vector [rad]: the turn by |v| about v. Any length is accepted.
inline Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_vector_rad) {
  const double angle = detail::safe_norm(rotation_vector_rad);
  // The second-order term is below the last bit here, and dividing by the angle would be inexact
  // for subnormal numbers.
  if (angle < 1e-100) return detail::rotation_polynomial(rotation_vector_rad, 1.0, 0.0);
  const double half_sin = std::sin(0.5 * angle);
  return detail::rotation_polynomial(rotation_vector_rad / angle, std::sin(angle),
                                     2.0 * half_sin * half_sin);
}

/// Rotation vector [rad] of a rotation, angle in [0, π], accurate near both ends. At exactly half
/// a turn both signs of the axis are right; the one whose largest component is positive is
/// returned. Precondition: `rotation` is a proper rotation up to rounding; see orthonormalized().
inline Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q = unit_quaternion(rotation);
  const Eigen::Vector3d v(q.x(), q.y(), q.z());
  const double half_sin = detail::safe_norm(v);
  if (half_sin < 1e-100) return 2.0 * v;
  return 2.0 * std::atan2(half_sin, q.w()) / half_sin * v;
}

/// Angle [rad] of a rotation in [0, π], accurate for tiny angles and near π, where the arc cosine
/// of the trace loses half of the digits. Precondition as for so3_log().
inline double rotation_angle_rad(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q = unit_quaternion(rotation);
  return 2.0 * std::atan2(detail::safe_norm(Eigen::Vector3d(q.x(), q.y(), q.z())), q.w());
}

/// Left Jacobian J of SO(3): `so3_exp(v + J^-1 d) = so3_exp(d) so3_exp(v)` to first order in d.
inline Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& rotation_vector_rad) {
  const double angle = detail::safe_norm(rotation_vector_rad);
  if (angle < 1.0) {
    return detail::rotation_polynomial(rotation_vector_rad, detail::one_minus_cos_over_a2(angle),
                                       detail::a_minus_sin_over_a3(angle));
  }
  // In terms of the axis nothing overflows, however long the vector is.
  const double half_sin = std::sin(0.5 * angle);
  return detail::rotation_polynomial(rotation_vector_rad / angle, 2.0 * half_sin * half_sin / angle,
                                     1.0 - std::sin(angle) / angle);
}

/// Inverse of so3_left_jacobian(). Defined for |v| < 2π; so3_log() never leaves [0, π]. Near a
/// full turn its elements grow without bound.
inline Eigen::Matrix3d so3_left_jacobian_inverse(const Eigen::Vector3d& rotation_vector_rad) {
  const double angle = detail::safe_norm(rotation_vector_rad);
  return detail::rotation_polynomial(rotation_vector_rad, -0.5,
                                     detail::one_minus_half_cot_over_a2(angle));
}

/// Rigid motion of a tangent vector [m, rad]: the screw motion that a constant body velocity
/// `tangent` makes in one unit of time.
inline Pose se3_exp(const Vector6& tangent) {
  const Eigen::Vector3d translation = tangent.head<3>();
  const Eigen::Vector3d rotation = tangent.tail<3>();
  Pose T = Pose::Identity();
  T.linear() = so3_exp(rotation);
  T.translation() = so3_left_jacobian(rotation) * translation;
  return T;
}

/// Inverse of se3_exp() with a rotation angle in [0, π]; see so3_log() for half a turn.
inline Vector6 se3_log(const Pose& T) {
  const Eigen::Vector3d rotation = so3_log(T.linear());
  Vector6 tangent;
  tangent.head<3>() = so3_left_jacobian_inverse(rotation) * T.translation();
  tangent.tail<3>() = rotation;
  return tangent;
}

/// Adjoint: `xi_a = se3_adjoint(T_a_b) * xi_b` expresses a twist of frame b in frame a, so that
/// `T_a_b * se3_exp(xi_b) = se3_exp(xi_a) * T_a_b`.
inline Matrix6 se3_adjoint(const Pose& T_a_b) {
  const Eigen::Matrix3d rotation = T_a_b.linear();
  const Eigen::Vector3d translation = T_a_b.translation();
  Matrix6 adjoint;
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.topRightCorner<3, 3>() = hat(translation) * rotation;
  adjoint.bottomLeftCorner<3, 3>().setZero();
  adjoint.bottomRightCorner<3, 3>() = rotation;
  return adjoint;
}

namespace detail {

/// Upper right block of the left Jacobian of SE(3) (Barfoot 2017, Eq. 7.86).
inline Eigen::Matrix3d se3_left_jacobian_q(const Vector6& tangent) {
  const Eigen::Vector3d rotation = tangent.tail<3>();
  const double angle = safe_norm(rotation);
  const Eigen::Matrix3d p = hat(tangent.head<3>());
  const Eigen::Matrix3d r = hat(rotation);
  const Eigen::Matrix3d rp = r * p;
  const Eigen::Matrix3d pr = p * r;
  const Eigen::Matrix3d rpr = rp * r;
  return 0.5 * p + a_minus_sin_over_a3(angle) * (rp + pr + rpr) +
         cos_remainder_over_a4(angle) * (r * rp + pr * r - 3.0 * rpr) +
         sin_cos_remainder_over_a5(angle) * (rpr * r + r * rpr);
}

}  // namespace detail

/// Left Jacobian J of SE(3): `se3_exp(xi + J^-1 d) = se3_exp(d) se3_exp(xi)` to first order in d.
/// The right Jacobian of xi is the left one of -xi.
inline Matrix6 se3_left_jacobian(const Vector6& tangent) {
  const Eigen::Matrix3d rotation_jacobian = so3_left_jacobian(tangent.tail<3>());
  Matrix6 jacobian;
  jacobian.topLeftCorner<3, 3>() = rotation_jacobian;
  jacobian.topRightCorner<3, 3>() = detail::se3_left_jacobian_q(tangent);
  jacobian.bottomLeftCorner<3, 3>().setZero();
  jacobian.bottomRightCorner<3, 3>() = rotation_jacobian;
  return jacobian;
}

/// Inverse of se3_left_jacobian(). Defined for a rotation below 2π, as so3_left_jacobian_inverse().
inline Matrix6 se3_left_jacobian_inverse(const Vector6& tangent) {
  const Eigen::Matrix3d rotation_inverse = so3_left_jacobian_inverse(tangent.tail<3>());
  Matrix6 inverse;
  inverse.topLeftCorner<3, 3>() = rotation_inverse;
  inverse.topRightCorner<3, 3>() =
      -rotation_inverse * detail::se3_left_jacobian_q(tangent) * rotation_inverse;
  inverse.bottomLeftCorner<3, 3>().setZero();
  inverse.bottomRightCorner<3, 3>() = rotation_inverse;
  return inverse;
}

/// Point at `fraction` of the geodesic from `T_w_a` (0) to `T_w_b` (1), i.e. a motion with constant
/// body velocity; both ends are returned bit by bit. Outside [0, 1] it extrapolates. Commutes with
/// a change of the world frame and of the body frame. At a relative turn of exactly π two geodesics
/// are equally short; so3_log() says which is taken.
inline Pose se3_interpolate(const Pose& T_w_a, const Pose& T_w_b, double fraction) {
  if (fraction == 0.0) return T_w_a;
  if (fraction == 1.0) return T_w_b;
  const Pose T_a_b = T_w_a.inverse() * T_w_b;
  return T_w_a * se3_exp(fraction * se3_log(T_a_b));
}

/// Pose of a translation [m] and a quaternion, which is normalised. Fails with kInvalidArgument
/// and leaves `pose` alone when a number is not finite or the quaternion's norm is below 1e-6 (a
/// unit quaternion was meant and something went wrong). `pose` must not be null.
inline Status pose_from_quaternion(const Eigen::Vector3d& translation_m,
                                   const Eigen::Quaterniond& quaternion, Pose* pose) {
  if (pose == nullptr) {
    return Status::failure(StatusCode::kInvalidArgument, "output pose is null");
  }
  if (!translation_m.allFinite()) {
    return Status::failure(StatusCode::kInvalidArgument, "translation is not finite");
  }
  if (!quaternion.coeffs().allFinite()) {
    return Status::failure(StatusCode::kInvalidArgument, "quaternion is not finite");
  }
  const double norm = detail::safe_norm(quaternion.coeffs().data(), 4);
  if (!(norm >= 1e-6) || !std::isfinite(norm)) {
    return Status::failure(StatusCode::kInvalidArgument,
                           "quaternion norm is zero or too large; expected a unit quaternion");
  }
  const Eigen::Quaterniond unit(quaternion.coeffs() / norm);
  *pose = Pose::Identity();
  pose->linear() = unit.toRotationMatrix();
  pose->translation() = translation_m;
  return Status::success();
}

}  // namespace srslam
