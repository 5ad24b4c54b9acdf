#include "cli/run_command.hpp"

#include <chrono>
#include <csignal>
#include <cstddef>
#include <iostream>
#include <string>

#include "cli/exit_code.hpp"
#include "cli/frame_record.hpp"
#include "cli/number_text.hpp"
#include "cli/progress_line.hpp"
#include "cli/report/run_report.hpp"
#include "cli/run_outputs.hpp"
#include "cli/run_plot.hpp"
#include "cli/run_result.hpp"
#include "cli/stop_signal.hpp"
#include "cli/text_file.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kReadAhead = 4;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

FrameOutcome outcome_of(const PipelineResult& result) {
  if (!result.status.ok()) return FrameOutcome::kRefused;
  switch (result.state) {
    case TrackingState::kTracked:
      return FrameOutcome::kTracked;
    case TrackingState::kLost:
      return FrameOutcome::kLost;
    case TrackingState::kNotInitialized:
      break;
  }
  return FrameOutcome::kNotInitialized;
}

/// Why not one pose came out of a run that ended by itself.
std::string nothing_tracked_reason(const RunInputs& inputs, const RunResult& result) {
  const std::size_t num_frames = result.records.size();
  const std::string all = "nothing was tracked: ";
  if (result.count(FrameOutcome::kDamaged) == num_frames) return all + "every frame is damaged";
  if (result.num_with_depth(inputs.dataset) == 0) {
    return all + "no frame has a depth image close enough in time";
  }
  return all + std::to_string(result.count(FrameOutcome::kNotInitialized)) +
         " frames could not start a map (features with depth needed: " +
         std::to_string(inputs.options.tracking.min_initial_points) + "), " +
         std::to_string(result.count(FrameOutcome::kDamaged)) + " damaged, " +
         std::to_string(result.count(FrameOutcome::kNoDepth)) + " without depth, " +
         std::to_string(result.count(FrameOutcome::kRefused)) + " refused";
}

/// One run: the frames first, then everything that is known only at the end.
class Run {
 public:
  Run(const RunInputs& inputs, bool with_report, bool quiet)
      : inputs_(inputs),
        with_report_(with_report),
        pipeline_(inputs.camera.camera, inputs.options),
        progress_(!quiet) {}

  FileStatus open() {
    FileStatus status = outputs_.open(inputs_);
    if (status.ok() && with_report_) features_.open(inputs_.output_folder);
    return status;
  }

  int execute() {
    const Clock::time_point start = Clock::now();
    const std::string failure = process_frames();
    pipeline_.finish();
    result_.wall_s = milliseconds_since(start) * 1e-3;
    progress_.finish();
    result_.keyframes = pipeline_.keyframes();
    result_.optimized = pipeline_.optimized_trajectory();
    decide_exit(failure);
    write_results();
    std::cout << summary_text(inputs_, result_) << std::flush;
    if (result_.exit_code == kExitFailure) {
      std::cerr << "srslam: error: " << result_.exit_reason << std::endl;
    }
    return result_.exit_code;
  }

 private:
  void warn(const std::string& text) { progress_.message("srslam: warning: " + text); }

  /// Returns why the run cannot go on, or an empty string when it came to its end.
  std::string process_frames() {
    const Status ready = pipeline_.status();
    if (!ready.ok()) return std::string("the pipeline refuses camera or options: ") + ready.reason;
    // With one thread, decoding happens in it too.
    const std::size_t read_ahead = inputs_.options.num_threads > 1 ? kReadAhead : 0;
    FrameReader reader(inputs_.dataset, inputs_.camera, 0, inputs_.num_frames, read_ahead);
    LoadedFrame loaded;
    while (requested_stop_signal() == 0) {
      const Clock::time_point start = Clock::now();
      if (!reader.next(&loaded)) break;
      FrameRecord record;
      record.index = loaded.index;
      record.timestamp_s = loaded.timestamp_s;
      record.decode_ms = loaded.load_ms;
      record.read_wait_ms = milliseconds_since(start);
      const FileStatus status = process(loaded, &record);
      if (!status.ok()) return status.message();
      progress_.update(progress_text(result_.records.size(), inputs_.num_frames,
                                     progress_.elapsed_s(), to_string(record.outcome)));
    }
    return {};
  }

  FileStatus process(const LoadedFrame& loaded, FrameRecord* record) {
    if (!loaded.status.ok()) {
      record->outcome = FrameOutcome::kDamaged;
      return log_skipped(*record, loaded.status.message());
    }
    if (!loaded.has_depth) {
      record->outcome = FrameOutcome::kNoDepth;
      return log_skipped(*record, {});
    }
    check_first_depth(loaded);
    const PipelineResult result = pipeline_.process(pipeline_frame(loaded, inputs_));
    record->outcome = outcome_of(result);
    if (record->outcome == FrameOutcome::kRefused) {
      return log_skipped(*record, std::string("refused by the pipeline: ") + result.status.reason);
    }
    record->num_features = result.num_features;
    record->num_matches = result.num_matches;
    record->num_inliers = result.num_inliers;
    record->times = result.times;
    if (result.has_scene) {
      record->reliability = result.scene.reliability;
      record->is_good = result.scene.scene_class == SceneClass::kGood;
    }
    if (result.has_culling) record->num_culled = result.culling.removal.num_removed;
    if (with_report_) features_.append(record->index, result);
    result_.num_map_points = result.num_map_points;
    result_.records.push_back(*record);
    if (record->outcome == FrameOutcome::kTracked) {
      result_.trajectory.push_back({loaded.timestamp_s, result.T_world_camera});
      FileStatus status = outputs_.append_pose(result_.trajectory.back());
      if (!status.ok()) return status;
    }
    return outputs_.append_frame(*record, &result, {});
  }

  void check_first_depth(const LoadedFrame& loaded) {
    if (result_.first_depth) return;
    result_.first_depth = summarize_depth(loaded.depth_m.view());
    const Status plausible = check_depth_plausible(*result_.first_depth);
    if (plausible.ok()) return;
    warn("frame " + std::to_string(loaded.index) + ", the first with depth: " + plausible.reason +
         " (median " + fixed_text(result_.first_depth->median_m, 3) + " m, valid " +
         fixed_text(100.0 * result_.first_depth->valid_share, 1) + " %, " +
         shortest_text(inputs_.camera.depth_units_per_m) + " units per metre)");
  }

  /// A frame that gives no pose; `note` says why when it is the frame's fault.
  FileStatus log_skipped(const FrameRecord& record, const std::string& note) {
    if (!note.empty()) warn("frame " + std::to_string(record.index) + " is skipped: " + note);
    result_.records.push_back(record);
    return outputs_.append_frame(record, nullptr, note);
  }

  void decide_exit(const std::string& failure) {
    const int signal_number = requested_stop_signal();
    if (!failure.empty()) {
      result_.exit_code = kExitFailure;
      result_.exit_reason = failure;
    } else if (signal_number != 0 && result_.records.size() < inputs_.num_frames) {
      result_.exit_code = kExitSignalBase + signal_number;
      result_.exit_reason = std::string("interrupted by ") +
                            (signal_number == SIGINT ? "SIGINT" : "SIGTERM") + " after frame " +
                            std::to_string(result_.records.size()) + " of " +
                            std::to_string(inputs_.num_frames);
    } else if (result_.trajectory.empty()) {
      result_.exit_code = kExitFailure;
      result_.exit_reason = nothing_tracked_reason(inputs_, result_);
    } else {
      result_.exit_code = kExitOk;
      result_.exit_reason = inputs_.num_frames < inputs_.dataset.size()
                                ? "finished at the limit of frames"
                                : "finished";
    }
  }

  void write_results() {
    require_written(outputs_.finish(result_.keyframes, result_.optimized));
    if (!inputs_.groundtruth.empty()) {
      ReportOptions options;
      options.groundtruth_frame = inputs_.camera.groundtruth_frame;
      result_.report = make_report(inputs_.groundtruth, result_.trajectory, options);
      result_.optimized_report = make_report(inputs_.groundtruth, result_.optimized, options);
    }
    const std::string picture_file = outputs_.path(kPictureFile);
    result_.picture = result_.trajectory.empty()
                          ? FileStatus::failure(StatusCode::kInsufficientData, picture_file, 0,
                                                "nothing was tracked")
                          : write_trajectory_plot(make_run_plot(inputs_, result_), picture_file);
    if (!result_.picture.ok() && !result_.trajectory.empty()) {
      warn("the picture is not written: " + result_.picture.message());
    }
    const std::string page_file = outputs_.path(kReportFile);
    result_.page =
        with_report_
            ? write_file_atomically(page_file, run_report_page(inputs_, result_, features_))
            : FileStatus::failure(StatusCode::kNotRun, page_file, 0, "--no-report was given");
    if (with_report_) require_written(result_.page);
    require_written(
        write_file_atomically(outputs_.path(kSummaryFile), summary_json_text(inputs_, result_)));
  }

  void require_written(const FileStatus& status) {
    if (status.ok() || result_.exit_code == kExitFailure) return;
    result_.exit_code = kExitFailure;
    result_.exit_reason = status.message();
  }

  const RunInputs& inputs_;
  bool with_report_;
  ReferencePipeline pipeline_;
  ProgressLine progress_;
  RunOutputs outputs_;
  FeatureStore features_;
  RunResult result_;
};

}  // namespace

int run_command(const RunSettings& settings) {
  install_stop_signals();
  RunInputs inputs;
  const std::string reason = load_run_inputs(settings, &inputs);
  if (!reason.empty()) return error_exit(kExitUsage, reason);
  if (!settings.quiet) std::cout << describe_run_inputs(inputs) << std::flush;
  Run run(inputs, !settings.without_report, settings.quiet);
  const FileStatus opened = run.open();
  if (!opened.ok()) return error_exit(kExitUsage, opened.message());
  return run.execute();
}

}  // namespace srslam::cli
