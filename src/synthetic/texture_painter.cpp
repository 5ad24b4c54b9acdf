#include "synthetic/texture_painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "synthetic/random.hpp"
#include "synthetic/texture_canvas.hpp"

namespace srslam::detail {
namespace {

Color random_color(RandomStream& random, double low = 30.0, double high = 225.0) {
  return {static_cast<float>(random.uniform(low, high)),
          static_cast<float>(random.uniform(low, high)),
          static_cast<float>(random.uniform(low, high))};
}

std::string random_word(RandomStream& random, int max_letters = 9) {
  const int length = 2 + random.integer(max_letters - 1);
  std::string word;
  for (int i = 0; i < length; ++i) word += static_cast<char>('a' + random.integer(26));
  return word;
}

std::string random_line(RandomStream& random, int num_words) {
  std::string line;
  for (int i = 0; i < num_words; ++i) line += (i == 0 ? "" : " ") + random_word(random);
  return line;
}

/// Lines of small text in the given area; ends of lines are ragged.
void paint_text_block(Canvas& canvas, RandomStream& random, double x_m, double y_m, double width_m,
                      double height_m, double letter_m, const Color& color) {
  const double spacing_m = 1.8 * letter_m;
  const int num_lines = static_cast<int>((height_m - letter_m) / spacing_m) + 1;
  for (int i = 0; i < num_lines; ++i) {
    const double y = y_m + letter_m + i * spacing_m;
    if (random.chance(0.12)) continue;  // between paragraphs
    double x = x_m;
    const double end_m = x_m + width_m * random.uniform(0.55, 1.0);
    while (x < end_m) {
      const double word_m = letter_m * random.uniform(1.2, 5.5);
      if (x + word_m > x_m + width_m) break;
      const std::string word = random_word(random, 7);
      canvas.text(word.substr(0, static_cast<std::size_t>(std::max(1.0, word_m / letter_m))), x, y,
                  letter_m, color);
      x += word_m + 0.7 * letter_m;
    }
  }
}

}  // namespace

Texture TexturePainter::plaster(double width_m, double height_m, const Color& color,
                                float contrast) {
  const std::uint64_t seed = next_seed();
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.fill([&](float x, float y) {
    const float coarse = fractal_noise(seed, x * 1.3F, y * 1.3F, 3);
    const float fine = fractal_noise(seed + 1, x * 22.0F, y * 22.0F, 4);
    return Color(color + Color::Constant(contrast * (0.8F * coarse + 0.8F * fine)));
  });
  return canvas.texture();
}

Texture TexturePainter::wood(double width_m, double height_m, const Color& color) {
  const std::uint64_t seed = next_seed();
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.fill([&](float x, float y) {
    const float plank_width = 0.14F;
    const float plank = std::floor(y / plank_width);
    const std::uint64_t plank_seed = combine_seed(seed, static_cast<std::uint64_t>(plank) + 17U);
    const float tone = static_cast<float>(plank_seed & 0xff) / 255.0F - 0.5F;
    const float bend = 0.02F * fractal_noise(plank_seed, x * 1.5F, y * 3.0F, 3);
    const float grain = fractal_noise(plank_seed + 3, x * 3.0F, (y + bend) * 90.0F, 4);
    const float joint = y - plank * plank_width < 0.004F ? -25.0F : 0.0F;
    return Color(color * (1.0F + 0.22F * tone + 0.30F * grain) + Color::Constant(joint));
  });
  return canvas.texture();
}

Texture TexturePainter::carpet(double width_m, double height_m, const Color& color) {
  const std::uint64_t seed = next_seed();
  RandomStream random(seed, 1);
  const float red = static_cast<float>(random.uniform(-40.0, 40.0));
  const float green = static_cast<float>(random.uniform(-40.0, 40.0));
  const float blue = static_cast<float>(random.uniform(-40.0, 40.0));
  const Color second = color + Color(blue, green, red);
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.fill([&](float x, float y) {
    const float flecks = fractal_noise(seed, x * 30.0F, y * 30.0F, 3);
    const float patches = fractal_noise(seed + 5, x * 5.0F, y * 5.0F, 4);
    const float worn = fractal_noise(seed + 9, x * 0.7F, y * 0.7F, 2);
    const float mix = std::clamp(0.5F + 2.2F * patches, 0.0F, 1.0F);
    const Color base = (1.0F - mix) * color + mix * second;
    return Color(base * (1.0F + 0.45F * flecks + 0.2F * worn));
  });
  return canvas.texture();
}

Texture TexturePainter::cardboard(double width_m, double height_m, bool printed) {
  const std::uint64_t seed = next_seed();
  RandomStream random(seed, 2);
  Canvas canvas(width_m, height_m, texel_m_);
  const Color brown(105.0F, 150.0F, 185.0F);
  canvas.fill([&](float x, float y) {
    const float fibre = fractal_noise(seed, x * 8.0F, y * 60.0F, 4);
    return Color(brown * (1.0F + 0.16F * fibre));
  });
  if (printed) {
    const Color ink(35.0F, 40.0F, 45.0F);
    const Color tape(150.0F, 185.0F, 205.0F);
    canvas.rectangle(0.0, height_m * random.uniform(0.44, 0.52), width_m, 0.05, tape);
    const int num_marks = 3 + static_cast<int>(width_m * height_m * 14.0);
    for (int i = 0; i < num_marks; ++i) {
      const double x = random.uniform(0.02, 0.8) * width_m;
      const double y = random.uniform(0.05, 0.95) * height_m;
      switch (random.integer(4)) {
        case 0: {
          const double letter_m = random.uniform(0.02, 0.06);
          canvas.text(random_line(random, 2), x, y, letter_m, ink);
          break;
        }
        case 1: {
          const double mark_height_m = random.uniform(0.02, 0.09);
          canvas.rectangle(x, y, random.uniform(0.03, 0.12), mark_height_m, ink);
          canvas.rectangle(x + 0.008, y + 0.008, 0.02, 0.015, random_color(random, 120.0, 250.0));
          break;
        }
        case 2: {  // bar code on a label
          canvas.rectangle(x, y, 0.13, 0.08, Color(235.0F, 235.0F, 232.0F));
          double bar_x = x + 0.01;
          while (bar_x < x + 0.115) {
            const double bar_m = random.uniform(0.002, 0.007);
            canvas.rectangle(bar_x, y + 0.01, bar_m, 0.045, ink);
            bar_x += bar_m + random.uniform(0.002, 0.007);
          }
          break;
        }
        default: {
          const double end_y = y + random.uniform(-0.1, 0.1);
          canvas.line(x, y, x + random.uniform(-0.2, 0.2), end_y, 0.004, ink);
        }
      }
    }
  }
  canvas.shade(next_seed(), 0.12, 16.0F, 4);
  return canvas.texture();
}

Texture TexturePainter::metal(double width_m, double height_m, const Color& color) {
  const std::uint64_t seed = next_seed();
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.fill([&](float x, float y) {
    const float scratches = fractal_noise(seed, x * 60.0F, y * 4.0F, 3);
    const float stains = fractal_noise(seed + 2, x * 6.0F, y * 6.0F, 4);
    return Color(color * (1.0F + 0.08F * scratches + 0.10F * stains));
  });
  return canvas.texture();
}

Texture TexturePainter::cloth(double width_m, double height_m, const Color& color, int pattern) {
  const std::uint64_t seed = next_seed();
  RandomStream random(seed, 3);
  const Color second = random_color(random, 20.0, 235.0);
  const auto stripe_m = static_cast<float>(random.uniform(0.025, 0.06));
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.fill([&](float x, float y) {
    // Folds bend every pattern, so that no two stripes are alike.
    const float fold = fractal_noise(seed + 4, x * 6.0F, y * 2.5F, 3);
    const float bent_x = x + 0.03F * fold;
    const float bent_y = y + 0.03F * fractal_noise(seed + 6, x * 5.0F, y * 5.0F, 3);
    const auto band = [&](float position, std::uint64_t salt) {
      const auto index =
          static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(position / stripe_m)));
      return static_cast<float>(combine_seed(seed + salt, index) & 0xff) / 255.0F;
    };
    float mix = 0.0F;
    switch (pattern) {
      case 0:  // stripes around
        mix = band(bent_y, 11) > 0.5F ? 0.9F : 0.0F;
        break;
      case 1:  // checks
        mix = 0.5F * (band(bent_y, 12) > 0.45F ? 1.0F : 0.0F) +
              0.5F * (band(bent_x, 13) > 0.55F ? 1.0F : 0.0F);
        break;
      case 2:  // printed flecks
        mix = value_noise(seed + 8, bent_x * 28.0F, bent_y * 28.0F) > 0.25F ? 0.95F : 0.0F;
        break;
      default:
        break;
    }
    const float weave = value_noise(seed + 10, x * 300.0F, y * 300.0F);
    const Color base = (1.0F - mix) * color + mix * second;
    return Color(base * (1.0F + 0.30F * fold + 0.10F * weave));
  });
  return canvas.texture();
}

Texture TexturePainter::skin(double width_m, double height_m, const Color& color) {
  return plaster(width_m, height_m, color, 12.0F);
}

Texture TexturePainter::head(double around_m, double height_m, const Color& skin_color,
                             const Color& hair_color) {
  const std::uint64_t seed = next_seed();
  Canvas canvas(around_m, height_m, texel_m_);
  const auto middle = static_cast<float>(0.5 * around_m);
  const auto height = static_cast<float>(height_m);
  canvas.fill([&](float x, float y) {
    const float from_front = std::abs(x - middle) / middle;  // 0 at the nose, 1 behind
    const float edge = 0.04F * fractal_noise(seed, x * 30.0F, y * 30.0F, 3);
    const float hair_line = from_front < 0.38F ? 0.26F : (from_front < 0.5F ? 0.55F : 0.86F);
    const bool hair = y / height < hair_line + edge;
    const float strands = fractal_noise(seed + 2, x * 120.0F, y * 25.0F, 3);
    const float tone = fractal_noise(seed + 3, x * 25.0F, y * 25.0F, 3);
    return hair ? Color(hair_color * (1.0F + 0.5F * strands))
                : Color(skin_color * (1.0F + 0.12F * tone));
  });
  const Color white(225.0F, 225.0F, 225.0F);
  const Color dark(35.0F, 35.0F, 40.0F);
  const Color shadow = 0.72F * skin_color;
  for (const double side : {-1.0, 1.0}) {
    const double x = 0.5 * around_m + side * 0.032;
    canvas.ellipse(x, 0.47 * height_m, 0.014, 0.007, 0.0, white);
    canvas.ellipse(x, 0.47 * height_m, 0.006, 0.006, 0.0, dark);
    canvas.line(x - 0.016, 0.41 * height_m, x + 0.016, 0.405 * height_m, 0.005, dark);
  }
  canvas.ellipse(0.5 * around_m, 0.60 * height_m, 0.011, 0.018, 0.0, shadow);
  canvas.ellipse(0.5 * around_m, 0.735 * height_m, 0.024, 0.006, 0.0, Color(85.0F, 80.0F, 150.0F));
  return canvas.texture();
}

Texture TexturePainter::poster(double width_m, double height_m) {
  RandomStream random(next_seed(), 4);
  const double texel_m = std::max(0.5 * texel_m_, 0.0012);
  Canvas canvas(width_m, height_m, texel_m);
  const bool dark = random.chance(0.35);
  const Color paper = dark ? random_color(random, 20.0, 90.0) : random_color(random, 190.0, 245.0);
  const Color ink = dark ? Color(235.0F, 235.0F, 235.0F) : Color(30.0F, 28.0F, 26.0F);
  canvas.image().setTo(cv::Scalar(paper[0], paper[1], paper[2]));
  const double heading_m = 0.07 * height_m;
  canvas.rectangle(0.0, 0.0, width_m, 0.16 * height_m, random_color(random));
  canvas.text(random_line(random, 2), 0.05 * width_m, 0.115 * height_m, heading_m,
              Color(245.0F, 245.0F, 245.0F));
  const std::uint64_t picture_seed = random.bits();
  const int num_blocks = 3 + random.integer(4);
  for (int i = 0; i < num_blocks; ++i) {
    const double x = width_m * random.uniform(0.04, 0.55);
    const double y = height_m * random.uniform(0.2, 0.75);
    const double block_width_m = width_m * random.uniform(0.22, 0.42);
    const double block_height_m = height_m * random.uniform(0.12, 0.3);
    if (random.chance(0.45)) {
      paint_text_block(canvas, random, x, y, block_width_m, block_height_m,
                       0.014 * height_m + 0.003, ink);
      continue;
    }
    canvas.rectangle(x, y, block_width_m, block_height_m, random_color(random));
    const int num_spots = 4 + random.integer(8);
    for (int k = 0; k < num_spots; ++k) {
      const Color color = random_color(random, 10.0, 250.0);
      const double spot_x = x + block_width_m * random.uniform(0.1, 0.9);
      const double spot_y = y + block_height_m * random.uniform(0.1, 0.9);
      if (random.chance(0.5)) {
        const double angle_deg = random.uniform(0.0, 180.0);
        const double radius_y = block_height_m * random.uniform(0.03, 0.22);
        const double radius_x = block_width_m * random.uniform(0.03, 0.18);
        canvas.ellipse(spot_x, spot_y, radius_x, radius_y, angle_deg, color);
      } else {
        const double line_width = random.uniform(0.004, 0.02);
        const double end_y = y + block_height_m * random.uniform(0.0, 1.0);
        const double end_x = x + block_width_m * random.uniform(0.0, 1.0);
        canvas.line(spot_x, spot_y, end_x, end_y, line_width, color);
      }
    }
  }
  canvas.shade(picture_seed, 0.3, 12.0F, 3);
  return canvas.texture();
}

Texture TexturePainter::screen(double width_m, double height_m) {
  RandomStream random(next_seed(), 5);
  Canvas canvas(width_m, height_m, std::max(0.4 * texel_m_, 0.0012));
  const Color desktop = random_color(random, 60.0, 140.0);
  canvas.image().setTo(cv::Scalar(desktop[0], desktop[1], desktop[2]));
  const int num_windows = 3 + random.integer(3);
  for (int i = 0; i < num_windows; ++i) {
    const double window_width_m = width_m * random.uniform(0.35, 0.6);
    const double window_height_m = height_m * random.uniform(0.4, 0.7);
    const double x = (width_m - window_width_m) * random.uniform();
    const double y = (height_m - window_height_m) * random.uniform();
    const bool dark = random.chance(0.5);
    canvas.rectangle(x, y, window_width_m, window_height_m,
                     dark ? Color(40.0F, 36.0F, 34.0F) : Color(238.0F, 238.0F, 236.0F));
    canvas.rectangle(x, y, window_width_m, 0.014, random_color(random, 60.0, 190.0));
    paint_text_block(canvas, random, x + 0.01, y + 0.02, window_width_m - 0.02,
                     window_height_m - 0.025, 0.006,
                     dark ? random_color(random, 150.0, 240.0) : Color(40.0F, 40.0F, 40.0F));
  }
  return canvas.texture();
}

Texture TexturePainter::keyboard(double width_m, double height_m) {
  RandomStream random(next_seed(), 6);
  Canvas canvas(width_m, height_m, std::max(0.4 * texel_m_, 0.0012));
  canvas.image().setTo(cv::Scalar(40, 40, 42));
  double y = 0.012;
  while (y + 0.017 < height_m) {
    double x = 0.012;
    while (x < width_m - 0.03) {
      const double key_m = random.chance(0.15) ? random.uniform(0.024, 0.05) : 0.016;
      canvas.rectangle(x, y, std::min(key_m, width_m - 0.012 - x), 0.016,
                       Color::Constant(static_cast<float>(random.uniform(95.0, 150.0))));
      canvas.rectangle(x + 0.004, y + 0.004, 0.004, 0.005, Color(225.0F, 225.0F, 225.0F));
      x += key_m + 0.003;
    }
    y += 0.019;
  }
  return canvas.texture();
}

Texture TexturePainter::sheet(double width_m, double height_m) {
  RandomStream random(next_seed(), 7);
  Canvas canvas(width_m, height_m, std::max(0.4 * texel_m_, 0.0012));
  canvas.image().setTo(cv::Scalar(232, 234, 235));
  canvas.text(random_line(random, 2), 0.12 * width_m, 0.1 * height_m, 0.01,
              Color(20.0F, 20.0F, 20.0F));
  paint_text_block(canvas, random, 0.1 * width_m, 0.14 * height_m, 0.8 * width_m, 0.8 * height_m,
                   0.0055, Color(55.0F, 50.0F, 50.0F));
  if (random.chance(0.6)) {
    const Color color = random_color(random);
    const double y = height_m * random.uniform(0.3, 0.6);
    const double x = width_m * random.uniform(0.15, 0.4);
    canvas.rectangle(x, y, 0.4 * width_m, 0.2 * height_m, color);
  }
  return canvas.texture();
}

Texture TexturePainter::book(double width_m, double height_m) {
  const std::uint64_t seed = next_seed();
  RandomStream random(seed, 8);
  Canvas canvas(width_m, height_m, std::max(0.5 * texel_m_, 0.0012));
  const Color cover = random_color(random, 25.0, 215.0);
  canvas.image().setTo(cv::Scalar(cover[0], cover[1], cover[2]));
  const Color print =
      cover.mean() > 120.0F ? Color(25.0F, 25.0F, 30.0F) : Color(225.0F, 230.0F, 235.0F);
  const int num_bands = 1 + random.integer(3);
  for (int i = 0; i < num_bands; ++i) {
    const Color color = random_color(random, 20.0, 240.0);
    const double band_height_m = height_m * random.uniform(0.01, 0.06);
    canvas.rectangle(0.0, height_m * random.uniform(0.05, 0.9), width_m, band_height_m, color);
  }
  // Letters that read along the spine would be rotated text; blocks of their size do as well.
  double y = height_m * 0.15;
  while (y < height_m * 0.75) {
    const double print_height_m = random.uniform(0.003, 0.010);
    const double print_width_m = width_m * random.uniform(0.2, 0.4);
    canvas.rectangle(width_m * random.uniform(0.2, 0.4), y, print_width_m, print_height_m, print);
    y += random.uniform(0.008, 0.022);
  }
  canvas.shade(seed, 0.1, 10.0F, 3);
  return canvas.texture();
}

Texture TexturePainter::balloon(double width_m, double height_m, const Color& color) {
  const std::uint64_t seed = next_seed();
  RandomStream random(seed, 9);
  Canvas canvas(width_m, height_m, texel_m_);
  canvas.image().setTo(cv::Scalar(color[0], color[1], color[2]));
  for (int i = 0; i < 26; ++i) {
    const Color spot_color = random_color(random, 10.0, 250.0);
    const double angle_deg = random.uniform(0.0, 180.0);
    const double radius_y = random.uniform(0.01, 0.04);
    const double radius_x = random.uniform(0.01, 0.04);
    const double y = height_m * random.uniform();
    canvas.ellipse(width_m * random.uniform(), y, radius_x, radius_y, angle_deg, spot_color);
  }
  canvas.shade(seed, 0.1, 14.0F, 3);
  return canvas.texture();
}

Texture TexturePainter::plain(const Color& color) {
  Canvas canvas(0.1, 0.1, 0.02);
  canvas.fill([&](float, float) { return color; });
  return canvas.texture();
}

}  // namespace srslam::detail
