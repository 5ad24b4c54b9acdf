#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include "srslam/culling/dbscan_grid.hpp"
#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Fewer points are not worth the start of threads.
constexpr std::size_t kMinPointsForThreads = 20000;

/// Root of a tree whose nodes point at smaller ones.
inline std::uint32_t find_root(std::uint32_t* parent, std::uint32_t node) noexcept {
  while (parent[node] != node) {
    parent[node] = parent[parent[node]];
    node = parent[node];
  }
  return node;
}

inline std::uint32_t join_roots(std::uint32_t* parent, std::uint32_t a, std::uint32_t b) noexcept {
  if (b < a) std::swap(a, b);
  parent[b] = a;
  return a;
}

/// DBSCAN over the cells of a grid. Points of a compact cell that holds min_points are core without
/// a look at any other; the others count until they have enough. Core points of a cell are one
/// cluster, so that only cells have to be joined, by the first pair of near core points. Each of
/// the three passes goes over the rows and may be shared among threads: what a row gets depends on
/// earlier passes alone.
template <typename Scalar, int D>
class CellClustering {
 public:
  CellClustering(DbscanProblem<Scalar, D>& problem, DbscanGridBuffers<Scalar>& buffers,
                 int num_threads)
      : problem_(problem),
        buffers_(buffers),
        grid_(problem, buffers),
        points_(grid_.points()),
        num_threads_(problem.num_points < kMinPointsForThreads ? 1U : std::size_t(num_threads)) {
    const std::size_t n = problem.num_points;
    reserve_elements(buffers_.point_state, n);
    reserve_elements(buffers_.point_cell, n);
    reserve_elements(buffers_.cell_core_end, grid_.num_cells());
    reserve_elements(buffers_.cell_parent, grid_.num_cells());
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      reserve_elements(buffers_.cell_low[axis], grid_.num_cells());
      reserve_elements(buffers_.cell_high[axis], grid_.num_cells());
    }
    if (buffers_.threads.size() < num_threads_) buffers_.threads.resize(num_threads_);
  }

  void run() {
    for (auto& thread : buffers_.threads) thread.num_comparisons = 0;
    for_each_row([this](std::size_t row, Thread& thread) { find_core_points(row, thread); });
    connect_cells();
    for_each_row([this](std::size_t row, Thread& thread) { find_clusters(row, thread); });
    write_labels();
    for (const auto& thread : buffers_.threads) {
      problem_.num_comparisons += thread.num_comparisons;
    }
  }

 private:
  static constexpr std::size_t kNumAxes = std::size_t(D);
  using Grid = DbscanGrid<Scalar, D>;
  using Thread = typename DbscanGridBuffers<Scalar>::Thread;
  enum State : std::uint8_t { kAlone, kNotCore, kCore };
  static constexpr std::uint32_t kNoCell = 0xffffffffU;
  static constexpr std::uint32_t kFewPoints = 4;  ///< of a cell that is looked at point by point

  template <typename Work>
  void for_each_row(const Work& work) {
    const std::size_t num_rows = grid_.num_rows();
    if (num_threads_ == 1) {
      for (std::size_t row = 0; row < num_rows; ++row) work(row, buffers_.threads[0]);
      return;
    }
    // Blocks of rows, several a thread, because some rows take longer.
    const std::size_t block = num_rows / (num_threads_ * 16) + 1;
    std::atomic<std::size_t> next{0};
    const auto take_blocks = [&](Thread& thread) {
      for (std::size_t begin = next.fetch_add(block); begin < num_rows;
           begin = next.fetch_add(block)) {
        const std::size_t end = std::min(begin + block, num_rows);
        for (std::size_t row = begin; row < end; ++row) work(row, thread);
      }
    };
    std::vector<std::thread> others;
    others.reserve(num_threads_ - 1);
    for (std::size_t i = 1; i < num_threads_; ++i) {
      others.emplace_back([&, i] { take_blocks(buffers_.threads[i]); });
    }
    take_blocks(buffers_.threads[0]);
    for (std::thread& other : others) other.join();
  }

  void start_row(std::size_t row, Thread& thread) const {
    thread.rows.clear();
    grid_.find_rows_in_reach(row, thread.rows);
    const std::size_t num_rows = thread.rows.size();
    reserve_elements(thread.first_cell, num_rows);
    reserve_elements(thread.last_cell, num_rows);
    for (std::size_t i = 0; i < num_rows; ++i) {
      thread.first_cell[i] = thread.last_cell[i] = grid_.row_begin(thread.rows[i]);
    }
  }

  /// Moves the window over a row to the cells in reach of a bin that only ever grows.
  void move_window(Thread& thread, std::size_t i, std::uint32_t bin) const {
    const std::uint32_t row_end = grid_.row_begin(thread.rows[i] + 1);
    std::uint32_t first = thread.first_cell[i];
    while (first < row_end && grid_.cell_bin(first) + Grid::kReach < bin) ++first;
    std::uint32_t last = std::max(first, thread.last_cell[i]);
    while (last < row_end && grid_.cell_bin(last) <= bin + Grid::kReach) ++last;
    thread.first_cell[i] = first;
    thread.last_cell[i] = last;
  }

  void find_core_points(std::size_t row, Thread& thread) {
    bool started = false;
    std::size_t own = 0;
    for (std::uint32_t cell = grid_.row_begin(row); cell < grid_.row_begin(row + 1); ++cell) {
      const std::uint32_t begin = grid_.cell_begin(cell);
      const std::uint32_t end = grid_.cell_begin(cell + 1);
      std::uint32_t core_end = begin;
      if (end - begin >= problem_.min_points) {
        std::fill(buffers_.point_state.begin() + begin, buffers_.point_state.begin() + end, kCore);
        core_end = end;
      } else {
        if (!started) {
          start_row(row, thread);
          started = true;
          while (thread.rows[own] != row) ++own;
        }
        for (std::size_t i = 0; i < thread.rows.size(); ++i) {
          move_window(thread, i, grid_.cell_bin(cell));
        }
        for (std::uint32_t point = begin; point < end; ++point) {
          buffers_.point_state[point] = state_of(point, own, thread);
        }
      }
      buffers_.cell_core_end[cell] = core_end;
    }
  }

  State state_of(std::uint32_t point, std::size_t own, Thread& thread) const {
    const NearTest<Scalar, D> test(points_, point, problem_.eps_squared);
    unsigned count = count_in_window(test, own, 0, thread);
    for (std::size_t i = 0; i < thread.rows.size() && count < problem_.min_points; ++i) {
      if (i != own) count += count_in_window(test, i, count, thread);
    }
    if (count >= problem_.min_points) return kCore;
    return count > 1 ? kNotCore : kAlone;
  }

  unsigned count_in_window(const NearTest<Scalar, D>& test, std::size_t i, unsigned count,
                           Thread& thread) const {
    return count_neighbors(test, points_, grid_.cell_begin(thread.first_cell[i]),
                           grid_.cell_begin(thread.last_cell[i]), problem_.min_points - count,
                           thread.num_comparisons);
  }

  /// Core points to the front of every cell, boxes around them; then cells with near core points
  /// are joined.
  void connect_cells() {
    const std::size_t num_cells = grid_.num_cells();
    for (std::uint32_t cell = 0; cell < num_cells; ++cell) {
      buffers_.cell_parent[cell] = cell;
      gather_core_points(cell);
    }
    if (num_threads_ == 1) {
      for (std::size_t row = 0; row < grid_.num_rows(); ++row) {
        connect_row(row, buffers_.threads[0], buffers_.cell_parent.data());
      }
      return;
    }
    for (auto& thread : buffers_.threads) {
      thread.parent.assign(buffers_.cell_parent.begin(),
                           buffers_.cell_parent.begin() + std::ptrdiff_t(num_cells));
    }
    for_each_row([this](std::size_t row, Thread& thread) {
      connect_row(row, thread, thread.parent.data());
    });
    std::uint32_t* const parent = buffers_.cell_parent.data();
    for (auto& thread : buffers_.threads) {
      for (std::uint32_t cell = 0; cell < num_cells; ++cell) {
        const std::uint32_t a = find_root(parent, cell);
        const std::uint32_t b = find_root(parent, thread.parent[cell]);
        if (a != b) join_roots(parent, a, b);
      }
    }
  }

  void gather_core_points(std::uint32_t cell) {
    const std::uint32_t begin = grid_.cell_begin(cell);
    const std::uint32_t end = grid_.cell_begin(cell + 1);
    std::uint32_t core_end = buffers_.cell_core_end[cell];
    for (std::uint32_t point = core_end; point < end; ++point) {
      if (buffers_.point_state[point] != kCore) continue;
      if (point != core_end) {
        grid_.swap_points(point, core_end);
        std::swap(buffers_.point_state[point], buffers_.point_state[core_end]);
      }
      ++core_end;
    }
    buffers_.cell_core_end[cell] = core_end;
    std::fill(buffers_.point_cell.begin() + begin, buffers_.point_cell.begin() + core_end, cell);
    if (core_end == begin) return;
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      const Scalar* const values = points_[axis];
      Scalar low = values[begin];
      Scalar high = values[begin];
      for (std::uint32_t point = begin + 1; point < core_end; ++point) {
        low = std::min(low, values[point]);
        high = std::max(high, values[point]);
      }
      buffers_.cell_low[axis][cell] = low;
      buffers_.cell_high[axis][cell] = high;
    }
  }

  std::uint32_t num_core_points(std::uint32_t cell) const noexcept {
    return buffers_.cell_core_end[cell] - grid_.cell_begin(cell);
  }
  bool has_core_points(std::uint32_t cell) const noexcept { return num_core_points(cell) > 0; }

  /// Joins the cells of a row with those after them in reach; each pair of cells meets once.
  void connect_row(std::size_t row, Thread& thread, std::uint32_t* parent) {
    bool started = false;
    for (std::uint32_t cell = grid_.row_begin(row); cell < grid_.row_begin(row + 1); ++cell) {
      if (!has_core_points(cell)) continue;
      if (!started) start_row(row, thread);
      started = true;
      for (std::size_t i = 0; i < thread.rows.size(); ++i) {
        if (thread.rows[i] < row) continue;
        move_window(thread, i, grid_.cell_bin(cell));
        const std::uint32_t first = std::max(thread.first_cell[i], cell + 1);
        const std::uint32_t last = thread.last_cell[i];
        if (first >= last) continue;
        const std::uint32_t num_points = grid_.cell_begin(last) - grid_.cell_begin(first);
        if (num_core_points(cell) <= kFewPoints && num_points <= kFewPoints * (last - first)) {
          connect_points(cell, first, last, thread, parent);
        } else {
          connect_pairs_of_cells(cell, first, last, thread, parent);
        }
      }
    }
  }

  /// Point by point, which is faster where cells hold few.
  void connect_points(std::uint32_t cell, std::uint32_t first, std::uint32_t last, Thread& thread,
                      std::uint32_t* parent) const {
    std::uint32_t root = find_root(parent, cell);
    for (std::uint32_t point = grid_.cell_begin(cell); point < buffers_.cell_core_end[cell];
         ++point) {
      const NearTest<Scalar, D> test(points_, point, problem_.eps_squared);
      visit_neighbors(test, points_, grid_.cell_begin(first), grid_.cell_begin(last),
                      thread.num_comparisons, [&](std::size_t other) {
                        if (buffers_.point_state[other] != kCore) return true;
                        const std::uint32_t other_root =
                            find_root(parent, buffers_.point_cell[other]);
                        if (other_root != root) root = join_roots(parent, root, other_root);
                        return true;
                      });
    }
  }

  void connect_pairs_of_cells(std::uint32_t cell, std::uint32_t first, std::uint32_t last,
                              Thread& thread, std::uint32_t* parent) const {
    std::uint32_t root = find_root(parent, cell);
    for (std::uint32_t other = first; other < last; ++other) {
      if (!has_core_points(other)) continue;
      const std::uint32_t other_root = find_root(parent, other);
      if (other_root != root && are_connected(cell, other, thread.num_comparisons)) {
        root = join_roots(parent, root, other_root);
      }
    }
  }

  /// Whether a core point of one cell is near a core point of the other.
  bool are_connected(std::uint32_t a, std::uint32_t b, std::uint64_t& num_comparisons) const {
    // A distance between boxes is rounded like one between points and never exceeds it.
    Scalar gap_squared = 0;
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      const Scalar gap =
          std::max({Scalar(0), buffers_.cell_low[axis][b] - buffers_.cell_high[axis][a],
                    buffers_.cell_low[axis][a] - buffers_.cell_high[axis][b]});
      gap_squared += gap * gap;
    }
    if (gap_squared > problem_.eps_squared) return false;
    if (num_core_points(a) > num_core_points(b)) std::swap(a, b);
    const std::uint32_t end = buffers_.cell_core_end[a];
    for (std::uint32_t point = grid_.cell_begin(a); point < end; ++point) {
      if (!is_near_box(point, b)) continue;
      const NearTest<Scalar, D> test(points_, point, problem_.eps_squared);
      if (count_neighbors(test, points_, grid_.cell_begin(b), buffers_.cell_core_end[b], 1,
                          num_comparisons) > 0) {
        return true;
      }
    }
    return false;
  }

  bool is_near_box(std::uint32_t point, std::uint32_t cell) const noexcept {
    Scalar gap_squared = 0;
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      const Scalar value = points_[axis][point];
      const Scalar gap = std::max({Scalar(0), buffers_.cell_low[axis][cell] - value,
                                   value - buffers_.cell_high[axis][cell]});
      gap_squared += gap * gap;
    }
    return gap_squared <= problem_.eps_squared;
  }

  /// Cell whose cluster each point of a row joins that is not core.
  void find_clusters(std::size_t row, Thread& thread) {
    bool started = false;
    for (std::uint32_t cell = grid_.row_begin(row); cell < grid_.row_begin(row + 1); ++cell) {
      const std::uint32_t core_end = buffers_.cell_core_end[cell];
      bool moved = false;
      for (std::uint32_t point = core_end; point < grid_.cell_begin(cell + 1); ++point) {
        if (buffers_.point_state[point] == kAlone) {
          buffers_.point_cell[point] = kNoCell;
          continue;
        }
        if (!started) start_row(row, thread);
        started = true;
        for (std::size_t i = 0; i < thread.rows.size() && !moved; ++i) {
          move_window(thread, i, grid_.cell_bin(cell));
        }
        moved = true;
        buffers_.point_cell[point] = nearest_core_cell(point, thread);
      }
    }
  }

  std::uint32_t nearest_core_cell(std::uint32_t point, Thread& thread) const {
    const NearTest<Scalar, D> test(points_, point, problem_.eps_squared);
    NearestCore<Scalar, D> nearest;
    std::size_t nearest_window = 0;
    for (std::size_t i = 0; i < thread.rows.size(); ++i) {
      visit_neighbors(test, points_, grid_.cell_begin(thread.first_cell[i]),
                      grid_.cell_begin(thread.last_cell[i]), thread.num_comparisons,
                      [&](std::size_t other) {
                        if (buffers_.point_state[other] != kCore) return true;
                        const std::size_t before = nearest.index();
                        const bool found = nearest.found();
                        nearest.offer(points_, other, test.squared_distance(points_, other));
                        if (!found || nearest.index() != before) nearest_window = i;
                        return true;
                      });
    }
    if (!nearest.found()) return kNoCell;
    std::uint32_t cell = thread.first_cell[nearest_window];
    while (grid_.cell_begin(cell + 1) <= nearest.index()) ++cell;
    return cell;
  }

  /// Clusters are numbered by the first core point of each in the input.
  void write_labels() {
    const std::size_t n = problem_.num_points;
    std::uint32_t* const parent = buffers_.cell_parent.data();
    for (std::size_t place = 0; place < n; ++place) {
      const std::uint32_t index = problem_.input[grid_.point_at(place)];
      const std::uint32_t cell = buffers_.point_cell[place];
      if (cell == kNoCell) continue;
      problem_.labels[index] = std::int32_t(find_root(parent, cell));
      problem_.kinds[index] =
          buffers_.point_state[place] == kCore ? PointKind::kCore : PointKind::kBorder;
    }
    reserve_elements(buffers_.cluster_of, grid_.num_cells());
    std::fill_n(buffers_.cluster_of.begin(), grid_.num_cells(), kNoiseLabel);
    for (std::size_t i = 0; i < n; ++i) {
      if (!problem_.is_core(i)) continue;
      std::int32_t& cluster = buffers_.cluster_of[std::size_t(problem_.labels[problem_.input[i]])];
      if (cluster == kNoiseLabel) cluster = problem_.num_clusters++;
    }
    for (std::size_t i = 0; i < n; ++i) {
      std::int32_t& label = problem_.labels[problem_.input[i]];
      if (label != kNoiseLabel) label = buffers_.cluster_of[std::size_t(label)];
    }
  }

  DbscanProblem<Scalar, D>& problem_;
  DbscanGridBuffers<Scalar>& buffers_;
  Grid grid_;
  PointAxes<Scalar, D> points_;
  std::size_t num_threads_;
};

}  // namespace srslam::detail
