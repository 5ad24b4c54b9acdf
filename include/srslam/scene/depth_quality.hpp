#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "srslam/core/grid.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/scene_metric.hpp"

namespace srslam {

enum class DepthQualityForm : std::uint8_t {
  kDefault,  ///< a cell with hardly any depth has neither spread nor gradient to be praised for
  kLiteral,  ///< as printed, spread and gradient of an empty cell taken for 0: it scores 2 of 3
};

struct DepthQualityOptions {
  double min_depth_m = 0.1;  ///< depth is valid strictly between these
  double max_depth_m = 8.0;
  double max_std_m = 1.0;               ///< C_m: standard deviation at which its term is 0
  double max_gradient_m_per_px = 0.05;  ///< S_m: mean gradient at which its term is 0
  /// A cell needs this many valid samples, and this share of its samples, for the two terms.
  int min_valid_samples = 16;
  double min_valid_share = 0.01;
  /// Every pixel of every row_step-th row is looked at, its gradient between direct neighbours: a
  /// row at a time is what caches and vector units like. [1, 64]
  int row_step = 4;
  /// Width for which max_gradient_m_per_px holds: in smaller images a pixel spans more of the
  /// scene.
  int reference_width_px = 640;
  DepthQualityForm form = DepthQualityForm::kDefault;

  Status validate() const noexcept {
    const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
    if (!(min_depth_m >= 0.0) || !positive(max_depth_m) || !(max_depth_m > min_depth_m)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "the depth range must be finite, not negative and not empty");
    }
    if (!positive(max_std_m) || !positive(max_gradient_m_per_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "max_std_m and max_gradient_m_per_px must be positive and finite");
    }
    if (min_valid_samples < 1 || !(min_valid_share >= 0.0) || min_valid_share > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "min_valid_samples must be positive, min_valid_share in [0, 1]");
    }
    if (row_step < 1 || row_step > 64 || reference_width_px < 1) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "row_step must be 1 to 64, reference_width_px positive");
    }
    return Status::success();
  }
};

struct DepthQualityCell {
  int num_samples = 0;
  int num_valid = 0;
  int num_gradients = 0;
  double std_m = 0.0;                   ///< of the valid samples
  double mean_gradient_m_per_px = 0.0;  ///< at the reference width
  double coverage_term = 0.0;
  double std_term = 0.0;
  double gradient_term = 0.0;
  double value() const noexcept { return coverage_term + std_term + gradient_term; }
};

struct DepthQualityResult {
  SceneMetric metric;  ///< in [0, 3]
  GridArray<DepthQualityCell> cells{};
};

namespace detail {

/// Sums over the samples of one cell. Depths are taken relative to a valid one, so that the
/// variance of a distant, flat wall keeps its digits.
struct DepthSums {
  int num_samples = 0;
  int num_valid = 0;
  int num_gradients = 0;
  float origin_m = 0.0F;
  double sum = 0.0;
  double sum_squares = 0.0;
  double sum_gradients = 0.0;
};

/// Limits of valid depth; false for NaN, too.
struct DepthRange {
  float low_m;
  float high_m;
  bool holds(float depth_m) const noexcept { return depth_m > low_m && depth_m < high_m; }
};

/// Depth of `size` pixels where it is valid and `otherwise` where not, and 1 or 0 to tell. Choice
/// and arithmetic are loops of their own: compilers make vector code of each, but not of arithmetic
/// under a condition, which might raise floating-point exceptions that the condition avoids.
template <typename Pixel, typename ToMetres>
void read_depth(const Pixel* pixels, int size, const ToMetres& to_metres, const DepthRange& range,
                float otherwise_m, float* depth_m, int* valid) noexcept {
  for (int k = 0; k < size; ++k) depth_m[k] = to_metres(pixels[k]);
  for (int k = 0; k < size; ++k) {
    valid[k] = int(depth_m[k] > range.low_m) & int(depth_m[k] < range.high_m);
  }
  for (int k = 0; k < size; ++k) depth_m[k] = valid[k] != 0 ? depth_m[k] : otherwise_m;
}

/// Adds the pixels [u_begin, u_end) of a row to a cell. `above` and `below` are the neighbouring
/// rows, or null at the image's edges; columns 0 and width - 1 have no gradient.
template <typename Pixel, typename ToMetres>
void add_depth_segment(const Pixel* row, const Pixel* above, const Pixel* below, int u_begin,
                       int u_end, int width, const ToMetres& to_metres, const DepthRange& range,
                       DepthSums* sums) noexcept {
  constexpr int kBlock = 64;
  sums->num_samples += u_end - u_begin;
  int u = u_begin;
  if (sums->num_valid == 0) {
    // The first valid depth is the origin; what lies before it is not valid.
    while (u < u_end && !range.holds(to_metres(row[u]))) ++u;
    if (u == u_end) return;
    sums->origin_m = to_metres(row[u]);
  }
  const float origin_m = sums->origin_m;
  std::array<float, kBlock> up_m{};
  std::array<float, kBlock> down_m{};
  std::array<int, kBlock> up_valid{};
  std::array<int, kBlock> down_valid{};
  for (; u < u_end; u += kBlock) {
    const int size = std::min(kBlock, u_end - u);
    // The block from index 1 on, with a neighbour on either side, of which the image's edge has
    // none.
    const int first = u > 0 ? 0 : 1;
    const int last = u + size < width ? size + 2 : size + 1;
    std::array<float, kBlock + 2> depth_m{};
    std::array<int, kBlock + 2> valid{};
    read_depth(row + (u + first - 1), last - first, to_metres, range, origin_m,
               depth_m.data() + first, valid.data() + first);
    Eigen::Array<float, kBlock, 1> values = Eigen::Array<float, kBlock, 1>::Zero();
    int count = 0;
    for (int k = 0; k < size; ++k) {
      values[k] = depth_m[std::size_t(k) + 1] - origin_m;
      count += valid[std::size_t(k) + 1];
    }
    sums->num_valid += count;
    sums->sum += double(values.sum());
    sums->sum_squares += double(values.square().sum());
    if (above == nullptr || below == nullptr) continue;

    read_depth(above + u, size, to_metres, range, origin_m, up_m.data(), up_valid.data());
    read_depth(below + u, size, to_metres, range, origin_m, down_m.data(), down_valid.data());
    count = 0;
    for (int k = 0; k < size; ++k) {
      const auto i = std::size_t(k);
      const int surrounded = valid[i] & valid[i + 1] & valid[i + 2] & up_valid[i] & down_valid[i];
      const float du = depth_m[i + 2] - depth_m[i];
      const float dv = down_m[i] - up_m[i];
      values[k] = float(surrounded) * (du * du + dv * dv);
      count += surrounded;
    }
    sums->num_gradients += count;
    // Central differences span two pixels.
    sums->sum_gradients += 0.5 * double(values.sqrt().sum());
  }
}

template <typename Pixel, typename ToMetres>
DepthQualityResult depth_quality_of(const ImageView<const Pixel>& depth, const ToMetres& to_metres,
                                    const DepthQualityOptions& options) noexcept {
  DepthQualityResult result;
  constexpr double kUpperBound = 3.0;
  Status status = options.validate();
  if (status.ok()) status = depth.validate();
  if (!status.ok()) {
    result.metric = failed_metric(status, kUpperBound);
    return result;
  }
  const DepthRange range{static_cast<float>(options.min_depth_m),
                         static_cast<float>(options.max_depth_m)};
  // First column of each column of cells, as grid_cell() has them: the smallest u with
  // floor(3 u / width) = col.
  std::array<int, kGridCols + 1> column_begin{};
  for (int col = 0; col <= kGridCols; ++col) {
    column_begin[static_cast<std::size_t>(col)] =
        (col * depth.width_px + kGridCols - 1) / kGridCols;
  }
  GridArray<DepthSums> grid{};
  for (int v = 0; v < depth.height_px; v += options.row_step) {
    const bool inside = v > 0 && v + 1 < depth.height_px;
    const int cell_row = kGridCols * (kGridRows * v / depth.height_px);
    for (int col = 0; col < kGridCols; ++col) {
      add_depth_segment(depth.row(v), inside ? depth.row(v - 1) : nullptr,
                        inside ? depth.row(v + 1) : nullptr,
                        column_begin[static_cast<std::size_t>(col)],
                        column_begin[static_cast<std::size_t>(col + 1)], depth.width_px, to_metres,
                        range, &grid[static_cast<std::size_t>(cell_row + col)]);
    }
  }

  const double gradient_scale = double(depth.width_px) / options.reference_width_px;
  double total = 0.0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const DepthSums& sums = grid[i];
    DepthQualityCell& cell = result.cells[i];
    cell.num_samples = sums.num_samples;
    cell.num_valid = sums.num_valid;
    cell.num_gradients = sums.num_gradients;
    if (sums.num_samples > 0) cell.coverage_term = double(sums.num_valid) / sums.num_samples;
    if (sums.num_valid > 0) {
      const double mean = sums.sum / sums.num_valid;
      cell.std_m = std::sqrt(std::max(0.0, sums.sum_squares / sums.num_valid - mean * mean));
    }
    if (sums.num_gradients > 0) {
      cell.mean_gradient_m_per_px = gradient_scale * sums.sum_gradients / sums.num_gradients;
    }
    const double needed =
        std::max(double(options.min_valid_samples), options.min_valid_share * sums.num_samples);
    if (options.form == DepthQualityForm::kLiteral || sums.num_valid >= needed) {
      cell.std_term = 1.0 - std::min(1.0, cell.std_m / options.max_std_m);
      cell.gradient_term =
          1.0 - std::min(1.0, cell.mean_gradient_m_per_px / options.max_gradient_m_per_px);
    }
    total += cell.value();
  }
  result.metric = metric_of(total / kGridCells, kUpperBound);
  return result;
}

}  // namespace detail

/// How complete and even depth is (Eq. 5): the mean over the cells of a 3×3 grid of valid share,
/// (1 - standard deviation / max_std_m) and (1 - mean gradient / max_gradient_m_per_px), the last
/// two not below 0. `depth_m` in metres; invalid is what is not strictly between the limits, NaN
/// included. O(pixels / row_step), allocates nothing. kInvalidArgument for options out of range or
/// a view that cannot be read.
inline DepthQualityResult depth_quality(const ImageView<const float>& depth_m,
                                        const DepthQualityOptions& options = {}) noexcept {
  return detail::depth_quality_of(
      depth_m, [](float value) { return value; }, options);
}

/// The same on raw 16-bit depth with `depth_units_per_m` units a metre (> 0), as sensors and files
/// give it.
inline DepthQualityResult depth_quality(const ImageView<const std::uint16_t>& raw_depth,
                                        double depth_units_per_m,
                                        const DepthQualityOptions& options = {}) noexcept {
  if (!(depth_units_per_m > 0.0) || !std::isfinite(depth_units_per_m)) {
    DepthQualityResult result;
    result.metric =
        detail::failed_metric(Status::failure(StatusCode::kInvalidArgument,
                                              "depth_units_per_m must be positive and finite"),
                              3.0);
    return result;
  }
  const auto m_per_unit = static_cast<float>(1.0 / depth_units_per_m);
  return detail::depth_quality_of(
      raw_depth, [m_per_unit](std::uint16_t value) { return float(value) * m_per_unit; }, options);
}

}  // namespace srslam
