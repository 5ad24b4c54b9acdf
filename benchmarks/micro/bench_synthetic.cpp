// Cost of a rendered frame and of its parts.

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "srslam/synthetic/synthetic_world.hpp"
#include "synthetic/detector_model.hpp"
#include "synthetic/renderer.hpp"
#include "synthetic/scenario_recipe.hpp"
#include "synthetic/sensor.hpp"

namespace srslam {
namespace {

SyntheticOptions options_for(const std::string& scenario) {
  SyntheticOptions options;
  options.scenario = scenario;
  synthetic_camera("tum_fr3", 640, 480, &options.camera);
  return options;
}

/// A scenario with its renderer and sensor; made once a benchmark.
struct Stage {
  explicit Stage(const std::string& scenario)
      : options(options_for(scenario)),
        built(detail::build_scenario(scenario, options.seed, 10.0, 2.4 / 640.0)),
        renderer(&built.scene, options.camera.camera),
        sensor(options.sensor, options.camera, 1) {}

  void render(std::size_t frame) {
    const double time_s = double(frame) / 30.0;
    renderer.render(time_s, built.camera.T_world_camera(time_s), &pixels, &workspace,
                    try_all_parts);
  }

  SyntheticOptions options;
  detail::BuiltScenario built;
  detail::Renderer renderer;
  detail::Sensor sensor;
  detail::PixelBuffers pixels;
  detail::Renderer::Workspace workspace;
  bool try_all_parts = false;
};

// Frames spread over ten seconds, so that people are near, far and out of view.
std::size_t next_frame(std::size_t frame) { return (frame + 37) % 300; }

void BM_WholeFrame(benchmark::State& state, const char* scenario) {
  SyntheticWorld world;
  if (!world.create(options_for(scenario)).ok()) {
    state.SkipWithError("the world cannot be made");
    return;
  }
  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  std::size_t index = 0;
  for (auto _ : state) {
    renderer.render(index, &frame);
    benchmark::DoNotOptimize(frame.color.pixels.data());
    index = next_frame(index);
  }
  state.counters["frames/s"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(BM_WholeFrame, static_room, "static_room")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_WholeFrame, walking_xyz, "walking_xyz")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_WholeFrame, crowd, "crowd")->Unit(benchmark::kMillisecond);

void BM_Rays(benchmark::State& state, bool try_all_parts) {
  Stage stage("crowd");
  stage.try_all_parts = try_all_parts;
  std::size_t index = 0;
  for (auto _ : state) {
    stage.render(index);
    benchmark::DoNotOptimize(stage.pixels.color.pixels.data());
    index = next_frame(index);
  }
  state.counters["parts"] = double(stage.built.scene.parts.size());
}
BENCHMARK_CAPTURE(BM_Rays, tiles, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Rays, every_part, true)->Unit(benchmark::kMillisecond)->Iterations(2);

void BM_Sensor(benchmark::State& state) {
  Stage stage("crowd");
  stage.render(100);
  ImageBuffer<Bgr8> color;
  ImageBuffer<std::uint16_t> raw_depth;
  detail::Sensor::Workspace workspace;
  std::uint64_t frame = 0;
  for (auto _ : state) {
    stage.sensor.expose(stage.pixels.color, 1.0, frame, &color);
    stage.sensor.measure_depth(stage.pixels, frame++, &raw_depth, &workspace);
    benchmark::DoNotOptimize(raw_depth.pixels.data());
  }
}
BENCHMARK(BM_Sensor)->Unit(benchmark::kMillisecond);

void BM_Detections(benchmark::State& state) {
  Stage stage("crowd");
  stage.render(100);
  std::uint64_t frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(detail::model_detections(stage.built.scene, stage.pixels, 1, frame++));
  }
}
BENCHMARK(BM_Detections)->Unit(benchmark::kMillisecond);

void BM_BuildWorld(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(detail::build_scenario("crowd", 1, 10.0, 2.4 / 640.0));
  }
}
BENCHMARK(BM_BuildWorld)->Unit(benchmark::kMillisecond)->Iterations(2);

}  // namespace
}  // namespace srslam
