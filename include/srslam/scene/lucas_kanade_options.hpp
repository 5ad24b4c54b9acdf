#pragma once

#include <cmath>

#include "srslam/core/status.hpp"

namespace srslam {

/// Pyramidal Lucas–Kanade flow. The defaults are a tenth of the cost of OpenCV's at the same worth
/// for the motion residual (docs/scene_reliability.md).
struct LucasKanadeOptions {
  int window_px = 9;             ///< side of the square window, 3..63
  int num_levels = 4;            ///< of the pyramid, 1..10
  int max_iterations = 10;       ///< a level and point, 1..100
  double epsilon_px = 0.03;      ///< a step shorter than this ends the iteration; > 0
  double min_eigenvalue = 1e-4;  ///< of the window's normal matrix, below it a point is lost; >= 0
  /// A point followed there and back must end this near to where it began; <= 0: not checked.
  double max_forward_backward_px = 1.0;
  /// Levels of the way back, which starts from the point of origin; 1..num_levels.
  int backward_levels = 1;
  double border_px = 5.0;  ///< a point this near to the image's edge is lost; >= 0
  int history = 8;         ///< last frames that may become the reference, 1..30

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (window_px < 3 || window_px > 63) return bad("window_px must be 3 to 63");
    if (num_levels < 1 || num_levels > 10) return bad("num_levels must be 1 to 10");
    if (max_iterations < 1 || max_iterations > 100) return bad("max_iterations must be 1 to 100");
    if (!(epsilon_px > 0.0) || !std::isfinite(epsilon_px))
      return bad("epsilon_px must be positive");
    if (!(min_eigenvalue >= 0.0) || !std::isfinite(min_eigenvalue)) {
      return bad("min_eigenvalue must not be negative");
    }
    if (!std::isfinite(max_forward_backward_px)) {
      return bad("max_forward_backward_px must be finite");
    }
    if (backward_levels < 1 || backward_levels > num_levels) {
      return bad("backward_levels must be 1 to num_levels");
    }
    if (!(border_px >= 0.0) || !std::isfinite(border_px))
      return bad("border_px must not be negative");
    if (history < 1 || history > 30) return bad("history must be 1 to 30");
    return Status::success();
  }
};

}  // namespace srslam
