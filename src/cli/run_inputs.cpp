#include "cli/run_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "cli/number_text.hpp"
#include "cli/pipeline_config.hpp"
#include "cli/text_list.hpp"
#include "cli/trajectory_report.hpp"
#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNone = "none";

bool exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

std::string name_of_folder(const std::string& folder) {
  std::error_code error;
  fs::path path = fs::weakly_canonical(folder, error);
  if (error || path.empty()) path = fs::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  const std::string name = path.filename().string();
  return name.empty() || name == "." ? "dataset" : name;
}

std::string open_dataset(const RunSettings& settings, RunInputs* inputs) {
  TumDatasetOptions options;
  options.association_file = settings.association_file;
  const FileStatus status = TumDataset::open(settings.dataset_folder, options, &inputs->dataset);
  if (!status.ok()) return status.message();
  inputs->dataset_name = name_of_folder(settings.dataset_folder);
  inputs->num_frames =
      std::min(inputs->dataset.size(), settings.max_frames.value_or(inputs->dataset.size()));
  return {};
}

std::string load_camera(const RunSettings& settings, RunInputs* inputs) {
  std::string camera = settings.camera;
  if (camera.empty()) {
    camera = inputs->dataset.camera_file();
    if (camera.empty()) {
      return "no camera: the dataset folder has no camera.yaml; give --camera with a preset (" +
             joined(camera_preset_names()) + ") or a camera file (format: docs/camera_file.md)";
    }
  }
  std::string reason = read_camera(camera, &inputs->camera);
  if (!reason.empty()) return reason;
  inputs->camera_depth_units_per_m = inputs->camera.depth_units_per_m;
  if (settings.depth_scale) {
    inputs->camera.depth_units_per_m = *settings.depth_scale;
    inputs->depth_scale_overridden = true;
    const Status valid = inputs->camera.validate();
    if (!valid.ok())
      return "--depth-scale " + shortest_text(*settings.depth_scale) + ": " + valid.reason;
  }
  if (!settings.groundtruth_frame.empty() &&
      !parse_groundtruth_frame(settings.groundtruth_frame, &inputs->camera.groundtruth_frame)) {
    return "--groundtruth-frame '" + settings.groundtruth_frame +
           "' is unknown: give camera or bonn_marker";
  }
  return {};
}

std::string load_detections(const RunSettings& settings, RunInputs* inputs) {
  if (settings.detections == kNone) return {};
  inputs->detections_file =
      settings.detections.empty() ? inputs->dataset.detections_file() : settings.detections;
  if (inputs->detections_file.empty()) return {};
  const FileStatus status = read_detections(inputs->detections_file, &inputs->detections);
  if (status.ok()) return {};
  return status.message() + " (--detections none runs without)";
}

std::string load_groundtruth(const RunSettings& settings, RunInputs* inputs) {
  if (settings.groundtruth == kNone) return {};
  inputs->groundtruth_file =
      settings.groundtruth.empty() ? inputs->dataset.groundtruth_file() : settings.groundtruth;
  if (inputs->groundtruth_file.empty()) return {};
  // The TUM benchmark publishes ground truth with repeated lines, and its tools take the last.
  TrajectoryReadOptions options;
  options.keep_last_of_repeated = true;
  const FileStatus status = read_trajectory(inputs->groundtruth_file, &inputs->groundtruth, options,
                                            &inputs->num_repeated_groundtruth);
  if (status.ok()) return {};
  return status.message() + " (--groundtruth none runs without)";
}

std::string load_options(const RunSettings& settings, RunInputs* inputs) {
  inputs->modules = default_modules(known_modules());
  if (settings.modules) {
    const std::string reason = parse_modules(*settings.modules, known_modules(), &inputs->modules);
    if (!reason.empty()) return "--modules: " + reason;
  }
  if (!settings.config_file.empty()) {
    const FileStatus status = read_pipeline_config(settings.config_file, &inputs->options);
    if (!status.ok()) return status.message();
  }
  inputs->options.scene.enabled = inputs->modules.has('S');
  inputs->options.culling.enabled = inputs->modules.has('D');
  if (settings.num_threads) inputs->options.num_threads = *settings.num_threads;
  const Status valid = inputs->options.validate();
  return valid.ok() ? std::string() : std::string("pipeline options: ") + valid.reason;
}

}  // namespace

bool is_camera_preset(const std::string& camera) {
  const std::vector<std::string> presets = camera_preset_names();
  return std::find(presets.begin(), presets.end(), camera) != presets.end();
}

std::string read_camera(const std::string& camera, RgbdCamera* result) {
  if (is_camera_preset(camera)) return camera_preset(camera, result).message();
  if (!exists(camera)) {
    return "--camera '" + camera + "' is neither a preset (" + joined(camera_preset_names()) +
           ") nor an existing camera file";
  }
  return read_camera_file(camera, result).message();
}

std::string load_run_inputs(const RunSettings& settings, RunInputs* inputs) {
  // What the command line alone decides comes first: it is the quickest to put right.
  for (const auto load :
       {load_options, open_dataset, load_camera, load_detections, load_groundtruth}) {
    std::string reason = load(settings, inputs);
    if (!reason.empty()) return reason;
  }
  inputs->output_folder = settings.output_folder.empty()
                              ? (fs::path("srslam_output") / inputs->dataset_name).string()
                              : settings.output_folder;
  return {};
}

PipelineFrame pipeline_frame(const LoadedFrame& loaded, const RunInputs& inputs) {
  PipelineFrame frame;
  frame.timestamp_s = loaded.timestamp_s;
  frame.gray = loaded.gray.view();
  frame.depth_m = loaded.depth_m.view();
  const std::size_t detections =
      find_detections(inputs.detections, loaded.timestamp_s, kDetectionTolerance_s);
  if (detections < inputs.detections.size()) {
    frame.detections = inputs.detections[detections].detections;
    frame.has_detections = true;
  }
  return frame;
}

std::string describe_run_inputs(const RunInputs& inputs) {
  const AssociationReport& association = inputs.dataset.association();
  std::string text;
  text += "dataset:      " + inputs.dataset.folder() + ": " + std::to_string(inputs.num_frames) +
          " of " + std::to_string(association.num_color) + " colour frames to process; " +
          std::to_string(association.num_with_depth) + " have depth within " +
          fixed_text(inputs.dataset.options().max_time_difference_s * 1e3, 0) + " ms (largest " +
          fixed_text(association.max_time_difference_s * 1e3, 1) + " ms, " +
          std::to_string(association.num_shared_depth) + " share a depth image)\n";
  text += "camera:       " + inputs.camera.name + ", " +
          std::to_string(inputs.camera.camera.width_px) + "x" +
          std::to_string(inputs.camera.camera.height_px) + " px, depth scale " +
          shortest_text(inputs.camera.depth_units_per_m) + " per metre";
  if (inputs.depth_scale_overridden) {
    text +=
        " (--depth-scale; the camera says " + shortest_text(inputs.camera_depth_units_per_m) + ")";
  }
  text += "\nmodules:      " + inputs.modules.text() +
          (inputs.modules.letters.empty() ? " (baseline)" : "") + "\n";
  text += "detections:   ";
  if (inputs.detections_file.empty()) {
    text += kNone;
  } else {
    text += inputs.detections_file + ", " + std::to_string(inputs.detections.size()) + " frames";
    if (!inputs.modules.has('D')) text += " (these modules do not mask by them)";
  }
  text += "\nground truth: ";
  if (inputs.groundtruth_file.empty()) {
    text += kNone;
  } else {
    text += inputs.groundtruth_file + ", " + std::to_string(inputs.groundtruth.size()) +
            " poses of the frame '" + groundtruth_frame_name(inputs.camera.groundtruth_frame) + "'";
    if (inputs.num_repeated_groundtruth > 0) {
      text += ", " + std::to_string(inputs.num_repeated_groundtruth) +
              " lines with a repeated time stamp dropped";
    }
  }
  return text + "\noutput:       " + inputs.output_folder + "\n";
}

}  // namespace srslam::cli
