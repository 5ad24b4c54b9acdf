#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/core/pose.hpp"
#include "support/constants.hpp"

namespace srslam::test {

/// Pseudo-random numbers whose sequence depends on the seed alone: unlike the distributions of
/// <random>, it is the same with every compiler and standard library. (SplitMix64.)
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  /// In [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(next() >> 11U) * 0x1.0p-53;
  }

  /// In [low, high], both included.
  int uniform_int(int low, int high) {
    const auto range = static_cast<std::uint64_t>(static_cast<std::int64_t>(high) - low) + 1;
    return static_cast<int>(low + static_cast<std::int64_t>(next() % range));
  }

  bool coin() { return (next() >> 63U) != 0; }

  /// Standard normal (Box-Muller, one of the pair).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
    return radius * std::cos(uniform(0.0, 2.0 * kPi));
  }

  Eigen::Vector3d vector3(double low, double high) {
    const double x = uniform(low, high);
    const double y = uniform(low, high);
    const double z = uniform(low, high);
    return {x, y, z};
  }

  /// Uniform on the sphere.
  Eigen::Vector3d unit_vector3() {
    const double z = uniform(-1.0, 1.0);
    const double azimuth = uniform(0.0, 2.0 * kPi);
    const double radius = std::sqrt(1.0 - z * z);
    return {radius * std::cos(azimuth), radius * std::sin(azimuth), z};
  }

  /// Rotation by an angle [rad] in [low, high) about a random axis.
  Eigen::Quaterniond rotation(double low_rad, double high_rad) {
    const Eigen::Vector3d axis = unit_vector3();
    return Eigen::Quaterniond(Eigen::AngleAxisd(uniform(low_rad, high_rad), axis));
  }

  /// Any rotation up to almost half a turn, translation components in [-max, max).
  Pose pose(double max_translation_m, double max_angle_rad = 3.1) {
    Pose T = Pose::Identity();
    T.linear() = rotation(0.0, max_angle_rad).toRotationMatrix();
    T.translation() = vector3(-max_translation_m, max_translation_m);
    return T;
  }

 private:
  std::uint64_t state_;
};

/// Runs `body(rng)` with `repetitions` fixed seeds, which follow from the name of the running test.
/// A failure prints the seed and how to replay it alone: set the environment variable
/// SRSLAM_TEST_SEED to the printed number.
template <typename Body>
void for_each_seed(int repetitions, Body&& body) {
  const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = std::string(info->test_suite_name()) + "." + info->name();
  std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a
  for (const char c : name) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  }
  const char* replay = std::getenv("SRSLAM_TEST_SEED");
  if (replay != nullptr) repetitions = 1;
  for (int i = 0; i < repetitions; ++i) {
    const std::uint64_t seed = replay != nullptr
                                   ? std::strtoull(replay, nullptr, 10)
                                   : hash + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL;
    SCOPED_TRACE("replay with SRSLAM_TEST_SEED=" + std::to_string(seed) +
                 " --gtest_filter=" + name);
    Rng rng(seed);
    body(rng);
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace srslam::test
