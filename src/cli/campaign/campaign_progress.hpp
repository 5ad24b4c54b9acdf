#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace srslam::cli {

/// What is left to do of a campaign, for the estimate of its end.
struct CampaignProgress {
  std::size_t num_jobs = 0;
  std::size_t num_done = 0;  ///< with those of earlier starts
  std::size_t num_failed = 0;
  std::size_t num_renderings_left = 0;  ///< under way or not begun
  std::size_t num_running = 0;
  std::size_t num_parallel = 1;     ///< at most at once
  double running_s = 0.0;           ///< how long those under way have taken, together
  std::vector<double> job_s;        ///< durations of jobs that ended
  std::vector<double> rendering_s;  ///< durations of renderings that ended
};

/// Time to the end [s], by the medians of what has ended; negative while nothing has.
double remaining_s(const CampaignProgress& progress);

/// "45 s", "3 min 20 s", "2 h 05 min".
std::string duration_text(double seconds);

/// The progress line.
std::string campaign_progress_text(const CampaignProgress& progress);

}  // namespace srslam::cli
