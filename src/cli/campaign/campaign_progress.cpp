#include "cli/campaign/campaign_progress.hpp"

#include <algorithm>
#include <cmath>

#include "cli/sample_statistics.hpp"

namespace srslam::cli {
namespace {

std::string two_digits(long value) {
  return std::string(value < 10 ? "0" : "") + std::to_string(value);
}

}  // namespace

double remaining_s(const CampaignProgress& progress) {
  if (progress.job_s.empty()) return -1.0;
  const std::size_t num_left = progress.num_jobs - progress.num_done - progress.num_failed;
  const double work_s =
      static_cast<double>(num_left) * summarize(progress.job_s).median +
      static_cast<double>(progress.num_renderings_left) * summarize(progress.rendering_s).median;
  const std::size_t num_tasks = num_left + progress.num_renderings_left;
  const std::size_t num_workers =
      std::max<std::size_t>(1, std::min(progress.num_parallel, num_tasks));
  return std::max(0.0, work_s - progress.running_s) / static_cast<double>(num_workers);
}

std::string duration_text(double seconds) {
  const long total_s = std::lround(seconds);
  if (total_s < 60) return std::to_string(total_s) + " s";
  if (total_s < 3600) {
    return std::to_string(total_s / 60) + " min " + two_digits(total_s % 60) + " s";
  }
  return std::to_string(total_s / 3600) + " h " + two_digits(total_s % 3600 / 60) + " min";
}

std::string campaign_progress_text(const CampaignProgress& progress) {
  const double left_s = remaining_s(progress);
  return "jobs " + std::to_string(progress.num_done + progress.num_failed) + "/" +
         std::to_string(progress.num_jobs) + "  failed " + std::to_string(progress.num_failed) +
         "  running " + std::to_string(progress.num_running) + "  left " +
         (left_s < 0.0 ? "?" : duration_text(left_s));
}

}  // namespace srslam::cli
