#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "srslam/core/feature.hpp"
#include "srslam/core/image_view.hpp"

namespace srslam {

/// OpenCV's element type of a pixel type.
template <typename T>
struct MatType;
template <>
struct MatType<std::uint8_t> {
  static constexpr int kValue = CV_8UC1;
};
template <>
struct MatType<std::uint16_t> {
  static constexpr int kValue = CV_16UC1;
};
template <>
struct MatType<float> {
  static constexpr int kValue = CV_32FC1;
};
template <>
struct MatType<Bgr8> {
  static constexpr int kValue = CV_8UC3;
};

/// A cv::Mat header over the view's pixels; nothing is copied, so the storage must outlive it.
/// OpenCV has no read-only Mat: pass the result of a constant view only where it is not written.
template <typename T>
cv::Mat as_mat(const ImageView<T>& view) {
  using Pixel = std::remove_const_t<T>;
  if (view.empty()) return {};
  return cv::Mat(view.height_px, view.width_px, MatType<Pixel>::kValue,
                 const_cast<Pixel*>(view.data), static_cast<std::size_t>(view.stride_bytes));
}

/// A view of `mat`, which must outlive it; empty when the Mat's element type is not T's.
template <typename T>
ImageView<const T> as_view(const cv::Mat& mat) {
  if (mat.empty() || mat.dims != 2 || mat.type() != MatType<T>::kValue) return {};
  return {mat.ptr<T>(), mat.cols, mat.rows, static_cast<std::ptrdiff_t>(mat.step[0])};
}

/// A feature from OpenCV's keypoint, whose angle is in degrees and negative when unknown.
/// `scale` is the size of a pixel of its octave in pixels of level 0.
inline Feature feature_from_keypoint(const cv::KeyPoint& keypoint, float scale) {
  constexpr float kRadiansPerDegree = 0.017453292519943295F;
  Feature feature;
  feature.u_px = keypoint.pt.x;
  feature.v_px = keypoint.pt.y;
  feature.response = keypoint.response;
  feature.angle_rad = keypoint.angle < 0.0F ? 0.0F : keypoint.angle * kRadiansPerDegree;
  feature.scale = scale;
  feature.octave = keypoint.octave;
  return feature;
}

/// The inverse; `size` is the patch diameter in pixels of level 0.
inline cv::KeyPoint keypoint_from_feature(const Feature& feature, float patch_size_px = 31.0F) {
  constexpr float kDegreesPerRadian = 57.29577951308232F;
  return {feature.u_px,
          feature.v_px,
          patch_size_px * feature.scale,
          feature.angle_rad * kDegreesPerRadian,
          feature.response,
          feature.octave,
          -1};
}

}  // namespace srslam
