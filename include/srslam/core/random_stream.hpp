#pragma once

#include <cstdint>

namespace srslam::detail {

/// Finaliser that turns any two different numbers into two unrelated ones.
constexpr std::uint64_t mix_bits(std::uint64_t x) noexcept {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr std::uint64_t combine_seed(std::uint64_t seed, std::uint64_t salt) noexcept {
  return mix_bits(seed * 0x9e3779b97f4a7c15ULL + mix_bits(salt + 0x632be59bd9b4e019ULL));
}

/// Random numbers that are the same on every platform, which the standard's distributions are not.
/// Draw one in a statement: compilers evaluate the arguments of a call in orders of their own.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) noexcept : state_(seed) {}
  RandomStream(std::uint64_t seed, std::uint64_t salt) noexcept
      : RandomStream(combine_seed(seed, salt)) {}

  std::uint64_t bits() noexcept { return mix_bits(state_ += 0x9e3779b97f4a7c15ULL); }
  /// In [0, 1).
  double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }
  /// In [0, count).
  int integer(int count) noexcept { return static_cast<int>(uniform() * count); }
  bool chance(double probability) noexcept { return uniform() < probability; }
  /// Standard normal: the sum of twelve uniform numbers, cut at six standard deviations.
  double gaussian() noexcept {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

}  // namespace srslam::detail
