#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/feature_frame.hpp"
#include "support/rng.hpp"

namespace srslam::test {

/// A camera without distortion, 640x480, with eight levels of factor 1.2.
inline PinholeCamera ideal_camera() { return {640, 480, 520.0, 525.0, 319.0, 241.0}; }

inline detail::TrackingCamera tracking_camera(const PinholeCamera& camera) {
  std::vector<float> scales = {1.0F};
  while (scales.size() < 8) scales.push_back(scales.back() * 1.2F);
  return detail::make_tracking_camera(camera, scales, 1.2, 0.0775);
}

inline BinaryDescriptor random_descriptor(Rng& rng) {
  return {rng.next(), rng.next(), rng.next(), rng.next()};
}

inline void flip_bits(Rng& rng, int count, BinaryDescriptor* descriptor) {
  for (int i = 0; i < count; ++i) {
    const int bit = rng.uniform_int(0, 255);
    (*descriptor)[static_cast<std::size_t>(bit / 64)] ^= 1ULL << static_cast<unsigned>(bit % 64);
  }
}

/// Features anywhere in the image, descriptors and orientations at random.
inline detail::OrbFeatures random_features(Rng& rng, const PinholeCamera& camera, int count) {
  detail::OrbFeatures result;
  for (int i = 0; i < count; ++i) {
    Feature feature;
    feature.u_px = static_cast<float>(rng.uniform(-0.5, camera.width_px - 0.51));
    feature.v_px = static_cast<float>(rng.uniform(-0.5, camera.height_px - 0.51));
    feature.octave = rng.uniform_int(0, 7);
    feature.angle_rad = static_cast<float>(rng.uniform(0.0, 6.28));
    feature.response = static_cast<float>(i);
    result.features.push_back(feature);
    result.descriptors.push_back(random_descriptor(rng));
  }
  return result;
}

/// Depth between 0.5 and 6 m, invalid with the given probability.
inline ImageBuffer<float> random_depth(Rng& rng, const PinholeCamera& camera, double invalid) {
  ImageBuffer<float> depth_m;
  depth_m.resize(camera.width_px, camera.height_px);
  for (float& value : depth_m.pixels) {
    value = rng.uniform(0.0, 1.0) < invalid ? 0.0F : static_cast<float>(rng.uniform(0.5, 6.0));
  }
  return depth_m;
}

}  // namespace srslam::test
