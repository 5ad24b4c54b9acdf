#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "srslam/core/image_view.hpp"

namespace srslam::detail {

/// A surface's picture with smaller copies of itself, so that distant surfaces do not flicker.
/// Coordinates in metres from the upper left corner, to the right and down; beyond its edges the
/// picture goes on mirrored.
class Texture {
 public:
  Texture() = default;
  /// `image` covers `width_m` by its height in square texels.
  Texture(const ImageView<const Bgr8>& image, double width_m);

  /// Colour (b, g, r in 0 to 255) averaged over about `footprint_m`.
  Eigen::Vector3f sample(double u_m, double v_m, double footprint_m) const;

 private:
  struct Level {
    std::vector<std::array<std::uint8_t, 4>> texels;
    int width = 0;
    int height = 0;
  };
  static Eigen::Vector4f bilinear(const Level& level, double x, double y);

  std::vector<Level> levels_;
  double texels_per_m_ = 1.0;
};

}  // namespace srslam::detail
