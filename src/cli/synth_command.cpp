#include "cli/synth_command.hpp"

#include <algorithm>
#include <iostream>
#include <thread>

#include "cli/exit_code.hpp"
#include "cli/number_text.hpp"
#include "cli/progress_line.hpp"
#include "cli/stop_signal.hpp"
#include "srslam/synthetic/sequence_writer.hpp"
#include "srslam/synthetic/synthetic_world.hpp"

namespace srslam::cli {
namespace {

int print_scenarios() {
  std::size_t widest = 0;
  for (const ScenarioInfo& info : scenario_list()) widest = std::max(widest, info.name.size());
  for (const ScenarioInfo& info : scenario_list()) {
    std::cout << info.name << std::string(widest + 2 - info.name.size(), ' ') << info.description
              << "\n";
  }
  return std::cout.flush() ? kExitOk : kExitFailure;
}

}  // namespace

int synth_command(const SynthSettings& settings) {
  if (settings.list) return print_scenarios();
  if (settings.scenario.empty())
    return error_exit(kExitUsage, "--scenario NAME is needed; --list names them");
  if (settings.output_folder.empty()) return error_exit(kExitUsage, "--output DIR is needed");
  SyntheticOptions options;
  options.scenario = settings.scenario;
  options.seed = settings.seed;
  options.num_frames = settings.num_frames;
  options.sensor = settings.sensor;
  FileStatus status =
      synthetic_camera(settings.camera, settings.width_px, settings.height_px, &options.camera);
  if (!status.ok()) return error_exit(kExitUsage, status.message());
  SyntheticWorld world;
  status = world.create(options);
  if (!status.ok()) return error_exit(kExitUsage, status.message());

  install_stop_signals();
  ProgressLine progress(!settings.quiet);
  SequenceWriterOptions writing;
  writing.flow = settings.flow;
  writing.jpeg = settings.jpeg;
  writing.overwrite = settings.overwrite;
  writing.num_threads = settings.num_threads.value_or(
      std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  const auto show_progress = [&](std::size_t num_done) {
    progress.update(progress_text(num_done, options.num_frames, progress.elapsed_s(), "rendered"));
    return requested_stop_signal() == 0;
  };
  status = write_sequence(world, settings.output_folder, writing, show_progress);
  progress.finish();
  if (requested_stop_signal() != 0 && !status.ok()) {
    std::cerr << "srslam: interrupted; " << settings.output_folder << " holds no sequence yet\n";
    return kExitSignalBase + requested_stop_signal();
  }
  if (!status.ok()) {
    std::cerr << "srslam: error: " << status.message() << "\n";
    return status.code == StatusCode::kInvalidArgument ? kExitUsage : kExitFailure;
  }
  if (!settings.quiet) {
    std::cout << "Scenario    " << options.scenario << ", seed " << options.seed << ", "
              << options.num_frames << " frames\nSpeed       "
              << fixed_text(double(options.num_frames) / progress.elapsed_s(), 1)
              << " frames/s of wall time, files included (" << writing.num_threads
              << " threads)\nWritten to  " << settings.output_folder << "\n";
  }
  return std::cout.flush() ? kExitOk : kExitFailure;
}

}  // namespace srslam::cli
