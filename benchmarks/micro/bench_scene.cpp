#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/scene/reliability.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

/// Everything of one frame that the assessor reads: depth with structure, noise and holes,
/// features, boxes and tracks.
struct SceneInput {
  SceneInput(int width_px, int num_features) {
    scene.camera = test::flow_camera(width_px);
    scene.camera.height_px = width_px == 1280 ? 720 : scene.camera.height_px;
    scene.camera.cy_px = 0.5 * (scene.camera.height_px - 1);
    scene.num_tracks = num_features;
    scene.mover_share = 0.25;
    tracks = scene.tracks();
    test::Rng rng(5);
    const auto num_pixels =
        std::size_t(scene.camera.width_px) * std::size_t(scene.camera.height_px);
    depth_m.resize(num_pixels);
    raw_depth.resize(num_pixels);
    for (std::size_t i = 0; i < num_pixels; ++i) {
      const double u = double(i % std::size_t(scene.camera.width_px));
      depth_m[i] = rng.uniform(0.0, 1.0) < 0.1
                       ? 0.0F
                       : float(1.0 + 2.0 * u / width_px + rng.uniform(0.0, 0.01));
      raw_depth[i] = static_cast<std::uint16_t>(5000.0F * depth_m[i]);
    }
    for (const FlowTrack& track : tracks) {
      Feature feature;
      feature.u_px = track.current.u_px;
      feature.v_px = track.current.v_px;
      feature.response = float(rng.uniform(7.0, 120.0));
      features.push_back(feature);
    }
    for (int i = 0; i < 5; ++i) {
      Detection box;
      box.class_name = "person";
      box.score = 0.6;
      box.x_min_px = 20.0 * i;
      box.x_max_px = 20.0 * i + 150.0;
      box.y_min_px = 60.0;
      box.y_max_px = 400.0;
      detections.push_back(box);
    }
  }

  ImageView<const float> depth_view() const {
    return {depth_m.data(), scene.camera.width_px, scene.camera.height_px};
  }

  test::FlowScene scene;
  std::vector<FlowTrack> tracks;
  std::vector<float> depth_m;
  std::vector<std::uint16_t> raw_depth;
  std::vector<Feature> features;
  std::vector<Detection> detections;
};

void detection_metrics(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), 1000);
  for (auto _ : state) {
    benchmark::DoNotOptimize(detection_confidence(input.detections));
    benchmark::DoNotOptimize(
        spatial_distribution(input.detections, input.scene.camera.width_px, 480));
  }
}
BENCHMARK(detection_metrics)->ArgNames({"width"})->Arg(640);

void feature_metric(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        feature_quality(input.features, input.scene.camera.width_px, input.scene.camera.height_px));
  }
}
BENCHMARK(feature_metric)->ArgNames({"width", "features"})->Args({640, 1000})->Args({1280, 2000});

void depth_metric(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), 10);
  DepthQualityOptions options;
  options.row_step = static_cast<int>(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(depth_quality(input.depth_view(), options));
}
BENCHMARK(depth_metric)
    ->ArgNames({"width", "row_step"})
    ->Args({640, 4})
    ->Args({640, 1})
    ->Args({1280, 4})
    ->Unit(benchmark::kMicrosecond);

void depth_metric_raw(benchmark::State& state) {
  const SceneInput input(640, 10);
  const ImageView<const std::uint16_t> view(input.raw_depth.data(), 640, 480);
  for (auto _ : state) benchmark::DoNotOptimize(depth_quality(view, 5000.0));
}
BENCHMARK(depth_metric_raw)->Unit(benchmark::kMicrosecond);

void four_metrics(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const int width_px = input.scene.camera.width_px;
  const int height_px = input.scene.camera.height_px;
  for (auto _ : state) {
    const SceneMetrics metrics{detection_confidence(input.detections).metric,
                               spatial_distribution(input.detections, width_px, height_px).metric,
                               feature_quality(input.features, width_px, height_px).metric,
                               depth_quality(input.depth_view()).metric};
    benchmark::DoNotOptimize(current_reliability(metrics));
  }
}
BENCHMARK(four_metrics)
    ->ArgNames({"width", "features"})
    ->Args({640, 1000})
    ->Args({1280, 2000})
    ->Unit(benchmark::kMicrosecond);

/// What covers the view, with the camera moving.
void background_depth(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), 1000);
  const BackgroundDepth background(input.scene.camera);
  BackgroundDepth::State memory;
  const Pose T_current_previous = test::flow_pose(0.01, 0.0, 0.005, 0.0, 0.004, 0.0);
  const ImageView<const float> depth_m = input.depth_view();
  for (auto _ : state) {
    benchmark::DoNotOptimize(background.update(depth_m, &T_current_previous, &memory));
  }
}
BENCHMARK(background_depth)
    ->ArgNames({"width"})
    ->Arg(640)
    ->Arg(1280)
    ->Unit(benchmark::kMicrosecond);

void residual(benchmark::State& state) {
  const SceneInput input(640, static_cast<int>(state.range(1)));
  MotionResidualOptions options;
  options.compensation = static_cast<MotionCompensation>(state.range(0));
  DominantMotionWorkspace workspace;
  for (auto _ : state) {
    benchmark::DoNotOptimize(motion_residual(
        input.tracks, input.scene.camera, &input.scene.T_current_reference, options, &workspace));
  }
  state.SetLabel(to_string(options.compensation));
}
BENCHMARK(residual)
    ->ArgNames({"compensation", "tracks"})
    ->ArgsProduct({{0, 1, 2}, {1000, 2000}})
    ->Unit(benchmark::kMicrosecond);

/// All but the optical flow.
void assessor(benchmark::State& state) {
  const SceneInput input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  SceneAssessor assessor(input.scene.camera);
  SceneObservation frame;
  frame.detections = input.detections;
  frame.has_detections = true;
  frame.features = input.features;
  frame.depth_m = input.depth_view();
  frame.tracks = input.tracks;
  for (auto _ : state) {
    ++frame.frame_id;
    benchmark::DoNotOptimize(assessor.assess(frame));
  }
}
BENCHMARK(assessor)
    ->ArgNames({"width", "features"})
    ->ArgsProduct({{640, 1280}, {1000, 2000}})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace srslam
