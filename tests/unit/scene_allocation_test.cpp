#include <gtest/gtest.h>

#include <vector>

#include "srslam/scene/reliability.hpp"
#include "support/allocation_counter.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

TEST(SceneAllocation, AssessingAStreamAllocatesOnlyAtItsStart) {
  test::FlowScene scene;
  scene.mover_share = 0.3;
  const std::vector<FlowTrack> tracks = scene.tracks();
  std::vector<Feature> features(1000);
  for (std::size_t i = 0; i < features.size(); ++i) {
    features[i].u_px = float(i % 640);
    features[i].v_px = float(i % 480);
    features[i].response = 50.0F;
  }
  const std::vector<float> depth_m(std::size_t{640} * 480, 2.0F);
  SceneAssessor assessor(scene.camera);
  SceneObservation frame;
  frame.features = features;
  frame.depth_m = {depth_m.data(), 640, 480};
  frame.tracks = tracks;
  const auto assess_frames = [&](int count) {
    for (int i = 0; i < count; ++i) {
      ++frame.frame_id;
      const SceneReport report = assessor.assess(frame);
      ASSERT_TRUE(report.status.ok());
    }
  };
  EXPECT_GT(test::count_allocations([&] { assess_frames(10); }), 0U);
  EXPECT_EQ(test::count_allocations([&] { assess_frames(50); }), 0U);
}

}  // namespace
}  // namespace srslam
