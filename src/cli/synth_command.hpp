#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "srslam/synthetic/synthetic_options.hpp"

namespace srslam::cli {

/// What the command line of `srslam synth` says.
struct SynthSettings {
  bool list = false;  ///< print the scenarios and do nothing else
  std::string scenario;
  std::string output_folder;
  std::uint64_t seed = 1;
  std::size_t num_frames = 300;
  int width_px = 640;
  int height_px = 480;
  std::string camera = "tum_fr3";
  SyntheticSensorOptions sensor;
  bool flow = false;
  bool jpeg = false;
  bool overwrite = false;
  std::optional<int> num_threads;  ///< not given: one a core
  bool quiet = false;
};

/// Renders a sequence. Returns an ExitCode, or kExitSignalBase + signal when it was asked to end
/// early; what was rendered until then is not a sequence yet and cannot be taken for one.
int synth_command(const SynthSettings& settings);

}  // namespace srslam::cli
