// Time of the evaluation against the length of the trajectories. The reference is sampled at three
// times the rate of the estimate, as ground truth at 100 Hz is against a camera at 30 Hz. The last
// columns of a run over several lengths give the fitted complexity.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <benchmark/benchmark.h>
#include <Eigen/Geometry>

#include "srslam/evaluation/trajectory_error.hpp"

namespace {

using srslam::StampedPose;
using srslam::Trajectory;

/// A smooth path through space, `rate_hz` poses a second, off it by up to 1 cm.
Trajectory make_trajectory(std::int64_t size, double rate_hz, double noise_m) {
  Trajectory trajectory;
  trajectory.reserve(static_cast<std::size_t>(size));
  std::uint32_t state = 1;
  const auto noise = [&state, noise_m] {
    state = state * 1664525U + 1013904223U;
    return noise_m * (static_cast<double>(state >> 8U) / 8388608.0 - 1.0);
  };
  for (std::int64_t i = 0; i < size; ++i) {
    const double time_s = static_cast<double>(i) / rate_hz;
    StampedPose pose;
    pose.timestamp_s = 1.5e9 + time_s;
    pose.T_world_camera.translation() =
        Eigen::Vector3d(2.0 * std::sin(0.3 * time_s) + noise(), std::cos(0.5 * time_s) + noise(),
                        0.3 * std::sin(time_s) + noise());
    pose.T_world_camera.linear() =
        Eigen::AngleAxisd(0.5 * std::sin(0.7 * time_s), Eigen::Vector3d::UnitY())
            .toRotationMatrix();
    trajectory.push_back(pose);
  }
  return trajectory;
}

Trajectory reference_of(std::int64_t size) { return make_trajectory(3 * size, 90.0, 0.0); }
Trajectory estimate_of(std::int64_t size) { return make_trajectory(size, 30.0, 0.01); }

/// `state.range(1)` is the tolerance in milliseconds.
void associate(benchmark::State& state) {
  const Trajectory reference = reference_of(state.range(0));
  const Trajectory estimate = estimate_of(state.range(0));
  srslam::AssociationOptions options;
  options.max_time_difference_s = static_cast<double>(state.range(1)) * 1e-3;
  for (auto iteration : state) {
    const auto result = srslam::associate(reference, estimate, options);
    if (!result.status.ok()) state.SkipWithError(result.status.reason);
    benchmark::DoNotOptimize(result.matches.data());
  }
  state.SetComplexityN(state.range(0));
}

void absolute_trajectory_error(benchmark::State& state) {
  const Trajectory reference = reference_of(state.range(0));
  const Trajectory estimate = estimate_of(state.range(0));
  for (auto iteration : state) {
    const auto result = srslam::absolute_trajectory_error(reference, estimate);
    if (!result.status.ok()) state.SkipWithError(result.status.reason);
    benchmark::DoNotOptimize(result.translation_m.rmse);
  }
  state.SetComplexityN(state.range(0));
}

void relative_pose_error(benchmark::State& state, srslam::RpeDefinition definition) {
  const Trajectory reference = reference_of(state.range(0));
  const Trajectory estimate = estimate_of(state.range(0));
  srslam::RpeOptions options;
  options.unit = srslam::RpeDelta::kSeconds;
  options.definition = definition;
  for (auto iteration : state) {
    const auto result = srslam::relative_pose_error(reference, estimate, options);
    if (!result.status.ok()) state.SkipWithError(result.status.reason);
    benchmark::DoNotOptimize(result.translation_m.rmse);
  }
  state.SetComplexityN(state.range(0));
}

const std::int64_t kShortest = 1000;
const std::int64_t kLongest = 100000;

BENCHMARK(associate)
    ->ArgNames({"poses", "tolerance_ms"})
    ->ArgsProduct({benchmark::CreateRange(kShortest, kLongest, 10), {20}})
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
// A tolerance of an hour: every pose is within it of every other.
BENCHMARK(associate)
    ->Name("associate_any_difference")
    ->ArgNames({"poses", "tolerance_ms"})
    ->ArgsProduct({benchmark::CreateRange(kShortest, kLongest, 10), {3600000}})
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK(absolute_trajectory_error)
    ->RangeMultiplier(10)
    ->Range(kShortest, kLongest)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK_CAPTURE(relative_pose_error, matched_poses, srslam::RpeDefinition::kMatchedPoses)
    ->RangeMultiplier(10)
    ->Range(kShortest, kLongest)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();
BENCHMARK_CAPTURE(relative_pose_error, tum_tool, srslam::RpeDefinition::kTumTool)
    ->RangeMultiplier(10)
    ->Range(kShortest, kLongest)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

}  // namespace
