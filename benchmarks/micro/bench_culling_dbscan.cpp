// Clustering by each search over the inputs that clustering libraries differ on: features of an
// image with objects in it (slam), points without structure (uniform), one dense blob (blob).

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/culling/adaptive_dbscan.hpp"
#include "srslam/culling/dbscan.hpp"
#include "support/cluster_inputs.hpp"

namespace srslam {
namespace {

using test::ClusterInput;

template <typename Scalar, std::size_t D>
void cluster(benchmark::State& state, ClusterInput input, NeighborSearch search, int num_threads) {
  const auto n = std::size_t(state.range(0));
  DbscanOptions options;
  const std::vector<std::array<Scalar, D>> points =
      test::cluster_input<Scalar, D>(input, n, &options);
  options.search = search;
  options.num_threads = num_threads;
  DbscanWorkspace<Scalar> workspace;
  std::vector<std::int32_t> labels(n);
  DbscanResult result;
  for (auto _ : state) {
    result = dbscan(points, options, workspace, labels);
    benchmark::DoNotOptimize(labels.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.counters["clusters"] = result.num_clusters;
  state.counters["comparisons/point"] = double(result.num_comparisons) / double(n);
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetComplexityN(state.range(0));
}

/// The same with another draw of the input in every call, as in a stream: nothing that the
/// processor has learnt of one input (branches above all) helps with the next. 64 draws in turn.
template <std::size_t D>
void cluster_stream(benchmark::State& state, ClusterInput input, NeighborSearch search) {
  constexpr std::size_t kNumFrames = 64;
  const auto n = std::size_t(state.range(0));
  DbscanOptions options;
  std::vector<std::vector<std::array<float, D>>> frames;
  for (std::size_t frame = 0; frame < kNumFrames; ++frame) {
    frames.push_back(test::cluster_input<float, D>(input, n, &options, frame));
  }
  options.search = search;
  DbscanWorkspace<float> workspace;
  std::vector<std::int32_t> labels(n);
  std::size_t frame = 0;
  for (auto _ : state) {
    dbscan(frames[frame], options, workspace, labels);
    benchmark::DoNotOptimize(labels.data());
    frame = (frame + 1) % kNumFrames;
  }
}

template <typename Scalar, std::size_t D>
void register_dimension() {
  const std::string scalar = sizeof(Scalar) == sizeof(float) ? "float" : "double";
  for (const ClusterInput input :
       {ClusterInput::kSlam, ClusterInput::kUniform, ClusterInput::kBlob}) {
    for (const NeighborSearch search : {NeighborSearch::kAutomatic, NeighborSearch::kSweep,
                                        NeighborSearch::kGrid, NeighborSearch::kBruteForce}) {
      const std::string name = "dbscan/" + test::to_string(input) + "/" + std::to_string(D) + "d/" +
                               scalar + "/" + to_string(search);
      auto* const bench = benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
        cluster<Scalar, D>(state, input, search, 1);
      });
      for (const int n : {30, 100, 200, 300, 500, 1000, 3000, 10000}) bench->Arg(n);
      if (search != NeighborSearch::kBruteForce) bench->Arg(100000);
    }
    if (sizeof(Scalar) == sizeof(float)) {
      for (const NeighborSearch search : {NeighborSearch::kAutomatic, NeighborSearch::kSweep,
                                          NeighborSearch::kGrid, NeighborSearch::kBruteForce}) {
        const std::string name = "dbscan/" + test::to_string(input) + "/" + std::to_string(D) +
                                 "d/stream/" + to_string(search);
        auto* const bench = benchmark::RegisterBenchmark(
            name.c_str(),
            [=](benchmark::State& state) { cluster_stream<D>(state, input, search); });
        for (const int n : {30, 50, 70, 100, 120, 200, 300, 500, 1000, 2000, 4000}) {
          bench->Arg(n);
        }
      }
      benchmark::RegisterBenchmark(
          ("dbscan/" + test::to_string(input) + "/" + std::to_string(D) + "d/float/grid/2_threads")
              .c_str(),
          [=](benchmark::State& state) {
            cluster<Scalar, D>(state, input, NeighborSearch::kGrid, 2);
          })
          ->Arg(30000)
          ->Arg(100000)
          ->UseRealTime();
    }
  }
}

/// The claim of O(n²/N): n points in N groups of depth of the same size, every pair of a group
/// compared, n²/N comparisons. What is fitted is the time over them.
void groups_of_depth(benchmark::State& state) {
  const auto num_groups = std::size_t(state.range(0));
  const std::size_t n = num_groups * std::size_t(state.range(1));
  std::vector<FlowPoint> points(n);
  test::Rng rng(3);
  for (std::size_t i = 0; i < n; ++i) {
    points[i].u_px = float(rng.uniform(0.0, 640.0));
    points[i].v_px = float(rng.uniform(0.0, 480.0));
    points[i].depth_m = 1.0F + float(i % num_groups);
  }
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 525.0;
  AdaptiveDbscanOptions options;
  options.search = NeighborSearch::kBruteForce;
  AdaptiveDbscanWorkspace workspace;
  std::vector<std::int32_t> labels(n);
  AdaptiveDbscanResult result;
  for (auto _ : state) {
    result = adaptive_dbscan(points, {}, camera, {0.3, 1.2}, options, workspace, labels);
    benchmark::DoNotOptimize(labels.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.counters["comparisons"] = double(result.num_comparisons);
  state.SetComplexityN(std::int64_t(n * n / num_groups));
}

const int registered = [] {
  register_dimension<float, 2>();
  register_dimension<float, 3>();
  register_dimension<float, 4>();
  register_dimension<float, 5>();
  register_dimension<double, 2>();
  register_dimension<double, 3>();
  benchmark::RegisterBenchmark("adaptive_dbscan/n_squared_over_groups", groups_of_depth)
      ->ArgNames({"groups", "points_in_each"})
      ->ArgsProduct({{1, 2, 4, 8}, {128, 256, 512}})
      ->Complexity(benchmark::oN);
  return 0;
}();

void adaptive_against_plain(benchmark::State& state, bool group_depths) {
  // Anomalous points of a frame: three bodies at their depths, and background.
  const auto n = std::size_t(state.range(0));
  test::Rng rng(5);
  std::vector<FlowPoint> points(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t body = i % 4;
    points[i].u_px =
        float(body == 3 ? rng.uniform(0.0, 640.0) : 150.0 * double(body + 1) + 30.0 * rng.normal());
    points[i].v_px = float(body == 3 ? rng.uniform(0.0, 480.0) : 240.0 + 60.0 * rng.normal());
    points[i].depth_m = body == 3 ? float(rng.uniform(3.0, 4.0)) : 1.0F + 0.7F * float(body);
  }
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 525.0;
  AdaptiveDbscanOptions options;
  options.group_depths = group_depths;
  AdaptiveDbscanWorkspace workspace;
  std::vector<std::int32_t> labels(n);
  for (auto _ : state) {
    adaptive_dbscan(points, {}, camera, {0.3, 1.2}, options, workspace, labels);
    benchmark::DoNotOptimize(labels.data());
  }
}
BENCHMARK_CAPTURE(adaptive_against_plain, adaptive, true)->Arg(60)->Arg(120)->Arg(400)->Arg(1000);
BENCHMARK_CAPTURE(adaptive_against_plain, plain, false)->Arg(60)->Arg(120)->Arg(400)->Arg(1000);

}  // namespace
}  // namespace srslam
