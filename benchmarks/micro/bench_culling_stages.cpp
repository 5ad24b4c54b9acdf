// The two stages of Algorithm 1 on a frame of a camera that moves through a room in which a person
// walks, and the simpler ways to choose what to remove.

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "srslam/culling/dynamic_culling.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/culling/removal_baselines.hpp"
#include "support/flow_scene.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

/// Tracks of 1000 features, a fifth of them on movers, half of those in boxes.
test::FlowScene room_with_movers() {
  test::FlowScene scene;
  scene.num_tracks = 1000;
  scene.mover_share = 0.2;
  scene.detected_share = 0.5;
  scene.noise_px = 0.5;
  scene.depth_noise = 1.0;
  scene.T_mover = test::flow_pose(-0.08, 0.05, 0.02, 0.0, 0.0, 0.05);
  return scene;
}

std::vector<Detection> boxes_of_people() {
  std::vector<Detection> boxes(2);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    boxes[i].class_name = "person";
    boxes[i].score = 0.8;
    boxes[i].x_min_px = 60.0 + 300.0 * double(i);
    boxes[i].x_max_px = 130.0 + 300.0 * double(i);
    boxes[i].y_min_px = 80.0;
    boxes[i].y_max_px = 460.0;
  }
  return boxes;
}

/// Stage 1 without the optical flow: camera motion, flow test, epipolar test, neighbourhoods.
void find_regions(benchmark::State& state, EpipolarSource source, SceneClass scene_class,
                  bool distorted) {
  test::FlowScene scene = room_with_movers();
  if (distorted) {
    scene.camera.k1 = 0.04;
    scene.camera.k2 = -0.1;
  }
  const std::vector<FlowTrack> tracks = scene.tracks();
  const std::vector<Detection> boxes = boxes_of_people();
  DynamicRegionInput input;
  input.tracks = tracks;
  input.detections = boxes;
  input.scene_class = scene_class;
  DynamicRegionOptions options;
  options.epipolar_source = source;
  DynamicRegionWorkspace workspace;
  std::vector<FeatureSuspicion> features(tracks.size());
  DynamicRegionsResult result;
  for (auto _ : state) {
    result = find_dynamic_regions(input, scene.camera, options, workspace, features);
    benchmark::DoNotOptimize(features.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.SetLabel(std::string("epipolar test: ") + to_string(result.epipolar));
  state.counters["anomalies"] = result.num_anomalies;
  state.counters["samples"] = result.fundamental.num_samples;
}
BENCHMARK_CAPTURE(find_regions, bad, EpipolarSource::kCameraMotion, SceneClass::kBad, false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(find_regions, camera_motion, EpipolarSource::kCameraMotion, SceneClass::kGood,
                  false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(find_regions, camera_motion_distorted, EpipolarSource::kCameraMotion,
                  SceneClass::kGood, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(find_regions, eight_point, EpipolarSource::kEightPoint, SceneClass::kGood, false)
    ->Unit(benchmark::kMicrosecond);

/// 1000 features, of which so many are potential, in the box of a person with the room behind, and
/// of those so many anomalous, on limbs that move.
struct SuspectedPerson {
  SuspectedPerson(int num_potential, int num_anomalous) {
    struct Limb {
      double u_px, v_px, depth_m;
    };
    constexpr Limb kLimbs[] = {{270.0, 200.0, 1.9}, {390.0, 180.0, 1.6}, {330.0, 400.0, 1.8}};
    test::Rng rng(7);
    for (int i = 0; i < 1000; ++i) {
      FeatureSuspicion feature;
      FlowPoint point;
      if (i < num_anomalous) {
        const Limb& limb = kLimbs[i % 3];
        const bool strays = i % 10 == 9;  // mistracked, anywhere in the box
        point.u_px = float(strays ? rng.uniform(230.0, 430.0) : limb.u_px + 14.0 * rng.normal());
        point.v_px = float(strays ? rng.uniform(60.0, 470.0) : limb.v_px + 20.0 * rng.normal());
        point.depth_m = float(strays ? rng.uniform(2.5, 4.0) : limb.depth_m + 0.04 * rng.normal());
        feature.anomalies = kFlowAnomaly;
        feature.in_object = true;
      } else if (i < num_potential) {
        const bool is_person = i % 3 != 0;
        point.u_px = float(is_person ? 330.0 + 40.0 * rng.normal() : rng.uniform(230.0, 430.0));
        point.v_px = float(rng.uniform(60.0, 470.0));
        point.depth_m = float(is_person ? 1.75 + 0.08 * rng.normal() : rng.uniform(2.5, 4.0));
        feature.in_object = true;
      } else {
        point.u_px = float(rng.uniform(0.0, 640.0));
        point.v_px = float(rng.uniform(0.0, 480.0));
        point.depth_m = float(rng.uniform(2.0, 4.5));
      }
      if (rng.uniform(0.0, 1.0) < 0.1) point.depth_m = 0.0F;
      points.push_back(point);
      features.push_back(feature);
    }
    Detection box;
    box.class_name = "person";
    box.score = 0.8;
    box.x_min_px = 230.0;
    box.x_max_px = 430.0;
    box.y_min_px = 60.0;
    box.y_max_px = 470.0;
    boxes.push_back(box);
  }

  std::vector<FlowPoint> points;
  std::vector<FeatureSuspicion> features;
  std::vector<Detection> boxes;
};

/// Stage 2: quartiles, groups, parameters, clusters, neighbours of core points, verdicts.
void cull(benchmark::State& state, ClusteredFeatures clustered, double residual_px) {
  const SuspectedPerson input(int(state.range(1)), int(state.range(0)));
  const PinholeCamera camera = test::flow_camera();
  DynamicCullingOptions options;
  options.clustered = clustered;
  CullingFrame frame;
  frame.reliability = {0.4, 1.0};
  frame.residual_px = residual_px;
  DynamicCullingWorkspace workspace;
  std::vector<CullingVerdict> verdicts(input.points.size());
  DynamicCullingResult result;
  for (auto _ : state) {
    result = cull_dynamic_features(input.points, input.features, camera, frame, options, workspace,
                                   verdicts);
    benchmark::DoNotOptimize(verdicts.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.SetLabel(to_string(result.branch));
  state.counters["removed"] = result.num_removed;
  state.counters["clusters"] = result.clusters.num_clusters;
  state.counters["comparisons"] = double(result.clusters.num_comparisons);
}
BENCHMARK_CAPTURE(cull, anomalies, ClusteredFeatures::kAnomalies, 1.0)
    ->ArgNames({"anomalous", "potential"})
    ->ArgsProduct({{30, 60, 120}, {300, 500}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(cull, potential, ClusteredFeatures::kPotential, 1.0)
    ->ArgNames({"anomalous", "potential"})
    ->ArgsProduct({{120}, {300, 500}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(cull, aggressive, ClusteredFeatures::kAnomalies, 20.0)
    ->ArgNames({"anomalous", "potential"})
    ->Args({120, 500})
    ->Unit(benchmark::kMicrosecond);

void remove_by(benchmark::State& state, RemovalBaseline baseline) {
  const SuspectedPerson input(int(state.range(1)), int(state.range(0)));
  const PinholeCamera camera = test::flow_camera();
  RemovalBaselineWorkspace workspace;
  std::vector<std::uint8_t> removed(input.points.size());
  RemovalBaselineResult result;
  for (auto _ : state) {
    result = remove_by_baseline(baseline, input.points, input.features, input.boxes, camera, {},
                                workspace, removed);
    benchmark::DoNotOptimize(removed.data());
  }
  if (!result.status.ok()) state.SkipWithError(result.status.reason);
  state.counters["removed"] = result.num_removed;
}
BENCHMARK_CAPTURE(remove_by, proportion, RemovalBaseline::kProportion)
    ->ArgNames({"anomalous", "potential"})
    ->Args({120, 500})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(remove_by, k_means, RemovalBaseline::kKMeans)
    ->ArgNames({"anomalous", "potential"})
    ->Args({120, 500})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(remove_by, convex_hull, RemovalBaseline::kConvexHull)
    ->ArgNames({"anomalous", "potential"})
    ->Args({120, 500})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(remove_by, dbscan, RemovalBaseline::kDbscan)
    ->ArgNames({"anomalous", "potential"})
    ->Args({120, 500})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace srslam
