#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/dominant_motion.hpp"
#include "srslam/scene/flow_track.hpp"

namespace srslam {

/// What is taken off the image motion before it is measured.
enum class MotionCompensation : std::uint8_t {
  kNone,    ///< nothing, as printed: mostly measures how the camera moves
  kAffine,  ///< the dominant affine flow
  kRigid,   ///< the flow of a rigid scene; the affine one where too few tracks have depth
};

constexpr const char* to_string(MotionCompensation compensation) noexcept {
  switch (compensation) {
    case MotionCompensation::kNone:
      return "none";
    case MotionCompensation::kAffine:
      return "affine";
    case MotionCompensation::kRigid:
      return "rigid";
  }
  return "unknown";
}

/// What the mean over the grid is taken over.
enum class CellMean : std::uint8_t {
  kOccupiedCells,  ///< cells that hold a track
  kAllCells,       ///< all nine, as printed: an empty cell counts as one at rest
};

struct MotionResidualOptions {
  MotionCompensation compensation = MotionCompensation::kRigid;
  CellMean cell_mean = CellMean::kOccupiedCells;
  DominantMotionOptions motion;  ///< its reference_width_px holds for the residual, too
  /// A compensated motion vector is shortened by this [px at the reference width], the noise of
  /// tracks that stand still, which grows as the camera moves. >= 0
  double noise_px = 1.0;
  /// A compensated motion vector counts with at most this length [px at the reference width]: what
  /// moves counts by how much of the image it is, not by how fast it is or by how wrong a track.
  /// Infinite: not limited. > 0
  double max_vector_px = 5.0;
  /// Share of tracks that are wrong in a rigid scene, too: depth from beside an edge, flow that has
  /// slipped, the more the faster the camera is. So many of the longest compensated vectors are
  /// left out, and inliers count as a share of the others. [0, 1)
  double spurious_share = 0.05;
  /// Share of usable tracks with depth below which kRigid becomes kAffine; [0, 1].
  double min_depth_share = 0.3;

  Status validate() const noexcept {
    if (!(min_depth_share >= 0.0) || min_depth_share > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument, "min_depth_share must be in [0, 1]");
    }
    if (!(max_vector_px > 0.0)) {
      return Status::failure(StatusCode::kInvalidArgument, "max_vector_px must be positive");
    }
    if (!(spurious_share >= 0.0) || !(spurious_share < 1.0)) {
      return Status::failure(StatusCode::kInvalidArgument, "spurious_share must be in [0, 1)");
    }
    if (!(noise_px >= 0.0) || !std::isfinite(noise_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "noise_px must be finite and not negative");
    }
    return motion.validate();
  }
};

struct MotionResidualCell {
  int num_tracks = 0;
  double mean_u_px = 0.0;  ///< mean vector of the (compensated) motion, at the reference width
  double mean_v_px = 0.0;
};

struct MotionResidualResult {
  Status status;
  /// R_r [px at the reference width]; NaN when not ok.
  double value_px = std::numeric_limits<double>::quiet_NaN();
  double mean_magnitude_px = 0.0;         ///< first term: mean length of the motion vectors
  double mean_cell_px = 0.0;              ///< second term: mean length of the cells' mean vectors
  GridArray<MotionResidualCell> cells{};  ///< by the reference position
  int num_tracks = 0;                     ///< given
  int num_alive = 0;
  int num_used = 0;          ///< alive and, if compensated, predicted by the camera's motion
  double alive_share = 0.0;  ///< of the given tracks
  /// Of usable tracks without the spurious share, with the camera's motion; 0 for kNone.
  double inlier_share = 0.0;
  /// How far the camera's motion outweighs the strongest other one: their shares' ratio, 1 without
  /// a rival and 0.5 with an equal one.
  double dominance = 1.0;
  MotionCompensation compensation = MotionCompensation::kNone;  ///< that was possible
  DominantMotionResult motion;                                  ///< not run for kNone
};

namespace detail {

/// Adds up Eq. 6 over vectors that are handed in one by one.
class ResidualSums {
 public:
  void add(int cell, const Eigen::Vector2d& motion_px) noexcept {
    magnitudes_ += motion_px.norm();
    ++count_;
    if (cell < 0) return;
    sums_[static_cast<std::size_t>(cell)] += motion_px;
    ++counts_[static_cast<std::size_t>(cell)];
  }

  void finish(double px_scale, CellMean cell_mean, MotionResidualResult* result) const noexcept {
    result->num_used = count_;
    if (count_ == 0) {
      result->status =
          Status::failure(StatusCode::kInsufficientData, "no track has a motion to measure");
      return;
    }
    result->status = Status::success();
    double cell_sum = 0.0;
    int occupied = 0;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      MotionResidualCell& cell = result->cells[i];
      cell.num_tracks = counts_[i];
      if (counts_[i] == 0) continue;
      const Eigen::Vector2d mean = sums_[i] / (counts_[i] * px_scale);
      cell.mean_u_px = mean.x();
      cell.mean_v_px = mean.y();
      cell_sum += mean.norm();
      ++occupied;
    }
    const int num_cells = cell_mean == CellMean::kAllCells ? kGridCells : occupied;
    result->mean_magnitude_px = magnitudes_ / (count_ * px_scale);
    result->mean_cell_px = num_cells > 0 ? cell_sum / num_cells : 0.0;
    result->value_px = result->mean_magnitude_px + result->mean_cell_px;
  }

 private:
  int count_ = 0;
  double magnitudes_ = 0.0;
  GridArray<int> counts_{};
  GridArray<Eigen::Matrix<double, 2, 1, Eigen::DontAlign>> sums_ = zeros();

  static GridArray<Eigen::Matrix<double, 2, 1, Eigen::DontAlign>> zeros() noexcept {
    GridArray<Eigen::Matrix<double, 2, 1, Eigen::DontAlign>> sums;
    for (auto& sum : sums) sum.setZero();
    return sums;
  }
};

/// Counts the tracks; false, with the status set, when nothing can be measured.
inline bool begin_residual(ArrayView<const FlowTrack> tracks, const PinholeCamera& camera,
                           const MotionResidualOptions& options,
                           MotionResidualResult* result) noexcept {
  result->status = options.validate();
  if (result->status.ok()) result->status = camera.validate();
  if (!result->status.ok()) return false;
  result->num_tracks = static_cast<int>(tracks.size);
  for (const FlowTrack& track : tracks) {
    if (track.alive) ++result->num_alive;
  }
  if (result->num_alive == 0) {
    result->status = Status::failure(StatusCode::kInsufficientData, "no track is left");
    return false;
  }
  result->alive_share = double(result->num_alive) / result->num_tracks;
  return true;
}

/// Squared length that all but the longest `spurious_share` of the vectors keep within.
template <typename LeftOver>
float longest_that_counts(const LeftOver& left_over, std::size_t size, double spurious_share,
                          DominantMotionWorkspace* workspace) {
  std::vector<float>& lengths_px2 = workspace->squared_error_px2;
  lengths_px2.clear();
  Eigen::Vector2d left_px;
  for (std::size_t i = 0; i < size; ++i) {
    if (left_over(i, &left_px)) lengths_px2.push_back(float(left_px.squaredNorm()));
  }
  if (lengths_px2.empty()) return 0.0F;
  const auto num_spurious = static_cast<std::size_t>(spurious_share * double(lengths_px2.size()));
  const auto last = lengths_px2.end() - static_cast<std::ptrdiff_t>(num_spurious) - 1;
  std::nth_element(lengths_px2.begin(), last, lengths_px2.end());
  return *last;
}

/// Means over what the camera's motion leaves of the usable tracks, which the workspace holds.
template <typename Model>
void measure_residual(const Model& model, const typename Model::Parameters& motion,
                      ArrayView<const FlowTrack> tracks, const PinholeCamera& camera,
                      const MotionResidualOptions& options, DominantMotionWorkspace* workspace,
                      MotionResidualResult* result) {
  ResidualSums sums;
  const double px_scale = double(camera.width_px) / options.motion.reference_width_px;
  const double max_length_px = options.max_vector_px * px_scale;
  const double noise_px = options.noise_px * px_scale;
  const auto left_over = [&](std::size_t i, Eigen::Vector2d* left_px) {
    Eigen::Vector2d predicted_px;
    if (!model.predict(motion, *workspace, i, &predicted_px)) return false;
    *left_px =
        Eigen::Vector2d(double(workspace->u_px[i]), double(workspace->v_px[i])) - predicted_px;
    return true;
  };
  const float longest_px2 =
      longest_that_counts(left_over, workspace->track.size(), options.spurious_share, workspace);
  Eigen::Vector2d left_px;
  for (std::size_t i = 0; i < workspace->track.size(); ++i) {
    if (!left_over(i, &left_px) || float(left_px.squaredNorm()) > longest_px2) continue;
    const FlowPoint& reference = tracks[static_cast<std::size_t>(workspace->track[i])].reference;
    const double length_px = left_px.norm();
    const double counted_px = std::clamp(length_px - noise_px, 0.0, max_length_px);
    if (length_px > 0.0) left_px *= counted_px / length_px;
    sums.add(grid_cell(double(reference.u_px), double(reference.v_px), camera.width_px,
                       camera.height_px),
             left_px);
  }
  sums.finish(px_scale, options.cell_mean, result);
  result->inlier_share =
      std::min(1.0, result->motion.inlier_share / (1.0 - options.spurious_share));
  const double shares = result->motion.inlier_share + result->motion.rival_share;
  result->dominance = shares > 0.0 ? result->motion.inlier_share / shares : 0.0;
}

}  // namespace detail

/// How the image moves between reference and current frame (Eq. 6): the mean length of the tracks'
/// motion vectors plus the mean over the cells of a 3×3 grid of the length of the cell's mean
/// vector, in pixels of an image `reference_width_px` wide. With compensation the vector is what
/// the camera's motion leaves of it (dominant_motion.hpp), so that a moving camera in a rigid scene
/// gives 0. `predicted` (may be null) is the expected relative pose, for kRigid.
///
/// Points that were lost do not count in the means: see alive_share. O(tracks), deterministic,
/// allocates only while the workspace grows. kInvalidArgument for options or a camera out of range;
/// kInsufficientData when no track is left, or too few for the camera's motion; kDegenerate when
/// they do not determine it.
inline MotionResidualResult motion_residual(ArrayView<const FlowTrack> tracks,
                                            const PinholeCamera& camera,
                                            const Pose* predicted_T_current_reference,
                                            const MotionResidualOptions& options,
                                            DominantMotionWorkspace* workspace) {
  MotionResidualResult result;
  if (!detail::begin_residual(tracks, camera, options, &result)) return result;
  if (options.compensation == MotionCompensation::kNone) {
    detail::ResidualSums sums;
    for (const FlowTrack& track : tracks) {
      const Eigen::Vector2d motion_px(double(track.current.u_px) - double(track.reference.u_px),
                                      double(track.current.v_px) - double(track.reference.v_px));
      if (!track.alive || !motion_px.allFinite()) continue;
      sums.add(grid_cell(double(track.reference.u_px), double(track.reference.v_px),
                         camera.width_px, camera.height_px),
               motion_px);
    }
    sums.finish(double(camera.width_px) / options.motion.reference_width_px, options.cell_mean,
                &result);
    return result;
  }

  if (options.compensation == MotionCompensation::kRigid) {
    int num_with_depth = 0;
    for (const FlowTrack& track : tracks) {
      if (track.alive && track.reference.depth_m > 0.0F) ++num_with_depth;
    }
    if (num_with_depth >= options.min_depth_share * result.num_alive) {
      result.motion = dominant_rigid_motion(tracks, camera, predicted_T_current_reference,
                                            options.motion, workspace);
    }
    if (result.motion.status.ok()) {
      result.compensation = MotionCompensation::kRigid;
      detail::measure_residual(detail::RigidModel(camera), result.motion.T_current_reference,
                               tracks, camera, options, workspace, &result);
      return result;
    }
  }
  result.motion =
      dominant_affine_motion(tracks, camera.width_px, nullptr, options.motion, workspace);
  result.compensation = MotionCompensation::kAffine;
  if (!result.motion.status.ok()) {
    result.status = result.motion.status;
    return result;
  }
  detail::measure_residual(detail::AffineModel{}, result.motion.affine, tracks, camera, options,
                           workspace, &result);
  return result;
}

/// The same against a relative pose that is known from elsewhere, say the tracker's own: nothing is
/// estimated, certainty is 1. Always kRigid; kInsufficientData when no track has reference depth.
inline MotionResidualResult motion_residual_given_pose(ArrayView<const FlowTrack> tracks,
                                                       const PinholeCamera& camera,
                                                       const Pose& T_current_reference,
                                                       const MotionResidualOptions& options,
                                                       DominantMotionWorkspace* workspace) {
  MotionResidualResult result;
  if (!detail::begin_residual(tracks, camera, options, &result)) return result;
  result.compensation = MotionCompensation::kRigid;
  result.motion =
      rigid_motion_support(tracks, camera, T_current_reference, options.motion, workspace);
  if (!result.motion.status.ok()) {
    result.status = result.motion.status;
    return result;
  }
  detail::measure_residual(detail::RigidModel(camera), T_current_reference, tracks, camera, options,
                           workspace, &result);
  return result;
}

}  // namespace srslam
