#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/feature_frame.hpp"
#include "pipeline/map.hpp"

namespace srslam::detail {

/// A self-contained copy of the part of the map that is to be adjusted, so that the solve can run
/// beside tracking, and the solution once solved.
struct BundleProblem {
  struct View {
    std::int32_t keyframe = -1;
    Pose T_world_camera = Pose::Identity();
    bool fixed = false;
  };
  struct Landmark {
    PointHandle handle;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  };
  struct Edge {
    std::int32_t view = -1;
    std::int32_t landmark = -1;
    Measurement measurement;
    double inverse_sigma = 1.0;
    bool inlier = true;  ///< result
  };
  std::vector<View> views;
  std::vector<Landmark> landmarks;
  std::vector<Edge> edges;

  // Results.
  bool usable = false;
  int num_iterations = 0;
  double solve_ms = 0.0;

  void clear() {
    views.clear();
    landmarks.clear();
    edges.clear();
    usable = false;
    num_iterations = 0;
    solve_ms = 0.0;
  }
};

/// Adjusts poses and landmarks in place with Ceres under a Huber cost and judges every edge by the
/// χ² gate afterwards. One thread, so that the bits depend on nothing but the problem. On failure
/// `usable` stays false and the problem holds its initial values.
void solve_bundle(const TrackingCamera& camera, int max_iterations, BundleProblem* problem);

}  // namespace srslam::detail
