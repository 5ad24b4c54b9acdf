#pragma once

#include <vector>

#include "pipeline/scene_module.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::detail {

/// Module D: finds the features of a frame that move by themselves. Reads what module S has made of
/// the same frame.
class CullingModule {
 public:
  CullingModule(const PinholeCamera& camera, const CullingOptions& options)
      : camera_(camera), options_(options) {}

  /// Which features go. To be called for every frame, after `scene` has assessed it: the next frame
  /// is compared with this one. A frame that `scene` could not judge is not judged here, either.
  /// `tracked_T_current_previous`: the camera's motion as tracking expects it, null when unknown.
  CullingReport cull(const PipelineFrame& frame, const SceneReport& report,
                     const Pose* tracked_T_current_previous, SceneModule* scene);

 private:
  void follow_features_back(const SceneReport& report, SceneModule* scene);
  void remember_depth(const ImageView<const float>& depth_m);

  PinholeCamera camera_;
  CullingOptions options_;
  std::vector<float> previous_depth_m_;  ///< row by row; empty before the first frame
  std::vector<FlowPoint> guess_;
  std::vector<FlowTrack> tracks_;
  std::vector<FeatureSuspicion> suspicions_;
  std::vector<CullingVerdict> verdicts_;
  DynamicRegionWorkspace regions_workspace_;
  DynamicCullingWorkspace removal_workspace_;
};

}  // namespace srslam::detail
