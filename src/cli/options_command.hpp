#pragma once

#include <string>

namespace srslam::cli {

struct OptionsSettings {
  std::string config_file;  ///< empty: the defaults
  bool yaml = false;
};

/// Prints every pipeline option with its value. Returns an ExitCode.
int options_command(const OptionsSettings& settings);

}  // namespace srslam::cli
