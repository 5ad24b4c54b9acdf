#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "srslam/pipeline/reference_pipeline.hpp"

namespace srslam::cli {

/// A feature as a picture shows it.
struct DrawnFeature {
  float u_px = 0.0F;
  float v_px = 0.0F;
  FeatureLabel label = FeatureLabel::kUnmatched;
  bool potential = false;  ///< may move, by module D, removed or not
};

/// The features of every frame of a run, until it is known which frames are shown. They are kept in
/// a file without a name, because a long run has more of them than memory should hold; the system
/// removes it with the process.
class FeatureStore {
 public:
  FeatureStore() = default;
  ~FeatureStore();
  FeatureStore(const FeatureStore&) = delete;
  FeatureStore& operator=(const FeatureStore&) = delete;

  /// Makes the file in `folder`. Without it nothing is kept.
  void open(const std::string& folder);

  void append(std::size_t frame_index, const PipelineResult& result);

  /// Features of a frame; empty when none are kept.
  std::vector<DrawnFeature> read(std::size_t frame_index) const;

 private:
  struct Place {
    std::int64_t offset = 0;
    std::size_t count = 0;
  };

  int descriptor_ = -1;
  std::int64_t size_ = 0;
  std::map<std::size_t, Place> places_;
};

}  // namespace srslam::cli
