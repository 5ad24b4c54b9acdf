#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace srslam::cli {

/// One line of progress: frame, frames in all, frames per second so far, state.
std::string progress_text(std::size_t num_done, std::size_t num_frames, double elapsed_s,
                          const std::string& state);

/// Shows the progress of a command on the standard error: one line that is overwritten on a
/// terminal, one line every `log_interval_s` otherwise. Says nothing when disabled, but passes
/// messages on.
class ProgressLine {
 public:
  explicit ProgressLine(bool enabled, double log_interval_s = 1.0);

  /// After each step. What is not due yet is kept for the next time, or for the end.
  void update(const std::string& text);
  /// Prints `text` as a line of its own, progress or not.
  void message(const std::string& text);
  /// Ends the line; the last state stays visible.
  void finish();

  /// Since the object was made [s].
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;

  void show();

  bool enabled_;
  bool is_terminal_;
  double log_interval_s_;
  Clock::time_point start_;
  double next_show_s_ = 0.0;
  std::string text_;
  bool is_shown_ = true;  ///< whether text_ is what was last printed
};

}  // namespace srslam::cli
