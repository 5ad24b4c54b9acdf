#include "cli/campaign/campaign_command.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/campaign/campaign_folder.hpp"
#include "cli/campaign/campaign_runner.hpp"
#include "cli/campaign/campaign_table_text.hpp"
#include "cli/exit_code.hpp"
#include "cli/library_versions.hpp"
#include "cli/pipeline_config.hpp"
#include "cli/report/campaign_report.hpp"
#include "cli/run_inputs.hpp"
#include "cli/run_outputs.hpp"
#include "cli/stop_signal.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

/// The program itself, also after its file was replaced.
constexpr const char* kThisProgram = "/proc/self/exe";

std::size_t default_parallel() {
  return std::max<std::size_t>(1, std::thread::hardware_concurrency() / 2);
}

/// An option that decides what the jobs compute, so that it means nothing without a suite.
std::string plan_option_given(const CampaignSettings& settings) {
  if (!settings.variants.empty()) return "--variants";
  if (!settings.scenarios.empty()) return "--scenarios";
  if (!settings.seeds.empty()) return "--seeds";
  if (settings.num_repeats) return "--repeats";
  if (settings.max_frames) return "--max-frames";
  if (!settings.camera.empty()) return "--camera";
  return settings.config_file.empty() ? "" : "--config";
}

std::string plan_sequences(const CampaignSettings& settings, const SequenceRenderer& renderer,
                           CampaignPlan* plan) {
  if (settings.suite == kSyntheticSuite) {
    if (!settings.camera.empty()) return "--camera: synthetic sequences bring their own camera";
    std::vector<std::uint32_t> seeds = {1};
    if (!settings.seeds.empty()) {
      const std::string reason = parse_seeds(settings.seeds, &seeds);
      if (!reason.empty()) return "--seeds: " + reason;
    }
    plan->suite = kSyntheticSuite;
    return rendered_sequences(renderer, settings.scenarios, seeds, &plan->sequences);
  }
  for (const auto& [name, text] :
       {std::pair{"--scenarios", &settings.scenarios}, {"--seeds", &settings.seeds}}) {
    if (!text->empty()) return std::string(name) + " is for --suite synthetic only";
  }
  std::string camera = settings.camera;
  std::error_code error;
  if (!camera.empty()) {
    RgbdCamera ignored;
    std::string reason = read_camera(camera, &ignored);
    if (!reason.empty()) return reason;
    if (!is_camera_preset(camera)) camera = fs::absolute(camera, error).string();
  }
  plan->suite = fs::weakly_canonical(fs::absolute(settings.suite, error), error).string();
  return find_sequences(settings.suite, camera, &plan->sequences);
}

/// A campaign with its folder: takes the lock, settles on the plan, does what was asked for.
class Campaign {
 public:
  explicit Campaign(const CampaignSettings& settings)
      : settings_(settings), renderer_(synthetic_renderer(kThisProgram)) {
    std::error_code error;
    folder_ = fs::absolute(settings.output_folder, error).lexically_normal().string();
    while (folder_.size() > 1 && folder_.back() == '/') folder_.pop_back();
  }

  /// Returns an empty string, or what is wrong.
  std::string prepare() {
    const bool has_plan = fs::exists(path(kPlanFile));
    if (!has_plan && (settings_.suite.empty() || settings_.only_job || settings_.only_merge)) {
      return folder_ + " holds no " + kPlanFile +
             (settings_.only_job || settings_.only_merge ? ": make it with --plan first"
                                                         : ": give --suite");
    }
    if (settings_.suite.empty()) {
      const std::string option = plan_option_given(settings_);
      if (!option.empty()) return option + " needs --suite; without it the plan is as it was";
    } else {
      std::string reason = make_plan(settings_, renderer_, &plan_, &config_text_);
      if (!reason.empty()) return reason;
    }
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) return folder_ + ": cannot be made: " + error.message();
    // Jobs of a batch system write nothing that they share.
    if (!settings_.only_job) {
      std::string reason = lock_.acquire(folder_);
      if (!reason.empty()) return reason;
    }
    return has_plan ? take_stored_plan() : store_plan();
  }

  int execute() {
    if (settings_.only_plan) {
      std::cout << job_list_text(plan_, folder_) << std::flush;
      return kExitOk;
    }
    const std::vector<CampaignJob> jobs = plan_jobs(plan_);
    if (settings_.only_job) {
      const std::size_t index = *settings_.only_job;
      if (index > jobs.size()) {
        return error_exit(kExitUsage, "--job " + std::to_string(index) +
                                          ": the plan has the jobs 1 to " +
                                          std::to_string(jobs.size()));
      }
      return run_jobs({jobs[index - 1]});
    }
    if (!settings_.only_merge) {
      remove_abandoned_work(path(kJobsFolder));
      remove_abandoned_work(path("sequences"));
      const int exit_code = run_jobs(jobs);
      // A failed job is told by the tables.
      if (exit_code > kExitFailure || (exit_code == kExitFailure && cannot_go_on_))
        return exit_code;
    }
    return merge(jobs);
  }

 private:
  std::string path(const char* name) const { return (fs::path(folder_) / name).string(); }

  std::string take_stored_plan() {
    CampaignPlan stored;
    std::string text;
    const FileStatus read = read_text_file(path(kPlanFile), &text);
    if (!read.ok()) return read.message();
    std::string reason = parse_plan(text, path(kPlanFile), &stored);
    if (!reason.empty()) return reason;
    if (settings_.suite.empty()) plan_ = stored;
    CampaignPlan expected = plan_;
    expected.version = program_identity();
    const std::string difference = plan_difference(stored, expected);
    if (!difference.empty()) {
      return folder_ + " holds another campaign: " + difference +
             ". Give the same options, or another --output";
    }
    PipelineOptions options;
    const FileStatus config = read_pipeline_config(path(kPlanConfigFile), &options);
    if (!config.ok()) return config.message();
    if (config_hash(options) != stored.config_hash) {
      return path(kPlanConfigFile) + ": has been changed since the plan was made (hash " +
             config_hash(options) + ", in the plan " + stored.config_hash + ")";
    }
    return {};
  }

  std::string store_plan() {
    // The plan last: with it the folder is complete.
    const FileStatus config = write_file_atomically(path(kPlanConfigFile), config_text_);
    if (!config.ok()) return config.message();
    return write_file_atomically(
               path(kPlanFile),
               plan_json(plan_).dump(2, ' ', false,
                                     nlohmann::ordered_json::error_handler_t::replace) +
                   "\n")
        .message();
  }

  int run_jobs(const std::vector<CampaignJob>& jobs) {
    RunnerSettings settings;
    settings.folder = folder_;
    settings.program = kThisProgram;
    settings.num_parallel =
        settings_.only_job ? 1 : settings_.num_parallel.value_or(default_parallel());
    settings.timeout_s = settings_.timeout_s;
    settings.retry_failed = settings_.retry_failed;
    settings.quiet = settings_.quiet;
    CampaignRunner runner(plan_, renderer_, settings);
    const std::string reason = runner.run(jobs);
    if (!reason.empty()) {
      cannot_go_on_ = true;
      return error_exit(kExitFailure, reason);
    }
    const int signal_number = requested_stop_signal();
    if (signal_number != 0 && !runner.is_finished()) {
      std::cerr << "srslam: warning: interrupted; the same command goes on with what is not done"
                << std::endl;
      return kExitSignalBase + signal_number;
    }
    return runner.num_failed() == 0 ? kExitOk : kExitFailure;
  }

  int merge(const std::vector<CampaignJob>& jobs) const {
    std::vector<JobRecord> records;
    records.reserve(jobs.size());
    for (const CampaignJob& job : jobs)
      records.push_back(read_job_record(job_folder(folder_, job)));
    const CampaignTables tables = make_tables(plan_, records);
    for (const auto& [name, text] :
         {std::pair{kTablesMarkdownFile, tables_markdown(plan_, tables)},
          {kTablesCsvFile, tables_csv(plan_, tables, records)},
          {kTablesJsonFile, tables_json(plan_, tables, records)},
          {kTimesFile, times_csv(plan_, records)},
          {kReportFile, campaign_report_page(plan_, tables, records, folder_)}}) {
      const FileStatus written = write_file_atomically(path(name), text);
      if (!written.ok()) return error_exit(kExitFailure, written.message());
    }
    for (const CampaignGap& gap : tables.missing) {
      std::cerr << "srslam: warning: job " << gap.job.index << " (" << gap.job.id
                << ") has not been run" << std::endl;
    }
    const std::size_t num_gaps = tables.failed.size() + tables.missing.size();
    std::cout << "jobs: " << jobs.size() - num_gaps << " done, " << tables.failed.size()
              << " failed, " << tables.missing.size()
              << " missing\ntables: " << path(kTablesMarkdownFile)
              << "\nreport: " << path(kReportFile) << std::endl;
    return num_gaps == 0 ? kExitOk : kExitFailure;
  }

  const CampaignSettings& settings_;
  SequenceRenderer renderer_;
  std::string folder_;
  std::string config_text_;
  CampaignPlan plan_;
  CampaignLock lock_;
  bool cannot_go_on_ = false;
};

}  // namespace

std::string make_plan(const CampaignSettings& settings, const SequenceRenderer& renderer,
                      CampaignPlan* plan, std::string* config_text) {
  CampaignPlan result;
  result.version = program_identity();
  result.num_repeats = settings.num_repeats.value_or(1);
  result.max_frames = settings.max_frames;
  std::string reason = parse_variants(settings.variants, known_modules(), &result.variants);
  if (!reason.empty()) return "--variants: " + reason;
  PipelineOptions options;
  if (!settings.config_file.empty()) {
    const FileStatus status = read_pipeline_config(settings.config_file, &options);
    if (!status.ok()) return status.message();
    const Status valid = options.validate();
    if (!valid.ok()) return settings.config_file + ": " + valid.reason;
  }
  result.config_hash = config_hash(options);
  reason = plan_sequences(settings, renderer, &result);
  if (!reason.empty()) return reason;
  *config_text = config_file_text(options);
  *plan = result;
  return {};
}

int campaign_command(const CampaignSettings& settings) {
  install_stop_signals();
  Campaign campaign(settings);
  const std::string reason = campaign.prepare();
  return reason.empty() ? campaign.execute() : error_exit(kExitUsage, reason);
}

}  // namespace srslam::cli
