#pragma once

#include <cstddef>
#include <fstream>
#include <string>

#include "srslam/core/status.hpp"
#include "srslam/evaluation/trajectory.hpp"

namespace srslam {

struct TrajectoryReadOptions {
  /// Take the last of consecutive lines with one time stamp, as the TUM benchmark's own tools do,
  /// instead of refusing the file. Its published ground truth of freiburg2_desk needs it.
  bool keep_last_of_repeated = false;
};

/// Reads a trajectory in TUM format, `timestamp tx ty tz qx qy qz qw` a line, `#` comments,
/// LF or CRLF. Quaternions are normalised; their norm must be within 0.1 of 1. NaN or infinite
/// numbers, positions beyond 1e9 m, time stamps beyond 1e10 s (milliseconds?), a zero-norm
/// quaternion, missing or extra columns, repeated or decreasing time stamps and an empty list fail
/// with file, line and reason. On failure `trajectory` is empty. `num_repeated` (optional) is how
/// many lines `keep_last_of_repeated` dropped.
FileStatus read_trajectory(const std::string& path, Trajectory* trajectory,
                           const TrajectoryReadOptions& options = {},
                           std::size_t* num_repeated = nullptr);

/// Appends poses to a file in TUM format and hands each to the operating system at once, so that a
/// crash of the program loses none. Time stamps get six decimals, or as many more as it takes to
/// read them back exactly; positions nine (nanometres), unit quaternions with qw >= 0 nine.
class TrajectoryWriter {
 public:
  /// Creates or truncates `path` and writes `comment` as leading `#` lines (empty: none).
  FileStatus open(const std::string& path, const std::string& comment);
  /// Refuses (kInvalidArgument, nothing written, the writer stays usable) a pose that
  /// read_trajectory() would not take back: not finite, not rigid, or not later than the one
  /// before.
  FileStatus append(const StampedPose& pose);
  /// Success also when open() was never called or close() was called before.
  FileStatus close();
  std::size_t num_written() const { return num_written_; }

 private:
  std::string path_;
  std::ofstream stream_;
  std::string line_;
  double last_timestamp_s_ = 0.0;
  std::size_t num_written_ = 0;
};

/// Writes a whole trajectory at once; the file is replaced in one step. Refuses what
/// TrajectoryWriter::append() refuses, and then leaves the file as it was.
FileStatus write_trajectory(const std::string& path, const Trajectory& trajectory,
                            const std::string& comment);

}  // namespace srslam
