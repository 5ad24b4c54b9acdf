#pragma once

#include "srslam/core/status.hpp"

namespace srslam {

/// Evenly spread ORB features.
struct FeatureOptions {
  int num_features = 1000;     ///< wanted per frame, >= 50
  int num_levels = 8;          ///< pyramid levels, 1..12
  double scale_factor = 1.2;   ///< between levels, > 1
  int fast_threshold = 20;     ///< FAST, 1..255
  int min_fast_threshold = 7;  ///< where a cell gives none with fast_threshold
};

/// Matching and pose solving.
struct TrackingOptions {
  int min_inliers = 15;               ///< fewer: LOST
  double min_depth_m = 0.1;           ///< valid depth, exclusive
  double max_depth_m = 8.0;           ///< valid depth, exclusive
  double close_depth_m = 3.0;         ///< a point nearer than this is triangulated well by depth
};

/// When a tracked frame becomes a keyframe (docs/pipeline.md).
struct KeyframeOptions {
  int max_frames = 30;                ///< since the last keyframe: insert when tracking weakens
  int min_frames = 0;                 ///< since the last keyframe, else never
  double weak_ratio = 0.25;           ///< inliers below this share of the reference's: urgent
  double reference_ratio = 0.75;      ///< inliers below this share of the reference's: wanted
  double young_reference_ratio = 0.4; ///< the same while the map has fewer than two keyframes
  int min_tracked_close = 100;        ///< fewer close points tracked ...
  int min_untracked_close = 70;       ///< ... and more close points untracked: wanted
};

/// Local map and bundle adjustment.
struct MappingOptions {
  int window_size = 10;        ///< keyframes optimised together, >= 2
  int max_fixed_keyframes = 20;///< neighbours held fixed
  int max_iterations = 5;
  int max_keyframes = 200;     ///< in the map; the most redundant ones leave first
  int apply_after_frames = 2;  ///< frames between an insertion and the use of its adjustment
};

struct PipelineOptions {
  FeatureOptions features;
  TrackingOptions tracking;
  KeyframeOptions keyframes;
  MappingOptions mapping;
  int num_threads = 2;  ///< 1 or 2; the result does not depend on it

  Status validate() const noexcept;
};

}  // namespace srslam
