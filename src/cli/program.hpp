#pragma once

namespace srslam::cli {

/// The program: reads the command line, runs the command and returns its ExitCode.
int run_program(int argc, const char* const* argv);

}  // namespace srslam::cli
