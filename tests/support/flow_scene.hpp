#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "srslam/core/camera.hpp"
#include "srslam/core/se3.hpp"
#include "srslam/scene/flow_track.hpp"
#include "support/rng.hpp"

namespace srslam::test {

/// A pinhole camera of this width with 4:3 images, about as wide as a Kinect's.
inline PinholeCamera flow_camera(int width_px = 640) {
  PinholeCamera camera;
  camera.width_px = width_px;
  camera.height_px = width_px * 3 / 4;
  camera.fx_px = 0.82 * width_px;
  camera.fy_px = 0.82 * width_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (camera.height_px - 1);
  return camera;
}

inline Pose flow_pose(double x, double y, double z, double rx, double ry, double rz) {
  Vector6 tangent;
  tangent << x, y, z, rx, ry, rz;
  return se3_exp(tangent);
}

/// What a camera tracks between two frames.
struct FlowScene {
  PinholeCamera camera = flow_camera();
  int num_tracks = 600;
  Pose T_current_reference = flow_pose(0.05, -0.02, 0.04, 0.01, 0.03, -0.02);
  /// Points on something nearer that moves by itself: their share, and the motion between the
  /// frames in the reference camera's frame.
  double mover_share = 0.0;
  Pose T_mover = flow_pose(-0.25, 0.0, 0.05, 0.0, 0.0, 0.0);
  double detected_share = 1.0;  ///< of the mover's points that lie in its box
  double noise_px = 0.2;        ///< uniform, in each direction
  double depth_noise = 0.0;     ///< normal, in sigmas of a structured-light camera (Nguyen 2012)
  std::uint64_t seed = 1;

  std::vector<FlowTrack> tracks() const {
    Rng rng(seed);
    std::vector<FlowTrack> tracks;
    tracks.reserve(static_cast<std::size_t>(num_tracks));
    while (static_cast<int>(tracks.size()) < num_tracks) {
      const bool moves = rng.uniform(0.0, 1.0) < mover_share;
      FlowTrack track;
      track.reference.u_px = float(rng.uniform(1.0, camera.width_px - 2.0));
      track.reference.v_px = float(rng.uniform(1.0, camera.height_px - 2.0));
      track.reference.depth_m = float(moves ? rng.uniform(1.0, 1.3) : rng.uniform(1.6, 4.5));
      track.reference.suspect = moves && rng.uniform(0.0, 1.0) < detected_share;
      Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
      if (!camera.unproject({double(track.reference.u_px), double(track.reference.v_px)},
                            double(track.reference.depth_m), &point_m)) {
        continue;
      }
      if (moves) point_m = T_mover * point_m;
      point_m = T_current_reference * point_m;
      Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
      if (!camera.project(point_m, &pixel)) continue;
      track.current.u_px = float(pixel.x() + rng.uniform(-noise_px, noise_px));
      track.current.v_px = float(pixel.y() + rng.uniform(-noise_px, noise_px));
      track.current.depth_m = float(point_m.z());
      if (depth_noise > 0.0) {
        for (FlowPoint* point : {&track.reference, &track.current}) {
          const double beyond_m = double(point->depth_m) - 0.4;
          point->depth_m +=
              float(depth_noise * (0.0012 + 0.0019 * beyond_m * beyond_m) * rng.normal());
        }
      }
      track.current.suspect = track.reference.suspect;
      track.alive = camera.in_image(pixel);
      tracks.push_back(track);
    }
    return tracks;
  }
};

/// How far two relative poses are apart, as the length of the tangent vector between them.
inline double pose_distance(const Pose& a, const Pose& b) {
  return se3_log(a * b.inverse()).norm();
}

}  // namespace srslam::test
