#include "cli/calibrate_command.hpp"

#include <filesystem>
#include <iostream>
#include <system_error>

#include "cli/exit_code.hpp"
#include "cli/gnuplot.hpp"
#include "cli/number_text.hpp"
#include "cli/pipeline_config.hpp"
#include "cli/progress_line.hpp"
#include "cli/run_inputs.hpp"
#include "cli/stop_signal.hpp"
#include "cli/text_file.hpp"
#include "srslam/core/nearest_rank.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

/// Adds the terms of every frame of one dataset. Returns an empty string or the reason.
std::string judge_frames(const RunInputs& inputs, ProgressLine* progress,
                         std::vector<ReliabilityTerms>* terms) {
  ReferencePipeline pipeline(inputs.camera.camera, inputs.options);
  if (!pipeline.status().ok()) return inputs.dataset_name + ": " + pipeline.status().reason;
  FrameReader reader(inputs.dataset, inputs.camera, 0, inputs.num_frames);
  LoadedFrame loaded;
  std::size_t num_done = 0;
  while (requested_stop_signal() == 0 && reader.next(&loaded)) {
    progress->update(
        progress_text(++num_done, inputs.num_frames, progress->elapsed_s(), inputs.dataset_name));
    if (!loaded.status.ok()) {
      progress->message("srslam: warning: frame " + std::to_string(loaded.index) +
                        " is skipped: " + loaded.status.message());
      continue;
    }
    if (!loaded.has_depth) continue;
    const PipelineResult result = pipeline.process(pipeline_frame(loaded, inputs));
    if (result.has_scene) terms->push_back(result.scene.terms);
  }
  return {};
}

/// Share of values up to each one, as data of gnuplot.
std::string distribution_data(const std::string& name, const std::vector<double>& sorted) {
  std::string text = "$" + name + " << END_OF_DATA\n";
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    text += shortest_text(sorted[i]) + " " +
            shortest_text(100.0 * double(i + 1) / double(sorted.size())) + "\n";
  }
  return text + "END_OF_DATA\n";
}

std::string distribution_panel(const PlotBox& box, const std::string& title,
                               const std::string& label, const std::string& data, double chosen,
                               const std::string& chosen_label) {
  constexpr const char* kChosenColor = "#b2377a";
  const std::string at = shortest_text(chosen);
  return gnuplot_box(box, title) + "set xlabel " + gnuplot_quoted(label) +
         "\nset ylabel 'frames up to this [%]'\nset yrange [0:102]\nset xrange [0:*]\n" +
         "set key off\nunset arrow\nset grid\nset arrow from " + at + ", graph 0 to " + at +
         ", graph 1 nohead lw 2 dt 2 lc rgb '" + kChosenColor + "'\nset label 2 " +
         gnuplot_quoted("dashed: " + chosen_label) + " at graph 0.4, graph 0.15 textcolor rgb '" +
         kChosenColor + "'\nplot $" + data + " using 1:2 with steps lw 2 lc rgb '#1f4e9c'\n" +
         "unset label 2\n";
}

FileStatus write_picture(const CalibrationResult& result, const std::string& file) {
  constexpr const char* kName = "calibration.png";
  const std::string script =
      distribution_data("residuals", result.residuals_px) +
      distribution_data("reliabilities", result.reliabilities) +
      gnuplot_picture(PlotFormat::kPng, 1200, 480, kName) + "set multiplot\n" +
      distribution_panel({0.07, 0.48, 0.16, 0.88},
                         "Motion residual of " + std::to_string(result.num_frames) + " frames",
                         "R_r [px at 640 px width]", "residuals", result.residual_scale_px,
                         "R_cb = " + fixed_text(result.residual_scale_px, 2) + " px") +
      distribution_panel({0.57, 0.98, 0.16, 0.88}, "Their reliability with that scale", "R",
                         "reliabilities", result.threshold,
                         "th_scene = " + fixed_text(result.threshold, 3)) +
      "unset multiplot\n";
  std::vector<std::string> contents;
  const FileStatus drawn =
      run_gnuplot(script, fs::path(file).parent_path().string(), file, {kName}, &contents);
  return drawn.ok() ? write_file_atomically(file, contents.front()) : drawn;
}

std::string summary_text(const CalibrationResult& result, const std::string& config_file,
                         const std::string& picture) {
  std::string text = "frames judged:  " + std::to_string(result.num_frames) + "\n";
  text += "motion residual: median " + fixed_text(nearest_rank(result.residuals_px, 50.0), 2) +
          " px, largest " + fixed_text(result.residuals_px.back(), 2) + " px\n";
  text += "reliability:     median " + fixed_text(nearest_rank(result.reliabilities, 50.0), 3) +
          ", smallest " + fixed_text(result.reliabilities.front(), 3) + "\n";
  text += "residual scale:  " + fixed_text(result.residual_scale_px, 4) + " px (" +
          fixed_text(100.0 * result.high_motion_share, 1) + " % of the frames above)\n";
  text += "threshold:       " + fixed_text(result.threshold, 4) + " (" +
          fixed_text(100.0 * result.good_share, 1) + " % of the frames GOOD)\n";
  text += "configuration:   " + config_file + "\n";
  if (!picture.empty()) text += "picture:         " + picture + "\n";
  return text;
}

}  // namespace

int calibrate_command(const CalibrateSettings& settings) {
  if (settings.output_file.empty()) return error_exit(kExitUsage, "--output FILE is needed");
  const fs::path output(settings.output_file);
  std::error_code error;
  if (output.has_parent_path() && !fs::is_directory(output.parent_path(), error)) {
    return error_exit(kExitUsage,
                      "--output: the folder " + output.parent_path().string() + " does not exist");
  }
  CalibrationOptions calibration = settings.calibration;
  if (settings.extremes) calibration.rule = CalibrationRule::kExtremes;
  const Status valid = calibration.validate();
  if (!valid.ok()) return error_exit(kExitUsage, valid.reason);

  install_stop_signals();
  std::vector<ReliabilityTerms> terms;
  PipelineOptions options;
  ProgressLine progress(!settings.quiet);
  for (const std::string& folder : settings.dataset_folders) {
    RunSettings run;
    run.dataset_folder = folder;
    run.camera = settings.camera;
    run.config_file = settings.config_file;
    run.groundtruth = "none";
    run.max_frames = settings.max_frames;
    run.modules = "S";
    RunInputs inputs;
    std::string reason = load_run_inputs(run, &inputs);
    if (reason.empty()) reason = judge_frames(inputs, &progress, &terms);
    if (!reason.empty()) return error_exit(kExitUsage, reason);
    if (requested_stop_signal() != 0) {
      progress.finish();
      std::cerr << "srslam: error: interrupted; nothing was written" << std::endl;
      return kExitSignalBase + requested_stop_signal();
    }
    options = inputs.options;
  }
  progress.finish();

  const CalibrationResult result =
      calibrate_reliability(terms, options.scene.assessor, calibration);
  if (!result.status.ok()) {
    return error_exit(kExitFailure,
                      std::string(result.status.reason) + " (" + std::to_string(result.num_frames) +
                          "; needed: " + std::to_string(calibration.min_frames) + ")");
  }
  options.scene.assessor.residual_scale_px = result.residual_scale_px;
  options.scene.assessor.threshold = result.threshold;
  const FileStatus written = write_file_atomically(settings.output_file, config_file_text(options));
  if (!written.ok()) return error_exit(kExitFailure, written.message());
  const std::string picture_file = fs::path(output).replace_extension(".png").string();
  const FileStatus picture = write_picture(result, picture_file);
  if (!picture.ok()) {
    std::cerr << "srslam: warning: the picture is not written: " << picture.message() << std::endl;
  }
  std::cout << summary_text(result, settings.output_file, picture.ok() ? picture_file : "")
            << std::flush;
  return kExitOk;
}

}  // namespace srslam::cli
