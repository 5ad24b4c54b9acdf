#pragma once

#include <cstddef>
#include <cstdint>

#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Words of a set with a bit for each point.
constexpr std::size_t words_of(std::size_t num_points) noexcept { return (num_points + 63) / 64; }

inline unsigned count_of_bits(std::uint64_t bits) noexcept {
  bits -= (bits >> 1U) & 0x5555555555555555U;
  bits = (bits & 0x3333333333333333U) + ((bits >> 2U) & 0x3333333333333333U);
  bits = (bits + (bits >> 4U)) & 0x0f0f0f0f0f0f0f0fU;
  return unsigned((bits * 0x0101010101010101U) >> 56U);
}

/// Index of the lowest bit set, of a word that is not 0.
inline unsigned lowest_bit(std::uint64_t bits) noexcept {
#if defined(__GNUC__)
  return unsigned(__builtin_ctzll(bits));
#else
  return count_of_bits((bits & (~bits + 1U)) - 1U);
#endif
}

inline bool has_bit(const std::uint64_t* words, std::size_t index) noexcept {
  return (words[index / 64] >> (index % 64) & 1U) != 0;
}

/// Neighbours of a point, a bit each: those of the words [first, end) of a set of all points. The
/// others have none.
struct NeighborRow {
  const std::uint64_t* words = nullptr;
  std::size_t first = 0;
  std::size_t end = 0;
};

template <typename Scalar, int D>
void join_nearest_core(DbscanProblem<Scalar, D>& problem, std::size_t point,
                       const NearestCore<Scalar, D>& nearest) {
  if (!nearest.found()) return;
  problem.kinds[problem.input[point]] = PointKind::kBorder;
  problem.labels[problem.input[point]] = problem.labels[problem.input[nearest.index()]];
}

/// Clusters of points whose neighbours are written down: `row_of(point)` is a NeighborRow, `core`
/// the set of core points, and `point_at(k)` the k-th point of the input, which numbers the
/// clusters. At most 64 kMaxWords points. O(words of all rows).
template <std::size_t kMaxWords, typename Scalar, int D, typename RowOf, typename PointAt>
void cluster_neighbor_rows(DbscanProblem<Scalar, D>& problem, const std::uint64_t* core,
                           const RowOf& row_of, const PointAt& point_at) {
  const std::size_t n = problem.num_points;
  const std::size_t num_words = words_of(n);
  std::uint64_t unreached[kMaxWords];  // core points without a cluster
  std::uint64_t pending[kMaxWords] = {};
  for (std::size_t word = 0; word < num_words; ++word) unreached[word] = core[word];
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t seed = point_at(k);
    if (!has_bit(unreached, seed)) continue;
    const std::int32_t cluster = problem.num_clusters++;
    std::size_t word = seed / 64;
    pending[word] = std::uint64_t(1) << (seed % 64);
    unreached[word] ^= pending[word];
    while (word < num_words) {
      if (pending[word] == 0) {
        ++word;
        continue;
      }
      const std::size_t point = word * 64 + lowest_bit(pending[word]);
      pending[word] &= pending[word] - 1U;
      problem.labels[problem.input[point]] = cluster;
      const NeighborRow row = row_of(point);
      for (std::size_t w = row.end; w-- > row.first;) {
        const std::uint64_t reached = row.words[w - row.first] & unreached[w];
        if (reached == 0) continue;
        unreached[w] ^= reached;
        pending[w] |= reached;
        if (w < word) word = w;
      }
    }
  }

  for (std::size_t word = 0; word < num_words; ++word) {
    std::uint64_t others = ~core[word];
    if (n - word * 64 < 64) others &= (std::uint64_t(1) << (n - word * 64)) - 1U;
    for (; others != 0; others &= others - 1U) {
      const std::size_t point = word * 64 + lowest_bit(others);
      const NearTest<Scalar, D> test = problem.near(point);
      NearestCore<Scalar, D> nearest;
      const NeighborRow row = row_of(point);
      for (std::size_t w = row.first; w < row.end; ++w) {
        for (std::uint64_t bits = row.words[w - row.first] & core[w]; bits != 0;
             bits &= bits - 1U) {
          const std::size_t other = w * 64 + lowest_bit(bits);
          nearest.offer(problem.points, other, test.squared_distance(problem.points, other));
        }
      }
      join_nearest_core(problem, point, nearest);
    }
  }
}

}  // namespace srslam::detail
