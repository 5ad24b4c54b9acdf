#pragma once

#include <string>

namespace srslam::cli {

/// What the program tells the shell; part of its interface (docs/program.md).
enum ExitCode : int {
  kExitOk = 0,            ///< done
  kExitFailure = 1,       ///< nothing was tracked, or the run failed on the way
  kExitUsage = 2,         ///< the command line or an input is wrong; nothing was run
  kExitSignalBase = 128,  ///< plus the signal: ended early, everything so far is written
};

/// Says on standard error why the program ends. Returns `code`.
int error_exit(ExitCode code, const std::string& reason);

}  // namespace srslam::cli
