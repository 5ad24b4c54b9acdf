#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "io/image_container.hpp"
#include "srslam/io/tum_dataset.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::expect_failure;
using test::kTinyHeight_px;
using test::kTinyWidth_px;
using test::TempFolder;
using test::tiny_camera;
using test::tiny_color_file;
using test::tiny_depth_file;
using test::write_image;
using test::write_text;

void expect_same_gray(const LoadedFrame& frame, const cv::Mat& expected) {
  ASSERT_EQ(frame.gray.width_px, expected.cols);
  ASSERT_EQ(frame.gray.height_px, expected.rows);
  for (int v = 0; v < expected.rows; ++v) {
    for (int u = 0; u < expected.cols; ++u) {
      ASSERT_EQ(frame.gray.view()(u, v), expected.at<std::uint8_t>(v, u)) << u << " " << v;
    }
  }
}

void expect_no_images(const LoadedFrame& frame) {
  EXPECT_FALSE(frame.has_depth);
  EXPECT_TRUE(frame.gray.empty());
  EXPECT_TRUE(frame.color.empty());
  EXPECT_TRUE(frame.depth_m.empty());
  EXPECT_EQ(frame.gray.width_px, 0);
  EXPECT_EQ(frame.depth_m.width_px, 0);
}

void expect_tiny_depth(const LoadedFrame& frame, int index) {
  ASSERT_TRUE(frame.has_depth);
  ASSERT_EQ(frame.depth_m.width_px, kTinyWidth_px);
  ASSERT_EQ(frame.depth_m.height_px, kTinyHeight_px);
  for (int v = 0; v < kTinyHeight_px; ++v) {
    for (int u = 0; u < kTinyWidth_px; ++u) {
      const double expected_m = test::tiny_raw_depth(index, u, v) / 5000.0;
      ASSERT_EQ(frame.depth_m.view()(u, v), static_cast<float>(expected_m)) << u << " " << v;
    }
  }
}

class TumDatasetTest : public testing::Test {
 protected:
  FileStatus open() { return TumDataset::open(folder_.path(), options_, &dataset_); }

  /// Opens a dataset of `num_frames` frames.
  void make(int num_frames, const std::string& extension = "png") {
    test::write_tiny_dataset(folder_.path(), num_frames, extension);
    const FileStatus status = open();
    ASSERT_TRUE(status.ok()) << status.message();
    ASSERT_EQ(dataset_.size(), static_cast<std::size_t>(num_frames));
  }

  TempFolder folder_;
  TumDatasetOptions options_;
  TumDataset dataset_;
  LoadedFrame frame_;
};

TEST_F(TumDatasetTest, OpensAndAssociates) {
  make(5);
  EXPECT_EQ(dataset_.folder(), folder_.path());
  const AssociationReport& report = dataset_.association();
  EXPECT_EQ(report.num_color, 5U);
  EXPECT_EQ(report.num_depth, 5U);
  EXPECT_EQ(report.num_with_depth, 5U);
  EXPECT_EQ(report.num_shared_depth, 0U);
  EXPECT_NEAR(report.max_time_difference_s, 0.004, 1e-9);
  EXPECT_EQ(dataset_.entry(2).timestamp_s, 1000.06);
  EXPECT_EQ(dataset_.entry(2).depth_timestamp_s, 1000.064);
  EXPECT_EQ(dataset_.entry(2).color_file, tiny_color_file(2));
  EXPECT_EQ(dataset_.entry(2).depth_file, tiny_depth_file(2));
  EXPECT_EQ(dataset_.groundtruth_file(), folder_ / "groundtruth.txt");
  EXPECT_EQ(dataset_.detections_file(), folder_ / "detections.txt");
  EXPECT_EQ(dataset_.camera_file(), folder_ / "camera.yaml");
}

TEST_F(TumDatasetTest, CompanionsAreOptionalAndATrailingSlashIsFine) {
  make(1);
  for (const char* name : {"groundtruth.txt", "detections.txt", "camera.yaml"}) {
    std::filesystem::remove(folder_ / name);
  }
  ASSERT_TRUE(TumDataset::open(folder_.path() + "/", options_, &dataset_).ok());
  EXPECT_EQ(dataset_.groundtruth_file(), "");
  EXPECT_EQ(dataset_.detections_file(), "");
  EXPECT_EQ(dataset_.camera_file(), "");
  EXPECT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
}

TEST_F(TumDatasetTest, LoadsPngExactly) {
  options_.color_mode = ColorMode::kGrayAndColor;
  make(3);
  for (int i = 0; i < 3; ++i) {
    const FileStatus status = dataset_.load(static_cast<std::size_t>(i), tiny_camera(), &frame_);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_TRUE(frame_.status.ok());
    EXPECT_EQ(frame_.index, static_cast<std::size_t>(i));
    EXPECT_EQ(frame_.timestamp_s, dataset_.entry(static_cast<std::size_t>(i)).timestamp_s);
    EXPECT_GE(frame_.load_ms, 0.0);
    const cv::Mat expected = test::tiny_color(i);
    ASSERT_EQ(frame_.color.width_px, kTinyWidth_px);
    ASSERT_EQ(frame_.color.height_px, kTinyHeight_px);
    for (int v = 0; v < kTinyHeight_px; ++v) {
      for (int u = 0; u < kTinyWidth_px; ++u) {
        const cv::Vec3b& pixel = expected.at<cv::Vec3b>(v, u);
        const Bgr8& loaded = frame_.color.view()(u, v);
        ASSERT_EQ(loaded.b, pixel[0]);
        ASSERT_EQ(loaded.g, pixel[1]);
        ASSERT_EQ(loaded.r, pixel[2]);
        // The usual luma weights; PNG decoders round in their own way.
        const double luma = 0.114 * pixel[0] + 0.587 * pixel[1] + 0.299 * pixel[2];
        ASSERT_NEAR(frame_.gray.view()(u, v), luma, 1.5);
      }
    }
    expect_tiny_depth(frame_, i);
  }
}

TEST_F(TumDatasetTest, GrayHasTheSameBitsInBothModes) {
  for (const std::string extension : {"png", "jpg"}) {
    SCOPED_TRACE(extension);
    options_.color_mode = ColorMode::kGray;
    make(2, extension);
    ASSERT_TRUE(dataset_.load(1, tiny_camera(), &frame_).ok());
    EXPECT_TRUE(frame_.color.empty());
    const cv::Mat expected =
        cv::imread(folder_ / tiny_color_file(1, extension), cv::IMREAD_GRAYSCALE);
    expect_same_gray(frame_, expected);
    options_.color_mode = ColorMode::kGrayAndColor;
    ASSERT_TRUE(open().ok());
    ASSERT_TRUE(dataset_.load(1, tiny_camera(), &frame_).ok());
    EXPECT_FALSE(frame_.color.empty());
    expect_same_gray(frame_, expected);
  }
}

TEST_F(TumDatasetTest, LoadingAgainReusesTheBuffers) {
  make(3);
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  const void* gray = frame_.gray.pixels.data();
  const void* depth = frame_.depth_m.pixels.data();
  const void* raw = frame_.scratch.raw_depth.data();
  std::filesystem::remove(folder_ / tiny_color_file(1));
  EXPECT_FALSE(dataset_.load(1, tiny_camera(), &frame_).ok());
  expect_no_images(frame_);
  ASSERT_TRUE(dataset_.load(2, tiny_camera(), &frame_).ok());
  EXPECT_EQ(frame_.gray.pixels.data(), gray);
  EXPECT_EQ(frame_.depth_m.pixels.data(), depth);
  EXPECT_EQ(frame_.scratch.raw_depth.data(), raw);
}

TEST_F(TumDatasetTest, FramesWithoutDepthWithinTheToleranceHaveNone) {
  make(3);
  write_text(folder_ / "depth.txt", test::tiny_timestamp(1, 4) + " " + tiny_depth_file(1) + "\n");
  ASSERT_TRUE(open().ok());
  EXPECT_EQ(dataset_.association().num_with_depth, 1U);
  EXPECT_EQ(dataset_.association().num_depth, 1U);
  EXPECT_FALSE(dataset_.entry(0).has_depth());
  EXPECT_TRUE(dataset_.entry(1).has_depth());
  ASSERT_TRUE(dataset_.load(1, tiny_camera(), &frame_).ok());
  EXPECT_TRUE(frame_.has_depth);
  ASSERT_TRUE(dataset_.load(2, tiny_camera(), &frame_).ok());
  EXPECT_FALSE(frame_.has_depth);
  EXPECT_TRUE(frame_.depth_m.empty());
  EXPECT_FALSE(frame_.gray.empty());
}

TEST_F(TumDatasetTest, AssociationAgreesWithBruteForce) {
  test::for_each_seed(60, [this](test::Rng& rng) {
    // Multiples of 1/128 s, so that ties and exact tolerances occur.
    const auto make_list = [&rng](const std::string& name) {
      std::vector<std::pair<double, std::string>> list;
      double time_s = 500.0 + rng.uniform_int(0, 30) / 128.0;
      const int size = rng.uniform_int(1, 25);
      for (int i = 0; i < size; ++i) {
        list.emplace_back(time_s, name + "/" + std::to_string(i) + ".png");
        time_s += rng.uniform_int(1, 10) / 128.0;
      }
      return list;
    };
    const auto color = make_list("rgb");
    const auto depth = make_list("depth");
    const auto text = [](const std::vector<std::pair<double, std::string>>& list) {
      std::string lines;
      for (const auto& [time_s, file] : list) {
        lines += std::to_string(static_cast<int>(time_s)) + "." +
                 std::to_string(10000000 +
                                static_cast<int>(std::lround((time_s - std::floor(time_s)) * 1e7)))
                     .substr(1) +
                 " " + file + "\n";
      }
      return lines;
    };
    write_text(folder_ / "rgb.txt", text(color));
    write_text(folder_ / "depth.txt", text(depth));
    options_.max_time_difference_s = rng.uniform_int(1, 4) / 128.0;
    const FileStatus status = open();
    ASSERT_TRUE(status.ok()) << status.message();

    std::vector<std::size_t> nearest(color.size());
    std::vector<std::size_t> uses(depth.size(), 0);
    AssociationReport expected;
    expected.num_color = color.size();
    expected.num_depth = depth.size();
    for (std::size_t i = 0; i < color.size(); ++i) {
      double best_s = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < depth.size(); ++j) {
        const double difference_s = std::abs(depth[j].first - color[i].first);
        if (difference_s < best_s) {
          best_s = difference_s;
          nearest[i] = j;
        }
      }
      if (best_s > options_.max_time_difference_s) {
        nearest[i] = depth.size();
        continue;
      }
      ++uses[nearest[i]];
      ++expected.num_with_depth;
      expected.max_time_difference_s = std::max(expected.max_time_difference_s, best_s);
    }
    ASSERT_EQ(dataset_.size(), color.size());
    for (std::size_t i = 0; i < color.size(); ++i) {
      const TumFrameEntry& entry = dataset_.entry(i);
      ASSERT_EQ(entry.timestamp_s, color[i].first);
      ASSERT_EQ(entry.color_file, color[i].second);
      ASSERT_EQ(entry.has_depth(), nearest[i] < depth.size());
      if (!entry.has_depth()) continue;
      ASSERT_EQ(entry.depth_file, depth[nearest[i]].second);
      ASSERT_EQ(entry.depth_timestamp_s, depth[nearest[i]].first);
      if (uses[nearest[i]] > 1) ++expected.num_shared_depth;
    }
    const AssociationReport& report = dataset_.association();
    EXPECT_EQ(report.num_color, expected.num_color);
    EXPECT_EQ(report.num_depth, expected.num_depth);
    EXPECT_EQ(report.num_with_depth, expected.num_with_depth);
    EXPECT_EQ(report.num_shared_depth, expected.num_shared_depth);
    EXPECT_EQ(report.max_time_difference_s, expected.max_time_difference_s);
  });
}

TEST_F(TumDatasetTest, AssociationFileReplacesTheLists) {
  make(3);
  std::filesystem::remove(folder_ / "rgb.txt");
  std::filesystem::remove(folder_ / "depth.txt");
  TempFolder elsewhere;
  options_.association_file = elsewhere / "associations.txt";
  // The same depth twice, once far beyond the tolerance.
  write_text(options_.association_file,
             "# rgb depth\r\n1000.0 " + tiny_color_file(0) + " 1000.034 " + tiny_depth_file(1) +
                 "\r\n1000.03 " + tiny_color_file(1) + " 1000.034 " + tiny_depth_file(1) + "\r\n");
  const FileStatus status = open();
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(dataset_.size(), 2U);
  EXPECT_EQ(dataset_.association().num_color, 2U);
  EXPECT_EQ(dataset_.association().num_depth, 1U);
  EXPECT_EQ(dataset_.association().num_with_depth, 2U);
  EXPECT_EQ(dataset_.association().num_shared_depth, 2U);
  EXPECT_NEAR(dataset_.association().max_time_difference_s, 0.034, 1e-9);
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  expect_tiny_depth(frame_, 1);
}

TEST_F(TumDatasetTest, AssociationFileErrors) {
  make(2);
  options_.association_file = folder_ / "associations.txt";
  expect_failure(open(), StatusCode::kNotFound, options_.association_file, 0, "does not exist");
  struct Case {
    std::string text;
    std::size_t line;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {"1 a.png 1 b.png\n2 a.png 2\n", 2,
       "expected 4 columns `t_color color_file t_depth depth_file`, got 3"},
      {"1 a.png 1 b.png c.png\n", 1, "got 5"},
      {"1 a.png x b.png\n", 1, "time stamp 'x'"},
      {"1 a.png 1 ../b.png\n", 1, "leaves the dataset folder"},
      {"1 a.png 1 b.png\n1 c.png 1 b.png\n", 2, "repeats the one before"},
      {"2 a.png 1 b.png\n1 c.png 1 b.png\n", 2, "is before the previous one"},
  };
  for (const Case& c : cases) {
    write_text(options_.association_file, c.text);
    expect_failure(open(), StatusCode::kCorruptData, options_.association_file, c.line,
                   c.reason_part);
  }
  write_text(options_.association_file, "# nothing\n");
  expect_failure(open(), StatusCode::kInsufficientData, options_.association_file, 0,
                 "lists no images");
  // Depth first, as the TUM tools write it when they are called the other way round.
  write_text(options_.association_file,
             "1000.004 " + tiny_depth_file(0) + " 1000.0 " + tiny_color_file(0) + "\n");
  ASSERT_TRUE(open().ok());
  expect_failure(dataset_.load(0, tiny_camera(), &frame_), StatusCode::kCorruptData,
                 folder_ / tiny_depth_file(0), 0, "is it a depth image?");
}

TEST_F(TumDatasetTest, ListErrorsHaveFileLineAndReason) {
  struct Case {
    std::string line;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {"1000.5", "expected 2 columns `timestamp file`, got 1"},
      {"1000.5 rgb/my image.png", "got 3; file names may not hold white space"},
      {"later rgb/1.png", "time stamp 'later' is not a finite decimal number of seconds"},
      {"nan rgb/1.png", "time stamp 'nan'"},
      {"1e400 rgb/1.png", "time stamp '1e400'"},
      {"1305031102175304 rgb/1.png", "expected seconds, not milliseconds"},
      {"1000.0 rgb/1.png", "time stamp 1000.000000 repeats the one before"},
      {"999.9 rgb/1.png", "time stamp 999.900000 is before the previous one, 1000.000000; sort"},
      {"1000.5 /etc/passwd", "is absolute"},
      {"1000.5 C:/rgb/1.png", "is absolute"},
      {"1000.5 ../rgb/1.png", "leaves the dataset folder"},
      {"1000.5 rgb/../../1.png", "leaves the dataset folder"},
      {"1000.5 rgb/..", "leaves the dataset folder"},
      {"1000.5 rgb\\1.png", "holds a backslash"},
      {"1000.5 rgb/\xFF.png", "UTF-8"},
      {"1000.5 rgb/\x02.png", "control character"},
      {"1000.5 rgb/" + std::string(5000, 'x') + ".png", "longer than 4096 bytes"},
  };
  for (const std::string list : {"rgb.txt", "depth.txt"}) {
    make(1);
    for (const Case& c : cases) {
      SCOPED_TRACE(list + ": " + c.line.substr(0, 60));
      write_text(folder_ / list, "# comment\n1000.0 rgb/0.png\n\n" + c.line + "\n2000 x.png\n");
      expect_failure(open(), StatusCode::kCorruptData, folder_ / list, 4, c.reason_part);
      EXPECT_EQ(dataset_.size(), 0U);
    }
    for (const std::string text : {"", "# comment\n", "\r\n\r\n"}) {
      write_text(folder_ / list, text);
      expect_failure(open(), StatusCode::kInsufficientData, folder_ / list, 0,
                     "lists no images; expected lines `timestamp file`");
    }
    std::filesystem::remove(folder_ / list);
    expect_failure(open(), StatusCode::kNotFound, folder_ / list, 0, "does not exist");
    std::filesystem::create_directory(folder_ / list);
    expect_failure(open(), StatusCode::kCorruptData, folder_ / list, 0, "is a folder");
    std::filesystem::remove(folder_ / list);
  }
}

TEST_F(TumDatasetTest, ListsWithCarriageReturnsTabsAndNamesWithDotsAreFine) {
  make(2);
  write_text(folder_ / "rgb.txt", "# c\r\n1000.0\t./" + tiny_color_file(0) +
                                      "\r\n  1000.03   rgb//" + tiny_color_file(1).substr(4) +
                                      " \r\n");
  ASSERT_TRUE(open().ok());
  EXPECT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  EXPECT_TRUE(dataset_.load(1, tiny_camera(), &frame_).ok());
  // Two dots in a name do not leave the folder.
  std::filesystem::rename(folder_ / tiny_color_file(0), folder_ / "rgb/..0.png");
  write_text(folder_ / "rgb.txt", "1000.0 rgb/..0.png\n");
  ASSERT_TRUE(open().ok());
  EXPECT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
}

TEST_F(TumDatasetTest, FolderAndOptionErrors) {
  expect_failure(TumDataset::open(folder_ / "absent", options_, &dataset_), StatusCode::kNotFound,
                 folder_ / "absent", 0, "dataset folder does not exist");
  write_text(folder_ / "file", "x");
  expect_failure(TumDataset::open(folder_ / "file", options_, &dataset_),
                 StatusCode::kInvalidArgument, folder_ / "file", 0, "is not a folder");
  expect_failure(TumDataset::open("", options_, &dataset_), StatusCode::kNotFound, "", 0,
                 "does not exist");
  make(1);
  for (const double bad_s : {0.0, -0.02, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    options_.max_time_difference_s = bad_s;
    expect_failure(open(), StatusCode::kInvalidArgument, folder_.path(), 0,
                   "max_time_difference_s");
  }
}

/// A file with the PNG header of an image of any size and no pixels behind it.
std::string png_with_header(std::uint32_t width_px, std::uint32_t height_px, unsigned char bits) {
  std::string bytes = "\x89PNG\r\n\x1A\n";
  const auto append_32 = [](std::uint32_t value, std::string* text) {
    for (const unsigned shift : {24U, 16U, 8U, 0U}) {
      *text += static_cast<char>(static_cast<unsigned char>(value >> shift & 0xFFU));
    }
  };
  const auto append_chunk = [&](const std::string& type_and_data) {
    append_32(static_cast<std::uint32_t>(type_and_data.size() - 4), &bytes);
    bytes += type_and_data;
    const std::vector<unsigned char> checked(type_and_data.begin(), type_and_data.end());
    append_32(io_detail::crc32(checked), &bytes);
  };
  std::string header = "IHDR";
  append_32(width_px, &header);
  append_32(height_px, &header);
  header += static_cast<char>(bits);
  header += std::string(4, '\0');
  append_chunk(header);
  append_chunk("IDATxyz");
  append_chunk("IEND");
  return bytes;
}

TEST_F(TumDatasetTest, DamagedImagesAreToldApartAndLeaveNothingBehind) {
  make(1);
  const std::string color = folder_ / tiny_color_file(0);
  const std::string depth = folder_ / tiny_depth_file(0);
  const std::string color_bytes = test::read_text(color);
  const std::string depth_bytes = test::read_text(depth);
  const std::string jpeg_bytes = [this] {
    write_image(folder_ / "x.jpg", test::tiny_color(0));
    return test::read_text(folder_ / "x.jpg");
  }();
  const auto image_bytes = [this](const cv::Mat& image, const std::string& name) {
    write_image(folder_ / name, image);
    return test::read_text(folder_ / name);
  };
  std::string flipped = depth_bytes;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 0x10);

  struct Case {
    bool is_color;
    std::string bytes;
    std::string reason_part;
  };
  const cv::Mat small8(10, 20, CV_8UC3, cv::Scalar(1, 2, 3));
  const cv::Mat small16(10, 20, CV_16UC1, cv::Scalar(5));
  const cv::Mat gray8(kTinyHeight_px, kTinyWidth_px, CV_8UC1, cv::Scalar(9));
  const cv::Mat color16(kTinyHeight_px, kTinyWidth_px, CV_16UC3, cv::Scalar(9, 9, 9));
  const std::vector<Case> cases = {
      {true, "", "file is empty"},
      {true, "this is no image\n", "neither a PNG nor a JPEG"},
      {true, color_bytes.substr(0, 20), "PNG is truncated"},
      {true, color_bytes.substr(0, color_bytes.size() - 1), "PNG is truncated"},
      {true, color_bytes.substr(0, color_bytes.size() / 2), "PNG is truncated"},
      {true, jpeg_bytes.substr(0, jpeg_bytes.size() - 1), "JPEG is truncated"},
      {true, jpeg_bytes.substr(0, jpeg_bytes.size() / 2), "JPEG is truncated"},
      {true, image_bytes(small8, "s.png"), "image is 20x10 px; the camera is 40x30 px"},
      {true, image_bytes(small8, "s.jpg"), "image is 20x10 px; the camera is 40x30 px"},
      {true, image_bytes(test::tiny_depth(0), "d.png"), "is it a depth image?"},
      {true, image_bytes(color16, "c.png"), "has 3 channel(s) of 16 bits; expected 8 bits"},
      {true, png_with_header(100000, 100000, 8), "image is 100000x100000 px"},
      {true, png_with_header(kTinyWidth_px, kTinyHeight_px, 8), "cannot be decoded"},
      {false, "", "file is empty"},
      {false, depth_bytes.substr(0, depth_bytes.size() - 5), "PNG is truncated"},
      {false, flipped, "has a wrong checksum"},
      {false, image_bytes(gray8, "g.png"),
       "depth image has 1 channel(s) of 8 bits; expected a 16-bit single-channel PNG"},
      {false, image_bytes(color16, "c.png"), "depth image has 3 channel(s) of 16 bits"},
      {false, jpeg_bytes, "depth image is a JPEG"},
      {false, image_bytes(small16, "s16.png"), "image is 20x10 px; the camera is 40x30 px"},
      {false, png_with_header(4000000000U, 1, 16), "image is 4000000000x1 px"},
      {false, png_with_header(2000000000U, 2000000000U, 16), "image is 2000000000x2000000000 px"},
  };
  options_.color_mode = ColorMode::kGrayAndColor;
  ASSERT_TRUE(open().ok());
  for (const Case& c : cases) {
    SCOPED_TRACE(c.reason_part);
    const std::string& path = c.is_color ? color : depth;
    write_text(path, c.bytes);
    // What libraries print about bad files ends up in front of a user who asked for nothing. The
    // crafted PNG whose container is whole but whose pixels are not is the one that reaches libpng.
    const bool reaches_decoder = c.reason_part == "cannot be decoded";
    testing::internal::CaptureStderr();
    const FileStatus status = dataset_.load(0, tiny_camera(), &frame_);
    const std::string printed = testing::internal::GetCapturedStderr();
    expect_failure(status, StatusCode::kCorruptData, path, 0, c.reason_part);
    if (!reaches_decoder) {
      EXPECT_EQ(printed, "");
    }
    EXPECT_EQ(frame_.status.message(), status.message());
    EXPECT_EQ(frame_.timestamp_s, 1000.0);
    expect_no_images(frame_);
    write_text(path, c.is_color ? color_bytes : depth_bytes);
    ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
    expect_tiny_depth(frame_, 0);
  }
}

TEST_F(TumDatasetTest, MissingFilesFoldersAndHugeFiles) {
  make(1);
  for (const std::string& path : {folder_ / tiny_color_file(0), folder_ / tiny_depth_file(0)}) {
    const std::string bytes = test::read_text(path);
    std::filesystem::remove(path);
    expect_failure(dataset_.load(0, tiny_camera(), &frame_), StatusCode::kNotFound, path, 0,
                   "does not exist");
    expect_no_images(frame_);
    std::filesystem::create_directory(path);
    expect_failure(dataset_.load(0, tiny_camera(), &frame_), StatusCode::kCorruptData, path, 0,
                   "is a folder");
    std::filesystem::remove(path);
    write_text(path, bytes);
    std::filesystem::resize_file(path, 1ULL << 33U);  // sparse
    expect_failure(dataset_.load(0, tiny_camera(), &frame_), StatusCode::kCorruptData, path, 0,
                   "file has 8589934592 bytes; at most");
    std::filesystem::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    expect_failure(dataset_.load(0, tiny_camera(), &frame_), StatusCode::kCorruptData, path, 0,
                   "not a regular file");
    std::filesystem::remove(path);
    write_text(path, bytes);
  }
  EXPECT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
}

TEST_F(TumDatasetTest, BadIndexAndBadCamera) {
  make(2);
  expect_failure(dataset_.load(2, tiny_camera(), &frame_), StatusCode::kInvalidArgument,
                 folder_.path(), 0, "frame 2 of 2 does not exist");
  expect_no_images(frame_);
  RgbdCamera camera = tiny_camera();
  camera.depth_units_per_m = 0.0;
  expect_failure(dataset_.load(0, camera, &frame_), StatusCode::kInvalidArgument, "tiny", 0,
                 "depth_units_per_m");
  expect_no_images(frame_);
  expect_failure(TumDataset().load(0, tiny_camera(), &frame_), StatusCode::kInvalidArgument, "", 0,
                 "frame 0 of 0 does not exist");
}

TEST_F(TumDatasetTest, DepthScaleIsTheCameras) {
  make(1);
  RgbdCamera camera = tiny_camera();
  camera.depth_units_per_m = 1000.0;
  ASSERT_TRUE(dataset_.load(0, camera, &frame_).ok());
  EXPECT_EQ(frame_.depth_m.view()(1, 0),
            static_cast<float>(test::tiny_raw_depth(0, 1, 0) / 1000.0));
  EXPECT_EQ(frame_.depth_m.view()(0, 0), 0.0F);
}

TEST_F(TumDatasetTest, GreyColourFilesAndAlphaAreAccepted) {
  make(1);
  options_.color_mode = ColorMode::kGrayAndColor;
  ASSERT_TRUE(open().ok());
  cv::Mat gray(kTinyHeight_px, kTinyWidth_px, CV_8UC1);
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u)
      gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(5 * u + v);
  }
  write_image(folder_ / tiny_color_file(0), gray);
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  expect_same_gray(frame_, gray);
  EXPECT_EQ(frame_.color.view()(3, 2).b, gray.at<std::uint8_t>(2, 3));
  cv::Mat alpha;
  cv::cvtColor(test::tiny_color(0), alpha, cv::COLOR_BGR2BGRA);
  write_image(folder_ / tiny_color_file(0), alpha);
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  EXPECT_EQ(frame_.color.view()(3, 2).r, test::tiny_color(0).at<cv::Vec3b>(2, 3)[2]);
}

TEST_F(TumDatasetTest, OrientationTagsAreIgnored) {
  make(1, "jpg");
  const std::string path = folder_ / tiny_color_file(0, "jpg");
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  const std::vector<std::uint8_t> expected = frame_.gray.pixels;
  // An Exif segment that says "turn by 90 degrees".
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0"
      "MM\0*\0\0\0\x08"
      "\0\x01"
      "\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"
      "\0\0\0\0",
      36);
  std::string bytes = test::read_text(path);
  bytes.insert(2, exif);
  write_text(path, bytes);
  const cv::Mat turned = cv::imread(path, cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(turned.cols, kTinyHeight_px) << "the tag is not understood, so this proves nothing";
  ASSERT_TRUE(dataset_.load(0, tiny_camera(), &frame_).ok());
  EXPECT_EQ(frame_.gray.pixels, expected);
}

TEST_F(TumDatasetTest, LoadingIsReentrant) {
  make(8);
  std::vector<std::vector<float>> alone(8);
  for (std::size_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(dataset_.load(i, tiny_camera(), &frame_).ok());
    alone[i] = frame_.depth_m.pixels;
  }
  std::vector<std::thread> threads;
  std::vector<int> num_wrong(3, 0);
  for (std::size_t t = 0; t < num_wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      LoadedFrame frame;
      for (std::size_t i = 0; i < 40; ++i) {
        const std::size_t index = (i * 3 + t) % 8;
        const bool loaded = dataset_.load(index, tiny_camera(), &frame).ok();
        if (!loaded || frame.depth_m.pixels != alone[index]) ++num_wrong[t];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(num_wrong, std::vector<int>(3, 0));
}

}  // namespace
}  // namespace srslam
