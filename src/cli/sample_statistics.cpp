#include "cli/sample_statistics.hpp"

#include <algorithm>
#include <numeric>

#include "srslam/core/nearest_rank.hpp"

namespace srslam::cli {

SampleStatistics summarize(std::vector<double> values) {
  SampleStatistics statistics;
  statistics.count = values.size();
  if (values.empty()) return statistics;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  statistics.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(n);
  statistics.median = n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  statistics.p95 = nearest_rank(values, 95.0);
  statistics.min = values.front();
  statistics.max = values.back();
  return statistics;
}

}  // namespace srslam::cli
