#pragma once

#include <cstdint>

#include "srslam/core/camera.hpp"
#include "srslam/interop/scene_flow.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "srslam/scene/reliability.hpp"

namespace srslam::detail {

/// Module S: follows corners of the reference frame and judges every frame by them. Reads the frame
/// only.
class SceneModule {
 public:
  /// `with_raw_residual`: raw_residual_px() is asked for.
  SceneModule(const PinholeCamera& camera, const SceneOptions& options,
              bool with_raw_residual = false)
      : camera_(camera),
        flow_(camera, options.flow),
        assessor_(camera, options.assessor),
        with_raw_residual_(with_raw_residual) {}

  SceneReport assess(const PipelineFrame& frame, ArrayView<const Feature> features);

  /// Motion residual (Eq. 6) of the last frame as printed, with the camera's motion in it [px at
  /// the reference width]; that of no motion where nothing could be followed.
  double raw_residual_px() const { return raw_residual_px_; }

 private:
  void measure_raw_residual(ArrayView<const FlowTrack> tracks);

  PinholeCamera camera_;
  SceneFlow flow_;
  SceneAssessor assessor_;
  std::uint64_t frame_id_ = 0;
  bool with_raw_residual_;
  double raw_residual_px_ = 0.0;
  DominantMotionWorkspace raw_workspace_;
};

}  // namespace srslam::detail
