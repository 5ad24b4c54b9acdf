#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "srslam/core/array_view.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// `p_reference ≈ scale · R_reference_estimate · p_estimate + t_reference_estimate`.
struct AlignmentResult {
  Status status;
  Eigen::Matrix3d R_reference_estimate = Eigen::Matrix3d::Identity();  ///< determinant +1
  Eigen::Vector3d t_reference_estimate = Eigen::Vector3d::Zero();      ///< [m]
  double scale = 1.0;
  /// The points leave a rotation undetermined, because they lie on a line or in one place. The
  /// rotation given is one of those that fit equally well.
  bool collinear = false;
  Eigen::Vector3d reference_mean = Eigen::Vector3d::Zero();  ///< of the reference points [m]
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();   ///< of the estimate's points [m]
};

/// The cross-covariance of the two point sets counts as being of rank below two, and so the points
/// as collinear, when its second singular value is at most this share of its first. For two equal
/// sets that is an extent across the line of a thousandth of the extent along it.
constexpr double kCollinearSingularValueRatio = 1e-6;

namespace detail {

/// Beyond this the square of a distance would overflow.
constexpr double kMaxMagnitude_m = 1e150;

/// Mean of points far from the origin without the rounding that a plain sum has.
inline Eigen::Vector3d mean_of(ArrayView<const Eigen::Vector3d> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point - points[0];
  return points[0] + sum / static_cast<double>(points.size);
}

}  // namespace detail

/// The rigid motion, and with `with_scale` the similarity, that maps the estimate's points onto the
/// reference's with the least sum of squared distances (Horn 1987; Umeyama, TPAMI 13(4), 1991,
/// Eq. 34–43). A reflection is never given: where it would fit better, the proper rotation that
/// fits best is.
///
/// Points in metres, equal numbers, point i of one corresponding to point i of the other. Fails
/// with kInvalidArgument (different numbers, not finite, or beyond 1e150),
/// kInsufficientData (fewer than three) and, with scale only, kDegenerate (one of the sets lies in
/// one place up to rounding, or the sets are uncorrelated: the scale would be 0 or arbitrary).
/// Linear time, no allocation.
inline AlignmentResult align_trajectories(ArrayView<const Eigen::Vector3d> reference_points,
                                          ArrayView<const Eigen::Vector3d> estimate_points,
                                          bool with_scale) {
  AlignmentResult result;
  const auto fail = [&result](StatusCode code, const char* reason) {
    result.status = Status::failure(code, reason);
    return result;
  };
  if (reference_points.size != estimate_points.size) {
    return fail(StatusCode::kInvalidArgument, "the point sets differ in size");
  }
  if (reference_points.size < 3) {
    return fail(StatusCode::kInsufficientData, "an alignment needs at least three matched poses");
  }
  const std::size_t count = reference_points.size;
  double reference_magnitude = 0.0;
  double estimate_magnitude = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!reference_points[i].allFinite() || !estimate_points[i].allFinite()) {
      return fail(StatusCode::kInvalidArgument, "a point is not finite");
    }
    reference_magnitude =
        std::max(reference_magnitude, reference_points[i].lpNorm<Eigen::Infinity>());
    estimate_magnitude = std::max(estimate_magnitude, estimate_points[i].lpNorm<Eigen::Infinity>());
  }
  if (!(std::max(reference_magnitude, estimate_magnitude) <= detail::kMaxMagnitude_m)) {
    return fail(StatusCode::kInvalidArgument, "positions are too large to compute with");
  }
  result.reference_mean = detail::mean_of(reference_points);
  result.estimate_mean = detail::mean_of(estimate_points);

  double reference_extent = 0.0;
  double estimate_extent = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d reference_offset = reference_points[i] - result.reference_mean;
    const Eigen::Vector3d estimate_offset = estimate_points[i] - result.estimate_mean;
    reference_extent = std::max(reference_extent, reference_offset.lpNorm<Eigen::Infinity>());
    estimate_extent = std::max(estimate_extent, estimate_offset.lpNorm<Eigen::Infinity>());
  }
  // What is left of equal positions after the mean is taken from them.
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon();
  const bool reference_moves = reference_extent > rounding * reference_magnitude;
  const bool estimate_moves = estimate_extent > rounding * estimate_magnitude;

  // Both sets are brought to unit size first: the ratio of singular values is then the same for a
  // path of any length, and nothing overflows.
  Eigen::Matrix3d cross_covariance = Eigen::Matrix3d::Zero();
  double estimate_variance = 0.0;
  if (reference_moves && estimate_moves) {
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d reference_unit =
          (reference_points[i] - result.reference_mean) / reference_extent;
      const Eigen::Vector3d estimate_unit =
          (estimate_points[i] - result.estimate_mean) / estimate_extent;
      cross_covariance += reference_unit * estimate_unit.transpose();
      estimate_variance += estimate_unit.squaredNorm();
    }
    cross_covariance /= static_cast<double>(count);
    estimate_variance /= static_cast<double>(count);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross_covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Not svd.singularValues(): the compiler cannot see that a finite matrix always sets them, and
  // would warn in the programs of users.
  const Eigen::Vector3d singular_values =
      (svd.matrixU().transpose() * cross_covariance * svd.matrixV()).diagonal();
  result.collinear = !(singular_values(1) > kCollinearSingularValueRatio * singular_values(0));
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs(2) = -1.0;
  result.R_reference_estimate = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();

  if (with_scale) {
    if (!reference_moves || !estimate_moves) {
      return fail(StatusCode::kDegenerate,
                  "no scale can be found: one of the trajectories stays in one place");
    }
    result.scale =
        singular_values.dot(signs) / estimate_variance * (reference_extent / estimate_extent);
    if (!std::isfinite(result.scale) || !(result.scale > 0.0)) {
      result.scale = 1.0;
      return fail(StatusCode::kDegenerate,
                  "no scale can be found: the trajectories do not correlate");
    }
  }
  result.t_reference_estimate =
      result.reference_mean - result.scale * (result.R_reference_estimate * result.estimate_mean);
  result.status = Status::success();
  return result;
}

}  // namespace srslam
