#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srslam/scene/calibration.hpp"

namespace srslam::cli {

struct CalibrateSettings {
  std::vector<std::string> dataset_folders;
  std::string camera;       ///< preset or file; empty: each folder's own
  std::string config_file;  ///< options to start from; empty: the defaults
  std::string output_file;  ///< configuration to write; the picture goes beside it
  std::optional<std::size_t> max_frames;
  bool extremes = false;
  CalibrationOptions calibration;
  bool quiet = false;
};

/// Sets residual scale and threshold of module S from sequences in which nothing moves but the
/// camera. Writes a configuration that `srslam run --config` reads, and a picture of the
/// distributions. Returns an ExitCode.
int calibrate_command(const CalibrateSettings& settings);

}  // namespace srslam::cli
