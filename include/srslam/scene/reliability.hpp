#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "srslam/core/array_view.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/plain_pose.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"
#include "srslam/scene/background_depth.hpp"
#include "srslam/scene/classification.hpp"
#include "srslam/scene/flow_track.hpp"
#include "srslam/scene/motion_residual.hpp"
#include "srslam/scene/reference_policy.hpp"
#include "srslam/scene/scene_metrics.hpp"

namespace srslam {

struct SceneAssessorOptions {
  DetectionConfidenceOptions confidence;
  SpatialDistributionOptions spatial;
  FeatureQualityOptions feature;
  DepthQualityOptions depth;
  /// Geometric mean: a frame without features is unreliable however good its depth is, which a sum
  /// cannot say.
  CurrentReliabilityOptions current = geometric_mean();
  MotionResidualOptions residual;
  ReferenceOptions reference;
  BackgroundDepthOptions background;
  ResidualFactorForm factor = ResidualFactorForm::kExponential;
  double residual_scale_px = 5.0;  ///< R_cb, at the reference width; > 0
  double threshold = 0.20;         ///< th_scene; finite, >= 0
  /// When a smaller share than this of the tracks with the camera's motion lies outside the boxes
  /// of movable objects and what has come before the background, the motion may be theirs: the
  /// reliability falls in proportion, to 0 when they cover everything, and the camera is thought to
  /// go on as it did, but for no more than `max_coasted_frames` in a row. [0, 1], 0: not asked
  double min_background_share = 0.5;
  int max_coasted_frames = 10;  ///< >= 0
  /// When less than this share of the view is clear of what has come before the background
  /// (BackgroundDepth), detected or not, the reliability falls in proportion. [0, 1], 0: not asked
  double min_clear_share = 0.5;
  /// A motion that continues the camera's so far less than this (MotionCandidate::continuity) is
  /// not taken for its: the reliability falls in proportion. [0, 1], 0: not asked
  double min_continuity = 0.3;
  /// When every track of the reference was lost, nobody knows how what is seen now moves against
  /// what was seen before: the reliability begins at 0 again and is back after so many frames that
  /// are connected by tracks. 0: not asked, as what covers the view is known (min_clear_share)
  int num_settling_frames = 0;
  /// Powers with which these multiply Eq. 7; >= 0, 0 as printed: the share of tracks that move with
  /// the camera, its weight against the strongest other motion, and the share still followed.
  double inlier_share_power = 1.0;
  double dominance_power = 1.0;
  double alive_share_power = 0.0;

  Status validate() const noexcept {
    for (const Status& status :
         {confidence.validate(), spatial.validate(), feature.validate(), depth.validate(),
          current.validate(), residual.validate(), reference.validate(), background.validate()}) {
      if (!status.ok()) return status;
    }
    const auto power = [](double x) { return x >= 0.0 && std::isfinite(x); };
    if (!(residual_scale_px > 0.0) || !std::isfinite(residual_scale_px)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "residual_scale_px must be positive and finite");
    }
    if (!(threshold >= 0.0) || !std::isfinite(threshold)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "threshold must be finite and not negative");
    }
    if (!(min_background_share >= 0.0) || min_background_share > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "min_background_share must be in [0, 1]");
    }
    if (!(min_clear_share >= 0.0) || min_clear_share > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument, "min_clear_share must be in [0, 1]");
    }
    if (!(min_continuity >= 0.0) || min_continuity > 1.0) {
      return Status::failure(StatusCode::kInvalidArgument, "min_continuity must be in [0, 1]");
    }
    if (max_coasted_frames < 0 || num_settling_frames < 0) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "numbers of coasted and settling frames must not be negative");
    }
    if (!power(inlier_share_power) || !power(dominance_power) || !power(alive_share_power)) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "powers must be finite and not negative");
    }
    return Status::success();
  }

  static CurrentReliabilityOptions geometric_mean() noexcept {
    CurrentReliabilityOptions options;
    options.form = CurrentReliabilityForm::kGeometricMean;
    return options;
  }

  /// Everything as printed: plain sum, raw image motion, factor x, scale 60 px.
  static SceneAssessorOptions literal() noexcept {
    SceneAssessorOptions options;
    options.confidence.no_detections = NoDetections::kZero;
    options.spatial.no_detections = NoDetections::kZero;
    options.feature.form = FeatureQualityForm::kLiteral;
    options.depth.form = DepthQualityForm::kLiteral;
    options.current.form = CurrentReliabilityForm::kLiteral;
    options.residual.compensation = MotionCompensation::kNone;
    options.residual.cell_mean = CellMean::kAllCells;
    options.factor = ResidualFactorForm::kLiteral;
    options.residual_scale_px = 60.0;
    options.reference.min_age_frames = 1;
    options.reference.max_age_frames = 30;
    options.min_background_share = 0.0;
    options.min_clear_share = 0.0;
    options.inlier_share_power = 0.0;
    options.dominance_power = 0.0;
    options.alive_share_power = 0.0;
    options.min_continuity = 0.0;
    options.num_settling_frames = 0;
    return options;
  }
};

/// What a frame's reliability is made of.
struct ReliabilityTerms {
  double current = 0.0;      ///< Eq. 1
  double residual_px = 0.0;  ///< Eq. 6, at the reference width
  double inlier_share = 1.0;
  double dominance = 1.0;         ///< see MotionResidualResult
  double continuity = 1.0;        ///< see MotionCandidate; 1 where nothing was predicted
  double settled_share = 1.0;     ///< of num_settling_frames, since tracks were lost altogether
  double background_share = 1.0;  ///< of the inliers, on nothing that may move or came in between
  double clear_share = 1.0;       ///< of the view, with nothing that came before the background
  double alive_share = 1.0;
  bool initial = false;  ///< judged without motion: the other terms do not count
};

/// The reliability of a frame: Eq. 7, times powers of the track shares where these are asked for.
inline double scene_reliability(const ReliabilityTerms& terms,
                                const SceneAssessorOptions& options) noexcept {
  if (terms.initial) return terms.current;
  const auto share_term = [](double share, double power) {
    return power == 0.0 ? 1.0 : std::pow(share, power);
  };
  const auto below = [](double share, double limit) { return share < limit ? share / limit : 1.0; };
  return scene_reliability(terms.current, terms.residual_px, options.residual_scale_px,
                           options.factor) *
         share_term(terms.inlier_share, options.inlier_share_power) *
         share_term(terms.dominance, options.dominance_power) *
         share_term(terms.alive_share, options.alive_share_power) *
         below(terms.background_share, options.min_background_share) *
         below(terms.clear_share, options.min_clear_share) *
         below(terms.continuity, options.min_continuity) *
         (options.num_settling_frames > 0 ? terms.settled_share : 1.0);
}

/// One frame as the assessor takes it. Views are read during assess() only.
struct SceneObservation {
  std::uint64_t frame_id = 0;  ///< increasing
  /// Boxes, read only when has_detections: a frame that no detector looked at says nothing of its
  /// objects, one in which it found nothing is a frame without objects.
  ArrayView<const Detection> detections;
  bool has_detections = false;
  ArrayView<const double> mask_areas_px;  ///< see spatial_distribution()
  ArrayView<const Feature> features;
  /// Empty: its metric is absent, and nothing is known to cover the view.
  ImageView<const float> depth_m;
  /// Points of the frame SceneReport::next_reference_id named last, followed into this one; empty
  /// without a reference.
  ArrayView<const FlowTrack> tracks;
  /// Pose relative to the reference from elsewhere, which then is not estimated; may be null.
  const Pose* T_current_reference = nullptr;
};

struct SceneReport {
  Status status;  ///< not ok: the frame was refused and nothing was changed
  double reliability = std::numeric_limits<double>::quiet_NaN();  ///< R (Eq. 7)
  SceneClass scene_class = SceneClass::kBad;                      ///< Eq. 8
  DetectionConfidenceResult confidence;                           ///< Eq. 2
  SpatialDistributionResult spatial;                              ///< Eq. 3
  FeatureQualityResult feature;                                   ///< Eq. 4
  DepthQualityResult depth;                                       ///< Eq. 5
  CurrentReliabilityResult current;                               ///< R_c (Eq. 1)
  MotionResidualResult residual;                                  ///< Eq. 6
  CoveredResult covered;  ///< by what has come before the background; all 0 without depth
  /// As they enter Eq. 7. The residual is at least residual_scale_px when too few points are left;
  /// shares that cannot be had are 1.
  ReliabilityTerms terms;
  double factor = 1.0;             ///< of Eq. 7
  bool high_motion = false;        ///< residual_px above residual_scale_px
  std::uint64_t reference_id = 0;  ///< of this frame's tracks
  int reference_age_frames = 0;
  bool reference_changed = false;  ///< from the next frame on
  std::uint64_t next_reference_id = 0;
  const char* reference_reason = "";  ///< why it changed
  /// Motion since the next reference, as far as the tracks tell: where its points are to be sought
  /// (predict_flow_points()). Only when reference_changed.
  bool has_next_motion = false;
  Pose T_current_next_reference = Pose::Identity();
  /// The camera's motion since the previous frame, as far as the tracks tell: both frames were
  /// measured against reference frames whose places are known to each other.
  bool has_step_motion = false;
  Pose T_current_previous = Pose::Identity();
  const char* weakest = "";  ///< term with the lowest value

  /// Everything in one line.
  std::string line() const {
    std::string text = std::string(to_string(scene_class)) + " R" + number(reliability) + " = R_c" +
                       number(current.value);
    if (terms.initial) {
      text += " (initial)";
    } else {
      text += " x factor" + number(factor) + " (residual" + number(terms.residual_px) + " px, " +
              to_string(residual.compensation) + ") x inliers" + number(terms.inlier_share) +
              " x dominance" + number(terms.dominance) + "; continuity" + number(terms.continuity) +
              ", settled" + number(terms.settled_share) + ", background" +
              number(terms.background_share) + ", clear" + number(terms.clear_share) + ", alive" +
              number(terms.alive_share) + ", reference " + std::to_string(reference_age_frames) +
              " frames old";
    }
    text += "; confidence" + number(confidence.metric.normalized()) + " spatial" +
            number(spatial.metric.normalized()) + " feature" + number(feature.metric.normalized()) +
            " depth" + number(depth.metric.normalized());
    return text + "; weakest: " + weakest;
  }

 private:
  /// A blank and three decimals, or a dash for what is absent.
  static std::string number(double value) {
    if (!std::isfinite(value)) return " -";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), " %.3f", value);
    return text.data();
  }
};

/// Judges every frame for feature-based SLAM (Eq. 1-8). Streaming, O(1) memory; one instance a
/// stream. The caller follows points from the reference frame and hands the tracks in:
///
///     report = assessor.assess(observation);            // tracks of assessor's reference
///     if (report.reference_changed) tracker.follow(report.next_reference_id);
///
/// Allocates only while buffers grow.
class SceneAssessor {
 public:
  /// What an assessor has to remember. Trivially copyable: its bytes may be saved and restored by
  /// the same build of the library.
  struct State {
    ReferencePolicy policy;
    std::uint64_t last_frame_id = 0;
    bool has_last = false;
    /// Where the tracks say that the camera was, for the prediction of its next motion. A frame
    /// whose tracks give no pose starts another path: its place on the last one is unknown.
    PlainPose T_path_last;
    std::uint64_t path_id = 0;
    std::uint64_t path_begin = 0;
    std::uint64_t num_frames = 0;
    bool has_velocity = false;
    PlainPose T_before_last;     ///< motion into the last frame that was measured
    int num_coasted_frames = 0;  ///< that were not, in a row
    BackgroundDepth::State background;
  };

  explicit SceneAssessor(const PinholeCamera& camera, const SceneAssessorOptions& options = {})
      : camera_(camera),
        options_(options),
        status_(options.validate()),
        background_(camera, options.background) {
    if (status_.ok()) status_ = camera.validate();
    state_.policy = ReferencePolicy(options.reference);
  }

  Status status() const noexcept { return status_; }
  const SceneAssessorOptions& options() const noexcept { return options_; }
  bool has_reference() const noexcept { return state_.policy.has_reference(); }
  /// Frame whose points are to be followed into the next one.
  std::uint64_t reference_id() const noexcept { return state_.policy.reference().frame_id; }

  const State& state() const noexcept { return state_; }
  /// Goes on where an assessor of the same camera and options was.
  void restore(const State& state) noexcept { state_ = state; }

  /// kInvalidArgument for options or a camera out of range, an id that does not increase, or
  /// another input that a metric refuses; then nothing has changed.
  SceneReport assess(const SceneObservation& frame) {
    SceneReport report;
    report.status = status_;
    if (status_.ok() && state_.has_last && frame.frame_id <= state_.last_frame_id) {
      report.status = Status::failure(StatusCode::kInvalidArgument, "frame ids must increase");
    }
    if (!report.status.ok()) return report;
    measure(frame, &report);
    if (!report.status.ok()) return report;
    report.terms.initial = state_.policy.initializing() || !state_.policy.has_reference();
    ++state_.num_frames;
    // Without any metric nothing speaks for a frame.
    report.terms.current = report.current.status.ok() ? report.current.value : 0.0;
    report.reference_id = reference_id();
    report.reference_age_frames =
        state_.policy.has_reference() ? state_.policy.age_frames() + 1 : 0;
    measure_motion(frame, &report);
    measure_covered(frame, &report);
    if (!report.terms.initial) judge_motion(&report);
    report.reliability = scene_reliability(report.terms, options_);
    report.scene_class = classify_scene(report.reliability, options_.threshold);
    name_weakest(&report);
    state_.last_frame_id = frame.frame_id;
    state_.has_last = true;

    ReferenceCandidate candidate;
    candidate.frame_id = frame.frame_id;
    candidate.current_reliability = report.current.value;
    candidate.good = report.scene_class == SceneClass::kGood;
    candidate.T_path_frame = state_.T_path_last;
    candidate.path_id = state_.path_id;
    candidate.path_begin = state_.path_begin;
    if (!report.terms.initial) {
      candidate.alive_share = report.residual.alive_share;
      candidate.num_alive = report.residual.num_alive;
    }
    report.reference_changed = state_.policy.update(candidate, &report.reference_reason);
    report.next_reference_id = reference_id();
    const ReferenceCandidate& next = state_.policy.reference();
    report.has_next_motion = report.reference_changed && next.path_id == state_.path_id;
    if (report.has_next_motion) {
      report.T_current_next_reference =
          state_.T_path_last.pose().inverse() * next.T_path_frame.pose();
    }
    return report;
  }

 private:
  /// Eq. 1 to 5.
  void measure(const SceneObservation& frame, SceneReport* report) const noexcept {
    if (frame.has_detections) {
      report->confidence = detection_confidence(frame.detections, options_.confidence);
      report->spatial = spatial_distribution(frame.detections, camera_.width_px, camera_.height_px,
                                             options_.spatial, frame.mask_areas_px);
    } else {
      report->confidence.metric = detail::failed_metric(Status::success(), 1.0);
      report->spatial.metric = detail::failed_metric(Status::success(), 2.0);
    }
    report->feature =
        feature_quality(frame.features, camera_.width_px, camera_.height_px, options_.feature);
    if (frame.depth_m.empty()) {
      report->depth.metric = detail::failed_metric(Status::success(), 3.0);
    } else {
      report->depth = depth_quality(frame.depth_m, options_.depth);
    }
    for (const SceneMetric* metric : {&report->confidence.metric, &report->spatial.metric,
                                      &report->feature.metric, &report->depth.metric}) {
      if (report->status.ok()) report->status = metric->status;
    }
    if (!report->status.ok()) return;
    report->current = current_reliability({report->confidence.metric, report->spatial.metric,
                                           report->feature.metric, report->depth.metric},
                                          options_.current);
  }

  /// Eq. 6, and where that puts the camera. Initial frames are measured, too, though not judged by
  /// it: the path begins there.
  void measure_motion(const SceneObservation& frame, SceneReport* report) {
    const ReferenceCandidate& reference = state_.policy.reference();
    const Pose T_path_reference = reference.T_path_frame.pose();
    const Pose T_path_last = state_.T_path_last.pose();
    const bool on_path = state_.policy.has_reference() && reference.path_id == state_.path_id;
    // Constant velocity.
    Pose T_predicted_reference = Pose::Identity();
    const bool has_prediction = on_path && state_.has_velocity;
    if (has_prediction) {
      T_predicted_reference =
          (T_path_last * state_.T_before_last.pose()).inverse() * T_path_reference;
    }
    MotionResidualResult& residual = report->residual;
    const ArrayView<const FlowTrack> tracks = suspect_covered(frame.tracks);
    if (!state_.policy.has_reference()) {
      // Nothing to measure against.
    } else if (frame.T_current_reference != nullptr) {
      residual = motion_residual_given_pose(tracks, camera_, *frame.T_current_reference,
                                            options_.residual, &workspace_);
    } else {
      residual = motion_residual(tracks, camera_, has_prediction ? &T_predicted_reference : nullptr,
                                 options_.residual, &workspace_);
    }
    const bool measured =
        residual.status.ok() && residual.compensation == MotionCompensation::kRigid;
    // A pose from elsewhere is not in doubt.
    if (measured && has_prediction && frame.T_current_reference == nullptr &&
        residual.motion.background_share < options_.min_background_share &&
        state_.num_coasted_frames < options_.max_coasted_frames) {
      state_.T_path_last = PlainPose(T_path_last * state_.T_before_last.pose());
      ++state_.num_coasted_frames;
    } else if (measured) {
      const Pose T_path_here = T_path_reference * residual.motion.T_current_reference.inverse();
      if (on_path) {
        state_.T_before_last = PlainPose(T_path_last.inverse() * T_path_here);
        report->has_step_motion = state_.num_coasted_frames == 0;
        report->T_current_previous = T_path_here.inverse() * T_path_last;
        state_.has_velocity = state_.num_coasted_frames == 0;
      }
      state_.num_coasted_frames = 0;
      state_.T_path_last = PlainPose(T_path_here);
      state_.path_id = reference.path_id;
      state_.path_begin = reference.path_begin;
    } else {
      state_.T_path_last = PlainPose();
      state_.path_id = frame.frame_id;
      state_.path_begin = report->terms.initial ? 0 : state_.num_frames;
      state_.has_velocity = false;
      state_.num_coasted_frames = 0;
    }
  }

  /// The tracks, where those that end on something that came before the background are suspects,
  /// too: in the frame before, since then they have hardly moved.
  ArrayView<const FlowTrack> suspect_covered(ArrayView<const FlowTrack> tracks) {
    if (options_.min_clear_share == 0.0 || state_.background.covered_share == 0.0) return tracks;
    tracks_.assign(tracks.begin(), tracks.end());
    for (FlowTrack& track : tracks_) {
      if (track.alive && background_.is_covered(state_.background, double(track.current.u_px),
                                                double(track.current.v_px))) {
        track.current.suspect = true;
      }
    }
    return tracks_;
  }

  /// How much of the view is covered. The background moves with the camera, as long as what is
  /// seen to move can be the camera's motion.
  void measure_covered(const SceneObservation& frame, SceneReport* report) noexcept {
    if (frame.depth_m.empty()) return;
    const bool is_known =
        report->has_step_motion && report->residual.motion.continuity() >= options_.min_continuity;
    report->covered = background_.update(
        frame.depth_m, is_known ? &report->T_current_previous : nullptr, &state_.background);
    report->terms.clear_share = 1.0 - report->covered.covered_share;
  }

  /// The terms of Eq. 7 that motion gives.
  void judge_motion(SceneReport* report) const noexcept {
    const MotionResidualResult& residual = report->residual;
    const bool measured = residual.status.ok();
    ReliabilityTerms& terms = report->terms;
    terms.residual_px = measured ? residual.value_px : options_.residual_scale_px;
    // Points that were lost say nothing, and they are lost where motion is largest.
    if (residual.alive_share < options_.reference.min_alive_share ||
        residual.num_alive < options_.reference.min_alive_tracks) {
      terms.residual_px = std::max(terms.residual_px, options_.residual_scale_px);
    }
    terms.alive_share = residual.alive_share;
    if (options_.residual.compensation != MotionCompensation::kNone) {
      terms.inlier_share = measured ? residual.inlier_share : 0.0;
      terms.dominance = measured ? residual.dominance : 0.0;
      terms.continuity = measured ? residual.motion.continuity() : 0.0;
      terms.background_share = measured ? residual.motion.background_share : 0.0;
    }
    if (measured && residual.compensation == MotionCompensation::kRigid && state_.path_begin > 0) {
      const auto num_connected = double(state_.num_frames - state_.path_begin);
      terms.settled_share =
          std::min(1.0, num_connected / std::max(1, options_.num_settling_frames));
    }
    report->high_motion = terms.residual_px > options_.residual_scale_px;
    report->factor =
        residual_factor(terms.residual_px, options_.residual_scale_px, options_.factor);
  }

  void name_weakest(SceneReport* report) const noexcept {
    double lowest = std::numeric_limits<double>::infinity();
    const auto consider = [&](const char* name, double value) {
      if (!(value < lowest)) return;
      lowest = value;
      report->weakest = name;
    };
    const CurrentReliabilityOptions& weights = options_.current;
    if (weights.confidence_weight > 0.0) {
      consider("confidence", report->confidence.metric.normalized());
    }
    if (weights.spatial_weight > 0.0) consider("spatial", report->spatial.metric.normalized());
    if (weights.feature_weight > 0.0) consider("feature", report->feature.metric.normalized());
    if (weights.depth_weight > 0.0) consider("depth", report->depth.metric.normalized());
    if (report->terms.initial) return;
    consider("motion residual", report->factor);
    if (options_.inlier_share_power > 0.0) consider("share of inliers", report->terms.inlier_share);
    if (report->terms.background_share < options_.min_background_share) {
      consider("share of background", report->terms.background_share);
    }
    if (report->terms.clear_share < options_.min_clear_share) {
      consider("share of clear view", report->terms.clear_share);
    }
    if (report->terms.continuity < options_.min_continuity) {
      consider("continuity", report->terms.continuity);
    }
    if (options_.num_settling_frames > 0) consider("settling", report->terms.settled_share);
    if (options_.dominance_power > 0.0) consider("dominance", report->terms.dominance);
    if (options_.alive_share_power > 0.0) consider("share alive", report->terms.alive_share);
  }

  PinholeCamera camera_;
  SceneAssessorOptions options_;
  Status status_;
  BackgroundDepth background_;
  State state_;
  std::vector<FlowTrack> tracks_;
  DominantMotionWorkspace workspace_;
};

}  // namespace srslam
