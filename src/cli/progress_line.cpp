#include "cli/progress_line.hpp"

#include <unistd.h>

#include <iostream>

#include "cli/number_text.hpp"

namespace srslam::cli {
namespace {

constexpr double kTerminalInterval_s = 0.1;
/// Back to the first column, clear to the end.
constexpr const char* kClearLine = "\r\033[K";

}  // namespace

std::string progress_text(std::size_t num_done, std::size_t num_frames, double elapsed_s,
                          const std::string& state) {
  const double fps = elapsed_s > 0.0 ? static_cast<double>(num_done) / elapsed_s : 0.0;
  return "frame " + std::to_string(num_done) + "/" + std::to_string(num_frames) + "  " +
         fixed_text(fps, 1) + " frames/s  " + state;
}

ProgressLine::ProgressLine(bool enabled, double log_interval_s)
    : enabled_(enabled),
      is_terminal_(::isatty(STDERR_FILENO) == 1),
      log_interval_s_(log_interval_s),
      start_(Clock::now()) {}

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void ProgressLine::update(const std::string& text) {
  if (!enabled_) return;
  const double now_s = elapsed_s();
  text_ = text;
  is_shown_ = false;
  if (now_s < next_show_s_) return;
  next_show_s_ = now_s + (is_terminal_ ? kTerminalInterval_s : log_interval_s_);
  show();
}

void ProgressLine::show() {
  std::cerr << (is_terminal_ ? kClearLine + text_ : text_ + "\n") << std::flush;
  is_shown_ = true;
}

void ProgressLine::message(const std::string& text) {
  if (is_terminal_ && enabled_) std::cerr << kClearLine;
  std::cerr << text << std::endl;
  if (is_terminal_ && enabled_ && !text_.empty()) std::cerr << text_ << std::flush;
}

void ProgressLine::finish() {
  if (!enabled_ || text_.empty()) return;
  if (!is_shown_) show();
  if (is_terminal_) std::cerr << std::endl;
}

}  // namespace srslam::cli
