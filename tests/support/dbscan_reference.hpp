#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/culling/dbscan_types.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam::test {

struct ReferenceClusters {
  std::vector<std::int32_t> labels;
  std::vector<PointKind> kinds;
  int num_clusters = 0;
};

/// DBSCAN as its definition reads, with every pair of points and no other cleverness. Border points
/// go to the nearest core point, of equally near ones to that with the smaller coordinates.
template <typename Point>
ReferenceClusters reference_dbscan(const std::vector<Point>& points, double eps, int min_points) {
  using Traits = PointTraits<Point>;
  using Scalar = typename Traits::Scalar;
  const std::size_t n = points.size();
  const Scalar eps_squared = static_cast<Scalar>(eps) * static_cast<Scalar>(eps);
  const auto squared_distance = [&](std::size_t a, std::size_t b) {
    Scalar sum = 0;
    for (int axis = 0; axis < Traits::kDimension; ++axis) {
      const Scalar difference =
          Traits::coordinate(points[a], axis) - Traits::coordinate(points[b], axis);
      sum += difference * difference;
    }
    return sum;
  };
  const auto is_valid = [&](std::size_t i) {
    for (int axis = 0; axis < Traits::kDimension; ++axis) {
      if (!std::isfinite(Traits::coordinate(points[i], axis))) return false;
    }
    return true;
  };
  const auto are_near = [&](std::size_t a, std::size_t b) {
    return is_valid(a) && is_valid(b) && squared_distance(a, b) <= eps_squared;
  };
  ReferenceClusters result;
  result.labels.assign(n, kNoiseLabel);
  result.kinds.assign(n, PointKind::kNoise);
  for (std::size_t i = 0; i < n; ++i) {
    int num_neighbors = 0;
    for (std::size_t j = 0; j < n; ++j) num_neighbors += are_near(i, j) ? 1 : 0;
    if (num_neighbors >= min_points) result.kinds[i] = PointKind::kCore;
  }
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (result.kinds[seed] != PointKind::kCore || result.labels[seed] != kNoiseLabel) continue;
    std::vector<std::size_t> pending{seed};
    result.labels[seed] = result.num_clusters;
    while (!pending.empty()) {
      const std::size_t point = pending.back();
      pending.pop_back();
      for (std::size_t i = 0; i < n; ++i) {
        if (result.kinds[i] != PointKind::kCore || result.labels[i] != kNoiseLabel) continue;
        if (!are_near(point, i)) continue;
        result.labels[i] = result.num_clusters;
        pending.push_back(i);
      }
    }
    ++result.num_clusters;
  }
  const auto precedes = [&](std::size_t a, std::size_t b) {
    for (int axis = 0; axis < Traits::kDimension; ++axis) {
      const Scalar x = Traits::coordinate(points[a], axis);
      const Scalar y = Traits::coordinate(points[b], axis);
      if (x != y) return x < y;
    }
    return false;
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (result.kinds[i] == PointKind::kCore) continue;
    std::size_t nearest = n;
    for (std::size_t j = 0; j < n; ++j) {
      if (result.kinds[j] != PointKind::kCore || !are_near(i, j)) continue;
      if (nearest == n || squared_distance(i, j) < squared_distance(i, nearest) ||
          (squared_distance(i, j) == squared_distance(i, nearest) && precedes(j, nearest))) {
        nearest = j;
      }
    }
    if (nearest == n) continue;
    result.kinds[i] = PointKind::kBorder;
    result.labels[i] = result.labels[nearest];
  }
  return result;
}

/// What points to cluster look like.
enum class PointPattern {
  kUniform,
  kBlobs,
  kDuplicates,
  kLine,
  kLattice,
  kFarAway,
  kFarApart,
  kNoNumbers
};
constexpr PointPattern kPointPatterns[] = {PointPattern::kUniform,    PointPattern::kBlobs,
                                           PointPattern::kDuplicates, PointPattern::kLine,
                                           PointPattern::kLattice,    PointPattern::kFarAway,
                                           PointPattern::kFarApart,   PointPattern::kNoNumbers};

inline std::string to_string(PointPattern pattern) {
  const char* const names[] = {"uniform", "blobs",    "duplicates", "line",
                               "lattice", "far away", "far apart",  "nan"};
  return names[static_cast<std::size_t>(pattern)];
}

/// Points for which eps = 0.1 and some four neighbours give clusters and noise.
template <typename Scalar, std::size_t D>
std::vector<std::array<Scalar, D>> points_to_cluster(PointPattern pattern, std::size_t n,
                                                     Rng& rng) {
  std::vector<std::array<Scalar, D>> points(n);
  // About six points in a ball of radius 0.1, whatever the dimension.
  const double extent = 0.17 * std::pow(double(n) / 6.0, 1.0 / double(D)) + 0.05;
  std::vector<std::array<double, D>> centers(1 + n / 40);
  for (auto& center : centers) {
    for (double& x : center) x = rng.uniform(0.0, 1.0);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto& center = centers[i % centers.size()];
    const double along = rng.uniform(0.0, 0.02 * double(n));
    for (std::size_t axis = 0; axis < D; ++axis) {
      double x = rng.uniform(0.0, extent);
      switch (pattern) {
        case PointPattern::kUniform:
        case PointPattern::kNoNumbers:
          break;
        case PointPattern::kBlobs:
          if (i % 3 != 0) x = center[axis] + 0.05 * rng.normal();
          break;
        case PointPattern::kDuplicates:
          if (i >= 10) x = double(points[i % (3 + n / 10)][axis]);
          break;
        case PointPattern::kLine:
          x = axis == 0 ? along : 0.5 * along;
          break;
        case PointPattern::kLattice:  // exactly eps apart, in numbers without rounding
          x = double(rng.uniform_int(0, 1 + int(std::pow(double(n), 1.0 / double(D))))) * 0.125;
          break;
        case PointPattern::kFarAway:  // few digits are left
          x += axis == 0 ? 1e5 : -3e4;
          break;
        case PointPattern::kFarApart:
          x += i % 4 == 0 ? 1e6 * double(i % 7) : (i % 4 == 1 ? -1e30 : 0.0);
          break;
      }
      points[i][axis] = static_cast<Scalar>(x);
    }
    if (pattern == PointPattern::kNoNumbers && i % 5 == 0) {
      const double odd[] = {kNan, kInf, -kInf};
      points[i][i % D] = static_cast<Scalar>(odd[i % 3]);
    }
  }
  return points;
}

}  // namespace srslam::test
