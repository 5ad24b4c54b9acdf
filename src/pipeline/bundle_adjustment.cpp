#include "pipeline/bundle_adjustment.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>

#include "pipeline/pose_solver.hpp"
#include "srslam/interop/ceres.hpp"

namespace srslam::detail {
namespace {

double gate(const Measurement& measurement) {
  return measurement.has_depth() ? kChi2PixelDepth : kChi2Pixel;
}

/// Parameter blocks and cost functions of one solve; they live as long as the ceres::Problem.
struct CeresBundle {
  std::vector<std::array<double, kPoseBlockSize>> poses;
  std::vector<RgbdObservation> observations;
  std::deque<RgbdReprojectionCost> costs;  // cost functions cannot be moved
  RgbdIntrinsics intrinsics;
  TangentPoseManifold manifold;
};

double squared_error(const CeresBundle& bundle, const BundleProblem& problem, std::size_t edge) {
  const BundleProblem::Edge& e = problem.edges[edge];
  const std::array<const double*, 2> parameters = {
      bundle.poses[static_cast<std::size_t>(e.view)].data(),
      problem.landmarks[static_cast<std::size_t>(e.landmark)].position_m.data()};
  Eigen::Vector3d residual;
  if (!bundle.costs[edge].Evaluate(parameters.data(), residual.data(), nullptr)) {
    return std::numeric_limits<double>::infinity();
  }
  return residual.squaredNorm();
}

}  // namespace

void solve_bundle(const TrackingCamera& camera, int max_iterations, BundleProblem* problem) {
  const auto start = std::chrono::steady_clock::now();
  problem->usable = false;

  CeresBundle bundle;
  bundle.intrinsics = {camera.fx, camera.fy, camera.cx, camera.cy, camera.baseline_fx};
  bundle.poses.resize(problem->views.size());
  for (std::size_t i = 0; i < problem->views.size(); ++i) {
    pose_to_block(problem->views[i].T_world_camera, bundle.poses[i].data());
  }
  bundle.observations.reserve(problem->edges.size());
  for (const BundleProblem::Edge& edge : problem->edges) {
    bundle.observations.push_back({edge.measurement.pixel.x(), edge.measurement.pixel.y(),
                                   edge.measurement.disparity_px, edge.inverse_sigma});
    bundle.costs.emplace_back(&bundle.observations.back(), &bundle.intrinsics);
  }
  for (std::size_t i = 0; i < problem->edges.size(); ++i) {
    // Ceres would write to stderr about a start that it cannot evaluate.
    if (!std::isfinite(squared_error(bundle, *problem, i))) return;
  }
  const std::vector<BundleProblem::Landmark> initial_landmarks = problem->landmarks;

  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem ceres_problem(problem_options);
  ceres::HuberLoss huber_pixel(std::sqrt(kChi2Pixel));
  ceres::HuberLoss huber_depth(std::sqrt(kChi2PixelDepth));

  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t i = 0; i < problem->views.size(); ++i) {
    double* block = bundle.poses[i].data();
    ceres_problem.AddParameterBlock(block, kPoseBlockSize, &bundle.manifold);
    if (problem->views[i].fixed) ceres_problem.SetParameterBlockConstant(block);
    ordering->AddElementToGroup(block, 1);
  }
  for (BundleProblem::Landmark& landmark : problem->landmarks) {
    ceres_problem.AddParameterBlock(landmark.position_m.data(), 3);
    ordering->AddElementToGroup(landmark.position_m.data(), 0);
  }
  for (std::size_t i = 0; i < problem->edges.size(); ++i) {
    const BundleProblem::Edge& edge = problem->edges[i];
    ceres_problem.AddResidualBlock(
        &bundle.costs[i], edge.measurement.has_depth() ? &huber_depth : &huber_pixel,
        bundle.poses[static_cast<std::size_t>(edge.view)].data(),
        problem->landmarks[static_cast<std::size_t>(edge.landmark)].position_m.data());
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;  // sums of several threads would come in any order
  options.logging_type = ceres::SILENT;
  // Steps that lower the cost by less move nothing that tracking would notice (docs/pipeline.md).
  options.function_tolerance = 1e-3;
  options.parameter_tolerance = 1e-7;

  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  const bool usable = summary.IsSolutionUsable();
  problem->num_iterations = static_cast<int>(summary.iterations.size());
  if (usable) {
    for (std::size_t i = 0; i < problem->views.size(); ++i) {
      if (!problem->views[i].fixed) {
        problem->views[i].T_world_camera = pose_from_block(bundle.poses[i].data());
      }
    }
    for (std::size_t i = 0; i < problem->edges.size(); ++i) {
      BundleProblem::Edge& edge = problem->edges[i];
      edge.inlier = squared_error(bundle, *problem, i) <= gate(edge.measurement);
    }
  } else {
    problem->landmarks = initial_landmarks;
  }
  problem->usable = usable;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  problem->solve_ms = elapsed.count();
}

}  // namespace srslam::detail
