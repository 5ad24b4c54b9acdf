#include "cli/campaign/campaign_folder.hpp"

#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX, not <csignal>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <vector>

#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = ".lock";
constexpr const char* kWorkPrefix = ".running-";

std::string host_name() {
  std::array<char, 256> name = {};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

/// What tells the work of this process, or of process `id` on this machine, from all others.
std::string work_suffix(const std::string& process_id) {
  return "-" + host_name() + "-" + process_id;
}

bool is_running(const std::string& process_id) {
  pid_t id = 0;
  const char* end = process_id.data() + process_id.size();
  const auto [stop, error] = std::from_chars(process_id.data(), end, id);
  // What is no number is not ours to judge.
  if (error != std::errc() || stop != end || id <= 0) return true;
  return ::kill(id, 0) == 0 || errno != ESRCH;
}

}  // namespace

CampaignLock::~CampaignLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string CampaignLock::acquire(const std::string& folder) {
  const std::string file = (fs::path(folder) / kLockFile).string();
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    return file + ": cannot be opened: " + std::generic_category().message(errno);
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) {
      return file + ": cannot be locked: " + std::generic_category().message(errno);
    }
    std::string owner;
    if (!read_text_file(file, &owner).ok() || owner.empty()) owner = "an unknown process";
    return "another campaign is at work in " + folder + " (" + owner +
           "); wait for its end or give another --output";
  }
  const std::string owner = "process " + std::to_string(::getpid()) + " on " + host_name();
  // Only for the message above; the lock holds without it.
  if (::ftruncate(descriptor_, 0) == 0) {
    const ssize_t ignored = ::write(descriptor_, owner.data(), owner.size());
    static_cast<void>(ignored);
  }
  return {};
}

std::string make_work_folder(const std::string& parent, const std::string& label,
                             std::string* folder) {
  std::error_code error;
  const fs::path path =
      fs::path(parent) / (kWorkPrefix + label + work_suffix(std::to_string(::getpid())));
  // A process of the same number may have left one.
  fs::remove_all(path, error);
  if (!error) fs::create_directories(path, error);
  if (error) return path.string() + ": cannot be made: " + error.message();
  *folder = path.string();
  return {};
}

std::string publish_folder(const std::string& work_folder, const std::string& final_folder,
                           bool replaces) {
  std::error_code error;
  if (replaces) fs::remove_all(final_folder, error);
  if (error) return final_folder + ": cannot be replaced: " + error.message();
  fs::rename(work_folder, final_folder, error);
  if (!error) return {};
  std::error_code ignored;
  const bool is_there = fs::is_directory(final_folder, ignored);
  if (is_there) fs::remove_all(work_folder, ignored);
  return is_there ? std::string() : final_folder + ": cannot be made: " + error.message();
}

void remove_abandoned_work(const std::string& parent) {
  std::error_code error;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator entry(parent, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.rfind(kWorkPrefix, 0) != 0) continue;
    const std::string process_id = name.substr(name.rfind('-') + 1);
    const std::string suffix = work_suffix(process_id);
    const bool is_ours = name.size() >= suffix.size() &&
                         name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0;
    if (is_ours && !is_running(process_id)) abandoned.push_back(entry->path());
  }
  for (const fs::path& path : abandoned) fs::remove_all(path, error);
}

}  // namespace srslam::cli
