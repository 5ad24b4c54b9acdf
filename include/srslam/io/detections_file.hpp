#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "srslam/core/detection.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Reads a detections file (format: docs/detections.md), strictly: any line that is not of the
/// format fails with its number. Frames come out in increasing order of time; lines of one frame
/// need not be adjacent in time order but a frame's lines must be consecutive.
FileStatus read_detections(const std::string& path, std::vector<FrameDetections>* frames);

/// Writes `frames` in the same format; a frame without detections becomes a `none` line.
FileStatus write_detections(const std::string& path, const std::vector<FrameDetections>& frames);

/// Index of the frame nearest to `timestamp_s`, or frames.size() when none lies within
/// `max_time_difference_s`. O(log n).
std::size_t find_detections(const std::vector<FrameDetections>& frames, double timestamp_s,
                            double max_time_difference_s);

}  // namespace srslam
