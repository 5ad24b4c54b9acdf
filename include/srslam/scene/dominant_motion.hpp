#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/random_stream.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/motion_model.hpp"

namespace srslam {

/// How image motion is explained by the motion of the camera.
enum class FlowModel : std::uint8_t {
  kRigid,   ///< a relative pose and the depth of the reference frame
  kAffine,  ///< six parameters of the image plane; needs no depth, knows no parallax
};

struct DominantMotionOptions {
  double inlier_px = 2.0;  ///< tracks within belong to a motion; > 0, at the reference width
  /// ... plus this share of the tracks' lower quartile of length: over a fast motion of the camera
  /// rolling shutter, blur and the offset between colour and depth make a rigid scene less rigid. A
  /// quartile, so that fast movers do not widen it. >= 0
  double inlier_per_flow = 0.08;
  int reference_width_px = 640;    ///< image width for which distances in pixels hold; > 0
  int min_tracks = 10;             ///< fewer usable tracks: no answer; >= 4
  int max_motions = 3;             ///< looked for, 1..3
  double min_motion_share = 0.08;  ///< of the usable tracks, for a motion beside the strongest
  int max_samples = 100;           ///< minimal samples a motion, 1..10000
  /// Sampling stops when it is this sure to have met a sample of inliers only; (0, 1).
  double sample_confidence = 0.99;
  int max_scored = 300;       ///< tracks on which samples are judged, >= 10
  int refine_iterations = 4;  ///< of least squares over the inliers, >= 1
  /// Part of its support that a motion keeps when a vote is entirely against it; [0, 1], 1 turns
  /// the votes off.
  double vote_floor = 0.2;
  double velocity_scale_px = 10.0;  ///< disagreement with the prediction that costs 1 - 1/e; > 0
  std::uint64_t seed = 1;

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
    if (!positive(inlier_px) || !positive(velocity_scale_px)) {
      return bad("inlier_px and velocity_scale_px must be positive and finite");
    }
    if (!(inlier_per_flow >= 0.0) || !std::isfinite(inlier_per_flow)) {
      return bad("inlier_per_flow must be finite and not negative");
    }
    if (reference_width_px < 1) return bad("reference_width_px must be positive");
    if (min_tracks < 4) return bad("min_tracks must be at least 4");
    if (max_motions < 1 || max_motions > 3) return bad("max_motions must be 1 to 3");
    if (!(min_motion_share > 0.0) || min_motion_share > 1.0) {
      return bad("min_motion_share must be in (0, 1]");
    }
    if (max_samples < 1 || max_samples > 10000) return bad("max_samples must be 1 to 10000");
    if (!(sample_confidence > 0.0) || !(sample_confidence < 1.0)) {
      return bad("sample_confidence must be between 0 and 1");
    }
    if (max_scored < 10) return bad("max_scored must be at least 10");
    if (refine_iterations < 1) return bad("refine_iterations must be positive");
    if (!(vote_floor >= 0.0) || vote_floor > 1.0) return bad("vote_floor must be in [0, 1]");
    return Status::success();
  }
};

/// A motion that many tracks share, and what speaks for it being the camera's. Votes are in [0, 1];
/// one that cannot be had is 1 for every motion.
struct MotionCandidate {
  int num_inliers = 0;
  double support = 0.0;     ///< inliers, as a share of the usable tracks
  double undetected = 0.0;  ///< vote: share of its inliers that are on no movable object
  double farness = 0.0;     ///< vote: how often an inlier lies farther than a track that is none
  double continuity = 0.0;  ///< vote: agreement with the predicted motion
  double score = 0.0;       ///< support times votes
};

struct DominantMotionResult {
  Status status;
  FlowModel model = FlowModel::kRigid;
  Pose T_current_reference = Pose::Identity();  ///< kRigid
  AffineFlow affine = AffineFlow::Identity();   ///< kAffine
  int num_usable = 0;                           ///< alive and, for kRigid, with reference depth
  int num_inliers = 0;                          ///< of the chosen motion
  double inlier_share = 0.0;                    ///< of the usable tracks
  double inlier_limit_px = 0.0;                 ///< distance that made an inlier, in this image
  double rival_share = 0.0;                     ///< largest support of a motion not chosen
  double background_share = 1.0;                ///< of the inliers that are on no movable object
  double certainty = 0.0;                       ///< 1: no rival; 0: another motion scores the same
  int num_motions = 0;
  int chosen = 0;                               ///< index in `candidates`
  std::array<MotionCandidate, 3> candidates{};  ///< by falling support

  /// Of the chosen motion with the predicted one; 1 without a prediction.
  double continuity() const noexcept {
    return num_motions > 0 ? candidates[static_cast<std::size_t>(chosen)].continuity : 1.0;
  }
};

namespace detail {

/// Sum of squared errors, each limited to the square of the inlier distance.
inline double truncated_cost(const std::vector<float>& squared_px2, std::size_t size,
                             float limit_px2) noexcept {
  double cost = 0.0;
  for (std::size_t k = 0; k < size; ++k) {
    cost += double(squared_px2[k] < limit_px2 ? squared_px2[k] : limit_px2);
  }
  return cost;
}

/// The motion that most active tracks share: samples of three tracks, judged by truncated squared
/// error, then least squares over the inliers. `motion` comes in as the first guess.
template <typename Model>
bool strongest_motion(const Model& model, const DominantMotionOptions& options, float limit_px2,
                      RandomStream* random, DominantMotionWorkspace* w,
                      typename Model::Parameters* motion) {
  const std::size_t num_active = w->active.size();
  if (num_active < 3) return false;
  // Judge on an even selection: neighbours in the list are neighbours in the image, as a rule.
  const auto num_scored = std::min(num_active, static_cast<std::size_t>(options.max_scored));
  w->scored.clear();
  for (std::size_t k = 0; k < num_scored; ++k) {
    w->scored.push_back(w->active[k * num_active / num_scored]);
  }
  double best_cost = std::numeric_limits<double>::infinity();
  const auto judge = [&](const typename Model::Parameters& candidate) {
    model.squared_errors(candidate, *w, w->scored, w->squared_error_px2.data());
    const double cost = truncated_cost(w->squared_error_px2, num_scored, limit_px2);
    if (!(cost < best_cost)) return false;
    best_cost = cost;
    return true;
  };
  const auto refine = [&](const std::vector<std::int32_t>& tracks,
                          typename Model::Parameters* refined) {
    double step_norm = 0.0;
    for (int i = 0; i < options.refine_iterations; ++i) {
      if (!model.step(*w, tracks, double(limit_px2), refined, &step_norm)) return false;
      if (step_norm < 1e-7) break;
    }
    return true;
  };

  // Samples that are worth while, from a share of inliers that the cost cannot exceed.
  const auto samples_needed = [&] {
    const double share = 1.0 - best_cost / (double(limit_px2) * double(num_scored));
    const double all_inliers = share * share * share;
    if (all_inliers < 1e-4) return options.max_samples;
    if (all_inliers > 0.999) return 0;
    const double needed = std::log(1.0 - options.sample_confidence) / std::log1p(-all_inliers);
    return std::min(options.max_samples, static_cast<int>(std::ceil(needed)));
  };

  const typename Model::Parameters guess = *motion;
  typename Model::Parameters best = guess;
  judge(guess);
  typename Model::Parameters candidate = guess;
  if (refine(w->scored, &candidate) && judge(candidate)) best = candidate;
  for (int num_samples = 0; num_samples < samples_needed(); ++num_samples) {
    std::array<std::int32_t, 3> sample{};
    for (std::size_t k = 0; k < 3; ++k) {
      sample[k] =
          w->active[static_cast<std::size_t>(random->integer(static_cast<int>(num_active)))];
    }
    if (sample[0] == sample[1] || sample[0] == sample[2] || sample[1] == sample[2]) continue;
    candidate = guess;
    if (!model.fit_sample(*w, sample, &candidate) || !judge(candidate)) continue;
    best = candidate;
  }
  candidate = best;
  if (refine(w->active, &candidate) && judge(candidate)) best = candidate;
  *motion = best;
  return std::isfinite(best_cost);
}

/// Vote for motions of what lies behind: how often an inlier of motion `number` is farther away
/// than a track that is none, ties half. 1 when there is nothing to compare.
inline double farness_vote(ArrayView<const FlowTrack> tracks, std::uint8_t number,
                           DominantMotionWorkspace* w) noexcept {
  w->depth_sorted_m.clear();
  for (std::size_t i = 0; i < w->track.size(); ++i) {
    const float depth_m = tracks[static_cast<std::size_t>(w->track[i])].reference.depth_m;
    if (w->owner[i] != number && depth_m > 0.0F) w->depth_sorted_m.push_back(depth_m);
  }
  std::sort(w->depth_sorted_m.begin(), w->depth_sorted_m.end());
  const auto begin = w->depth_sorted_m.begin();
  const auto end = w->depth_sorted_m.end();
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < w->track.size(); ++i) {
    const float depth_m = tracks[static_cast<std::size_t>(w->track[i])].reference.depth_m;
    if (w->owner[i] != number || !(depth_m > 0.0F)) continue;
    const auto [nearer, not_farther] = std::equal_range(begin, end, depth_m);
    sum += 0.5 * double((nearer - begin) + (not_farther - begin));
    ++count;
  }
  if (count == 0 || begin == end) return 1.0;
  return sum / (double(count) * double(end - begin));
}

/// Mean distance of two motions' predictions over the usable tracks, as a vote.
template <typename Model>
double continuity_vote(const Model& model, const typename Model::Parameters& motion,
                       const typename Model::Parameters& predicted, double scale_px,
                       DominantMotionWorkspace* w) noexcept {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < w->track.size(); ++i) {
    Eigen::Vector2d a;
    Eigen::Vector2d b;
    if (!model.predict(motion, *w, i, &a) || !model.predict(predicted, *w, i, &b)) continue;
    sum += (a - b).norm();
    ++count;
  }
  return count == 0 ? 0.0 : std::exp(-sum / (double(count) * scale_px));
}

inline void activate_all(DominantMotionWorkspace* w) {
  w->active.resize(w->track.size());
  for (std::size_t i = 0; i < w->active.size(); ++i) w->active[i] = static_cast<std::int32_t>(i);
}

/// Usable tracks within `limit_px` of a motion.
template <typename Model>
void count_inliers(const Model& model, const typename Model::Parameters& motion,
                   ArrayView<const FlowTrack> tracks, float limit_px, DominantMotionWorkspace* w,
                   DominantMotionResult* result) {
  activate_all(w);
  w->squared_error_px2.resize(w->track.size());
  model.squared_errors(motion, *w, w->active, w->squared_error_px2.data());
  const auto within = [limit_px](float squared_px2) { return squared_px2 < limit_px * limit_px; };
  result->num_usable = static_cast<int>(w->track.size());
  result->num_inliers = static_cast<int>(
      std::count_if(w->squared_error_px2.begin(), w->squared_error_px2.end(), within));
  result->inlier_share = double(result->num_inliers) / result->num_usable;
  int num_undetected = 0;
  for (std::size_t i = 0; i < w->track.size(); ++i) {
    const FlowTrack& track = tracks[static_cast<std::size_t>(w->track[i])];
    if (within(w->squared_error_px2[i]) && !track.reference.suspect && !track.current.suspect) {
      ++num_undetected;
    }
  }
  result->background_share =
      result->num_inliers > 0 ? double(num_undetected) / result->num_inliers : 0.0;
  result->status = Status::success();
}

/// Distance within which a track belongs to a motion, in pixels of this image.
inline float inlier_limit_px(ArrayView<const FlowTrack> tracks, double px_scale,
                             const DominantMotionOptions& options,
                             DominantMotionWorkspace* w) noexcept {
  std::vector<float>& lengths_px = w->squared_error_px2;
  lengths_px.clear();
  for (const std::int32_t index : w->track) {
    const FlowTrack& track = tracks[static_cast<std::size_t>(index)];
    lengths_px.push_back(std::hypot(track.current.u_px - track.reference.u_px,
                                    track.current.v_px - track.reference.v_px));
  }
  if (lengths_px.empty()) return static_cast<float>(options.inlier_px * px_scale);
  const auto quartile = lengths_px.begin() + static_cast<std::ptrdiff_t>(lengths_px.size() / 4);
  std::nth_element(lengths_px.begin(), quartile, lengths_px.end());
  return static_cast<float>(options.inlier_px * px_scale +
                            options.inlier_per_flow * double(*quartile));
}

/// Finds motions one after the other, lets them be voted on, and puts the winner into `result`.
/// The workspace holds the usable tracks.
template <typename Model>
void choose_motion(const Model& model, ArrayView<const FlowTrack> tracks, double px_scale,
                   const typename Model::Parameters* predicted,
                   const DominantMotionOptions& options, DominantMotionWorkspace* w,
                   DominantMotionResult* result, typename Model::Parameters* chosen) {
  const std::size_t num_usable = w->track.size();
  result->num_usable = static_cast<int>(num_usable);
  if (result->num_usable < options.min_tracks) {
    result->status =
        Status::failure(StatusCode::kInsufficientData, "too few tracks for the camera's motion");
    return;
  }
  const float limit_px = inlier_limit_px(tracks, px_scale, options, w);
  result->inlier_limit_px = double(limit_px);
  const float limit_px2 = limit_px * limit_px;
  RandomStream random(options.seed);
  w->squared_error_px2.resize(num_usable);
  w->owner.assign(num_usable, DominantMotionWorkspace::kNoOwner);
  activate_all(w);

  std::array<typename Model::Parameters, 3> motions;
  for (int number = 0; number < options.max_motions; ++number) {
    const auto k = static_cast<std::size_t>(number);
    motions[k] = predicted != nullptr ? *predicted : Model::identity();
    if (!strongest_motion(model, options, limit_px2, &random, w, &motions[k])) break;
    model.squared_errors(motions[k], *w, w->active, w->squared_error_px2.data());
    MotionCandidate candidate;
    int num_suspects = 0;
    for (std::size_t a = 0; a < w->active.size(); ++a) {
      if (!(w->squared_error_px2[a] < limit_px2)) continue;
      const auto i = static_cast<std::size_t>(w->active[a]);
      w->owner[i] = static_cast<std::uint8_t>(number);
      ++candidate.num_inliers;
      const FlowTrack& track = tracks[static_cast<std::size_t>(w->track[i])];
      if (track.reference.suspect || track.current.suspect) ++num_suspects;
    }
    candidate.support = double(candidate.num_inliers) / double(num_usable);
    if (candidate.num_inliers < 4 || (number > 0 && candidate.support < options.min_motion_share)) {
      break;
    }
    candidate.undetected = 1.0 - double(num_suspects) / candidate.num_inliers;
    candidate.farness = farness_vote(tracks, static_cast<std::uint8_t>(number), w);
    candidate.continuity = predicted == nullptr
                               ? 1.0
                               : continuity_vote(model, motions[k], *predicted,
                                                 options.velocity_scale_px * px_scale, w);
    candidate.score = candidate.support;
    for (const double vote : {candidate.undetected, candidate.farness, candidate.continuity}) {
      candidate.score *= options.vote_floor + (1.0 - options.vote_floor) * vote;
    }
    result->candidates[k] = candidate;
    ++result->num_motions;
    w->active.erase(std::remove_if(w->active.begin(), w->active.end(),
                                   [&](std::int32_t i) {
                                     return w->owner[static_cast<std::size_t>(i)] !=
                                            DominantMotionWorkspace::kNoOwner;
                                   }),
                    w->active.end());
  }
  if (result->num_motions == 0) {
    result->status =
        Status::failure(StatusCode::kDegenerate, "no motion explains more than a few tracks");
    return;
  }
  double second_score = 0.0;
  for (int number = 1; number < result->num_motions; ++number) {
    const double score = result->candidates[static_cast<std::size_t>(number)].score;
    const double best_score = result->candidates[static_cast<std::size_t>(result->chosen)].score;
    if (score > best_score) {
      second_score = best_score;
      result->chosen = number;
    } else {
      second_score = std::max(second_score, score);
    }
  }
  for (int number = 0; number < result->num_motions; ++number) {
    if (number == result->chosen) continue;
    result->rival_share =
        std::max(result->rival_share, result->candidates[static_cast<std::size_t>(number)].support);
  }
  const auto best = static_cast<std::size_t>(result->chosen);
  *chosen = motions[best];
  const double best_score = result->candidates[best].score;
  result->certainty = best_score > 0.0 ? 1.0 - second_score / best_score : 0.0;
  // Tracks of other motions may agree with the chosen one, too.
  count_inliers(model, *chosen, tracks, limit_px, w, result);
}

}  // namespace detail

/// The relative pose that most tracks share or, when votes say so, the one that is the camera's:
/// with people over half the image the strongest motion is theirs. Up to max_motions motions are
/// found one after the other by sampling three tracks with reference depth and refined on their
/// inliers; boxes of movable objects (FlowPoint::suspect), depth (the room is behind what moves in
/// it) and continuity with `predicted` (null: unknown) vote. The same input gives the same bits.
/// Allocates only while the workspace grows. kInvalidArgument for options or a camera out of range,
/// kInsufficientData below min_tracks usable tracks, kDegenerate when no motion was found.
inline DominantMotionResult dominant_rigid_motion(ArrayView<const FlowTrack> tracks,
                                                  const PinholeCamera& camera,
                                                  const Pose* predicted_T_current_reference,
                                                  const DominantMotionOptions& options,
                                                  DominantMotionWorkspace* workspace) {
  DominantMotionResult result;
  result.model = FlowModel::kRigid;
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  if (!result.status.ok()) return result;
  detail::collect_rigid_tracks(tracks, camera, workspace);
  const detail::RigidModel model(camera);
  detail::choose_motion(model, tracks, double(camera.width_px) / options.reference_width_px,
                        predicted_T_current_reference, options, workspace, &result,
                        &result.T_current_reference);
  return result;
}

/// How many tracks agree with a relative pose that is known; nothing is estimated. Failures as
/// above.
inline DominantMotionResult rigid_motion_support(ArrayView<const FlowTrack> tracks,
                                                 const PinholeCamera& camera,
                                                 const Pose& T_current_reference,
                                                 const DominantMotionOptions& options,
                                                 DominantMotionWorkspace* workspace) {
  DominantMotionResult result;
  result.model = FlowModel::kRigid;
  result.T_current_reference = T_current_reference;
  result.status = options.validate();
  if (result.status.ok()) result.status = camera.validate();
  if (result.status.ok() && !T_current_reference.matrix().allFinite()) {
    result.status =
        Status::failure(StatusCode::kInvalidArgument, "the relative pose is not finite");
  }
  if (!result.status.ok()) return result;
  detail::collect_rigid_tracks(tracks, camera, workspace);
  const detail::RigidModel model(camera);
  if (workspace->track.empty()) {
    result.status =
        Status::failure(StatusCode::kInsufficientData, "too few tracks for the camera's motion");
    return result;
  }
  result.inlier_limit_px = double(detail::inlier_limit_px(
      tracks, double(camera.width_px) / options.reference_width_px, options, workspace));
  detail::count_inliers(model, T_current_reference, tracks, float(result.inlier_limit_px),
                        workspace, &result);
  result.certainty = 1.0;
  return result;
}

/// The same with six affine parameters of the image plane instead of depth and pose. `width_px`:
/// of the image that the tracks are in.
inline DominantMotionResult dominant_affine_motion(ArrayView<const FlowTrack> tracks, int width_px,
                                                   const AffineFlow* predicted,
                                                   const DominantMotionOptions& options,
                                                   DominantMotionWorkspace* workspace) {
  DominantMotionResult result;
  result.model = FlowModel::kAffine;
  result.status = options.validate();
  if (result.status.ok() && width_px <= 0) {
    result.status = Status::failure(StatusCode::kInvalidArgument, "image width must be positive");
  }
  if (!result.status.ok()) return result;
  detail::collect_affine_tracks(tracks, workspace);
  detail::choose_motion(detail::AffineModel{}, tracks,
                        double(width_px) / options.reference_width_px, predicted, options,
                        workspace, &result, &result.affine);
  return result;
}

}  // namespace srslam
