#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "cli/campaign/campaign_plan.hpp"

namespace srslam::cli {

constexpr const char* kJobRecordFile = "job.json";
constexpr const char* kJobLogFile = "log.txt";

enum class JobStatus : std::uint8_t {
  kMissing,  ///< not run, or not to its end
  kDone,
  kFailed,
};

/// What is kept of a job: the file job.json in its folder.
struct JobRecord {
  JobStatus status = JobStatus::kMissing;
  std::string reason;                        ///< of a failure
  std::map<std::string, double> figures;     ///< by the keys of campaign_metrics()
  std::map<std::string, std::string> facts;  ///< by the keys of campaign_facts()
  std::map<std::string, double> times;       ///< by the keys of campaign_time_metrics()
  double seconds = 0.0;                      ///< of the process
  std::size_t num_parallel = 1;              ///< jobs that the campaign ran at once
};

JobRecord failed_job(const std::string& reason);

/// The record of a run that ended with code 0, from the summary.json in `folder`; failed when it is
/// not there, cannot be read, or was made with other options than `config_hash`.
JobRecord record_of_run(const std::string& folder, const std::string& config_hash);

/// What the end of a program's log says, in one line of text: its errors, else its last lines.
std::string log_tail(const std::string& log_file);

std::string job_record_text(const CampaignJob& job, const JobRecord& record);

/// The record in the folder of a job; kMissing when there is none or it cannot be read.
JobRecord read_job_record(const std::string& folder);

/// Folder of a finished job.
std::string job_folder(const std::string& campaign_folder, const CampaignJob& job);

}  // namespace srslam::cli
