#pragma once

#include <string>
#include <vector>

namespace srslam::cli {

/// Runs `arguments[0]`, looked up in PATH, with `arguments` in the folder `working_folder` and
/// waits at most `timeout_s` for it, then kills it. No shell takes part, so nothing in an argument
/// is ever interpreted. Its output goes to the file `log_file`, its input is empty. It runs in a
/// process group of its own: an interrupt from the terminal does not reach it.
/// Returns an empty string when it ended with 0, else the reason.
std::string run_child_process(const std::vector<std::string>& arguments,
                              const std::string& working_folder, const std::string& log_file,
                              double timeout_s);

}  // namespace srslam::cli
