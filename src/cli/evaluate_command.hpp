#pragma once

#include <string>

#include "cli/trajectory_report.hpp"

namespace srslam::cli {

struct EvaluateSettings {
  std::string groundtruth_file;
  std::string estimate_file;
  bool json = false;
  ReportOptions report;
};

/// Compares two trajectory files and prints the report on the standard output. Returns an ExitCode:
/// kExitUsage when a file cannot be read, kExitFailure when no absolute error can be computed.
int evaluate_command(const EvaluateSettings& settings);

}  // namespace srslam::cli
