#include "srslam/culling/dbscan.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include "support/constants.hpp"

/// A point of somebody else's.
struct TestKeypoint {
  int id = 0;
  float v_px = 0.0F;
  float u_px = 0.0F;
};

template <>
struct srslam::PointTraits<TestKeypoint> {
  using Scalar = float;
  static constexpr int kDimension = 2;
  static float coordinate(const TestKeypoint& point, int axis) {
    return axis == 0 ? point.u_px : point.v_px;
  }
};

namespace srslam {
namespace {

using testing::ElementsAre;
using Point1 = std::array<double, 1>;
using Point2 = std::array<double, 2>;

constexpr NeighborSearch kSearches[] = {NeighborSearch::kAutomatic, NeighborSearch::kBruteForce,
                                        NeighborSearch::kSweep, NeighborSearch::kGrid};

struct Clusters {
  DbscanResult result;
  std::vector<std::int32_t> labels;
  std::vector<PointKind> kinds;
};

template <typename Point>
Clusters cluster(const std::vector<Point>& points, double eps, int min_points,
                 NeighborSearch search) {
  DbscanOptions options;
  options.eps = eps;
  options.min_points = min_points;
  options.search = search;
  DbscanWorkspace<typename PointTraits<Point>::Scalar> workspace;
  Clusters clusters;
  clusters.labels.assign(points.size(), 77);
  clusters.result = dbscan(points, options, workspace, clusters.labels);
  EXPECT_TRUE(clusters.result.status.ok()) << clusters.result.status.reason;
  clusters.kinds = workspace.kinds;
  return clusters;
}

TEST(Dbscan, FindsWhatWasCountedByHand) {
  // Two groups on a line, a point at the rim of the first and one by itself.
  const std::vector<Point1> points = {{9.0}, {0.0}, {1.0}, {2.0}, {3.0}, {20.0}, {9.5}, {8.5}};
  for (const NeighborSearch search : kSearches) {
    const Clusters found = cluster(points, 1.0, 3, search);
    EXPECT_THAT(found.labels, ElementsAre(0, 1, 1, 1, 1, kNoiseLabel, 0, 0));
    EXPECT_THAT(found.kinds, ElementsAre(PointKind::kCore, PointKind::kBorder, PointKind::kCore,
                                         PointKind::kCore, PointKind::kBorder, PointKind::kNoise,
                                         PointKind::kCore, PointKind::kCore));
    EXPECT_EQ(found.result.num_clusters, 2);
    EXPECT_EQ(found.result.num_core, 5U);
    EXPECT_EQ(found.result.num_border, 2U);
    EXPECT_EQ(found.result.num_noise, 1U);
    EXPECT_EQ(found.result.num_invalid, 0U);
  }
}

TEST(Dbscan, NeighborsIncludeThePointItselfAndThoseAtEps) {
  const std::vector<Point2> points = {{0.0, 0.0}, {3.0, 4.0}};
  for (const NeighborSearch search : kSearches) {
    EXPECT_THAT(cluster(points, 5.0, 2, search).labels, ElementsAre(0, 0));
    EXPECT_THAT(cluster(points, 5.0, 3, search).labels, ElementsAre(kNoiseLabel, kNoiseLabel));
    EXPECT_THAT(cluster(points, 4.999, 2, search).labels, ElementsAre(kNoiseLabel, kNoiseLabel));
    EXPECT_THAT(cluster(points, 4.999, 1, search).labels, ElementsAre(0, 1));
  }
}

TEST(Dbscan, BorderPointsGoToTheNearestCorePoint) {
  // Two crosses of five and a point between them.
  std::vector<Point2> crosses;
  for (const double center : {0.0, 3.875}) {
    for (const Point2& arm : {Point2{0, 0}, {-1, 0}, {1, 0}, {0, 1}, {0, -1}}) {
      crosses.push_back({center + arm[0], arm[1]});
    }
  }
  crosses.push_back({1.9375, 0.0});
  for (const NeighborSearch search : kSearches) {
    // It sees both inner arms and itself, an arm its centre, itself and the point: a bridge of core
    // points, or none.
    EXPECT_EQ(cluster(crosses, 1.0, 3, search).result.num_clusters, 1);
    const Clusters stricter = cluster(crosses, 1.0, 4, search);
    EXPECT_EQ(stricter.result.num_clusters, 2);
    EXPECT_EQ(stricter.labels[10], kNoiseLabel);
    EXPECT_EQ(stricter.result.num_core, 2U);
    EXPECT_EQ(stricter.result.num_border, 8U);
  }
  // A point that sees one core point on either side, the right one nearer.
  const std::vector<Point1> line = {{-1.0}, {0.0}, {0.5}, {1.0}, {1.95},
                                    {2.8},  {3.4}, {3.6}, {4.0}};
  for (const NeighborSearch search : kSearches) {
    const Clusters found = cluster(line, 1.0, 4, search);
    ASSERT_EQ(found.kinds[4], PointKind::kBorder);
    EXPECT_EQ(found.result.num_clusters, 2);
    EXPECT_EQ(found.labels[4], found.labels[5]);
  }
}

TEST(Dbscan, BorderPointsBetweenEquallyNearOnesGoToTheSmallerCoordinates) {
  std::vector<Point1> points = {{3.5}, {3.25}, {3.0}, {2.0}, {1.0}, {0.75}, {0.5}};
  for (const NeighborSearch search : kSearches) {
    for (int order = 0; order < 2; ++order) {
      const Clusters found = cluster(points, 1.0, 4, search);
      ASSERT_EQ(found.kinds[3], PointKind::kBorder);
      const std::size_t smaller = order == 0 ? 4 : 2;
      EXPECT_EQ(found.labels[3], found.labels[smaller]);
      EXPECT_NE(found.labels[2], found.labels[4]);
      std::reverse(points.begin(), points.end());
    }
  }
}

TEST(Dbscan, ClustersAreNumberedByTheirFirstCorePoint) {
  // The first point is a border point of the cluster whose core points come last.
  const std::vector<Point1> points = {{11.0}, {0.0}, {0.1}, {0.2}, {10.0}, {10.1}, {10.2}};
  for (const NeighborSearch search : kSearches) {
    EXPECT_THAT(cluster(points, 0.85, 3, search).labels, ElementsAre(1, 0, 0, 0, 1, 1, 1));
  }
}

TEST(Dbscan, PointsThatAreNoNumbersAreNoiseAndNobodysNeighbors) {
  const std::vector<Point2> points = {
      {0.0, 0.0}, {test::kNan, 0.0}, {0.0, test::kInf}, {-test::kInf, test::kNan}, {0.1, 0.0}};
  for (const NeighborSearch search : kSearches) {
    const Clusters found = cluster(points, 1.0, 2, search);
    EXPECT_THAT(found.labels, ElementsAre(0, kNoiseLabel, kNoiseLabel, kNoiseLabel, 0));
    EXPECT_EQ(found.result.num_invalid, 3U);
    EXPECT_EQ(found.result.num_noise, 3U);
    EXPECT_EQ(cluster(points, 1.0, 3, search).result.num_clusters, 0);
    const Clusters alone = cluster(std::vector<Point2>{points[1], points[2]}, 1.0, 1, search);
    EXPECT_THAT(alone.labels, ElementsAre(kNoiseLabel, kNoiseLabel));
    EXPECT_EQ(alone.result.num_invalid, 2U);
  }
}

TEST(Dbscan, NoPointsAndOnePoint) {
  for (const NeighborSearch search : kSearches) {
    EXPECT_EQ(cluster(std::vector<Point2>{}, 1.0, 1, search).result.num_clusters, 0);
    EXPECT_THAT(cluster(std::vector<Point2>{{5.0, 5.0}}, 1.0, 1, search).labels, ElementsAre(0));
    EXPECT_THAT(cluster(std::vector<Point2>{{5.0, 5.0}}, 1.0, 2, search).labels,
                ElementsAre(kNoiseLabel));
  }
}

TEST(Dbscan, TakesVectorsOfEigenAndTypesOfTheUser) {
  std::vector<Eigen::Vector2f> vectors;
  std::vector<TestKeypoint> keypoints;
  for (int i = 0; i < 5; ++i) {
    const float u_px = i < 3 ? float(i) : 100.0F + float(i);
    vectors.emplace_back(u_px, 7.0F);
    keypoints.push_back({i, 7.0F, u_px});
  }
  for (const NeighborSearch search : kSearches) {
    EXPECT_THAT(cluster(vectors, 1.5, 2, search).labels, ElementsAre(0, 0, 0, 1, 1));
    EXPECT_THAT(cluster(keypoints, 1.5, 2, search).labels, ElementsAre(0, 0, 0, 1, 1));
  }
}

TEST(Dbscan, WritesWhereItIsTold) {
  const std::vector<Point1> points = {{0.0}, {0.1}, {5.0}};
  std::array<std::int32_t, 5> labels = {9, 9, 9, 9, 9};
  DbscanOptions options;
  options.eps = 0.5;
  options.min_points = 2;
  DbscanWorkspace<double> workspace;
  const DbscanResult result =
      dbscan(ArrayView<const Point1>(points.data(), 3), options, workspace, {labels.data() + 1, 3});
  ASSERT_TRUE(result.status.ok());
  EXPECT_THAT(labels, ElementsAre(9, 0, 0, kNoiseLabel, 9));
}

TEST(Dbscan, RefusesWhatItCannotDo) {
  const std::vector<std::array<float, 2>> points(3);
  std::vector<std::int32_t> labels = {5, 5, 5};
  DbscanWorkspace<float> workspace;
  const auto code_of = [&](DbscanOptions options) {
    const DbscanResult result = dbscan(points, options, workspace, labels);
    EXPECT_STRNE(result.status.reason, "");
    EXPECT_THAT(labels, ElementsAre(5, 5, 5));
    return result.status.code;
  };
  DbscanOptions options;
  for (const double eps : {0.0, -1.0, test::kNan, test::kInf, 1e-30, 1e30}) {
    options.eps = eps;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument) << eps;
  }
  options = {};
  options.min_points = 0;
  EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
  for (const int num_threads : {0, 65}) {
    options = {};
    options.num_threads = num_threads;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
  }
  options = {};
  options.search = NeighborSearch::kKdTree;
  EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
  options = {};
  std::vector<std::int32_t> too_few = {5, 5};
  EXPECT_EQ(dbscan(points, options, workspace, too_few).status.code, StatusCode::kInvalidArgument);
  EXPECT_THAT(too_few, ElementsAre(5, 5));
}

TEST(Dbscan, WorkspaceServesProblemsOfAnySize) {
  DbscanWorkspace<double> workspace;
  DbscanOptions options;
  options.eps = 1.5;
  options.min_points = 2;
  for (const NeighborSearch search : kSearches) {
    options.search = search;
    for (const std::size_t n : {600U, 3U, 1000U, 0U, 70U}) {
      std::vector<Point2> points(n);
      for (std::size_t i = 0; i < n; ++i) points[i] = {double(i), double(i % 2)};
      std::vector<std::int32_t> labels(n);
      const DbscanResult result = dbscan(points, options, workspace, labels);
      ASSERT_TRUE(result.status.ok());
      EXPECT_EQ(result.num_clusters, n == 0 ? 0 : 1);
      EXPECT_EQ(result.num_core, n);
      EXPECT_EQ(workspace.kinds.size(), n);
    }
  }
}

TEST(Dbscan, DenseCellsNeedNoDistances) {
  std::vector<Point2> points(5000);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {1e-4 * double(i % 71), 1e-4 * double(i % 67)};
  }
  const Clusters grid = cluster(points, 0.05, 5, NeighborSearch::kGrid);
  EXPECT_EQ(grid.result.num_clusters, 1);
  EXPECT_EQ(grid.result.num_comparisons, 0U);
  EXPECT_EQ(grid.result.search, NeighborSearch::kGrid);
}

TEST(Dbscan, EveryPairIsComparedWhereThatIsAskedFor) {
  std::vector<Point2> points(200);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = {double(i), 0.0};
  const Clusters every_pair = cluster(points, 1.5, 3, NeighborSearch::kBruteForce);
  EXPECT_EQ(every_pair.result.search, NeighborSearch::kBruteForce);
  EXPECT_EQ(every_pair.result.num_comparisons, 200U * 200U);
  const Clusters swept = cluster(points, 1.5, 3, NeighborSearch::kSweep);
  EXPECT_EQ(swept.result.search, NeighborSearch::kSweep);
  // Sixteen points with themselves and the next tile.
  EXPECT_LE(swept.result.num_comparisons, 200U * 32U);
  EXPECT_EQ(swept.labels, every_pair.labels);
}

TEST(Dbscan, ChoosesTheSearchByNumberAndDensity) {
  const auto search_of = [](std::size_t n, double spacing, NeighborSearch search) {
    std::vector<Point2> points(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t row = i / 64;
      points[i] = {spacing * double(i % 64), spacing * double(row)};
    }
    return cluster(points, 1.0, 4, search).result.search;
  };
  EXPECT_EQ(search_of(80, 1.0, NeighborSearch::kAutomatic), NeighborSearch::kBruteForce);
  EXPECT_EQ(search_of(81, 1.0, NeighborSearch::kAutomatic), NeighborSearch::kSweep);
  EXPECT_EQ(search_of(4096, 1.0, NeighborSearch::kAutomatic), NeighborSearch::kSweep);
  EXPECT_EQ(search_of(4096, 1.0, NeighborSearch::kSweep), NeighborSearch::kSweep);
  EXPECT_EQ(search_of(4097, 1.0, NeighborSearch::kAutomatic), NeighborSearch::kGrid);
  EXPECT_EQ(search_of(4097, 1.0, NeighborSearch::kSweep), NeighborSearch::kGrid);
  EXPECT_EQ(search_of(1000, 0.1, NeighborSearch::kAutomatic), NeighborSearch::kGrid) << "dense";
  EXPECT_EQ(search_of(100, 0.01, NeighborSearch::kAutomatic), NeighborSearch::kGrid) << "one cell";
  // A point far away hides the density from the box but not from the sorted axis.
  std::vector<Point2> points(3000, Point2{0.0, 0.0});
  points[0] = {1e6, 1e6};
  const Clusters found = cluster(points, 1.0, 4, NeighborSearch::kAutomatic);
  EXPECT_EQ(found.result.search, NeighborSearch::kGrid);
  EXPECT_EQ(found.result.num_core, 2999U);
}

TEST(Dbscan, TakesCoordinatesWhoseDifferenceIsNoNumber) {
  constexpr float kFar = 3e38F;
  std::vector<std::array<float, 2>> points;
  for (int i = 0; i < 90; ++i) {
    const float x = i % 3 == 0 ? kFar : (i % 3 == 1 ? -kFar : 0.25F * float(i));
    points.push_back({x, i % 2 == 0 ? kFar : -kFar});
  }
  const Clusters expected = cluster(points, 1.0, 3, NeighborSearch::kBruteForce);
  EXPECT_EQ(expected.result.num_invalid, 0U);
  EXPECT_GE(expected.result.num_clusters, 4);
  for (const NeighborSearch search : kSearches) {
    EXPECT_EQ(cluster(points, 1.0, 3, search).labels, expected.labels) << to_string(search);
  }
}

TEST(Dbscan, ComparesFewPointsWhereManyAreSpreadOut) {
  std::vector<Point2> points;
  for (int x = 0; x < 200; ++x) {
    for (int y = 0; y < 200; ++y) points.push_back({double(x), double(y)});
  }
  const Clusters found = cluster(points, 1.0, 5, NeighborSearch::kGrid);
  EXPECT_EQ(found.result.num_clusters, 1);
  EXPECT_EQ(found.result.num_core, 198U * 198U);
  EXPECT_EQ(found.result.num_noise, 4U) << "the corners see border points only";
  EXPECT_LT(found.result.num_comparisons, 50U * points.size());
}

}  // namespace
}  // namespace srslam
