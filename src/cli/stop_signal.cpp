#include "cli/stop_signal.hpp"

#include <signal.h>  // NOLINT(modernize-deprecated-headers): sigaction() is POSIX, not <csignal>

#include <atomic>

namespace srslam::cli {
namespace {

// A signal handler can reach nothing but a global; a lock-free atomic is safe to set in it.
std::atomic<int> stop_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not take a lock");

extern "C" void remember_stop_signal(int signal_number) {
  stop_signal.store(signal_number);
  // The second signal of either kind must find the default action, which ends the program.
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
}

}  // namespace

void install_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = remember_stop_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

int requested_stop_signal() { return stop_signal.load(); }

}  // namespace srslam::cli
