#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "srslam/io/trajectory_file.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::expect_failure;
using test::TempFolder;
using test::write_text;

class TrajectoryFile : public testing::Test {
 protected:
  FileStatus read(const std::string& text) {
    write_text(path_, text);
    return read_trajectory(path_, &trajectory_);
  }

  TempFolder folder_;
  std::string path_ = folder_ / "trajectory.txt";
  Trajectory trajectory_;
  const std::string good_ = "1.5 1 2 3 0 0 0 1\n";
};

TEST_F(TrajectoryFile, ReadsPosesAsCameraToWorld) {
  // A quarter turn about z maps the camera's x axis to the world's y axis.
  const FileStatus status = read(
      "# timestamp tx ty tz qx qy qz qw\r\n"
      "\r\n"
      "  1305031102.0259\t1.25 -2 3e0 0 0 0.7071 0.7071 \r\n"
      "1305031102.0358 0 0 0 0 0 0 -1");
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(trajectory_.size(), 2U);
  EXPECT_EQ(trajectory_[0].timestamp_s, 1305031102.0259);
  const Eigen::Vector3d p = trajectory_[0].T_world_camera * Eigen::Vector3d(1.0, 0.0, 0.0);
  EXPECT_NEAR((p - Eigen::Vector3d(1.25, -1.0, 3.0)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(trajectory_[1].T_world_camera.matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-15));
}

TEST_F(TrajectoryFile, NormalisesRoundedQuaternions) {
  ASSERT_TRUE(read("1 0 0 0 0.66 0.60 -0.29 -0.34\n").ok());
  const Eigen::Matrix3d R = trajectory_[0].T_world_camera.linear();
  EXPECT_NEAR((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-14);
}

TEST_F(TrajectoryFile, RefusesBadLinesWithLineAndReason) {
  struct Case {
    std::string line;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {"2.5 1 2 3 0 0 0", "expected 8 columns `timestamp tx ty tz qx qy qz qw`, got 7"},
      {"2.5 1 2 3 0 0 0 1 9", "got 9"},
      {"2.5", "got 1"},
      {"2.5,1,2,3,0,0,0,1", "got 1"},
      {"nan 1 2 3 0 0 0 1", "time stamp 'nan' is not a finite decimal number"},
      {"x 1 2 3 0 0 0 1", "time stamp 'x'"},
      {"1548339819874260000 1 2 3 0 0 0 1", "not milliseconds or nanoseconds"},
      {"2.5 nan 2 3 0 0 0 1", "tx is 'nan', not a finite decimal number"},
      {"2.5 1 inf 3 0 0 0 1", "ty is 'inf', not a finite decimal number"},
      {"2.5 1 2 -1e10 0 0 0 1", "tz is '-1e10', beyond 1e9 m"},
      {"2.5 1 2 3 0 0 NaN 1", "qz is 'NaN', not a finite decimal number"},
      {"2.5 1 2 3 0 0 0 0", "quaternion `qx qy qz qw` has norm 0; expected a unit quaternion"},
      {"2.5 1 2 3 0 0 0 1e-200", "expected a unit quaternion"},
      {"2.5 1 2 3 1e308 1e308 1e308 1e308", "expected a unit quaternion"},
      {"2.5 1 2 3 0 0 0 1.2", "has norm 1.2; expected a unit quaternion"},
      {"1.5 1 2 3 0 0 0 1", "time stamp 1.500000 repeats the one before"},
      {"1.4 1 2 3 0 0 0 1", "time stamp 1.400000 is before the previous one, 1.500000"},
      {"2.5 1 2 3 0 0 0 \xFF", "UTF-8"},
      {"2.5 1 2 3 0 0 0 1" + std::string(5000, ' '), "longer than 4096 bytes"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.line.substr(0, 60));
    expect_failure(read("# comment\n" + good_ + "\n" + c.line + "\n" + "9 0 0 0 0 0 0 1\n"),
                   StatusCode::kCorruptData, path_, 4, c.reason_part);
    EXPECT_TRUE(trajectory_.empty());
  }
}

TEST_F(TrajectoryFile, RefusesEmptyListsMissingFilesAndFolders) {
  for (const std::string text : {"", "# only comments\n", "\n\n"}) {
    expect_failure(read(text), StatusCode::kInsufficientData, path_, 0, "no poses");
  }
  expect_failure(read_trajectory(folder_ / "absent.txt", &trajectory_), StatusCode::kNotFound,
                 folder_ / "absent.txt", 0, "does not exist");
  expect_failure(read_trajectory(folder_.path(), &trajectory_), StatusCode::kCorruptData,
                 folder_.path(), 0, "is a folder");
}

TEST_F(TrajectoryFile, RepeatedTimeStampsKeepTheLastOnRequestOnly) {
  write_text(path_, good_ + "2 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n2 3 0 0 0 0 0 1\n3 4 0 0 0 0 0 1\n");
  std::size_t num_repeated = 99;
  expect_failure(read_trajectory(path_, &trajectory_, {}, &num_repeated), StatusCode::kCorruptData,
                 path_, 3, "repeats");
  EXPECT_EQ(num_repeated, 0U);
  TrajectoryReadOptions options;
  options.keep_last_of_repeated = true;
  ASSERT_TRUE(read_trajectory(path_, &trajectory_, options, &num_repeated).ok());
  EXPECT_EQ(num_repeated, 2U);
  ASSERT_EQ(trajectory_.size(), 3U);
  EXPECT_EQ(trajectory_[1].timestamp_s, 2.0);
  EXPECT_EQ(trajectory_[1].T_world_camera.translation().x(), 3.0);
  // Decreasing ones stay refused.
  write_text(path_, good_ + "1 1 0 0 0 0 0 1\n");
  expect_failure(read_trajectory(path_, &trajectory_, options), StatusCode::kCorruptData, path_, 2,
                 "is before the previous one");
}

Trajectory random_trajectory(test::Rng* rng, std::size_t size) {
  Trajectory trajectory;
  double time_s = rng->uniform(1.0e9, 1.6e9);
  for (std::size_t i = 0; i < size; ++i) {
    StampedPose pose;
    pose.timestamp_s = time_s;
    pose.T_world_camera = rng->pose(50.0);
    trajectory.push_back(pose);
    time_s += rng->uniform(1e-3, 0.1);
  }
  return trajectory;
}

void expect_restored(const Trajectory& restored, const Trajectory& written) {
  ASSERT_EQ(restored.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    ASSERT_EQ(restored[i].timestamp_s, written[i].timestamp_s);
    const Pose& a = restored[i].T_world_camera;
    const Pose& b = written[i].T_world_camera;
    // Nine decimals: half a nanometre a coordinate, and the like for quaternions.
    ASSERT_LE((a.translation() - b.translation()).cwiseAbs().maxCoeff(), 0.5001e-9);
    ASSERT_LE((a.linear() - b.linear()).cwiseAbs().maxCoeff(), 5e-9);
  }
}

TEST_F(TrajectoryFile, WrittenPosesAreReadBackWithExactTimeStamps) {
  test::for_each_seed(30, [this](test::Rng& rng) {
    const Trajectory written = random_trajectory(&rng, 20);
    ASSERT_TRUE(write_trajectory(path_, written, "made by a test\nsecond line").ok());
    const FileStatus status = read_trajectory(path_, &trajectory_);
    ASSERT_TRUE(status.ok()) << status.message();
    expect_restored(trajectory_, written);
  });
  const std::string text = test::read_text(path_);
  EXPECT_EQ(text.substr(0, text.find('\n', text.find('\n') + 1) + 1),
            "# made by a test\n# second line\n");
}

TEST_F(TrajectoryFile, HalfTurnsSurvive) {
  Trajectory written;
  const std::vector<Eigen::Vector3d> axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                             Eigen::Vector3d::UnitZ(),
                                             Eigen::Vector3d(1.0, -1.0, 1.0).normalized()};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    StampedPose pose;
    pose.timestamp_s = static_cast<double>(i);
    pose.T_world_camera.linear() =
        Eigen::AngleAxisd(3.14159265358979323846, axes[i]).toRotationMatrix();
    written.push_back(pose);
  }
  ASSERT_TRUE(write_trajectory(path_, written, "").ok());
  ASSERT_TRUE(read_trajectory(path_, &trajectory_).ok());
  expect_restored(trajectory_, written);
}

TEST_F(TrajectoryFile, WriterFlushesEveryPoseAndMatchesTheWholeWrite) {
  test::Rng rng(20240611);
  const Trajectory written = random_trajectory(&rng, 10);
  TrajectoryWriter writer;
  ASSERT_TRUE(writer.open(path_, "comment").ok());
  for (std::size_t i = 0; i < written.size(); ++i) {
    ASSERT_TRUE(writer.append(written[i]).ok());
    EXPECT_EQ(writer.num_written(), i + 1);
    // Before close(): what a crash would leave behind.
    const FileStatus status = read_trajectory(path_, &trajectory_);
    ASSERT_TRUE(status.ok()) << status.message();
    ASSERT_EQ(trajectory_.size(), i + 1);
  }
  EXPECT_TRUE(writer.close().ok());
  EXPECT_TRUE(writer.close().ok());
  const std::string whole = folder_ / "whole.txt";
  ASSERT_TRUE(write_trajectory(whole, written, "comment").ok());
  EXPECT_EQ(test::read_text(path_), test::read_text(whole));
}

TEST_F(TrajectoryFile, WriterRefusesWhatItCouldNotReadBackAndGoesOn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  StampedPose good;
  good.timestamp_s = 10.0;
  TrajectoryWriter writer;
  expect_failure(writer.append(good), StatusCode::kInvalidArgument, "", 0, "not open");
  ASSERT_TRUE(writer.open(path_, "").ok());
  ASSERT_TRUE(writer.append(good).ok());

  std::vector<std::pair<StampedPose, std::string>> bad(9, {good, ""});
  for (auto& [pose, reason] : bad) pose.timestamp_s = 11.0;
  bad[0].first.timestamp_s = nan;
  bad[0].second = "time stamp";
  bad[1].first.timestamp_s = 10.0;
  bad[1].second = "not after";
  bad[2].first.timestamp_s = 9.0;
  bad[2].second = "not after";
  bad[3].first.timestamp_s = 1e11;
  bad[3].second = "1e10";
  bad[4].first.T_world_camera.translation().y() = nan;
  bad[4].second = "position";
  bad[5].first.T_world_camera.translation().z() = inf;
  bad[5].second = "position";
  bad[6].first.T_world_camera.linear()(1, 1) = nan;
  bad[6].second = "rotation";
  bad[7].first.T_world_camera.linear() *= 1.001;
  bad[7].second = "rotation";
  bad[8].first.T_world_camera.linear() = -Eigen::Matrix3d::Identity();
  bad[8].second = "rotation";
  for (const auto& [pose, reason] : bad) {
    SCOPED_TRACE(reason);
    expect_failure(writer.append(pose), StatusCode::kInvalidArgument, path_, 0, reason);
    const std::string whole = folder_ / "whole.txt";
    expect_failure(write_trajectory(whole, {good, pose}, ""), StatusCode::kInvalidArgument, whole,
                   0, "pose 1: ");
    EXPECT_FALSE(std::filesystem::exists(whole));
  }
  good.timestamp_s = 11.0;
  ASSERT_TRUE(writer.append(good).ok());
  EXPECT_EQ(writer.num_written(), 2U);
  ASSERT_TRUE(writer.close().ok());
  ASSERT_TRUE(read_trajectory(path_, &trajectory_).ok());
  EXPECT_EQ(trajectory_.size(), 2U);
}

TEST_F(TrajectoryFile, WriterReportsWhatTheSystemRefuses) {
  TrajectoryWriter writer;
  expect_failure(writer.open(folder_ / "absent/t.txt", ""), StatusCode::kIoError,
                 folder_ / "absent/t.txt", 0, "cannot be created");
  expect_failure(writer.open(folder_.path(), ""), StatusCode::kIoError, folder_.path(), 0,
                 "is a folder");
  // A device that is always full.
  if (std::filesystem::exists("/dev/full")) {
    ASSERT_TRUE(writer.open("/dev/full", "").ok());
    StampedPose pose;
    expect_failure(writer.append(pose), StatusCode::kIoError, "/dev/full", 0, "cannot be written");
    EXPECT_EQ(writer.num_written(), 0U);
    // The same writer serves again.
    ASSERT_TRUE(writer.open(path_, "").ok());
    EXPECT_TRUE(writer.append(pose).ok());
    EXPECT_TRUE(writer.close().ok());
  }
}

TEST_F(TrajectoryFile, AnEmptyTrajectoryCanBeWritten) {
  ASSERT_TRUE(write_trajectory(path_, {}, "nothing was tracked").ok());
  EXPECT_EQ(test::read_text(path_), "# nothing was tracked\n");
}

}  // namespace
}  // namespace srslam
