#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "cli/campaign/campaign_plan.hpp"

namespace CLI {
class App;
}

namespace srslam::cli {

/// What the command line of `srslam campaign` says. Empty means not given.
struct CampaignSettings {
  // What the jobs compute.
  std::string suite;  ///< `synthetic` or a folder
  std::string variants;
  std::string scenarios;
  std::string seeds;
  std::optional<std::size_t> num_repeats;
  std::optional<std::size_t> max_frames;
  std::string camera;
  std::string config_file;
  // How they are run.
  std::string output_folder;
  std::optional<std::size_t> num_parallel;
  double timeout_s = 7200.0;
  bool retry_failed = false;
  bool quiet = false;
  // Parts of the work.
  bool only_plan = false;
  std::optional<std::size_t> only_job;
  bool only_merge = false;
};

/// Adds the command `campaign` to the command line.
CLI::App* add_campaign_command(CLI::App* program, CampaignSettings* settings);

/// Runs every job of a campaign that has not been run, and makes the tables. Returns an ExitCode:
/// kExitFailure when a job failed or is missing, or kExitSignalBase + signal.
int campaign_command(const CampaignSettings& settings);

/// The plan that the settings ask for; they name a suite. Returns an empty string, or what is wrong
/// and what would be right.
std::string make_plan(const CampaignSettings& settings, const SequenceRenderer& renderer,
                      CampaignPlan* plan, std::string* config_text);

}  // namespace srslam::cli
