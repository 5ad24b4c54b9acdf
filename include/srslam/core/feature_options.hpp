#pragma once

#include "srslam/core/status.hpp"

namespace srslam {

/// Corners spread evenly over an image and over the levels of its pyramid.
struct FeatureOptions {
  int num_features = 1000;     ///< wanted per frame, 50..20000
  int num_levels = 8;          ///< pyramid levels, 1..12
  double scale_factor = 1.2;   ///< between levels, 1.05..2
  int fast_threshold = 20;     ///< FAST threshold, 1..255
  int min_fast_threshold = 7;  ///< where a cell gives nothing above it, 1..fast_threshold

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (num_features < 50 || num_features > 20000) return bad("num_features must be in 50..20000");
    if (num_levels < 1 || num_levels > 12) return bad("num_levels must be in 1..12");
    if (!(scale_factor >= 1.05 && scale_factor <= 2.0)) {
      return bad("scale_factor must be in 1.05..2");
    }
    if (fast_threshold < 1 || fast_threshold > 255) return bad("fast_threshold must be in 1..255");
    if (min_fast_threshold < 1 || min_fast_threshold > fast_threshold) {
      return bad("min_fast_threshold must be in 1..fast_threshold");
    }
    return Status::success();
  }
};

}  // namespace srslam
