#include "cli/report/feature_store.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <type_traits>

namespace srslam::cli {

static_assert(std::is_trivially_copyable_v<DrawnFeature>, "it goes to a file as it is");

FeatureStore::~FeatureStore() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void FeatureStore::open(const std::string& folder) {
  const std::string file = (std::filesystem::path(folder) / ".features.tmp").string();
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (descriptor_ >= 0) ::unlink(file.c_str());
}

void FeatureStore::append(std::size_t frame_index, const PipelineResult& result) {
  if (descriptor_ < 0) return;
  std::vector<DrawnFeature> features;
  const std::size_t count = std::min(result.features.size, result.labels.size);
  features.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const bool potential = result.has_culling && result.culling.suspicions[i].potential();
    features.push_back(
        {result.features[i].u_px, result.features[i].v_px, result.labels[i], potential});
  }
  const std::size_t num_bytes = features.size() * sizeof(DrawnFeature);
  // A full disk costs the features of this frame, no more.
  if (::pwrite(descriptor_, features.data(), num_bytes, size_) != static_cast<ssize_t>(num_bytes)) {
    return;
  }
  places_[frame_index] = {size_, features.size()};
  size_ += static_cast<std::int64_t>(num_bytes);
}

std::vector<DrawnFeature> FeatureStore::read(std::size_t frame_index) const {
  const auto place = places_.find(frame_index);
  if (place == places_.end()) return {};
  std::vector<DrawnFeature> features(place->second.count);
  const std::size_t num_bytes = features.size() * sizeof(DrawnFeature);
  if (::pread(descriptor_, features.data(), num_bytes, place->second.offset) !=
      static_cast<ssize_t>(num_bytes)) {
    features.clear();
  }
  return features;
}

}  // namespace srslam::cli
