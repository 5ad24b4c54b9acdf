#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "srslam/core/camera.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/scene/flow_track.hpp"
#include "support/constants.hpp"
#include "support/flow_scene.hpp"
#include "support/rng.hpp"

namespace srslam::test {

/// 0, ..., n - 1 in any order.
inline std::vector<std::size_t> random_order(std::size_t n, Rng& rng) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  for (std::size_t i = n; i > 1; --i) {
    std::swap(order[i - 1], order[std::size_t(rng.uniform_int(0, int(i) - 1))]);
  }
  return order;
}

/// A pinhole camera with any size and lens of those that are sold.
inline PinholeCamera random_flow_camera(Rng& rng) {
  constexpr int kWidths_px[] = {320, 640, 848, 1280};
  PinholeCamera camera = flow_camera(kWidths_px[rng.uniform_int(0, 3)]);
  camera.fx_px = camera.width_px * rng.uniform(0.6, 1.1);
  camera.fy_px = camera.fx_px * rng.uniform(0.97, 1.03);
  camera.cx_px += camera.width_px * rng.uniform(-0.03, 0.03);
  camera.cy_px += camera.height_px * rng.uniform(-0.03, 0.03);
  if (rng.coin()) {
    camera.k1 = rng.uniform(-0.06, 0.06);
    camera.k2 = rng.uniform(-0.05, 0.05);
    camera.p1 = rng.uniform(-0.001, 0.001);
  }
  return camera;
}

/// Features on up to four bodies at their depths and on what is behind, some without depth.
inline std::vector<FlowPoint> bodies_and_background(int n, const PinholeCamera& camera, Rng& rng) {
  struct Body {
    double u, v, width, height, depth_m;
  };
  std::vector<Body> bodies(std::size_t(rng.uniform_int(1, 4)));
  for (Body& body : bodies) {
    body = {rng.uniform(0.1, 0.9), rng.uniform(0.2, 0.6), rng.uniform(0.02, 0.06),
            rng.uniform(0.05, 0.12), rng.uniform(0.8, 3.0)};
  }
  constexpr double kNoDepth_m[] = {0.0, kNan, kInf, -1.0};
  std::vector<FlowPoint> points(static_cast<std::size_t>(n));
  for (FlowPoint& point : points) {
    double u = rng.uniform(0.0, 1.0);
    double v = rng.uniform(0.0, 0.75);
    double depth_m = rng.uniform(2.5, 5.0);
    if (rng.uniform(0.0, 1.0) < 0.7) {
      const Body& body = bodies[std::size_t(rng.uniform_int(0, int(bodies.size()) - 1))];
      u = body.u + body.width * rng.normal();
      v = body.v + body.height * rng.normal();
      depth_m = body.depth_m + 0.06 * rng.normal();
    }
    if (rng.uniform(0.0, 1.0) < 0.12) depth_m = kNoDepth_m[rng.uniform_int(0, 3)];
    point.u_px = float(u * camera.width_px);
    point.v_px = float(v * camera.width_px);
    point.depth_m = float(depth_m);
  }
  return points;
}

/// What stage 1 may say of features: any mixture of objects, anomalies and their neighbours.
inline std::vector<FeatureSuspicion> random_suspicions(std::size_t n, Rng& rng) {
  const double anomalous_share = rng.uniform(0.0, 0.7);
  const double object_share = rng.uniform(0.0, 0.7);
  std::vector<FeatureSuspicion> features(n);
  for (FeatureSuspicion& feature : features) {
    if (rng.uniform(0.0, 1.0) < anomalous_share) {
      feature.anomalies = static_cast<std::uint8_t>(rng.uniform_int(1, 7));
    }
    feature.in_object = rng.uniform(0.0, 1.0) < object_share;
    feature.near_anomaly =
        !feature.anomalous() && !feature.in_object && rng.uniform(0.0, 1.0) < 0.2;
    feature.flow_tested = rng.uniform(0.0, 1.0) < 0.8;
    feature.moves_with_camera =
        feature.flow_tested && !feature.anomalous() && rng.uniform(0.0, 1.0) < 0.7;
  }
  return features;
}

}  // namespace srslam::test
