#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "srslam/core/array_view.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/scene_metric.hpp"

namespace srslam {

enum class FeatureQualityForm : std::uint8_t {
  kDefault,  ///< an empty cell counts nothing, a sparse one in proportion
  kLiteral,  ///< as printed, empty cells taken for cells without spread: they score 1
};

struct FeatureQualityOptions {
  /// Response that counts as full: 255 for FAST scores. > 0 [response]
  double response_scale = 255.0;
  /// Features from which on a cell counts in full; > 0, kDefault only.
  int full_cell_count = 10;
  FeatureQualityForm form = FeatureQualityForm::kDefault;

  Status validate() const noexcept {
    if (!(response_scale > 0.0) || !std::isfinite(response_scale)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "response_scale must be positive and finite");
    }
    if (full_cell_count < 1) {
      return Status::failure(StatusCode::kInvalidArgument, "full_cell_count must be positive");
    }
    return Status::success();
  }
};

struct FeatureQualityCell {
  int num_features = 0;
  double mean_response = 0.0;  ///< normalised, [0, 1]
  double response_std = 0.0;   ///< population standard deviation of the normalised responses
  double value = 0.0;          ///< [0, 2]
};

struct FeatureQualityResult {
  SceneMetric metric;  ///< in [0, 2]
  GridArray<FeatureQualityCell> cells{};
  std::size_t num_outside = 0;  ///< features outside the image, which are ignored
};

/// How strong, alike and well spread features are (Eq. 4): the mean over the cells of a 3×3 grid of
/// (mean response + 1 / (1 + standard deviation of the responses)), responses divided by
/// `response_scale` and limited to [0, 1]. kDefault scales a cell by min(1, n / full_cell_count),
/// so that an empty cell gives 0. Responses that are no number count as 0. O(n), allocates nothing.
/// kInvalidArgument for options out of range or an image without size.
inline FeatureQualityResult feature_quality(ArrayView<const Feature> features, int width_px,
                                            int height_px,
                                            const FeatureQualityOptions& options = {}) noexcept {
  FeatureQualityResult result;
  constexpr double kUpperBound = 2.0;
  Status status = options.validate();
  if (status.ok() && (width_px <= 0 || height_px <= 0)) {
    status = Status::failure(StatusCode::kInvalidArgument, "image size must be positive");
  }
  if (!status.ok()) {
    result.metric = detail::failed_metric(status, kUpperBound);
    return result;
  }
  // Relative to the first response of the cell: equal responses have no spread at all.
  GridArray<double> origins{};
  GridArray<double> sums{};
  GridArray<double> sums_of_squares{};
  for (const Feature& feature : features) {
    const int cell = grid_cell(double(feature.u_px), double(feature.v_px), width_px, height_px);
    if (cell < 0) {
      ++result.num_outside;
      continue;
    }
    const double scaled = double(feature.response) / options.response_scale;
    const double response = scaled > 0.0 ? std::min(scaled, 1.0) : 0.0;
    const auto i = static_cast<std::size_t>(cell);
    if (result.cells[i].num_features++ == 0) origins[i] = response;
    const double offset = response - origins[i];
    sums[i] += offset;
    sums_of_squares[i] += offset * offset;
  }
  double total = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    FeatureQualityCell& cell = result.cells[i];
    if (cell.num_features > 0) {
      const double mean_offset = sums[i] / cell.num_features;
      cell.mean_response = origins[i] + mean_offset;
      cell.response_std = std::sqrt(
          std::max(0.0, sums_of_squares[i] / cell.num_features - mean_offset * mean_offset));
    }
    cell.value = cell.mean_response + 1.0 / (1.0 + cell.response_std);
    if (options.form == FeatureQualityForm::kDefault) {
      cell.value *= std::min(1.0, double(cell.num_features) / options.full_cell_count);
    }
    total += cell.value;
  }
  result.metric = detail::metric_of(total / kGridCells, kUpperBound);
  return result;
}

}  // namespace srslam
