#pragma once

#include <cmath>

#include "srslam/core/feature_options.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/lucas_kanade_options.hpp"

namespace srslam {

/// Points that module S follows to judge motion by, and how.
struct SceneFlowOptions {
  /// Wider images are reduced by a whole factor to at most this first: a scene then has the same
  /// reliability whatever camera resolution it is seen with, and optical flow costs less. 0: never
  int max_width_px = 320;
  FeatureOptions corners;           ///< followed, of the reduced image
  LucasKanadeOptions lucas_kanade;  ///< pixels are those of the reduced image
  /// A corner so near to where depth leaps is of the nearer surface, whose outline it is, and has
  /// its depth [px of the reduced image]; 0: has the depth of its pixel.
  double edge_reach_px = 2.0;

  Status validate() const noexcept {
    if (max_width_px < 0) {
      return Status::failure(StatusCode::kInvalidArgument, "max_width_px must not be negative");
    }
    if (!(edge_reach_px >= 0.0) || !std::isfinite(edge_reach_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "edge_reach_px must be finite and not negative");
    }
    const Status status = corners.validate();
    return status.ok() ? lucas_kanade.validate() : status;
  }
};

}  // namespace srslam
