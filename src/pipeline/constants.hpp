#pragma once

namespace srslam::detail {

constexpr double kTwoPi = 6.283185307179586;

}  // namespace srslam::detail
