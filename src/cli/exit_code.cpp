#include "cli/exit_code.hpp"

#include <iostream>

namespace srslam::cli {

int error_exit(ExitCode code, const std::string& reason) {
  std::cerr << "srslam: error: " << reason << std::endl;
  return code;
}

}  // namespace srslam::cli
