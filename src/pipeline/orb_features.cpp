#include "pipeline/orb_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/constants.hpp"
#include "srslam/interop/opencv_views.hpp"

namespace srslam::detail {
namespace {

// ORB samples a 31×31 patch, rotated; a keypoint needs that much image around it.
constexpr int kPatchSize = 31;
constexpr int kPatchRadius = kPatchSize / 2;
constexpr int kBorder = 19;
// cv::FAST leaves three pixels at the edge of what it is given untested.
constexpr int kFastMargin = 3;
// Cells in which the lower FAST threshold is tried when the upper one finds nothing.
constexpr int kThresholdCell = 32;

/// Half width of the circular patch at each row offset from its centre.
std::array<int, kPatchRadius + 1> make_patch_half_widths() {
  std::array<int, kPatchRadius + 1> half_widths{};
  for (int dv = 0; dv <= kPatchRadius; ++dv) {
    half_widths[static_cast<std::size_t>(dv)] =
        static_cast<int>(std::sqrt(double(kPatchRadius * kPatchRadius - dv * dv)));
  }
  return half_widths;
}

/// Orientation of the patch around (u, v): direction from the centre to the intensity centroid.
float patch_angle_rad(const cv::Mat& image, int u, int v) {
  static const std::array<int, kPatchRadius + 1> kHalfWidths = make_patch_half_widths();
  int moment_u = 0;
  int moment_v = 0;
  const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
  const std::uint8_t* centre = image.ptr<std::uint8_t>(v) + u;
  for (int du = -kPatchRadius; du <= kPatchRadius; ++du) moment_u += du * centre[du];
  for (int dv = 1; dv <= kPatchRadius; ++dv) {
    const int half_width = kHalfWidths[static_cast<std::size_t>(dv)];
    const std::uint8_t* below = centre + dv * step;
    const std::uint8_t* above = centre - dv * step;
    int row_difference = 0;
    for (int du = -half_width; du <= half_width; ++du) {
      const int low = below[du];
      const int high = above[du];
      row_difference += low - high;
      moment_u += du * (low + high);
    }
    moment_v += dv * row_difference;
  }
  const double angle = std::atan2(double(moment_v), double(moment_u));
  return static_cast<float>(angle < 0.0 ? angle + kTwoPi : angle);
}

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  // Position breaks ties, so that the choice does not depend on the order of detection.
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  return a.pt.x < b.pt.x;
}

}  // namespace

struct OrbExtractor::Impl {
  struct Level {
    int num_wanted = 0;
    cv::Mat image;
    // Level-0 pixels per pixel of this level; the rounded size makes them differ a little from
    // the nominal scale and from each other.
    float ratio_u = 1.0F;
    float ratio_v = 1.0F;

    // Integers are pixel centres, so halves are added before a length is scaled.
    float to_level0_u(float u) const { return (u + 0.5F) * ratio_u - 0.5F; }
    float to_level0_v(float v) const { return (v + 0.5F) * ratio_v - 0.5F; }
  };

  FeatureOptions options;
  std::vector<Level> levels;
  std::vector<float> scales;
  cv::Ptr<cv::ORB> descriptor;
  // Reused from call to call.
  std::vector<cv::KeyPoint> candidates, cell_candidates, chosen;
  std::vector<int> cell_of_candidate, cell_begin, cell_order;
  cv::Mat descriptors;

  void build_pyramid(const cv::Mat& gray);
  void detect(const Level& level, const ImageView<const std::uint8_t>& mask);
  void detect_in_empty_cells(const cv::Mat& inner);
  void choose_evenly(const cv::Mat& image, int num_wanted);
};

OrbExtractor::OrbExtractor(const FeatureOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  const auto num_levels = static_cast<std::size_t>(options.num_levels);
  impl_->levels.resize(num_levels);
  impl_->scales.resize(num_levels);
  // Shares proportional to the levels' widths: their sum over all levels is num_features.
  const double inverse_factor = 1.0 / options.scale_factor;
  double share = options.num_features * (1.0 - inverse_factor) /
                 (1.0 - std::pow(inverse_factor, options.num_levels));
  double scale = 1.0;
  int assigned = 0;
  for (std::size_t i = 0; i < num_levels; ++i) {
    const bool last = i + 1 == num_levels;
    const int wanted =
        last ? options.num_features - assigned : static_cast<int>(std::lround(share));
    impl_->levels[i].num_wanted = std::max(wanted, 0);
    assigned += wanted;
    impl_->scales[i] = static_cast<float>(scale);
    share *= inverse_factor;
    scale *= options.scale_factor;
  }
  // One level only: the pyramid is ours, each level is described as an image of its own.
  impl_->descriptor = cv::ORB::create(options.num_features, 1.2F, 1, kBorder - kFastMargin, 0, 2,
                                      cv::ORB::FAST_SCORE, kPatchSize, options.fast_threshold);
}

OrbExtractor::~OrbExtractor() = default;

const std::vector<float>& OrbExtractor::level_scales() const { return impl_->scales; }

void OrbExtractor::Impl::build_pyramid(const cv::Mat& gray) {
  levels[0].image = gray;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const cv::Size size(cvRound(float(gray.cols) / scales[i]),
                        cvRound(float(gray.rows) / scales[i]));
    if (size.width <= 2 * kBorder + kFastMargin || size.height <= 2 * kBorder + kFastMargin) {
      levels[i].image.release();  // too small for a patch: this and coarser levels stay empty
      continue;
    }
    cv::resize(levels[i - 1].image, levels[i].image, size, 0, 0, cv::INTER_LINEAR);
    levels[i].ratio_u = float(gray.cols) / float(size.width);
    levels[i].ratio_v = float(gray.rows) / float(size.height);
  }
}

void OrbExtractor::Impl::detect_in_empty_cells(const cv::Mat& inner) {
  const int cols = (inner.cols + kThresholdCell - 1) / kThresholdCell;
  const int rows = (inner.rows + kThresholdCell - 1) / kThresholdCell;
  std::vector<int>& occupied = cell_begin;  // scratch; overwritten when cells are chosen from
  occupied.assign(static_cast<std::size_t>(cols * rows), 0);
  for (const cv::KeyPoint& keypoint : candidates) {
    const int cell = (static_cast<int>(keypoint.pt.y) / kThresholdCell) * cols +
                     static_cast<int>(keypoint.pt.x) / kThresholdCell;
    occupied[static_cast<std::size_t>(cell)] = 1;
  }
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      if (occupied[static_cast<std::size_t>(row * cols + col)] != 0) continue;
      const cv::Rect cell(col * kThresholdCell, row * kThresholdCell, kThresholdCell,
                          kThresholdCell);
      const cv::Rect padded(cell.x - kFastMargin, cell.y - kFastMargin,
                            cell.width + 2 * kFastMargin, cell.height + 2 * kFastMargin);
      const cv::Rect area = padded & cv::Rect(0, 0, inner.cols, inner.rows);
      if (area.width <= 2 * kFastMargin || area.height <= 2 * kFastMargin) continue;
      cv::FAST(inner(area), cell_candidates, options.min_fast_threshold, true);
      for (cv::KeyPoint& keypoint : cell_candidates) {
        keypoint.pt.x += static_cast<float>(area.x);
        keypoint.pt.y += static_cast<float>(area.y);
        candidates.push_back(keypoint);
      }
    }
  }
}

void OrbExtractor::Impl::detect(const Level& level, const ImageView<const std::uint8_t>& mask) {
  constexpr int kOffset = kBorder - kFastMargin;
  const cv::Mat& image = level.image;
  const cv::Mat inner =
      image(cv::Rect(kOffset, kOffset, image.cols - 2 * kOffset, image.rows - 2 * kOffset));
  cv::FAST(inner, candidates, options.fast_threshold, true);
  if (options.min_fast_threshold < options.fast_threshold) detect_in_empty_cells(inner);
  for (cv::KeyPoint& keypoint : candidates) {
    keypoint.pt.x += kOffset;
    keypoint.pt.y += kOffset;
  }
  if (mask.empty()) return;
  const auto hidden = [&](const cv::KeyPoint& keypoint) {
    const int u = std::min(static_cast<int>(std::lround(level.to_level0_u(keypoint.pt.x))),
                           mask.width_px - 1);
    const int v = std::min(static_cast<int>(std::lround(level.to_level0_v(keypoint.pt.y))),
                           mask.height_px - 1);
    return mask(u, v) == 0;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), hidden), candidates.end());
}

void OrbExtractor::Impl::choose_evenly(const cv::Mat& image, int num_wanted) {
  chosen.clear();
  if (static_cast<int>(candidates.size()) <= num_wanted) {
    chosen = candidates;
    std::sort(chosen.begin(), chosen.end(), stronger);
    return;
  }
  const double area = double(image.cols - 2 * kBorder) * double(image.rows - 2 * kBorder);
  const double cell_size = std::max(1.0, std::sqrt(area / std::max(num_wanted, 1)));
  const int cols = std::max(1, cvRound((image.cols - 2 * kBorder) / cell_size));
  const int rows = std::max(1, cvRound((image.rows - 2 * kBorder) / cell_size));
  const auto num_cells = static_cast<std::size_t>(cols * rows);

  // Candidates sorted by cell, strongest first within a cell.
  cell_of_candidate.resize(candidates.size());
  cell_begin.assign(num_cells + 1, 0);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto col = static_cast<int>((candidates[i].pt.x - kBorder) * float(cols) /
                                      float(image.cols - 2 * kBorder));
    const auto row = static_cast<int>((candidates[i].pt.y - kBorder) * float(rows) /
                                      float(image.rows - 2 * kBorder));
    const int cell = std::clamp(row, 0, rows - 1) * cols + std::clamp(col, 0, cols - 1);
    cell_of_candidate[i] = cell;
    ++cell_begin[static_cast<std::size_t>(cell) + 1];
  }
  for (std::size_t cell = 0; cell < num_cells; ++cell) cell_begin[cell + 1] += cell_begin[cell];
  cell_order.resize(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) cell_order[i] = static_cast<int>(i);
  std::sort(cell_order.begin(), cell_order.end(), [&](int a, int b) {
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    if (cell_of_candidate[ia] != cell_of_candidate[ib]) {
      return cell_of_candidate[ia] < cell_of_candidate[ib];
    }
    return stronger(candidates[ia], candidates[ib]);
  });

  // Round r takes the r-th strongest corner of every cell that has one; the round that would
  // overshoot gives its strongest only.
  for (int round = 0; static_cast<int>(chosen.size()) < num_wanted; ++round) {
    const std::size_t round_begin = chosen.size();
    for (std::size_t cell = 0; cell < num_cells; ++cell) {
      const int index = cell_begin[cell] + round;
      if (index < cell_begin[cell + 1]) {
        chosen.push_back(
            candidates[static_cast<std::size_t>(cell_order[static_cast<std::size_t>(index)])]);
      }
    }
    if (static_cast<int>(chosen.size()) > num_wanted) {
      std::sort(chosen.begin() + static_cast<std::ptrdiff_t>(round_begin), chosen.end(), stronger);
      chosen.resize(static_cast<std::size_t>(num_wanted));
    }
  }
}

void OrbExtractor::extract(const ImageView<const std::uint8_t>& gray,
                           const ImageView<const std::uint8_t>& mask, OrbFeatures* output) {
  output->features.clear();
  output->descriptors.clear();
  impl_->build_pyramid(as_mat(gray));
  for (std::size_t i = 0; i < impl_->levels.size(); ++i) {
    const Impl::Level& level = impl_->levels[i];
    const cv::Mat& image = level.image;
    if (image.cols <= 2 * kBorder + kFastMargin || image.rows <= 2 * kBorder + kFastMargin) break;
    impl_->detect(level, mask);
    impl_->choose_evenly(image, level.num_wanted);
    if (impl_->chosen.empty()) continue;
    for (cv::KeyPoint& keypoint : impl_->chosen) {
      const float angle = patch_angle_rad(image, cvRound(keypoint.pt.x), cvRound(keypoint.pt.y));
      keypoint.angle = static_cast<float>(angle * 360.0 / kTwoPi);
      keypoint.octave = 0;
      Feature feature;
      feature.u_px = level.to_level0_u(keypoint.pt.x);
      feature.v_px = level.to_level0_v(keypoint.pt.y);
      feature.response = keypoint.response;
      feature.angle_rad = angle;
      feature.scale = impl_->scales[i];
      feature.octave = static_cast<std::int32_t>(i);
      output->features.push_back(feature);
    }
    // Keypoints keep kBorder from the edge, so compute() drops none and rows match `chosen`.
    impl_->descriptor->compute(image, impl_->chosen, impl_->descriptors);
    for (int row = 0; row < impl_->descriptors.rows; ++row) {
      BinaryDescriptor descriptor;
      static_assert(sizeof(descriptor) == 32, "ORB descriptors have 256 bits");
      std::memcpy(descriptor.data(), impl_->descriptors.ptr(row), sizeof(descriptor));
      output->descriptors.push_back(descriptor);
    }
  }
}

}  // namespace srslam::detail
