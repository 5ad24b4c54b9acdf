#pragma once

#include <string>
#include <string_view>
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

/// Whether a pixel lies in a box, edges included; false for a NaN.
inline bool box_contains(const Detection& box, double u_px, double v_px) noexcept {
  return u_px >= box.x_min_px && u_px <= box.x_max_px && v_px >= box.y_min_px &&
         v_px <= box.y_max_px;
}

/// Whether what a detector calls so moves by itself: the people, vehicles and animals of COCO.
inline bool is_movable_class(std::string_view class_name) noexcept {
  constexpr std::string_view kMovable[] = {
      "person", "bicycle", "car",   "motorcycle", "airplane", "bus",   "train",
      "truck",  "boat",    "bird",  "cat",        "dog",      "horse", "sheep",
      "cow",    "bear",    "zebra", "elephant",   "giraffe"};
  for (const std::string_view name : kMovable) {
    if (class_name == name) return true;
  }
  return false;
}

/// What a detector said of one frame. An empty list means "looked at, nothing found", which is
/// not the same as a frame that was never looked at.
struct FrameDetections {
  double timestamp_s = 0.0;
  std::vector<Detection> detections;
};

}  // namespace srslam
