#pragma once

#include <cstddef>
#include <list>
#include <string>
#include <vector>

#include "cli/campaign/campaign_plan.hpp"
#include "cli/campaign/campaign_progress.hpp"
#include "cli/campaign/campaign_record.hpp"
#include "cli/child_process.hpp"
#include "cli/progress_line.hpp"

namespace srslam::cli {

struct RunnerSettings {
  std::string folder;   ///< of the campaign, absolute
  std::string program;  ///< srslam
  std::size_t num_parallel = 1;
  double timeout_s = 7200.0;  ///< of a job or a rendering
  bool retry_failed = false;
  bool quiet = false;
};

/// Runs jobs of a plan as processes. Jobs that have a record are not run again. A job works in a
/// folder of its own, which gets its name when the job is over: whatever happens before leaves the
/// job as if it had never begun. Several runners, on several machines, may share a folder.
class CampaignRunner {
 public:
  CampaignRunner(const CampaignPlan& plan, const SequenceRenderer& renderer,
                 const RunnerSettings& settings);

  /// Until every job has a record or requested_stop_signal() says to stop, when what is under way
  /// is ended and dropped. Returns an empty string, or why results cannot be kept.
  std::string run(const std::vector<CampaignJob>& jobs);

  /// Whether every job that run() was given has a record.
  bool is_finished() const {
    return progress_.num_done + progress_.num_failed == progress_.num_jobs;
  }
  std::size_t num_failed() const { return progress_.num_failed; }

 private:
  enum class SequenceState : unsigned char { kAbsent, kRendering, kReady, kFailed };

  struct Sequence {
    SequenceState state = SequenceState::kAbsent;
    std::string reason;  ///< why it could not be rendered
  };
  /// A process that is under way.
  struct Task {
    ChildProcess process;
    bool is_rendering = false;
    std::size_t sequence = 0;  ///< of a rendering
    CampaignJob job;           ///< of a run
    std::string work_folder;
  };

  void sort_out(const std::vector<CampaignJob>& jobs);
  std::string start_tasks();
  std::string start_next(bool* started);
  std::string start_rendering(std::size_t sequence);
  std::string start_run(const CampaignJob& job);
  std::string collect();
  std::string finish_rendering(const Task& task, const std::string& failure);
  std::string finish_run(const Task& task, const std::string& failure);
  std::string keep(const CampaignJob& job, const std::string& work_folder, const JobRecord& record);
  std::string keep_without_run(const CampaignJob& job, const std::string& reason);
  void drop_tasks();
  void show_progress();

  const CampaignPlan& plan_;
  const SequenceRenderer& renderer_;
  RunnerSettings settings_;
  std::string jobs_folder_;
  std::vector<Sequence> sequences_;
  std::list<CampaignJob> pending_;
  std::list<Task> tasks_;
  CampaignProgress progress_;
  ProgressLine line_;
};

}  // namespace srslam::cli
