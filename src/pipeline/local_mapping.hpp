#pragma once

#include <cstdint>
#include <future>
#include <vector>

#include "pipeline/bundle_adjustment.hpp"
#include "pipeline/map.hpp"
#include "pipeline/matching.hpp"
#include "srslam/pipeline/pipeline_options.hpp"

namespace srslam::detail {

/// Turns tracked frames into keyframes: new points, joined duplicates, culling, and a bundle
/// adjustment that is solved on a copy of the window and applied a fixed number of frames later.
/// That number, not the clock, decides when the map changes, so a second thread changes nothing
/// but the time.
class LocalMapper {
 public:
  LocalMapper(const PipelineOptions& options, Map* map) : options_(options), map_(map) {}
  ~LocalMapper();
  LocalMapper(const LocalMapper&) = delete;
  LocalMapper& operator=(const LocalMapper&) = delete;

  /// No adjustment is waiting to be applied.
  bool idle() const { return !pending_; }

  /// Call at the start of every frame: applies the adjustment when it is due. True when the map
  /// changed.
  bool advance_frame();

  /// Applies what is waiting now. True when the map changed.
  bool apply_pending();

  /// Adds the frame as a keyframe with `frame.points` as its map points, and starts the
  /// adjustment of its neighbourhood. Applies a waiting one first; the caller re-reads its poses.
  std::int32_t insert(double timestamp_s, const Pose& T_world_camera, const FeatureFrame& frame,
                      std::vector<std::uint8_t> thumbnail);

  /// Time of the last applied solve [ms]; 0 once read.
  double take_solve_ms();

 private:
  void create_points(Keyframe* keyframe);
  void fuse_with_neighbours(std::int32_t keyframe);
  void fuse_into(const std::vector<PointHandle>& points, std::int32_t keyframe);
  void refresh_points_of(const Keyframe& keyframe);
  void cull_recent_points(std::int32_t newest_keyframe);
  void cull_keyframes();
  double redundancy(const Keyframe& keyframe) const;
  void build_problem(std::int32_t keyframe);

  const PipelineOptions options_;
  Map* map_;
  std::vector<PointHandle> recent_points_;
  std::int32_t newest_keyframe_ = -1;

  bool pending_ = false;
  int frames_until_applied_ = 0;
  BundleProblem problem_;
  std::future<void> solve_;
  double last_solve_ms_ = 0.0;

  // Reused between insertions.
  std::vector<Map::Neighbour> neighbours_;
  std::vector<MatchCandidate> candidates_;
  std::vector<PointHandle> collected_;
  std::vector<std::pair<double, std::int32_t>> by_depth_;
};

}  // namespace srslam::detail
