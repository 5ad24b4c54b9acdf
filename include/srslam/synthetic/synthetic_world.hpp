#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "srslam/core/detection.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/status.hpp"
#include "srslam/synthetic/synthetic_options.hpp"

namespace srslam {

/// Something that moves, as masks know it.
struct SyntheticMover {
  int instance = 0;        ///< value in the masks, 1 to 255
  std::string class_name;  ///< such as "person" or "box"
  std::string motion;      ///< what it does
};

/// One frame with everything that is known of it. All images have the camera's size.
struct SyntheticFrame {
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();  ///< of the camera, world z up, floor at z = 0
  ImageBuffer<Bgr8> color;
  ImageBuffer<std::uint16_t>
      raw_depth;                    ///< as the sensor gives it: depth · depth_units_per_m, 0: none
  ImageBuffer<float> true_depth_m;  ///< along the optical axis, at pixel centres; 0: nothing seen
  ImageBuffer<std::uint8_t> instances;  ///< SyntheticMover::instance, 0 for what stands still
  std::vector<Detection> detections;    ///< of a modelled detector: misses, false alarms, jitter
};

/// A furnished room in which people and things move, seen by a moving RGB-D camera. Made from a
/// scenario and a seed; the same options give the same frames on the same build, whatever the
/// order in which they are asked for. Immutable: any number of threads may use one world, each
/// through a renderer of its own.
class SyntheticWorld {
 public:
  SyntheticWorld();
  ~SyntheticWorld();
  SyntheticWorld(SyntheticWorld&& other) noexcept;
  SyntheticWorld& operator=(SyntheticWorld&& other) noexcept;

  /// Builds the world, which takes a few seconds at 640x480. On failure the world is left as it
  /// was.
  FileStatus create(const SyntheticOptions& options);

  const SyntheticOptions& options() const;
  double timestamp_s(std::size_t frame) const;
  Pose T_world_camera(std::size_t frame) const;
  const std::vector<SyntheticMover>& movers() const;
  /// The scenario with seed, version, camera, sensor and movers as a JSON document.
  std::string description_json() const;

 private:
  friend class SyntheticRenderer;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Draws the frames of a world. Not for several threads at once; make one a thread.
class SyntheticRenderer {
 public:
  /// `world` must have been created and must outlive the renderer.
  explicit SyntheticRenderer(const SyntheticWorld& world);
  ~SyntheticRenderer();
  SyntheticRenderer(const SyntheticRenderer&) = delete;
  SyntheticRenderer& operator=(const SyntheticRenderer&) = delete;

  /// Frame `index` < options().num_frames. Buffers keep their allocations.
  Status render(std::size_t index, SyntheticFrame* frame);

  /// Where what each pixel of the frame rendered last shows has gone in frame `index` [px]: the
  /// displacement of the surface point, whether or not something hides it there. NaN where it
  /// leaves the camera's domain (behind the camera, or beyond the lens model) or nothing is seen.
  Status flow_to(std::size_t index, ImageBuffer<Eigen::Vector2f>* flow_px) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srslam
