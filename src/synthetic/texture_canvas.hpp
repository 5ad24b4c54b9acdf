#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>

#include "synthetic/random.hpp"
#include "synthetic/texture_painter.hpp"

namespace srslam::detail {

/// Smooth noise in [-1, 1] that never repeats: values at the corners of a lattice, blended.
inline float value_noise(std::uint64_t seed, float x, float y) {
  const float left = std::floor(x);
  const float top = std::floor(y);
  const auto corner = [&](float cx, float cy) {
    const auto ix = static_cast<std::uint64_t>(static_cast<std::int64_t>(cx));
    const auto iy = static_cast<std::uint64_t>(static_cast<std::int64_t>(cy));
    const std::uint64_t bits = mix_bits(seed ^ mix_bits(ix * 0x9e3779b97f4a7c15ULL + iy));
    return static_cast<float>(bits >> 40) * (2.0F / 16777216.0F) - 1.0F;
  };
  const float ax = x - left;
  const float ay = y - top;
  const float bx = ax * ax * (3.0F - 2.0F * ax);
  const float by = ay * ay * (3.0F - 2.0F * ay);
  const float upper = (1.0F - bx) * corner(left, top) + bx * corner(left + 1.0F, top);
  const float lower = (1.0F - bx) * corner(left, top + 1.0F) + bx * corner(left + 1.0F, top + 1.0F);
  return (1.0F - by) * upper + by * lower;
}

/// Noise over several sizes, each half as large and as strong as the one before.
inline float fractal_noise(std::uint64_t seed, float x, float y, int octaves) {
  float sum = 0.0F;
  float strength = 0.5F;
  for (int i = 0; i < octaves; ++i) {
    sum += strength * value_noise(seed + static_cast<std::uint64_t>(i) * 7919U, x, y);
    x *= 2.03F;
    y *= 2.03F;
    strength *= 0.55F;
  }
  return sum;
}

/// A picture under construction.
class Canvas {
 public:
  Canvas(double width_m, double height_m, double texel_m)
      : width_m_(width_m),
        texel_m_(texel_m),
        image_(std::clamp(static_cast<int>(std::lround(height_m / texel_m)), 4, 4096),
               std::clamp(static_cast<int>(std::lround(width_m / texel_m)), 4, 4096), CV_8UC3) {}

  cv::Mat& image() { return image_; }
  int texels(double length_m) const {
    return std::max(1, static_cast<int>(std::lround(length_m / texel_m_)));
  }

  /// color_at(x_m, y_m) for every texel.
  template <typename ColorAt>
  void fill(const ColorAt& color_at) {
    for (int v = 0; v < image_.rows; ++v) {
      auto* row = image_.ptr<cv::Vec3b>(v);
      for (int u = 0; u < image_.cols; ++u) {
        const Color color = color_at(static_cast<float>((u + 0.5) * texel_m_),
                                     static_cast<float>((v + 0.5) * texel_m_));
        for (int c = 0; c < 3; ++c) {
          row[u][c] = static_cast<std::uint8_t>(std::clamp(color[c], 0.0F, 255.0F));
        }
      }
    }
  }

  void rectangle(double x_m, double y_m, double width_m, double height_m, const Color& color) {
    cv::rectangle(image_,
                  cv::Rect(texels_at(x_m), texels_at(y_m), texels(width_m), texels(height_m)),
                  scalar(color), cv::FILLED);
  }
  void ellipse(double x_m, double y_m, double semi_x_m, double semi_y_m, double angle_deg,
               const Color& color) {
    cv::ellipse(image_, cv::Point(texels_at(x_m), texels_at(y_m)),
                cv::Size(texels(semi_x_m), texels(semi_y_m)), angle_deg, 0.0, 360.0, scalar(color),
                cv::FILLED, cv::LINE_AA);
  }
  void line(double x0_m, double y0_m, double x1_m, double y1_m, double width_m,
            const Color& color) {
    cv::line(image_, cv::Point(texels_at(x0_m), texels_at(y0_m)),
             cv::Point(texels_at(x1_m), texels_at(y1_m)), scalar(color), texels(width_m),
             cv::LINE_AA);
  }
  /// A line of letters `height_m` tall whose base line starts at (x, y).
  void text(const std::string& letters, double x_m, double y_m, double height_m,
            const Color& color) {
    const double scale = height_m / texel_m_ / 22.0;  // Hershey capitals are 22 units tall
    const int thickness = std::max(1, static_cast<int>(std::lround(scale * 2.0)));
    cv::putText(image_, letters, cv::Point(texels_at(x_m), texels_at(y_m)),
                cv::FONT_HERSHEY_SIMPLEX, scale, scalar(color), thickness, cv::LINE_AA);
  }
  /// Shades the finished picture by `strength` grey levels of noise of the given size.
  void shade(std::uint64_t seed, double size_m, float strength, int octaves) {
    for (int v = 0; v < image_.rows; ++v) {
      auto* row = image_.ptr<cv::Vec3b>(v);
      for (int u = 0; u < image_.cols; ++u) {
        const float change =
            strength * fractal_noise(seed, static_cast<float>(u * texel_m_ / size_m),
                                     static_cast<float>(v * texel_m_ / size_m), octaves);
        for (int c = 0; c < 3; ++c) {
          row[u][c] = static_cast<std::uint8_t>(
              std::clamp(static_cast<float>(row[u][c]) + change, 0.0F, 255.0F));
        }
      }
    }
  }

  Texture texture() const {
    return {ImageView<const Bgr8>(reinterpret_cast<const Bgr8*>(image_.data), image_.cols,
                                  image_.rows, static_cast<std::ptrdiff_t>(image_.step[0])),
            width_m_};
  }

 private:
  int texels_at(double position_m) const {
    return static_cast<int>(std::lround(position_m / texel_m_));
  }
  static cv::Scalar scalar(const Color& color) {
    return {static_cast<double>(color[0]), static_cast<double>(color[1]),
            static_cast<double>(color[2])};
  }

  double width_m_;
  double texel_m_;
  cv::Mat image_;
};

}  // namespace srslam::detail
