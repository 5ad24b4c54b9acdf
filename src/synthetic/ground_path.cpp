#include "synthetic/ground_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "synthetic/constants.hpp"

namespace srslam::detail {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kRounding_s = 0.5;  // a person needs about so long to start, stop or turn
// Slower than this, the direction of motion says nothing about where the body faces.
constexpr double kStanding_m_per_s = 0.12;

Eigen::Vector2d on_polyline(const std::vector<Waypoint>& waypoints, double time_s) {
  if (time_s <= waypoints.front().time_s) return waypoints.front().position_m;
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (time_s > waypoints[i].time_s) continue;
    const double length_s = waypoints[i].time_s - waypoints[i - 1].time_s;
    const double share = length_s > 0.0 ? (time_s - waypoints[i - 1].time_s) / length_s : 1.0;
    return (1.0 - share) * waypoints[i - 1].position_m + share * waypoints[i].position_m;
  }
  return waypoints.back().position_m;
}

/// Mean over a window of `half_width` samples to both sides.
template <typename Value>
std::vector<Value> box_filtered(const std::vector<Value>& values, int half_width) {
  std::vector<Value> sums(values.size() + 1);
  sums[0] = values[0] * 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
  std::vector<Value> result(values.size());
  const auto last = static_cast<int>(values.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    // The window shrinks at the ends and stays symmetric, so that the ends do not move.
    const int reach = std::min({half_width, i, last - i});
    result[static_cast<std::size_t>(i)] = (sums[static_cast<std::size_t>(i + reach + 1)] -
                                           sums[static_cast<std::size_t>(i - reach)]) /
                                          double(2 * reach + 1);
  }
  return result;
}

}  // namespace

GroundPath::GroundPath(const std::vector<Waypoint>& waypoints, double yaw_at_rest_rad) {
  begin_s_ = waypoints.front().time_s - 2.0 * kRounding_s;
  const double end_s = waypoints.back().time_s + 2.0 * kRounding_s;
  const auto count = static_cast<std::size_t>(std::ceil((end_s - begin_s_) / kStep_s)) + 2;
  std::vector<Eigen::Vector2d> positions(count);
  for (std::size_t i = 0; i < count; ++i) {
    positions[i] = on_polyline(waypoints, begin_s_ + double(i) * kStep_s);
  }
  const int half_width = static_cast<int>(0.5 * kRounding_s / kStep_s);
  positions = box_filtered(box_filtered(positions, half_width), half_width);

  samples_.resize(count);
  std::vector<double> yaws(count);
  double yaw_rad = yaw_at_rest_rad;
  for (std::size_t i = 0; i < count; ++i) {
    State& sample = samples_[i];
    sample.position_m = positions[i];
    const Eigen::Vector2d step_m =
        positions[std::min(i + 1, count - 1)] - positions[i == 0 ? 0 : i - 1];
    sample.speed_m_per_s = step_m.norm() / (2.0 * kStep_s);
    sample.walked_m =
        i == 0 ? 0.0 : samples_[i - 1].walked_m + (positions[i] - positions[i - 1]).norm();
    if (sample.speed_m_per_s > kStanding_m_per_s) {
      const double direction_rad = std::atan2(step_m.y(), step_m.x());
      yaw_rad += std::remainder(direction_rad - yaw_rad, 2.0 * kPi);
    }
    yaws[i] = yaw_rad;
  }
  yaws = box_filtered(box_filtered(yaws, half_width), half_width);
  for (std::size_t i = 0; i < count; ++i) samples_[i].yaw_rad = yaws[i];
}

GroundPath::State GroundPath::at(double time_s) const {
  const double position =
      std::clamp((time_s - begin_s_) / kStep_s, 0.0, double(samples_.size() - 1) - 1e-9);
  const auto i = static_cast<std::size_t>(position);
  const double share = position - double(i);
  const State& a = samples_[i];
  const State& b = samples_[i + 1];
  State state;
  state.position_m = (1.0 - share) * a.position_m + share * b.position_m;
  state.yaw_rad = (1.0 - share) * a.yaw_rad + share * b.yaw_rad;
  state.walked_m = (1.0 - share) * a.walked_m + share * b.walked_m;
  state.speed_m_per_s = (1.0 - share) * a.speed_m_per_s + share * b.speed_m_per_s;
  return state;
}

double Timeline::operator()(double time_s) const {
  if (keys_.empty()) return 0.0;
  if (time_s <= keys_.front().time_s) return keys_.front().value;
  for (std::size_t i = 1; i < keys_.size(); ++i) {
    if (time_s > keys_[i].time_s) continue;
    const double length_s = keys_[i].time_s - keys_[i - 1].time_s;
    const double share = length_s > 0.0 ? (time_s - keys_[i - 1].time_s) / length_s : 1.0;
    const double eased = share * share * (3.0 - 2.0 * share);
    return (1.0 - eased) * keys_[i - 1].value + eased * keys_[i].value;
  }
  return keys_.back().value;
}

}  // namespace srslam::detail
