#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <nanoflann.hpp>

#include "srslam/core/array_view.hpp"
#include "srslam/culling/dbscan.hpp"

namespace srslam {

namespace detail {

/// Points of a clustering problem as nanoflann wants to see them.
template <typename Scalar, int D>
struct KdTreePoints {
  PointAxes<Scalar, D> axes;
  std::size_t num_points;

  std::size_t kdtree_get_point_count() const noexcept { return num_points; }
  Scalar kdtree_get_pt(std::size_t index, std::size_t axis) const noexcept {
    return axes[axis][index];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const noexcept {
    return false;
  }
};

/// Hands the neighbours of a point to a visitor, which returns false when it has seen enough.
template <typename Scalar, typename Visit>
class KdTreeVisitor {
 public:
  using DistanceType = Scalar;
  using IndexType = std::uint32_t;

  KdTreeVisitor(Scalar eps_squared, const Visit& visit)
      : eps_squared_(eps_squared), visit_(visit) {}

  bool addPoint(Scalar squared_distance, std::uint32_t index) {  // NOLINT: named by nanoflann
    return !(squared_distance <= eps_squared_) || visit_(index, squared_distance);
  }
  /// A little more than what counts, because distances to branches of the tree are rounded
  /// otherwise than those to points.
  Scalar worstDist() const noexcept { return eps_squared_ * Scalar(1.0001); }  // NOLINT
  bool full() const noexcept { return true; }
  void sort() const noexcept {}
  std::size_t size() const noexcept { return 0; }

 private:
  Scalar eps_squared_;
  const Visit& visit_;
};

template <typename Scalar, int D>
class KdTreeClustering {
 public:
  KdTreeClustering(DbscanProblem<Scalar, D>& problem, DbscanWorkspace<Scalar>& workspace)
      : problem_(problem),
        workspace_(workspace),
        points_{problem.points, problem.num_points},
        tree_(D, points_, nanoflann::KDTreeSingleIndexAdaptorParams(kMaxLeafPoints)) {
    tree_.buildIndex();
  }

  void run() {
    for (std::size_t i = 0; i < problem_.num_points; ++i) {
      unsigned num_neighbors = 0;
      visit_neighbors(i, [&](std::size_t /*other*/, Scalar /*squared_distance*/) {
        return ++num_neighbors < problem_.min_points;
      });
      if (num_neighbors >= problem_.min_points) {
        problem_.kinds[problem_.input[i]] = PointKind::kCore;
      }
    }
    reserve_elements(workspace_.pending, problem_.num_points);
    for (std::size_t i = 0; i < problem_.num_points; ++i) {
      if (problem_.is_core(i) && problem_.labels[problem_.input[i]] == kNoiseLabel) grow_from(i);
    }
    for (std::size_t i = 0; i < problem_.num_points; ++i) {
      if (problem_.is_core(i)) continue;
      NearestCore<Scalar, D> nearest;
      visit_neighbors(i, [&](std::size_t other, Scalar squared_distance) {
        if (problem_.is_core(other)) nearest.offer(problem_.points, other, squared_distance);
        return true;
      });
      join_nearest_core(problem_, i, nearest);
    }
  }

 private:
  static constexpr std::size_t kMaxLeafPoints = 16;
  using Points = KdTreePoints<Scalar, D>;
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<Scalar, Points>,
                                                   Points, D, std::uint32_t>;

  template <typename Visit>
  void visit_neighbors(std::size_t point, const Visit& visit) {
    Scalar query[std::size_t(D)];
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      query[axis] = problem_.points[axis][point];
    }
    const auto counted = [&](std::size_t other, Scalar squared_distance) {
      ++problem_.num_comparisons;
      return visit(other, squared_distance);
    };
    KdTreeVisitor<Scalar, decltype(counted)> visitor(problem_.eps_squared, counted);
#if NANOFLANN_VERSION < 0x150
    tree_.findNeighbors(visitor, query, nanoflann::SearchParams(32, 0.0F, false));
#else
    tree_.findNeighbors(visitor, query, nanoflann::SearchParameters(0.0F, false));
#endif
  }

  void grow_from(std::size_t seed) {
    const std::int32_t cluster = problem_.num_clusters++;
    std::uint32_t* const pending = workspace_.pending.data();
    std::size_t num_pending = 0;
    const auto reach = [&](std::size_t point) {
      problem_.labels[problem_.input[point]] = cluster;
      pending[num_pending++] = std::uint32_t(point);
    };
    reach(seed);
    while (num_pending > 0) {
      visit_neighbors(pending[--num_pending], [&](std::size_t other, Scalar /*squared*/) {
        if (problem_.is_core(other) && problem_.labels[problem_.input[other]] == kNoiseLabel) {
          reach(other);
        }
        return true;
      });
    }
  }

  DbscanProblem<Scalar, D>& problem_;
  DbscanWorkspace<Scalar>& workspace_;
  Points points_;
  Tree tree_;
};

}  // namespace detail

/// dbscan() with neighbours found by nanoflann's kd-tree: the same clusters, numbers and kinds.
/// `options.search` is not looked at, `num_threads` neither; num_comparisons counts the neighbours
/// that were met. O(n log n + neighbours): n² where all points are near each other. The tree is
/// built anew and allocates.
template <typename Point>
DbscanResult dbscan_kd_tree(ArrayView<const Point> points, const DbscanOptions& options,
                            DbscanWorkspace<typename PointTraits<Point>::Scalar>& workspace,
                            ArrayView<std::int32_t> labels) {
  using Scalar = typename PointTraits<Point>::Scalar;
  constexpr int kDimension = PointTraits<Point>::kDimension;
  return detail::cluster_points(
      points, options, workspace, labels, [&](detail::DbscanProblem<Scalar, kDimension>& problem) {
        if (problem.num_points > 0) {
          detail::KdTreeClustering<Scalar, kDimension>(problem, workspace).run();
        }
        return NeighborSearch::kKdTree;
      });
}

/// The same for a vector of points.
template <typename Point, typename Allocator>
DbscanResult dbscan_kd_tree(const std::vector<Point, Allocator>& points,
                            const DbscanOptions& options,
                            DbscanWorkspace<typename PointTraits<Point>::Scalar>& workspace,
                            ArrayView<std::int32_t> labels) {
  return dbscan_kd_tree(ArrayView<const Point>(points.data(), points.size()), options, workspace,
                        labels);
}

}  // namespace srslam
