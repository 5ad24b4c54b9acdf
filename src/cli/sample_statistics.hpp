#pragma once

#include <cstddef>
#include <vector>

namespace srslam::cli {

/// Summary of measured values. All 0 when there are none.
struct SampleStatistics {
  std::size_t count = 0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values when count is even
  double min = 0.0;
  double p95 = 0.0;  ///< nearest rank: the smallest value that >= 95 % of the values do not exceed
  double max = 0.0;
};

/// Takes the values by value because it sorts them. O(n log n).
SampleStatistics summarize(std::vector<double> values);

}  // namespace srslam::cli
