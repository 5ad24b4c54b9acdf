#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/pose.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/core/status.hpp"
#include "srslam/evaluation/association.hpp"
#include "srslam/evaluation/error_statistics.hpp"
#include "srslam/evaluation/trajectory.hpp"
#include "srslam/evaluation/trajectory_alignment.hpp"

namespace srslam {

/// How the estimate is laid over the reference before absolute errors are taken.
enum class Alignment : std::uint8_t {
  kNone,  ///< not at all: both trajectories are in the same world frame
  kSE3,   ///< best rigid motion
  kSim3,  ///< best rigid motion and scale
};

/// Stable name of `alignment`, for tables and machine-readable output.
constexpr const char* to_string(Alignment alignment) noexcept {
  switch (alignment) {
    case Alignment::kNone:
      return "none";
    case Alignment::kSE3:
      return "SE3";
    case Alignment::kSim3:
      return "Sim3";
  }
  return "unknown";
}

struct AteOptions {
  Alignment alignment = Alignment::kSE3;
  AssociationOptions association;
  /// The camera counts as fixed when every matched reference position is at most this far from
  /// their mean [m], >= 0.
  double fixed_camera_radius_m = 0.05;

  Status validate() const noexcept {
    if (!std::isfinite(fixed_camera_radius_m) || fixed_camera_radius_m < 0.0) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "fixed_camera_radius_m must be finite and not negative");
    }
    return association.validate();
  }
};

struct AteResult {
  Status status;
  ErrorStatistics translation_m;  ///< of errors_m
  std::size_t num_matched = 0;
  std::size_t num_reference = 0;
  std::size_t num_estimate = 0;
  double max_abs_time_difference_s = 0.0;  ///< over the matches
  Alignment alignment = Alignment::kSE3;   ///< what was done, as asked for
  /// p_reference = T_reference_estimate * (scale * p_estimate).
  Pose T_reference_estimate = Pose::Identity();
  double scale = 1.0;  ///< 1 unless the alignment is kSim3
  /// The path lies on a line or in one place, so that a rotation of the alignment is arbitrary; see
  /// AlignmentResult::collinear. Never set without an alignment.
  bool collinear = false;
  /// The reference does not leave a ball of AteOptions::fixed_camera_radius_m. An alignment then
  /// hides most of what went wrong: read estimate_rms_displacement_m beside the error.
  bool fixed_camera = false;
  /// Root mean square distance of the matched positions from their mean [m], unaligned, unscaled.
  double reference_rms_displacement_m = 0.0;
  double estimate_rms_displacement_m = 0.0;
  std::vector<double> errors_m;  ///< one a match
  std::vector<TrajectoryMatch> matches;
};

namespace detail {

/// Root mean square distance from `mean`, and the largest of the distances.
inline double rms_distance(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& mean,
                           double* largest) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Eigen::Vector3d& point : points) distances.push_back(safe_norm(point - mean));
  ErrorStatistics statistics;
  // Cannot fail: align_trajectories() has refused whatever has no finite distances.
  static_cast<void>(compute_error_statistics(distances, &statistics));
  *largest = statistics.max;
  return statistics.rmse;
}

}  // namespace detail

/// Absolute trajectory error: distances between the positions of the estimate, aligned as a whole,
/// and those of the reference at the same time (Sturm et al., IROS 2012, Eq. 2–3). Rotations do not
/// enter. Not changed by a rigid motion of either world frame when aligned.
///
/// Both trajectories in metres, `T_world_camera`. Fails as associate() and align_trajectories() do,
/// and with kInsufficientData when fewer than three poses match; the counts, and where they exist
/// the matches, are filled in all the same. O(n log n) in the sum of both lengths.
inline AteResult absolute_trajectory_error(const Trajectory& reference, const Trajectory& estimate,
                                           const AteOptions& options = {}) {
  AteResult result;
  result.num_reference = reference.size();
  result.num_estimate = estimate.size();
  result.alignment = options.alignment;
  result.status = options.validate();
  if (!result.status.ok()) return result;

  AssociationResult association = associate(reference, estimate, options.association);
  result.matches = std::move(association.matches);
  result.num_matched = result.matches.size();
  result.max_abs_time_difference_s = association.max_abs_time_difference_s;
  result.status = association.status;
  if (!result.status.ok()) return result;
  if (result.num_matched < 3) {
    result.status = Status::failure(StatusCode::kInsufficientData,
                                    "an absolute error needs at least three matched poses");
    return result;
  }

  std::vector<Eigen::Vector3d> reference_points;
  std::vector<Eigen::Vector3d> estimate_points;
  reference_points.reserve(result.num_matched);
  estimate_points.reserve(result.num_matched);
  for (const TrajectoryMatch& match : result.matches) {
    reference_points.emplace_back(reference[match.reference_index].T_world_camera.translation());
    estimate_points.emplace_back(estimate[match.estimate_index].T_world_camera.translation());
  }
  const AlignmentResult alignment =
      align_trajectories(reference_points, estimate_points, options.alignment == Alignment::kSim3);
  result.status = alignment.status;
  if (!result.status.ok() && result.status.code != StatusCode::kDegenerate) return result;

  double reference_radius_m = 0.0;
  double estimate_radius_m = 0.0;
  result.reference_rms_displacement_m =
      detail::rms_distance(reference_points, alignment.reference_mean, &reference_radius_m);
  result.estimate_rms_displacement_m =
      detail::rms_distance(estimate_points, alignment.estimate_mean, &estimate_radius_m);
  result.fixed_camera = reference_radius_m <= options.fixed_camera_radius_m;
  if (!result.status.ok()) return result;

  result.errors_m.reserve(result.num_matched);
  if (options.alignment == Alignment::kNone) {
    for (std::size_t i = 0; i < result.num_matched; ++i) {
      result.errors_m.push_back(detail::safe_norm(estimate_points[i] - reference_points[i]));
    }
  } else {
    result.scale = alignment.scale;
    result.collinear = alignment.collinear;
    result.T_reference_estimate.linear() = alignment.R_reference_estimate;
    result.T_reference_estimate.translation() = alignment.t_reference_estimate;
    // About the means rather than through T_reference_estimate, whose translation carries the
    // rounding of coordinates far from the origin.
    for (std::size_t i = 0; i < result.num_matched; ++i) {
      const Eigen::Vector3d estimate_offset = estimate_points[i] - alignment.estimate_mean;
      const Eigen::Vector3d reference_offset = reference_points[i] - alignment.reference_mean;
      const Eigen::Vector3d difference =
          alignment.scale * (alignment.R_reference_estimate * estimate_offset) - reference_offset;
      result.errors_m.push_back(detail::safe_norm(difference));
    }
  }
  result.status = compute_error_statistics(result.errors_m, &result.translation_m);
  return result;
}

enum class RpeDelta : std::uint8_t {
  kFrames,   ///< a number of poses
  kSeconds,  ///< a time
};

/// Stable name of `unit`, for tables and machine-readable output.
constexpr const char* to_string(RpeDelta unit) noexcept {
  return unit == RpeDelta::kFrames ? "frames" : "s";
}

/// Which pairs of poses are compared and how.
enum class RpeDefinition : std::uint8_t {
  /// Poses are matched one to one by associate() first, and both poses of a pair must be matched.
  /// kFrames: pose k of the estimate and pose k + delta. kSeconds: pose k and the later matched
  /// pose
  /// whose interval is nearest to delta, if it is within RpeOptions::relative_delta_tolerance.
  /// Pairs
  /// overlap: every pose may begin one. The error is (motion of the reference)⁻¹ · (motion of the
  /// estimate), as in Sturm et al., IROS 2012, Eq. 1.
  kMatchedPoses,
  /// What the TUM RGB-D benchmark's `evaluate_rpe` prints with a fixed delta, for comparison with
  /// published figures. Pairs are formed among all poses of the estimate: the other end of a pair
  /// is
  /// the pose nearest in time (or number) to delta later, however far from it that is, and pairs
  /// that end at the last pose are left out. Each end takes the reference pose nearest in time if
  /// it
  /// is within twice the median interval of the reference (max_time_difference_s is not used, and
  /// two poses may share one). The error is (motion of the estimate) · (motion of the reference)⁻¹:
  /// its angle is that of kMatchedPoses, its length differs where the rotations do.
  kTumTool,
};

/// Stable name of `definition`, for tables and machine-readable output.
constexpr const char* to_string(RpeDefinition definition) noexcept {
  return definition == RpeDefinition::kMatchedPoses ? "matched_poses" : "tum_tool";
}

struct RpeOptions {
  double delta = 1.0;  ///< > 0; a whole number when in frames
  RpeDelta unit = RpeDelta::kFrames;
  RpeDefinition definition = RpeDefinition::kMatchedPoses;
  /// kMatchedPoses in seconds: how far a pair's interval may be from delta, as a share of delta, in
  /// [0, 1).
  double relative_delta_tolerance = 0.1;
  AssociationOptions association;

  Status validate() const noexcept {
    if (!std::isfinite(delta) || !(delta > 0.0)) {
      return Status::failure(StatusCode::kInvalidArgument, "delta must be positive and finite");
    }
    if (unit == RpeDelta::kFrames && (delta != std::floor(delta) || delta > 1e9)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "delta in frames must be a whole number, at most 1e9");
    }
    if (!(relative_delta_tolerance >= 0.0 && relative_delta_tolerance < 1.0)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "relative_delta_tolerance must be in [0, 1)");
    }
    return association.validate();
  }
};

/// The error of the motion between two poses.
struct RpePair {
  std::size_t estimate_from = 0;  ///< indices into the trajectories
  std::size_t estimate_to = 0;
  std::size_t reference_from = 0;
  std::size_t reference_to = 0;
  double from_timestamp_s = 0.0;  ///< time stamps of the estimate, without the offset
  double to_timestamp_s = 0.0;
  double translation_m = 0.0;
  double rotation_deg = 0.0;  ///< angle of the error's rotation, in [0, 180]
};

struct RpeResult {
  Status status;
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
  double delta = 0.0;  ///< as asked for, so that a table can say it
  RpeDelta unit = RpeDelta::kFrames;
  RpeDefinition definition = RpeDefinition::kMatchedPoses;
  std::size_t num_pairs = 0;
  std::size_t num_matched = 0;  ///< poses of the estimate that have a reference pose
  std::size_t num_reference = 0;
  std::size_t num_estimate = 0;
  double max_abs_time_difference_s = 0.0;  ///< over the poses of all pairs
  double median_interval_s = 0.0;          ///< time between the poses of a pair
  double max_interval_s = 0.0;             ///< far above the median: pairs reach over lost frames
  std::vector<RpePair> pairs;              ///< in the order of from_timestamp_s
};

namespace detail {

/// Motion from pose `from` to pose `to`, in the frame of `from`. The difference of the positions is
/// taken first, so that coordinates far from the origin lose nothing.
inline Pose relative_motion(const Pose& from, const Pose& to) {
  Pose motion = Pose::Identity();
  motion.linear() = from.linear().transpose() * to.linear();
  motion.translation() = from.linear().transpose() * (to.translation() - from.translation());
  return motion;
}

/// Fills in the errors of a pair whose indices are set.
inline void compute_pair_error(const Trajectory& reference, const Trajectory& estimate,
                               RpeDefinition definition, RpePair* pair) {
  constexpr double kDegPerRad = 57.295779513082320877;
  const Pose reference_motion = relative_motion(reference[pair->reference_from].T_world_camera,
                                                reference[pair->reference_to].T_world_camera);
  const Pose estimate_motion = relative_motion(estimate[pair->estimate_from].T_world_camera,
                                               estimate[pair->estimate_to].T_world_camera);
  const Eigen::Matrix3d rotation = estimate_motion.linear() * reference_motion.linear().transpose();
  Eigen::Vector3d reference_translation = reference_motion.translation();
  if (definition == RpeDefinition::kTumTool)
    reference_translation = (rotation * reference_translation).eval();
  const Eigen::Vector3d difference = estimate_motion.translation() - reference_translation;
  pair->from_timestamp_s = estimate[pair->estimate_from].timestamp_s;
  pair->to_timestamp_s = estimate[pair->estimate_to].timestamp_s;
  pair->translation_m = safe_norm(difference);
  pair->rotation_deg = kDegPerRad * rotation_angle_rad(rotation);
}

/// Pairs of RpeDefinition::kMatchedPoses. `matches` in increasing order of estimate_index.
inline std::vector<RpePair> pairs_of_matched_poses(const std::vector<TrajectoryMatch>& matches,
                                                   const Trajectory& estimate,
                                                   const RpeOptions& options) {
  const bool in_frames = options.unit == RpeDelta::kFrames;
  const double tolerance = in_frames ? 0.0 : options.relative_delta_tolerance * options.delta;
  // How far the interval between two matched poses is from delta.
  const auto deviation = [&](std::size_t from, std::size_t to) {
    const std::size_t i = matches[from].estimate_index;
    const std::size_t j = matches[to].estimate_index;
    const double interval =
        in_frames ? static_cast<double>(j - i) : estimate[j].timestamp_s - estimate[i].timestamp_s;
    return std::abs(interval - options.delta);
  };
  std::vector<RpePair> pairs;
  std::size_t to = 0;
  for (std::size_t from = 0; from + 1 < matches.size(); ++from) {
    // The nearest end never moves back when the beginning moves on, so one sweep finds all.
    to = std::max(to, from + 1);
    while (to + 1 < matches.size() && deviation(from, to + 1) < deviation(from, to)) ++to;
    if (!(deviation(from, to) <= tolerance)) continue;
    // Matching nearest first may cross; a motion forwards is not compared with one backwards.
    if (matches[to].reference_index <= matches[from].reference_index) continue;
    RpePair pair;
    pair.estimate_from = matches[from].estimate_index;
    pair.estimate_to = matches[to].estimate_index;
    pair.reference_from = matches[from].reference_index;
    pair.reference_to = matches[to].reference_index;
    pairs.push_back(pair);
  }
  return pairs;
}

/// Index of the pose nearest in time to `timestamp_s`; of two equally near the one that a binary
/// search from the middle meets first, which is the TUM tool's choice. Precondition: not empty.
inline std::size_t nearest_pose(const Trajectory& trajectory, double timestamp_s) {
  std::size_t best = 0;
  double best_difference_s = std::abs(trajectory[0].timestamp_s - timestamp_s);
  std::size_t begin = 0;
  std::size_t end = trajectory.size();
  while (begin < end) {
    const std::size_t middle = begin + (end - begin) / 2;
    const double difference_s = trajectory[middle].timestamp_s - timestamp_s;
    if (std::abs(difference_s) < best_difference_s) {
      best_difference_s = std::abs(difference_s);
      best = middle;
    }
    if (difference_s == 0.0) return middle;
    if (difference_s > 0.0) {
      end = middle;
    } else {
      begin = middle + 1;
    }
  }
  return best;
}

/// Pairs of RpeDefinition::kTumTool; also counts the poses that have a reference pose.
inline Status pairs_of_tum_tool(const Trajectory& reference, const Trajectory& estimate,
                                const RpeOptions& options, std::vector<RpePair>* pairs,
                                std::size_t* num_matched) {
  if (reference.size() < 2 || estimate.size() < 2) {
    return Status::failure(StatusCode::kInsufficientData,
                           "each trajectory needs at least two poses");
  }
  std::vector<double> intervals_s;
  intervals_s.reserve(reference.size() - 1);
  for (std::size_t i = 1; i < reference.size(); ++i) {
    intervals_s.push_back(reference[i].timestamp_s - reference[i - 1].timestamp_s);
  }
  ErrorStatistics interval_s;
  const Status status = compute_error_statistics(intervals_s, &interval_s);
  if (!status.ok()) return status;
  const double max_difference_s = 2.0 * interval_s.median;

  const double offset_s = options.association.estimate_time_offset_s;
  std::vector<std::size_t> nearest;
  std::vector<bool> is_near;
  nearest.reserve(estimate.size());
  is_near.reserve(estimate.size());
  std::size_t first_returned = 0;
  bool has_overlap = false;
  *num_matched = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double time_s = estimate[i].timestamp_s + offset_s;
    const std::size_t index = nearest_pose(reference, time_s);
    nearest.push_back(index);
    is_near.push_back(std::abs(reference[index].timestamp_s - time_s) <= max_difference_s);
    if (is_near.back()) ++*num_matched;
    // The tool's own test of overlap: poses must not all fall to one and the same.
    const std::size_t returned = nearest_pose(estimate, reference[index].timestamp_s - offset_s);
    if (i == 0) first_returned = returned;
    has_overlap = has_overlap || returned != first_returned;
  }
  if (!has_overlap) {
    return Status::failure(StatusCode::kInsufficientData,
                           "the time stamps of the trajectories overlap too little");
  }
  const std::size_t last = estimate.size() - 1;
  for (std::size_t from = 0; from <= last; ++from) {
    std::size_t to = 0;
    if (options.unit == RpeDelta::kFrames) {
      to = from + std::min(static_cast<std::size_t>(options.delta), last - from);
    } else {
      to = nearest_pose(estimate, estimate[from].timestamp_s + options.delta);
    }
    if (to == last || !is_near[from] || !is_near[to]) continue;
    RpePair pair;
    pair.estimate_from = from;
    pair.estimate_to = to;
    pair.reference_from = nearest[from];
    pair.reference_to = nearest[to];
    pairs->push_back(pair);
  }
  return Status::success();
}

}  // namespace detail

/// Relative pose error: errors of the motion over `options.delta`, translation and rotation apart.
/// Not changed by a rigid motion of either world frame; no alignment, no scale. Both trajectories
/// must hold poses of the same body: a constant transform between the two bodies does change it.
///
/// Both trajectories in metres, `T_world_camera`. Fails with kInvalidArgument (options,
/// trajectories) and kInsufficientData: kMatchedPoses with fewer than three matches or no pair,
/// kTumTool with fewer than two pairs. The counts are filled in all the same. O(n log n) in the sum
/// of both lengths.
inline RpeResult relative_pose_error(const Trajectory& reference, const Trajectory& estimate,
                                     const RpeOptions& options = {}) {
  RpeResult result;
  result.num_reference = reference.size();
  result.num_estimate = estimate.size();
  result.delta = options.delta;
  result.unit = options.unit;
  result.definition = options.definition;
  const auto fail = [&result](StatusCode code, const char* reason) {
    result.status = Status::failure(code, reason);
    return result;
  };
  result.status = options.validate();
  if (!result.status.ok()) return result;

  std::size_t min_pairs = 1;
  if (options.definition == RpeDefinition::kMatchedPoses) {
    AssociationResult association = associate(reference, estimate, options.association);
    result.num_matched = association.matches.size();
    result.status = association.status;
    if (!result.status.ok()) return result;
    if (result.num_matched < 3) {
      return fail(StatusCode::kInsufficientData,
                  "a relative error needs at least three matched poses");
    }
    std::sort(association.matches.begin(), association.matches.end(),
              [](const TrajectoryMatch& a, const TrajectoryMatch& b) {
                return a.estimate_index < b.estimate_index;
              });
    result.pairs = detail::pairs_of_matched_poses(association.matches, estimate, options);
  } else {
    min_pairs = 2;
    result.status = check_trajectory(reference, TrajectoryRole::kReference).status;
    if (!result.status.ok()) return result;
    result.status = check_trajectory(estimate, TrajectoryRole::kEstimate).status;
    if (!result.status.ok()) return result;
    result.status =
        detail::pairs_of_tum_tool(reference, estimate, options, &result.pairs, &result.num_matched);
    if (!result.status.ok()) return result;
  }
  result.num_pairs = result.pairs.size();
  if (result.num_pairs < min_pairs) {
    return fail(StatusCode::kInsufficientData, options.definition == RpeDefinition::kTumTool
                                                   ? "fewer than two pairs of poses are delta apart"
                                                   : "no two matched poses are delta apart");
  }

  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  std::vector<double> intervals_s;
  translations_m.reserve(result.num_pairs);
  rotations_deg.reserve(result.num_pairs);
  intervals_s.reserve(result.num_pairs);
  const double offset_s = options.association.estimate_time_offset_s;
  const auto note_time_difference = [&](std::size_t reference_index, std::size_t estimate_index) {
    result.max_abs_time_difference_s = std::max(
        result.max_abs_time_difference_s, std::abs(estimate[estimate_index].timestamp_s + offset_s -
                                                   reference[reference_index].timestamp_s));
  };
  for (RpePair& pair : result.pairs) {
    detail::compute_pair_error(reference, estimate, options.definition, &pair);
    translations_m.push_back(pair.translation_m);
    rotations_deg.push_back(pair.rotation_deg);
    intervals_s.push_back(pair.to_timestamp_s - pair.from_timestamp_s);
    note_time_difference(pair.reference_from, pair.estimate_from);
    note_time_difference(pair.reference_to, pair.estimate_to);
  }
  ErrorStatistics interval_s;
  if (!compute_error_statistics(translations_m, &result.translation_m).ok() ||
      !compute_error_statistics(rotations_deg, &result.rotation_deg).ok() ||
      !compute_error_statistics(intervals_s, &interval_s).ok()) {
    result.translation_m = {};
    result.rotation_deg = {};
    result.pairs.clear();
    return fail(StatusCode::kInvalidArgument,
                "positions or time stamps are too large to compute with");
  }
  result.median_interval_s = interval_s.median;
  result.max_interval_s = interval_s.max;
  result.status = Status::success();
  return result;
}

}  // namespace srslam
