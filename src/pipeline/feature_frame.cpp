#include "pipeline/feature_frame.hpp"

#include <limits>

namespace srslam::detail {

TrackingCamera make_tracking_camera(const PinholeCamera& camera,
                                    const std::vector<float>& level_scales, double scale_factor,
                                    double virtual_baseline_m) {
  TrackingCamera result;
  result.distorted = camera;
  result.fx = camera.fx_px;
  result.fy = camera.fy_px;
  result.cx = camera.cx_px;
  result.cy = camera.cy_px;
  result.baseline_fx = virtual_baseline_m * camera.fx_px;
  result.level_scales = level_scales;
  result.log_scale_factor = std::log(scale_factor);

  // The undistorted area bulges or caves in between the corners, so the whole outline is asked.
  const double infinity = std::numeric_limits<double>::infinity();
  result.min_u = result.min_v = infinity;
  result.max_u = result.max_v = -infinity;
  const auto include = [&](double u, double v) {
    Eigen::Vector2d ideal;
    if (!camera.undistort_pixel({u, v}, &ideal)) return;
    result.min_u = std::min(result.min_u, ideal.x());
    result.max_u = std::max(result.max_u, ideal.x());
    result.min_v = std::min(result.min_v, ideal.y());
    result.max_v = std::max(result.max_v, ideal.y());
  };
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = -0.5 + camera.width_px * double(i) / kSteps;
    const double v = -0.5 + camera.height_px * double(i) / kSteps;
    include(u, -0.5);
    include(u, camera.height_px - 0.5);
    include(-0.5, v);
    include(camera.width_px - 0.5, v);
  }
  if (!(result.min_u < result.max_u && result.min_v < result.max_v)) {
    // A model that folds over along the whole outline: fall back to the image itself.
    result.min_u = result.min_v = -0.5;
    result.max_u = camera.width_px - 0.5;
    result.max_v = camera.height_px - 0.5;
  }
  return result;
}

void FeatureFrame::assign(const TrackingCamera& camera, OrbFeatures* extracted,
                          const ImageView<const float>& depth_m, double min_depth_m,
                          double max_depth_m) {
  features.swap(extracted->features);
  descriptors.swap(extracted->descriptors);
  measurements.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Feature& feature = features[i];
    Measurement measurement;
    if (!camera.distorted.undistort_pixel({feature.u_px, feature.v_px}, &measurement.pixel) ||
        !camera.in_image(measurement.pixel.x(), measurement.pixel.y())) {
      continue;
    }
    const int u = static_cast<int>(std::lround(feature.u_px));
    const int v = static_cast<int>(std::lround(feature.v_px));
    if (depth_m.contains(u, v)) {
      const double depth = depth_m(u, v);
      if (depth > min_depth_m && depth < max_depth_m) {  // false for NaN
        measurement.depth_m = depth;
        measurement.disparity_px = camera.baseline_fx / depth;
      }
    }
    measurements.push_back(measurement);
    features[kept] = feature;
    descriptors[kept] = descriptors[i];
    ++kept;
  }
  features.resize(kept);
  descriptors.resize(kept);
  points.assign(kept, PointHandle{});

  min_u_ = camera.min_u;
  min_v_ = camera.min_v;
  cols_per_px_ = kBucketCols / (camera.max_u - camera.min_u);
  rows_per_px_ = kBucketRows / (camera.max_v - camera.min_v);
  fill_buckets();
}

void FeatureFrame::fill_buckets() {
  const std::size_t kept = measurements.size();
  // Counting sort into buckets keeps features in index order within each.
  const auto bucket_of = [&](const Measurement& measurement) {
    const int col = std::clamp(bucket_col(measurement.pixel.x()), 0, kBucketCols - 1);
    const int row = std::clamp(bucket_row(measurement.pixel.y()), 0, kBucketRows - 1);
    return static_cast<std::size_t>(row * kBucketCols + col);
  };
  constexpr auto kNumBuckets = static_cast<std::size_t>(kBucketCols * kBucketRows);
  bucket_begin_.assign(kNumBuckets + 1, 0);
  for (const Measurement& measurement : measurements) ++bucket_begin_[bucket_of(measurement) + 1];
  for (std::size_t i = 0; i < kNumBuckets; ++i) bucket_begin_[i + 1] += bucket_begin_[i];
  bucket_items_.resize(kept);
  for (std::size_t i = kept; i-- > 0;) {
    // Filling from the back with the end offsets leaves bucket_begin_ at the starts again.
    std::int32_t& end = bucket_begin_[bucket_of(measurements[i]) + 1];
    bucket_items_[static_cast<std::size_t>(--end)] = static_cast<std::int32_t>(i);
  }
  // Each end offset is now its bucket's start: shift back into place.
  for (std::size_t i = 0; i < kNumBuckets; ++i) bucket_begin_[i] = bucket_begin_[i + 1];
  bucket_begin_[kNumBuckets] = static_cast<std::int32_t>(kept);
}

}  // namespace srslam::detail
