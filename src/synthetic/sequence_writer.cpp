#include "srslam/synthetic/sequence_writer.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "srslam/evaluation/trajectory.hpp"
#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"

namespace srslam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kColorList = "rgb.txt";
constexpr const char* kDepthList = "depth.txt";
constexpr const char* kDescription = "scenario.json";
/// Everything else that a sequence consists of; the list that makes it one goes first.
constexpr const char* kWritten[] = {kColorList,       kDepthList,    "groundtruth.txt",
                                    "detections.txt", "camera.yaml", "rgb",
                                    "depth",          "masks",       "flow"};
constexpr int kJpegQuality = 95;
// Flow as in the KITTI benchmark: 16 bits a component, 64 steps a pixel about 2^15.
constexpr float kFlowSteps_per_px = 64.0F;
constexpr float kFlowZero = 32768.0F;

FileStatus write_bytes(const std::string& path, const void* data, std::size_t size) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  bool written = file != nullptr;
  if (written) {
    written = std::fwrite(data, 1, size, file) == size;
    written = std::fclose(file) == 0 && written;
  }
  if (written) return FileStatus::success();
  return FileStatus::failure(StatusCode::kIoError, path, 0,
                             std::string("cannot be written: ") + std::strerror(errno));
}

FileStatus write_text(const std::string& path, const std::string& text) {
  return write_bytes(path, text.data(), text.size());
}

std::string stamp_text(double timestamp_s) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6f", timestamp_s);
  return text;
}

/// Writes the images of single frames.
class ImageWriter {
 public:
  ImageWriter(std::string folder, const SequenceWriterOptions& options)
      : folder_(std::move(folder)), options_(options) {}

  std::string color_name(double timestamp_s) const {
    return "rgb/" + stamp_text(timestamp_s) + (options_.jpeg ? ".jpg" : ".png");
  }
  static std::string depth_name(double timestamp_s) {
    return "depth/" + stamp_text(timestamp_s) + ".png";
  }

  FileStatus write(const SyntheticFrame& frame) {
    const cv::Size size(frame.color.width_px, frame.color.height_px);
    // OpenCV takes no const data; it only reads.
    const cv::Mat color(size, CV_8UC3, const_cast<Bgr8*>(frame.color.pixels.data()));
    FileStatus status = encode(color_name(frame.timestamp_s), color);
    if (!status.ok()) return status;
    const cv::Mat depth(size, CV_16UC1, const_cast<std::uint16_t*>(frame.raw_depth.pixels.data()));
    status = encode(depth_name(frame.timestamp_s), depth);
    if (!status.ok()) return status;
    const cv::Mat mask(size, CV_8UC1, const_cast<std::uint8_t*>(frame.instances.pixels.data()));
    return encode("masks/" + stamp_text(frame.timestamp_s) + ".png", mask);
  }

  FileStatus write_flow(double timestamp_s, const ImageBuffer<Eigen::Vector2f>& flow_px) {
    cv::Mat image(flow_px.height_px, flow_px.width_px, CV_16UC3);
    for (int v = 0; v < image.rows; ++v) {
      auto* row = image.ptr<cv::Vec<std::uint16_t, 3>>(v);
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector2f steps =
            kFlowSteps_per_px * flow_px.view()(u, v) + Eigen::Vector2f::Constant(kFlowZero);
        const bool valid =
            steps.allFinite() && steps.minCoeff() >= 0.0F && steps.maxCoeff() <= 65535.0F;
        // The file holds red, green, blue: u, v, valid.
        row[u] =
            valid ? cv::Vec<std::uint16_t, 3>(1, static_cast<std::uint16_t>(std::lround(steps.y())),
                                              static_cast<std::uint16_t>(std::lround(steps.x())))
                  : cv::Vec<std::uint16_t, 3>(0, 0, 0);
      }
    }
    return encode("flow/" + stamp_text(timestamp_s) + ".png", image);
  }

 private:
  FileStatus encode(const std::string& name, const cv::Mat& image) {
    const std::string extension = name.substr(name.rfind('.'));
    const std::vector<int> parameters =
        extension == ".jpg" ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, kJpegQuality}
                            : std::vector<int>{};  // OpenCV's own choice for PNG is its fastest
    if (!cv::imencode(extension, image, encoded_, parameters)) {
      return FileStatus::failure(StatusCode::kIoError, folder_ + "/" + name, 0,
                                 "the image could not be encoded");
    }
    return write_bytes(folder_ + "/" + name, encoded_.data(), encoded_.size());
  }

  std::string folder_;
  SequenceWriterOptions options_;
  std::vector<unsigned char> encoded_;
};

FileStatus prepare_folder(const std::string& folder, const SequenceWriterOptions& options) {
  std::error_code error;
  const bool holds_something = fs::exists(folder, error) && !fs::is_empty(folder, error);
  if (error) {
    return FileStatus::failure(StatusCode::kIoError, folder, 0,
                               "cannot be looked into: " + error.message());
  }
  if (holds_something && !options.overwrite) {
    return FileStatus::failure(StatusCode::kInvalidArgument, folder, 0,
                               "the folder is not empty; name another one or allow overwriting");
  }
  // scenario.json is written first and marks what is ours. Without it images in the folder are
  // somebody's recording.
  if (!fs::exists(fs::path(folder) / kDescription, error)) {
    for (const char* name : kWritten) {
      if (fs::exists(fs::path(folder) / name, error)) {
        return FileStatus::failure(StatusCode::kInvalidArgument, folder, 0,
                                   std::string("holds ") + name + " but no " + kDescription +
                                       ": not a rendered sequence, which alone is overwritten");
      }
    }
  }
  // An unfinished sequence must not look like one, and no image of an earlier one may remain.
  for (const char* name : kWritten) {
    fs::remove_all(fs::path(folder) / name, error);
    if (error) {
      return FileStatus::failure(StatusCode::kIoError, (fs::path(folder) / name).string(), 0,
                                 "cannot be removed: " + error.message());
    }
  }
  std::vector<const char*> folders{"rgb", "depth", "masks"};
  if (options.flow) folders.push_back("flow");
  for (const char* name : folders) {
    const fs::path path = fs::path(folder) / name;
    fs::create_directories(path, error);
    if (error) {
      return FileStatus::failure(StatusCode::kIoError, path.string(), 0,
                                 "the folder cannot be made: " + error.message());
    }
  }
  return FileStatus::success();
}

}  // namespace

FileStatus write_sequence(const SyntheticWorld& world, const std::string& folder,
                          const SequenceWriterOptions& options, const SequenceProgress& progress) {
  FileStatus status = prepare_folder(folder, options);
  const std::string prefix = folder + "/";
  if (status.ok()) status = write_text(prefix + kDescription, world.description_json());
  if (!status.ok()) return status;

  const std::size_t num_frames = world.options().num_frames;
  std::vector<FrameDetections> detections(num_frames);
  std::atomic<std::size_t> next_frame{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;  // guards what follows
  std::size_t num_done = 0;
  FileStatus first_failure = FileStatus::success();
  const auto work = [&]() {
    SyntheticRenderer renderer(world);
    ImageWriter writer(folder, options);
    SyntheticFrame frame;
    ImageBuffer<Eigen::Vector2f> flow_px;
    for (std::size_t i = next_frame++; i < num_frames && !stop; i = next_frame++) {
      renderer.render(i, &frame);
      FileStatus written = writer.write(frame);
      if (written.ok() && options.flow && i + 1 < num_frames) {
        renderer.flow_to(i + 1, &flow_px);
        written = writer.write_flow(frame.timestamp_s, flow_px);
      }
      const std::lock_guard<std::mutex> lock(mutex);
      detections[i] = {frame.timestamp_s, frame.detections};
      ++num_done;
      if (!written.ok()) {
        if (first_failure.ok()) first_failure = written;
        stop = true;
      } else if (progress && !progress(num_done) && first_failure.ok()) {
        first_failure = FileStatus::failure(StatusCode::kNotConverged, folder, 0,
                                            "stopped before the sequence was complete");
        stop = true;
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < options.num_threads; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (!first_failure.ok()) return first_failure;

  const ImageWriter names(folder, options);
  Trajectory groundtruth;
  std::string color_list = "# color images\n# timestamp filename\n";
  std::string depth_list = "# depth images\n# timestamp filename\n";
  for (std::size_t i = 0; i < num_frames; ++i) {
    const double timestamp_s = world.timestamp_s(i);
    groundtruth.push_back({timestamp_s, world.T_world_camera(i)});
    color_list += stamp_text(timestamp_s) + " " + names.color_name(timestamp_s) + "\n";
    depth_list += stamp_text(timestamp_s) + " " + ImageWriter::depth_name(timestamp_s) + "\n";
  }
  status = write_trajectory(prefix + "groundtruth.txt", groundtruth,
                            "ground truth of the camera\ntimestamp tx ty tz qx qy qz qw");
  if (status.ok()) status = write_detections(prefix + "detections.txt", detections);
  if (status.ok()) status = write_camera_file(prefix + "camera.yaml", world.options().camera);
  if (status.ok()) status = write_text(prefix + kDepthList, depth_list);
  if (status.ok()) status = write_text(prefix + kColorList, color_list);
  return status;
}

}  // namespace srslam
