#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"

namespace srslam {

/// Points in cells, cells in rows, rows in a tree: what the grid keeps. A cell is a run of points,
/// a row a run of cells that differ along one axis only.
template <typename Scalar>
struct DbscanGridBuffers {
  static constexpr std::size_t kMaxDimension = 6;
  template <typename T>
  using PerAxis = std::array<std::vector<T>, kMaxDimension>;

  PerAxis<std::uint32_t> bins;                      ///< of each valid point
  std::vector<Scalar> axis_values;                  ///< one axis, sorted
  std::vector<std::uint32_t> order, order_before;   ///< valid points, sorted
  std::vector<std::uint32_t> digit_begin;           ///< of a counting sort
  PerAxis<Scalar> sorted;                           ///< coordinates in that order
  std::vector<std::uint32_t> cell_begin, cell_bin;  ///< first point; bin along the row
  std::vector<std::uint32_t> row_begin;             ///< first cell
  std::array<std::vector<std::uint32_t>, kMaxDimension - 1> level_bin, level_begin;

  std::vector<std::uint8_t> point_state;     ///< of each sorted point
  std::vector<std::uint32_t> cell_core_end;  ///< core points stand first in a cell
  PerAxis<Scalar> cell_low, cell_high;       ///< box of the core points
  std::vector<std::uint32_t> cell_parent;    ///< cells of one cluster, as a forest
  std::vector<std::uint32_t> point_cell;     ///< whose cluster a point joins
  std::vector<std::int32_t> cluster_of;      ///< of each root

  /// What one thread needs for itself.
  struct Thread {
    std::vector<std::uint32_t> rows, first_cell, last_cell;  ///< near rows; their cells in reach
    std::vector<std::uint32_t> parent;                       ///< its own forest
    std::uint64_t num_comparisons = 0;
  };
  std::vector<Thread> threads;
};

/// Points sorted along one axis: what the sweep keeps.
template <typename Scalar>
struct DbscanSweepBuffers {
  std::vector<std::uint32_t> bin;             ///< of each valid point, along the axis
  std::vector<std::uint32_t> bin_end;         ///< of a counting sort
  std::vector<std::uint32_t> place;           ///< of each valid point in the order
  std::vector<std::uint32_t> input;           ///< index in the input of each sorted point
  std::array<std::vector<Scalar>, 6> sorted;  ///< coordinates in that order

  /// Neighbours of sixteen points.
  struct TileRow {
    std::uint32_t first_tile, end_tile;  ///< those in reach
    std::uint32_t bits;                  ///< words of its first point
  };
  std::vector<TileRow> tile_rows;
  std::vector<std::array<std::uint16_t, 16>> tiles;  ///< of the row that is being compared
  std::vector<std::uint64_t> neighbor_bits;
};

/// Buffers of dbscan(), kept by the caller so that a steady stream allocates nothing. O(n).
template <typename Scalar>
struct DbscanWorkspace {
  std::vector<PointKind> kinds;  ///< of the points of the last call, in their order

  // What follows belongs to the search.
  std::vector<std::uint32_t> input;                ///< index in the input of each valid point
  std::array<std::vector<Scalar>, 6> coordinates;  ///< of the valid points
  std::vector<std::uint64_t> neighbor_bits;        ///< brute force over few points
  std::array<std::vector<Scalar>, 6> remaining;    ///< brute force: points not yet reached
  std::vector<std::uint32_t> remaining_index, pending;
  DbscanSweepBuffers<Scalar> sweep;
  DbscanGridBuffers<Scalar> grid;
};

namespace detail {

/// Makes room for `size` elements and never less than before: nothing is written twice and a
/// steady stream allocates nothing.
template <typename T>
void reserve_elements(std::vector<T>& vector, std::size_t size) {
  if (vector.size() < size) vector.resize(size);
}

template <int D, typename Scalar>
PointAxes<Scalar, D> axes_of(const std::array<std::vector<Scalar>, 6>& coordinates) noexcept {
  PointAxes<Scalar, D> axes{};
  for (std::size_t axis = 0; axis < std::size_t(D); ++axis) axes[axis] = coordinates[axis].data();
  return axes;
}

/// What every search is given and fills: the valid points, and label and kind of each of them.
template <typename Scalar, int D>
struct DbscanProblem {
  PointAxes<Scalar, D> points{};
  std::size_t num_points = 0;
  Scalar eps = 0;
  Scalar eps_squared = 0;
  unsigned min_points = 1;
  const std::uint32_t* input = nullptr;  ///< index of a point in what follows
  std::int32_t* labels = nullptr;        ///< kNoiseLabel before the search
  PointKind* kinds = nullptr;            ///< PointKind::kNoise before the search
  std::uint64_t num_comparisons = 0;
  std::int32_t num_clusters = 0;

  NearTest<Scalar, D> near(std::size_t point) const noexcept {
    return {points, point, eps_squared};
  }
  bool is_core(std::size_t point) const noexcept { return kinds[input[point]] == PointKind::kCore; }
};

/// The core point that a border point belongs to: the nearest; of equally near ones that with the
/// smaller coordinates, axis by axis. No order of the input changes it.
template <typename Scalar, int D>
class NearestCore {
 public:
  void offer(const PointAxes<Scalar, D>& points, std::size_t index, Scalar squared_distance) {
    if (!found_ || squared_distance < squared_distance_ ||
        (squared_distance == squared_distance_ && precedes(points, index))) {
      found_ = true;
      index_ = index;
      squared_distance_ = squared_distance;
    }
  }
  bool found() const noexcept { return found_; }
  std::size_t index() const noexcept { return index_; }

 private:
  bool precedes(const PointAxes<Scalar, D>& points, std::size_t index) const noexcept {
    for (const Scalar* axis : points) {
      if (axis[index] != axis[index_]) return axis[index] < axis[index_];
    }
    return false;
  }

  bool found_ = false;
  std::size_t index_ = 0;
  Scalar squared_distance_ = 0;
};

}  // namespace detail
}  // namespace srslam
