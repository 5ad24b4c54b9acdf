#pragma once

#include <cstdint>
#include <vector>

#include "srslam/core/detection.hpp"
#include "synthetic/renderer.hpp"
#include "synthetic/scene.hpp"

namespace srslam::detail {

/// What a detector trained on everyday classes would say of a frame: it knows people, chairs and
/// screens, not boxes or boards; it misses small, cut and hidden things more often, for several
/// frames in a row; its boxes are off by a few per cent of their size, its scores grow with what is
/// to be seen; now and then it sees something where nothing is.
std::vector<Detection> model_detections(const Scene& scene, const PixelBuffers& pixels,
                                        std::uint64_t seed, std::uint64_t frame);

}  // namespace srslam::detail
