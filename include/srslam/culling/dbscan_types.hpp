#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <Eigen/Core>

#include "srslam/core/status.hpp"

namespace srslam {

/// How clustering reads a point: its dimension (1 to 6), the type of its coordinates (float or
/// double) and where they are. Specialise it for your own type; nothing has to be converted:
///
///     template <>
///     struct srslam::PointTraits<MyPoint> {
///       using Scalar = float;
///       static constexpr int kDimension = 2;
///       static Scalar coordinate(const MyPoint& p, int axis) { return axis == 0 ? p.u : p.v; }
///     };
template <typename Point, typename Enable = void>
struct PointTraits;

template <typename T, std::size_t N>
struct PointTraits<std::array<T, N>> {
  using Scalar = T;
  static constexpr int kDimension = static_cast<int>(N);
  static Scalar coordinate(const std::array<T, N>& point, int axis) noexcept {
    return point[static_cast<std::size_t>(axis)];
  }
};

/// Column vectors of Eigen, of a size known to the compiler.
template <typename T, int N, int Options>
struct PointTraits<Eigen::Matrix<T, N, 1, Options, N, 1>, std::enable_if_t<(N > 0)>> {
  using Scalar = T;
  static constexpr int kDimension = N;
  static Scalar coordinate(const Eigen::Matrix<T, N, 1, Options, N, 1>& point, int axis) noexcept {
    return point[axis];
  }
};

/// How neighbours are found. The clusters are the same.
enum class NeighborSearch : std::uint8_t {
  kAutomatic,   ///< whichever is expected to be fastest for number, dimension and density
  kBruteForce,  ///< every pair; n² comparisons up to 512 points
  kSweep,       ///< pairs that are near along one axis; above 4096 points kGrid instead
  kGrid,        ///< cells in which all points are neighbours of each other
  kKdTree,      ///< by nanoflann; only dbscan_kd_tree() in srslam/interop/nanoflann.hpp offers it
};

constexpr const char* to_string(NeighborSearch search) noexcept {
  switch (search) {
    case NeighborSearch::kAutomatic:
      return "automatic";
    case NeighborSearch::kBruteForce:
      return "brute_force";
    case NeighborSearch::kSweep:
      return "sweep";
    case NeighborSearch::kGrid:
      return "grid";
    case NeighborSearch::kKdTree:
      return "kd_tree";
  }
  return "unknown";
}

struct DbscanOptions {
  double eps = 0.05;   ///< neighbours are this near or nearer, in the points' unit; > 0, finite
  int min_points = 3;  ///< a core point has this many neighbours, itself included; >= 1
  NeighborSearch search = NeighborSearch::kAutomatic;  ///< changes no label
  int num_threads = 1;  ///< of the grid, from 20 000 points on; changes no label; 1..64

  Status validate() const noexcept {
    const auto bad = [](const char* reason) {
      return Status::failure(StatusCode::kInvalidArgument, reason);
    };
    if (!(eps > 0.0) || !std::isfinite(eps)) return bad("eps must be positive and finite");
    if (min_points < 1) return bad("min_points must be at least 1");
    if (num_threads < 1 || num_threads > 64) return bad("num_threads must be 1 to 64");
    return Status::success();
  }
};

/// Label of points that belong to no cluster; clusters are 0, 1, ...
constexpr std::int32_t kNoiseLabel = -1;

/// What a point is to its cluster.
enum class PointKind : std::uint8_t {
  kNoise,   ///< no core point is near
  kBorder,  ///< not core, but near a core point
  kCore,    ///< has min_points neighbours
};

struct DbscanResult {
  Status status;
  int num_clusters = 0;
  std::size_t num_core = 0;
  std::size_t num_border = 0;
  std::size_t num_noise = 0;
  std::size_t num_invalid = 0;        ///< of the noise: points with a coordinate that is no number
  std::uint64_t num_comparisons = 0;  ///< distances between points that were looked at
  NeighborSearch search = NeighborSearch::kAutomatic;  ///< that was used
};

}  // namespace srslam
