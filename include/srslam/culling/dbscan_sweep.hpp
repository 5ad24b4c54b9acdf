#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "srslam/culling/dbscan_bits.hpp"
#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Up to so many points can be swept: with a bit for each pair that is 512 bytes a point.
constexpr std::size_t kMaxSweepPoints = 4096;

/// Sort and sweep: points are sorted along the axis on which they are spread widest and compared
/// with those that are near on it. Which of them are near is written down, a bit each, in tiles of
/// 16 by 16 points; a tile off the diagonal is computed once and turned over for the other side.
/// Nothing in it depends on how the points lie within the reach of each other, so that there is
/// little for a processor to mispredict. At most kMaxSweepPoints points. O(n·w) time and bits, w
/// points being within about eps of a point along that axis.
template <typename Scalar, int D>
class SweepClustering {
 public:
  SweepClustering(DbscanProblem<Scalar, D>& problem, DbscanSweepBuffers<Scalar>& buffers)
      : problem_(problem), buffers_(buffers), sorted_(problem) {
    find_box();
  }

  void run() {
    sort_points();
    lay_out_rows();
    cluster();
  }

  /// The same where it is expected to be faster than the grid; otherwise does nothing and returns
  /// false.
  bool run_if_sparse() {
    if (is_dense()) return false;
    sort_points();
    lay_out_rows();
    if (num_pairs_ > kMaxPairsPerPoint * problem_.num_points) return false;
    cluster();
    return true;
  }

 private:
  static constexpr std::size_t kNumAxes = std::size_t(D);
  static constexpr std::size_t kTile = 16;  ///< points; four tiles are a word of bits
  /// Bins are wider than eps, or half of it, by so much that points within eps of each other are
  /// never more than `reach_` bins apart, however kMaxSweepPoints bins are rounded in floats.
  static constexpr Scalar kSlack = Scalar(1.004);

  // Where the grid, which does not look at the distances within a cell, is faster (docs/dbscan.md):
  static constexpr double kMaxPointsPerCube = 4.0;  ///< of edge eps/2, on average over the box
  static constexpr std::size_t kMinDensePoints = 64 * kNumAxes;
  static constexpr std::uint64_t kMaxPairsPerPoint = 256 * (kNumAxes < 3 ? 1 : kNumAxes - 1);

  using TileRow = typename DbscanSweepBuffers<Scalar>::TileRow;

  /// The box of the points and its longest side.
  void find_box() {
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      const auto [low, high] = range_of(problem_.points[axis]);
      range_[axis] = high - low;
      if (!std::isfinite(range_[axis])) continue;  // too far apart for the type
      if (!has_widest_ || range_[axis] > range_[widest_]) {
        widest_ = axis;
        widest_low_ = low;
        has_widest_ = true;
      }
    }
  }

  bool is_dense() const noexcept {
    const double eps = double(problem_.eps);
    double num_cells = 1.0;
    double diagonal_squared = 0.0;
    for (const Scalar range : range_) {
      const double in_eps = double(range) / eps;
      num_cells *= std::max(1.0, in_eps);
      diagonal_squared += in_eps * in_eps;
    }
    if (diagonal_squared <= 1.0) return true;  // one cell
    const double num_cubes = num_cells * double(1U << kNumAxes);
    return problem_.num_points >= kMinDensePoints &&
           double(problem_.num_points) > kMaxPointsPerCube * num_cubes;
  }

  /// By counting, into bins of half of eps or, where these were more than the points, wider ones.
  void sort_points() {
    const std::size_t n = problem_.num_points;
    if (has_widest_) {
      const Scalar eps = problem_.eps * kSlack;
      const Scalar width = std::max(eps / 2, range_[widest_] / Scalar(n));
      per_width_ = 1 / width;
      reach_ = width >= eps ? 1 : 2;
      num_bins_ = std::size_t(range_[widest_] / width) + 2;
    }
    reserve_elements(buffers_.bin, n);
    reserve_elements(buffers_.bin_end, n + 4);
    reserve_elements(buffers_.place, n);
    reserve_elements(buffers_.input, n);
    std::uint32_t* const bins = buffers_.bin.data();
    std::uint32_t* const bin_end = buffers_.bin_end.data();
    std::fill_n(bin_end, num_bins_, 0U);
    const Scalar* const along = problem_.points[widest_];
    for (std::size_t i = 0; i < n; ++i) bins[i] = std::uint32_t(bin_of(along[i]));
    for (std::size_t i = 0; i < n; ++i) ++bin_end[bins[i]];
    std::uint32_t end = 0;
    for (std::size_t bin = 0; bin < num_bins_; ++bin) {
      const std::uint32_t begin = end;
      end += bin_end[bin];
      bin_end[bin] = begin;  // and moves on to the end of the bin as points are placed
    }
    std::uint32_t* const place = buffers_.place.data();
    for (std::size_t i = 0; i < n; ++i) {
      place[i] = bin_end[bins[i]]++;
      buffers_.input[place[i]] = problem_.input[i];
    }
    for (std::size_t axis = 0; axis < kNumAxes; ++axis) {
      reserve_elements(buffers_.sorted[axis], n + kTile);
      const Scalar* const values = problem_.points[axis];
      Scalar* const sorted = buffers_.sorted[axis].data();
      for (std::size_t i = 0; i < n; ++i) sorted[place[i]] = values[i];
      // The last tile is filled up with neighbours of nothing.
      std::fill_n(sorted + n, kTile, std::numeric_limits<Scalar>::infinity());
    }
    sorted_.points = axes_of<D>(buffers_.sorted);
    sorted_.input = buffers_.input.data();
  }

  /// Never falls as the coordinate grows.
  std::int32_t bin_of(Scalar along) const noexcept {
    return has_widest_ ? std::int32_t((along - widest_low_) * per_width_) : 0;
  }
  std::size_t bin_at(std::size_t place) const noexcept {
    return std::size_t(bin_of(sorted_.points[widest_][place]));
  }

  /// Least and greatest of the values, four at a time.
  std::array<Scalar, 2> range_of(const Scalar* values) const noexcept {
    const std::size_t n = problem_.num_points;
    std::array<Scalar, 4> low{};
    std::array<Scalar, 4> high{};
    low.fill(values[0]);
    high.fill(values[0]);
    std::size_t i = 0;
    for (; i + 4 <= n; i += 4) {
      for (std::size_t lane = 0; lane < 4; ++lane) {
        low[lane] = values[i + lane] < low[lane] ? values[i + lane] : low[lane];
        high[lane] = values[i + lane] > high[lane] ? values[i + lane] : high[lane];
      }
    }
    for (; i < n; ++i) {
      low[0] = std::min(low[0], values[i]);
      high[0] = std::max(high[0], values[i]);
    }
    return {std::min(std::min(low[0], low[1]), std::min(low[2], low[3])),
            std::max(std::max(high[0], high[1]), std::max(high[2], high[3]))};
  }

  /// Which tiles each tile can have neighbours in, and where their bits go.
  void lay_out_rows() {
    const std::size_t n = problem_.num_points;
    num_tiles_ = (n + kTile - 1) / kTile;
    reserve_elements(buffers_.tile_rows, num_tiles_);
    num_words_ = 0;
    num_pairs_ = 0;
    for (std::size_t tile = 0; tile < num_tiles_; ++tile) {
      const std::size_t begin = tile * kTile;
      const std::size_t end = std::min(begin + kTile, n);
      const std::size_t low = bin_at(begin);
      const std::size_t high = std::min(bin_at(end - 1) + reach_, num_bins_ - 1);
      TileRow& row = buffers_.tile_rows[tile];
      row.first_tile =
          low <= reach_ ? 0U : std::uint32_t(buffers_.bin_end[low - reach_ - 1] / kTile);
      row.end_tile = std::uint32_t((buffers_.bin_end[high] + kTile - 1) / kTile);
      row.bits = std::uint32_t(num_words_);
      num_words_ += kTile * words_in(row);
      num_pairs_ += (end - begin) * (std::min(n, row.end_tile * kTile) - begin);
    }
  }

  void cluster() {
    // Room for every pair, whatever these points need: a stream of frames allocates at its start.
    reserve_elements(buffers_.neighbor_bits, num_tiles_ * kTile * words_of(problem_.num_points));
    reserve_elements(buffers_.tiles, num_tiles_);
    std::fill_n(buffers_.neighbor_bits.begin(), num_words_, std::uint64_t(0));
    compare_tiles();
    std::uint64_t core[kMaxSweepPoints / 64];
    find_core_points(core);
    cluster_neighbor_rows<kMaxSweepPoints / 64>(
        sorted_, core, [this](std::size_t point) { return row_of(point); },
        [this](std::size_t k) { return buffers_.place[k]; });
    problem_.num_comparisons += num_pairs_;
    problem_.num_clusters = sorted_.num_clusters;
  }

  static std::size_t words_in(const TileRow& row) noexcept {
    return (row.end_tile + 3U) / 4U - row.first_tile / 4U;
  }

  NeighborRow row_of(std::size_t point) const noexcept {
    const TileRow& row = buffers_.tile_rows[point / kTile];
    const std::size_t num_words = words_in(row);
    const std::size_t first = row.first_tile / 4U;
    return {buffers_.neighbor_bits.data() + row.bits + point % kTile * num_words, first,
            first + num_words};
  }

  void compare_tiles() {
    const std::size_t n = problem_.num_points;
    for (std::size_t tile = 0; tile < num_tiles_; ++tile) {
      const TileRow row = buffers_.tile_rows[tile];
      const std::size_t num_words = words_in(row);
      const std::size_t num_points = std::min(kTile, n - tile * kTile);
      std::uint64_t* const bits = buffers_.neighbor_bits.data() + row.bits;
      for (std::size_t i = 0; i < num_points; ++i) {
        const NearTest<Scalar, D> test = sorted_.near(tile * kTile + i);
        for (std::size_t other = tile; other < row.end_tile; ++other) {
          const unsigned near = test.neighbors_of_16(sorted_.points, other * kTile);
          buffers_.tiles[other][i] = std::uint16_t(near);
          bits[i * num_words + other / 4 - row.first_tile / 4U] |= std::uint64_t(near)
                                                                   << (other % 4 * kTile);
        }
      }
      for (std::size_t other = tile + 1; other < row.end_tile; ++other) {
        write_transposed(tile, other);
      }
    }
  }

  /// Bits of the points of `other` for those of `tile`.
  void write_transposed(std::size_t tile, std::size_t other) {
    const TileRow& row = buffers_.tile_rows[other];
    const std::size_t num_words = words_in(row);
    std::uint64_t* const bits =
        buffers_.neighbor_bits.data() + row.bits + (tile / 4 - row.first_tile / 4U);
    const std::array<std::uint16_t, kTile> turned = transposed(buffers_.tiles[other]);
    for (std::size_t i = 0; i < kTile; ++i) {
      bits[i * num_words] |= std::uint64_t(turned[i]) << (tile % 4 * kTile);
    }
  }

  /// The set of core points. Without a branch on what is found: who is core cannot be predicted.
  void find_core_points(std::uint64_t* core) {
    const std::size_t n = problem_.num_points;
    std::fill_n(core, words_of(n), std::uint64_t(0));
    for (std::size_t tile = 0; tile < num_tiles_; ++tile) {
      const TileRow row = buffers_.tile_rows[tile];
      const std::size_t num_words = words_in(row);
      const std::uint64_t* const bits = buffers_.neighbor_bits.data() + row.bits;
      std::array<unsigned, kTile> count{};
      for (std::size_t w = 0; w < num_words; ++w) {
        for (std::size_t i = 0; i < kTile; ++i) count[i] += count_of_bits(bits[i * num_words + w]);
      }
      const std::size_t begin = tile * kTile;
      const std::size_t num_points = std::min(kTile, n - begin);
      std::uint64_t are_core = 0;
      for (std::size_t i = 0; i < num_points; ++i) {
        const bool is_core = count[i] >= problem_.min_points;
        are_core |= std::uint64_t(is_core) << i;
        problem_.kinds[sorted_.input[begin + i]] = is_core ? PointKind::kCore : PointKind::kNoise;
      }
      core[begin / 64] |= are_core << (begin % 64);
    }
  }

  DbscanProblem<Scalar, D>& problem_;
  DbscanSweepBuffers<Scalar>& buffers_;
  DbscanProblem<Scalar, D> sorted_;  ///< the same points in their order along the axis
  std::array<Scalar, kNumAxes> range_{};
  bool has_widest_ = false;
  std::size_t widest_ = 0;
  Scalar widest_low_ = 0;
  Scalar per_width_ = 0;
  std::size_t reach_ = 1;  ///< bins around one that may hold neighbours
  std::size_t num_bins_ = 1;
  std::size_t num_tiles_ = 0;
  std::size_t num_words_ = 0;
  std::uint64_t num_pairs_ = 0;  ///< that are compared
};

}  // namespace srslam::detail
