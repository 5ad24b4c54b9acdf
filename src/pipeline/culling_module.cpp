#include "pipeline/culling_module.hpp"

#include <algorithm>
#include <cstddef>

#include "srslam/scene/flow_prediction.hpp"

namespace srslam::detail {

CullingReport CullingModule::cull(const PipelineFrame& frame, ArrayView<const Feature> features,
                                  const SceneReport& report, const Pose* tracked_T_current_previous,
                                  const SceneModule& scene) {
  CullingReport result;
  points_.clear();
  for (const Feature& feature : features) {
    FlowPoint point;
    point.u_px = feature.u_px;
    point.v_px = feature.v_px;
    describe_flow_point(frame.depth_m,
                        frame.has_detections ? frame.detections : ArrayView<const Detection>(),
                        &point);
    points_.push_back(point);
  }
  result.status = tracker_.push(++frame_id_, frame.gray, points_);
  if (result.status.ok()) result.status = report.status;
  if (!result.status.ok()) {
    previous_depth_m_.clear();
    return result;
  }
  follow_features_back(report);

  DynamicRegionInput input;
  input.tracks = tracks_;
  if (frame.has_detections) input.detections = frame.detections;
  input.object_mask = frame.object_mask;
  input.scene_class = report.scene_class;
  // Tracking sees what is left of earlier frames and is not led astray by what fills this one.
  if (tracked_T_current_previous != nullptr) {
    input.predicted_T_current_previous = tracked_T_current_previous;
  } else if (report.has_step_motion) {
    input.predicted_T_current_previous = &report.T_current_previous;
  }
  suspicions_.resize(tracks_.size());
  result.regions =
      find_dynamic_regions(input, camera_, options_.regions, regions_workspace_, suspicions_);
  // Without the camera's motion the objects are known all the same.
  if (result.regions.status.code == StatusCode::kInvalidArgument) {
    result.status = result.regions.status;
  }

  CullingFrame culling_frame;
  culling_frame.reliability = {report.reliability, report.feature.metric.value};
  culling_frame.initializing = report.terms.initial;
  culling_frame.residual_px = options_.removal.residual == BranchResidual::kRaw
                                  ? scene.raw_residual_px()
                                  : report.terms.residual_px;
  verdicts_.resize(tracks_.size());
  if (result.status.ok()) {
    result.removal = cull_dynamic_features(points_, suspicions_, camera_, culling_frame,
                                           options_.removal, removal_workspace_, verdicts_);
    result.status = result.removal.status;
  }
  result.points = points_;
  result.suspicions = suspicions_;
  result.verdicts = verdicts_;
  remember_depth(frame.depth_m);
  return result;
}

/// Where each feature was in the previous frame, sought where the camera's motion has it.
void CullingModule::follow_features_back(const SceneReport& report) {
  guess_.clear();
  if (report.has_step_motion) {
    predict_flow_points(points_, camera_, report.T_current_previous.inverse(), &guess_);
  }
  const Status followed = tracker_.track_back(points_, guess_, &tracks_);
  if (!followed.ok() || previous_depth_m_.empty()) {
    tracks_.clear();
    for (const FlowPoint& point : points_) tracks_.push_back({point, point, false});
    return;
  }
  const ImageView<const float> previous_depth_m(previous_depth_m_.data(), camera_.width_px,
                                                camera_.height_px);
  for (FlowTrack& track : tracks_) {
    if (!track.alive) continue;
    track.reference.depth_m =
        depth_at(previous_depth_m, track.reference.u_px, track.reference.v_px);
  }
}

void CullingModule::remember_depth(const ImageView<const float>& depth_m) {
  const auto width = static_cast<std::size_t>(depth_m.width_px);
  previous_depth_m_.resize(width * static_cast<std::size_t>(depth_m.height_px));
  for (int v = 0; v < depth_m.height_px; ++v) {
    const float* row = depth_m.row(v);
    std::copy(row, row + width, previous_depth_m_.begin() + std::ptrdiff_t(width) * v);
  }
}

}  // namespace srslam::detail
