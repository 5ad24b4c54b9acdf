#include "synthetic/texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace srslam::detail {
namespace {

/// Largest integer not above `value`, without a call into the mathematics library.
int floor_to_int(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

/// Index in [0, size) of a texel on the picture that goes on mirrored.
int mirrored(int index, int size) {
  if (index >= 0 && index < size) return index;
  const int period = 2 * size;
  index %= period;
  if (index < 0) index += period;
  return index < size ? index : period - 1 - index;
}

}  // namespace

Texture::Texture(const ImageView<const Bgr8>& image, double width_m)
    : texels_per_m_(image.width_px / width_m) {
  Level base;
  base.width = image.width_px;
  base.height = image.height_px;
  base.texels.reserve(static_cast<std::size_t>(base.width) * static_cast<std::size_t>(base.height));
  for (int v = 0; v < base.height; ++v) {
    const Bgr8* row = image.row(v);
    for (int u = 0; u < base.width; ++u) base.texels.push_back({row[u].b, row[u].g, row[u].r, 0});
  }
  levels_.push_back(std::move(base));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.width = std::max(1, fine.width / 2);
    coarse.height = std::max(1, fine.height / 2);
    coarse.texels.resize(static_cast<std::size_t>(coarse.width) *
                         static_cast<std::size_t>(coarse.height));
    for (int v = 0; v < coarse.height; ++v) {
      for (int u = 0; u < coarse.width; ++u) {
        auto& texel =
            coarse.texels[static_cast<std::size_t>(v) * static_cast<std::size_t>(coarse.width) +
                          static_cast<std::size_t>(u)];
        for (std::size_t channel = 0; channel < 3; ++channel) {
          int sum = 2;
          for (int k = 0; k < 4; ++k) {
            const int x = std::min(2 * u + (k & 1), fine.width - 1);
            const int y = std::min(2 * v + (k >> 1), fine.height - 1);
            sum += fine.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(fine.width) +
                               static_cast<std::size_t>(x)][channel];
          }
          texel[channel] = static_cast<std::uint8_t>(sum / 4);
        }
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

Eigen::Vector4f Texture::bilinear(const Level& level, double x, double y) {
  const int left = floor_to_int(x);
  const int top = floor_to_int(y);
  const auto ax = static_cast<float>(x - left);
  const auto ay = static_cast<float>(y - top);
  const int u0 = mirrored(left, level.width);
  const int u1 = mirrored(left + 1, level.width);
  const int v0 = mirrored(top, level.height);
  const int v1 = mirrored(top + 1, level.height);
  const auto texel = [&](int u, int v) {
    const auto& t =
        level.texels[static_cast<std::size_t>(v) * static_cast<std::size_t>(level.width) +
                     static_cast<std::size_t>(u)];
    return Eigen::Vector4f(t[0], t[1], t[2], t[3]);
  };
  const Eigen::Vector4f upper = (1.0F - ax) * texel(u0, v0) + ax * texel(u1, v0);
  const Eigen::Vector4f lower = (1.0F - ax) * texel(u0, v1) + ax * texel(u1, v1);
  return (1.0F - ay) * upper + ay * lower;
}

Eigen::Vector3f Texture::sample(double u_m, double v_m, double footprint_m) const {
  const double x = u_m * texels_per_m_;
  const double y = v_m * texels_per_m_;
  const float level =
      std::clamp(std::log2(std::max(1.0F, static_cast<float>(footprint_m * texels_per_m_))), 0.0F,
                 static_cast<float>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(fine);
  const double fine_scale = 1.0 / static_cast<double>(std::uint64_t{1} << fine);
  // Texel centres lie at half integers.
  Eigen::Vector4f color = bilinear(levels_[fine], x * fine_scale - 0.5, y * fine_scale - 0.5);
  if (blend != 0.0F) {
    const Eigen::Vector4f coarse =
        bilinear(levels_[fine + 1], 0.5 * x * fine_scale - 0.5, 0.5 * y * fine_scale - 0.5);
    color += blend * (coarse - color);
  }
  return color.head<3>();
}

}  // namespace srslam::detail
