#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/map.hpp"
#include "pipeline/matching.hpp"
#include "pipeline/pose_solver.hpp"
#include "srslam/pipeline/pipeline_options.hpp"

namespace srslam::detail {

/// A tiny blurred copy of the image by which keyframes are compared as a whole.
void make_thumbnail(const ImageView<const std::uint8_t>& gray,
                    std::vector<std::uint8_t>* thumbnail);

/// Zero-mean normalised correlation in [-1, 1]; 0 for images without contrast.
double thumbnail_similarity(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b);

struct Relocalization {
  Status status;
  Pose T_world_camera = Pose::Identity();
  std::int32_t keyframe = -1;  ///< that the frame was found against
  int num_inliers = 0;
};

/// Finds a frame in the map without a guess: keyframes that look alike as a whole, descriptor
/// matches to their points, a RANSAC over three-point alignments of measured and mapped points,
/// and a robust solve with further matches by projection. On success `frame->points` holds the
/// inliers.
class Relocalizer {
 public:
  explicit Relocalizer(const PipelineOptions& options) : options_(options) {}

  /// `last_keyframe` is tried first; `frame_number` varies the random samples.
  Relocalization find(const Map& map, std::int32_t last_keyframe, std::uint32_t frame_number,
                      const std::vector<std::uint8_t>& thumbnail, FeatureFrame* frame);

 private:
  bool find_in(const Map& map, std::int32_t keyframe, std::uint32_t seed, FeatureFrame* frame,
               Relocalization* result);
  bool align_by_samples(const Map& map, const FeatureFrame& frame, std::uint32_t seed,
                        Pose* T_world_camera) const;

  const PipelineOptions options_;
  std::vector<MatchCandidate> candidates_;
  std::vector<Match> matches_;
  std::vector<Match> more_matches_;
  std::vector<std::uint8_t> taken_;
  std::vector<PoseObservation> observations_;
  MatchWorkspace workspace_;
};

}  // namespace srslam::detail
