#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/positive_definite.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// Maps reference pixels (u, v, 1) to current ones.
using AffineFlow = Eigen::Matrix<double, 2, 3, Eigen::DontAlign>;

/// Buffers of dominant_motion(), kept by the caller so that a steady stream allocates nothing.
struct DominantMotionWorkspace {
  std::vector<std::int32_t> track;  ///< index of the usable track
  // Usable tracks: point in the reference camera [m] (kAffine: pixel, 1), current pixel without
  // distortion.
  std::vector<float> x, y, z, u_px, v_px;
  std::vector<float> squared_error_px2;
  std::vector<std::uint8_t> owner;  ///< motion that the track belongs to, or kNoOwner
  std::vector<std::int32_t> active, scored;
  std::vector<float> depth_sorted_m;
  static constexpr std::uint8_t kNoOwner = 255;
};

namespace detail {

constexpr float kBehindCamera_px2 = 1e12F;
constexpr double kNoLimit_px2 = std::numeric_limits<double>::infinity();

/// Tukey's biweight: what is hardly within the limit hardly pulls. 1 under kNoLimit_px2.
inline double tukey_weight(double squared_px2, double limit_px2) noexcept {
  const double rest = 1.0 - squared_px2 / limit_px2;
  return rest > 0.0 ? rest * rest : 0.0;
}

/// Motion model of rigid flow. Points in the reference camera, projected without distortion.
struct RigidModel {
  using Parameters = Pose;
  double fx, fy, cx, cy;

  explicit RigidModel(const PinholeCamera& camera) noexcept
      : fx(camera.fx_px), fy(camera.fy_px), cx(camera.cx_px), cy(camera.cy_px) {}

  void squared_errors(const Pose& T_current_reference, const DominantMotionWorkspace& w,
                      ArrayView<const std::int32_t> indices, float* squared_px2) const noexcept {
    const Eigen::Matrix3f R = T_current_reference.linear().cast<float>();
    const Eigen::Vector3f t = T_current_reference.translation().cast<float>();
    const auto fu = float(fx);
    const auto fv = float(fy);
    const auto cu = float(cx);
    const auto cv = float(cy);
    for (std::size_t k = 0; k < indices.size; ++k) {
      const auto i = static_cast<std::size_t>(indices[k]);
      const float px = R(0, 0) * w.x[i] + R(0, 1) * w.y[i] + R(0, 2) * w.z[i] + t.x();
      const float py = R(1, 0) * w.x[i] + R(1, 1) * w.y[i] + R(1, 2) * w.z[i] + t.y();
      const float pz = R(2, 0) * w.x[i] + R(2, 1) * w.y[i] + R(2, 2) * w.z[i] + t.z();
      const float inverse = 1.0F / pz;
      const float du = fu * px * inverse + cu - w.u_px[i];
      const float dv = fv * py * inverse + cv - w.v_px[i];
      const float squared = du * du + dv * dv;
      squared_px2[k] = pz > 1e-3F ? squared : kBehindCamera_px2;
    }
  }

  /// One Gauss-Newton step over the tracks within the limit; false when they do not determine the
  /// pose.
  bool step(const DominantMotionWorkspace& w, ArrayView<const std::int32_t> indices,
            double limit_px2, Pose* T_current_reference, double* step_norm) const noexcept {
    Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
    const Eigen::Matrix3d R = T_current_reference->linear();
    const Eigen::Vector3d t = T_current_reference->translation();
    Eigen::Matrix<double, 6, 1> row_u;
    Eigen::Matrix<double, 6, 1> row_v;
    for (std::size_t k = 0; k < indices.size; ++k) {
      const auto i = static_cast<std::size_t>(indices[k]);
      const Eigen::Vector3d p =
          R * Eigen::Vector3d(double(w.x[i]), double(w.y[i]), double(w.z[i])) + t;
      if (!(p.z() > 1e-3)) continue;
      const double inverse = 1.0 / p.z();
      const double x = p.x() * inverse;
      const double y = p.y() * inverse;
      const double du = fx * x + cx - double(w.u_px[i]);
      const double dv = fy * y + cy - double(w.v_px[i]);
      const double weight = tukey_weight(du * du + dv * dv, limit_px2);
      if (weight <= 0.0) continue;
      // d(u, v) / d(perturbation of T on the left).
      row_u << fx * inverse, 0.0, -fx * x * inverse, -fx * x * y, fx * (1.0 + x * x), -fx * y;
      row_v << 0.0, fy * inverse, -fy * y * inverse, -fy * (1.0 + y * y), fy * x * y, fy * x;
      for (int c = 0; c < 6; ++c) {
        const double weighted_u = weight * row_u[c];
        const double weighted_v = weight * row_v[c];
        for (int r = c; r < 6; ++r) {
          hessian(r, c) += row_u[r] * weighted_u + row_v[r] * weighted_v;
        }
        gradient[c] += du * weighted_u + dv * weighted_v;
      }
    }
    Eigen::Matrix<double, 6, 1> delta = -gradient;
    if (!solve_positive_definite(1e-14, &hessian, &delta) || !delta.allFinite()) return false;
    *step_norm = delta.norm();
    *T_current_reference = se3_exp(delta) * *T_current_reference;
    return true;
  }

  static Pose identity() noexcept { return Pose::Identity(); }

  /// Where the motion takes usable track `i`; false behind the camera.
  bool predict(const Pose& T_current_reference, const DominantMotionWorkspace& w, std::size_t i,
               Eigen::Vector2d* pixel) const noexcept {
    const Eigen::Vector3d p =
        T_current_reference * Eigen::Vector3d(double(w.x[i]), double(w.y[i]), double(w.z[i]));
    if (!(p.z() > 1e-3)) return false;
    *pixel = Eigen::Vector2d(fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy);
    return true;
  }

  /// The pose that takes three tracks where they are, from the given one; false when there is none
  /// near it.
  bool fit_sample(const DominantMotionWorkspace& w, const std::array<std::int32_t, 3>& sample,
                  Pose* T_current_reference) const noexcept {
    constexpr int kMaxSteps = 8;
    constexpr double kConverged = 1e-6;
    const ArrayView<const std::int32_t> indices{sample.data(), sample.size()};
    double step_norm = 0.0;
    for (int i = 0; i < kMaxSteps; ++i) {
      if (!step(w, indices, kNoLimit_px2, T_current_reference, &step_norm)) return false;
      // Beyond a metre or a radian the sample is no motion between near frames.
      if (step_norm > 2.0) return false;
      if (step_norm < kConverged) return true;
    }
    return step_norm < 1e-3;
  }
};

/// Motion model of affine flow. Pixels of the reference frame in x and y.
struct AffineModel {
  using Parameters = AffineFlow;

  void squared_errors(const AffineFlow& affine, const DominantMotionWorkspace& w,
                      ArrayView<const std::int32_t> indices, float* squared_px2) const noexcept {
    const Eigen::Matrix<float, 2, 3> a = affine.cast<float>();
    for (std::size_t k = 0; k < indices.size; ++k) {
      const auto i = static_cast<std::size_t>(indices[k]);
      const float du = a(0, 0) * w.x[i] + a(0, 1) * w.y[i] + a(0, 2) - w.u_px[i];
      const float dv = a(1, 0) * w.x[i] + a(1, 1) * w.y[i] + a(1, 2) - w.v_px[i];
      squared_px2[k] = du * du + dv * dv;
    }
  }

  /// Weighted least squares, which needs no iteration but for the weights.
  bool step(const DominantMotionWorkspace& w, ArrayView<const std::int32_t> indices,
            double limit_px2, AffineFlow* affine, double* step_norm) const noexcept {
    // About the mean, for the sake of the equations' condition.
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    double weight_sum = 0.0;
    const auto weight_at = [&](std::size_t i, Eigen::Vector2d* pixel) {
      *pixel = Eigen::Vector2d(double(w.x[i]), double(w.y[i]));
      const Eigen::Vector2d error = affine->leftCols<2>() * *pixel + affine->col(2) -
                                    Eigen::Vector2d(double(w.u_px[i]), double(w.v_px[i]));
      return tukey_weight(error.squaredNorm(), limit_px2);
    };
    Eigen::Vector2d pixel;
    for (const std::int32_t index : indices) {
      const double weight = weight_at(static_cast<std::size_t>(index), &pixel);
      mean += weight * pixel;
      weight_sum += weight;
    }
    if (!(weight_sum > 0.0)) return false;
    mean /= weight_sum;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    for (const std::int32_t index : indices) {
      const auto i = static_cast<std::size_t>(index);
      const double weight = weight_at(i, &pixel);
      const Eigen::Vector3d row(pixel.x() - mean.x(), pixel.y() - mean.y(), 1.0);
      normal += weight * row * row.transpose();
      right += weight * row * Eigen::RowVector2d(double(w.u_px[i]), double(w.v_px[i]));
    }
    if (!solve_positive_definite(1e-12, &normal, &right) || !right.allFinite()) return false;
    AffineFlow fitted;
    fitted.leftCols<2>() = right.topRows<2>().transpose();
    fitted.col(2) = right.row(2).transpose() - fitted.leftCols<2>() * mean;
    *step_norm = (fitted - *affine).norm();
    *affine = fitted;
    return true;
  }

  static AffineFlow identity() noexcept { return AffineFlow::Identity(); }

  bool predict(const AffineFlow& affine, const DominantMotionWorkspace& w, std::size_t i,
               Eigen::Vector2d* pixel) const noexcept {
    *pixel = affine.leftCols<2>() * Eigen::Vector2d(double(w.x[i]), double(w.y[i])) + affine.col(2);
    return true;
  }

  bool fit_sample(const DominantMotionWorkspace& w, const std::array<std::int32_t, 3>& sample,
                  AffineFlow* affine) const noexcept {
    double step_norm = 0.0;
    return step(w, {sample.data(), sample.size()}, kNoLimit_px2, affine, &step_norm);
  }
};

inline void clear_tracks(std::size_t capacity, DominantMotionWorkspace* w) {
  w->track.clear();
  w->track.reserve(capacity);
  for (std::vector<float>* values : {&w->x, &w->y, &w->z, &w->u_px, &w->v_px}) {
    values->clear();
    values->reserve(capacity);
  }
}

/// Alive tracks with reference depth, as points in the reference camera and undistorted pixels.
inline void collect_rigid_tracks(ArrayView<const FlowTrack> tracks, const PinholeCamera& camera,
                                 DominantMotionWorkspace* w) {
  clear_tracks(tracks.size, w);
  Eigen::Vector3d point_m;
  Eigen::Vector2d pixel;
  for (std::size_t i = 0; i < tracks.size; ++i) {
    const FlowTrack& track = tracks[i];
    if (!track.alive ||
        !camera.unproject({double(track.reference.u_px), double(track.reference.v_px)},
                          double(track.reference.depth_m), &point_m) ||
        !camera.undistort_pixel({double(track.current.u_px), double(track.current.v_px)}, &pixel)) {
      continue;
    }
    w->track.push_back(static_cast<std::int32_t>(i));
    w->x.push_back(float(point_m.x()));
    w->y.push_back(float(point_m.y()));
    w->z.push_back(float(point_m.z()));
    w->u_px.push_back(float(pixel.x()));
    w->v_px.push_back(float(pixel.y()));
  }
}

/// Alive tracks, as pixels of the reference frame and of the current one.
inline void collect_affine_tracks(ArrayView<const FlowTrack> tracks, DominantMotionWorkspace* w) {
  clear_tracks(tracks.size, w);
  for (std::size_t i = 0; i < tracks.size; ++i) {
    const FlowTrack& track = tracks[i];
    if (!track.alive || !std::isfinite(track.reference.u_px + track.reference.v_px) ||
        !std::isfinite(track.current.u_px + track.current.v_px)) {
      continue;
    }
    w->track.push_back(static_cast<std::int32_t>(i));
    w->x.push_back(track.reference.u_px);
    w->y.push_back(track.reference.v_px);
    w->u_px.push_back(track.current.u_px);
    w->v_px.push_back(track.current.v_px);
  }
}

}  // namespace detail

}  // namespace srslam
