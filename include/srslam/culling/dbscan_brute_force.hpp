#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Up to so many points have all their neighbours written down, a bit each.
constexpr std::size_t kMaxPointsAsBits = 512;

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

template <typename Visit>
void visit_bits(const std::uint64_t* words, std::size_t num_words, const Visit& visit) {
  for (std::size_t word = 0; word < num_words; ++word) {
    for (std::uint64_t bits = words[word]; bits != 0; bits &= bits - 1U) {
      visit(word * 64 + lowest_bit(bits));
    }
  }
}

template <typename Scalar, int D>
void join_nearest_core(DbscanProblem<Scalar, D>& problem, std::size_t point,
                       const NearestCore<Scalar, D>& nearest) {
  if (!nearest.found()) return;
  problem.kinds[problem.input[point]] = PointKind::kBorder;
  problem.labels[problem.input[point]] = problem.labels[problem.input[nearest.index()]];
}

/// Every pair once, written down as a bit; then clusters grow by whole words. At most
/// kMaxPointsAsBits points. O(n²) time, O(n²) bits.
template <typename Scalar, int D>
void cluster_few(DbscanProblem<Scalar, D>& problem, DbscanWorkspace<Scalar>& workspace) {
  constexpr std::size_t kMaxWords = kMaxPointsAsBits / 64;
  const std::size_t n = problem.num_points;
  const std::size_t num_words = (n + 63) / 64;
  reserve_elements(workspace.neighbor_bits, n * num_words);
  std::uint64_t* const neighbors = workspace.neighbor_bits.data();
  std::uint64_t unreached[kMaxWords] = {};  // core points without a cluster
  for (std::size_t i = 0; i < n; ++i) {
    const NearTest<Scalar, D> test = problem.near(i);
    std::uint64_t* const row = neighbors + i * num_words;
    unsigned num_neighbors = 0;
    for (std::size_t word = 0; word < num_words; ++word) {
      std::uint64_t bits = 0;
      const std::size_t begin = word * 64;
      for (std::size_t j = begin; j < n && j < begin + 64; j += 16) {
        bits |= std::uint64_t(test.neighbors_of_16(problem.points, j)) << (j - begin);
      }
      if (n - begin < 64) bits &= (std::uint64_t(1) << (n - begin)) - 1U;
      row[word] = bits;
      num_neighbors += count_of_bits(bits);
    }
    if (num_neighbors >= problem.min_points) {
      unreached[i / 64] |= std::uint64_t(1) << (i % 64);
      problem.kinds[problem.input[i]] = PointKind::kCore;
    }
  }
  problem.num_comparisons += std::uint64_t(n) * n;

  std::uint64_t core[kMaxWords] = {};
  for (std::size_t word = 0; word < kMaxWords; ++word) core[word] = unreached[word];
  for (std::size_t i = 0; i < n; ++i) {
    if ((unreached[i / 64] >> (i % 64) & 1U) == 0) continue;
    const std::int32_t cluster = problem.num_clusters++;
    std::uint64_t pending[kMaxWords] = {};
    pending[i / 64] = std::uint64_t(1) << (i % 64);
    unreached[i / 64] ^= pending[i / 64];
    for (std::size_t word = i / 64; word < num_words;) {
      if (pending[word] == 0) {
        ++word;
        continue;
      }
      const std::size_t point = word * 64 + lowest_bit(pending[word]);
      pending[word] &= pending[word] - 1U;
      problem.labels[problem.input[point]] = cluster;
      const std::uint64_t* const row = neighbors + point * num_words;
      for (std::size_t w = num_words; w-- > 0;) {
        const std::uint64_t reached = row[w] & unreached[w];
        if (reached == 0) continue;
        unreached[w] ^= reached;
        pending[w] |= reached;
        if (w < word) word = w;
      }
    }
  }

  for (std::size_t i = 0; i < n; ++i) {
    if ((core[i / 64] >> (i % 64) & 1U) != 0) continue;
    std::uint64_t near_core[kMaxWords] = {};
    for (std::size_t word = 0; word < num_words; ++word) {
      near_core[word] = neighbors[i * num_words + word] & core[word];
    }
    const NearTest<Scalar, D> test = problem.near(i);
    NearestCore<Scalar, D> nearest;
    visit_bits(near_core, num_words, [&](std::size_t j) {
      nearest.offer(problem.points, j, test.squared_distance(problem.points, j));
    });
    join_nearest_core(problem, i, nearest);
  }
}

/// Every pair, as the definition says; the reference that the other searches are held against, and
/// the fastest for some hundred points of many dimensions. O(n²) time, O(n) memory.
template <typename Scalar, int D>
void cluster_brute_force(DbscanProblem<Scalar, D>& problem, DbscanWorkspace<Scalar>& workspace) {
  const std::size_t n = problem.num_points;
  std::uint64_t& num_comparisons = problem.num_comparisons;
  for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
    reserve_elements(workspace.remaining[axis], n + kLanes);
  }
  reserve_elements(workspace.remaining_index, n);
  reserve_elements(workspace.pending, n);
  std::uint32_t* const remaining_index = workspace.remaining_index.data();
  std::size_t num_remaining = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (count_neighbors(problem.near(i), problem.points, 0, n, problem.min_points,
                        num_comparisons) < problem.min_points) {
      continue;
    }
    problem.kinds[problem.input[i]] = PointKind::kCore;
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      workspace.remaining[axis][num_remaining] = problem.points[axis][i];
    }
    remaining_index[num_remaining++] = std::uint32_t(i);
  }

  // Clusters grow from point to point; whatever is reached leaves the points still looked at.
  const PointAxes<Scalar, D> remaining = axes_of<D>(workspace.remaining);
  std::uint32_t* const pending = workspace.pending.data();
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (!problem.is_core(seed) || problem.labels[problem.input[seed]] != kNoiseLabel) continue;
    const std::int32_t cluster = problem.num_clusters++;
    std::size_t num_pending = 1;
    pending[0] = std::uint32_t(seed);
    problem.labels[problem.input[seed]] = cluster;
    while (num_pending > 0) {
      const NearTest<Scalar, D> test = problem.near(pending[--num_pending]);
      std::size_t num_kept = 0;
      num_comparisons += num_remaining;
      for (std::size_t first = 0; first < num_remaining; first += kLanes) {
        const unsigned lanes = lanes_before(first, num_remaining);
        const unsigned reached = test.neighbors_of_4(remaining, first) & lanes;
        if (reached == 0 && num_kept == first) {
          num_kept = first + count_of_nibble(lanes);
          continue;
        }
        for (std::size_t i = first; i < num_remaining && i < first + kLanes; ++i) {
          const std::uint32_t point = remaining_index[i];
          if ((reached >> (i - first) & 1U) != 0) {
            std::int32_t& label = problem.labels[problem.input[point]];
            if (label == kNoiseLabel) pending[num_pending++] = point;
            label = cluster;
          } else {
            for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
              workspace.remaining[axis][num_kept] = workspace.remaining[axis][i];
            }
            remaining_index[num_kept++] = point;
          }
        }
      }
      num_remaining = num_kept;
    }
  }

  for (std::size_t i = 0; i < n; ++i) {
    if (problem.is_core(i)) continue;
    const NearTest<Scalar, D> test = problem.near(i);
    NearestCore<Scalar, D> nearest;
    visit_neighbors(test, problem.points, 0, n, num_comparisons, [&](std::size_t j) {
      if (problem.is_core(j)) {
        nearest.offer(problem.points, j, test.squared_distance(problem.points, j));
      }
      return true;
    });
    join_nearest_core(problem, i, nearest);
  }
}

}  // namespace srslam::detail
