#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "srslam/core/array_view.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/image_view.hpp"

namespace srslam {

/// A point of an image that is, or will be, followed by optical flow.
struct FlowPoint {
  float u_px = 0.0F;
  float v_px = 0.0F;
  float depth_m = 0.0F;  ///< invalid where <= 0 or not finite
  bool suspect = false;  ///< on an object that may move by itself, as far as is known
};

/// A point of the reference frame and where the current frame shows it.
struct FlowTrack {
  FlowPoint reference;
  FlowPoint current;   ///< meaningless while not alive
  bool alive = false;  ///< followed up to the current frame
};

/// Depth at the pixel nearest to (u, v) [m]; 0 outside the image and where it is invalid.
inline float depth_at(const ImageView<const float>& depth_m, float u_px, float v_px) noexcept {
  // Negated, so that a NaN is outside, too.
  if (!(u_px >= -0.5F && v_px >= -0.5F && u_px < float(depth_m.width_px) - 0.5F &&
        v_px < float(depth_m.height_px) - 0.5F)) {
    return 0.0F;
  }
  const float value =
      depth_m(static_cast<int>(std::lround(u_px)), static_cast<int>(std::lround(v_px)));
  return value > 0.0F && std::isfinite(value) ? value : 0.0F;
}

/// Depth at (u, v) [m], or of the nearest surface `reach_px` to the side, above and below if that
/// is nearer by a share of `min_step` at least. 0 where none of them is valid.
inline float front_depth_at(const ImageView<const float>& depth_m, float u_px, float v_px,
                            float reach_px, float min_step) noexcept {
  const float here_m = depth_at(depth_m, u_px, v_px);
  if (!(reach_px > 0.0F)) return here_m;
  float nearest_m = here_m;
  float farthest_m = here_m;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const float side_m = depth_at(depth_m, u_px + static_cast<float>(du) * reach_px,
                                    v_px + static_cast<float>(dv) * reach_px);
      if (!(side_m > 0.0F)) continue;
      if (!(nearest_m > 0.0F) || side_m < nearest_m) nearest_m = side_m;
      farthest_m = std::max(farthest_m, side_m);
    }
  }
  return farthest_m > (1.0F + min_step) * nearest_m ? nearest_m : here_m;
}

/// Sets depth of `point` from the image, and whether a box of a movable object holds it. An empty
/// image or list says that nothing is known: no depth, no suspicion. O(boxes).
inline void describe_flow_point(const ImageView<const float>& depth_m,
                                ArrayView<const Detection> detections, FlowPoint* point) noexcept {
  point->depth_m = depth_m.empty() ? 0.0F : depth_at(depth_m, point->u_px, point->v_px);
  point->suspect = false;
  const double u = double(point->u_px);
  const double v = double(point->v_px);
  for (const Detection& box : detections) {
    if (box_contains(box, u, v) && is_movable_class(box.class_name)) {
      point->suspect = true;
      return;
    }
  }
}

}  // namespace srslam
