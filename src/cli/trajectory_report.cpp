#include "cli/trajectory_report.hpp"

#include <algorithm>

#include "cli/number_text.hpp"
#include "srslam/io/bonn_groundtruth.hpp"

namespace srslam::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMillisecondsPerSecond = 1e3;

RpeResult relative_error(const Trajectory& groundtruth, const Trajectory& estimate,
                         const ReportOptions& options, RpeDelta unit) {
  RpeOptions rpe;
  rpe.delta = 1.0;
  rpe.unit = unit;
  rpe.definition = options.rpe_definition;
  rpe.association = options.association;
  return relative_pose_error(groundtruth, estimate, rpe);
}

const char* definition_name(RpeDefinition definition) {
  return definition == RpeDefinition::kTumTool ? "tum_tool" : "matched_poses";
}

std::string delta_text(const RpeResult& rpe) {
  return fixed_text(rpe.delta, 0) + (rpe.unit == RpeDelta::kFrames ? " frame" : " s");
}

Json statistics_json(const ErrorStatistics& statistics) {
  return Json{{"rmse", statistics.rmse}, {"mean", statistics.mean}, {"median", statistics.median},
              {"std", statistics.std},   {"min", statistics.min},   {"max", statistics.max}};
}

Json status_json(const Status& status) {
  Json json{{"status", to_string(status.code)}};
  if (!status.ok()) json["reason"] = status.reason;
  return json;
}

Json ate_json(const AteResult& ate, const std::string& groundtruth) {
  Json json = status_json(ate.status);
  json["groundtruth"] = groundtruth;
  json["alignment"] = to_string(ate.alignment);
  json["num_matched"] = ate.num_matched;
  json["num_estimate"] = ate.num_estimate;
  json["num_groundtruth"] = ate.num_reference;
  json["max_time_difference_s"] = ate.max_abs_time_difference_s;
  if (!ate.status.ok()) return json;
  json["translation_m"] = statistics_json(ate.translation_m);
  json["scale"] = ate.scale;
  json["collinear"] = ate.collinear;
  json["fixed_camera"] = ate.fixed_camera;
  json["groundtruth_rms_displacement_m"] = ate.reference_rms_displacement_m;
  json["estimate_rms_displacement_m"] = ate.estimate_rms_displacement_m;
  return json;
}

Json rpe_json(const RpeResult& rpe, const std::string& groundtruth) {
  Json json = status_json(rpe.status);
  json["groundtruth"] = groundtruth;
  json["delta"] = rpe.delta;
  json["delta_unit"] = rpe.unit == RpeDelta::kFrames ? "frames" : "seconds";
  json["definition"] = definition_name(rpe.definition);
  json["num_pairs"] = rpe.num_pairs;
  json["num_matched"] = rpe.num_matched;
  json["num_estimate"] = rpe.num_estimate;
  json["num_groundtruth"] = rpe.num_reference;
  json["max_time_difference_s"] = rpe.max_abs_time_difference_s;
  if (!rpe.status.ok()) return json;
  json["median_interval_s"] = rpe.median_interval_s;
  json["max_interval_s"] = rpe.max_interval_s;
  json["translation_m"] = statistics_json(rpe.translation_m);
  json["rotation_deg"] = statistics_json(rpe.rotation_deg);
  return json;
}

std::string right_aligned(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, text.size()), ' ') + text;
}

constexpr std::size_t kLabelWidth = 20;
constexpr std::size_t kNumberWidth = 11;

std::string table_header() {
  std::string line(kLabelWidth, ' ');
  for (const char* name : {"rmse", "mean", "median", "std", "min", "max"}) {
    line += right_aligned(name, kNumberWidth);
  }
  return line + "\n";
}

std::string table_row(const std::string& label, const ErrorStatistics& statistics) {
  std::string line = "  " + label;
  line.resize(kLabelWidth, ' ');
  for (const double value : {statistics.rmse, statistics.mean, statistics.median, statistics.std,
                             statistics.min, statistics.max}) {
    line += right_aligned(fixed_text(value, 6), kNumberWidth);
  }
  return line + "\n";
}

std::string matched_text(std::size_t num_matched, std::size_t num_estimate,
                         std::size_t num_groundtruth, double max_time_difference_s) {
  return std::to_string(num_matched) + " of " + std::to_string(num_estimate) +
         " estimated poses matched (ground truth: " + std::to_string(num_groundtruth) +
         " poses), largest time difference " +
         fixed_text(max_time_difference_s * kMillisecondsPerSecond, 1) + " ms";
}

std::string ate_text(const AteResult& ate, const std::string& groundtruth) {
  std::string text = "Absolute trajectory error, alignment " +
                     std::string(to_string(ate.alignment)) + ", ground truth: " + groundtruth +
                     "\n";
  text += "  " +
          matched_text(ate.num_matched, ate.num_estimate, ate.num_reference,
                       ate.max_abs_time_difference_s) +
          "\n";
  if (!ate.status.ok()) return text + "  not available: " + ate.status.reason + "\n";
  text += table_header() + table_row("translation [m]", ate.translation_m);
  if (ate.alignment == Alignment::kSim3) {
    text += "  scale of the alignment: " + fixed_text(ate.scale, 6) + "\n";
  }
  if (ate.collinear) {
    text +=
        "  note: the path lies on a line or in one place; a rotation of the alignment is "
        "arbitrary\n";
  }
  if (ate.fixed_camera) {
    text +=
        "  note: the camera is fixed, so the alignment hides most of the error; RMS "
        "displacement from the mean: estimate " +
        fixed_text(ate.estimate_rms_displacement_m, 6) + " m, ground truth " +
        fixed_text(ate.reference_rms_displacement_m, 6) + " m\n";
  }
  return text;
}

std::string rpe_text(const RpeResult& rpe, const std::string& groundtruth) {
  std::string text = "Relative pose error over " + delta_text(rpe) + " (" +
                     definition_name(rpe.definition) + "), ground truth: " + groundtruth + "\n";
  text += "  " + std::to_string(rpe.num_pairs) + " pairs; " +
          matched_text(rpe.num_matched, rpe.num_estimate, rpe.num_reference,
                       rpe.max_abs_time_difference_s) +
          "\n";
  if (!rpe.status.ok()) return text + "  not available: " + rpe.status.reason + "\n";
  text += "  time between the poses of a pair: median " + fixed_text(rpe.median_interval_s, 3) +
          " s, largest " + fixed_text(rpe.max_interval_s, 3) + " s\n";
  text += table_header() + table_row("translation [m]", rpe.translation_m) +
          table_row("rotation [deg]", rpe.rotation_deg);
  return text;
}

}  // namespace

TrajectoryReport make_report(const Trajectory& groundtruth, const Trajectory& estimate,
                             const ReportOptions& options) {
  TrajectoryReport report;
  AteOptions ate;
  ate.alignment = options.alignment;
  ate.association = options.association;
  report.ate = absolute_trajectory_error(groundtruth, estimate, ate);
  const bool is_marker = options.groundtruth_frame == GroundtruthFrame::kBonnMarker;
  report.ate_groundtruth =
      std::string(groundtruth_frame_name(options.groundtruth_frame)) + " poses as published";
  report.rpe_groundtruth =
      is_marker ? "camera poses converted from bonn_marker" : report.ate_groundtruth;
  const Trajectory converted =
      is_marker ? camera_trajectory_from_bonn_marker(groundtruth) : Trajectory();
  const Trajectory& camera_poses = is_marker ? converted : groundtruth;
  report.rpe_frame = relative_error(camera_poses, estimate, options, RpeDelta::kFrames);
  report.rpe_second = relative_error(camera_poses, estimate, options, RpeDelta::kSeconds);
  return report;
}

const char* groundtruth_frame_name(GroundtruthFrame frame) {
  return frame == GroundtruthFrame::kBonnMarker ? "bonn_marker" : "camera";
}

bool parse_groundtruth_frame(const std::string& name, GroundtruthFrame* frame) {
  for (const GroundtruthFrame known : {GroundtruthFrame::kCamera, GroundtruthFrame::kBonnMarker}) {
    if (name != groundtruth_frame_name(known)) continue;
    *frame = known;
    return true;
  }
  return false;
}

nlohmann::ordered_json report_json(const TrajectoryReport& report) {
  return Json{{"ate", ate_json(report.ate, report.ate_groundtruth)},
              {"rpe_1_frame", rpe_json(report.rpe_frame, report.rpe_groundtruth)},
              {"rpe_1_s", rpe_json(report.rpe_second, report.rpe_groundtruth)}};
}

std::string report_text(const TrajectoryReport& report) {
  return ate_text(report.ate, report.ate_groundtruth) + "\n" +
         rpe_text(report.rpe_frame, report.rpe_groundtruth) + "\n" +
         rpe_text(report.rpe_second, report.rpe_groundtruth);
}

}  // namespace srslam::cli
