// Every search against the definition on all kinds of points, and what must not change the
// clusters: order, threads, mirroring, shifts that round nothing.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/culling/dbscan.hpp"
#include "support/dbscan_reference.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::kPointPatterns;
using test::PointPattern;
using test::points_to_cluster;
using test::reference_dbscan;
using test::ReferenceClusters;
using test::Rng;

template <typename Point>
ReferenceClusters clusters_of(const std::vector<Point>& points, const DbscanOptions& options) {
  DbscanWorkspace<typename PointTraits<Point>::Scalar> workspace;
  ReferenceClusters clusters;
  clusters.labels.assign(points.size(), 77);
  const DbscanResult result = dbscan(points, options, workspace, clusters.labels);
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  clusters.kinds = workspace.kinds;
  clusters.num_clusters = result.num_clusters;
  EXPECT_EQ(result.num_core + result.num_border + result.num_noise, points.size());
  return clusters;
}

/// Calls compare(d) for the dimensions 1 to 6, d being a std::integral_constant.
template <typename Compare>
void for_each_dimension(const Compare& compare) {
  compare(std::integral_constant<std::size_t, 1>{});
  compare(std::integral_constant<std::size_t, 2>{});
  compare(std::integral_constant<std::size_t, 3>{});
  compare(std::integral_constant<std::size_t, 4>{});
  compare(std::integral_constant<std::size_t, 5>{});
  compare(std::integral_constant<std::size_t, 6>{});
}

/// Every search against the definition, on `n` points.
template <typename Scalar, std::size_t D>
void compare_searches(PointPattern pattern, std::size_t n, DbscanOptions options, Rng& rng) {
  const auto points = points_to_cluster<Scalar, D>(pattern, n, rng);
  if (pattern == PointPattern::kLattice) options.eps = 0.125;
  const ReferenceClusters expected = reference_dbscan(points, options.eps, options.min_points);
  for (const NeighborSearch search : {NeighborSearch::kAutomatic, NeighborSearch::kBruteForce,
                                      NeighborSearch::kSweep, NeighborSearch::kGrid}) {
    options.search = search;
    const ReferenceClusters found = clusters_of(points, options);
    SCOPED_TRACE(test::to_string(pattern) + ", " + std::to_string(n) + " points of " +
                 std::to_string(D) + " dimensions, eps " + std::to_string(options.eps) +
                 ", min_points " + std::to_string(options.min_points) + ", " + to_string(search));
    ASSERT_EQ(found.labels, expected.labels);
    ASSERT_EQ(found.kinds, expected.kinds);
    ASSERT_EQ(found.num_clusters, expected.num_clusters);
  }
}

template <typename Scalar, std::size_t D>
void compare_with_definition(Rng& rng) {
  for (const PointPattern pattern : kPointPatterns) {
    // Few points, a bit each; more; and so many that cells fill.
    for (const int max_points : {20, 256, 600}) {
      const auto n = std::size_t(rng.uniform_int(1, max_points));
      DbscanOptions options;
      options.eps = rng.uniform(0.05, 0.3);
      options.min_points = rng.uniform_int(1, 7);
      compare_searches<Scalar, D>(pattern, n, options, rng);
    }
  }
}

/// Sizes on either side of what tiles, words and the choice between searches depend on, and of
/// nothing in particular.
template <typename Scalar, std::size_t D>
void compare_sizes(Rng& rng) {
  for (const std::size_t n : {15U,  16U,  17U,  56U,  57U,  63U,  64U,  65U,  72U,  73U,  80U, 81U,
                              127U, 128U, 129U, 191U, 193U, 257U, 321U, 385U, 511U, 512U, 513U}) {
    const PointPattern pattern =
        kPointPatterns[std::size_t(rng.uniform_int(0, int(std::size(kPointPatterns)) - 1))];
    DbscanOptions options;
    options.eps = std::exp(rng.uniform(-3.5, 0.5));
    options.min_points = rng.uniform_int(1, 9);
    compare_searches<Scalar, D>(pattern, n, options, rng);
  }
}

TEST(DbscanProperty, SizesAroundEveryThresholdInFloat) {
  for_each_seed(8, [](Rng& rng) {
    for_each_dimension([&](auto d) { compare_sizes<float, decltype(d)::value>(rng); });
  });
}

TEST(DbscanProperty, SizesAroundEveryThresholdInDouble) {
  for_each_seed(8, [](Rng& rng) {
    for_each_dimension([&](auto d) { compare_sizes<double, decltype(d)::value>(rng); });
  });
}

template <std::size_t D>
void compare_largest_sweeps(Rng& rng) {
  for (const PointPattern pattern : kPointPatterns) {
    for (const std::size_t n : {4095U, 4096U, 4097U}) {
      const auto points = points_to_cluster<float, D>(pattern, n, rng);
      DbscanOptions options;
      options.eps = pattern == PointPattern::kLattice ? 0.125 : rng.uniform(0.05, 0.2);
      options.min_points = rng.uniform_int(2, 7);
      options.search = NeighborSearch::kBruteForce;
      const ReferenceClusters expected = clusters_of(points, options);
      for (const NeighborSearch search :
           {NeighborSearch::kAutomatic, NeighborSearch::kSweep, NeighborSearch::kGrid}) {
        options.search = search;
        const ReferenceClusters found = clusters_of(points, options);
        ASSERT_EQ(found.labels, expected.labels)
            << test::to_string(pattern) << ' ' << n << ' ' << to_string(search);
        ASSERT_EQ(found.kinds, expected.kinds);
      }
    }
  }
}

TEST(DbscanProperty, TheMostPointsThatAreSweptAndMore) {
  for_each_seed(1, [](Rng& rng) {
    compare_largest_sweeps<1>(rng);
    compare_largest_sweeps<2>(rng);
    compare_largest_sweeps<5>(rng);
  });
}

TEST(DbscanProperty, TransposingExchangesRowsAndColumns) {
  for_each_seed(50, [](Rng& rng) {
    std::array<std::uint16_t, 16> rows{};
    for (std::uint16_t& row : rows) row = std::uint16_t(rng.uniform_int(0, 0xffff));
    const std::array<std::uint16_t, 16> columns = detail::transposed(rows);
    for (unsigned row = 0; row < 16; ++row) {
      for (unsigned column = 0; column < 16; ++column) {
        ASSERT_EQ(rows[row] >> column & 1, columns[column] >> row & 1);
      }
    }
  });
}

TEST(DbscanProperty, EverySearchFindsWhatTheDefinitionSaysInFloat) {
  for_each_seed(4, [](Rng& rng) {
    for_each_dimension([&](auto d) { compare_with_definition<float, decltype(d)::value>(rng); });
  });
}

TEST(DbscanProperty, EverySearchFindsWhatTheDefinitionSaysInDouble) {
  for_each_seed(4, [](Rng& rng) {
    for_each_dimension([&](auto d) { compare_with_definition<double, decltype(d)::value>(rng); });
  });
}

TEST(DbscanProperty, OrderOfThePointsChangesNothingButNumbers) {
  for_each_seed(20, [](Rng& rng) {
    for (const PointPattern pattern : kPointPatterns) {
      const auto n = std::size_t(rng.uniform_int(1, 500));
      const auto points = points_to_cluster<float, 3>(pattern, n, rng);
      std::vector<std::size_t> order(n);
      std::iota(order.begin(), order.end(), 0U);
      for (std::size_t i = n; i > 1; --i) {
        std::swap(order[i - 1], order[std::size_t(rng.uniform_int(0, int(i) - 1))]);
      }
      std::vector<std::array<float, 3>> shuffled(n);
      for (std::size_t i = 0; i < n; ++i) shuffled[i] = points[order[i]];
      DbscanOptions options;
      options.eps = 0.125;
      for (const NeighborSearch search :
           {NeighborSearch::kBruteForce, NeighborSearch::kSweep, NeighborSearch::kGrid}) {
        options.search = search;
        const ReferenceClusters before = clusters_of(points, options);
        const ReferenceClusters after = clusters_of(shuffled, options);
        std::map<std::int32_t, std::int32_t> number;
        for (std::size_t i = 0; i < n; ++i) {
          ASSERT_EQ(after.kinds[i], before.kinds[order[i]]);
          const auto known = number.emplace(before.labels[order[i]], after.labels[i]).first;
          ASSERT_EQ(known->second, after.labels[i]) << test::to_string(pattern);
        }
        ASSERT_EQ(before.num_clusters, after.num_clusters);
      }
    }
  });
}

TEST(DbscanProperty, ThreadsChangeNoLabel) {
  for_each_seed(2, [](Rng& rng) {
    for (const PointPattern pattern : {PointPattern::kUniform, PointPattern::kBlobs}) {
      const auto points = points_to_cluster<float, 2>(pattern, 30000, rng);
      DbscanOptions options;
      options.eps = 0.1;
      options.min_points = 6;
      const ReferenceClusters one = clusters_of(points, options);
      EXPECT_GT(one.num_clusters, 0);
      for (const int num_threads : {2, 5}) {
        options.num_threads = num_threads;
        const ReferenceClusters several = clusters_of(points, options);
        EXPECT_EQ(one.labels, several.labels);
        EXPECT_EQ(one.kinds, several.kinds);
      }
    }
  });
}

TEST(DbscanProperty, MirroringAndExactShiftsChangeNothing) {
  for_each_seed(20, [](Rng& rng) {
    std::vector<std::array<float, 2>> points(400);
    for (auto& point : points) {
      for (float& x : point) x = float(rng.uniform_int(0, 4095)) / 1024.0F;
    }
    auto moved = points;
    for (auto& point : moved) {
      point[0] = 8.0F - point[0];
      point[1] += 32.0F;
    }
    DbscanOptions options;
    options.eps = 0.17;
    options.min_points = 5;
    options.search = NeighborSearch::kGrid;
    const ReferenceClusters before = clusters_of(points, options);
    const ReferenceClusters after = clusters_of(moved, options);
    EXPECT_EQ(before.kinds, after.kinds);
    for (std::size_t i = 0; i < points.size(); ++i) {
      // Border points between equally near clusters may change sides in a mirror.
      if (before.kinds[i] == PointKind::kCore) {
        ASSERT_EQ(before.labels[i], after.labels[i]);
      }
    }
  });
}

TEST(DbscanProperty, LargeEpsGivesOneClusterAndSmallEpsNoise) {
  for_each_seed(10, [](Rng& rng) {
    const auto points = points_to_cluster<double, 4>(PointPattern::kBlobs, 300, rng);
    DbscanOptions options;
    for (const NeighborSearch search :
         {NeighborSearch::kBruteForce, NeighborSearch::kSweep, NeighborSearch::kGrid}) {
      options.search = search;
      options.eps = 1e3;
      options.min_points = 1;
      EXPECT_EQ(clusters_of(points, options).num_clusters, 1);
      options.eps = 1e-9;
      EXPECT_EQ(clusters_of(points, options).num_clusters, 300);
      options.min_points = 2;
      EXPECT_EQ(clusters_of(points, options).num_clusters, 0);
    }
  });
}

}  // namespace
}  // namespace srslam
