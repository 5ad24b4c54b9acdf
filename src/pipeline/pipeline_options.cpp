#include "srslam/pipeline/pipeline_options.hpp"

#include <cmath>

namespace srslam {

Status PipelineOptions::validate() const noexcept {
  const auto bad = [](const char* reason) {
    return Status::failure(StatusCode::kInvalidArgument, reason);
  };
  const auto share = [](double value) { return value > 0.0 && value <= 1.0; };
  const Status feature_status = features.validate();
  if (!feature_status.ok()) return feature_status;
  if (tracking.min_inliers < 4) return bad("tracking.min_inliers must be at least 4");
  if (tracking.min_relocalized_inliers < tracking.min_inliers) {
    return bad("tracking.min_relocalized_inliers must be at least tracking.min_inliers");
  }
  if (tracking.min_initial_points < tracking.min_inliers) {
    return bad("tracking.min_initial_points must be at least tracking.min_inliers");
  }
  if (!(tracking.min_depth_m >= 0.0 && tracking.max_depth_m > tracking.min_depth_m &&
        std::isfinite(tracking.max_depth_m))) {
    return bad("tracking depth range must be 0 <= min_depth_m < max_depth_m");
  }
  if (!(tracking.close_depth_m > 0.0 && std::isfinite(tracking.close_depth_m))) {
    return bad("tracking.close_depth_m must be positive");
  }
  if (!(tracking.virtual_baseline_m > 0.0 && std::isfinite(tracking.virtual_baseline_m))) {
    return bad("tracking.virtual_baseline_m must be positive");
  }
  if (keyframes.max_frames < 1) return bad("keyframes.max_frames must be at least 1");
  if (keyframes.min_frames < 0) return bad("keyframes.min_frames must not be negative");
  if (!share(keyframes.weak_ratio) || !share(keyframes.reference_ratio) ||
      !share(keyframes.young_reference_ratio)) {
    return bad("keyframe ratios must be in (0, 1]");
  }
  if (keyframes.min_tracked_close < 0 || keyframes.min_untracked_close < 0) {
    return bad("keyframe point counts must not be negative");
  }
  if (mapping.window_size < 2) return bad("mapping.window_size must be at least 2");
  if (mapping.max_fixed_keyframes < 0) {
    return bad("mapping.max_fixed_keyframes must not be negative");
  }
  if (mapping.max_iterations < 1) return bad("mapping.max_iterations must be at least 1");
  if (mapping.max_keyframes < 3) return bad("mapping.max_keyframes must be at least 3");
  if (mapping.apply_after_frames < 1) return bad("mapping.apply_after_frames must be at least 1");
  if (!share(mapping.redundant_share)) return bad("mapping.redundant_share must be in (0, 1]");
  if (num_threads < 1 || num_threads > 2) return bad("num_threads must be 1 or 2");
  const Status scene_status = scene.assessor.validate();
  if (!scene_status.ok()) return scene_status;
  // A frame that becomes the reference must still be at hand.
  if (scene.flow.lucas_kanade.history < scene.assessor.reference.num_recent_frames()) {
    return bad("scene: the tracker's history must hold all candidates for the reference frame");
  }
  if (culling.enabled && !scene.enabled) return bad("culling needs scene: turn both on");
  for (const Status& status : {scene.flow.validate(), culling.flow.validate(),
                               culling.regions.validate(), culling.removal.validate()}) {
    if (!status.ok()) return status;
  }
  return Status::success();
}

}  // namespace srslam
