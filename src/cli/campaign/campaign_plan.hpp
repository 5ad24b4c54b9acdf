#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/campaign/campaign_sequences.hpp"
#include "cli/campaign/campaign_variants.hpp"

namespace srslam::cli {

constexpr const char* kPlanFile = "plan.json";
constexpr const char* kPlanConfigFile = "config.yaml";
constexpr const char* kJobsFolder = "jobs";
constexpr const char* kSyntheticSuite = "synthetic";

/// Everything that decides what the jobs of a campaign compute. How many run at once is no part.
struct CampaignPlan {
  std::string version;  ///< of srslam, the program's bytes and the synthetic world
  std::string suite;    ///< `synthetic` or a folder
  std::vector<CampaignSequence> sequences;
  std::vector<CampaignVariant> variants;
  std::size_t num_repeats = 1;
  std::optional<std::size_t> max_frames;
  std::string config_hash;
};

/// One run of a variant over a sequence.
struct CampaignJob {
  std::size_t index = 1;  ///< from 1, as `--job` takes it
  std::string id;         ///< name of its folder
  std::size_t sequence = 0;
  std::size_t variant = 0;
  std::size_t repeat = 1;  ///< from 1
};

/// The jobs of a plan: sequences, in them variants, in them repeats. Ids are unique and hold no
/// character that means something to a shell or a file system.
std::vector<CampaignJob> plan_jobs(const CampaignPlan& plan);

/// Arguments of srslam for a job, without the program's name. `campaign_folder` is absolute; the
/// results go to `output`.
std::vector<std::string> run_arguments(const CampaignPlan& plan, const CampaignJob& job,
                                       const std::string& campaign_folder,
                                       const std::string& output);

/// Where the images of `sequence` are.
std::string sequence_folder(const CampaignSequence& sequence, const std::string& campaign_folder);

nlohmann::ordered_json plan_json(const CampaignPlan& plan);

/// Reads a plan. `text` is the content of `file`. Returns an empty string, or file and reason;
/// `plan` is set on success only.
std::string parse_plan(const std::string& text, const std::string& file, CampaignPlan* plan);

/// What differs between the plan of a folder and a new one, for people; empty when nothing does.
std::string plan_difference(const CampaignPlan& stored, const CampaignPlan& wanted);

/// The job list as `--plan` prints it: index, id and command, separated by tabs.
std::string job_list_text(const CampaignPlan& plan, const std::string& campaign_folder);

}  // namespace srslam::cli
