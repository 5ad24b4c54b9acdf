#include "pipeline/scene_module.hpp"

namespace srslam::detail {

SceneReport SceneModule::assess(const PipelineFrame& frame, ArrayView<const Feature> features) {
  const ArrayView<const Detection> detections =
      frame.has_detections ? frame.detections : ArrayView<const Detection>();
  SceneReport report;
  report.status =
      flow_.push(++frame_id_, frame.gray, frame.depth_m, detections, frame.feature_mask);
  if (!report.status.ok()) return report;

  SceneObservation observation;
  observation.frame_id = frame_id_;
  observation.detections = frame.detections;
  observation.has_detections = frame.has_detections;
  observation.features = features;
  observation.depth_m = frame.depth_m;
  observation.tracks = flow_.tracks();
  if (with_raw_residual_) measure_raw_residual(observation.tracks);
  report = assessor_.assess(observation);
  const Status followed = flow_.follow(report);
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
