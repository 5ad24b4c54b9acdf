#include "srslam/synthetic/sequence_writer.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "support/synthetic_support.hpp"

namespace srslam {
namespace {

namespace fs = std::filesystem;

class SyntheticSequence : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("srslam_sequence_") + info->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string folder(const std::string& name) const { return (folder_ / name).string(); }

  static SyntheticWorld short_world(std::uint64_t seed = 1) {
    SyntheticOptions options = test::synthetic_options("walking_xyz", seed);
    options.num_frames = 6;
    return test::synthetic_world(options);
  }

  fs::path folder_;
};

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> files(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      names.push_back(fs::relative(entry.path(), folder).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(SyntheticSequence, IsReadBackAsItWasRendered) {
  const SyntheticWorld world = short_world();
  SequenceWriterOptions options;
  options.flow = true;
  ASSERT_TRUE(write_sequence(world, folder("a"), options).ok());
  RgbdCamera camera;
  ASSERT_TRUE(read_camera_file(folder("a/camera.yaml"), &camera).ok());
  EXPECT_EQ(camera.camera.fx_px, world.options().camera.camera.fx_px);
  TumDataset dataset;
  const FileStatus opened = TumDataset::open(folder("a"), {}, &dataset);
  ASSERT_TRUE(opened.ok()) << opened.message();
  ASSERT_EQ(dataset.size(), 6U);
  Trajectory groundtruth;
  ASSERT_TRUE(read_trajectory(folder("a/groundtruth.txt"), &groundtruth).ok());
  ASSERT_EQ(groundtruth.size(), 6U);
  std::vector<FrameDetections> detections;
  ASSERT_TRUE(read_detections(folder("a/detections.txt"), &detections).ok());
  ASSERT_EQ(detections.size(), 6U);

  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  ImageBuffer<Eigen::Vector2f> flow_px;
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(renderer.render(i, &frame).ok());
    EXPECT_NEAR(groundtruth[i].timestamp_s, frame.timestamp_s, 1e-7);
    EXPECT_TRUE(groundtruth[i].T_world_camera.isApprox(frame.T_world_camera, 1e-8));
    EXPECT_EQ(detections[i].detections.size(), frame.detections.size());
    std::ostringstream stamp;
    stamp << std::fixed;
    stamp.precision(6);
    stamp << frame.timestamp_s;
    const cv::Mat color = cv::imread(folder("a/rgb/" + stamp.str() + ".png"), cv::IMREAD_COLOR);
    const cv::Mat depth =
        cv::imread(folder("a/depth/" + stamp.str() + ".png"), cv::IMREAD_UNCHANGED);
    const cv::Mat mask =
        cv::imread(folder("a/masks/" + stamp.str() + ".png"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(color.type(), CV_8UC3);
    ASSERT_EQ(depth.type(), CV_16UC1);
    ASSERT_EQ(mask.type(), CV_8UC1);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        ASSERT_EQ(color.at<cv::Vec3b>(v, u)[2], frame.color.view()(u, v).r);
        ASSERT_EQ(depth.at<std::uint16_t>(v, u), frame.raw_depth.view()(u, v));
        ASSERT_EQ(mask.at<std::uint8_t>(v, u), frame.instances.view()(u, v));
      }
    }
    const cv::Mat flow = cv::imread(folder("a/flow/" + stamp.str() + ".png"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(flow.empty(), i == 5);  // the last frame leads nowhere
    if (i == 5) continue;
    ASSERT_EQ(flow.type(), CV_16UC3);
    ASSERT_TRUE(renderer.flow_to(i + 1, &flow_px).ok());
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const auto& texel = flow.at<cv::Vec<std::uint16_t, 3>>(v, u);
        if (texel[0] == 0) continue;
        ASSERT_NEAR((texel[2] - 32768.0) / 64.0, flow_px.view()(u, v).x(), 0.008);
        ASSERT_NEAR((texel[1] - 32768.0) / 64.0, flow_px.view()(u, v).y(), 0.008);
      }
    }
  }
}

TEST_F(SyntheticSequence, SameBytesWithAnyNumberOfThreads) {
  const SyntheticWorld world = short_world(2);
  SequenceWriterOptions options;
  options.jpeg = true;
  ASSERT_TRUE(write_sequence(world, folder("one"), options).ok());
  options.num_threads = 3;
  ASSERT_TRUE(write_sequence(short_world(2), folder("three"), options).ok());
  const std::vector<std::string> names = files(folder("one"));
  EXPECT_EQ(names.size(), 6U * 3U + 6U);
  ASSERT_EQ(names, files(folder("three")));
  for (const std::string& name : names) {
    EXPECT_EQ(content(folder("one") + "/" + name), content(folder("three") + "/" + name)) << name;
  }
}

TEST_F(SyntheticSequence, TouchesNothingInAFolderThatIsNotEmpty) {
  fs::create_directories(folder("mine"));
  std::ofstream(folder("mine/notes.txt")) << "keep me";
  SequenceWriterOptions options;
  const SyntheticWorld world = short_world();
  const FileStatus status = write_sequence(world, folder("mine"), options);
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("not empty"), std::string::npos);
  EXPECT_EQ(files(folder("mine")), std::vector<std::string>{"notes.txt"});
  options.overwrite = true;
  EXPECT_TRUE(write_sequence(world, folder("mine"), options).ok());
  EXPECT_EQ(content(folder("mine/notes.txt")), "keep me");
  // What an earlier sequence left behind does not stay.
  std::ofstream(folder("mine/rgb/old.png")) << "old";
  EXPECT_TRUE(write_sequence(world, folder("mine"), options).ok());
  EXPECT_FALSE(fs::exists(folder("mine/rgb/old.png")));
}

TEST_F(SyntheticSequence, NeverOverwritesARecording) {
  fs::create_directories(folder("tum/rgb"));
  std::ofstream(folder("tum/rgb/1.png")) << "recorded";
  std::ofstream(folder("tum/rgb.txt")) << "1.0 rgb/1.png";
  SequenceWriterOptions options;
  options.overwrite = true;
  const FileStatus status = write_sequence(short_world(), folder("tum"), options);
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("scenario.json"), std::string::npos) << status.message();
  EXPECT_EQ(content(folder("tum/rgb/1.png")), "recorded");
  EXPECT_EQ(content(folder("tum/rgb.txt")), "1.0 rgb/1.png");
}

TEST_F(SyntheticSequence, StoppedHalfWayItIsNoSequence) {
  const FileStatus status = write_sequence(short_world(), folder("a"), {},
                                           [](std::size_t num_done) { return num_done < 3; });
  EXPECT_EQ(status.code, StatusCode::kNotConverged);
  EXPECT_FALSE(fs::exists(folder("a/rgb.txt")));
  TumDataset dataset;
  EXPECT_FALSE(TumDataset::open(folder("a"), {}, &dataset).ok());
  // It can be taken up again.
  SequenceWriterOptions options;
  options.overwrite = true;
  EXPECT_TRUE(write_sequence(short_world(), folder("a"), options).ok());
  EXPECT_TRUE(TumDataset::open(folder("a"), {}, &dataset).ok());
}

TEST_F(SyntheticSequence, SaysWhereItCannotWrite) {
  fs::create_directories(folder_);
  std::ofstream(folder("file")) << "x";
  const FileStatus status = write_sequence(short_world(), folder("file/inside"), {});
  EXPECT_FALSE(status.ok());
  EXPECT_NE(status.message().find("file"), std::string::npos);
}

}  // namespace
}  // namespace srslam
