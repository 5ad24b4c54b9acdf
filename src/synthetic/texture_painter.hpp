#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "synthetic/texture.hpp"

namespace srslam::detail {

/// Blue, green, red, 0 to 255.
using Color = Eigen::Vector3f;

/// Paints the surfaces of the world. Nothing repeats: every picture has its own seed, and patterns
/// such as stripes and tiles vary in width and shade. `texel_m` is the size of a texel.
class TexturePainter {
 public:
  TexturePainter(std::uint64_t seed, double texel_m) : seed_(seed), texel_m_(texel_m) {}

  /// Rough paint or plaster: shades of one colour within ± `contrast` (grey levels).
  Texture plaster(double width_m, double height_m, const Color& color, float contrast);
  Texture wood(double width_m, double height_m, const Color& color);
  /// Woven floor with flecks and worn paths.
  Texture carpet(double width_m, double height_m, const Color& color);
  Texture cardboard(double width_m, double height_m, bool printed);
  Texture metal(double width_m, double height_m, const Color& color);
  /// Fabric: stripes, checks, flecks or plain, with folds.
  Texture cloth(double width_m, double height_m, const Color& color, int pattern);
  Texture skin(double width_m, double height_m, const Color& color);
  /// A head: face to the front (middle), hair above and behind.
  Texture head(double around_m, double height_m, const Color& skin_color, const Color& hair_color);
  /// Print with a picture, headings and lines of text.
  Texture poster(double width_m, double height_m);
  /// Windows with text on a screen.
  Texture screen(double width_m, double height_m);
  Texture keyboard(double width_m, double height_m);
  Texture sheet(double width_m, double height_m);  ///< printed paper
  Texture book(double width_m, double height_m);   ///< a spine or a cover
  Texture balloon(double width_m, double height_m, const Color& color);
  Texture plain(const Color& color);

 private:
  std::uint64_t next_seed() {
    return seed_ = seed_ * 6364136223846793005ULL + 1442695040888963407ULL;
  }

  std::uint64_t seed_;
  double texel_m_;
};

}  // namespace srslam::detail
