#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/core/status.hpp"
#include "srslam/io/camera_file.hpp"

namespace srslam {

/// Version of the worlds. Figures measured on sequences of different versions do not compare.
constexpr int kSyntheticWorldVersion = 1;

/// One of the built-in scenarios.
struct ScenarioInfo {
  std::string name;
  std::string description;
};

/// Every scenario, in documentation order.
std::vector<ScenarioInfo> scenario_list();

/// How the camera turns light and distance into pixels.
struct SyntheticSensorOptions {
  /// No noise, no vignetting, no holes, no quantisation but that of the pixel formats.
  bool clean = false;
  /// Strength of slow changes of the exposure, as a share of the brightness; 0: none. [0, 0.9]
  double exposure_change = 0.0;
  /// Exposure time over which moving things blur [s]; 0: none. [0, 1/30]
  double exposure_time_s = 0.0;
};

struct SyntheticOptions {
  std::string scenario = "walking_xyz";
  std::uint64_t seed = 1;  ///< changes looks, ways, tremor and noise; equal seeds, equal bytes
  std::size_t num_frames = 300;  ///< at 30 Hz; [1, 100000]
  /// Intrinsics, depth scale and frame rate; see synthetic_camera().
  RgbdCamera camera;
  SyntheticSensorOptions sensor;

  /// Ok, or what is wrong and what would be right.
  FileStatus validate() const;
};

/// Camera of a preset (`tum_fr3` and `bonn` are meant) for another image size, its field of view
/// kept: `width_px` by `height_px` must have the preset's aspect ratio. Poses are of the camera.
FileStatus synthetic_camera(const std::string& preset, int width_px, int height_px,
                            RgbdCamera* camera);

}  // namespace srslam
