#pragma once

#include "cli/run_inputs.hpp"

namespace srslam::cli {

/// Runs the pipeline over a dataset and writes everything that docs/program.md lists. Returns an
/// ExitCode, or kExitSignalBase + signal when it was asked to end early.
int run_command(const RunSettings& settings);

}  // namespace srslam::cli
