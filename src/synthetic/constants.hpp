#pragma once

namespace srslam::detail {

constexpr double kPi = 3.14159265358979323846;

}  // namespace srslam::detail
