#pragma once

#include <string>
#include <vector>

namespace srslam {

/// Axis-aligned box of one detected object. Edges in pixels of the full image, pixel centres at
/// integer coordinates, `x` along u and `y` along v.
struct Detection {
  std::string class_name;  ///< detector's label without white space, e.g. "person"
  double score = 0.0;      ///< confidence in [0, 1]
  double x_min_px = 0.0;
  double y_min_px = 0.0;
  double x_max_px = 0.0;  ///< > x_min_px
  double y_max_px = 0.0;  ///< > y_min_px
};

/// What a detector said of one frame. An empty list means "looked at, nothing found", which is
/// not the same as a frame that was never looked at.
struct FrameDetections {
  double timestamp_s = 0.0;
  std::vector<Detection> detections;
};

}  // namespace srslam
