#include "cli/child_process.hpp"

#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX, not <csignal>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <thread>

#include "cli/number_text.hpp"

namespace srslam::cli {
namespace {

std::string error_text(int error_number) { return std::generic_category().message(error_number); }

ChildEnd end_of(int wait_status) {
  ChildEnd end;
  if (WIFEXITED(wait_status)) {
    end.exit_code = WEXITSTATUS(wait_status);
    if (end.exit_code != 0) end.reason = "ended with code " + std::to_string(end.exit_code);
  } else {
    end.signal_number = WTERMSIG(wait_status);
    end.reason = "was ended by signal " + std::to_string(end.signal_number);
  }
  return end;
}

/// What happens between fork() and the new program: nothing that could wait for a lock which
/// another thread held at the fork. Does not return; an error number goes to `error_pipe`.
[[noreturn]] void become(char* const* argv, const char* working_folder, const char* log_file,
                         pid_t parent, int error_pipe) {
  const auto succeeded = [&] {
    // The order matters: a parent that ended before prctl() shows in getppid().
    if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return false;
    if (::getppid() != parent) ::_exit(1);
    ::setpgid(0, 0);
    ::signal(SIGPIPE, SIG_DFL);
    const int input = ::open("/dev/null", O_RDONLY);
    if (input < 0 || ::dup2(input, STDIN_FILENO) < 0) return false;
    const int log = ::open(log_file, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (log < 0 || ::dup2(log, STDOUT_FILENO) < 0 || ::dup2(log, STDERR_FILENO) < 0) return false;
    if (input > STDERR_FILENO) ::close(input);
    if (log > STDERR_FILENO) ::close(log);
    if (::chdir(working_folder) != 0) return false;
    ::execvp(argv[0], argv);
    return false;
  };
  int error_number = succeeded() ? 0 : errno;
  if (::write(error_pipe, &error_number, sizeof(error_number)) < 0) ::_exit(2);
  ::_exit(1);
}

}  // namespace

std::string ChildProcess::start(const std::vector<std::string>& arguments,
                                const std::string& working_folder, const std::string& log_file) {
  std::vector<std::string> storage = arguments;
  std::vector<char*> argv;
  argv.reserve(storage.size() + 1);
  for (std::string& argument : storage) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const auto failure = [&](int error_number) {
    return arguments.front() + " cannot be started: " + error_text(error_number);
  };
  // Closes by itself when the new program starts; what comes through it is why it did not.
  std::array<int, 2> error_pipe = {};
  if (::pipe2(error_pipe.data(), O_CLOEXEC) != 0) return failure(errno);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    become(argv.data(), working_folder.c_str(), log_file.c_str(), parent, error_pipe[1]);
  }
  const int fork_error = errno;
  ::close(error_pipe[1]);
  if (child < 0) {
    ::close(error_pipe[0]);
    return failure(fork_error);
  }
  start_ = Clock::now();
  id_ = child;
  int error_number = 0;
  ssize_t num_read = 0;
  do {
    num_read = ::read(error_pipe[0], &error_number, sizeof(error_number));
  } while (num_read < 0 && errno == EINTR);
  ::close(error_pipe[0]);
  if (num_read <= 0) return {};
  end();
  return failure(error_number);
}

std::optional<ChildEnd> ChildProcess::poll() {
  if (id_ == 0) return ChildEnd{-1, 0, "was not started"};
  int wait_status = 0;
  const pid_t ended = ::waitpid(id_, &wait_status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
  id_ = 0;
  if (ended < 0) return ChildEnd{-1, 0, "cannot be waited for: " + error_text(errno)};
  return end_of(wait_status);
}

void ChildProcess::end() {
  if (id_ == 0) return;
  ::kill(-id_, SIGKILL);
  // Its group exists only once it has come to setpgid().
  ::kill(id_, SIGKILL);
  while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
  }
  id_ = 0;
}

double ChildProcess::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

std::string run_child_process(const std::vector<std::string>& arguments,
                              const std::string& working_folder, const std::string& log_file,
                              double timeout_s) {
  ChildProcess child;
  std::string reason = child.start(arguments, working_folder, log_file);
  if (!reason.empty()) return reason;
  while (child.elapsed_s() < timeout_s) {
    if (const std::optional<ChildEnd> end = child.poll()) {
      return end->reason.empty() ? std::string() : arguments.front() + " " + end->reason;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return arguments.front() + " did not end within " + shortest_text(timeout_s) + " s";
}

}  // namespace srslam::cli
