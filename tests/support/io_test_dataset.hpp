#pragma once

// Small datasets for the tests of reading files: written on the spot, removed afterwards.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "srslam/core/status.hpp"
#include "srslam/io/camera_file.hpp"

namespace srslam::test {

/// A folder of its own that is removed with its content.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "srslam_io_test_XXXXXX").string();
    const char* made = mkdtemp(pattern.data());
    EXPECT_NE(made, nullptr) << "cannot make a folder like " << pattern;
    path_ = pattern;
  }
  ~TempFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline void write_text(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  ASSERT_TRUE(stream.good()) << path;
}

inline std::string read_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream.good()) << path;
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

inline void write_image(const std::string& path, const cv::Mat& image) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  ASSERT_TRUE(cv::imwrite(path, image)) << path;
}

constexpr int kTinyWidth_px = 40;
constexpr int kTinyHeight_px = 30;

/// Camera of the tiny datasets.
inline RgbdCamera tiny_camera() {
  RgbdCamera camera;
  camera.name = "tiny";
  camera.camera.width_px = kTinyWidth_px;
  camera.camera.height_px = kTinyHeight_px;
  camera.camera.fx_px = 35.0;
  camera.camera.fy_px = 35.5;
  camera.camera.cx_px = 19.5;
  camera.camera.cy_px = 14.5;
  camera.depth_units_per_m = 5000.0;
  return camera;
}

/// A smooth coloured pattern that differs from frame to frame and survives JPEG.
inline cv::Mat tiny_color(int index) {
  cv::Mat image(kTinyHeight_px, kTinyWidth_px, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<cv::Vec3b>(v, u) =
          cv::Vec3b(static_cast<std::uint8_t>(4 * u + index), static_cast<std::uint8_t>(6 * v),
                    static_cast<std::uint8_t>(2 * u + 3 * v + 5 * index));
    }
  }
  return image;
}

/// Raw depth with holes.
inline std::uint16_t tiny_raw_depth(int index, int u_px, int v_px) {
  if ((u_px + v_px + index) % 7 == 0) return 0;
  return static_cast<std::uint16_t>(3000 + 300 * u_px + 41 * v_px + 113 * index);
}

inline cv::Mat tiny_depth(int index) {
  cv::Mat image(kTinyHeight_px, kTinyWidth_px, CV_16UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u)
      image.at<std::uint16_t>(v, u) = tiny_raw_depth(index, u, v);
  }
  return image;
}

/// `1000.<hundredths>`: 30 ms between frames from 1000 s on.
inline std::string tiny_timestamp(int index, int offset_ms = 0) {
  std::array<char, 32> text{};
  const int milliseconds = 30 * index + offset_ms;
  std::snprintf(text.data(), text.size(), "%d.%03d", 1000 + milliseconds / 1000,
                milliseconds % 1000);
  return text.data();
}

/// Colour and depth image names of a frame.
inline std::string tiny_color_file(int index, const std::string& extension = "png") {
  return "rgb/" + tiny_timestamp(index) + "." + extension;
}
inline std::string tiny_depth_file(int index) {
  return "depth/" + tiny_timestamp(index, 4) + ".png";
}

/// Writes a whole valid dataset: `num_frames` colour images, depth 4 ms after each, ground truth,
/// detections and a camera file.
inline void write_tiny_dataset(const std::string& folder, int num_frames,
                               const std::string& extension = "png") {
  std::string rgb = "# color images\n# timestamp filename\n";
  std::string depth = "# depth maps\n# timestamp filename\n";
  std::string groundtruth = "# timestamp tx ty tz qx qy qz qw\n";
  std::string detections = "# srslam detections v1\n";
  for (int i = 0; i < num_frames; ++i) {
    write_image(folder + "/" + tiny_color_file(i, extension), tiny_color(i));
    write_image(folder + "/" + tiny_depth_file(i), tiny_depth(i));
    rgb += tiny_timestamp(i) + " " + tiny_color_file(i, extension) + "\n";
    depth += tiny_timestamp(i, 4) + " " + tiny_depth_file(i) + "\n";
    groundtruth += tiny_timestamp(i, 1) + " 0." + std::to_string(i) + " 0 1.5 0 0 0.6 0.8\n";
    detections += tiny_timestamp(i) + (i % 3 == 0 ? " none\n" : " person 0.9 1.5 2.5 20.0 28.0\n");
    if (i % 3 == 2) detections += tiny_timestamp(i) + " chair 0.5 20.0 3.0 39.0 29.5\n";
  }
  write_text(folder + "/rgb.txt", rgb);
  write_text(folder + "/depth.txt", depth);
  write_text(folder + "/groundtruth.txt", groundtruth);
  write_text(folder + "/detections.txt", detections);
  const FileStatus status = write_camera_file(folder + "/camera.yaml", tiny_camera());
  ASSERT_TRUE(status.ok()) << status.message();
}

/// Expects a failure with code, file, line and a reason that holds `reason_part`.
inline void expect_failure(const FileStatus& status, StatusCode code, const std::string& file,
                           std::size_t line, const std::string& reason_part) {
  EXPECT_EQ(to_string(status.code), std::string(to_string(code))) << status.message();
  EXPECT_EQ(status.file, file) << status.message();
  EXPECT_EQ(status.line, line) << status.message();
  EXPECT_NE(status.reason.find(reason_part), std::string::npos)
      << "expected '" << reason_part << "' in: " << status.message();
}

/// Folder of the real slice `name`, or an empty string when SRSLAM_DATA_DIR does not lead to it.
inline std::string real_slice(const std::string& name) {
  const char* root = std::getenv("SRSLAM_DATA_DIR");
  if (root == nullptr || *root == '\0') return {};
  std::string folder = std::string(root) + "/" + name;
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? folder : std::string();
}

/// Why a test of real data is skipped.
inline std::string skip_reason(const std::string& name) {
  return "set SRSLAM_DATA_DIR to a folder that holds " + name + " to run this test on real images";
}

}  // namespace srslam::test
