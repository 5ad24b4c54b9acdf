#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan.hpp"
#include "support/allocation_counter.hpp"

namespace srslam {
namespace {

TEST(CullingAllocation, ClusteringAStreamAllocatesOnlyAtItsStart) {
  DbscanOptions options;
  options.eps = 0.06;
  for (const NeighborSearch search : {NeighborSearch::kBruteForce, NeighborSearch::kGrid}) {
    for (const std::size_t n : {200U, 2000U}) {
      options.search = search;
      DbscanWorkspace<float> workspace;
      std::vector<std::array<float, 3>> points(n);
      std::vector<std::int32_t> labels(n);
      const auto cluster_frames = [&](std::size_t count) {
        for (std::size_t frame = 0; frame < count; ++frame) {
          for (std::size_t i = 0; i < n; ++i) {
            const std::size_t k = i + frame;
            points[i] = {float((37 * k) % 101) / 101.0F, float((53 * k) % 97) / 97.0F,
                         float((71 * k) % 89) / 89.0F};
          }
          ASSERT_TRUE(dbscan(points, options, workspace, labels).status.ok());
        }
      };
      EXPECT_GT(test::count_allocations([&] { cluster_frames(10); }), 0U);
      EXPECT_EQ(test::count_allocations([&] { cluster_frames(40); }), 0U) << to_string(search);
    }
  }
}

}  // namespace
}  // namespace srslam
