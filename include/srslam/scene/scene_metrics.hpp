#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// What a metric over detections says of a frame without any. A frame without detections is no
/// worse and no better than others, so that the default leaves the metric out.
enum class NoDetections : std::uint8_t {
  kAbsent,  ///< the metric does not count for this frame
  kZero,    ///< as the printed sum over nothing
  kOne,     ///< the upper end of the metric's range
};

/// A metric of one frame. Without `present` it has no value, which is not the same as zero.
struct SceneMetric {
  Status status;                                            ///< kOk also when the metric is absent
  bool present = false;                                     ///< false: absent, `value` is NaN
  double value = std::numeric_limits<double>::quiet_NaN();  ///< in [0, upper_bound]
  double upper_bound = 1.0;

  /// Value in [0, 1]; NaN when absent.
  double normalized() const noexcept { return value / upper_bound; }
};

// ---------------------------------------------------------------------------------------------
// Detection confidence (Eq. 2)

struct DetectionConfidenceOptions {
  double min_score = 0.25;  ///< detections below are left out; [0, 1]
  NoDetections no_detections = NoDetections::kAbsent;

  Status validate() const noexcept {
    if (min_score >= 0.0 && min_score <= 1.0) return Status::success();
    return Status::failure(StatusCode::kInvalidArgument, "min_score must be between 0 and 1");
  }
};

struct DetectionConfidenceResult {
  SceneMetric metric;  ///< in [0, 1]
  std::size_t num_used = 0;
  std::size_t num_ignored = 0;  ///< below min_score, or with a score that is no number in [0, 1]
};

// ---------------------------------------------------------------------------------------------
// Spatial distribution (Eq. 3)

/// What the distance between an object and the image's centre is divided by.
enum class CenterDistanceScale : std::uint8_t {
  kDiagonal,      ///< the image's diagonal, as printed: the term stays in [0.5, 1]
  kHalfDiagonal,  ///< the largest distance inside the image: the term uses [0, 1]
};

/// Whether a central object makes a frame more reliable or less.
enum class CenterMeaning : std::uint8_t {
  kAttention,  ///< more, as printed: what is central is what the camera attends to
  kOcclusion,  ///< less: what is central hides the most
};

struct SpatialDistributionOptions {
  double min_score = 0.25;  ///< detections below are left out; [0, 1]
  CenterDistanceScale distance_scale = CenterDistanceScale::kDiagonal;
  CenterMeaning center = CenterMeaning::kAttention;
  NoDetections no_detections = NoDetections::kAbsent;

  Status validate() const noexcept {
    return DetectionConfidenceOptions{min_score, no_detections}.validate();
  }
};

struct SpatialDistributionResult {
  SceneMetric metric;               ///< in [0, 2]
  double mean_area_term = 0.0;      ///< of 1 - area / image area
  double mean_distance_term = 0.0;  ///< of 1 - distance / scale, or of distance / scale
  std::size_t num_used = 0;
  std::size_t num_ignored = 0;  ///< below min_score, without number, or outside the image
};

// ---------------------------------------------------------------------------------------------
// Feature quality (Eq. 4)

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

// ---------------------------------------------------------------------------------------------
// Depth quality (Eq. 5)

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

// ---------------------------------------------------------------------------------------------
// Current reliability (Eq. 1)

enum class CurrentReliabilityForm : std::uint8_t {
  kDefault,        ///< weighted mean of the normalised metrics that are present, in [0, 1]
  kLiteral,        ///< plain sum of the metrics as printed, absent ones left out
  kMinimum,        ///< smallest normalised metric: one bad metric is enough
  kGeometricMean,  ///< weighted, between the two
};

struct SceneMetrics {
  SceneMetric confidence;  ///< Eq. 2
  SceneMetric spatial;     ///< Eq. 3
  SceneMetric feature;     ///< Eq. 4
  SceneMetric depth;       ///< Eq. 5
};

struct CurrentReliabilityOptions {
  CurrentReliabilityForm form = CurrentReliabilityForm::kDefault;
  double confidence_weight = 1.0;  ///< >= 0, not all 0
  double spatial_weight = 1.0;
  double feature_weight = 1.0;
  double depth_weight = 1.0;

  Status validate() const noexcept {
    double sum = 0.0;
    for (const double weight : {confidence_weight, spatial_weight, feature_weight, depth_weight}) {
      if (!(weight >= 0.0) || !std::isfinite(weight)) {
        return Status::failure(StatusCode::kInvalidArgument,
                               "weights must be finite and not negative");
      }
      sum += weight;
    }
    if (sum > 0.0) return Status::success();
    return Status::failure(StatusCode::kInvalidArgument, "at least one weight must be positive");
  }
};

struct CurrentReliabilityResult {
  Status status;  ///< kInsufficientData when no metric with a positive weight is present
  double value = std::numeric_limits<double>::quiet_NaN();
  int num_metrics = 0;  ///< that counted
};

namespace detail {

inline SceneMetric metric_of(double value, double upper_bound) noexcept {
  SceneMetric metric;
  metric.status = Status::success();
  metric.present = true;
  metric.value = std::clamp(value, 0.0, upper_bound);
  metric.upper_bound = upper_bound;
  return metric;
}

inline SceneMetric failed_metric(const Status& status, double upper_bound) noexcept {
  SceneMetric metric;
  metric.status = status;
  metric.upper_bound = upper_bound;
  return metric;
}

inline SceneMetric metric_without_detections(NoDetections rule, double upper_bound) noexcept {
  if (rule == NoDetections::kZero) return metric_of(0.0, upper_bound);
  if (rule == NoDetections::kOne) return metric_of(upper_bound, upper_bound);
  return failed_metric(Status::success(), upper_bound);
}

inline bool counts(const Detection& detection, double min_score) noexcept {
  return detection.score >= min_score && detection.score <= 1.0;
}

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

/// Mean score of the detections (Eq. 2). O(n), allocates nothing. kInvalidArgument for options out
/// of range.
inline DetectionConfidenceResult detection_confidence(
    ArrayView<const Detection> detections,
    const DetectionConfidenceOptions& options = {}) noexcept {
  DetectionConfidenceResult result;
  const Status status = options.validate();
  if (!status.ok()) {
    result.metric = detail::failed_metric(status, 1.0);
    return result;
  }
  double sum = 0.0;
  for (const Detection& detection : detections) {
    if (!detail::counts(detection, options.min_score)) {
      ++result.num_ignored;
      continue;
    }
    sum += detection.score;
    ++result.num_used;
  }
  result.metric = result.num_used == 0
                      ? detail::metric_without_detections(options.no_detections, 1.0)
                      : detail::metric_of(sum / double(result.num_used), 1.0);
  return result;
}

/// How little of the image objects take, and how central they are (Eq. 3): the mean over objects of
/// (1 - area / image area) + (1 - distance of the centre / scale). Boxes are clipped to the image.
/// `mask_areas_px`, if not empty, has one area a detection [px²], negative where there is none, and
/// takes the place of the boxes' areas. O(n), allocates nothing. kInvalidArgument for options out
/// of range, an image without size, or another number of areas than detections.
inline SpatialDistributionResult spatial_distribution(
    ArrayView<const Detection> detections, int width_px, int height_px,
    const SpatialDistributionOptions& options = {},
    ArrayView<const double> mask_areas_px = {}) noexcept {
  SpatialDistributionResult result;
  constexpr double kUpperBound = 2.0;
  Status status = options.validate();
  if (status.ok() && (width_px <= 0 || height_px <= 0)) {
    status = Status::failure(StatusCode::kInvalidArgument, "image size must be positive");
  }
  if (status.ok() && !mask_areas_px.empty() && mask_areas_px.size != detections.size) {
    status = Status::failure(StatusCode::kInvalidArgument, "one mask area a detection is needed");
  }
  if (!status.ok()) {
    result.metric = detail::failed_metric(status, kUpperBound);
    return result;
  }
  // Pixel centres are integers: the image reaches half a pixel beyond them.
  const double right = width_px - 0.5;
  const double bottom = height_px - 0.5;
  const double center_u = 0.5 * (width_px - 1);
  const double center_v = 0.5 * (height_px - 1);
  const double diagonal = std::hypot(double(width_px), double(height_px));
  const double scale =
      options.distance_scale == CenterDistanceScale::kDiagonal ? diagonal : 0.5 * diagonal;
  const double image_area = double(width_px) * double(height_px);
  double area_sum = 0.0;
  double distance_sum = 0.0;
  for (std::size_t i = 0; i < detections.size; ++i) {
    const Detection& detection = detections[i];
    const double u_min = std::clamp(detection.x_min_px, -0.5, right);
    const double u_max = std::clamp(detection.x_max_px, -0.5, right);
    const double v_min = std::clamp(detection.y_min_px, -0.5, bottom);
    const double v_max = std::clamp(detection.y_max_px, -0.5, bottom);
    // Negated, so that a box with a NaN is ignored, too.
    if (!detail::counts(detection, options.min_score) || !(u_max > u_min) || !(v_max > v_min)) {
      ++result.num_ignored;
      continue;
    }
    double area = (u_max - u_min) * (v_max - v_min);
    if (!mask_areas_px.empty() && mask_areas_px[i] >= 0.0) area = mask_areas_px[i];
    const double distance =
        std::hypot(0.5 * (u_min + u_max) - center_u, 0.5 * (v_min + v_max) - center_v);
    const double away = std::min(1.0, distance / scale);
    area_sum += std::max(0.0, 1.0 - area / image_area);
    distance_sum += options.center == CenterMeaning::kAttention ? 1.0 - away : away;
    ++result.num_used;
  }
  if (result.num_used == 0) {
    result.metric = detail::metric_without_detections(options.no_detections, kUpperBound);
    return result;
  }
  result.mean_area_term = area_sum / double(result.num_used);
  result.mean_distance_term = distance_sum / double(result.num_used);
  result.metric = detail::metric_of(result.mean_area_term + result.mean_distance_term, kUpperBound);
  return result;
}

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

/// The metrics of a frame in one number (Eq. 1). Metrics that are absent, failed or have weight 0
/// do not count.
inline CurrentReliabilityResult current_reliability(
    const SceneMetrics& metrics, const CurrentReliabilityOptions& options = {}) noexcept {
  CurrentReliabilityResult result;
  result.status = options.validate();
  if (!result.status.ok()) return result;
  const std::array<std::pair<const SceneMetric*, double>, 4> terms{
      {{&metrics.confidence, options.confidence_weight},
       {&metrics.spatial, options.spatial_weight},
       {&metrics.feature, options.feature_weight},
       {&metrics.depth, options.depth_weight}}};
  double weight_sum = 0.0;
  double sum = 0.0;
  double literal_sum = 0.0;
  double smallest = 1.0;
  double log_sum = 0.0;
  for (const auto& [metric, weight] : terms) {
    if (!metric->present || weight == 0.0) continue;
    const double normalized = metric->normalized();
    ++result.num_metrics;
    weight_sum += weight;
    sum += weight * normalized;
    literal_sum += metric->value;
    smallest = std::min(smallest, normalized);
    log_sum += weight * std::log(normalized);  // -infinity for 0, whose exponential is 0 again
  }
  if (result.num_metrics == 0) {
    result.status =
        Status::failure(StatusCode::kInsufficientData, "no metric with a weight is present");
    return result;
  }
  result.status = Status::success();
  switch (options.form) {
    case CurrentReliabilityForm::kDefault:
      result.value = sum / weight_sum;
      break;
    case CurrentReliabilityForm::kLiteral:
      result.value = literal_sum;
      break;
    case CurrentReliabilityForm::kMinimum:
      result.value = smallest;
      break;
    case CurrentReliabilityForm::kGeometricMean:
      result.value = std::exp(log_sum / weight_sum);
      break;
  }
  return result;
}

}  // namespace srslam
