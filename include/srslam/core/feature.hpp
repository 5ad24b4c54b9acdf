#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace srslam {

/// A point feature in the original (distorted) image.
struct Feature {
  float u_px = 0.0F;
  float v_px = 0.0F;
  float response = 0.0F;    ///< detector score; FAST: 0..255
  float angle_rad = 0.0F;   ///< orientation in [0, 2π)
  float scale = 1.0F;       ///< pixel size of its pyramid level in level-0 pixels, >= 1
  std::int32_t octave = 0;  ///< pyramid level, 0 = full resolution
};

/// 256-bit binary descriptor (ORB), as four words so that the Hamming distance is four popcounts.
using BinaryDescriptor = std::array<std::uint64_t, 4>;

/// Number of differing bits, 0..256.
inline int hamming_distance(const BinaryDescriptor& a, const BinaryDescriptor& b) noexcept {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::uint64_t x = a[i] ^ b[i];
    // Population count in parallel bit fields: portable, and no -m flag is needed for it.
    x -= (x >> 1U) & 0x5555555555555555ULL;
    x = (x & 0x3333333333333333ULL) + ((x >> 2U) & 0x3333333333333333ULL);
    x = (x + (x >> 4U)) & 0x0F0F0F0F0F0F0F0FULL;
    distance += static_cast<int>((x * 0x0101010101010101ULL) >> 56U);
  }
  return distance;
}

}  // namespace srslam
