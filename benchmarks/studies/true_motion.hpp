#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/synthetic/synthetic_world.hpp"

namespace srslam::studies {

/// How far what each pixel of a rendered sequence shows has moved by itself since the frame before:
/// its true flow less that of a rigid scene. The world is built again from the scenario.json of the
/// sequence, since the files hold no flow back in time.
class TrueMotion {
 public:
  /// Empty, or why `folder` cannot be rendered again.
  std::string open(const std::string& folder, const RgbdCamera& camera) {
    const std::string file = (std::filesystem::path(folder) / "scenario.json").string();
    if (!std::filesystem::exists(file)) {
      return file + ": is not there; take a sequence of `srslam synth`";
    }
    const cv::FileStorage storage(file, cv::FileStorage::READ | cv::FileStorage::FORMAT_JSON);
    const auto version = static_cast<int>(storage["world_version"]);
    if (version != kSyntheticWorldVersion) {
      return file + ": world_version is " + std::to_string(version) + ", this program renders " +
             std::to_string(kSyntheticWorldVersion) + "; render the sequence again";
    }
    SyntheticOptions options;
    options.scenario = static_cast<std::string>(storage["scenario"]);
    options.seed = static_cast<std::uint64_t>(static_cast<double>(storage["seed"]));
    options.num_frames = static_cast<std::size_t>(static_cast<int>(storage["num_frames"]));
    options.camera = camera;
    options.sensor.clean = true;  // only geometry is asked for
    const FileStatus created = world_.create(options);
    if (!created.ok()) return created.message();
    renderer_.emplace(world_);
    return {};
  }

  double timestamp_s(std::size_t index) const { return world_.timestamp_s(index); }

  /// Renders frame `index` > 0 and finds the mover of each pixel and its motion [px], NaN where
  /// that leads out of the camera's domain.
  Status measure(std::size_t index) {
    Status status = renderer_->render(index, &frame_);
    if (status.ok()) status = renderer_->flow_to(index - 1, &flow_px_);
    if (!status.ok()) return status;
    const PinholeCamera& camera = world_.options().camera.camera;
    const Pose T_previous_current =
        world_.T_world_camera(index - 1).inverse() * frame_.T_world_camera;
    motion_px_.resize(camera.width_px, camera.height_px);
    for (int v = 0; v < camera.height_px; ++v) {
      for (int u = 0; u < camera.width_px; ++u) {
        float& motion_px = motion_px_.view()(u, v);
        motion_px = 0.0F;
        if (frame_.instances.view()(u, v) == 0) continue;
        Eigen::Vector3d point_m;
        Eigen::Vector2d rigid_px;
        const auto depth_m = double(frame_.true_depth_m.view()(u, v));
        motion_px = camera.unproject({double(u), double(v)}, depth_m, &point_m) &&
                            camera.project(T_previous_current * point_m, &rigid_px)
                        ? (flow_px_.view()(u, v).cast<double>() + Eigen::Vector2d(u, v) - rigid_px)
                              .cast<float>()
                              .norm()
                        : std::numeric_limits<float>::quiet_NaN();
      }
    }
    return status;
  }

  /// Pixel of the surface to which a corner belongs that is seen within `radius_px` of (u, v): the
  /// nearest one to the camera if there is a step in depth, else that of its own pixel.
  Eigen::Vector2i owner_of(float u_px, float v_px, float radius_px) const {
    constexpr float kStep = 0.95F;  // of the depth
    const ImageView<const float> depth_m = frame_.true_depth_m.view();
    const Eigen::Vector2i own(std::clamp(cvRound(u_px), 0, depth_m.width_px - 1),
                              std::clamp(cvRound(v_px), 0, depth_m.height_px - 1));
    const int reach = static_cast<int>(radius_px);
    Eigen::Vector2i nearest = own;
    for (int v = own.y() - reach; v <= own.y() + reach; ++v) {
      for (int u = own.x() - reach; u <= own.x() + reach; ++u) {
        if (u < 0 || v < 0 || u >= depth_m.width_px || v >= depth_m.height_px) continue;
        const Eigen::Vector2i offset = Eigen::Vector2i(u, v) - own;
        if (float(offset.squaredNorm()) > radius_px * radius_px || !(depth_m(u, v) > 0.0F))
          continue;
        if (!(depth_m(nearest.x(), nearest.y()) <= depth_m(u, v))) nearest = {u, v};
      }
    }
    const bool step = depth_m(nearest.x(), nearest.y()) < kStep * depth_m(own.x(), own.y());
    return step ? nearest : own;
  }

  ImageView<const std::uint8_t> instances() const { return frame_.instances.view(); }
  ImageView<const float> motion_px() const { return motion_px_.view(); }

 private:
  SyntheticWorld world_;
  std::optional<SyntheticRenderer> renderer_;
  SyntheticFrame frame_;
  ImageBuffer<Eigen::Vector2f> flow_px_;
  ImageBuffer<float> motion_px_;
};

}  // namespace srslam::studies
