#pragma once

#include <limits>

namespace srslam::detail {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace srslam::detail
