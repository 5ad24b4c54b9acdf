#pragma once

#include <cstdint>
#include <vector>

#include "srslam/core/image_view.hpp"
#include "srslam/synthetic/synthetic_options.hpp"
#include "synthetic/renderer.hpp"
#include "synthetic/smooth_signal.hpp"

namespace srslam::detail {

/// What an RGB-D camera of the structured-light kind makes of a scene.
class Sensor {
 public:
  struct Workspace {
    std::vector<float> jittered_m;
    std::vector<float> coarse_noise;
  };

  Sensor(const SyntheticSensorOptions& options, const RgbdCamera& camera, std::uint64_t seed);

  /// Brightness of a frame relative to the first.
  double exposure(double time_s) const;

  void expose(const ImageBuffer<Eigen::Vector3f>& color, double time_s, std::uint64_t frame,
              ImageBuffer<Bgr8>* image) const;

  /// Disparity noise and its quantisation, which make the error grow with the square of the depth;
  /// holes in the projector's shadow, at edges, at grazing angles and out of range.
  void measure_depth(const PixelBuffers& scene, std::uint64_t frame,
                     ImageBuffer<std::uint16_t>* raw_depth, Workspace* workspace) const;

 private:
  SyntheticSensorOptions options_;
  RgbdCamera camera_;
  std::uint64_t seed_;
  SmoothSignal exposure_;
  std::vector<float> vignetting_;
};

}  // namespace srslam::detail
