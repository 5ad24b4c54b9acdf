#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan_bits.hpp"
#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_types.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam::detail {

/// Up to so many points have all their neighbours written down, a bit each.
constexpr std::size_t kMaxPointsAsBits = 512;

/// Every pair once, written down as a bit; then clusters grow by whole words. At most
/// kMaxPointsAsBits points. O(n²) time, O(n²) bits.
template <typename Scalar, int D>
void cluster_few(DbscanProblem<Scalar, D>& problem, DbscanWorkspace<Scalar>& workspace) {
  constexpr std::size_t kMaxWords = kMaxPointsAsBits / 64;
  const std::size_t n = problem.num_points;
  const std::size_t num_words = words_of(n);
  reserve_elements(workspace.neighbor_bits, n * num_words);
  std::uint64_t* const neighbors = workspace.neighbor_bits.data();
  std::uint64_t core[kMaxWords] = {};
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
      core[i / 64] |= std::uint64_t(1) << (i % 64);
      problem.kinds[problem.input[i]] = PointKind::kCore;
    }
  }
  problem.num_comparisons += std::uint64_t(n) * n;
  cluster_neighbor_rows<kMaxWords>(
      problem, core,
      [&](std::size_t point) {
        return NeighborRow{neighbors + point * num_words, 0, num_words};
      },
      [](std::size_t k) { return k; });
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
