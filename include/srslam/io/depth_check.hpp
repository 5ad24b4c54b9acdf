#pragma once

#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// What one depth image holds, to tell a wrong depth scale before a run is wasted on it.
struct DepthSummary {
  double valid_share = 0.0;  ///< of pixels that are finite and > 0, in [0, 1]
  double median_m = 0.0;     ///< of the valid pixels (upper of the two middle ones); 0 without any
};

/// Summarises a depth image. An image without pixels gives zeros. Linear time; copies the valid
/// depths.
DepthSummary summarize_depth(ImageView<const float> depth_m);

/// Whether an image is what an indoor RGB-D sensor gives: at least a tenth of its pixels valid and
/// a median between 0.3 m and 10 m. Not ok means "worth a warning", not "wrong": it finds units
/// taken for others (metres, millimetres, the inverse of the scale), not a scale that is wrong by
/// a small factor.
Status check_depth_plausible(const DepthSummary& summary) noexcept;

}  // namespace srslam
