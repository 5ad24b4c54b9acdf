#pragma once

#include <cstdint>
#include <vector>

#include "srslam/core/camera.hpp"
#include "srslam/interop/lucas_kanade.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "srslam/scene/reliability.hpp"

namespace srslam::detail {

/// Module S: follows the features of the reference frame and judges every frame by them. Reads the
/// frame only.
class SceneModule {
 public:
  /// `with_raw_residual`: raw_residual_px() is asked for.
  SceneModule(const PinholeCamera& camera, const SceneOptions& options,
              bool with_raw_residual = false)
      : camera_(camera),
        tracker_(options.flow),
        assessor_(camera, options.assessor),
        with_raw_residual_(with_raw_residual) {}

  SceneReport assess(const PipelineFrame& frame, ArrayView<const Feature> features);

  /// The features of the last frame, with depth and whether a box holds them.
  ArrayView<const FlowPoint> points() const { return points_; }
  /// Its newest frame is the one assessed last.
  LucasKanadeTracker& tracker() { return tracker_; }
  /// Motion residual (Eq. 6) of the last frame as printed, with the camera's motion in it [px at
  /// the reference width]; that of no motion where nothing could be followed.
  double raw_residual_px() const { return raw_residual_px_; }

 private:
  void measure_raw_residual(ArrayView<const FlowTrack> tracks);

  PinholeCamera camera_;
  LucasKanadeTracker tracker_;
  SceneAssessor assessor_;
  std::uint64_t frame_id_ = 0;
  std::vector<FlowPoint> points_;
  std::vector<FlowPoint> guess_;
  bool with_raw_residual_;
  double raw_residual_px_ = 0.0;
  DominantMotionWorkspace raw_workspace_;
};

}  // namespace srslam::detail
