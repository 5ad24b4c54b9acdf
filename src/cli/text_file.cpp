#include "cli/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace srslam::cli {
namespace {

FileStatus failure(const std::string& path, const char* what, int error_number) {
  return FileStatus::failure(
      StatusCode::kIoError, path, 0,
      std::string(what) + ": " + std::generic_category().message(error_number));
}

/// 0, or the error number.
int write_all(int descriptor, const std::string& text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    written += static_cast<std::size_t>(count);
  }
  return ::fsync(descriptor) == 0 ? 0 : errno;
}

}  // namespace

FileStatus write_file_atomically(const std::string& path, const std::string& text) {
  const std::filesystem::path target(path);
  const std::string temporary =
      (target.parent_path() / ("." + target.filename().string() + ".tmp")).string();
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return failure(path, "cannot be created", errno);
  int error_number = write_all(descriptor, text);
  if (::close(descriptor) != 0 && error_number == 0) error_number = errno;
  if (error_number == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error_number = errno;
  if (error_number != 0) {
    ::unlink(temporary.c_str());
    return failure(path, "cannot be written", error_number);
  }
  return FileStatus::success();
}

FileStatus read_text_file(const std::string& path, std::string* text) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return failure(path, "cannot be opened", errno);
  std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) return failure(path, "cannot be read", errno);
  *text = std::move(content);
  return FileStatus::success();
}

}  // namespace srslam::cli
