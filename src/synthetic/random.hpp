#pragma once

#include <cstdint>

#include "srslam/core/random_stream.hpp"

namespace srslam::detail {

/// Approximately normal number (standard deviation 1, cut at ±3.46) from 64 random bits: cheap
/// enough for every pixel.
constexpr float gaussian_from_bits(std::uint64_t bits) noexcept {
  const auto sum = static_cast<std::int32_t>((bits & 0xffff) + ((bits >> 16) & 0xffff) +
                                             ((bits >> 32) & 0xffff) + (bits >> 48));
  // Four uniform numbers of variance 1/12 each.
  return (static_cast<float>(sum) - 131070.0F) * (1.7320508F / 65536.0F);
}

}  // namespace srslam::detail
