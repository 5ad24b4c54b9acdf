// Random damage to valid datasets: reading them never crashes or hangs, every refusal says why and
// names a file that the damage explains, and what is accepted is whole.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "fuzz/dataset_corruption.hpp"
#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam {
namespace {

constexpr int kNumFrames = 10;
constexpr std::uint64_t kNumSeeds = 400;

/// What one damaged dataset gave.
struct Tally {
  int num_lists_refused = 0;
  int num_frames_refused = 0;
  int num_frames_accepted = 0;
  int num_companions_refused = 0;
};

class CorruptedDataset {
 public:
  CorruptedDataset(std::string folder, const std::vector<test::Damage>& damages)
      : folder_(std::move(folder)) {
    for (const test::Damage& damage : damages) damaged_.insert(damage.file);
  }

  void read_everything(Tally* tally) {
    RgbdCamera camera = test::tiny_camera();
    const FileStatus camera_status = read_camera_file(path("camera.yaml"), &camera);
    check_companion(camera_status, "camera.yaml", tally);

    Trajectory trajectory;
    check_companion(read_trajectory(path("groundtruth.txt"), &trajectory), "groundtruth.txt",
                    tally);
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      EXPECT_TRUE(trajectory[i].T_world_camera.matrix().allFinite());
      if (i > 0) {
        EXPECT_GT(trajectory[i].timestamp_s, trajectory[i - 1].timestamp_s);
      }
    }

    std::vector<FrameDetections> detections;
    check_companion(read_detections(path("detections.txt"), &detections), "detections.txt", tally);
    for (const FrameDetections& frame : detections) check_detections(frame);

    TumDataset dataset;
    TumDatasetOptions options;
    options.color_mode = ColorMode::kGrayAndColor;
    const FileStatus status = TumDataset::open(folder_, options, &dataset);
    if (!status.ok()) {
      check_refusal(status);
      EXPECT_TRUE(is_damaged(status.file)) << status.message();
      EXPECT_TRUE(status.file == path("rgb.txt") || status.file == path("depth.txt"))
          << status.message();
      EXPECT_EQ(dataset.size(), 0U);
      ++tally->num_lists_refused;
      return;
    }
    FrameReader reader(dataset, camera, 0, dataset.size(), 2);
    LoadedFrame frame;
    std::size_t num_frames = 0;
    while (reader.next(&frame)) {
      check_frame(frame, camera, tally);
      ++num_frames;
    }
    EXPECT_EQ(num_frames, dataset.size());
  }

 private:
  std::string path(const std::string& file) const { return folder_ + "/" + file; }
  bool is_damaged(const std::string& full_path) const {
    return std::any_of(damaged_.begin(), damaged_.end(),
                       [&](const std::string& file) { return full_path == path(file); });
  }
  bool is_file_damaged(const std::string& file) const { return damaged_.count(file) > 0; }

  static void check_refusal(const FileStatus& status) {
    EXPECT_NE(status.code, StatusCode::kNotRun);
    EXPECT_GE(status.reason.size(), 10U) << status.message();
    EXPECT_FALSE(status.file.empty()) << status.message();
  }

  void check_companion(const FileStatus& status, const std::string& file, Tally* tally) const {
    if (status.ok()) return;
    check_refusal(status);
    EXPECT_EQ(status.file, path(file)) << status.message();
    EXPECT_TRUE(is_file_damaged(file)) << status.message();
    ++tally->num_companions_refused;
  }

  static void check_detections(const FrameDetections& frame) {
    EXPECT_TRUE(std::isfinite(frame.timestamp_s));
    for (const Detection& detection : frame.detections) {
      EXPECT_FALSE(detection.class_name.empty());
      EXPECT_TRUE(detection.score >= 0.0 && detection.score <= 1.0);
      EXPECT_LT(detection.x_min_px, detection.x_max_px);
      EXPECT_LT(detection.y_min_px, detection.y_max_px);
      EXPECT_LE(std::max(std::abs(detection.x_min_px), std::abs(detection.x_max_px)), 1e6);
      EXPECT_LE(std::max(std::abs(detection.y_min_px), std::abs(detection.y_max_px)), 1e6);
    }
  }

  void check_frame(const LoadedFrame& frame, const RgbdCamera& camera, Tally* tally) const {
    EXPECT_TRUE(std::isfinite(frame.timestamp_s));
    if (!frame.status.ok()) {
      check_refusal(frame.status);
      // A list may lead to a wrong file, and a camera file may state a wrong size.
      EXPECT_TRUE(is_damaged(frame.status.file) || is_file_damaged("rgb.txt") ||
                  is_file_damaged("depth.txt") || is_file_damaged("camera.yaml"))
          << frame.status.message();
      EXPECT_TRUE(frame.gray.empty());
      EXPECT_TRUE(frame.color.empty());
      EXPECT_TRUE(frame.depth_m.empty());
      ++tally->num_frames_refused;
      return;
    }
    ++tally->num_frames_accepted;
    const auto num_pixels = static_cast<std::size_t>(camera.camera.width_px) *
                            static_cast<std::size_t>(camera.camera.height_px);
    EXPECT_EQ(frame.gray.pixels.size(), num_pixels);
    EXPECT_EQ(frame.color.pixels.size(), num_pixels);
    EXPECT_EQ(frame.depth_m.pixels.size(), frame.has_depth ? num_pixels : 0U);
    EXPECT_EQ(frame.gray.width_px, camera.camera.width_px);
    EXPECT_TRUE(std::all_of(frame.depth_m.pixels.begin(), frame.depth_m.pixels.end(),
                            [](float depth_m) { return std::isfinite(depth_m) && depth_m >= 0; }));
  }

  std::string folder_;
  std::set<std::string> damaged_;
};

class IoCorruption : public testing::TestWithParam<const char*> {};

TEST_P(IoCorruption, NeverCrashesAndAlwaysSaysWhy) {
  const test::TempFolder work;
  const std::string valid = work / "valid";
  test::write_tiny_dataset(valid, kNumFrames, GetParam());
  Tally intact;
  CorruptedDataset(valid, {}).read_everything(&intact);
  ASSERT_EQ(intact.num_frames_accepted, kNumFrames);
  ASSERT_EQ(intact.num_frames_refused + intact.num_lists_refused + intact.num_companions_refused,
            0);

  Tally tally;
  int num_seeds_refused = 0;
  double slowest_s = 0.0;
  for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
    const std::string copy = work / ("copy" + std::to_string(seed));
    std::filesystem::copy(valid, copy, std::filesystem::copy_options::recursive);
    test::DatasetCorrupter corrupter(copy, seed);
    const std::vector<test::Damage> damages = corrupter.corrupt();
    std::string trace = "seed " + std::to_string(seed);
    for (const test::Damage& damage : damages) trace += "; " + damage.file + ": " + damage.what;
    SCOPED_TRACE(trace);
    const Tally before = tally;
    const auto start = std::chrono::steady_clock::now();
    CorruptedDataset(copy, damages).read_everything(&tally);
    slowest_s = std::max(
        slowest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (tally.num_lists_refused + tally.num_frames_refused + tally.num_companions_refused >
        before.num_lists_refused + before.num_frames_refused + before.num_companions_refused) {
      ++num_seeds_refused;
    }
    std::filesystem::remove_all(copy);
  }
  std::cout << kNumSeeds << " damaged datasets: " << num_seeds_refused
            << " gave at least one reason; " << tally.num_lists_refused << " lists, "
            << tally.num_companions_refused << " other text files and " << tally.num_frames_refused
            << " frames refused, " << tally.num_frames_accepted << " frames accepted; slowest "
            << slowest_s << " s\n";
  // The damage must bite in each way for the test to mean anything.
  EXPECT_GT(num_seeds_refused, static_cast<int>(kNumSeeds) / 2);
  EXPECT_GT(tally.num_lists_refused, static_cast<int>(kNumSeeds) / 10);
  EXPECT_GT(tally.num_companions_refused, static_cast<int>(kNumSeeds) / 10);
  EXPECT_GT(tally.num_frames_refused, static_cast<int>(kNumSeeds) / 10);
  EXPECT_LT(slowest_s, 30.0);
}

INSTANTIATE_TEST_SUITE_P(ColourFormat, IoCorruption, testing::Values("png", "jpg"),
                         [](const testing::TestParamInfo<const char*>& format) {
                           return std::string(format.param);
                         });

TEST(DatasetCorrupter, DoesTheSameForTheSameSeed) {
  const test::TempFolder work;
  const std::string valid = work / "valid";
  test::write_tiny_dataset(valid, 3);
  std::set<std::string> distinct;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<std::string> done;
    for (const char* name : {"a", "b"}) {
      const std::string copy = work / name;
      std::filesystem::copy(valid, copy, std::filesystem::copy_options::recursive);
      std::string text;
      for (const test::Damage& damage : test::DatasetCorrupter(copy, seed).corrupt()) {
        text += damage.file + ": " + damage.what + "\n";
        const std::filesystem::path file = std::filesystem::path(copy) / damage.file;
        if (std::filesystem::is_regular_file(file)) text += test::read_text(file.string());
      }
      done.push_back(text);
      std::filesystem::remove_all(copy);
    }
    EXPECT_EQ(done[0], done[1]) << "seed " << seed;
    distinct.insert(done[0]);
  }
  EXPECT_GT(distinct.size(), 15U);  // two seeds may remove the same file
}

}  // namespace
}  // namespace srslam
