#include "srslam/io/depth_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

namespace srslam {
namespace {

constexpr double kMinValidShare = 0.1;
// Structured-light and time-of-flight sensors measure between these distances indoors.
constexpr double kMinMedian_m = 0.3;
constexpr double kMaxMedian_m = 10.0;

}  // namespace

DepthSummary summarize_depth(ImageView<const float> depth_m) {
  DepthSummary summary;
  if (depth_m.empty()) return summary;
  std::vector<float> valid;
  for (int v = 0; v < depth_m.height_px; ++v) {
    const float* row = depth_m.row(v);
    std::copy_if(row, row + depth_m.width_px, std::back_inserter(valid),
                 [](float depth) { return std::isfinite(depth) && depth > 0.0F; });
  }
  if (valid.empty()) return summary;
  const auto middle = valid.begin() + static_cast<std::ptrdiff_t>(valid.size() / 2);
  std::nth_element(valid.begin(), middle, valid.end());
  summary.median_m = static_cast<double>(*middle);
  summary.valid_share = static_cast<double>(valid.size()) /
                        (static_cast<double>(depth_m.width_px) * depth_m.height_px);
  return summary;
}

Status check_depth_plausible(const DepthSummary& summary) noexcept {
  if (!(summary.valid_share >= kMinValidShare)) {
    return Status::failure(StatusCode::kInsufficientData,
                           "less than a tenth of the depth pixels is valid");
  }
  if (!(summary.median_m >= kMinMedian_m)) {
    return Status::failure(StatusCode::kInvalidArgument,
                           "median depth is below 0.3 m; depth_units_per_m may be too large");
  }
  if (!(summary.median_m <= kMaxMedian_m)) {
    return Status::failure(StatusCode::kInvalidArgument,
                           "median depth is above 10 m; depth_units_per_m may be too small");
  }
  return Status::success();
}

}  // namespace srslam
