// Clusters cases from standard input for check_against_sklearn.py. A case is int32 dimension, int32
// number of points, float64 eps, int32 min_points and the coordinates as float64; what comes out
// for each search is the number of clusters, then label and kind of every point, all int32.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "srslam/culling/dbscan.hpp"

namespace {

using srslam::NeighborSearch;

template <typename T>
bool read(T* values, std::size_t count) {
  return std::fread(values, sizeof(T), count, stdin) == count;
}

void write(std::int32_t value) { std::fwrite(&value, sizeof(value), 1, stdout); }

template <std::size_t D>
bool cluster_case(std::size_t num_points, double eps, int min_points) {
  std::vector<std::array<double, D>> points(num_points);
  if (num_points > 0 && !read(points.data()->data(), num_points * D)) return false;
  for (const NeighborSearch search :
       {NeighborSearch::kBruteForce, NeighborSearch::kSweep, NeighborSearch::kGrid}) {
    srslam::DbscanOptions options;
    options.eps = eps;
    options.min_points = min_points;
    options.search = search;
    srslam::DbscanWorkspace<double> workspace;
    std::vector<std::int32_t> labels(num_points);
    const srslam::DbscanResult result = srslam::dbscan(points, options, workspace, labels);
    if (!result.status.ok()) return false;
    write(result.num_clusters);
    for (std::size_t i = 0; i < num_points; ++i) {
      write(labels[i]);
      write(static_cast<std::int32_t>(workspace.kinds[i]));
    }
  }
  return true;
}

}  // namespace

int main() {
  std::int32_t dimension = 0;
  while (read(&dimension, 1)) {
    std::int32_t num_points = 0;
    double eps = 0.0;
    std::int32_t min_points = 0;
    if (!read(&num_points, 1) || !read(&eps, 1) || !read(&min_points, 1)) return 1;
    const auto n = std::size_t(num_points);
    bool done = false;
    switch (dimension) {
      case 1:
        done = cluster_case<1>(n, eps, min_points);
        break;
      case 2:
        done = cluster_case<2>(n, eps, min_points);
        break;
      case 3:
        done = cluster_case<3>(n, eps, min_points);
        break;
      case 4:
        done = cluster_case<4>(n, eps, min_points);
        break;
      case 5:
        done = cluster_case<5>(n, eps, min_points);
        break;
      case 6:
        done = cluster_case<6>(n, eps, min_points);
        break;
      default:
        break;
    }
    if (!done) return 1;
  }
  return 0;
}
