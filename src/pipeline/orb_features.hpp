#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "srslam/core/feature.hpp"
#include "srslam/core/feature_options.hpp"
#include "srslam/core/image_view.hpp"

namespace srslam::detail {

/// Features of one image and their descriptors, in step.
struct OrbFeatures {
  std::vector<Feature> features;
  std::vector<BinaryDescriptor> descriptors;
};

/// ORB features of corners that are spread evenly (CornerPyramid), with FAST scores as responses.
/// Keeps its buffers between calls.
class OrbExtractor {
 public:
  explicit OrbExtractor(const FeatureOptions& options);
  ~OrbExtractor();
  OrbExtractor(const OrbExtractor&) = delete;
  OrbExtractor& operator=(const OrbExtractor&) = delete;

  /// `mask` may be empty; else it has the size of `gray` and no feature is taken where it is 0.
  /// Output is ordered by level, then by cell, and depends on nothing but the input.
  void extract(const ImageView<const std::uint8_t>& gray, const ImageView<const std::uint8_t>& mask,
               OrbFeatures* output);

  /// Size of a pixel of `octave` in pixels of level 0.
  const std::vector<float>& level_scales() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srslam::detail
