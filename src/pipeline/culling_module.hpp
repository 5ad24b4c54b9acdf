#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/scene_module.hpp"
#include "srslam/core/camera.hpp"
#include "srslam/interop/lucas_kanade.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::detail {

/// Module D: finds the features of a frame that move by themselves. Reads what module S says of the
/// same frame.
class CullingModule {
 public:
  CullingModule(const PinholeCamera& camera, const CullingOptions& options)
      : camera_(camera), options_(options), tracker_(one_frame_back(options.flow)) {}

  /// Which features go. To be called for every frame, after `scene` has assessed it: the next frame
  /// is compared with this one. A frame that `scene` could not judge is not judged here, either.
  /// `tracked_T_current_previous`: the camera's motion as tracking expects it, null when unknown.
  CullingReport cull(const PipelineFrame& frame, ArrayView<const Feature> features,
                     const SceneReport& report, const Pose* tracked_T_current_previous,
                     const SceneModule& scene);

 private:
  static LucasKanadeOptions one_frame_back(LucasKanadeOptions options) {
    options.history = 1;
    return options;
  }
  void follow_features_back(const SceneReport& report);
  void remember_depth(const ImageView<const float>& depth_m);

  PinholeCamera camera_;
  CullingOptions options_;
  LucasKanadeTracker tracker_;
  std::uint64_t frame_id_ = 0;
  std::vector<FlowPoint> points_;        ///< features of the last frame
  std::vector<float> previous_depth_m_;  ///< row by row; empty before the first frame
  std::vector<FlowPoint> guess_;
  std::vector<FlowTrack> tracks_;
  std::vector<FeatureSuspicion> suspicions_;
  std::vector<CullingVerdict> verdicts_;
  DynamicRegionWorkspace regions_workspace_;
  DynamicCullingWorkspace removal_workspace_;
};

}  // namespace srslam::detail
