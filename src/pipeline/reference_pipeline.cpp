#include "srslam/pipeline/reference_pipeline.hpp"

#include <cmath>

#include "pipeline/culling_module.hpp"
#include "pipeline/keyframe_decision.hpp"
#include "pipeline/local_mapping.hpp"
#include "pipeline/map.hpp"
#include "pipeline/orb_features.hpp"
#include "pipeline/scene_module.hpp"
#include "pipeline/stopwatch.hpp"
#include "pipeline/tracker.hpp"

namespace srslam {

using detail::FeatureFrame;
using detail::Keyframe;
using detail::MapPoint;
using detail::PointHandle;

struct ReferencePipeline::Impl {
  /// A tracked frame, by the keyframe it was tracked against.
  struct TrackedPose {
    double timestamp_s = 0.0;
    std::int32_t keyframe = -1;
    Pose T_keyframe_camera = Pose::Identity();
  };

  Impl(const PinholeCamera& camera, const PipelineOptions& pipeline_options)
      : options(pipeline_options),
        extractor(options.features),
        map(detail::make_tracking_camera(camera, extractor.level_scales(),
                                         options.features.scale_factor,
                                         options.tracking.virtual_baseline_m)),
        mapper(options, &map),
        tracker(options, &map) {
    if (options.scene.enabled) {
      const bool with_raw_residual =
          options.culling.enabled && options.culling.removal.residual == BranchResidual::kRaw;
      scene = std::make_unique<detail::SceneModule>(camera, options.scene, with_raw_residual);
    }
    if (options.culling.enabled) {
      culling = std::make_unique<detail::CullingModule>(camera, options.culling);
    }
  }

  Status check(const PipelineFrame& frame) const;
  void cull(const PipelineFrame& input, PipelineResult* result);
  bool restore_untested(PipelineResult* result);
  void label_all_features();
  void initialize(const PipelineFrame& input, PipelineResult* result);
  void track(const PipelineFrame& input, PipelineResult* result);
  void insert_keyframe(const PipelineFrame& input, Pose* T_world_camera, std::int32_t* reference,
                       PipelineResult* result);
  detail::KeyframeEvidence keyframe_evidence(std::int32_t reference, int num_inliers) const;

  const PipelineOptions options;
  detail::OrbExtractor extractor;
  detail::Map map;
  detail::LocalMapper mapper;
  detail::Tracker tracker;
  std::unique_ptr<detail::SceneModule> scene;      ///< null without module S
  std::unique_ptr<detail::CullingModule> culling;  ///< null without module D

  detail::OrbFeatures extracted;
  FeatureFrame frame;
  std::vector<FeatureLabel> labels;
  std::vector<FeatureLabel> all_labels;
  std::vector<std::uint8_t> removed;  ///< with module D, of all features
  FeatureFrame whole_frame;           ///< with module D, before anything was removed
  std::vector<std::uint8_t> thumbnail;
  bool has_timestamp = false;
  double last_timestamp_s = 0.0;
  int frames_since_keyframe = 0;
  std::vector<TrackedPose> tracked_poses;
};

Status ReferencePipeline::Impl::check(const PipelineFrame& input) const {
  const PinholeCamera& camera = map.camera().distorted;
  const auto bad = [](const char* reason) {
    return Status::failure(StatusCode::kInvalidArgument, reason);
  };
  const auto has_camera_size = [&](const auto& image) {
    return image.width_px == camera.width_px && image.height_px == camera.height_px;
  };
  if (!input.gray.validate().ok()) return bad("the grey image is empty or malformed");
  if (!input.depth_m.validate().ok()) return bad("the depth image is empty or malformed");
  if (!has_camera_size(input.gray)) return bad("the grey image is not of the camera's size");
  if (!has_camera_size(input.depth_m)) return bad("the depth image is not of the camera's size");
  if (!input.feature_mask.empty() &&
      (!input.feature_mask.validate().ok() || !has_camera_size(input.feature_mask))) {
    return bad("the feature mask is not of the camera's size");
  }
  if (!input.object_mask.empty() &&
      (!input.object_mask.validate().ok() || !has_camera_size(input.object_mask))) {
    return bad("the object mask is not of the camera's size");
  }
  if (!std::isfinite(input.timestamp_s)) return bad("the time stamp is not finite");
  if (has_timestamp && !(input.timestamp_s > last_timestamp_s)) {
    return bad("time stamps must increase strictly");
  }
  return Status::success();
}

void ReferencePipeline::Impl::cull(const PipelineFrame& input, PipelineResult* result) {
  Pose T_current_previous = Pose::Identity();
  const bool is_predicted = tracker.predict_step(input.timestamp_s, &T_current_previous);
  result->culling = culling->cull(input, frame.features, result->scene,
                                  is_predicted ? &T_current_previous : nullptr, *scene);
  result->has_culling = result->culling.status.ok();
  if (!result->has_culling) return;
  const ArrayView<const CullingVerdict> verdicts = result->culling.verdicts;
  removed.assign(verdicts.size, 0);
  for (std::size_t i = 0; i < removed.size(); ++i) removed[i] = is_removed(verdicts[i]) ? 1 : 0;
  whole_frame = frame;
  frame.remove_if([&](std::size_t i) { return removed[i] != 0; });
}

/// What went without having failed a test itself comes back; false when that is nothing.
bool ReferencePipeline::Impl::restore_untested(PipelineResult* result) {
  if (!result->has_culling) return false;
  for (std::size_t i = 0; i < removed.size(); ++i) {
    if (removed[i] == 0 || result->culling.suspicions[i].anomalous()) continue;
    removed[i] = 0;
    ++result->culling.num_restored;
  }
  if (result->culling.num_restored == 0) return false;
  frame = whole_frame;
  frame.remove_if([&](std::size_t i) { return removed[i] != 0; });
  return true;
}

/// What became of the features that were not removed goes to their places among all.
void ReferencePipeline::Impl::label_all_features() {
  all_labels.assign(removed.size(), FeatureLabel::kCulled);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all_labels.size(); ++i) {
    if (removed[i] == 0) all_labels[i] = labels[kept++];
  }
}

void ReferencePipeline::Impl::insert_keyframe(const PipelineFrame& input, Pose* T_world_camera,
                                              std::int32_t* reference, PipelineResult* result) {
  if (*reference >= 0 && !mapper.idle()) {
    // The waiting adjustment moves the map; the frame moves with its reference.
    const Pose T_reference_camera = map.T_world_keyframe(*reference).inverse() * *T_world_camera;
    mapper.apply_pending();
    *T_world_camera = map.T_world_keyframe(*reference) * T_reference_camera;
  }
  detail::make_thumbnail(input.gray, &thumbnail);
  *reference = mapper.insert(input.timestamp_s, *T_world_camera, frame, thumbnail);
  frame.points = map.keyframe(*reference)->frame.points;
  frames_since_keyframe = 0;
  result->is_keyframe = true;
}

void ReferencePipeline::Impl::initialize(const PipelineFrame& input, PipelineResult* result) {
  if (frame.num_with_depth() < static_cast<std::size_t>(options.tracking.min_initial_points)) {
    result->keyframe_reason = "too few features with depth to start a map";
    labels.assign(frame.size(), FeatureLabel::kUnmatched);
    return;
  }
  Pose T_world_camera = Pose::Identity();
  std::int32_t reference = -1;
  insert_keyframe(input, &T_world_camera, &reference, result);
  result->keyframe_reason = "first keyframe";
  result->state = TrackingState::kTracked;
  labels.assign(frame.size(), FeatureLabel::kUnmatched);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (frame.points[i].assigned()) labels[i] = FeatureLabel::kInlier;
  }
  result->num_matches = static_cast<int>(map.num_points());
  result->num_inliers = result->num_matches;
  tracked_poses.push_back({input.timestamp_s, reference, Pose::Identity()});
  tracker.remember(input.timestamp_s, T_world_camera, reference, true, &frame);
}

detail::KeyframeEvidence ReferencePipeline::Impl::keyframe_evidence(std::int32_t reference,
                                                                    int num_inliers) const {
  detail::KeyframeEvidence evidence;
  evidence.frames_since_last = frames_since_keyframe;
  evidence.mapper_idle = mapper.idle();
  evidence.num_inliers = num_inliers;
  evidence.num_keyframes = static_cast<int>(map.keyframe_indices().size());
  const int min_score = evidence.num_keyframes <= 2 ? 2 : 3;
  for (const PointHandle& handle : map.keyframe(reference)->frame.points) {
    const MapPoint* point = map.point(handle);
    if (point != nullptr && map.observation_score(*point) >= min_score) {
      ++evidence.num_reference_points;
    }
  }
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const detail::Measurement& measurement = frame.measurements[i];
    const MapPoint* point = map.point(frame.points[i]);
    // Fresh points count on neither side of the ratio: many of them would hide that the
    // reference is going out of view.
    if (point != nullptr && map.observation_score(*point) >= min_score) {
      ++evidence.num_tracked_well_observed;
    }
    if (!measurement.has_depth() || measurement.depth_m > options.tracking.close_depth_m) continue;
    if (point != nullptr) {
      ++evidence.num_tracked_close;
    } else {
      ++evidence.num_untracked_close;
    }
  }
  return evidence;
}

void ReferencePipeline::Impl::track(const PipelineFrame& input, PipelineResult* result) {
  detail::Stopwatch stopwatch;
  mapper.advance_frame();
  ++frames_since_keyframe;
  result->times.keyframe_ms = stopwatch.lap_ms();

  detail::make_thumbnail(input.gray, &thumbnail);
  detail::TrackingOutcome outcome =
      tracker.track(input.timestamp_s, thumbnail, &frame, &labels, &result->times);
  if (!outcome.tracked && restore_untested(result)) {
    outcome = tracker.track(input.timestamp_s, thumbnail, &frame, &labels, &result->times);
  }
  result->T_world_camera = outcome.T_world_camera;
  result->num_matches = outcome.num_matches;
  result->num_inliers = outcome.num_inliers;
  result->relocalized = outcome.relocalized;
  result->state = outcome.tracked ? TrackingState::kTracked : TrackingState::kLost;
  if (!outcome.tracked) {
    result->keyframe_reason = "lost";
    tracker.remember(input.timestamp_s, outcome.T_world_camera, outcome.reference_keyframe, false,
                     &frame);
    return;
  }

  stopwatch.lap_ms();
  std::int32_t reference = outcome.reference_keyframe;
  Pose T_world_camera = outcome.T_world_camera;
  const detail::KeyframeDecision decision =
      detail::decide_keyframe(keyframe_evidence(reference, outcome.num_inliers), options.keyframes,
                              options.tracking.min_inliers);
  // What moves is still among the features of such a frame, and would get into the map.
  const bool mixed =
      result->has_culling && (result->culling.removal.branch == CullingBranch::kSparing ||
                              result->culling.num_restored > 0);
  result->keyframe_reason = mixed ? "features that move could not be removed" : decision.reason;
  if (decision.insert && !mixed) insert_keyframe(input, &T_world_camera, &reference, result);
  tracked_poses.push_back(
      {input.timestamp_s, reference, map.T_world_keyframe(reference).inverse() * T_world_camera});
  tracker.remember(input.timestamp_s, T_world_camera, reference, true, &frame);
  result->times.keyframe_ms += stopwatch.lap_ms();
}

ReferencePipeline::ReferencePipeline(const PinholeCamera& camera, const PipelineOptions& options) {
  status_ = camera.validate();
  if (status_.ok()) status_ = options.validate();
  if (status_.ok()) impl_ = std::make_unique<Impl>(camera, options);
}

ReferencePipeline::~ReferencePipeline() = default;
ReferencePipeline::ReferencePipeline(ReferencePipeline&&) noexcept = default;
ReferencePipeline& ReferencePipeline::operator=(ReferencePipeline&&) noexcept = default;

Status ReferencePipeline::status() const { return status_; }

PipelineResult ReferencePipeline::process(const PipelineFrame& input) {
  PipelineResult result;
  result.status = status_;
  if (!status_.ok()) return result;
  if (impl_ == nullptr) {
    result.status = Status::failure(StatusCode::kInvalidArgument, "the pipeline was moved from");
    return result;
  }
  result.status = impl_->check(input);
  if (!result.status.ok()) return result;
  Impl& impl = *impl_;
  detail::Stopwatch total;
  detail::Stopwatch stopwatch;
  impl.has_timestamp = true;
  impl.last_timestamp_s = input.timestamp_s;

  impl.extractor.extract(input.gray, input.feature_mask, &impl.extracted);
  impl.frame.assign(impl.map.camera(), &impl.extracted, input.depth_m,
                    impl.options.tracking.min_depth_m, impl.options.tracking.max_depth_m);
  result.num_features = static_cast<int>(impl.frame.size());
  result.num_features_with_depth = static_cast<int>(impl.frame.num_with_depth());
  result.times.features_ms = stopwatch.lap_ms();

  if (impl.scene != nullptr) {
    result.scene = impl.scene->assess(input, impl.frame.features);
    result.has_scene = result.scene.status.ok();
    result.times.scene_ms = stopwatch.lap_ms();
  }
  if (impl.culling != nullptr) {
    impl.cull(input, &result);
    result.times.culling_ms = stopwatch.lap_ms();
  }

  if (impl.map.keyframe_indices().empty()) {
    impl.initialize(input, &result);
  } else {
    impl.track(input, &result);
  }
  result.num_keyframes = static_cast<int>(impl.map.keyframe_indices().size());
  result.num_map_points = static_cast<int>(impl.map.num_points());
  result.times.bundle_adjustment_ms = impl.mapper.take_solve_ms();
  // A tracked frame has been swapped into the tracker, a lost one is still here.
  const FeatureFrame& seen =
      result.state == TrackingState::kTracked ? impl.tracker.last_frame() : impl.frame;
  result.features = seen.features;
  result.labels = impl.labels;
  if (result.has_culling) {
    impl.label_all_features();
    result.features = impl.whole_frame.features;
    result.labels = impl.all_labels;
  }
  result.times.total_ms = total.lap_ms();
  return result;
}

void ReferencePipeline::finish() {
  if (impl_ != nullptr) impl_->mapper.apply_pending();
}

Trajectory ReferencePipeline::keyframes() const {
  Trajectory trajectory;
  if (impl_ == nullptr) return trajectory;
  for (const std::int32_t index : impl_->map.keyframe_indices()) {
    const Keyframe& keyframe = *impl_->map.keyframe(index);
    trajectory.push_back({keyframe.timestamp_s, keyframe.T_world_camera});
  }
  return trajectory;
}

Trajectory ReferencePipeline::optimized_trajectory() const {
  Trajectory trajectory;
  if (impl_ == nullptr) return trajectory;
  trajectory.reserve(impl_->tracked_poses.size());
  for (const Impl::TrackedPose& pose : impl_->tracked_poses) {
    trajectory.push_back(
        {pose.timestamp_s, impl_->map.T_world_keyframe(pose.keyframe) * pose.T_keyframe_camera});
  }
  return trajectory;
}

}  // namespace srslam
