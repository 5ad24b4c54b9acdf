#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "srslam/core/array_view.hpp"

namespace srslam {

/// Percentile by nearest rank: the smallest of the sorted values that at least `percent` of them do
/// not exceed; 0 is the smallest of all, 100 the largest. NaN for none.
inline double nearest_rank(ArrayView<const double> sorted, double percent) noexcept {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  // The product first: 95 % of 20 values is rank 19 exactly, though 0.95 is not a binary number.
  const double rank = std::ceil(percent * double(sorted.size) / 100.0);
  return sorted[std::min(static_cast<std::size_t>(std::max(rank, 1.0)), sorted.size) - 1];
}

}  // namespace srslam
