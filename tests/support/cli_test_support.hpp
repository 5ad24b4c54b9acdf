#pragma once

// For the tests of the program: a small rendered dataset that can be tracked, and the program as a
// child process.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX, not <csignal>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "srslam/core/pose.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::test {

// ---- A room with patterned walls and a box in it ------------------------------------------------

constexpr double kRoomFrameInterval_s = 0.032;

inline RgbdCamera room_camera() {
  RgbdCamera camera;
  camera.name = "room";
  camera.camera.width_px = 320;
  camera.camera.height_px = 240;
  camera.camera.fx_px = 262.0;
  camera.camera.fy_px = 262.0;
  camera.camera.cx_px = 159.5;
  camera.camera.cy_px = 119.5;
  camera.depth_units_per_m = 5000.0;
  return camera;
}

/// T_world_camera of frame `index`: a slow sweep, 1 cm and 0.4 degrees from frame to frame.
inline Pose room_pose(int index) {
  Pose T_world_camera = Pose::Identity();
  const double phase = 0.05 * index;
  T_world_camera.translation() = Eigen::Vector3d(0.2 * std::sin(phase), 0.1 * std::sin(2.0 * phase),
                                                 -1.0 + 0.15 * std::sin(0.7 * phase));
  T_world_camera.linear() =
      (Eigen::AngleAxisd(0.12 * std::sin(phase), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.06 * std::sin(1.3 * phase), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return T_world_camera;
}

/// Grey level of the pattern at a place of surface `surface`: squares of 8 cm, each of its own
/// grey, with smaller ones in them.
inline double room_pattern(int surface, double a_m, double b_m) {
  const auto hash = [surface](double scale, double x, double y) {
    auto h =
        static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x * scale)) * 73856093 ^
                                   static_cast<std::int64_t>(std::floor(y * scale)) * 19349663 ^
                                   static_cast<std::int64_t>(surface + 1) * 83492791);
    h ^= h >> 33U;
    h *= 0xFF51AFD7ED558CCDULL;
    h ^= h >> 33U;
    return static_cast<double>(h % 1000U) / 999.0;
  };
  return 30.0 + 130.0 * hash(12.5, a_m, b_m) + 70.0 * hash(37.0, a_m, b_m);
}

struct RoomHit {
  double depth_m = std::numeric_limits<double>::infinity();  ///< along the ray's unit of z
  double gray = 0.0;
};

/// What a ray from `origin` along `direction` meets first: the walls of the room from inside, or
/// the box from outside.
inline RoomHit room_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  RoomHit hit;
  const auto meet = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                        int first_surface) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double plane : {low[axis], high[axis]}) {
        if (std::abs(direction[axis]) < 1e-12) continue;
        const double t = (plane - origin[axis]) / direction[axis];
        if (!(t > 1e-6) || t >= hit.depth_m) continue;
        const Eigen::Vector3d point = origin + t * direction;
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        if (point[a] < low[a] || point[a] > high[a] || point[b] < low[b] || point[b] > high[b]) {
          continue;
        }
        hit.depth_m = t;
        hit.gray = room_pattern(first_surface + 2 * axis + (plane == high[axis] ? 1 : 0), point[a],
                                point[b]);
      }
    }
  };
  meet({-2.0, -1.5, -2.5}, {2.0, 1.5, 1.5}, 0);
  meet({0.1, -0.2, 0.3}, {0.7, 0.5, 0.8}, 6);
  return hit;
}

/// Renders colour (grey in three channels) and raw depth of frame `index`, without noise.
inline void render_room(int index, cv::Mat* color, cv::Mat* raw_depth) {
  const RgbdCamera camera = room_camera();
  const PinholeCamera& model = camera.camera;
  const Pose T_world_camera = room_pose(index);
  const Eigen::Vector3d origin = T_world_camera.translation();
  const Eigen::Matrix3d rotation = T_world_camera.linear();
  color->create(model.height_px, model.width_px, CV_8UC3);
  raw_depth->create(model.height_px, model.width_px, CV_16UC1);
  const auto cast = [&](double u_px, double v_px) {
    const Eigen::Vector3d ray((u_px - model.cx_px) / model.fx_px,
                              (v_px - model.cy_px) / model.fy_px, 1.0);
    return room_hit(origin, rotation * ray);
  };
  for (int v = 0; v < model.height_px; ++v) {
    for (int u = 0; u < model.width_px; ++u) {
      double gray = 0.0;
      for (const double dv : {-0.25, 0.25}) {
        for (const double du : {-0.25, 0.25}) gray += 0.25 * cast(u + du, v + dv).gray;
      }
      const auto level = static_cast<std::uint8_t>(std::clamp(std::lround(gray), 0L, 255L));
      color->at<cv::Vec3b>(v, u) = cv::Vec3b(level, level, level);
      raw_depth->at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(std::lround(cast(u, v).depth_m * camera.depth_units_per_m));
    }
  }
}

inline std::string room_timestamp(int index) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6f", 1000.0 + kRoomFrameInterval_s * index);
  return text;
}

inline std::string image_file(const std::string& folder, const std::string& stamp) {
  return folder + "/" + stamp + ".png";
}

/// A dataset of `num_frames` frames with ground truth, detections and camera.yaml.
inline void write_room_dataset(const std::string& folder, int num_frames) {
  std::string rgb = "# color images\n";
  std::string depth = "# depth maps\n";
  std::string detections = "# srslam detections v1\n";
  Trajectory groundtruth;
  const std::string prefix = folder + "/";
  for (int i = 0; i < num_frames; ++i) {
    const std::string stamp = room_timestamp(i);
    cv::Mat color;
    cv::Mat raw_depth;
    render_room(i, &color, &raw_depth);
    const std::string color_file = image_file("rgb", stamp);
    const std::string depth_file = image_file("depth", stamp);
    write_image(prefix + color_file, color);
    write_image(prefix + depth_file, raw_depth);
    rgb.append(stamp).append(" ").append(color_file).append("\n");
    depth.append(stamp).append(" ").append(depth_file).append("\n");
    detections.append(stamp).append(" none\n");
    groundtruth.push_back({1000.0 + kRoomFrameInterval_s * i, room_pose(i)});
  }
  write_text(folder + "/rgb.txt", rgb);
  write_text(folder + "/depth.txt", depth);
  write_text(folder + "/detections.txt", detections);
  FileStatus status = write_trajectory(folder + "/groundtruth.txt", groundtruth, "");
  ASSERT_TRUE(status.ok()) << status.message();
  status = write_camera_file(folder + "/camera.yaml", room_camera());
  ASSERT_TRUE(status.ok()) << status.message();
}

// ---- The program --------------------------------------------------------------------------------

/// How a run of the program ended and what it printed.
struct ProgramResult {
  int exit_code = -1;  ///< -1: ended by a signal that it did not handle
  int signal_number = 0;
  std::string out;
  std::string err;

  bool says(const std::string& text) const {
    return out.find(text) != std::string::npos || err.find(text) != std::string::npos;
  }
};

/// Path of the program, from the environment variable SRSLAM_PROGRAM; empty when it is not set.
inline std::string program_path() {
  const char* path = std::getenv("SRSLAM_PROGRAM");
  return path == nullptr ? std::string() : std::string(path);
}

/// The program started with `arguments` in `folder`, where its output goes too.
class Program {
 public:
  Program(const std::vector<std::string>& arguments, const std::string& folder,
          const std::string& path_variable = {})
      : out_file_(folder + "/stdout.txt"), err_file_(folder + "/stderr.txt") {
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), program_path());
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    std::vector<std::string> variables;
    for (char** variable = environ; *variable != nullptr; ++variable) {
      const std::string text = *variable;
      if (path_variable.empty() || text.compare(0, 5, "PATH=") != 0) variables.push_back(text);
    }
    if (!path_variable.empty()) variables.push_back("PATH=" + path_variable);
    std::vector<char*> envp;
    envp.reserve(variables.size() + 1);
    for (std::string& variable : variables) envp.push_back(variable.data());
    envp.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_file_.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_file_.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    const int error =
        posix_spawn(&child_, words.front().c_str(), &actions, nullptr, argv.data(), envp.data());
    posix_spawn_file_actions_destroy(&actions);
    EXPECT_EQ(error, 0) << "cannot start " << words.front() << ": " << std::strerror(error);
  }

  void send(int signal_number) const { ::kill(child_, signal_number); }

  ProgramResult wait() {
    ProgramResult result;
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) result.signal_number = WTERMSIG(status);
    result.out = read_text(out_file_);
    result.err = read_text(err_file_);
    return result;
  }

 private:
  std::string out_file_;
  std::string err_file_;
  pid_t child_ = 0;
};

inline ProgramResult run_program(const std::vector<std::string>& arguments,
                                 const std::string& folder) {
  return Program(arguments, folder).wait();
}

}  // namespace srslam::test
