#pragma once

#include "srslam/pipeline/pipeline_options.hpp"

namespace srslam::detail {

/// What the keyframe rule looks at.
struct KeyframeEvidence {
  int frames_since_last = 0;
  bool mapper_idle = true;
  int num_inliers = 0;
  int num_tracked_well_observed = 0;  ///< inliers whose point several views constrain
  int num_reference_points = 0;       ///< points of the reference keyframe that several do
  int num_tracked_close = 0;          ///< inliers nearer than close_depth_m
  int num_untracked_close = 0;        ///< features nearer than close_depth_m without a point
  int num_keyframes = 0;
};

struct KeyframeDecision {
  bool insert = false;
  const char* reason = "";
};

/// The keyframe rule of the ORB-SLAM family for RGB-D, without reliability: insert when tracking
/// has lost enough of the reference's points or needs close points, and either enough time has
/// passed, or the mapper is free, or it is urgent.
KeyframeDecision decide_keyframe(const KeyframeEvidence& evidence, const KeyframeOptions& options,
                                 int min_inliers);

}  // namespace srslam::detail
