#include "cli/run_result.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/library_versions.hpp"
#include "cli/number_text.hpp"
#include "cli/pipeline_config.hpp"
#include "cli/run_outputs.hpp"

namespace srslam::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Times that every frame has.
SampleStatistics record_statistics(const RunResult& result, double FrameRecord::*field) {
  std::vector<double> times_ms;
  for (const FrameRecord& record : result.records) times_ms.push_back(record.*field);
  return summarize(std::move(times_ms));
}

Json times_json(const SampleStatistics& statistics) {
  return Json{{"frames", statistics.count},
              {"median_ms", statistics.median},
              {"p95_ms", statistics.p95},
              {"mean_ms", statistics.mean},
              {"max_ms", statistics.max}};
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

double frames_per_second(const RunResult& result) {
  return result.wall_s > 0.0 ? static_cast<double>(result.records.size()) / result.wall_s : 0.0;
}

Json camera_json(const RunInputs& inputs) {
  const PinholeCamera& camera = inputs.camera.camera;
  return Json{{"name", inputs.camera.name},
              {"width_px", camera.width_px},
              {"height_px", camera.height_px},
              {"fx_px", camera.fx_px},
              {"fy_px", camera.fy_px},
              {"cx_px", camera.cx_px},
              {"cy_px", camera.cy_px},
              {"k1", camera.k1},
              {"k2", camera.k2},
              {"p1", camera.p1},
              {"p2", camera.p2},
              {"k3", camera.k3},
              {"depth_units_per_m", inputs.camera.depth_units_per_m},
              {"depth_scale_overridden", inputs.depth_scale_overridden}};
}

Json association_json(const RunInputs& inputs) {
  const AssociationReport& association = inputs.dataset.association();
  return Json{{"num_color", association.num_color},
              {"num_depth", association.num_depth},
              {"num_color_with_depth", association.num_with_depth},
              {"num_color_sharing_depth", association.num_shared_depth},
              {"allowed_time_difference_s", inputs.dataset.options().max_time_difference_s},
              {"max_time_difference_s", association.max_time_difference_s}};
}

Json frames_json(const RunInputs& inputs, const RunResult& result) {
  const std::size_t num_with_depth = result.num_with_depth(inputs.dataset);
  const std::size_t num_tracked = result.count(FrameOutcome::kTracked);
  return Json{{"in_dataset", inputs.dataset.size()},
              {"to_process", inputs.num_frames},
              {"processed", result.records.size()},
              {"with_depth", num_with_depth},
              {"without_depth", result.count(FrameOutcome::kNoDepth)},
              {"damaged", result.count(FrameOutcome::kDamaged)},
              {"refused", result.count(FrameOutcome::kRefused)},
              {"tracked", num_tracked},
              {"lost", result.count(FrameOutcome::kLost)},
              {"not_initialized", result.count(FrameOutcome::kNotInitialized)},
              {"coverage", share(num_tracked, result.records.size())},
              {"coverage_with_depth", share(num_tracked, num_with_depth)}};
}

Json first_depth_json(const RunResult& result) {
  if (!result.first_depth) return nullptr;
  const Status plausible = check_depth_plausible(*result.first_depth);
  Json json{{"valid_share", result.first_depth->valid_share},
            {"median_m", result.first_depth->median_m},
            {"plausible", plausible.ok()}};
  if (!plausible.ok()) json["reason"] = plausible.reason;
  return json;
}

Json evaluation_json(const RunInputs& inputs, const RunResult& result) {
  if (!result.report || !result.optimized_report) return nullptr;
  return Json{{"groundtruth_file", inputs.groundtruth_file},
              {"groundtruth_frame", groundtruth_frame_name(inputs.camera.groundtruth_frame)},
              {"num_repeated_groundtruth_dropped", inputs.num_repeated_groundtruth},
              {kTrajectoryFile, report_json(*result.report)},
              {kOptimizedTrajectoryFile, report_json(*result.optimized_report)}};
}

Json timing_json(const RunInputs& inputs, const RunResult& result) {
  Json stages;
  for (const Stage& stage : kStages) {
    stages[stage.name] = times_json(stage_statistics(result, stage));
  }
  return Json{{"wall_s", result.wall_s},
              {"frames_per_s", frames_per_second(result)},
              {"includes", "decoding, tracking, mapping and writing of poses"},
              {"threads", inputs.options.num_threads},
              {"decode", times_json(record_statistics(result, &FrameRecord::decode_ms))},
              {"read_wait", times_json(record_statistics(result, &FrameRecord::read_wait_ms))},
              {"stages", stages}};
}

Json written_json(const FileStatus& status) {
  return status.ok() ? Json{{"written", true}}
                     : Json{{"written", false}, {"reason", status.reason}};
}

Json versions_json() {
  const LibraryVersions versions = library_versions();
  return Json{{"srslam", versions.srslam},
              {"eigen", versions.eigen},
              {"opencv", versions.opencv},
              {"ceres", versions.ceres},
              {"compiler", versions.compiler}};
}

Json machine_json() {
  const Machine machine = this_machine();
  return Json{{"cpu", machine.cpu}, {"logical_cores", machine.num_logical_cores}};
}

std::string percent(double share_of_one) { return fixed_text(100.0 * share_of_one, 1) + " %"; }

std::string ate_summary(const TrajectoryReport& report) {
  if (!report.ate.status.ok()) return std::string("not available: ") + report.ate.status.reason;
  return fixed_text(report.ate.translation_m.rmse, 4) + " m RMSE (" +
         to_string(report.ate.alignment) + "; " + std::to_string(report.ate.num_matched) + " of " +
         std::to_string(report.ate.num_estimate) + " poses matched; " + report.ate_groundtruth +
         ")";
}

std::string rpe_summary(const RpeResult& rpe, const std::string& groundtruth) {
  if (!rpe.status.ok()) return std::string("not available: ") + rpe.status.reason;
  return fixed_text(rpe.translation_m.rmse, 4) + " m, " + fixed_text(rpe.rotation_deg.rmse, 3) +
         " deg RMSE (" + std::to_string(rpe.num_pairs) + " pairs; " + groundtruth + ")";
}

std::string line(const std::string& label, const std::string& text) {
  constexpr std::size_t kLabelWidth = 16;
  return label + std::string(kLabelWidth - std::min(kLabelWidth, label.size()), ' ') + text + "\n";
}

}  // namespace

SampleStatistics stage_statistics(const RunResult& result, const Stage& stage) {
  std::vector<double> times_ms;
  times_ms.reserve(result.records.size());
  for (const FrameRecord& record : result.records) {
    const double time_ms = record.times.*stage.field;
    if (time_ms > 0.0) times_ms.push_back(time_ms);
  }
  return summarize(std::move(times_ms));
}

std::array<std::size_t, kNumFrameOutcomes> RunResult::counts() const {
  std::array<std::size_t, kNumFrameOutcomes> result = {};
  for (const FrameRecord& record : records) ++result[static_cast<std::size_t>(record.outcome)];
  return result;
}

std::size_t RunResult::count(FrameOutcome outcome) const {
  return counts()[static_cast<std::size_t>(outcome)];
}

std::size_t RunResult::num_with_depth(const TumDataset& dataset) const {
  return static_cast<std::size_t>(std::count_if(
      records.begin(), records.end(),
      [&dataset](const FrameRecord& record) { return dataset.entry(record.index).has_depth(); }));
}

std::string summary_json_text(const RunInputs& inputs, const RunResult& result) {
  Json json;
  json["exit_code"] = result.exit_code;
  json["exit_reason"] = result.exit_reason;
  json["dataset"] = Json{{"name", inputs.dataset_name}, {"folder", inputs.dataset.folder()}};
  json["camera"] = camera_json(inputs);
  json["association"] = association_json(inputs);
  json["modules"] = inputs.modules.text();
  json["detections"] = inputs.detections_file.empty()
                           ? Json(nullptr)
                           : Json{{"file", inputs.detections_file},
                                  {"frames", inputs.detections.size()},
                                  {"used_for_masking", inputs.modules.has('D')}};
  json["frames"] = frames_json(inputs, result);
  json["first_depth_image"] = first_depth_json(result);
  json["keyframes_in_map"] = result.keyframes.size();
  json["map_points"] = result.num_map_points;
  json["evaluation"] = evaluation_json(inputs, result);
  json["timing"] = timing_json(inputs, result);
  json["peak_memory_mib"] = peak_memory_mib();
  json["picture"] = written_json(result.picture);
  json["report"] = written_json(result.page);
  json["config_hash"] = config_hash(inputs.options);
  json["versions"] = versions_json();
  json["machine"] = machine_json();
  // Paths may hold bytes that are not UTF-8; they must not cost the summary.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string summary_text(const RunInputs& inputs, const RunResult& result) {
  const std::size_t num_tracked = result.count(FrameOutcome::kTracked);
  std::string text = line("Result", result.exit_reason);
  text += line("Frames tracked",
               std::to_string(num_tracked) + " of " + std::to_string(result.records.size()) + " (" +
                   percent(share(num_tracked, result.records.size())) + "); lost " +
                   std::to_string(result.count(FrameOutcome::kLost)) + ", not initialised " +
                   std::to_string(result.count(FrameOutcome::kNotInitialized)) +
                   ", without depth " + std::to_string(result.count(FrameOutcome::kNoDepth)) +
                   ", damaged " + std::to_string(result.count(FrameOutcome::kDamaged)) +
                   ", refused " + std::to_string(result.count(FrameOutcome::kRefused)));
  if (result.report && result.optimized_report) {
    text += line("ATE", ate_summary(*result.report));
    text += line("ATE, optimised", ate_summary(*result.optimized_report));
    text +=
        line("RPE, 1 frame", rpe_summary(result.report->rpe_frame, result.report->rpe_groundtruth));
    text +=
        line("RPE, 1 s", rpe_summary(result.report->rpe_second, result.report->rpe_groundtruth));
  } else {
    text += line("ATE, RPE", "no ground truth");
  }
  const SampleStatistics total = stage_statistics(result, kStages.back());
  text += line("Speed", fixed_text(frames_per_second(result), 1) +
                            " frames/s of wall time, decoding included (" +
                            std::to_string(inputs.options.num_threads) +
                            (inputs.options.num_threads == 1 ? " thread" : " threads") +
                            "); a frame takes " + fixed_text(total.median, 1) + " ms (median), " +
                            fixed_text(total.p95, 1) + " ms (95 %)");
  text += line("Peak memory", fixed_text(peak_memory_mib(), 0) + " MiB");
  text += line("Written to", inputs.output_folder);
  return text;
}

}  // namespace srslam::cli
