// Cost of core's functions. Inputs vary from call to call (a table of 1024), so that branch
// predictors and caches see what they see in use; items per second are calls per second.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Core>

#include "srslam/core/camera.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/orthonormalized.hpp"
#include "srslam/core/robust_cost.hpp"
#include "srslam/core/se3.hpp"

namespace {

using namespace srslam;

constexpr std::size_t kTable = 1024;

/// Deterministic numbers in [low, high).
class Numbers {
 public:
  std::uint64_t bits() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return state_ ^ (state_ >> 29U);
  }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11U) * 0x1.0p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

std::vector<Vector6> tangents(double max_angle_rad) {
  Numbers numbers;
  std::vector<Vector6> table(kTable);
  for (Vector6& tangent : table) {
    for (int i = 0; i < 3; ++i) tangent[i] = numbers.uniform(-1.0, 1.0);
    for (int i = 3; i < 6; ++i) {
      tangent[i] = numbers.uniform(-max_angle_rad, max_angle_rad) / 1.7320508;
    }
  }
  return table;
}

std::vector<Pose> poses(double max_angle_rad) {
  std::vector<Pose> table;
  for (const Vector6& tangent : tangents(max_angle_rad)) table.push_back(se3_exp(tangent));
  return table;
}

PinholeCamera tum_fr1() {
  return {640,      480,       517.306408, 516.469215, 318.643040, 255.313989,
          0.262383, -0.953104, -0.005358,  0.002628,   1.163314};
}

PinholeCamera tum_fr3() { return {640, 480, 535.4, 539.2, 320.1, 247.6, 0.0, 0.0, 0.0, 0.0, 0.0}; }

PinholeCamera camera_of(const benchmark::State& state) {
  return state.range(0) == 0 ? tum_fr3() : tum_fr1();
}

/// Pixels spread over the image.
std::vector<Eigen::Vector2d> pixels() {
  Numbers numbers;
  std::vector<Eigen::Vector2d> table(kTable);
  for (Eigen::Vector2d& pixel : table) {
    pixel.x() = numbers.uniform(-0.5, 639.5);
    pixel.y() = numbers.uniform(-0.5, 479.5);
  }
  return table;
}

/// Points that the camera sees all over its image.
std::vector<Eigen::Vector3d> points(const PinholeCamera& camera) {
  Numbers numbers;
  std::vector<Eigen::Vector3d> table;
  for (const Eigen::Vector2d& pixel : pixels()) {
    Eigen::Vector3d point = Eigen::Vector3d::UnitZ();
    camera.unproject(pixel, numbers.uniform(0.5, 8.0), &point);
    table.push_back(point);
  }
  return table;
}

/// Calls `body(i)` with i running through the table.
template <typename Body>
void run(benchmark::State& state, const Body& body) {
  std::size_t i = 0;
  for (auto _ : state) {
    body(i);
    i = (i + 1) % kTable;
  }
  state.SetItemsProcessed(state.iterations());
}

// The argument is the largest rotation in degrees: 2 is one frame's motion (series), 170 anything.
constexpr double kRadPerDegree = 0.017453292519943295;

void se3_exp_call(benchmark::State& state) {
  const std::vector<Vector6> table = tangents(static_cast<double>(state.range(0)) * kRadPerDegree);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(se3_exp(table[i])); });
}
BENCHMARK(se3_exp_call)->Name("se3_exp")->ArgName("degrees")->Arg(2)->Arg(170);

void se3_log_call(benchmark::State& state) {
  const std::vector<Pose> table = poses(static_cast<double>(state.range(0)) * kRadPerDegree);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(se3_log(table[i])); });
}
BENCHMARK(se3_log_call)->Name("se3_log")->ArgName("degrees")->Arg(2)->Arg(170);

void se3_left_jacobian_call(benchmark::State& state) {
  const std::vector<Vector6> table = tangents(static_cast<double>(state.range(0)) * kRadPerDegree);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(se3_left_jacobian(table[i])); });
}
BENCHMARK(se3_left_jacobian_call)->Name("se3_left_jacobian")->ArgName("degrees")->Arg(2)->Arg(170);

void se3_interpolate_call(benchmark::State& state) {
  const std::vector<Pose> table = poses(1.0);
  run(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(se3_interpolate(table[i], table[(i + 1) % kTable], 0.3));
  });
}
BENCHMARK(se3_interpolate_call)->Name("se3_interpolate");

void orthonormalized_call(benchmark::State& state) {
  const std::vector<Pose> table = poses(3.0);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(orthonormalized(table[i])); });
}
BENCHMARK(orthonormalized_call)->Name("orthonormalized");

void project_call(benchmark::State& state) {
  const PinholeCamera camera = camera_of(state);
  const std::vector<Eigen::Vector3d> table = points(camera);
  run(state, [&](std::size_t i) {
    Eigen::Vector2d pixel;
    benchmark::DoNotOptimize(camera.project(table[i], &pixel));
    benchmark::DoNotOptimize(pixel);
  });
}
BENCHMARK(project_call)->Name("project")->ArgName("distorted")->Arg(0)->Arg(1);

void project_point_jacobian(benchmark::State& state) {
  const PinholeCamera camera = camera_of(state);
  const std::vector<Eigen::Vector3d> table = points(camera);
  run(state, [&](std::size_t i) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> J_point;
    benchmark::DoNotOptimize(camera.project(table[i], &pixel, &J_point));
    benchmark::DoNotOptimize(pixel);
    benchmark::DoNotOptimize(J_point);
  });
}
BENCHMARK(project_point_jacobian)->ArgName("distorted")->Arg(0)->Arg(1);

void project_both_jacobians(benchmark::State& state) {
  const PinholeCamera camera = camera_of(state);
  const std::vector<Eigen::Vector3d> table = points(camera);
  run(state, [&](std::size_t i) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> J_point;
    Eigen::Matrix<double, 2, 9> J_intrinsics;
    benchmark::DoNotOptimize(camera.project(table[i], &pixel, &J_point, &J_intrinsics));
    benchmark::DoNotOptimize(pixel);
    benchmark::DoNotOptimize(J_point);
    benchmark::DoNotOptimize(J_intrinsics);
  });
}
BENCHMARK(project_both_jacobians)->ArgName("distorted")->Arg(0)->Arg(1);

void unproject_call(benchmark::State& state) {
  const PinholeCamera camera = camera_of(state);
  const std::vector<Eigen::Vector2d> table = pixels();
  run(state, [&](std::size_t i) {
    Eigen::Vector3d point;
    benchmark::DoNotOptimize(camera.unproject(table[i], 2.0, &point));
    benchmark::DoNotOptimize(point);
  });
}
BENCHMARK(unproject_call)->Name("unproject")->ArgName("distorted")->Arg(0)->Arg(1);

void undistort_pixel_call(benchmark::State& state) {
  const PinholeCamera camera = camera_of(state);
  const std::vector<Eigen::Vector2d> table = pixels();
  run(state, [&](std::size_t i) {
    Eigen::Vector2d pixel;
    benchmark::DoNotOptimize(camera.undistort_pixel(table[i], &pixel));
    benchmark::DoNotOptimize(pixel);
  });
}
BENCHMARK(undistort_pixel_call)->Name("undistort_pixel")->ArgName("distorted")->Arg(0)->Arg(1);

// The worst case: pixels that no ray reaches, on which the search must give up.
void undistort_unreachable(benchmark::State& state) {
  PinholeCamera camera = tum_fr3();
  camera.k1 = -0.5;  // reaches a radius of 0.544
  Numbers numbers;
  std::vector<Eigen::Vector2d> table(kTable);
  for (Eigen::Vector2d& distorted : table) {
    distorted = {numbers.uniform(0.55, 2.0), numbers.uniform(-2.0, 2.0)};
  }
  std::size_t num_found = 0;
  run(state, [&](std::size_t i) {
    Eigen::Vector2d normalized;
    num_found += camera.undistort(table[i], &normalized) ? 1 : 0;
  });
  if (num_found != 0) state.SkipWithError("an unreachable pixel was undistorted");
}
BENCHMARK(undistort_unreachable);

void robust_weight(benchmark::State& state) {
  const RobustCost cost{static_cast<RobustKind>(state.range(0)), 1.0, 5.0};
  state.SetLabel(to_string(cost.kind));
  Numbers numbers;
  std::vector<double> table(kTable);
  for (double& squared_residual : table) squared_residual = numbers.uniform(0.0, 4.0);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(cost.weight(table[i])); });
}
BENCHMARK(robust_weight)->ArgName("kind")->DenseRange(0, 4);

void robust_rho(benchmark::State& state) {
  const RobustCost cost{static_cast<RobustKind>(state.range(0)), 1.0, 5.0};
  state.SetLabel(to_string(cost.kind));
  Numbers numbers;
  std::vector<double> table(kTable);
  for (double& squared_residual : table) squared_residual = numbers.uniform(0.0, 4.0);
  run(state, [&](std::size_t i) { benchmark::DoNotOptimize(cost.rho(table[i])); });
}
BENCHMARK(robust_rho)->ArgName("kind")->DenseRange(0, 4);

void hamming_distance_call(benchmark::State& state) {
  Numbers numbers;
  std::vector<BinaryDescriptor> table(kTable);
  for (BinaryDescriptor& descriptor : table) {
    for (std::uint64_t& word : descriptor) word = numbers.bits();
  }
  run(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(hamming_distance(table[i], table[(i + 1) % kTable]));
  });
}
BENCHMARK(hamming_distance_call)->Name("hamming_distance");

void grid_cell_call(benchmark::State& state) {
  const std::vector<Eigen::Vector2d> table = pixels();
  run(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(grid_cell(table[i].x(), table[i].y(), 640, 480));
  });
}
BENCHMARK(grid_cell_call)->Name("grid_cell");

}  // namespace

BENCHMARK_MAIN();
