#include "synthetic/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "synthetic/random.hpp"

namespace srslam::detail {
namespace {

// A sensor like the first Kinect: focal length [px at 640] times baseline [m], disparity in steps
// of an eighth of a pixel. The noise of the disparity gives the axial noise that Nguyen et al.
// (2012) measured: 6 mm at 2 m, 2.6 cm at 4 m.
constexpr float kFocalBaseline = 580.0F * 0.075F;
constexpr float kDisparityStep_px = 0.125F;
constexpr float kDisparityNoise_px = 0.065F;
constexpr float kLateralNoise_px = 0.5F;
constexpr float kMinDepth_m = 0.45F;
constexpr float kFadingDepth_m = 4.6F;  // from here on more and more pixels stay empty
constexpr float kMaxDepth_m = 6.5F;
constexpr float kSafeCosine = 0.30F;  // surfaces seen at a flatter angle lose pixels
constexpr float kBlindCosine = 0.08F;
constexpr float kEdgeStep = 0.04F;  // of the depth, between neighbours, that makes an edge
constexpr float kEdgeDropout = 0.55F;
constexpr float kVignetting = 0.24F;  // of the brightness, in the corners
constexpr int kCoarse_px = 4;         // neighbouring disparities share a window, and its error

enum Salt : std::uint64_t { kColorSalt = 101, kDepthSalt = 102, kCoarseSalt = 103 };

std::uint64_t pixel_bits(std::uint64_t stream, std::size_t pixel) {
  return mix_bits(stream + static_cast<std::uint64_t>(pixel) * 0x9e3779b97f4a7c15ULL);
}

/// Nearest integer of a number within the range of int, without a call into the mathematics
/// library.
int nearest(float value) { return static_cast<int>(value < 0.0F ? value - 0.5F : value + 0.5F); }

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

}  // namespace

Sensor::Sensor(const SyntheticSensorOptions& options, const RgbdCamera& camera, std::uint64_t seed)
    : options_(options), camera_(camera), seed_(seed) {
  RandomStream random(seed, 104);
  // A signal of this RMS seldom goes beyond twice of it.
  exposure_ = SmoothSignal(&random, 0.5, 0.1, 0.7);
  const int width = camera.camera.width_px;
  const int height = camera.camera.height_px;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const float x = (float(u) + 0.5F) / float(width) - 0.5F;
      const float y = (float(v) + 0.5F) / float(height) - 0.5F;
      const float r2 = 2.0F * (x * x + y * y);  // 1 in the corners
      vignetting_.push_back(1.0F - kVignetting * r2 * (0.4F + 0.6F * r2));
    }
  }
}

double Sensor::exposure(double time_s) const {
  if (options_.exposure_change <= 0.0) return 1.0;
  return std::max(0.1, 1.0 + options_.exposure_change *
                                 std::clamp(exposure_(time_s) - exposure_(0.0), -1.0, 1.0));
}

void Sensor::expose(const ImageBuffer<Eigen::Vector3f>& color, double time_s, std::uint64_t frame,
                    ImageBuffer<Bgr8>* image) const {
  image->resize(color.width_px, color.height_px);
  const auto gain = static_cast<float>(exposure(time_s));
  const std::uint64_t stream = combine_seed(combine_seed(seed_, kColorSalt), frame);
  for (std::size_t i = 0; i < color.pixels.size(); ++i) {
    Eigen::Vector3f value = gain * color.pixels[i];
    if (!options_.clean) {
      value *= vignetting_[i];
      const std::uint64_t bits = pixel_bits(stream, i);
      const float common = gaussian_from_bits(bits);
      for (int channel = 0; channel < 3; ++channel) {
        const float own =
            gaussian_from_bits(mix_bits(bits + static_cast<std::uint64_t>(channel) + 1U));
        const float sigma = 1.1F + 0.008F * value[channel];
        value[channel] += sigma * (0.8F * common + 0.6F * own);
      }
    }
    image->pixels[i] = {rounded(value[0]), rounded(value[1]), rounded(value[2])};
  }
}

void Sensor::measure_depth(const PixelBuffers& scene, std::uint64_t frame,
                           ImageBuffer<std::uint16_t>* raw_depth, Workspace* workspace) const {
  const int width = scene.depth_m.width_px;
  const int height = scene.depth_m.height_px;
  raw_depth->resize(width, height);
  const auto units = static_cast<float>(camera_.depth_units_per_m);
  const auto to_raw = [&](float depth_m) {
    const float raw = depth_m * units;
    return raw >= 0.5F && raw < 65535.5F ? static_cast<std::uint16_t>(nearest(raw))
                                         : std::uint16_t{0};
  };
  if (options_.clean) {
    std::transform(scene.depth_m.pixels.begin(), scene.depth_m.pixels.end(),
                   raw_depth->pixels.begin(), to_raw);
    return;
  }

  const std::uint64_t stream = combine_seed(combine_seed(seed_, kDepthSalt), frame);
  const auto true_depth = scene.depth_m.view();
  workspace->jittered_m.resize(scene.depth_m.pixels.size());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(u);
      const std::uint64_t bits = pixel_bits(stream, i);
      const float du = kLateralNoise_px * gaussian_from_bits(bits);
      const float dv = kLateralNoise_px * gaussian_from_bits(mix_bits(bits + 1U));
      const int from_u = std::clamp(nearest(float(u) + du), 0, width - 1);
      const int from_v = std::clamp(nearest(float(v) + dv), 0, height - 1);
      workspace->jittered_m[i] = true_depth(from_u, from_v);
    }
  }

  const int coarse_width = width / kCoarse_px + 2;
  const int coarse_height = height / kCoarse_px + 2;
  workspace->coarse_noise.resize(static_cast<std::size_t>(coarse_width) *
                                 static_cast<std::size_t>(coarse_height));
  const std::uint64_t coarse_stream = combine_seed(combine_seed(seed_, kCoarseSalt), frame);
  for (std::size_t i = 0; i < workspace->coarse_noise.size(); ++i) {
    workspace->coarse_noise[i] = gaussian_from_bits(pixel_bits(coarse_stream, i));
  }
  const auto coarse = [&](int u, int v) {
    const float x = float(u) / float(kCoarse_px);
    const float y = float(v) / float(kCoarse_px);
    const auto left = static_cast<std::size_t>(x);
    const auto top = static_cast<std::size_t>(y);
    const float ax = x - float(left);
    const float ay = y - float(top);
    const float* upper =
        &workspace->coarse_noise[top * static_cast<std::size_t>(coarse_width) + left];
    const float* lower = upper + coarse_width;
    return (1.0F - ay) * ((1.0F - ax) * upper[0] + ax * upper[1]) +
           ay * ((1.0F - ax) * lower[0] + ax * lower[1]);
  };

  // The projector stands to the right of the camera and sees each point shifted to the left by its
  // disparity. What a nearer point further right already covers there gets no light. Pixels of
  // smaller images cover more of it.
  const float pixels_per_px = float(width) / 640.0F;
  for (int v = 0; v < height; ++v) {
    float covered_from_px = 1e9F;
    for (int u = width - 1; u >= 0; --u) {
      const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(u);
      std::uint16_t& raw = raw_depth->pixels[i];
      raw = 0;
      const float clear_m = true_depth(u, v);
      if (clear_m > 0.0F) {
        const float seen_at_px = float(u) - pixels_per_px * kFocalBaseline / clear_m;
        const bool in_shadow = seen_at_px > covered_from_px + 1.0F;
        covered_from_px = std::min(covered_from_px, seen_at_px);
        if (in_shadow) continue;
      }
      const float depth_m = workspace->jittered_m[i];
      if (depth_m < kMinDepth_m || depth_m > kMaxDepth_m) continue;

      const std::uint64_t bits = mix_bits(pixel_bits(stream, i) + 7U);
      const float luck = static_cast<float>(bits >> 40) * (1.0F / 16777216.0F);
      float dropout = 0.002F;
      const float cosine = scene.cosine.pixels[i];
      if (cosine < kSafeCosine) {
        dropout += std::clamp((kSafeCosine - cosine) / (kSafeCosine - kBlindCosine), 0.0F, 1.0F);
      }
      if (depth_m > kFadingDepth_m) {
        dropout += (depth_m - kFadingDepth_m) / (kMaxDepth_m - kFadingDepth_m);
      }
      const float neighbours_m[] = {
          true_depth(std::max(u - 1, 0), v), true_depth(std::min(u + 1, width - 1), v),
          true_depth(u, std::max(v - 1, 0)), true_depth(u, std::min(v + 1, height - 1))};
      for (const float neighbour_m : neighbours_m) {
        if (std::abs(neighbour_m - clear_m) > kEdgeStep * clear_m) {
          dropout += kEdgeDropout;
          break;
        }
      }
      if (luck < dropout) continue;

      const float noise = 0.8F * coarse(u, v) + 0.6F * gaussian_from_bits(mix_bits(bits + 3U));
      const float disparity_px = kFocalBaseline / depth_m + kDisparityNoise_px * noise;
      const float quantized_px =
          kDisparityStep_px * float(nearest(disparity_px / kDisparityStep_px));
      if (quantized_px > 0.0F) raw = to_raw(kFocalBaseline / quantized_px);
    }
  }
}

}  // namespace srslam::detail
