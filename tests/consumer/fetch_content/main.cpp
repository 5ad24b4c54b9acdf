#include <cstdio>

#include "srslam/evaluation/improvement.hpp"

int main() {
  const srslam::ImprovementResult result = srslam::improvement_percent(0.05, 0.2);
  std::printf("improvement: %g %%\n", result.percent);
  return result.status.ok() && result.percent > 74.9 && result.percent < 75.1 ? 0 : 1;
}
