// Cost of reading datasets. Images come from the slice fr1_xyz_a below the folder that
// SRSLAM_DATA_DIR names, or, without it, are made up in the same size and formats.

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "srslam/io/detections_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/io/tum_dataset.hpp"

namespace srslam {
namespace {

constexpr int kNumFrames = 40;
constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;

/// A folder of its own for one benchmark, removed at its end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::random_device device;
    path_ =
        (std::filesystem::temp_directory_path() / ("srslam_bench_io_" + std::to_string(device())))
            .string();
    std::filesystem::create_directories(path_ + "/rgb");
    std::filesystem::create_directories(path_ + "/depth");
  }
  ~ScratchFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string timestamp(int index, double offset_s) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6f", 1305031102.0 + index / 30.0 + offset_s);
  return text.data();
}

/// Writes lists of `num_frames` entries.
void write_lists(const std::string& folder, int num_frames) {
  std::ofstream rgb(folder + "/rgb.txt");
  std::ofstream depth(folder + "/depth.txt");
  for (int i = 0; i < num_frames; ++i) {
    rgb << timestamp(i, 0.0) << " rgb/" << i << ".jpg\n";
    depth << timestamp(i, 0.012) << " depth/" << i << ".png\n";
  }
}

/// Smooth surfaces with noise, about as hard to compress as real images.
void write_images(const std::string& folder) {
  cv::RNG rng(7);
  for (int i = 0; i < kNumFrames; ++i) {
    cv::Mat coarse(kHeight_px / 16, kWidth_px / 16, CV_8UC3);
    rng.fill(coarse, cv::RNG::UNIFORM, 30, 220);
    cv::Mat color(kHeight_px, kWidth_px, CV_8UC3);
    cv::Mat depth(kHeight_px, kWidth_px, CV_16UC1);
    for (int v = 0; v < kHeight_px; ++v) {
      for (int u = 0; u < kWidth_px; ++u) {
        cv::Vec3b pixel = coarse.at<cv::Vec3b>(v / 16, u / 16);
        for (int c = 0; c < 3; ++c) {
          pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + rng.uniform(-8, 9));
        }
        color.at<cv::Vec3b>(v, u) = pixel;
        const bool hole = coarse.at<cv::Vec3b>(v / 16, u / 16)[0] < 60;
        depth.at<std::uint16_t>(v, u) =
            hole ? std::uint16_t{0}
                 : static_cast<std::uint16_t>(5000 + 8 * u + 5 * v + 4 * rng.uniform(-3, 4));
      }
    }
    cv::imwrite(folder + "/rgb/" + std::to_string(i) + ".jpg", color,
                {cv::IMWRITE_JPEG_QUALITY, 95});
    cv::imwrite(folder + "/depth/" + std::to_string(i) + ".png", depth);
  }
}

/// The real slice, or a made-up dataset that lives as long as the program.
const std::string& image_folder(std::string* label) {
  static const std::string real = [] {
    const char* root = std::getenv("SRSLAM_DATA_DIR");
    std::string folder = root == nullptr ? std::string() : std::string(root) + "/fr1_xyz_a";
    return std::filesystem::exists(folder + "/rgb.txt") ? folder : std::string();
  }();
  if (!real.empty()) {
    *label = "fr1_xyz_a";
    return real;
  }
  static const ScratchFolder* const made_up = [] {
    static ScratchFolder folder;
    write_lists(folder.path(), kNumFrames);
    write_images(folder.path());
    return &folder;
  }();
  *label = "made-up images";
  return made_up->path();
}

bool open_images(benchmark::State* state, ColorMode mode, bool with_depth, TumDataset* dataset,
                 RgbdCamera* camera) {
  std::string label;
  TumDatasetOptions options;
  options.color_mode = mode;
  // Nothing is that near: colour alone.
  if (!with_depth) options.max_time_difference_s = 1e-9;
  FileStatus status = TumDataset::open(image_folder(&label), options, dataset);
  if (status.ok()) status = camera_preset("tum_fr1", camera);
  if (!status.ok()) state->SkipWithError(status.message().c_str());
  state->SetLabel(label);
  return status.ok();
}

void load_frames(benchmark::State* state, ColorMode mode, bool with_depth) {
  TumDataset dataset;
  RgbdCamera camera;
  if (!open_images(state, mode, with_depth, &dataset, &camera)) return;
  LoadedFrame frame;
  std::size_t index = 0;
  for (auto _ : *state) {
    const FileStatus status = dataset.load(index % kNumFrames, camera, &frame);
    if (!status.ok() || frame.has_depth != with_depth) {
      state->SkipWithError(("frame did not load: " + status.message()).c_str());
      return;
    }
    benchmark::DoNotOptimize(frame.gray.pixels.data());
    ++index;
  }
  state->SetItemsProcessed(state->iterations());
}

void BM_LoadGray(benchmark::State& state) { load_frames(&state, ColorMode::kGray, false); }
void BM_LoadGrayAndColor(benchmark::State& state) {
  load_frames(&state, ColorMode::kGrayAndColor, false);
}
void BM_LoadGrayAndDepth(benchmark::State& state) { load_frames(&state, ColorMode::kGray, true); }
BENCHMARK(BM_LoadGray)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_LoadGrayAndColor)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_LoadGrayAndDepth)->Unit(benchmark::kMillisecond)->UseRealTime();

/// What the caller waits for when it does nothing else; one iteration reads kNumFrames frames.
void BM_FrameReader(benchmark::State& state) {
  TumDataset dataset;
  RgbdCamera camera;
  if (!open_images(&state, ColorMode::kGray, true, &dataset, &camera)) return;
  for (auto _ : state) {
    FrameReader reader(dataset, camera, 0, kNumFrames, static_cast<std::size_t>(state.range(0)));
    LoadedFrame frame;
    while (reader.next(&frame)) benchmark::DoNotOptimize(frame.depth_m.pixels.data());
  }
  state.SetItemsProcessed(state.iterations() * kNumFrames);
}
BENCHMARK(BM_FrameReader)->Arg(0)->Arg(4)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_OpenLists(benchmark::State& state) {
  ScratchFolder folder;
  write_lists(folder.path(), static_cast<int>(state.range(0)));
  for (auto _ : state) {
    TumDataset dataset;
    const FileStatus status = TumDataset::open(folder.path(), {}, &dataset);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
    benchmark::DoNotOptimize(dataset.association().num_with_depth);
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_OpenLists)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

void BM_ReadTrajectory(benchmark::State& state) {
  ScratchFolder folder;
  Trajectory trajectory(static_cast<std::size_t>(state.range(0)));
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const double t = static_cast<double>(i);
    trajectory[i].timestamp_s = 1305031102.0 + 0.01 * t;
    trajectory[i].T_world_camera.linear() =
        Eigen::AngleAxisd(0.001 * t, Eigen::Vector3d(0.6, 0.0, 0.8)).toRotationMatrix();
    trajectory[i].T_world_camera.translation() << 0.001 * t, 1.0 / (1.0 + t), -0.5;
  }
  const std::string path = folder.path() + "/trajectory.txt";
  FileStatus status = write_trajectory(path, trajectory, "");
  for (auto _ : state) {
    if (status.ok()) status = read_trajectory(path, &trajectory);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
    benchmark::DoNotOptimize(trajectory.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_ReadTrajectory)->Arg(10000)->Unit(benchmark::kMillisecond);

void BM_AppendPose(benchmark::State& state) {
  ScratchFolder folder;
  TrajectoryWriter writer;
  FileStatus status = writer.open(folder.path() + "/trajectory.txt", "");
  StampedPose pose;
  pose.T_world_camera.translation() << 1.25, -0.5, 3.75;
  for (auto _ : state) {
    pose.timestamp_s += 1.0 / 30.0;
    if (status.ok()) status = writer.append(pose);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
  }
}
BENCHMARK(BM_AppendPose)->Unit(benchmark::kMicrosecond);

void BM_ReadDetections(benchmark::State& state) {
  ScratchFolder folder;
  std::vector<FrameDetections> frames(1000);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].timestamp_s = 1305031102.0 + 0.03 * static_cast<double>(i);
    frames[i].detections.assign(10, {"person", 0.875, 100.5, 50.25, 200.125, 400.5});
  }
  const std::string path = folder.path() + "/detections.txt";
  FileStatus status = write_detections(path, frames);
  for (auto _ : state) {
    if (status.ok()) status = read_detections(path, &frames);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
    benchmark::DoNotOptimize(frames.data());
  }
  state.SetItemsProcessed(state.iterations() * 10000);
}
BENCHMARK(BM_ReadDetections)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace srslam
