#include "pipeline/scene_module.hpp"

#include "srslam/interop/follow_reference.hpp"

namespace srslam::detail {

SceneReport SceneModule::assess(const PipelineFrame& frame, ArrayView<const Feature> features) {
  const ArrayView<const Detection> detections =
      frame.has_detections ? frame.detections : ArrayView<const Detection>();
  points_.clear();
  for (const Feature& feature : features) {
    FlowPoint point;
    point.u_px = feature.u_px;
    point.v_px = feature.v_px;
    describe_flow_point(frame.depth_m, detections, &point);
    points_.push_back(point);
  }
  SceneReport report;
  report.status = tracker_.push(++frame_id_, frame.gray, points_);
  if (!report.status.ok()) return report;

  SceneObservation observation;
  observation.frame_id = frame_id_;
  observation.detections = frame.detections;
  observation.has_detections = frame.has_detections;
  observation.features = features;
  observation.depth_m = frame.depth_m;
  if (tracker_.following()) {
    for (FlowTrack& track : tracker_.tracks()) {
      if (track.alive) describe_flow_point(frame.depth_m, detections, &track.current);
    }
    observation.tracks = tracker_.tracks();
  }
  if (with_raw_residual_) measure_raw_residual(observation.tracks);
  report = assessor_.assess(observation);
  const Status followed = follow_next_reference(report, camera_, &tracker_, &guess_);
  if (report.status.ok()) report.status = followed;
  return report;
}

void SceneModule::measure_raw_residual(ArrayView<const FlowTrack> tracks) {
  MotionResidualOptions options = assessor_.options().residual;
  options.compensation = MotionCompensation::kNone;
  const MotionResidualResult raw =
      motion_residual(tracks, camera_, nullptr, options, &raw_workspace_);
  raw_residual_px_ = raw.status.ok() ? raw.value_px : 0.0;
}

}  // namespace srslam::detail
