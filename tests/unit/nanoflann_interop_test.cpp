#include "srslam/interop/nanoflann.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/dbscan_reference.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

template <typename Scalar, std::size_t D>
void compare_with_definition(test::Rng& rng) {
  for (const test::PointPattern pattern : test::kPointPatterns) {
    const auto n = std::size_t(rng.uniform_int(1, 400));
    const auto points = test::points_to_cluster<Scalar, D>(pattern, n, rng);
    DbscanOptions options;
    options.eps = pattern == test::PointPattern::kLattice ? 0.125 : rng.uniform(0.05, 0.3);
    options.min_points = rng.uniform_int(1, 7);
    DbscanWorkspace<Scalar> workspace;
    std::vector<std::int32_t> labels(n, 77);
    const DbscanResult result = dbscan_kd_tree(points, options, workspace, labels);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    const test::ReferenceClusters expected =
        test::reference_dbscan(points, options.eps, options.min_points);
    SCOPED_TRACE(test::to_string(pattern) + ", " + std::to_string(D) + " dimensions");
    ASSERT_EQ(labels, expected.labels);
    ASSERT_EQ(workspace.kinds, expected.kinds);
    ASSERT_EQ(result.num_clusters, expected.num_clusters);
    EXPECT_EQ(result.search, NeighborSearch::kKdTree);
  }
}

TEST(DbscanKdTree, FindsWhatTheDefinitionSays) {
  test::for_each_seed(4, [](test::Rng& rng) {
    compare_with_definition<float, 1>(rng);
    compare_with_definition<float, 2>(rng);
    compare_with_definition<double, 3>(rng);
    compare_with_definition<float, 4>(rng);
    compare_with_definition<double, 5>(rng);
    compare_with_definition<float, 6>(rng);
  });
}

TEST(DbscanKdTree, RefusesWhatEverySearchRefuses) {
  const std::vector<std::array<float, 2>> points(3);
  std::vector<std::int32_t> labels = {5, 5, 5};
  DbscanWorkspace<float> workspace;
  DbscanOptions options;
  options.eps = -1.0;
  EXPECT_EQ(dbscan_kd_tree(points, options, workspace, labels).status.code,
            StatusCode::kInvalidArgument);
  options = {};
  labels.pop_back();
  EXPECT_EQ(dbscan_kd_tree(points, options, workspace, labels).status.code,
            StatusCode::kInvalidArgument);
  EXPECT_EQ(labels[0], 5);
  labels.clear();
  const std::vector<std::array<float, 2>> none;
  EXPECT_EQ(dbscan_kd_tree(none, options, workspace, labels).num_clusters, 0);
}

}  // namespace
}  // namespace srslam
