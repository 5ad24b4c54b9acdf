#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace srslam {

/// Why an operation failed. Every result starts as `kNotRun`, never as success.
enum class StatusCode : std::uint8_t {
  kOk = 0,
  kNotRun,            ///< the operation has not been called
  kInvalidArgument,   ///< an option or input is outside its documented domain
  kInsufficientData,  ///< too few observations for an answer
  kDegenerate,        ///< the problem has no unique answer (rank deficiency, zero baseline)
  kNotConverged,      ///< an iterative method stopped before its tolerance was met
  kNotFound,          ///< a file, key or item does not exist
  kCorruptData,       ///< content that cannot be what it claims to be
  kIoError,           ///< the operating system refused to read or write
  kUnsupported,       ///< valid, but not something that this build can do
};

/// Stable lower-case name of `code`, for logs and machine-readable output.
constexpr const char* to_string(StatusCode code) noexcept {
  switch (code) {
    case StatusCode::kOk:
      return "ok";
    case StatusCode::kNotRun:
      return "not_run";
    case StatusCode::kInvalidArgument:
      return "invalid_argument";
    case StatusCode::kInsufficientData:
      return "insufficient_data";
    case StatusCode::kDegenerate:
      return "degenerate";
    case StatusCode::kNotConverged:
      return "not_converged";
    case StatusCode::kNotFound:
      return "not_found";
    case StatusCode::kCorruptData:
      return "corrupt_data";
    case StatusCode::kIoError:
      return "io_error";
    case StatusCode::kUnsupported:
      return "unsupported";
  }
  return "unknown";
}

/// Outcome of an algorithm: a code and a reason in static storage, so that reporting a failure
/// never allocates and copies of it never dangle.
struct Status {
  StatusCode code = StatusCode::kNotRun;
  const char* reason = "not run";

  constexpr bool ok() const noexcept { return code == StatusCode::kOk; }

  static constexpr Status success() noexcept { return {StatusCode::kOk, ""}; }
  /// `reason` must have static storage duration (a string literal).
  static constexpr Status failure(StatusCode code, const char* reason) noexcept {
    return {code, reason};
  }
};

/// Outcome of reading or writing a file: where, why, and what would be right.
struct FileStatus {
  StatusCode code = StatusCode::kNotRun;
  std::string file;      ///< path as the caller gave it
  std::size_t line = 0;  ///< 1-based; 0 when the failure has no line
  std::string reason = "not run";

  bool ok() const noexcept { return code == StatusCode::kOk; }

  /// `file:line: reason` with the parts that exist.
  std::string message() const {
    std::string text = file;
    if (line > 0) text += ":" + std::to_string(line);
    if (!text.empty()) text += ": ";
    return text + reason;
  }

  static FileStatus success() { return {StatusCode::kOk, {}, 0, {}}; }
  static FileStatus failure(StatusCode code, std::string file, std::size_t line,
                            std::string reason) {
    return {code, std::move(file), line, std::move(reason)};
  }
};

}  // namespace srslam
