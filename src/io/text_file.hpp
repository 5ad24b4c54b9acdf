#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "srslam/core/status.hpp"

namespace srslam::io_detail {

/// No line of any of our text formats needs more.
constexpr std::size_t kMaxLineBytes = 4096;

/// Absolute bound of time stamps. Seconds since 1970 stay below it for three centuries; stamps in
/// milliseconds or nanoseconds do not, and below it a double still tells microseconds apart.
constexpr double kMaxTimestamp_s = 1e10;

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// Opens `path` for reading; a missing file, a directory and a refusal by the system are told
/// apart.
FileStatus open_for_reading(const std::string& path, FileHandle* handle);

/// Reads a whole regular file of 1 to `max_bytes` bytes; `bytes` keeps its allocation.
FileStatus read_whole_file(const std::string& path, std::size_t max_bytes,
                           std::vector<unsigned char>* bytes);

/// Lines of a text file one by one, in bounded memory. Accepts LF and CRLF, a missing last line end
/// and a UTF-8 byte order mark; refuses lines that are too long, not UTF-8 or hold control
/// characters other than tabs.
class LineReader {
 public:
  FileStatus open(const std::string& path);

  /// The next line without its end, valid until the next call. False at the end of the file and on
  /// failure; status() tells which.
  bool next(std::string_view* line);

  /// Success until a line was refused.
  const FileStatus& status() const { return status_; }
  const std::string& path() const { return path_; }
  std::size_t line_number() const { return line_number_; }
  /// A failure at the current line.
  FileStatus failure(StatusCode code, std::string reason) const;

 private:
  bool refuse(StatusCode code, std::string reason);
  /// Reads the next bytes; false at the end of the file and on failure.
  bool fill_buffer();

  std::string path_;
  FileHandle file_;
  FileStatus status_;
  std::vector<char> buffer_;
  std::size_t position_ = 0;
  std::size_t available_ = 0;
  std::string line_;
  std::size_t line_number_ = 0;
};

/// Text without leading and trailing spaces and tabs.
std::string_view trim(std::string_view text);

/// Splits at spaces and tabs. Fills `tokens` as far as they go and returns how many there are.
template <std::size_t kCapacity>
std::size_t split(std::string_view line, std::array<std::string_view, kCapacity>* tokens) {
  std::size_t count = 0;
  std::size_t i = 0;
  while (true) {
    while (i < line.size() && (line[i] == ' ' || line[i] == '\t')) ++i;
    if (i == line.size()) return count;
    const std::size_t start = i;
    while (i < line.size() && line[i] != ' ' && line[i] != '\t') ++i;
    if (count < kCapacity) (*tokens)[count] = line.substr(start, i - start);
    ++count;
  }
}

/// Whether `text` is UTF-8 without control characters (tabs aside), as one line must be.
bool is_line_of_text(std::string_view text);

/// `'text'`, shortened when long, for reasons.
std::string quote(std::string_view text);

/// Parses a time stamp: finite, in seconds. On failure returns the reason, otherwise an empty
/// string.
std::string parse_timestamp(std::string_view text, double* timestamp_s);

/// Checks that `timestamp_s` follows `previous_s` and says why when it does not.
std::string check_increasing(double previous_s, double timestamp_s);

/// Replaces the file at `path` by `text` in one step: other readers see the old or the new content,
/// never a part.
FileStatus write_file_atomically(const std::string& path, std::string_view text);

}  // namespace srslam::io_detail
