#pragma once

#include <string>
#include <vector>

#include "srslam/core/camera.hpp"
#include "srslam/core/status.hpp"

namespace srslam {

/// What the poses of a dataset's ground truth file describe.
enum class GroundtruthFrame : unsigned char {
  kCamera,      ///< the optical frame of the camera
  kBonnMarker,  ///< the marker body of the BONN dataset; see camera_pose_from_bonn_marker()
};

/// Everything that must be known of a sensor before its files can be read.
struct RgbdCamera {
  std::string name;  ///< preset name, or the file's path
  PinholeCamera camera;
  double depth_units_per_m = 0.0;  ///< raw 16-bit depth value of one metre (TUM, BONN: 5000)
  double fps = 30.0;               ///< nominal frame rate [1/s]
  GroundtruthFrame groundtruth_frame = GroundtruthFrame::kCamera;

  /// Ok when every number is in the range that docs/camera_file.md states for its key. There is
  /// no default depth scale: 0 is refused.
  Status validate() const noexcept;
};

/// Names that camera_preset() knows, in documentation order.
std::vector<std::string> camera_preset_names();

/// Looks a preset up by name (`tum_fr1`, `tum_fr2`, `tum_fr3`, `bonn`). Unknown names fail with
/// kNotFound and a reason that lists the known ones.
FileStatus camera_preset(const std::string& name, RgbdCamera* camera);

/// Reads a YAML camera file (format: docs/camera_file.md). Every key is checked: unknown,
/// missing, repeated or out-of-range keys fail with file, line and reason. On failure `camera` is
/// left as it was.
FileStatus read_camera_file(const std::string& path, RgbdCamera* camera);

/// Writes `camera` so that read_camera_file() restores everything but the name to the last bit.
/// The file is replaced in one step; a camera that validate() refuses is not written.
FileStatus write_camera_file(const std::string& path, const RgbdCamera& camera);

}  // namespace srslam
