// Cost of the baseline's parts and of whole frames, all on made-up input.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/bundle_adjustment.hpp"
#include "pipeline/culling_module.hpp"
#include "pipeline/feature_frame.hpp"
#include "pipeline/matching.hpp"
#include "pipeline/orb_features.hpp"
#include "pipeline/pose_solver.hpp"
#include "pipeline/scene_module.hpp"
#include "pipeline/stopwatch.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "support/rendered_world.hpp"
#include "support/rng.hpp"
#include "support/tracking_frames.hpp"

namespace srslam {
namespace {

using detail::BundleProblem;
using detail::Measurement;
using test::RenderedFrame;
using test::RenderedWorld;
using test::Rng;

const PinholeCamera kCamera = test::ideal_camera();

Measurement measure(const detail::TrackingCamera& camera, const Eigen::Vector3d& point_camera_m,
                    Rng* rng) {
  const Eigen::Vector3d projected = camera.project(point_camera_m);
  Measurement measurement;
  measurement.pixel = projected.head<2>() + Eigen::Vector2d(rng->normal(), rng->normal());
  measurement.disparity_px = std::max(0.5, projected.z() + rng->normal());
  measurement.depth_m = camera.baseline_fx / measurement.disparity_px;
  return measurement;
}

void BM_ExtractFeatures(benchmark::State& state) {
  RenderedFrame frame;
  RenderedWorld(1).render(kCamera, Pose::Identity(), &frame.gray, &frame.depth_m);
  detail::OrbExtractor extractor({});
  detail::OrbFeatures features;
  for (auto _ : state) {
    extractor.extract(frame.gray.view(), {}, &features);
    benchmark::DoNotOptimize(features.features.data());
  }
  state.counters["features"] = static_cast<double>(features.features.size());
}
BENCHMARK(BM_ExtractFeatures)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Module D of a frame, which module S has assessed before (not timed): the features followed one
/// frame back, regions, removal. `people`: half of the features lie in a person's box.
void BM_CullingModule(benchmark::State& state) {
  const bool people = state.range(0) != 0;
  constexpr int kNumFrames = 12;
  const std::vector<RenderedFrame> frames =
      test::render_path(RenderedWorld(3), kCamera, kNumFrames);
  detail::OrbExtractor extractor({});
  std::vector<detail::OrbFeatures> features(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    extractor.extract(frames[i].gray.view(), {}, &features[i]);
  }
  const std::vector<Detection> boxes = {{"person", 0.8, 0.25 * kCamera.width_px, 0.0,
                                         0.75 * kCamera.width_px, 1.0 * kCamera.height_px}};
  SceneOptions scene_options;
  scene_options.enabled = true;
  CullingOptions culling_options;
  culling_options.enabled = true;
  detail::SceneModule scene(kCamera, scene_options);
  detail::CullingModule culling(kCamera, culling_options);
  int number = 0;
  int num_removed = 0;
  for (auto _ : state) {
    // There and back, so that the camera never leaps.
    const int place = number++ % (2 * kNumFrames - 2);
    const auto i = static_cast<std::size_t>(std::min(place, 2 * kNumFrames - 2 - place));
    PipelineFrame frame;
    frame.gray = frames[i].gray.view();
    frame.depth_m = frames[i].depth_m.view();
    frame.has_detections = people;
    if (people) frame.detections = boxes;
    const SceneReport report = scene.assess(frame, features[i].features);
    detail::Stopwatch stopwatch;
    const CullingReport culled = culling.cull(frame, features[i].features, report, nullptr, scene);
    state.SetIterationTime(1e-3 * stopwatch.lap_ms());
    if (!culled.status.ok()) state.SkipWithError(culled.status.reason);
    num_removed += culled.removal.num_removed;
  }
  state.counters["removed"] = double(num_removed) / std::max(1, number);
}
BENCHMARK(BM_CullingModule)
    ->ArgName("people")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

void BM_MatchByProjection(benchmark::State& state) {
  Rng rng(2);
  const detail::TrackingCamera camera = test::tracking_camera(kCamera);
  detail::OrbFeatures features = test::random_features(rng, kCamera, 1000);
  const ImageBuffer<float> depth_m = test::random_depth(rng, kCamera, 0.2);
  detail::FeatureFrame frame;
  frame.assign(camera, &features, depth_m.view(), 0.1, 8.0);
  // Half of the candidates belong to features, half to nothing.
  std::vector<detail::MatchCandidate> candidates(2000);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    detail::MatchCandidate& candidate = candidates[i];
    const std::size_t feature = i / 2 % frame.size();
    const Measurement& measurement = frame.measurements[feature];
    const Eigen::Vector2d offset(rng.uniform(-4, 4), rng.uniform(-4, 4));
    candidate.position_m = camera.unproject(measurement.pixel + offset,
                                            measurement.has_depth() ? measurement.depth_m : 2.0);
    candidate.descriptor = i % 2 == 0 ? frame.descriptors[feature] : test::random_descriptor(rng);
    test::flip_bits(rng, 20, &candidate.descriptor);
    candidate.octave = frame.features[feature].octave;
    candidate.radius_px = 12.0;
  }
  detail::MatchWorkspace workspace;
  std::vector<detail::Match> matches;
  for (auto _ : state) {
    match_by_projection(camera, frame, Pose::Identity(), candidates, {}, {}, &workspace, &matches);
    benchmark::DoNotOptimize(matches.data());
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(BM_MatchByProjection)->Unit(benchmark::kMicrosecond);

void BM_SolvePose(benchmark::State& state) {
  Rng rng(3);
  const detail::TrackingCamera camera = test::tracking_camera(kCamera);
  const Pose truth = rng.pose(1.0);
  std::vector<detail::PoseObservation> observations(300);
  const auto in_view = [&] {
    return camera.unproject({rng.uniform(0, 640), rng.uniform(0, 480)}, rng.uniform(0.8, 4.0));
  };
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Eigen::Vector3d point_camera_m = in_view();
    observations[i].position_m = truth * point_camera_m;
    observations[i].measurement = measure(camera, i % 5 == 0 ? in_view() : point_camera_m, &rng);
  }
  Vector6 offset;
  offset << 0.02, -0.01, 0.015, 0.01, -0.01, 0.005;
  const Pose guess = truth * se3_exp(offset);
  int num_inliers = 0;
  for (auto _ : state) {
    const detail::PoseSolution solution = solve_pose(camera, guess, &observations);
    if (!solution.status.ok()) state.SkipWithError(solution.status.reason);
    num_inliers = solution.num_inliers;
  }
  state.counters["inliers"] = num_inliers;
}
BENCHMARK(BM_SolvePose)->Unit(benchmark::kMicrosecond);

void BM_SolveBundle(benchmark::State& state) {
  Rng rng(4);
  const detail::TrackingCamera camera = test::tracking_camera(kCamera);
  BundleProblem initial;
  for (int i = 0; i < 10; ++i) {
    Vector6 tangent;
    tangent << 0.08 * i, 0.01 * i, 0.01 * i, 0.01 * i, -0.03 * i, 0.0;
    initial.views.push_back({i, se3_exp(tangent), i == 0});
  }
  while (initial.landmarks.size() < 2000) {
    const Eigen::Vector3d point(rng.uniform(-1.5, 2.2), rng.uniform(-1.2, 1.2),
                                rng.uniform(1.5, 4.0));
    const auto landmark = static_cast<std::int32_t>(initial.landmarks.size());
    int num_views = 0;
    for (const BundleProblem::View& view : initial.views) {
      BundleProblem::Edge edge;
      edge.view = view.keyframe;
      edge.landmark = landmark;
      edge.measurement = measure(camera, view.T_world_camera.inverse() * point, &rng);
      if (!camera.in_image(edge.measurement.pixel.x(), edge.measurement.pixel.y())) continue;
      initial.edges.push_back(edge);
      ++num_views;
    }
    if (num_views == 0) continue;
    initial.landmarks.push_back({{landmark, 1}, point + rng.vector3(-0.01, 0.01)});
  }
  for (BundleProblem::View& view : initial.views) {
    Vector6 offset;
    offset << rng.vector3(-0.005, 0.005), rng.vector3(-0.003, 0.003);
    if (!view.fixed) view.T_world_camera = view.T_world_camera * se3_exp(offset);
  }
  BundleProblem problem;
  for (auto _ : state) {
    state.PauseTiming();
    problem = initial;
    state.ResumeTiming();
    solve_bundle(camera, 5, &problem);
    if (!problem.usable) state.SkipWithError("not usable");
  }
  state.counters["edges"] = static_cast<double>(initial.edges.size());
  state.counters["solver_iterations"] = problem.num_iterations;
}
BENCHMARK(BM_SolveBundle)->Unit(benchmark::kMillisecond)->UseRealTime();

/// One iteration is one frame of a 90-frame sequence at 640x480, bundle adjustment included; after
/// the last frame a fresh pipeline starts over. The argument is PipelineOptions::num_threads.
void BM_ProcessFrame(benchmark::State& state) {
  static const std::vector<RenderedFrame> frames = test::render_path(RenderedWorld(1), kCamera, 90);
  PipelineOptions options;
  options.num_threads = static_cast<int>(state.range(0));
  ReferencePipeline pipeline(kCamera, options);
  std::size_t next = 0;
  double num_lost = 0.0;
  double num_keyframes = 0.0;
  for (auto _ : state) {
    if (next == frames.size()) {
      state.PauseTiming();
      pipeline = ReferencePipeline(kCamera, options);
      next = 0;
      state.ResumeTiming();
    }
    PipelineFrame input;
    input.timestamp_s = frames[next].timestamp_s;
    input.gray = frames[next].gray.view();
    input.depth_m = frames[next].depth_m.view();
    const PipelineResult result = pipeline.process(input);
    if (result.state != TrackingState::kTracked) num_lost += 1.0;
    if (result.is_keyframe) num_keyframes += 1.0;
    ++next;
  }
  state.counters["lost"] = num_lost;
  state.counters["keyframes_per_100"] =
      100.0 * num_keyframes / static_cast<double>(std::max<std::int64_t>(state.iterations(), 1));
}
BENCHMARK(BM_ProcessFrame)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MinTime(3.0);

}  // namespace
}  // namespace srslam
