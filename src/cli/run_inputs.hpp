#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cli/modules.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "srslam/pipeline/pipeline_options.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::cli {

/// What the command line of `srslam run` says. Empty means not given.
struct RunSettings {
  std::string dataset_folder;
  std::string camera;                 ///< preset or file
  std::optional<double> depth_scale;  ///< raw depth value of one metre
  std::string detections;             ///< file or `none`
  std::string groundtruth;            ///< file or `none`
  std::string groundtruth_frame;      ///< `camera` or `bonn_marker`
  std::string association_file;
  std::optional<std::string> modules;
  std::string config_file;
  std::string output_folder;
  std::optional<std::size_t> max_frames;
  std::optional<int> num_threads;
  bool without_report = false;
  bool quiet = false;
};

/// Everything that a run reads before its first frame.
struct RunInputs {
  std::string dataset_name;  ///< last part of the folder's path
  TumDataset dataset;
  std::size_t num_frames = 0;  ///< to be processed
  RgbdCamera camera;
  bool depth_scale_overridden = false;
  double camera_depth_units_per_m = 0.0;  ///< before it was overridden
  std::string detections_file;            ///< empty: none
  std::vector<FrameDetections> detections;
  std::string groundtruth_file;  ///< empty: none
  Trajectory groundtruth;
  std::size_t num_repeated_groundtruth = 0;  ///< lines dropped for a repeated time stamp
  ModuleSelection modules;
  PipelineOptions options;
  std::string output_folder;
};

/// Detections belong to a colour frame when their time stamps differ by at most this.
constexpr double kDetectionTolerance_s = 0.02;

/// Whether `camera` is the name of a preset; it is a file otherwise.
bool is_camera_preset(const std::string& camera);

/// Reads what `--camera` names, a preset or a camera file. Returns an empty string or the reason.
std::string read_camera(const std::string& camera, RgbdCamera* result);

/// Reads and checks all inputs that `settings` names; nothing is written. Returns an empty string,
/// or what is wrong and what would be right.
std::string load_run_inputs(const RunSettings& settings, RunInputs* inputs);

/// A frame of the dataset, which must outlive it, with the detections that belong to it.
PipelineFrame pipeline_frame(const LoadedFrame& loaded, const RunInputs& inputs);

/// What the run is going to do, a few lines: also everything that was found rather than asked for.
std::string describe_run_inputs(const RunInputs& inputs);

}  // namespace srslam::cli
