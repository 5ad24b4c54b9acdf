#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/orb_features.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"

namespace srslam::detail {

/// Refers to a map point without owning it; goes stale when the point leaves the map.
struct PointHandle {
  std::int32_t slot = -1;
  std::uint32_t generation = 0;
  bool assigned() const { return slot >= 0; }
  friend bool operator==(const PointHandle& a, const PointHandle& b) {
    return a.slot == b.slot && a.generation == b.generation;
  }
};

/// What the camera measured of one feature: a pixel of the ideal (undistorted) pinhole camera and,
/// where depth is valid, the disparity that a stereo camera of the virtual baseline would see.
/// Disparity makes depth errors, which grow with the square of depth, uniform in pixels.
struct Measurement {
  Eigen::Vector2d pixel;
  double disparity_px = -1.0;  ///< <= 0: no depth
  double depth_m = -1.0;       ///< <= 0: no depth
  bool has_depth() const { return disparity_px > 0.0; }
};

/// Camera model shared by tracking and mapping: the ideal pinhole camera plus virtual baseline.
struct TrackingCamera {
  PinholeCamera distorted;  ///< as given
  double fx = 0, fy = 0, cx = 0, cy = 0;
  double baseline_fx = 0;                             ///< virtual stereo baseline times fx [m px]
  double min_u = 0, max_u = 0, min_v = 0, max_v = 0;  ///< undistorted image area
  std::vector<float> level_scales;
  double log_scale_factor = 0;

  Eigen::Vector3d project(const Eigen::Vector3d& point_camera_m) const {
    const double inverse_z = 1.0 / point_camera_m.z();
    return {fx * point_camera_m.x() * inverse_z + cx, fy * point_camera_m.y() * inverse_z + cy,
            baseline_fx * inverse_z};
  }
  Eigen::Vector3d unproject(const Eigen::Vector2d& pixel, double depth_m) const {
    return {(pixel.x() - cx) / fx * depth_m, (pixel.y() - cy) / fy * depth_m, depth_m};
  }
  bool in_image(double u, double v) const {
    return u >= min_u && u < max_u && v >= min_v && v < max_v;
  }
};

/// Features of one image with their measurements, bucketed for radius queries.
class FeatureFrame {
 public:
  std::vector<Feature> features;
  std::vector<BinaryDescriptor> descriptors;
  std::vector<Measurement> measurements;
  std::vector<PointHandle> points;  ///< map point that each feature shows

  std::size_t size() const { return features.size(); }

  /// Takes the features over, undistorts them, reads depth and fills the buckets. Features that
  /// the distortion model cannot undistort are dropped.
  void assign(const TrackingCamera& camera, OrbFeatures* extracted,
              const ImageView<const float>& depth_m, double min_depth_m, double max_depth_m);

  /// Drops the features for which `is_removed(index)`; the others keep their order.
  template <typename IsRemoved>
  void remove_if(IsRemoved is_removed);

  std::size_t num_with_depth() const {
    return static_cast<std::size_t>(
        std::count_if(measurements.begin(), measurements.end(),
                      [](const Measurement& measurement) { return measurement.has_depth(); }));
  }

  /// Calls `visit(index)` for features within the square of half side `radius_px` around (u, v)
  /// whose level is in [min_octave, max_octave]. Order is by bucket, then by index.
  template <typename Visit>
  void for_each_near(double u, double v, double radius_px, int min_octave, int max_octave,
                     Visit visit) const;

 private:
  void fill_buckets();

  static constexpr int kBucketCols = 64;
  static constexpr int kBucketRows = 48;
  int bucket_col(double u) const { return static_cast<int>((u - min_u_) * cols_per_px_); }
  int bucket_row(double v) const { return static_cast<int>((v - min_v_) * rows_per_px_); }

  double min_u_ = 0, min_v_ = 0, cols_per_px_ = 0, rows_per_px_ = 0;
  std::vector<std::int32_t> bucket_begin_;
  std::vector<std::int32_t> bucket_items_;
};

template <typename IsRemoved>
void FeatureFrame::remove_if(IsRemoved is_removed) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (is_removed(i)) continue;
    features[kept] = features[i];
    descriptors[kept] = descriptors[i];
    measurements[kept] = measurements[i];
    points[kept] = points[i];
    ++kept;
  }
  if (kept == features.size()) return;
  features.resize(kept);
  descriptors.resize(kept);
  measurements.resize(kept);
  points.resize(kept);
  fill_buckets();
}

template <typename Visit>
void FeatureFrame::for_each_near(double u, double v, double radius_px, int min_octave,
                                 int max_octave, Visit visit) const {
  const int first_col = std::max(0, bucket_col(u - radius_px));
  const int last_col = std::min(kBucketCols - 1, bucket_col(u + radius_px));
  const int first_row = std::max(0, bucket_row(v - radius_px));
  const int last_row = std::min(kBucketRows - 1, bucket_row(v + radius_px));
  for (int row = first_row; row <= last_row; ++row) {
    for (int col = first_col; col <= last_col; ++col) {
      const auto bucket = static_cast<std::size_t>(row * kBucketCols + col);
      for (std::int32_t k = bucket_begin_[bucket]; k < bucket_begin_[bucket + 1]; ++k) {
        const auto index = static_cast<std::size_t>(bucket_items_[static_cast<std::size_t>(k)]);
        const int octave = features[index].octave;
        if (octave < min_octave || octave > max_octave) continue;
        const Eigen::Vector2d& pixel = measurements[index].pixel;
        if (std::abs(pixel.x() - u) > radius_px || std::abs(pixel.y() - v) > radius_px) continue;
        visit(index);
      }
    }
  }
}

/// Builds the tracking camera; the virtual baseline is in metres.
TrackingCamera make_tracking_camera(const PinholeCamera& camera,
                                    const std::vector<float>& level_scales, double scale_factor,
                                    double virtual_baseline_m);

}  // namespace srslam::detail
