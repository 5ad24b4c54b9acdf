#pragma once

#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// Where points of a reference frame are in the current one if they stand still: a first guess for
/// optical flow. Points without depth, behind the current camera or outside its image keep their
/// place. `predicted` has one a point; it allocates only while it grows. O(n).
inline void predict_flow_points(ArrayView<const FlowPoint> points, const PinholeCamera& camera,
                                const Pose& T_current_reference,
                                std::vector<FlowPoint>* predicted) {
  predicted->assign(points.begin(), points.end());
  for (FlowPoint& point : *predicted) {
    Eigen::Vector3d position_m;
    Eigen::Vector2d pixel;
    if (!camera.unproject({double(point.u_px), double(point.v_px)}, double(point.depth_m),
                          &position_m) ||
        !camera.project(T_current_reference * position_m, &pixel) || !camera.in_image(pixel)) {
      continue;
    }
    point.u_px = static_cast<float>(pixel.x());
    point.v_px = static_cast<float>(pixel.y());
  }
}

}  // namespace srslam
