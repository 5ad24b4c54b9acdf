#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/status.hpp"
#include "srslam/culling/dbscan_brute_force.hpp"
#include "srslam/culling/dbscan_cells.hpp"
#include "srslam/culling/dbscan_sweep.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam {

namespace detail {

/// Points up to which every pair is faster than a sort: measured on points like an image's features
/// and on uniform ones, between whose crossings it lies (docs/dbscan.md).
constexpr std::size_t max_points_for_brute_force(int dimension) noexcept {
  return dimension <= 2 ? 80 : (dimension == 3 ? 72 : 56);
}

/// Copies the valid points axis by axis; the others are noise.
template <typename Point, typename Scalar>
std::size_t gather_valid_points(ArrayView<const Point> points, DbscanWorkspace<Scalar>& workspace) {
  using Traits = PointTraits<Point>;
  constexpr int kDimension = Traits::kDimension;
  reserve_elements(workspace.input, points.size);
  for (std::size_t axis = 0; axis < std::size_t(kDimension); ++axis) {
    reserve_elements(workspace.coordinates[axis], points.size + 16);
  }
  std::size_t num_valid = 0;
  for (std::size_t i = 0; i < points.size; ++i) {
    bool valid = true;
    for (int axis = 0; axis < kDimension; ++axis) {
      const Scalar value = Traits::coordinate(points[i], axis);
      workspace.coordinates[std::size_t(axis)][num_valid] = value;
      valid = valid && std::isfinite(value);
    }
    workspace.input[num_valid] = std::uint32_t(i);
    num_valid += valid ? 1U : 0U;
  }
  return num_valid;
}

/// What dbscan() and its like have in common: checks, the valid points, and the sums. `search`
/// takes the problem, fills labels and kinds, and returns what it was.
template <typename Point, typename Scalar, typename Search>
DbscanResult cluster_points(ArrayView<const Point> points, const DbscanOptions& options,
                            DbscanWorkspace<Scalar>& workspace, ArrayView<std::int32_t> labels,
                            const Search& search) {
  constexpr int kDimension = PointTraits<Point>::kDimension;
  static_assert(kDimension >= 1 && kDimension <= 6, "points have 1 to 6 dimensions");
  static_assert(std::is_same_v<Scalar, float> || std::is_same_v<Scalar, double>,
                "coordinates are float or double");
  DbscanResult result;
  const auto fail = [&](StatusCode code, const char* reason) {
    result.status = Status::failure(code, reason);
    return result;
  };
  result.status = options.validate();
  if (!result.status.ok()) return result;
  const Scalar eps = static_cast<Scalar>(options.eps);
  if (!std::isnormal(eps * eps)) {
    return fail(StatusCode::kInvalidArgument,
                "the square of eps is too small or too large for the type of the coordinates");
  }
  if (labels.size != points.size) {
    return fail(StatusCode::kInvalidArgument, "labels must have a place for each point");
  }
  if (points.size > std::size_t(std::numeric_limits<std::int32_t>::max())) {
    return fail(StatusCode::kUnsupported, "more than 2147483647 points");
  }

  workspace.kinds.assign(points.size, PointKind::kNoise);
  std::fill(labels.begin(), labels.end(), kNoiseLabel);
  DbscanProblem<Scalar, kDimension> problem;
  problem.num_points = gather_valid_points(points, workspace);
  problem.points = axes_of<kDimension>(workspace.coordinates);
  problem.eps = eps;
  problem.eps_squared = eps * eps;
  problem.min_points = unsigned(options.min_points);
  problem.input = workspace.input.data();
  problem.labels = labels.data;
  problem.kinds = workspace.kinds.data();
  result.search = search(problem);
  for (const PointKind kind : workspace.kinds) {
    result.num_core += kind == PointKind::kCore ? 1U : 0U;
    result.num_border += kind == PointKind::kBorder ? 1U : 0U;
  }
  result.num_noise = points.size - result.num_core - result.num_border;
  result.num_invalid = points.size - problem.num_points;
  result.num_comparisons = problem.num_comparisons;
  result.num_clusters = problem.num_clusters;
  return result;
}

/// Clusters by the search that the options name, or by the one expected to be fastest; returns it.
template <typename Scalar, int D>
NeighborSearch search_and_cluster(DbscanProblem<Scalar, D>& problem, const DbscanOptions& options,
                                  DbscanWorkspace<Scalar>& workspace) {
  const std::size_t n = problem.num_points;
  NeighborSearch search = options.search;
  if (search == NeighborSearch::kAutomatic && n <= max_points_for_brute_force(D)) {
    search = NeighborSearch::kBruteForce;
  }
  if (n == 0) return search;
  if (search == NeighborSearch::kBruteForce) {
    if (n <= kMaxPointsAsBits) {
      cluster_few(problem, workspace);
    } else {
      cluster_brute_force(problem, workspace);
    }
    return search;
  }
  if (search != NeighborSearch::kGrid && n <= kMaxSweepPoints) {
    SweepClustering<Scalar, D> sweep(problem, workspace.sweep);
    if (search == NeighborSearch::kSweep) {
      sweep.run();
      return NeighborSearch::kSweep;
    }
    if (sweep.run_if_sparse()) return NeighborSearch::kSweep;
  }
  CellClustering<Scalar, D>(problem, workspace.grid, options.num_threads).run();
  return NeighborSearch::kGrid;
}

}  // namespace detail

/// DBSCAN (Ester et al. 1996), exact: a point with min_points points within eps of it, itself
/// included, is a core point; core points within eps of each other share a cluster; a point that is
/// not core belongs to the cluster of its nearest core point within eps (of equally near ones that
/// with the smaller coordinates, axis by axis); all others are noise. Which points are core, border
/// and noise and which of them share a cluster does not depend on the order of the points, the
/// search or the number of threads. Clusters are numbered by their first core point in the input.
///
/// `labels` has a place for each point: its cluster, or kNoiseLabel. Points with a coordinate that
/// is not finite are noise and neighbours of nothing. Distances are rounded as the coordinates'
/// type does.
///
/// O(n) memory, all of it the workspace's. Time O(n) in what a grid cell can see, whatever the
/// density: cells whose points are all near each other need no distances between them. Fails with
/// kInvalidArgument (options, size of labels, eps too small or too large for the coordinates' type)
/// or kUnsupported (2³¹ points or more); labels are then untouched.
template <typename Point>
DbscanResult dbscan(ArrayView<const Point> points, const DbscanOptions& options,
                    DbscanWorkspace<typename PointTraits<Point>::Scalar>& workspace,
                    ArrayView<std::int32_t> labels) {
  using Scalar = typename PointTraits<Point>::Scalar;
  constexpr int kDimension = PointTraits<Point>::kDimension;
  if (options.search == NeighborSearch::kKdTree) {
    DbscanResult result;
    result.status = Status::failure(
        StatusCode::kInvalidArgument,
        "the kd-tree is searched by dbscan_kd_tree() in srslam/interop/nanoflann.hpp");
    return result;
  }
  return detail::cluster_points(points, options, workspace, labels,
                                [&](detail::DbscanProblem<Scalar, kDimension>& problem) {
                                  return detail::search_and_cluster(problem, options, workspace);
                                });
}

/// The same for a vector of points.
template <typename Point, typename Allocator>
DbscanResult dbscan(const std::vector<Point, Allocator>& points, const DbscanOptions& options,
                    DbscanWorkspace<typename PointTraits<Point>::Scalar>& workspace,
                    ArrayView<std::int32_t> labels) {
  return dbscan(ArrayView<const Point>(points.data(), points.size()), options, workspace, labels);
}

}  // namespace srslam
