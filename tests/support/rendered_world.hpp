#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/camera.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/core/se3.hpp"

namespace srslam::test {

/// A static room with boxes in it, seen by a perfect RGB-D camera: exact depth, no noise, and a
/// texture that repeats nowhere. Every surface carries two grids of randomly grey cells, turned
/// against each other; cell borders are as soft as a pixel is wide, so that corners move smoothly
/// with the camera. All of it follows from the seed.
///
/// World: x right, y down, z forward, origin near the room's middle. The camera may move within
/// about 0.6 m of the origin.
class RenderedWorld {
 public:
  explicit RenderedWorld(std::uint64_t seed) : seed_(seed) {}

  /// Renders what a camera without distortion sees (coefficients of `camera` are ignored). Depth is
  /// along the optical axis [m] and valid everywhere.
  void render(const PinholeCamera& camera, const Pose& T_world_camera,
              ImageBuffer<std::uint8_t>* gray, ImageBuffer<float>* depth_m) const {
    gray->resize(camera.width_px, camera.height_px);
    depth_m->resize(camera.width_px, camera.height_px);
    const Eigen::Vector3d origin = T_world_camera.translation();
    const Eigen::Matrix3d R = T_world_camera.linear();
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = 0; u < camera.width_px; ++u) {
        // Unit length along the optical axis: the ray's parameter is depth.
        const Eigen::Vector3d ray = R * Eigen::Vector3d((u - camera.cx_px) / camera.fx_px,
                                                        (v - camera.cy_px) / camera.fy_px, 1.0);
        const Hit hit = cast(origin, ray);
        const Eigen::Vector3d point = origin + hit.depth_m * ray;
        const int axis = hit.surface / 2 % 3;
        const double cosine = std::max(0.2, std::abs(ray[axis]) / ray.norm());
        gray->view()(u, v) = texture(hit.surface, point[(axis + 1) % 3], point[(axis + 2) % 3],
                                     hit.depth_m / camera.fx_px / cosine);
        depth_m->view()(u, v) = static_cast<float>(hit.depth_m);
      }
    }
  }

  /// A smooth hand-held path at `time_s`; identity at 0. About 0.35 m/s and 15 degrees a second.
  static Pose path(double time_s) {
    Vector6 tangent;
    tangent << 0.35 * std::sin(0.9 * time_s), 0.12 * std::sin(1.3 * time_s),
        0.25 * (1.0 - std::cos(0.7 * time_s)), 0.10 * std::sin(0.8 * time_s),
        0.22 * std::sin(0.6 * time_s), 0.06 * std::sin(1.1 * time_s);
    Pose T_world_camera = Pose::Identity();
    T_world_camera.linear() = so3_exp(tangent.tail<3>());
    T_world_camera.translation() = tangent.head<3>();
    return T_world_camera;
  }

 private:
  struct Box {
    Eigen::Vector3d min_m;
    Eigen::Vector3d max_m;
  };
  struct Hit {
    double depth_m = std::numeric_limits<double>::infinity();
    int surface = 0;  ///< object * 6 + axis * 2 + side
  };

  Hit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d inverse = ray.cwiseInverse();
    Hit hit;
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const Eigen::Vector3d to_min = (boxes_[i].min_m - origin).cwiseProduct(inverse);
      const Eigen::Vector3d to_max = (boxes_[i].max_m - origin).cwiseProduct(inverse);
      int enter_axis = 0;
      int leave_axis = 0;
      const double enter = to_min.cwiseMin(to_max).maxCoeff(&enter_axis);
      const double leave = to_min.cwiseMax(to_max).minCoeff(&leave_axis);
      const bool room = i == 0;  // seen from inside
      const double depth_m = room ? leave : enter;
      if (depth_m >= hit.depth_m || (!room && (enter >= leave || enter <= 0.0))) continue;
      const int axis = room ? leave_axis : enter_axis;
      const bool positive = ray[axis] > 0.0;
      hit.depth_m = depth_m;
      hit.surface = static_cast<int>(i) * 6 + axis * 2 + (positive ? 1 : 0);
    }
    return hit;
  }

  std::uint8_t texture(int surface, double a_m, double b_m, double pixel_m) const {
    const double coarse =
        cells(surface, 0, 0.88 * a_m + 0.47 * b_m, 0.88 * b_m - 0.47 * a_m, 0.13, pixel_m);
    const double fine =
        cells(surface, 1, 0.96 * a_m - 0.28 * b_m, 0.96 * b_m + 0.28 * a_m, 0.055, pixel_m);
    return static_cast<std::uint8_t>(20.0 + 120.0 * coarse + 90.0 * fine);
  }

  /// In [0, 1]: grey of the cell that holds (a, b), blended with its neighbours across borders.
  double cells(int surface, int layer, double a_m, double b_m, double cell_m,
               double pixel_m) const {
    const double softness = std::min(1.0, pixel_m / cell_m);
    const auto split = [&](double position_m, std::int64_t* cell) {
      const double s = position_m / cell_m;
      const double floor = std::floor(s);
      *cell = static_cast<std::int64_t>(floor);
      return std::clamp((s - floor - 0.5) / softness + 0.5, 0.0, 1.0);
    };
    std::int64_t i = 0;
    std::int64_t j = 0;
    const double x = split(a_m, &i);
    const double y = split(b_m, &j);
    return (1.0 - y) *
               ((1.0 - x) * grey(surface, layer, i, j) + x * grey(surface, layer, i + 1, j)) +
           y * ((1.0 - x) * grey(surface, layer, i, j + 1) +
                x * grey(surface, layer, i + 1, j + 1));
  }

  double grey(int surface, int layer, std::int64_t i, std::int64_t j) const {
    std::uint64_t z =
        seed_ + 0x9E3779B97F4A7C15ULL * static_cast<std::uint64_t>(2 * surface + layer);
    z ^= static_cast<std::uint64_t>(i) * 0xD6E8FEB86659FD93ULL;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z ^= static_cast<std::uint64_t>(j) * 0xCA5A826395121157ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1.0p-53;
  }

  std::uint64_t seed_;
  std::array<Box, 4> boxes_ = {
      Box{{-2.1, -1.4, -1.6}, {2.2, 1.5, 2.9}},  // the room
      Box{{-1.1, 0.25, 1.7}, {-0.35, 1.5, 2.3}},
      Box{{0.45, -0.15, 1.5}, {0.95, 1.5, 2.0}},
      Box{{-0.3, -0.95, 2.1}, {0.5, -0.45, 2.6}},
  };
};

/// One rendered frame with its truth.
struct RenderedFrame {
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();
  ImageBuffer<std::uint8_t> gray;
  ImageBuffer<float> depth_m;
};

/// The first `num_frames` frames of RenderedWorld::path() at 30 Hz, time stamps from `start_s`.
inline std::vector<RenderedFrame> render_path(const RenderedWorld& world,
                                              const PinholeCamera& camera, int num_frames,
                                              double start_s = 100.0) {
  std::vector<RenderedFrame> frames(static_cast<std::size_t>(num_frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double time_s = static_cast<double>(i) / 30.0;
    frames[i].timestamp_s = start_s + time_s;
    frames[i].T_world_camera = RenderedWorld::path(time_s);
    world.render(camera, frames[i].T_world_camera, &frames[i].gray, &frames[i].depth_m);
  }
  return frames;
}

}  // namespace srslam::test
