#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace srslam::cli {

/// One line of progress: frame, frames in all, frames per second so far, state.
std::string progress_text(std::size_t num_done, std::size_t num_frames, double elapsed_s,
                          const std::string& state);

/// Shows the progress of a run on the standard error: one line that is overwritten on a terminal,
/// one line every second otherwise. Says nothing when disabled, but passes messages on.
class ProgressLine {
 public:
  ProgressLine(std::size_t num_frames, bool enabled);

  /// After each frame.
  void update(std::size_t num_done, const std::string& state);
  /// Prints `text` as a line of its own, progress or not.
  void message(const std::string& text);
  /// Ends the line; the last state stays visible.
  void finish();

  /// Since the object was made [s].
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;

  void show();

  std::size_t num_frames_;
  bool enabled_;
  bool is_terminal_;
  Clock::time_point start_;
  double next_show_s_ = 0.0;
  std::string text_;
  bool is_shown_ = true;  ///< whether text_ is what was last printed
};

}  // namespace srslam::cli
