// Clustering over nanoflann's kd-tree, on the inputs of bench_culling: beside it the search that
// dbscan() takes by itself.

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/interop/nanoflann.hpp"
#include "support/cluster_inputs.hpp"

namespace srslam {
namespace {

template <std::size_t D>
void cluster(benchmark::State& state, test::ClusterInput input, NeighborSearch search) {
  const auto n = std::size_t(state.range(0));
  DbscanOptions options;
  const std::vector<std::array<float, D>> points =
      test::cluster_input<float, D>(input, n, &options);
  DbscanWorkspace<float> workspace;
  std::vector<std::int32_t> labels(n);
  DbscanResult result;
  for (auto _ : state) {
    result = search == NeighborSearch::kKdTree ? dbscan_kd_tree(points, options, workspace, labels)
                                               : dbscan(points, options, workspace, labels);
    benchmark::DoNotOptimize(labels.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.counters["clusters"] = result.num_clusters;
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

template <std::size_t D>
void register_kd_tree() {
  for (const test::ClusterInput input : {test::ClusterInput::kSlam, test::ClusterInput::kUniform}) {
    for (const NeighborSearch search : {NeighborSearch::kKdTree, NeighborSearch::kAutomatic}) {
      const std::string name = "dbscan/" + test::to_string(input) + "/" + std::to_string(D) +
                               "d/float/" + to_string(search);
      auto* const bench = benchmark::RegisterBenchmark(
          name.c_str(), [=](benchmark::State& state) { cluster<D>(state, input, search); });
      for (const int n : {30, 60, 120, 300, 1000, 3000, 10000}) bench->Arg(n);
    }
  }
}

const int registered = [] {
  register_kd_tree<2>();
  register_kd_tree<3>();
  return 0;
}();

}  // namespace
}  // namespace srslam
