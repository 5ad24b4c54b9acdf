#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "srslam/core/detection.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Reads a detections file (format: docs/detections.md), strictly: any line that is not of the
/// format fails with its number. The lines of one frame must be consecutive; the frames may come
/// in any order, as a detector that runs in parallel writes them, and are returned in increasing
/// order of time, each with its boxes in the file's order. On failure `frames` is empty.
FileStatus read_detections(const std::string& path, std::vector<FrameDetections>* frames);

/// Writes `frames` in the same format so that read_detections() restores every number to the last
/// bit; a frame without detections becomes a `none` line. Refuses (kInvalidArgument, file left as
/// it was) what read_detections() would refuse. The file is replaced in one step.
FileStatus write_detections(const std::string& path, const std::vector<FrameDetections>& frames);

/// Index of the frame nearest to `timestamp_s`, the earlier one of two equally near, or
/// frames.size() when none lies within `max_time_difference_s`. `frames` in increasing order of
/// time. O(log n).
std::size_t find_detections(const std::vector<FrameDetections>& frames, double timestamp_s,
                            double max_time_difference_s);

}  // namespace srslam
