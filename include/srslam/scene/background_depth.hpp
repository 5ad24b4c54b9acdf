#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/camera.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// Cells in which the background is remembered, whatever the size of the image.
constexpr int kBackgroundCols = 32;
constexpr int kBackgroundRows = 24;
constexpr int kBackgroundCells = kBackgroundCols * kBackgroundRows;

struct BackgroundDepthOptions {
  /// A cell is covered when it shows less than this share of its background's depth ...
  double nearer_ratio = 0.8;
  /// ... less this [m]: noise of near depth. >= 0
  double nearer_margin_m = 0.1;
  int max_covered_frames = 90;  ///< what has been there for longer is background; 1..65000
  /// When a larger share of the view was covered in the frame before, the motion of what is seen is
  /// not the camera's: the background then stays where it was in the image. [0, 1]
  double max_share_to_move = 0.5;
  double min_depth_m = 0.1;  ///< depth is valid strictly between these
  double max_depth_m = 8.0;

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (!(nearer_ratio > 0.0) || nearer_ratio > 1.0) return bad("nearer_ratio must be in (0, 1]");
    if (!(nearer_margin_m >= 0.0) || !std::isfinite(nearer_margin_m)) {
      return bad("nearer_margin_m must be finite and not negative");
    }
    if (max_covered_frames < 1 || max_covered_frames > 65000) {
      return bad("max_covered_frames must be 1 to 65000");
    }
    if (!(max_share_to_move >= 0.0) || max_share_to_move > 1.0) {
      return bad("max_share_to_move must be in [0, 1]");
    }
    if (!(min_depth_m >= 0.0) || !std::isfinite(max_depth_m) || !(max_depth_m > min_depth_m)) {
      return bad("the depth range must be finite, not negative and not empty");
    }
    return Status::success();
  }
};

struct CoveredResult {
  Status status;
  int num_compared = 0;  ///< cells with depth now and a background known before
  int num_covered = 0;   ///< of these, with something before the background
  /// num_covered of num_compared; 0 when nothing could be compared.
  double covered_share = 0.0;
};

/// Remembers how far away the background is, in cells of the image that move with the camera, and
/// tells how much of it is covered by what has come before it since. Sees what no detector knows
/// and what fills the view so that its motion is the only one: it came from somewhere. What stays
/// longer than `max_covered_frames` becomes background, so that an error heals; what was there
/// from the start becomes foreground when it leaves.
///
/// O(cells), no allocation after construction. What it remembers is plain data in `State`.
class BackgroundDepth {
 public:
  /// Background in the frame seen last; z_m is 0 where none is known.
  struct Point {
    float x_m = 0.0F;
    float y_m = 0.0F;
    float z_m = 0.0F;
    std::uint16_t num_covered_frames = 0;  ///< in a row, up to now
  };
  /// Trivially copyable.
  struct State {
    std::array<Point, static_cast<std::size_t>(kBackgroundCells)> points{};
    double covered_share = 0.0;  ///< of the frame seen last
  };

  explicit BackgroundDepth(const PinholeCamera& camera, const BackgroundDepthOptions& options = {})
      : camera_(camera), options_(options), status_(options.validate()) {
    if (status_.ok()) status_ = camera.validate();
    if (!status_.ok()) return;
    rays_.resize(static_cast<std::size_t>(kBackgroundCells), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const int col = static_cast<int>(i) % kBackgroundCols;
      const int row = static_cast<int>(i) / kBackgroundCols;
      Eigen::Vector3d ray;
      // A pixel covers half a pixel around its centre.
      const Eigen::Vector2d centre_px((col + 0.5) * cell_width_px() - 0.5,
                                      (row + 0.5) * cell_height_px() - 0.5);
      if (camera_.unproject(centre_px, 1.0, &ray)) rays_[i] = ray.cast<float>();
    }
  }

  Status status() const noexcept { return status_; }
  const BackgroundDepthOptions& options() const noexcept { return options_; }

  /// Takes the next frame. `T_current_previous`: how the camera has moved since the one before,
  /// null when unknown: the background then stays where it was in the image. The depth image has
  /// the camera's field of view, in any resolution. kInvalidArgument, with nothing changed, for an
  /// image that cannot be read.
  CoveredResult update(const ImageView<const float>& depth_m, const Pose* T_current_previous,
                       State* state) const noexcept {
    CoveredResult result;
    result.status = status_;
    if (result.status.ok()) result.status = depth_m.validate();
    if (!result.status.ok()) return result;
    if (T_current_previous != nullptr && T_current_previous->matrix().allFinite() &&
        state->covered_share <= options_.max_share_to_move) {
      move(*T_current_previous, &state->points);
      fill_gaps(&state->points);
    }
    for (std::size_t i = 0; i < state->points.size(); ++i) {
      const float seen_m = cell_depth(depth_m, static_cast<int>(i));
      if (!(seen_m > 0.0F)) continue;
      Point& point = state->points[i];
      if (point.z_m > 0.0F) {
        ++result.num_compared;
        if (double(seen_m) < options_.nearer_ratio * double(point.z_m) - options_.nearer_margin_m) {
          ++result.num_covered;
          if (++point.num_covered_frames <= options_.max_covered_frames) continue;
        }
      }
      point = on_ray(i, seen_m);
    }
    if (result.num_compared > 0) {
      result.covered_share = double(result.num_covered) / result.num_compared;
    }
    state->covered_share = result.covered_share;
    return result;
  }

  /// Whether the frame seen last showed something before the background at a pixel; false outside
  /// the image.
  bool is_covered(const State& state, double u_px, double v_px) const noexcept {
    const Eigen::Vector2d pixel(u_px, v_px);
    return camera_.in_image(pixel) && state.points[cell_of(pixel)].num_covered_frames > 0;
  }

 private:
  using Points = std::array<Point, static_cast<std::size_t>(kBackgroundCells)>;

  static constexpr int kSamplesASide = 4;       // of a cell
  static constexpr int kMinValidSamples = 5;    // of the 16
  static constexpr int kMinKnownNeighbors = 5;  // of 8, to fill a gap

  double cell_width_px() const noexcept { return double(camera_.width_px) / kBackgroundCols; }
  double cell_height_px() const noexcept { return double(camera_.height_px) / kBackgroundRows; }

  /// Precondition: in the image.
  std::size_t cell_of(const Eigen::Vector2d& pixel) const noexcept {
    const int col =
        std::clamp(static_cast<int>((pixel.x() + 0.5) / cell_width_px()), 0, kBackgroundCols - 1);
    const int row =
        std::clamp(static_cast<int>((pixel.y() + 0.5) / cell_height_px()), 0, kBackgroundRows - 1);
    return static_cast<std::size_t>(row * kBackgroundCols + col);
  }

  Point on_ray(std::size_t cell, float depth_m) const noexcept {
    const Eigen::Vector3f& ray = rays_[cell];
    return {ray.x() * depth_m, ray.y() * depth_m, ray.z() * depth_m, 0};
  }

  /// Median of samples; 0 when most of them are invalid.
  float cell_depth(const ImageView<const float>& depth_m, int cell) const noexcept {
    std::array<float, static_cast<std::size_t>(kSamplesASide * kSamplesASide)> samples_m{};
    std::size_t num_valid = 0;
    const auto low_m = static_cast<float>(options_.min_depth_m);
    const auto high_m = static_cast<float>(options_.max_depth_m);
    const int col = cell % kBackgroundCols * kSamplesASide;
    const int row = cell / kBackgroundCols * kSamplesASide;
    constexpr int kCols = kBackgroundCols * kSamplesASide;
    constexpr int kRows = kBackgroundRows * kSamplesASide;
    for (int dv = 0; dv < kSamplesASide; ++dv) {
      const float* pixels = depth_m.row(sample_index(row + dv, kRows, depth_m.height_px));
      for (int du = 0; du < kSamplesASide; ++du) {
        const float value_m = pixels[sample_index(col + du, kCols, depth_m.width_px)];
        if (value_m > low_m && value_m < high_m) samples_m[num_valid++] = value_m;
      }
    }
    if (num_valid < kMinValidSamples) return 0.0F;
    const auto middle = samples_m.begin() + static_cast<std::ptrdiff_t>(num_valid / 2);
    std::nth_element(samples_m.begin(), middle,
                     samples_m.begin() + static_cast<std::ptrdiff_t>(num_valid));
    return *middle;
  }

  /// Pixel in the middle of part `number` of `count` equal parts.
  static int sample_index(int number, int count, int size_px) noexcept {
    return static_cast<int>((2 * std::int64_t{number} + 1) * size_px / (2 * std::int64_t{count}));
  }

  /// Takes the background along with the camera; of two points in a cell the nearer one is seen.
  void move(const Pose& T_current_previous, Points* points) const noexcept {
    Points moved{};
    for (const Point& point : *points) {
      if (!(point.z_m > 0.0F)) continue;
      const Eigen::Vector3d position_m =
          T_current_previous *
          Eigen::Vector3d(double(point.x_m), double(point.y_m), double(point.z_m));
      Eigen::Vector2d pixel;
      if (!(position_m.z() > options_.min_depth_m) || !camera_.project(position_m, &pixel) ||
          !camera_.in_image(pixel)) {
        continue;
      }
      Point& target = moved[cell_of(pixel)];
      if (target.z_m > 0.0F && double(target.z_m) <= position_m.z()) continue;
      target = {static_cast<float>(position_m.x()), static_cast<float>(position_m.y()),
                static_cast<float>(position_m.z()), point.num_covered_frames};
    }
    *points = moved;
  }

  /// Points that move apart leave cells between them empty.
  void fill_gaps(Points* points) const noexcept {
    const Points known = *points;
    for (int row = 0; row < kBackgroundRows; ++row) {
      for (int col = 0; col < kBackgroundCols; ++col) {
        const auto cell = static_cast<std::size_t>(row * kBackgroundCols + col);
        if (known[cell].z_m > 0.0F) continue;
        int num_known = 0;
        float sum_m = 0.0F;
        std::uint16_t num_covered_frames = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            if (row + dv < 0 || row + dv >= kBackgroundRows || col + du < 0 ||
                col + du >= kBackgroundCols) {
              continue;
            }
            const Point& neighbor =
                known[static_cast<std::size_t>((row + dv) * kBackgroundCols + col + du)];
            if (!(neighbor.z_m > 0.0F)) continue;
            ++num_known;
            sum_m += neighbor.z_m;
            num_covered_frames = std::max(num_covered_frames, neighbor.num_covered_frames);
          }
        }
        if (num_known < kMinKnownNeighbors) continue;
        (*points)[cell] = on_ray(cell, sum_m / static_cast<float>(num_known));
        (*points)[cell].num_covered_frames = num_covered_frames;
      }
    }
  }

  PinholeCamera camera_;
  BackgroundDepthOptions options_;
  Status status_;
  std::vector<Eigen::Vector3f> rays_;  ///< of the cells' centres, of depth 1
};

}  // namespace srslam
