#pragma once

#include <limits>

namespace srslam::test {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A time stamp as recordings have them, of which a double keeps 0.2 µs.
constexpr double kEpoch_s = 1.5e9;

}  // namespace srslam::test
