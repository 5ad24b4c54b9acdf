#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace srslam::cli {

/// How a child process ended.
struct ChildEnd {
  int exit_code = -1;     ///< -1 unless it ended by itself
  int signal_number = 0;  ///< that ended it, or 0
  std::string reason;     ///< "ended with code 3", "was ended by signal 9"; empty for code 0
};

/// A program that runs beside this one. No shell takes part, so nothing in an argument is ever
/// interpreted. It runs in a process group of its own: an interrupt from the terminal does not
/// reach it. The system ends it when the thread that started it ends, however that happens, so that
/// nothing goes on writing after a kill.
class ChildProcess {
 public:
  ChildProcess() = default;
  ~ChildProcess() { end(); }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Starts `arguments[0]`, looked up in PATH, with `arguments` in the folder `working_folder`. Its
  /// output goes to the file `log_file`, its input is empty. Once per object.
  /// Returns an empty string or the reason.
  std::string start(const std::vector<std::string>& arguments, const std::string& working_folder,
                    const std::string& log_file);

  /// How it ended; empty while it runs. Does not wait.
  std::optional<ChildEnd> poll();

  /// Kills it with its process group, if it runs, and waits until it is gone.
  void end();

  /// Since start() [s].
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;

  pid_t id_ = 0;  ///< 0: not started, or over
  Clock::time_point start_;
};

/// Runs a ChildProcess and waits at most `timeout_s` for it, then kills it.
/// Returns an empty string when it ended with 0, else the reason.
std::string run_child_process(const std::vector<std::string>& arguments,
                              const std::string& working_folder, const std::string& log_file,
                              double timeout_s);

}  // namespace srslam::cli
