#include "cli/program.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <exception>
#include <iostream>
#include <string>

#include "cli/calibrate_command.hpp"
#include "cli/campaign/campaign_command.hpp"
#include "cli/evaluate_command.hpp"
#include "cli/exit_code.hpp"
#include "cli/modules.hpp"
#include "cli/options_command.hpp"
#include "cli/run_command.hpp"
#include "cli/synth_command.hpp"
#include "cli/text_list.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/version.hpp"

namespace srslam::cli {
namespace {

constexpr const char* kCameraFrame = "camera";
constexpr const char* kMarkerFrame = "bonn_marker";

std::string preset_list() { return joined(camera_preset_names()); }

std::string module_list() {
  std::string text;
  for (const Module& module : known_modules()) {
    text += std::string(text.empty() ? "" : ", ") + module.letter + " " + module.name +
            (module.built ? "" : " (not built yet)");
  }
  return text;
}

CLI::App* add_run_command(CLI::App* program, RunSettings* settings) {
  CLI::App* run = program->add_subcommand(
      "run", "Estimate the camera's trajectory over a folder of RGB-D images in the TUM layout");
  run->add_option("--dataset", settings->dataset_folder,
                  "Folder with rgb.txt, depth.txt and what they list; groundtruth.txt, "
                  "detections.txt and camera.yaml are used when they are there")
      ->required()
      ->type_name("DIR");
  run->add_option("--camera", settings->camera,
                  "Camera preset (" + preset_list() +
                      ") or camera file; default: camera.yaml in the dataset folder")
      ->type_name("NAME|FILE");
  run->add_option("--depth-scale", settings->depth_scale,
                  "Raw depth value of one metre, in place of the camera's")
      ->type_name("X");
  run->add_option("--associations", settings->association_file,
                  "File of `t_color color_file t_depth depth_file` lines that pairs colour and "
                  "depth; default: paired by time")
      ->type_name("FILE");
  run->add_option("--detections", settings->detections,
                  "Detections file; default: detections.txt in the dataset folder if it is there")
      ->type_name("FILE|none");
  run->add_option("--groundtruth", settings->groundtruth,
                  "Ground truth; default: groundtruth.txt in the dataset folder if it is there")
      ->type_name("FILE|none");
  run->add_option("--groundtruth-frame", settings->groundtruth_frame,
                  "What the ground truth's poses describe; default: as the camera says")
      ->check(CLI::IsMember({kCameraFrame, kMarkerFrame}).description(""))
      ->type_name("camera|bonn_marker");
  run->add_option("--modules", settings->modules,
                  "none for the baseline, or letters separated by commas: " + module_list() +
                      "; default: every module that is built (" +
                      default_modules(known_modules()).text() + ")")
      ->type_name("none|S,P,D,B");
  run->add_option("--config", settings->config_file,
                  "Pipeline options, `key: value` a line; `srslam options` lists them")
      ->type_name("FILE");
  run->add_option("--output", settings->output_folder,
                  "Folder for the results, made if need be; default: srslam_output/<dataset>")
      ->type_name("DIR");
  run->add_option("--max-frames", settings->max_frames, "Stop after so many colour frames")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->type_name("N");
  run->add_option("--threads", settings->num_threads,
                  "1: everything in one thread; 2: decoding and bundle adjustment beside "
                  "tracking; the result is the same. Takes precedence over --config")
      ->check(CLI::Range(1, 2).description(""))
      ->type_name("1|2");
  run->add_flag("--no-report", settings->without_report, "Do not write report.html");
  run->add_flag("--quiet", settings->quiet,
                "No description of the inputs and no progress line; warnings remain");
  return run;
}

CLI::App* add_evaluate_command(CLI::App* program, EvaluateSettings* settings,
                               std::string* groundtruth_frame, std::string* rpe_definition,
                               bool* with_scale) {
  CLI::App* evaluate = program->add_subcommand(
      "evaluate", "Absolute and relative errors of a trajectory against ground truth");
  evaluate
      ->add_option("--groundtruth", settings->groundtruth_file,
                   "Trajectory in TUM format: `timestamp tx ty tz qx qy qz qw` a line")
      ->required()
      ->type_name("FILE");
  evaluate->add_option("--estimate", settings->estimate_file, "Trajectory in TUM format")
      ->required()
      ->type_name("FILE");
  evaluate->add_flag("--json", settings->json, "Print JSON instead of tables");
  evaluate
      ->add_option("--max-time-difference", settings->report.association.max_time_difference_s,
                   "Poses match when their time stamps differ by less than this [s]")
      ->capture_default_str()
      ->type_name("X");
  evaluate
      ->add_option("--offset", settings->report.association.estimate_time_offset_s,
                   "Added to the estimate's time stamps [s]")
      ->capture_default_str()
      ->type_name("X");
  evaluate->add_flag("--scale", *with_scale,
                     "Align the absolute error with scale (Sim3) instead of without (SE3)");
  evaluate
      ->add_option("--groundtruth-frame", *groundtruth_frame,
                   "What the ground truth's poses describe; those of the BONN marker are carried "
                   "into the camera's frame for relative errors")
      ->check(CLI::IsMember({kCameraFrame, kMarkerFrame}).description(""))
      ->capture_default_str()
      ->type_name("camera|bonn_marker");
  evaluate
      ->add_option("--rpe", *rpe_definition,
                   "Pairs of the relative error: among matched poses, or as the TUM benchmark's "
                   "tool forms them (docs/evaluation.md)")
      ->check(CLI::IsMember({"matched_poses", "tum_tool"}).description(""))
      ->capture_default_str()
      ->type_name("matched_poses|tum_tool");
  return evaluate;
}

CLI::App* add_synth_command(CLI::App* program, SynthSettings* settings) {
  CLI::App* synth = program->add_subcommand(
      "synth", "Render an RGB-D sequence of a room with moving people, ground truth included");
  synth->add_flag("--list", settings->list, "Print the scenarios and what happens in them");
  synth->add_option("--scenario", settings->scenario, "Which one")->type_name("NAME");
  synth->add_option("--output", settings->output_folder, "Folder for the sequence")
      ->type_name("DIR");
  synth->add_option("--seed", settings->seed, "Other looks, ways and noise; same seed, same bytes")
      ->capture_default_str()
      ->type_name("N");
  synth->add_option("--frames", settings->num_frames, "Length, at 30 frames a second")
      ->capture_default_str()
      ->type_name("N");
  synth->add_option("--width", settings->width_px, "Image width [px]")
      ->capture_default_str()
      ->type_name("W");
  synth->add_option("--height", settings->height_px, "Image height [px]")
      ->capture_default_str()
      ->type_name("H");
  synth->add_option("--camera", settings->camera, "Camera preset: " + preset_list())
      ->capture_default_str()
      ->type_name("NAME");
  synth->add_flag("--clean", settings->sensor.clean,
                  "A perfect sensor: no noise, holes, vignetting");
  synth
      ->add_option("--exposure-change", settings->sensor.exposure_change,
                   "Slow changes of the brightness, as a share of it (0 to 0.9)")
      ->capture_default_str()
      ->type_name("X");
  synth
      ->add_option("--exposure-time", settings->sensor.exposure_time_s,
                   "Motion blur over this time [s]; seven times slower")
      ->capture_default_str()
      ->type_name("X");
  synth->add_flag("--flow", settings->flow, "Also write the optical flow to the next frame");
  synth->add_flag("--jpeg", settings->jpeg, "Colour as JPEG instead of PNG, a quarter of the size");
  synth->add_flag("--overwrite", settings->overwrite, "Replace the sequence that the folder holds");
  synth
      ->add_option("--threads", settings->num_threads,
                   "Frames rendered side by side; the result is the same; default: one a core")
      ->check(CLI::Range(1, 256).description(""))
      ->type_name("N");
  synth->add_flag("--quiet", settings->quiet, "No progress line and no summary");
  return synth;
}

CLI::App* add_calibrate_command(CLI::App* program, CalibrateSettings* settings) {
  CLI::App* calibrate = program->add_subcommand(
      "calibrate",
      "Set residual scale and threshold of the scene reliability from sequences in which nothing "
      "moves but the camera");
  calibrate
      ->add_option("--dataset", settings->dataset_folders,
                   "Folders in the TUM layout, one or more, of the camera that is to be used")
      ->required()
      ->type_name("DIR...");
  calibrate
      ->add_option("--camera", settings->camera,
                   "Camera preset (" + preset_list() +
                       ") or camera file; default: camera.yaml in each folder")
      ->type_name("NAME|FILE");
  calibrate
      ->add_option("--config", settings->config_file,
                   "Pipeline options to start from; all others are kept")
      ->type_name("FILE");
  calibrate
      ->add_option("--output", settings->output_file,
                   "Configuration to write, for `srslam run --config`; a picture of the "
                   "distributions goes beside it")
      ->required()
      ->type_name("FILE");
  calibrate->add_option("--max-frames", settings->max_frames, "Read so many frames of each folder")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->type_name("N");
  calibrate->add_flag("--extremes", settings->extremes,
                      "The largest residual and the smallest reliability, as in the paper, in "
                      "place of percentiles");
  calibrate
      ->add_option("--residual-percentile", settings->calibration.residual_percentile,
                   "Of the motion residuals: becomes the residual scale")
      ->capture_default_str()
      ->type_name("X");
  calibrate
      ->add_option("--reliability-percentile", settings->calibration.reliability_percentile,
                   "Of the reliabilities: becomes the threshold")
      ->capture_default_str()
      ->type_name("X");
  calibrate->add_flag("--quiet", settings->quiet, "No progress line");
  return calibrate;
}

int dispatch(int argc, const char* const* argv) {
  CLI::App program("srslam: RGB-D SLAM over folders of images, and the evaluation of trajectories",
                   "srslam");
  program.set_version_flag("--version", std::string("srslam ") + SRSLAM_VERSION_STRING);
  program.require_subcommand(1);
  program.footer(
      "`srslam COMMAND --help` explains a command. Exit codes: 0 done, 1 failed, 2 wrong "
      "command line or input, 128 + signal when interrupted.");

  RunSettings run_settings;
  const CLI::App* run = add_run_command(&program, &run_settings);

  EvaluateSettings evaluate_settings;
  std::string groundtruth_frame = kCameraFrame;
  std::string rpe_definition = "matched_poses";
  bool with_scale = false;
  const CLI::App* evaluate = add_evaluate_command(&program, &evaluate_settings, &groundtruth_frame,
                                                  &rpe_definition, &with_scale);

  SynthSettings synth_settings;
  const CLI::App* synth = add_synth_command(&program, &synth_settings);

  CampaignSettings campaign_settings;
  const CLI::App* campaign = add_campaign_command(&program, &campaign_settings);

  CalibrateSettings calibrate_settings;
  const CLI::App* calibrate = add_calibrate_command(&program, &calibrate_settings);

  OptionsSettings options_settings;
  CLI::App* options = program.add_subcommand(
      "options", "Every pipeline option with value, range, unit and meaning");
  options->add_option("--config", options_settings.config_file, "Show the values of this file")
      ->type_name("FILE");
  options->add_flag("--yaml", options_settings.yaml,
                    "Print a configuration file, to be edited and given to run --config");

  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  if (run->parsed()) return run_command(run_settings);
  if (synth->parsed()) return synth_command(synth_settings);
  if (calibrate->parsed()) return calibrate_command(calibrate_settings);
  if (campaign->parsed()) return campaign_command(campaign_settings);
  if (options->parsed()) return options_command(options_settings);
  if (with_scale) evaluate_settings.report.alignment = Alignment::kSim3;
  if (rpe_definition == "tum_tool") {
    evaluate_settings.report.rpe_definition = RpeDefinition::kTumTool;
  }
  parse_groundtruth_frame(groundtruth_frame, &evaluate_settings.report.groundtruth_frame);
  return evaluate->parsed() ? evaluate_command(evaluate_settings) : kExitUsage;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  try {
    return dispatch(argc, argv);
  } catch (const std::exception& error) {
    // Nothing of srslam throws; this is memory that ran out and the like.
    std::cerr << "srslam: error: " << error.what() << std::endl;
    return kExitFailure;
  }
}

}  // namespace srslam::cli
