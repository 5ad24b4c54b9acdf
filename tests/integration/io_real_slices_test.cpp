// Reads real datasets from the folder that SRSLAM_DATA_DIR names; skips without it.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "srslam/io/bonn_groundtruth.hpp"
#include "srslam/io/depth_check.hpp"
#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam {
namespace {

struct SliceCase {
  std::string name;
  std::string preset;
  std::size_t num_color;
  std::size_t num_depth;
  double max_time_difference_s;
};

class RealSlice : public testing::TestWithParam<SliceCase> {
 protected:
  void SetUp() override {
    folder_ = test::real_slice(GetParam().name);
    if (folder_.empty()) GTEST_SKIP() << test::skip_reason(GetParam().name);
    ASSERT_TRUE(camera_preset(GetParam().preset, &camera_).ok());
    const FileStatus status = TumDataset::open(folder_, {}, &dataset_);
    ASSERT_TRUE(status.ok()) << status.message();
  }

  std::string folder_;
  RgbdCamera camera_;
  TumDataset dataset_;
};

TEST_P(RealSlice, EveryColourFrameHasDepth) {
  const AssociationReport& report = dataset_.association();
  EXPECT_EQ(report.num_color, GetParam().num_color);
  EXPECT_EQ(report.num_depth, GetParam().num_depth);
  EXPECT_EQ(report.num_with_depth, GetParam().num_color);
  EXPECT_LE(report.max_time_difference_s, GetParam().max_time_difference_s);
  RecordProperty("num_shared_depth", static_cast<int>(report.num_shared_depth));
  std::cout << GetParam().name << ": " << report.num_with_depth << " of " << report.num_color
            << " colour frames have depth, " << report.num_shared_depth
            << " of them share a depth image, largest difference "
            << 1e3 * report.max_time_difference_s << " ms\n";
}

TEST_P(RealSlice, EveryFrameLoadsWithPlausibleDepth) {
  FrameReader reader(dataset_, camera_, 0, dataset_.size());
  LoadedFrame frame;
  std::size_t num_loaded = 0;
  std::size_t num_plausible = 0;
  while (reader.next(&frame)) {
    ASSERT_TRUE(frame.status.ok()) << frame.status.message();
    ASSERT_EQ(frame.index, num_loaded);
    ASSERT_TRUE(frame.has_depth);
    ASSERT_TRUE(frame.gray.view().validate().ok());
    ASSERT_EQ(frame.gray.width_px, 640);
    ASSERT_EQ(frame.gray.height_px, 480);
    ASSERT_TRUE(
        std::all_of(frame.depth_m.pixels.begin(), frame.depth_m.pixels.end(), [](float depth_m) {
          return std::isfinite(depth_m) && depth_m >= 0.0F && depth_m < 14.0F;
        }));
    if (check_depth_plausible(summarize_depth(frame.depth_m.view())).ok()) ++num_plausible;
    ++num_loaded;
  }
  EXPECT_EQ(num_loaded, GetParam().num_color);
  EXPECT_EQ(num_plausible, num_loaded);
}

TEST_P(RealSlice, DetectionsBelongToColourFrames) {
  std::vector<FrameDetections> frames;
  const FileStatus status = read_detections(dataset_.detections_file(), &frames);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(frames.size(), dataset_.size());
  for (std::size_t i = 0; i < dataset_.size(); ++i) {
    EXPECT_LT(find_detections(frames, dataset_.entry(i).timestamp_s, 1e-4), frames.size()) << i;
  }
}

TEST_P(RealSlice, GroundTruthSurvivesWritingToItsPrintedDigits) {
  Trajectory groundtruth;
  FileStatus status = read_trajectory(dataset_.groundtruth_file(), &groundtruth);
  ASSERT_TRUE(status.ok()) << status.message();
  test::TempFolder folder;
  ASSERT_TRUE(write_trajectory(folder / "copy.txt", groundtruth, "copy").ok());
  Trajectory copy;
  status = read_trajectory(folder / "copy.txt", &copy);
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(copy.size(), groundtruth.size());
  for (std::size_t i = 0; i < copy.size(); ++i) {
    EXPECT_EQ(copy[i].timestamp_s, groundtruth[i].timestamp_s);
    const Pose difference = groundtruth[i].T_world_camera.inverse() * copy[i].T_world_camera;
    EXPECT_LT((difference.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Slices, RealSlice,
                         testing::Values(SliceCase{"fr1_xyz_a", "tum_fr1", 400, 401, 0.0172},
                                         SliceCase{"bonn_crowd_a", "bonn", 480, 481, 0.02}),
                         [](const testing::TestParamInfo<SliceCase>& slice) {
                           return slice.param.name;
                         });

TEST(BonnGroundtruthFile, ConversionAgreesWithThePublishedTransformsToThePrintedDigits) {
  const std::string folder = test::real_slice("bonn_crowd_a");
  if (folder.empty()) GTEST_SKIP() << test::skip_reason("bonn_crowd_a");
  Trajectory recorded;
  Trajectory expected;
  FileStatus status = read_trajectory(folder + "/groundtruth.txt", &recorded);
  ASSERT_TRUE(status.ok()) << status.message();
  status = read_trajectory(folder + "/groundtruth_camera.txt", &expected);
  ASSERT_TRUE(status.ok()) << status.message();
  const Trajectory converted = camera_trajectory_from_bonn_marker(recorded);
  ASSERT_EQ(converted.size(), expected.size());
  // Both are rounded to six decimals in the file.
  constexpr double kHalfDigit = 0.5e-6;
  double largest_position_m = 0.0;
  double largest_quaternion = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(converted[i].timestamp_s, expected[i].timestamp_s);
    const Pose& a = converted[i].T_world_camera;
    const Pose& b = expected[i].T_world_camera;
    largest_position_m =
        std::max(largest_position_m, (a.translation() - b.translation()).cwiseAbs().maxCoeff());
    const Eigen::Quaterniond q_a(Eigen::Matrix3d(a.linear()));
    Eigen::Quaterniond q_b(Eigen::Matrix3d(b.linear()));
    if (q_a.dot(q_b) < 0.0) q_b.coeffs() *= -1.0;
    largest_quaternion =
        std::max(largest_quaternion, (q_a.coeffs() - q_b.coeffs()).cwiseAbs().maxCoeff());
  }
  std::cout << "largest difference: " << largest_position_m << " m, " << largest_quaternion
            << " in a quaternion coefficient, over " << expected.size() << " poses\n";
  EXPECT_LE(largest_position_m, 1.01 * kHalfDigit);
  // Reading normalises the rounded quaternion, which moves it by as much again.
  EXPECT_LE(largest_quaternion, 2.0 * kHalfDigit);
}

TEST(RealTrajectories, EveryPublishedFileIsRead) {
  const std::string folder = test::real_slice("trajectories");
  if (folder.empty()) GTEST_SKIP() << test::skip_reason("trajectories");
  std::size_t num_files = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".txt") continue;
    ++num_files;
    const std::string path = file.path().string();
    Trajectory trajectory;
    std::size_t num_repeated = 0;
    TrajectoryReadOptions options;
    options.keep_last_of_repeated = true;
    const FileStatus status = read_trajectory(path, &trajectory, options, &num_repeated);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_GT(trajectory.size(), 500U) << path;
    // One time stamp of one file stands twice; refused unless asked for.
    const bool has_repeated = file.path().filename() == "fr2_desk_groundtruth.txt";
    EXPECT_EQ(num_repeated, has_repeated ? 1U : 0U) << path;
    EXPECT_EQ(read_trajectory(path, &trajectory).ok(), !has_repeated) << path;
  }
  EXPECT_EQ(num_files, 6U);
}

}  // namespace
}  // namespace srslam
