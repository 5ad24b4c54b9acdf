#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/feature_options.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/interop/opencv_views.hpp"

namespace srslam {

/// FAST corners spread evenly over the image and over the levels of a pyramid. Every level is cut
/// into about as many cells as it should give corners; cells give their strongest ones in turn
/// until the level has its share, so that texture in one part of the image cannot use up the
/// budget. Keeps its buffers between calls; OpenCV allocates inside. Not thread-safe.
class CornerPyramid {
 public:
  /// cv::FAST leaves so many pixels at the edge of what it is given untested.
  static constexpr int kFastMargin = 3;

  struct Level {
    float scale = 1.0F;  ///< nominal size of a pixel in pixels of level 0
    int num_wanted = 0;
    /// Empty where it would be too small for a corner, as are coarser levels then.
    cv::Mat image;
    std::vector<cv::KeyPoint> corners;  ///< in pixels of this level
    // Level-0 pixels per pixel of this level; the rounded size makes them differ a little from
    // the nominal scale and from each other.
    float ratio_u = 1.0F;
    float ratio_v = 1.0F;

    // Integers are pixel centres, so halves are added before a length is scaled.
    float to_level0_u(float u) const { return (u + 0.5F) * ratio_u - 0.5F; }
    float to_level0_v(float v) const { return (v + 0.5F) * ratio_v - 0.5F; }
  };

  /// `border_px`: pixels at the edge of every level without corners, at least kFastMargin.
  /// Precondition: options.validate().
  explicit CornerPyramid(const FeatureOptions& options, int border_px)
      : options_(options), border_px_(std::max(border_px, kFastMargin)) {
    const auto num_levels = static_cast<std::size_t>(options.num_levels);
    levels_.resize(num_levels);
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
      levels_[i].num_wanted = std::max(wanted, 0);
      assigned += wanted;
      levels_[i].scale = static_cast<float>(scale);
      share *= inverse_factor;
      scale *= options.scale_factor;
    }
  }

  /// Finds the corners of all levels. `mask` may be empty; else it has the size of `gray` and no
  /// corner is taken where it is 0. Corners of a level are ordered by cell and depend on nothing
  /// but the input. Level 0 refers to `gray`, which must live as long as its image is read.
  void detect(const ImageView<const std::uint8_t>& gray,
              const ImageView<const std::uint8_t>& mask) {
    build(as_mat(gray));
    for (Level& level : levels_) {
      level.corners.clear();
      if (level.image.empty()) continue;
      find_candidates(level, mask);
      choose_evenly(&level);
    }
  }

  ArrayView<Level> levels() noexcept { return levels_; }

 private:
  // Cells in which the lower FAST threshold is tried when the upper one finds nothing.
  static constexpr int kThresholdCell = 32;

  bool is_large_enough(const cv::Size& size) const {
    return size.width > 2 * border_px_ + kFastMargin && size.height > 2 * border_px_ + kFastMargin;
  }

  static bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
    // Position breaks ties, so that the choice does not depend on the order of detection.
    if (a.response != b.response) return a.response > b.response;
    if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
    return a.pt.x < b.pt.x;
  }

  void build(const cv::Mat& gray) {
    bool reached_end = false;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      Level& level = levels_[i];
      const cv::Size size(cvRound(float(gray.cols) / level.scale),
                          cvRound(float(gray.rows) / level.scale));
      reached_end = reached_end || !is_large_enough(size);
      if (reached_end) {
        level.image.release();
        continue;
      }
      if (i == 0) {
        level.image = gray;
        continue;
      }
      cv::resize(levels_[i - 1].image, level.image, size, 0, 0, cv::INTER_LINEAR);
      level.ratio_u = float(gray.cols) / float(size.width);
      level.ratio_v = float(gray.rows) / float(size.height);
    }
  }

  void find_candidates(const Level& level, const ImageView<const std::uint8_t>& mask) {
    const int offset = border_px_ - kFastMargin;
    const cv::Mat& image = level.image;
    const cv::Mat inner =
        image(cv::Rect(offset, offset, image.cols - 2 * offset, image.rows - 2 * offset));
    cv::FAST(inner, candidates_, options_.fast_threshold, true);
    if (options_.min_fast_threshold < options_.fast_threshold) search_empty_cells(inner);
    for (cv::KeyPoint& keypoint : candidates_) {
      keypoint.pt.x += static_cast<float>(offset);
      keypoint.pt.y += static_cast<float>(offset);
    }
    if (mask.empty()) return;
    const auto hidden = [&](const cv::KeyPoint& keypoint) {
      const int u = std::min(static_cast<int>(std::lround(level.to_level0_u(keypoint.pt.x))),
                             mask.width_px - 1);
      const int v = std::min(static_cast<int>(std::lround(level.to_level0_v(keypoint.pt.y))),
                             mask.height_px - 1);
      return mask(u, v) == 0;
    };
    candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), hidden),
                      candidates_.end());
  }

  void search_empty_cells(const cv::Mat& inner) {
    const int cols = (inner.cols + kThresholdCell - 1) / kThresholdCell;
    const int rows = (inner.rows + kThresholdCell - 1) / kThresholdCell;
    std::vector<int>& occupied = cell_begin_;  // scratch; overwritten when cells are chosen from
    occupied.assign(static_cast<std::size_t>(cols * rows), 0);
    for (const cv::KeyPoint& keypoint : candidates_) {
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
        cv::FAST(inner(area), cell_candidates_, options_.min_fast_threshold, true);
        for (cv::KeyPoint& keypoint : cell_candidates_) {
          keypoint.pt.x += static_cast<float>(area.x);
          keypoint.pt.y += static_cast<float>(area.y);
          candidates_.push_back(keypoint);
        }
      }
    }
  }

  void choose_evenly(Level* level) {
    const cv::Mat& image = level->image;
    const int num_wanted = level->num_wanted;
    std::vector<cv::KeyPoint>& chosen = level->corners;
    if (static_cast<int>(candidates_.size()) <= num_wanted) {
      chosen = candidates_;
      std::sort(chosen.begin(), chosen.end(), stronger);
      return;
    }
    const int width = image.cols - 2 * border_px_;
    const int height = image.rows - 2 * border_px_;
    const double cell_size =
        std::max(1.0, std::sqrt(double(width) * double(height) / std::max(num_wanted, 1)));
    const int cols = std::max(1, cvRound(width / cell_size));
    const int rows = std::max(1, cvRound(height / cell_size));
    const auto num_cells = static_cast<std::size_t>(cols * rows);

    // Candidates sorted by cell, strongest first within a cell.
    cell_of_candidate_.resize(candidates_.size());
    cell_begin_.assign(num_cells + 1, 0);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const auto col =
          static_cast<int>((candidates_[i].pt.x - float(border_px_)) * float(cols) / float(width));
      const auto row =
          static_cast<int>((candidates_[i].pt.y - float(border_px_)) * float(rows) / float(height));
      const int cell = std::clamp(row, 0, rows - 1) * cols + std::clamp(col, 0, cols - 1);
      cell_of_candidate_[i] = cell;
      ++cell_begin_[static_cast<std::size_t>(cell) + 1];
    }
    for (std::size_t cell = 0; cell < num_cells; ++cell) cell_begin_[cell + 1] += cell_begin_[cell];
    cell_order_.resize(candidates_.size());
    for (std::size_t i = 0; i < candidates_.size(); ++i) cell_order_[i] = static_cast<int>(i);
    std::sort(cell_order_.begin(), cell_order_.end(), [&](int a, int b) {
      const auto ia = static_cast<std::size_t>(a);
      const auto ib = static_cast<std::size_t>(b);
      if (cell_of_candidate_[ia] != cell_of_candidate_[ib]) {
        return cell_of_candidate_[ia] < cell_of_candidate_[ib];
      }
      return stronger(candidates_[ia], candidates_[ib]);
    });

    // Round r takes the r-th strongest corner of every cell that has one; the round that would
    // overshoot gives its strongest only.
    for (int round = 0; static_cast<int>(chosen.size()) < num_wanted; ++round) {
      const std::size_t round_begin = chosen.size();
      for (std::size_t cell = 0; cell < num_cells; ++cell) {
        const int index = cell_begin_[cell] + round;
        if (index < cell_begin_[cell + 1]) {
          chosen.push_back(
              candidates_[static_cast<std::size_t>(cell_order_[static_cast<std::size_t>(index)])]);
        }
      }
      if (static_cast<int>(chosen.size()) > num_wanted) {
        std::sort(chosen.begin() + static_cast<std::ptrdiff_t>(round_begin), chosen.end(),
                  stronger);
        chosen.resize(static_cast<std::size_t>(num_wanted));
      }
    }
  }

  FeatureOptions options_;
  int border_px_;
  std::vector<Level> levels_;
  // Reused from call to call.
  std::vector<cv::KeyPoint> candidates_, cell_candidates_;
  std::vector<int> cell_of_candidate_, cell_begin_, cell_order_;
};

}  // namespace srslam
