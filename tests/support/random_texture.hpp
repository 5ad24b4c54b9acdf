#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "support/rng.hpp"

namespace srslam::test {

/// Smooth random grey values over the whole range: noise blurred by `sigma_px`.
inline cv::Mat random_texture(Rng& rng, int width_px, int height_px, double sigma_px) {
  cv::Mat texture(height_px, width_px, CV_8UC1);
  for (int v = 0; v < texture.rows; ++v) {
    for (int u = 0; u < texture.cols; ++u) {
      texture.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(rng.uniform_int(0, 255));
    }
  }
  cv::GaussianBlur(texture, texture, {0, 0}, sigma_px);
  cv::normalize(texture, texture, 0, 255, cv::NORM_MINMAX);
  return texture;
}

}  // namespace srslam::test
