#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/feature_frame.hpp"
#include "pipeline/map.hpp"

namespace srslam::detail {

/// Largest Hamming distance of a match when the position is predicted, and when it is not.
constexpr int kMaxHammingPredicted = 100;
constexpr int kMaxHammingUnpredicted = 50;

/// A point of the world that the frame may show. `handle` is unassigned for points that were
/// only unprojected from the previous frame and are in no map.
struct MatchCandidate {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  BinaryDescriptor descriptor{};
  PointHandle handle;
  int octave = 0;           ///< level at which it is expected
  float angle_rad = -1.0F;  ///< orientation when last seen, < 0: unknown
  double radius_px = 15.0;  ///< searched around its projection, at level 0; grows with the level
};

/// Candidate `candidate` is shown by feature `feature`.
struct Match {
  std::int32_t candidate = -1;
  std::int32_t feature = -1;
  int distance = 256;
};

struct ProjectionMatchOptions {
  int levels_below = 1;    ///< levels searched below the expected one ...
  int levels_above = 1;    ///< ... and above
  double max_ratio = 1.0;  ///< best distance / second best of the same level, 1 accepts all
  bool check_rotation = true;
};

/// Reused between calls.
struct MatchWorkspace {
  std::vector<std::int32_t> match_of_feature;
};

/// Features near where the candidates project under `T_camera_world`. Every feature serves the
/// candidate with the least distance, ties to the earlier candidate. Features for which
/// `taken` is non-zero are left alone (empty: none). Matches come out by candidate.
void match_by_projection(const TrackingCamera& camera, const FeatureFrame& frame,
                         const Pose& T_camera_world, const std::vector<MatchCandidate>& candidates,
                         const std::vector<std::uint8_t>& taken,
                         const ProjectionMatchOptions& options, MatchWorkspace* workspace,
                         std::vector<Match>* matches);

/// Brute-force matches by descriptor alone, each feature used once, with ratio and rotation test.
void match_by_descriptor(const FeatureFrame& frame, const std::vector<MatchCandidate>& candidates,
                         double max_ratio, MatchWorkspace* workspace, std::vector<Match>* matches);

}  // namespace srslam::detail
