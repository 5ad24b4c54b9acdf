#include "text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "numbers.hpp"

namespace srslam::io_detail {
namespace {

constexpr std::size_t kBufferBytes = 1U << 16U;

/// Length of the UTF-8 sequence that starts `text`, 0 when it is not valid (overlong forms,
/// surrogates and code points above U+10FFFF are not).
std::size_t utf8_sequence_length(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto is_continuation = [&](std::size_t i) {
    return i < text.size() && (byte(i) & 0xC0U) == 0x80U;
  };
  const unsigned first = byte(0);
  if (first < 0x80U) return 1;
  if (first < 0xC2U || first > 0xF4U || !is_continuation(1)) return 0;
  if (first < 0xE0U) return 2;
  const unsigned second = byte(1);
  if (first < 0xF0U) {
    if ((first == 0xE0U && second < 0xA0U) || (first == 0xEDU && second > 0x9FU)) return 0;
    return is_continuation(2) ? 3 : 0;
  }
  if ((first == 0xF0U && second < 0x90U) || (first == 0xF4U && second > 0x8FU)) return 0;
  return is_continuation(2) && is_continuation(3) ? 4 : 0;
}

/// Empty when `line` is text.
const char* text_problem(std::string_view line) {
  for (std::size_t i = 0; i < line.size();) {
    const unsigned char c = static_cast<unsigned char>(line[i]);
    if ((c < 0x20U && c != '\t') || c == 0x7FU) {
      return "line holds a control character; expected a UTF-8 text file";
    }
    const std::size_t length = utf8_sequence_length(line.substr(i));
    if (length == 0) return "line is not UTF-8; save the file with UTF-8 encoding";
    i += length;
  }
  return "";
}

}  // namespace

FileStatus open_for_reading(const std::string& path, FileHandle* handle) {
  handle->reset();
  if (path.empty() || path.find('\0') != std::string::npos) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, 0, "not a file name");
  }
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    return FileStatus::failure(StatusCode::kNotFound, path, 0, "file does not exist");
  }
  if (status.type() == std::filesystem::file_type::directory) {
    return FileStatus::failure(StatusCode::kCorruptData, path, 0, "is a folder; expected a file");
  }
  handle->reset(std::fopen(path.c_str(), "rb"));
  if (*handle == nullptr) {
    return FileStatus::failure(StatusCode::kIoError, path, 0,
                               "cannot be opened: " + std::generic_category().message(errno));
  }
  return FileStatus::success();
}

FileStatus read_whole_file(const std::string& path, std::size_t max_bytes,
                           std::vector<unsigned char>* bytes) {
  bytes->clear();
  const auto failed = [&path](StatusCode code, std::string reason) {
    return FileStatus::failure(code, path, 0, std::move(reason));
  };
  std::error_code error;
  const std::filesystem::file_status kind = std::filesystem::status(path, error);
  if (std::filesystem::exists(kind) && !std::filesystem::is_directory(kind) &&
      !std::filesystem::is_regular_file(kind)) {
    // Opening a pipe would wait for a writer.
    return failed(StatusCode::kCorruptData, "is not a regular file");
  }
  FileHandle file;
  FileStatus status = open_for_reading(path, &file);
  if (!status.ok()) return status;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return failed(StatusCode::kIoError, "cannot be read: " + error.message());
  if (size == 0) return failed(StatusCode::kCorruptData, "file is empty");
  if (size > max_bytes) {
    return failed(StatusCode::kCorruptData, "file has " + std::to_string(size) +
                                                " bytes; at most " + std::to_string(max_bytes) +
                                                " are expected");
  }
  std::setvbuf(file.get(), nullptr, _IONBF, 0);
  bytes->resize(static_cast<std::size_t>(size));
  const std::size_t num_read = std::fread(bytes->data(), 1, bytes->size(), file.get());
  if (num_read == bytes->size()) return status;
  bytes->clear();
  if (std::ferror(file.get()) != 0) {
    return failed(StatusCode::kIoError,
                  "cannot be read: " + std::generic_category().message(errno));
  }
  return failed(StatusCode::kIoError, "file became shorter while it was read");
}

FileStatus LineReader::open(const std::string& path) {
  path_ = path;
  position_ = 0;
  available_ = 0;
  line_number_ = 0;
  status_ = open_for_reading(path, &file_);
  if (status_.ok()) {
    // Our own buffer serves; a second copy in the C library would only cost.
    std::setvbuf(file_.get(), nullptr, _IONBF, 0);
    buffer_.resize(kBufferBytes);
  }
  return status_;
}

FileStatus LineReader::failure(StatusCode code, std::string reason) const {
  return FileStatus::failure(code, path_, line_number_, std::move(reason));
}

bool LineReader::refuse(StatusCode code, std::string reason) {
  status_ = failure(code, std::move(reason));
  return false;
}

bool LineReader::fill_buffer() {
  available_ = std::fread(buffer_.data(), 1, buffer_.size(), file_.get());
  position_ = 0;
  if (std::ferror(file_.get()) != 0) {
    return refuse(StatusCode::kIoError,
                  "cannot be read: " + std::generic_category().message(errno));
  }
  return available_ > 0;
}

bool LineReader::next(std::string_view* line) {
  if (!status_.ok()) return false;
  line_.clear();
  ++line_number_;
  // One byte more than allowed may be a carriage return; two are too much in any case.
  constexpr std::size_t kTooLong = kMaxLineBytes + 2;
  bool ended = false;
  while (!ended && line_.size() < kTooLong) {
    if (position_ == available_ && !fill_buffer()) {
      if (!status_.ok() || line_.empty()) return false;
      break;  // the last line has no end
    }
    const char* start = buffer_.data() + position_;
    const std::size_t rest = available_ - position_;
    const void* end = std::memchr(start, '\n', rest);
    ended = end != nullptr;
    const std::size_t length =
        ended ? static_cast<std::size_t>(static_cast<const char*>(end) - start) : rest;
    position_ += length + (ended ? 1 : 0);
    line_.append(start, std::min(length, kTooLong - line_.size()));
  }
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  if (line_.size() > kMaxLineBytes) {
    return refuse(StatusCode::kCorruptData,
                  "line is longer than " + std::to_string(kMaxLineBytes) + " bytes");
  }
  if (line_number_ == 1 && line_.compare(0, 3, "\xEF\xBB\xBF") == 0) line_.erase(0, 3);
  const char* problem = text_problem(line_);
  if (*problem != '\0') return refuse(StatusCode::kCorruptData, problem);
  *line = line_;
  return true;
}

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool is_line_of_text(std::string_view text) { return *text_problem(text) == '\0'; }

std::string quote(std::string_view text) {
  constexpr std::size_t kMaxBytes = 60;
  if (text.size() <= kMaxBytes) return "'" + std::string(text) + "'";
  std::size_t length = kMaxBytes;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) --length;
  return "'" + std::string(text.substr(0, length)) + "...'";
}

std::string parse_timestamp(std::string_view text, double* timestamp_s) {
  double value = 0.0;
  if (!parse_decimal(text, &value)) {
    return "time stamp " + quote(text) + " is not a finite decimal number of seconds";
  }
  if (std::abs(value) > kMaxTimestamp_s) {
    return "time stamp " + quote(text) +
           " is beyond 1e10 s; expected seconds, not milliseconds or nanoseconds";
  }
  *timestamp_s = value;
  return {};
}

std::string check_increasing(double previous_s, double timestamp_s) {
  if (timestamp_s > previous_s) return {};
  std::string reason = "time stamp ";
  append_timestamp(timestamp_s, &reason);
  if (timestamp_s == previous_s) {
    reason += " repeats the one before; each time stamp may occur once";
  } else {
    reason += " is before the previous one, ";
    append_timestamp(previous_s, &reason);
    reason += "; sort the lines by time";
  }
  return reason;
}

FileStatus write_file_atomically(const std::string& path, std::string_view text) {
  namespace fs = std::filesystem;
  const auto failed = [&path](const std::string& what, const std::error_code& error) {
    return FileStatus::failure(StatusCode::kIoError, path, 0,
                               what + (error ? ": " + error.message() : std::string()));
  };
  if (path.empty() || path.find('\0') != std::string::npos) {
    return FileStatus::failure(StatusCode::kInvalidArgument, path, 0, "not a file name");
  }
  std::error_code error;
  fs::path target = path;
  const fs::file_status status = fs::status(target, error);
  if (fs::exists(status)) {
    // Renaming onto a device or a link would replace the device or the link itself.
    if (!fs::is_regular_file(status)) {
      return failed("cannot be written: exists and is not a regular file", {});
    }
    target = fs::canonical(target, error);
    if (error) return failed("cannot be written", error);
  }
  const fs::path temporary = target.string() + ".partial";
  FileHandle file(std::fopen(temporary.c_str(), "wb"));
  if (file == nullptr) {
    return failed("cannot be created", std::error_code(errno, std::generic_category()));
  }
  const bool written =
      text.empty() || std::fwrite(text.data(), 1, text.size(), file.get()) == text.size();
  const bool closed = std::fclose(file.release()) == 0;
  if (!written || !closed) {
    const std::error_code reason(errno, std::generic_category());
    fs::remove(temporary, error);
    return failed("cannot be written", reason);
  }
  fs::rename(temporary, target, error);
  if (error) {
    const std::error_code reason = error;
    fs::remove(temporary, error);
    return failed("cannot be replaced", reason);
  }
  return FileStatus::success();
}

}  // namespace srslam::io_detail
