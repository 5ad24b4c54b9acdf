#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "synthetic/constants.hpp"
#include "synthetic/random.hpp"

namespace srslam::detail {

/// Band-limited random signal with zero mean: what a hand or a body does when it tries to hold
/// still. A sum of sines whose strength falls with the frequency.
class SmoothSignal {
 public:
  SmoothSignal() = default;
  /// `rms`: root mean square of the signal; frequencies in [low_hz, high_hz].
  SmoothSignal(RandomStream* random, double rms, double low_hz, double high_hz) {
    double power = 0.0;
    for (std::size_t i = 0; i < kNumSines; ++i) {
      const double share = (static_cast<double>(i) + random->uniform()) / double(kNumSines);
      const double frequency_hz = low_hz * std::pow(high_hz / low_hz, share);
      Sine& sine = sines_[i];
      sine.rate = 2.0 * kPi * frequency_hz;
      sine.phase = 2.0 * kPi * random->uniform();
      sine.amplitude = random->uniform(0.6, 1.4) / frequency_hz;
      power += 0.5 * sine.amplitude * sine.amplitude;
    }
    for (Sine& sine : sines_) sine.amplitude *= rms / std::sqrt(power);
  }

  double operator()(double time_s) const {
    double sum = 0.0;
    for (const Sine& sine : sines_)
      sum += sine.amplitude * std::sin(sine.rate * time_s + sine.phase);
    return sum;
  }

 private:
  static constexpr std::size_t kNumSines = 7;
  struct Sine {
    double amplitude = 0.0;
    double rate = 0.0;
    double phase = 0.0;
  };
  std::array<Sine, kNumSines> sines_{};
};

}  // namespace srslam::detail
