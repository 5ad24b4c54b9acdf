#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan_lanes.hpp"
#include "srslam/culling/dbscan_workspace.hpp"

namespace srslam {

/// Points of an image that others are asked to be near. Cleared and filled again it allocates
/// nothing.
class NearPoints {
 public:
  void clear() noexcept { size_ = 0; }

  void add(float u, float v) {
    detail::reserve_elements(u_, size_ + 1 + detail::kLanes);
    detail::reserve_elements(v_, size_ + 1 + detail::kLanes);
    u_[size_] = u;
    v_[size_] = v;
    ++size_;
  }

  std::size_t size() const noexcept { return size_; }

  /// Whether a point lies within `radius` of (u, v), the radius included. Never where a coordinate
  /// is no number. O(points).
  bool any_near(float u, float v, float radius) const {
    const detail::PointAxes<float, 2> points = {u_.data(), v_.data()};
    const detail::PointAxes<float, 2> query = {&u, &v};
    std::uint64_t num_comparisons = 0;
    return !detail::visit_neighbors(detail::NearTest<float, 2>(query, 0, radius * radius), points,
                                    0, size_, num_comparisons, [](std::size_t) { return false; });
  }

 private:
  std::vector<float> u_, v_;
  std::size_t size_ = 0;
};

}  // namespace srslam
