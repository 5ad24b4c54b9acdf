#include "pipeline/keyframe_decision.hpp"

namespace srslam::detail {

KeyframeDecision decide_keyframe(const KeyframeEvidence& evidence, const KeyframeOptions& options,
                                 int min_inliers) {
  const bool needs_close = evidence.num_tracked_close < options.min_tracked_close &&
                           evidence.num_untracked_close > options.min_untracked_close;
  const double reference_ratio =
      evidence.num_keyframes < 2 ? options.young_reference_ratio : options.reference_ratio;
  const bool weakened =
      evidence.num_tracked_well_observed < reference_ratio * evidence.num_reference_points;
  if (evidence.num_inliers <= min_inliers) return {false, "too few inliers to build on"};
  if (!weakened && !needs_close) return {false, "reference still well tracked"};

  const bool long_ago = evidence.frames_since_last >= options.max_frames;
  const bool mapper_free = evidence.frames_since_last >= options.min_frames && evidence.mapper_idle;
  const bool urgent =
      evidence.num_tracked_well_observed < options.weak_ratio * evidence.num_reference_points ||
      needs_close;
  if (!long_ago && !mapper_free && !urgent) return {false, "wanted, but the mapper is busy"};
  if (needs_close) return {true, "few close points tracked, more in view"};
  if (urgent) return {true, "tracking much weaker than the reference"};
  return {true, "tracking weaker than the reference"};
}

}  // namespace srslam::detail
