#pragma once

#include <cstddef>
#include <fstream>
#include <string>

#include "srslam/core/status.hpp"
#include "srslam/evaluation/trajectory.hpp"

namespace srslam {

/// Reads a trajectory in TUM format, `timestamp tx ty tz qx qy qz qw` a line, `#` comments,
/// LF or CRLF. Quaternions are normalised. NaN or infinite numbers, a zero-norm quaternion,
/// missing or extra columns, repeated or decreasing time stamps and an empty list fail with file,
/// line and reason.
FileStatus read_trajectory(const std::string& path, Trajectory* trajectory);

/// Appends poses to a file in TUM format, flushing after each so that a crash loses none.
class TrajectoryWriter {
 public:
  /// Creates or truncates `path` and writes `comment` as a leading `#` line (empty: none).
  FileStatus open(const std::string& path, const std::string& comment);
  FileStatus append(const StampedPose& pose);
  FileStatus close();
  std::size_t num_written() const { return num_written_; }

 private:
  std::string path_;
  std::ofstream stream_;
  std::size_t num_written_ = 0;
};

/// Writes a whole trajectory at once.
FileStatus write_trajectory(const std::string& path, const Trajectory& trajectory,
                            const std::string& comment);

}  // namespace srslam
