#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/culling/dbscan_types.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam::test {

/// What clustering libraries are compared on.
enum class ClusterInput {
  kSlam,  ///< image coordinates / width, then depth [m], then flow: twenty blobs, 40 % background
  kUniform,  ///< the unit cube, eps for six neighbours
  kBlob,     ///< every point near every other
};

inline std::string to_string(ClusterInput input) {
  const char* const names[] = {"slam", "uniform", "blob"};
  return names[static_cast<std::size_t>(input)];
}

/// The input of n points with D = 2 (image), 3 (and depth), 4 (image and flow) or 5 (all)
/// dimensions, and the options that go with it; `frame` tells draws of the same kind apart.
template <typename Scalar, std::size_t D>
std::vector<std::array<Scalar, D>> cluster_input(ClusterInput input, std::size_t n,
                                                 DbscanOptions* options, std::uint64_t frame = 0) {
  Rng rng(1000 * D + n + 1000003 * frame);
  std::vector<std::array<Scalar, D>> points(n);
  if (input != ClusterInput::kSlam) {
    options->min_points = 5;
    options->eps = 0.05;
    if (input == ClusterInput::kUniform) {
      const double unit_ball = std::pow(kPi, 0.5 * D) / std::tgamma(0.5 * D + 1.0);
      options->eps = std::pow(6.0 / (double(n) * unit_ball), 1.0 / double(D));
    }
    for (auto& point : points) {
      for (Scalar& x : point) {
        x = Scalar(input == ClusterInput::kUniform ? rng.uniform(0.0, 1.0)
                                                   : 0.5 + 0.002 * rng.normal());
      }
    }
    return points;
  }
  constexpr double kEps[] = {0.03, 0.05, 0.04, 0.05};
  options->eps = kEps[D - 2];
  options->min_points = 4;
  struct Blob {
    double u, v, sigma, depth_m, du, dv;
  };
  std::array<Blob, 20> blobs{};
  for (Blob& blob : blobs) {
    blob.u = rng.uniform(0.0, 1.0);
    blob.v = rng.uniform(0.0, 0.75);
    blob.sigma = rng.uniform(0.01, 0.04);
    blob.depth_m = rng.uniform(0.6, 4.5);
    blob.du = 0.015 * rng.normal();
    blob.dv = 0.015 * rng.normal();
  }
  for (auto& point : points) {
    const Blob& blob = blobs[std::size_t(rng.uniform_int(0, 19))];
    const bool is_background = rng.uniform(0.0, 1.0) < 0.4;
    std::array<double, 5> x{};
    x[0] = is_background ? rng.uniform(0.0, 1.0) : blob.u + blob.sigma * rng.normal();
    x[1] = is_background ? rng.uniform(0.0, 0.75) : blob.v + blob.sigma * rng.normal();
    x[0] = std::clamp(x[0], 0.0, 1.0);
    x[1] = std::clamp(x[1], 0.0, 0.75);
    x[2] = is_background ? rng.uniform(0.6, 4.5) : blob.depth_m + 0.03 * rng.normal();
    x[3] = is_background ? 0.003 * rng.normal() : blob.du + 0.002 * rng.normal();
    x[4] = is_background ? 0.003 * rng.normal() : blob.dv + 0.002 * rng.normal();
    for (std::size_t axis = 0; axis < D; ++axis) {
      const std::size_t source = D == 4 && axis >= 2 ? axis + 1 : axis;
      point[axis] = Scalar(x[source]);
    }
  }
  return points;
}

}  // namespace srslam::test
