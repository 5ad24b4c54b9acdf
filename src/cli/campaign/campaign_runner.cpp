#include "cli/campaign/campaign_runner.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <thread>

#include "cli/campaign/campaign_folder.hpp"
#include "cli/number_text.hpp"
#include "cli/stop_signal.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPollInterval(10);
constexpr double kLogInterval_s = 30.0;
constexpr const char* kRenderedFolder = "sequence";

/// Where a rendering's log and images are while it goes on.
std::string inside(const std::string& folder, const char* name) {
  return (fs::path(folder) / name).string();
}

/// `reason` without what is different in every campaign folder.
std::string without_folder(std::string reason, const std::string& folder) {
  const std::string prefix = folder + "/";
  for (std::size_t at = 0; (at = reason.find(prefix, at)) != std::string::npos;) {
    reason.erase(at, prefix.size());
  }
  return reason;
}

}  // namespace

CampaignRunner::CampaignRunner(const CampaignPlan& plan, const SequenceRenderer& renderer,
                               const RunnerSettings& settings)
    : plan_(plan),
      renderer_(renderer),
      settings_(settings),
      jobs_folder_((fs::path(settings.folder) / kJobsFolder).string()),
      sequences_(plan.sequences.size()),
      line_(!settings.quiet, kLogInterval_s) {}

void CampaignRunner::sort_out(const std::vector<CampaignJob>& jobs) {
  progress_.num_jobs = jobs.size();
  progress_.num_parallel = settings_.num_parallel;
  for (const CampaignJob& job : jobs) {
    const JobRecord record = read_job_record(job_folder(settings_.folder, job));
    if (record.status == JobStatus::kDone) {
      ++progress_.num_done;
      progress_.job_s.push_back(record.seconds);
    } else if (record.status == JobStatus::kFailed && !settings_.retry_failed) {
      ++progress_.num_failed;
    } else {
      pending_.push_back(job);
    }
  }
  for (const CampaignJob& job : pending_) {
    Sequence& sequence = sequences_[job.sequence];
    if (sequence.state == SequenceState::kReady) continue;
    const CampaignSequence& planned = plan_.sequences[job.sequence];
    std::error_code error;
    if (!planned.is_rendered() ||
        fs::is_directory(sequence_folder(planned, settings_.folder), error)) {
      sequence.state = SequenceState::kReady;
    }
  }
}

std::string CampaignRunner::run(const std::vector<CampaignJob>& jobs) {
  sort_out(jobs);
  std::string reason;
  while (reason.empty() && (!pending_.empty() || !tasks_.empty())) {
    if (requested_stop_signal() != 0) break;
    reason = start_tasks();
    if (reason.empty()) reason = collect();
    show_progress();
    std::this_thread::sleep_for(kPollInterval);
  }
  drop_tasks();
  line_.finish();
  return reason;
}

std::string CampaignRunner::start_tasks() {
  bool started = true;
  while (started && tasks_.size() < settings_.num_parallel) {
    std::string reason = start_next(&started);
    if (!reason.empty()) return reason;
  }
  return {};
}

std::string CampaignRunner::start_next(bool* started) {
  *started = true;
  for (auto job = pending_.begin(); job != pending_.end();) {
    const Sequence& sequence = sequences_[job->sequence];
    if (sequence.state == SequenceState::kAbsent) return start_rendering(job->sequence);
    if (sequence.state == SequenceState::kRendering) {
      ++job;
      continue;
    }
    const CampaignJob chosen = *job;
    job = pending_.erase(job);
    if (sequence.state == SequenceState::kReady) return start_run(chosen);
    std::string reason = keep_without_run(chosen, sequence.reason);
    if (!reason.empty()) return reason;
  }
  *started = false;
  return {};
}

std::string CampaignRunner::start_rendering(std::size_t sequence) {
  const CampaignSequence& planned = plan_.sequences[sequence];
  const fs::path target = sequence_folder(planned, settings_.folder);
  Task& task = tasks_.emplace_back();
  task.is_rendering = true;
  task.sequence = sequence;
  std::string reason =
      make_work_folder(target.parent_path().string(), planned.label(), &task.work_folder);
  if (!reason.empty()) return reason;
  sequences_[sequence].state = SequenceState::kRendering;
  RenderRequest request;
  request.scenario = planned.name;
  request.seed = *planned.seed;
  request.max_frames = plan_.max_frames;
  request.folder = inside(task.work_folder, kRenderedFolder);
  reason = task.process.start(renderer_.command(request), task.work_folder,
                              inside(task.work_folder, kJobLogFile));
  if (reason.empty()) return {};
  reason = finish_rendering(task, reason);
  tasks_.pop_back();
  return reason;
}

std::string CampaignRunner::start_run(const CampaignJob& job) {
  Task& task = tasks_.emplace_back();
  task.job = job;
  std::string reason = make_work_folder(jobs_folder_, job.id, &task.work_folder);
  if (!reason.empty()) return reason;
  // It runs in its own folder, so that no result names a folder that is renamed later.
  std::vector<std::string> arguments = run_arguments(plan_, job, settings_.folder, ".");
  arguments.insert(arguments.begin(), settings_.program);
  reason = task.process.start(arguments, task.work_folder, inside(task.work_folder, kJobLogFile));
  if (reason.empty()) return {};
  reason = finish_run(task, reason);
  tasks_.pop_back();
  return reason;
}

std::string CampaignRunner::collect() {
  for (auto task = tasks_.begin(); task != tasks_.end();) {
    std::string failure;
    if (const auto end = task->process.poll()) {
      failure = end->reason;
    } else if (task->process.elapsed_s() > settings_.timeout_s) {
      task->process.end();
      failure = "did not end within " + shortest_text(settings_.timeout_s) + " s";
    } else {
      ++task;
      continue;
    }
    std::string reason =
        task->is_rendering ? finish_rendering(*task, failure) : finish_run(*task, failure);
    task = tasks_.erase(task);
    if (!reason.empty()) return reason;
  }
  return {};
}

std::string CampaignRunner::finish_rendering(const Task& task, const std::string& failure) {
  Sequence& sequence = sequences_[task.sequence];
  const CampaignSequence& planned = plan_.sequences[task.sequence];
  const std::string rendered = inside(task.work_folder, kRenderedFolder);
  std::error_code ignored;
  std::string reason;
  if (!failure.empty() || !fs::is_directory(rendered, ignored)) {
    const std::string tail = log_tail(inside(task.work_folder, kJobLogFile));
    sequence.state = SequenceState::kFailed;
    sequence.reason = "its sequence " + planned.label() + " was not rendered: synth " +
                      (failure.empty() ? "made no folder" : failure) +
                      (tail.empty() ? "" : ": " + tail);
  } else {
    sequence.state = SequenceState::kReady;
    progress_.rendering_s.push_back(task.process.elapsed_s());
    reason = publish_folder(rendered, sequence_folder(planned, settings_.folder), false);
  }
  fs::remove_all(task.work_folder, ignored);
  return reason;
}

std::string CampaignRunner::finish_run(const Task& task, const std::string& failure) {
  JobRecord record;
  if (failure.empty()) {
    record = record_of_run(task.work_folder, plan_.config_hash);
  } else {
    const std::string tail = log_tail(inside(task.work_folder, kJobLogFile));
    record = failed_job("run " + failure + (tail.empty() ? "" : ": " + tail));
  }
  record.seconds = task.process.elapsed_s();
  return keep(task.job, task.work_folder, record);
}

std::string CampaignRunner::keep_without_run(const CampaignJob& job, const std::string& reason) {
  std::string work_folder;
  std::string failure = make_work_folder(jobs_folder_, job.id, &work_folder);
  return failure.empty() ? keep(job, work_folder, failed_job(reason)) : failure;
}

std::string CampaignRunner::keep(const CampaignJob& job, const std::string& work_folder,
                                 const JobRecord& result) {
  JobRecord record = result;
  record.num_parallel = settings_.num_parallel;
  record.reason = without_folder(without_folder(record.reason, work_folder), settings_.folder);
  const FileStatus written =
      write_file_atomically(inside(work_folder, kJobRecordFile), job_record_text(job, record));
  if (!written.ok()) return written.message();
  const std::string folder = job_folder(settings_.folder, job);
  // What is there is a failure that is tried again, or no job's folder at all; or else another
  // process did this job meanwhile, and its result is as good.
  const bool replaces = read_job_record(folder).status != JobStatus::kDone;
  std::string reason = publish_folder(work_folder, folder, replaces);
  if (!reason.empty()) return reason;
  if (record.status == JobStatus::kDone) {
    ++progress_.num_done;
    progress_.job_s.push_back(record.seconds);
  } else {
    ++progress_.num_failed;
    line_.message("srslam: warning: job " + std::to_string(job.index) + " (" + job.id +
                  ") failed: " + record.reason);
  }
  return {};
}

void CampaignRunner::drop_tasks() {
  for (Task& task : tasks_) {
    task.process.end();
    std::error_code ignored;
    if (!task.work_folder.empty()) fs::remove_all(task.work_folder, ignored);
  }
  tasks_.clear();
}

void CampaignRunner::show_progress() {
  progress_.num_running = tasks_.size();
  progress_.running_s = 0.0;
  for (const Task& task : tasks_) progress_.running_s += task.process.elapsed_s();
  std::vector<bool> is_needed(sequences_.size(), false);
  for (const CampaignJob& job : pending_) is_needed[job.sequence] = true;
  progress_.num_renderings_left = 0;
  for (std::size_t i = 0; i < sequences_.size(); ++i) {
    const SequenceState state = sequences_[i].state;
    const bool is_open = state == SequenceState::kAbsent || state == SequenceState::kRendering;
    if (is_needed[i] && is_open) ++progress_.num_renderings_left;
  }
  line_.update(campaign_progress_text(progress_));
}

}  // namespace srslam::cli
