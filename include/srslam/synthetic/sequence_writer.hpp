#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "srslam/core/status.hpp"
#include "srslam/synthetic/synthetic_world.hpp"

namespace srslam {

struct SequenceWriterOptions {
  bool flow = false;       ///< also write flow/ (16-bit PNG, see docs/synthetic.md)
  bool jpeg = false;       ///< colour as JPEG (quality 95) in place of PNG: a quarter of the size
  int num_threads = 1;     ///< frames are drawn side by side; the files do not depend on it
  bool overwrite = false;  ///< write into a folder that already holds a sequence
};

/// Called after each frame with the number of frames done, one call at a time; false stops.
using SequenceProgress = std::function<bool(std::size_t num_done)>;

/// Draws every frame of `world` into `folder` in the TUM layout: rgb/ and depth/ with their lists,
/// groundtruth.txt, camera.yaml, masks/, detections.txt and scenario.json. The lists are written at
/// the end, so that a folder that was not finished is not taken for a sequence. Fails without
/// touching anything (kInvalidArgument) when the folder holds something and `overwrite` is not set,
/// or when it holds images that no scenario.json says are rendered. A stop by `progress` is
/// kNotConverged.
FileStatus write_sequence(const SyntheticWorld& world, const std::string& folder,
                          const SequenceWriterOptions& options,
                          const SequenceProgress& progress = {});

}  // namespace srslam
