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
  SceneModule(const PinholeCamera& camera, const SceneOptions& options)
      : camera_(camera), tracker_(options.flow), assessor_(camera, options.assessor) {}

  SceneReport assess(const PipelineFrame& frame, ArrayView<const Feature> features);

 private:
  PinholeCamera camera_;
  LucasKanadeTracker tracker_;
  SceneAssessor assessor_;
  std::uint64_t frame_id_ = 0;
  std::vector<FlowPoint> points_;
};

}  // namespace srslam::detail
