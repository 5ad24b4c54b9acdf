#pragma once

#include <cmath>

#include <Eigen/Core>

#include "srslam/core/status.hpp"

namespace srslam {

/// Pinhole camera with radial-tangential (Brown-Conrady) distortion, the model and the coefficient
/// order of OpenCV. Camera frame: x right, y down, z forward [m]. Pixel (u, v): u right, v down,
/// integers at pixel centres. With normalised coordinates (x, y) = (X/Z, Y/Z) and s = x² + y²:
///
///     x_d = x (1 + k1 s + k2 s² + k3 s³) + 2 p1 x y + p2 (s + 2 x²)
///     y_d = y (1 + k1 s + k2 s² + k3 s³) + p1 (s + 2 y²) + 2 p2 x y
///     u = fx x_d + cx,   v = fy y_d + cy
///
/// A polynomial describes a lens only as far as it has been calibrated. Further out it may turn
/// back, and points that no ray of the camera reaches would land inside the image. The model's
/// domain therefore is the set of points where (1) the radial component of the distorted position
/// grows on the whole way from the centre, for which min over t in [0, s] of 1 + 3 k1 t + 5 k2 t² +
/// 7 k3 t³, plus min(0, 6 (p1 y + p2 x)), must be positive, and (2) the Jacobian of the distortion
/// has a positive determinant. project() refuses the rest; undistort() never answers with it.
///
/// Every member is constant time but undistort() and those that use it (Newton, 3 to 6 steps as a
/// rule), allocates nothing, and is re-entrant. On failure outputs are left as they were. Output
/// pointers may be null when the output is not wanted.
struct PinholeCamera {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double k3 = 0.0;

  /// Ok when the image size and focal lengths are positive and all numbers are finite. The
  /// principal point may lie outside the image, as it does in a crop.
  Status validate() const noexcept {
    if (width_px <= 0 || height_px <= 0) {
      return Status::failure(StatusCode::kInvalidArgument, "camera image size must be positive");
    }
    if (!(fx_px > 0.0) || !(fy_px > 0.0) || !std::isfinite(fx_px) || !std::isfinite(fy_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "camera focal lengths must be positive and finite");
    }
    if (!std::isfinite(cx_px) || !std::isfinite(cy_px)) {
      return Status::failure(StatusCode::kInvalidArgument, "camera principal point must be finite");
    }
    if (!std::isfinite(k1) || !std::isfinite(k2) || !std::isfinite(p1) || !std::isfinite(p2) ||
        !std::isfinite(k3)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "camera distortion coefficients must be finite");
    }
    return Status::success();
  }

  bool has_distortion() const noexcept {
    return k1 != 0.0 || k2 != 0.0 || p1 != 0.0 || p2 != 0.0 || k3 != 0.0;
  }

  /// Distorted pixel of a point in the camera frame [m]; it may lie outside the image (see
  /// in_image()). False when the point is not finite, has z <= 0, lies outside the model's domain
  /// (see above), or when the pixel or a requested Jacobian is not representable.
  /// `J_point`: d(u, v)/d(X, Y, Z) [px/m].
  /// `J_intrinsics`: d(u, v)/d(fx, fy, cx, cy, k1, k2, p1, p2, k3).
  bool project(const Eigen::Vector3d& point_camera_m, Eigen::Vector2d* pixel,
               Eigen::Matrix<double, 2, 3>* J_point = nullptr,
               Eigen::Matrix<double, 2, 9>* J_intrinsics = nullptr) const noexcept {
    const double z = point_camera_m.z();
    if (!(z > 0.0) || !point_camera_m.allFinite()) return false;
    const double z_inv = 1.0 / z;
    const Eigen::Vector2d normalized(point_camera_m.x() * z_inv, point_camera_m.y() * z_inv);
    Eigen::Matrix2d J_distort;
    Eigen::Vector2d distorted;
    if (has_distortion()) {
      distorted = distort(normalized, &J_distort);
      if (!in_domain(normalized, J_distort)) return false;
    } else {
      distorted = normalized;
      J_distort.setIdentity();
    }
    const Eigen::Vector2d result(fx_px * distorted.x() + cx_px, fy_px * distorted.y() + cy_px);
    if (!result.allFinite()) return false;

    const double x = normalized.x();
    const double y = normalized.y();
    Eigen::Matrix<double, 2, 3> by_point;
    if (J_point != nullptr) {
      for (int row = 0; row < 2; ++row) {
        const double focal_over_z = (row == 0 ? fx_px : fy_px) * z_inv;
        by_point(row, 0) = focal_over_z * J_distort(row, 0);
        by_point(row, 1) = focal_over_z * J_distort(row, 1);
        by_point(row, 2) = -(x * by_point(row, 0) + y * by_point(row, 1));
      }
      if (!by_point.allFinite()) return false;
    }
    if (J_intrinsics != nullptr) {
      const double s = x * x + y * y;
      const double xy2 = 2.0 * x * y;
      Eigen::Matrix<double, 2, 9> by_intrinsics;
      by_intrinsics << distorted.x(), 0.0, 1.0, 0.0, fx_px * x * s, fx_px * x * s * s, fx_px * xy2,
          fx_px * (s + 2.0 * x * x), fx_px * x * s * s * s,  //
          0.0, distorted.y(), 0.0, 1.0, fy_px * y * s, fy_px * y * s * s, fy_px * (s + 2.0 * y * y),
          fy_px * xy2, fy_px * y * s * s * s;
      if (!by_intrinsics.allFinite()) return false;
      *J_intrinsics = by_intrinsics;
    }
    if (J_point != nullptr) *J_point = by_point;
    if (pixel != nullptr) *pixel = result;
    return true;
  }

  /// Distorted normalised coordinates. Evaluates the polynomial everywhere, also outside the
  /// model's domain. `J`: d(x_d, y_d)/d(x, y).
  Eigen::Vector2d distort(const Eigen::Vector2d& normalized,
                          Eigen::Matrix2d* J = nullptr) const noexcept {
    const double x = normalized.x();
    const double y = normalized.y();
    const double s = x * x + y * y;
    const double radial = 1.0 + s * (k1 + s * (k2 + s * k3));
    const double xy2 = 2.0 * x * y;
    if (J != nullptr) {
      const double radial_slope = 2.0 * (k1 + s * (2.0 * k2 + s * 3.0 * k3));  // d/dx, over x
      const double cross = 0.5 * xy2 * radial_slope + 2.0 * (p1 * x + p2 * y);
      (*J)(0, 0) = radial + x * x * radial_slope + 2.0 * p1 * y + 6.0 * p2 * x;
      (*J)(0, 1) = cross;
      (*J)(1, 0) = cross;
      (*J)(1, 1) = radial + y * y * radial_slope + 6.0 * p1 * y + 2.0 * p2 * x;
    }
    return {x * radial + p1 * xy2 + p2 * (s + 2.0 * x * x),
            y * radial + p1 * (s + 2.0 * y * y) + p2 * xy2};
  }

  /// Inverse of distort() inside the model's domain, to rounding. False when the input is not
  /// finite or no point of the domain is distorted to it.
  bool undistort(const Eigen::Vector2d& distorted_normalized,
                 Eigen::Vector2d* normalized) const noexcept {
    return undistort(distorted_normalized, normalized, nullptr);
  }

  /// Point in the camera frame [m] that `pixel` shows at `depth_m` along the optical axis. False
  /// when the depth is not finite or <= 0, when undistort() fails, or when the point or a requested
  /// Jacobian is not representable.
  /// `J`: d(X, Y, Z)/d(u, v, depth).
  bool unproject(const Eigen::Vector2d& pixel, double depth_m, Eigen::Vector3d* point_camera_m,
                 Eigen::Matrix3d* J = nullptr) const noexcept {
    if (!(depth_m > 0.0) || !std::isfinite(depth_m)) return false;
    const Eigen::Vector2d distorted((pixel.x() - cx_px) / fx_px, (pixel.y() - cy_px) / fy_px);
    Eigen::Vector2d normalized;
    Eigen::Matrix2d J_distort;
    if (!undistort(distorted, &normalized, &J_distort)) return false;
    const Eigen::Vector3d point(normalized.x() * depth_m, normalized.y() * depth_m, depth_m);
    if (!point.allFinite()) return false;

    if (J != nullptr) {
      // The determinant is positive in the model's domain.
      const double scale =
          depth_m / (J_distort(0, 0) * J_distort(1, 1) - J_distort(0, 1) * J_distort(1, 0));
      Eigen::Matrix3d jacobian;
      jacobian << scale * J_distort(1, 1) / fx_px, -scale * J_distort(0, 1) / fy_px, normalized.x(),
          -scale * J_distort(1, 0) / fx_px, scale * J_distort(0, 0) / fy_px, normalized.y(),  //
          0.0, 0.0, 1.0;
      if (!jacobian.allFinite()) return false;
      *J = jacobian;
    }
    if (point_camera_m != nullptr) *point_camera_m = point;
    return true;
  }

  /// Pixel at which a camera of the same intrinsics without distortion would see what `pixel`
  /// shows. False when undistort() fails.
  bool undistort_pixel(const Eigen::Vector2d& pixel,
                       Eigen::Vector2d* undistorted_pixel) const noexcept {
    const Eigen::Vector2d distorted((pixel.x() - cx_px) / fx_px, (pixel.y() - cy_px) / fy_px);
    Eigen::Vector2d normalized;
    if (!undistort(distorted, &normalized, nullptr)) return false;
    const Eigen::Vector2d result(fx_px * normalized.x() + cx_px, fy_px * normalized.y() + cy_px);
    if (!result.allFinite()) return false;
    if (undistorted_pixel != nullptr) *undistorted_pixel = result;
    return true;
  }

  /// The camera of the image resized by `factor` (0.5: half the resolution) about its upper left
  /// corner, which is at (-0.5, -0.5): pixel u becomes (u + 0.5) factor - 0.5. The size is rounded
  /// down to whole pixels. A factor that is not positive and finite gives a camera that validate()
  /// refuses.
  PinholeCamera scaled(double factor) const noexcept {
    PinholeCamera result = *this;
    result.width_px = scaled_size(width_px, factor);
    result.height_px = scaled_size(height_px, factor);
    result.fx_px = fx_px * factor;
    result.fy_px = fy_px * factor;
    result.cx_px = (cx_px + 0.5) * factor - 0.5;
    result.cy_px = (cy_px + 0.5) * factor - 0.5;
    return result;
  }

  /// Whether `pixel` lies in the image and at least `border_px` from its edges, which are at -0.5
  /// and size - 0.5. A border of 0.5 leaves the area that bilinear interpolation can serve. False
  /// for NaN.
  bool in_image(const Eigen::Vector2d& pixel, double border_px = 0.0) const noexcept {
    return pixel.x() >= border_px - 0.5 && pixel.x() < width_px - 0.5 - border_px &&
           pixel.y() >= border_px - 0.5 && pixel.y() < height_px - 0.5 - border_px;
  }

 private:
  bool in_domain(const Eigen::Vector2d& normalized,
                 const Eigen::Matrix2d& J_distort) const noexcept {
    const double det = J_distort(0, 0) * J_distort(1, 1) - J_distort(0, 1) * J_distort(1, 0);
    return det > 0.0 && min_radial_slope(normalized) > 0.0;
  }

  /// Lower bound of the derivative, by the radius, of the radial component of the distorted
  /// position, over the way from the centre to (x, y): the least g(t) = 1 + 3 k1 t + 5 k2 t² +
  /// 7 k3 t³ over [0, s], plus the tangential part 6 (p1 y + p2 x), which is linear in the radius,
  /// where that is negative. NaN and bounds below zero may come out as any number <= 0.
  double min_radial_slope(const Eigen::Vector2d& normalized) const noexcept {
    const double s = normalized.squaredNorm();
    const double tangential = 6.0 * (p1 * normalized.y() + p2 * normalized.x());
    const double offset = 1.0 + (tangential < 0.0 ? tangential : 0.0);
    const double a = 3.0 * k1;
    const double b = 5.0 * k2;
    const double c = 7.0 * k3;
    // Enough for most points: the sum of the negative terms alone.
    const double a_neg = a < 0.0 ? a : 0.0;
    const double b_neg = b < 0.0 ? b : 0.0;
    const double c_neg = c < 0.0 ? c : 0.0;
    const double bound = offset + s * (a_neg + s * (b_neg + s * c_neg));
    if (bound > 0.0) return bound;
    const double end = offset + s * (a + s * (b + s * c));
    if (!(end > 0.0)) return 0.0;
    double least = end < offset ? end : offset;
    // The least value is at an end or at the minimum of the cubic, the root of
    // g' = a + 2 b t + 3 c t² with g'' > 0, which is (-b + root) / (3 c).
    const double discriminant = b * b - 3.0 * a * c;
    if (discriminant > 0.0) {
      const double root = std::sqrt(discriminant);
      // Without cancellation and without a division by c = 0.
      const double t = b > 0.0 ? -a / (b + root) : (root - b) / (3.0 * c);
      if (t > 0.0 && t < s) {
        const double inside = offset + t * (a + t * (b + t * c));
        if (inside < least) least = inside;
      }
    }
    return least;
  }

  bool undistort(const Eigen::Vector2d& target, Eigen::Vector2d* normalized,
                 Eigen::Matrix2d* J_at_solution) const noexcept {
    if (!target.allFinite()) return false;
    if (!has_distortion()) {
      if (normalized != nullptr) *normalized = target;
      if (J_at_solution != nullptr) J_at_solution->setIdentity();
      return true;
    }
    constexpr int kMaxSteps = 50;
    constexpr int kMaxHalvings = 30;
    // Start inside the domain; the centre always is.
    Eigen::Vector2d x = target;
    Eigen::Matrix2d J;
    Eigen::Vector2d error = target - distort(x, &J);
    for (int i = 0; !in_domain(x, J); ++i) {
      x = i < kMaxHalvings ? Eigen::Vector2d(0.5 * x) : Eigen::Vector2d(0.0, 0.0);
      error = target - distort(x, &J);
      if (i > kMaxHalvings) return false;
    }
    // Rounding of the polynomial, with room for a steep slope.
    const double tolerance = 1e-13 * (1.0 + target.norm());
    double error_norm = error.norm();
    const double exact = 1e-16 * target.norm();
    for (int step = 0; step < kMaxSteps && error_norm > exact; ++step) {
      const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
      const Eigen::Vector2d dx((J(1, 1) * error.x() - J(0, 1) * error.y()) / det,
                               (J(0, 0) * error.y() - J(1, 0) * error.x()) / det);
      // Shorten the step until it stays in the domain and lowers the error.
      bool improved = false;
      double length = 1.0;
      for (int i = 0; i < kMaxHalvings; ++i, length *= 0.5) {
        const Eigen::Vector2d candidate = x + length * dx;
        Eigen::Matrix2d candidate_J;
        const Eigen::Vector2d candidate_error = target - distort(candidate, &candidate_J);
        const double candidate_norm = candidate_error.norm();
        if (candidate_norm < error_norm && in_domain(candidate, candidate_J)) {
          x = candidate;
          J = candidate_J;
          error = candidate_error;
          error_norm = candidate_norm;
          improved = true;
          break;
        }
        // At the last bits nothing is gained by searching on.
        if (error_norm <= tolerance) break;
      }
      if (!improved) break;
    }
    if (!(error_norm <= tolerance)) return false;
    if (normalized != nullptr) *normalized = x;
    if (J_at_solution != nullptr) *J_at_solution = J;
    return true;
  }

  static int scaled_size(int size_px, double factor) noexcept {
    // A hair above, so that 3 * (1.0 / 3.0) is 1 whatever the rounding.
    const double scaled = std::floor(size_px * factor + 1e-9);
    return scaled >= 1.0 && scaled <= 2147483647.0 ? static_cast<int>(scaled) : 0;
  }
};

}  // namespace srslam
