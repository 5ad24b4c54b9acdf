// Runs the baseline on real images from the folder that SRSLAM_DATA_DIR names; skips without it.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>

#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam {
namespace {

struct SliceCase {
  std::string name;
  std::string preset;
  double max_ate_m;
};

class PipelineOnRealSlice : public testing::TestWithParam<SliceCase> {};

TEST_P(PipelineOnRealSlice, TracksEveryFrame) {
  const SliceCase& slice = GetParam();
  const std::string folder = test::real_slice(slice.name);
  if (folder.empty()) GTEST_SKIP() << test::skip_reason(slice.name);
  TumDataset dataset;
  RgbdCamera camera;
  FileStatus status = TumDataset::open(folder, {}, &dataset);
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_TRUE(camera_preset(slice.preset, &camera).ok());
  ReferencePipeline pipeline(camera.camera);
  ASSERT_TRUE(pipeline.status().ok());
  FrameReader reader(dataset, camera, 0, 120);
  LoadedFrame frame;
  Trajectory live;
  std::size_t num_frames = 0;
  while (reader.next(&frame)) {
    ASSERT_TRUE(frame.status.ok()) << frame.status.message();
    PipelineFrame input;
    input.timestamp_s = frame.timestamp_s;
    input.gray = frame.gray.view();
    input.depth_m = frame.depth_m.view();
    const PipelineResult result = pipeline.process(input);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_STREQ(to_string(result.state), "TRACKED") << "frame " << num_frames;
    EXPECT_FALSE(result.relocalized) << "frame " << num_frames;
    EXPECT_TRUE(result.T_world_camera.matrix().allFinite());
    live.push_back({frame.timestamp_s, result.T_world_camera});
    ++num_frames;
  }
  EXPECT_EQ(num_frames, 120U);
  pipeline.finish();
  Trajectory groundtruth;
  status = read_trajectory(dataset.groundtruth_file(), &groundtruth);
  ASSERT_TRUE(status.ok()) << status.message();
  for (const bool causal : {true, false}) {
    const AteResult ate =
        absolute_trajectory_error(groundtruth, causal ? live : pipeline.optimized_trajectory());
    ASSERT_TRUE(ate.status.ok()) << ate.status.reason;
    EXPECT_EQ(ate.num_estimate, 120U);
    EXPECT_LT(ate.translation_m.rmse, slice.max_ate_m);
    std::cout << slice.name << ", frames 0..119, " << (causal ? "live" : "optimized")
              << " trajectory: ATE rmse " << ate.translation_m.rmse << " m over " << ate.num_matched
              << " matches, " << pipeline.keyframes().size() << " keyframes\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Slices, PipelineOnRealSlice,
                         testing::Values(SliceCase{"fr1_xyz_a", "tum_fr1", 0.015},
                                         SliceCase{"bonn_crowd_a", "bonn", 0.018}),
                         [](const testing::TestParamInfo<SliceCase>& slice) {
                           return slice.param.name;
                         });

}  // namespace
}  // namespace srslam
