#include "cli/child_process.hpp"

#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX, not <csignal>
#include <spawn.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "cli/number_text.hpp"

namespace srslam::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// What posix_spawnp() needs besides the arguments, released with the object.
class SpawnSettings {
 public:
  SpawnSettings(const std::string& working_folder, const std::string& log_file) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, log_file.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0666);
    posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
    posix_spawn_file_actions_addchdir_np(&actions_, working_folder.c_str());
    posix_spawnattr_init(&attributes_);
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes_, &defaults);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_,
                             static_cast<short>(POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
  }
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_ = {};
  posix_spawnattr_t attributes_ = {};
};

std::string describe_exit(const std::string& program, int wait_status) {
  if (WIFEXITED(wait_status)) {
    if (WEXITSTATUS(wait_status) == 0) return {};
    return program + " ended with code " + std::to_string(WEXITSTATUS(wait_status));
  }
  return program + " was ended by signal " + std::to_string(WTERMSIG(wait_status));
}

}  // namespace

std::string run_child_process(const std::vector<std::string>& arguments,
                              const std::string& working_folder, const std::string& log_file,
                              double timeout_s) {
  std::vector<std::string> storage = arguments;
  std::vector<char*> argv;
  argv.reserve(storage.size() + 1);
  for (std::string& argument : storage) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const std::string& program = arguments.front();
  const SpawnSettings settings(working_folder, log_file);
  pid_t child = 0;
  const int error_number = posix_spawnp(&child, program.c_str(), settings.actions(),
                                        settings.attributes(), argv.data(), environ);
  if (error_number != 0) {
    return program + " cannot be started: " + std::generic_category().message(error_number);
  }

  const Clock::time_point deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                        std::chrono::duration<double>(timeout_s));
  int wait_status = 0;
  while (true) {
    const pid_t ended = ::waitpid(child, &wait_status, WNOHANG);
    if (ended == child) return describe_exit(program, wait_status);
    if (ended < 0 && errno != EINTR) {
      return program + " cannot be waited for: " + std::generic_category().message(errno);
    }
    if (Clock::now() >= deadline) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ::kill(-child, SIGKILL);
  while (::waitpid(child, &wait_status, 0) < 0 && errno == EINTR) {
  }
  return program + " did not end within " + shortest_text(timeout_s) + " s";
}

}  // namespace srslam::cli
