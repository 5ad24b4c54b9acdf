#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Width of a bin in units of eps. A little more than 1, so that points within eps of each other
/// lie in the same bin or in neighbouring ones however their coordinates are rounded. Narrower
/// bins, whose points would all be neighbours of each other, were slower at every size
/// (docs/dbscan.md): there are too many of them around a point. Bins that hold many points are
/// divided instead.
constexpr double kBinWidthInEps = 1.0 + 1e-5;

/// An axis is divided into bins only where those of the longer axes still hold so many points on
/// average. With fewer the rows around a point are many and hold next to nothing: a walk over them
/// takes longer than the distances that it spares (docs/dbscan.md).
constexpr double kMinPointsPerBin = 20.0;

/// Points sorted into rows of cells. Rows are the leaves of a tree with a level for every axis but
/// that of the rows, so that the rows around one are found in time that does not depend on how far
/// the points are spread; nothing is kept for empty space.
template <typename Scalar, int D>
class DbscanGrid {
 public:
  using Axes = PointAxes<Scalar, D>;
  static constexpr std::size_t kNumAxes = std::size_t(D);
  static constexpr std::size_t kNumLevels = kNumAxes - 1;
  static constexpr std::uint32_t kReach = 1;  ///< bins around one that may hold neighbours

  DbscanGrid(const DbscanProblem<Scalar, D>& problem, DbscanGridBuffers<Scalar>& buffers)
      : problem_(problem), buffers_(buffers), num_points_(problem.num_points) {
    choose_bins();
    sort_points();
    make_cells();
  }

  std::size_t num_cells() const noexcept { return num_cells_; }
  std::size_t num_rows() const noexcept { return num_rows_; }
  /// Coordinates of the points in the order of the cells.
  Axes points() const noexcept { return axes_of<D>(buffers_.sorted); }
  std::uint32_t cell_begin(std::size_t cell) const noexcept { return buffers_.cell_begin[cell]; }
  std::uint32_t cell_bin(std::size_t cell) const noexcept { return buffers_.cell_bin[cell]; }
  std::uint32_t row_begin(std::size_t row) const noexcept { return buffers_.row_begin[row]; }
  /// Valid point that stands at a place of the order.
  std::uint32_t point_at(std::size_t place) const noexcept { return buffers_.order[place]; }

  void swap_points(std::size_t a, std::size_t b) noexcept {
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      std::swap(buffers_.sorted[axis][a], buffers_.sorted[axis][b]);
    }
    std::swap(buffers_.order[a], buffers_.order[b]);
  }

  /// Rows in reach of `row`, itself included, in ascending order.
  template <typename Rows>
  void find_rows_in_reach(std::size_t row, Rows& rows) const {
    if constexpr (kNumLevels == 0) {
      rows.push_back(0);
    } else {
      std::array<std::uint32_t, kNumLevels> bins{};
      std::size_t node = row;
      for (std::size_t level = kNumLevels; level-- > 0;) {
        bins[level] = buffers_.level_bin[level][node];
        if (level == 0) break;
        // The parent's children start at or before this node.
        const auto& begins = buffers_.level_begin[level - 1];
        node = std::size_t(std::upper_bound(begins.begin(),
                                            begins.begin() + std::ptrdiff_t(num_nodes_[level - 1]),
                                            std::uint32_t(node)) -
                           begins.begin()) -
               1;
      }
      descend(0, 0, num_nodes_[0], bins, rows);
    }
  }

 private:
  template <typename Rows>
  void descend(std::size_t level, std::size_t begin, std::size_t end,
               const std::array<std::uint32_t, kNumLevels>& bins, Rows& rows) const {
    const std::uint32_t* const level_bins = buffers_.level_bin[level].data();
    const std::uint32_t low = bins[level] < kReach ? 0 : bins[level] - kReach;
    const std::uint32_t high = bins[level] + kReach;
    std::size_t node =
        std::size_t(std::lower_bound(level_bins + begin, level_bins + end, low) - level_bins);
    for (; node < end && level_bins[node] <= high; ++node) {
      if (level + 1 == kNumLevels) {
        rows.push_back(std::uint32_t(node));
      } else {
        descend(level + 1, buffers_.level_begin[level][node], buffers_.level_begin[level][node + 1],
                bins, rows);
      }
    }
  }

  /// A table of bins that costs no more than the points themselves.
  std::size_t max_bins() const noexcept { return 2 * num_points_ + 2048; }

  void choose_bins() {
    const double width = double(problem_.eps) * kBinWidthInEps;
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      reserve_elements(buffers_.bins[axis], num_points_);
      const Scalar* const values = problem_.points[axis];
      Scalar low = values[0];
      Scalar high = values[0];
      for (std::size_t i = 1; i < num_points_; ++i) {
        low = std::min(low, values[i]);
        high = std::max(high, values[i]);
      }
      const double spread = (double(high) - double(low)) / width;
      std::uint32_t* const bins = buffers_.bins[axis].data();
      if (spread < double(max_bins())) {
        const double per_width = 1.0 / width;
        for (std::size_t i = 0; i < num_points_; ++i) {
          bins[i] = std::uint32_t(std::int32_t((double(values[i]) - double(low)) * per_width));
        }
        num_bins_[axis] = std::uint32_t(spread) + 2;
      } else {
        num_bins_[axis] = bin_far_spread(values, width, bins);
      }
    }
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) axis_of_digit_[axis] = axis;
    // The longest axis lies along the rows: that makes the fewest of them.
    std::sort(axis_of_digit_.begin(), axis_of_digit_.end(), [&](std::size_t a, std::size_t b) {
      return num_bins_[a] != num_bins_[b] ? num_bins_[a] > num_bins_[b] : a < b;
    });
    double points_per_bin = double(num_points_);
    for (std::size_t digit = 0; digit < kNumAxes; ++digit) {
      const std::size_t axis = axis_of_digit_[digit];
      if (digit > 0 && points_per_bin < kMinPointsPerBin) {
        std::fill_n(buffers_.bins[axis].begin(), num_points_, 0U);
        num_bins_[axis] = 1;
      }
      // The last bin is empty but for what rounding puts there.
      points_per_bin /= std::max(1.0, double(num_bins_[axis]) - 1.0);
    }
  }

  /// Bins for points with wide gaps, or with coordinates so large that they have few digits left
  /// for eps: from point to point in ascending order, gaps shortened. Returns the number of bins.
  std::uint32_t bin_far_spread(const Scalar* values, double width, std::uint32_t* bins) {
    auto& sorted = buffers_.axis_values;
    sorted.assign(values, values + num_points_);
    std::sort(sorted.begin(), sorted.end());
    auto& order = buffers_.order;  // not in use yet: the bin of each sorted value
    reserve_elements(order, num_points_);
    double bin_low = double(sorted[0]);
    std::uint32_t bin = 0;
    for (std::size_t i = 0; i < num_points_; ++i) {
      const double value = double(sorted[i]);
      if (value - bin_low >= width) {
        const bool apart = value - double(sorted[i - 1]) > double(problem_.eps) * 1.001;
        bin += apart ? kReach + 1 : 1;
        bin_low = value;
      }
      order[i] = bin;
    }
    for (std::size_t i = 0; i < num_points_; ++i) {
      const auto place = std::lower_bound(sorted.begin(), sorted.end(), values[i]);
      bins[i] = order[std::size_t(place - sorted.begin())];
    }
    return bin + 1;
  }

  /// By counting, from the axis along the rows to that of the first level; neighbouring axes that
  /// have few bins together are one digit.
  void sort_points() {
    auto& order = buffers_.order;
    auto& before = buffers_.order_before;
    reserve_elements(order, num_points_);
    reserve_elements(before, num_points_);
    bool first = true;
    for (std::size_t digit = 0; digit < kNumAxes;) {
      std::size_t end = digit + 1;
      std::size_t num_values = num_bins_[axis_of_digit_[digit]];
      while (end < kNumAxes && num_values * num_bins_[axis_of_digit_[end]] <= max_bins()) {
        num_values *= num_bins_[axis_of_digit_[end++]];
      }
      reserve_elements(buffers_.digit_begin, num_values + 1);
      std::fill_n(buffers_.digit_begin.begin(), num_values + 1, 0U);
      for (std::size_t i = 0; i < num_points_; ++i) {
        ++buffers_.digit_begin[digit_value(i, digit, end) + 1];
      }
      for (std::size_t value = 1; value <= num_values; ++value) {
        buffers_.digit_begin[value] += buffers_.digit_begin[value - 1];
      }
      for (std::size_t place = 0; place < num_points_; ++place) {
        const std::uint32_t point = first ? std::uint32_t(place) : order[place];
        before[buffers_.digit_begin[digit_value(point, digit, end)]++] = point;
      }
      order.swap(before);
      first = false;
      digit = end;
    }
  }

  std::size_t digit_value(std::size_t point, std::size_t begin, std::size_t end) const noexcept {
    std::size_t value = 0;
    for (std::size_t digit = end; digit-- > begin;) {
      const std::size_t axis = axis_of_digit_[digit];
      value = value * num_bins_[axis] + buffers_.bins[axis][point];
    }
    return value;
  }

  void make_cells() {
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      reserve_elements(buffers_.sorted[axis], num_points_ + kLanes);
    }
    for (auto* cells : {&buffers_.cell_begin, &buffers_.cell_bin}) {
      reserve_elements(*cells, num_points_ + 1);
    }
    reserve_elements(buffers_.row_begin, num_points_ + 1);
    for (std::size_t level = 0; level < kNumLevels; ++level) {
      reserve_elements(buffers_.level_bin[level], num_points_);
      reserve_elements(buffers_.level_begin[level], num_points_ + 1);
    }
    num_nodes_.fill(0);

    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      Scalar* const sorted = buffers_.sorted[axis].data();
      for (std::size_t i = 0; i < num_points_; ++i) {
        sorted[i] = problem_.points[axis][buffers_.order[i]];
      }
    }
    std::array<std::uint32_t, kNumAxes> bins{};  // along the row first
    std::size_t raw_cell_begin = 0;
    for (std::size_t i = 0; i < num_points_; ++i) {
      std::size_t num_changed = i == 0 ? kNumAxes : 0;  // digits from the lowest on
      for (std::size_t digit = 0; digit < kNumAxes; ++digit) {
        const std::uint32_t bin = buffers_.bins[axis_of_digit_[digit]][buffers_.order[i]];
        if (i == 0 || bin != bins[digit]) num_changed = std::max(num_changed, digit + 1);
      }
      if (num_changed == 0) continue;
      if (i > 0) add_cells(raw_cell_begin, i, bins[0]);
      raw_cell_begin = i;
      for (std::size_t digit = 0; digit < kNumAxes; ++digit) {
        bins[digit] = buffers_.bins[axis_of_digit_[digit]][buffers_.order[i]];
      }
      if (num_changed == 1) continue;
      // A level for each axis from the highest on; below the first that changed all are new.
      for (std::size_t level = kNumAxes - num_changed; level < kNumLevels; ++level) {
        const std::size_t node = num_nodes_[level]++;
        buffers_.level_bin[level][node] = bins[kNumLevels - level];
        if (level + 1 < kNumLevels) {
          buffers_.level_begin[level][node] = std::uint32_t(num_nodes_[level + 1]);
        }
      }
      buffers_.row_begin[num_rows_++] = std::uint32_t(num_cells_);
    }
    add_cells(raw_cell_begin, num_points_, bins[0]);
    if (num_rows_ == 0) buffers_.row_begin[num_rows_++] = 0;  // one dimension: the only row
    buffers_.row_begin[num_rows_] = std::uint32_t(num_cells_);
    buffers_.cell_begin[num_cells_] = std::uint32_t(num_points_);
    for (std::size_t level = 0; level + 1 < kNumLevels; ++level) {
      buffers_.level_begin[level][num_nodes_[level]] = std::uint32_t(num_nodes_[level + 1]);
    }
  }

  /// Points [begin, end) of one bin become a cell or, if they are not all near each other, several.
  void add_cells(std::size_t begin, std::size_t end, std::uint32_t bin) {
    if (end - begin > 1) {
      std::array<Scalar, kNumAxes> low{};
      std::array<Scalar, kNumAxes> high{};
      find_box(begin, end, low, high);
      Scalar diagonal_squared = 0;
      std::size_t widest = 0;
      for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
        const Scalar width = high[axis] - low[axis];
        diagonal_squared += width * width;
        if (width > high[widest] - low[widest]) widest = axis;
      }
      if (diagonal_squared > problem_.eps_squared) {
        const std::size_t middle = divide(begin, end, widest, low[widest], high[widest]);
        add_cells(begin, middle, bin);
        add_cells(middle, end, bin);
        return;
      }
    }
    buffers_.cell_begin[num_cells_] = std::uint32_t(begin);
    buffers_.cell_bin[num_cells_] = bin;
    ++num_cells_;
  }

  void find_box(std::size_t begin, std::size_t end, std::array<Scalar, kNumAxes>& low,
                std::array<Scalar, kNumAxes>& high) const noexcept {
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      const Scalar* const values = buffers_.sorted[axis].data();
      low[axis] = high[axis] = values[begin];
      for (std::size_t i = begin + 1; i < end; ++i) {
        low[axis] = std::min(low[axis], values[i]);
        high[axis] = std::max(high[axis], values[i]);
      }
    }
  }

  /// Points in the lower half of an axis first; returns where the others start. Both have some.
  std::size_t divide(std::size_t begin, std::size_t end, std::size_t axis, Scalar low,
                     Scalar high) noexcept {
    Scalar middle = low / 2 + high / 2;
    if (!(middle >= low && middle < high)) middle = low;
    const auto& values = buffers_.sorted[axis];
    std::size_t first = begin;
    std::size_t last = end;
    while (first < last) {
      if (values[first] <= middle) {
        ++first;
      } else {
        swap_points(first, --last);
      }
    }
    return first;
  }

  const DbscanProblem<Scalar, D>& problem_;
  DbscanGridBuffers<Scalar>& buffers_;
  std::size_t num_points_;
  std::size_t num_cells_ = 0;
  std::size_t num_rows_ = 0;
  std::array<std::uint32_t, kNumAxes> num_bins_{};
  std::array<std::size_t, kNumAxes> axis_of_digit_{};  ///< axis 0 of it lies along the rows
  std::array<std::size_t, kNumLevels == 0 ? 1 : kNumLevels> num_nodes_{};
};

}  // namespace srslam::detail
