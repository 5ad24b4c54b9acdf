#include <benchmark/benchmark.h>

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "srslam/interop/opencv.hpp"
#include "srslam/scene/reliability.hpp"
#include "support/flow_scene.hpp"
#include "support/random_texture.hpp"

namespace srslam {
namespace {

/// Textured frames of a scene at constant depth that moves by a few pixels a frame, back and forth.
struct FlowInput {
  FlowInput(int width_px, int num_points) {
    camera = test::flow_camera(width_px);
    if (width_px == 1280) {
      camera.height_px = 720;
      camera.cy_px = 359.5;
    }
    test::Rng rng(1);
    const cv::Mat texture =
        test::random_texture(rng, camera.width_px + 80, camera.height_px + 80, 2.0);
    for (int i = 0; i < 16; ++i) {
      const int shift = 4 * (i < 8 ? i : 16 - i);
      frames.push_back(
          texture(cv::Rect(shift, shift / 2, camera.width_px, camera.height_px)).clone());
    }
    depth_m.assign(std::size_t(camera.width_px) * std::size_t(camera.height_px), 2.0F);
    for (int i = 0; i < num_points; ++i) {
      FlowPoint point;
      point.u_px = float(rng.uniform(20.0, camera.width_px - 21.0));
      point.v_px = float(rng.uniform(20.0, camera.height_px - 21.0));
      point.depth_m = 2.0F;
      points.push_back(point);
      Feature feature;
      feature.u_px = point.u_px;
      feature.v_px = point.v_px;
      feature.response = 60.0F;
      features.push_back(feature);
    }
  }

  PinholeCamera camera;
  std::vector<cv::Mat> frames;
  std::vector<float> depth_m;
  std::vector<FlowPoint> points;
  std::vector<Feature> features;
};

LucasKanadeOptions flow_options(benchmark::State& state) {
  LucasKanadeOptions options;
  if (state.range(2) != 0) {  // as OpenCV's own defaults
    options.window_px = 21;
    options.max_iterations = 30;
    options.epsilon_px = 0.01;
    options.backward_levels = options.num_levels;
    state.SetLabel("21x21, 30 iterations");
  }
  return options;
}

/// Pyramid, flow and the way back.
void lucas_kanade(benchmark::State& state) {
  const FlowInput input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  LucasKanadeTracker tracker(flow_options(state));
  std::uint64_t id = 0;
  for (auto _ : state) {
    const cv::Mat& frame = input.frames[id % input.frames.size()];
    tracker.push(++id, as_view<std::uint8_t>(frame), input.points);
    if (id % 6 == 1) tracker.follow(id);
    benchmark::DoNotOptimize(tracker.tracks());
  }
}
BENCHMARK(lucas_kanade)
    ->ArgNames({"width", "points", "large"})
    ->Args({640, 1000, 0})
    ->Args({640, 1000, 1})
    ->Args({1280, 2000, 0})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// All of module S: corners, optical flow, metrics, residual, classification. `reduced`: judged in
/// an image of at most 320 pixels of width, as shipped, or else in the image itself.
void scene_module(benchmark::State& state) {
  const FlowInput input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  SceneFlowOptions options;
  options.corners.num_features = static_cast<int>(state.range(1));
  if (state.range(2) == 0) options.max_width_px = 0;
  SceneFlow flow(input.camera, options);
  SceneAssessor assessor(input.camera);
  SceneObservation frame;
  frame.features = input.features;
  frame.depth_m = {input.depth_m.data(), input.camera.width_px, input.camera.height_px};
  std::size_t num_tracks = 0;
  for (auto _ : state) {
    const cv::Mat& image = input.frames[frame.frame_id % input.frames.size()];
    flow.push(++frame.frame_id, as_view<std::uint8_t>(image), frame.depth_m, {});
    frame.tracks = flow.tracks();
    const SceneReport report = assessor.assess(frame);
    flow.follow(report);
    num_tracks = frame.tracks.size;
    benchmark::DoNotOptimize(report.reliability);
  }
  state.counters["tracks"] = double(num_tracks);
}
BENCHMARK(scene_module)
    ->ArgNames({"width", "points", "reduced"})
    ->Args({640, 1000, 1})
    ->Args({640, 1000, 0})
    ->Args({640, 2000, 1})
    ->Args({1280, 1000, 1})
    ->Args({1280, 2000, 1})
    ->Args({1280, 2000, 0})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace srslam
