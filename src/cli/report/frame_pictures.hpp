#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "cli/report/feature_store.hpp"
#include "cli/run_inputs.hpp"
#include "cli/run_result.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/image_view.hpp"

namespace srslam::cli {

/// A frame that the page shows, and why.
struct ChosenFrame {
  std::size_t record = 0;  ///< place in RunResult::records
  std::string reason;      ///< "largest error", "lost"; empty: one of the evenly spread
};

/// At most `max_frames` of the frames that the pipeline took, in their order: the one of the
/// largest absolute error, the first of each of the longest lost spans, the others evenly spread.
std::vector<ChosenFrame> choose_frames(const RunResult& result, std::size_t max_frames);

/// Absolute errors [m] of the tracked frames that have one, by time stamp.
std::map<double, double> absolute_errors_m(const RunResult& result);

/// JPEG of `gray` with what `mask` (empty: none) marks tinted, features coloured by label and
/// boxes; empty when it cannot be made. A mask of another size is left out.
std::string overlay_jpeg(ImageView<const std::uint8_t> gray, ImageView<const std::uint8_t> mask,
                         const std::vector<DrawnFeature>& features,
                         const std::vector<Detection>& detections);

/// The chosen frames as a part of a page; says so when there are none.
std::string frame_pictures_html(const RunInputs& inputs, const RunResult& result,
                                const FeatureStore& features);

}  // namespace srslam::cli
