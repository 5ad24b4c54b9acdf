#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/core/camera.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/pose.hpp"
#include "synthetic/scene.hpp"

namespace srslam::detail {

/// Index that stands for the room in PixelBuffers::part.
constexpr std::uint16_t kRoomPart = 0xffff;

/// What a camera sees, before the sensor.
struct PixelBuffers {
  ImageBuffer<Eigen::Vector3f> color;  ///< blue, green, red, 0 to 255
  ImageBuffer<float> depth_m;          ///< along the optical axis; 0 where nothing is seen
  ImageBuffer<float> cosine;           ///< between the surface's normal and the ray
  ImageBuffer<std::uint16_t> part;     ///< index into Scene::parts, or kRoomPart
};

/// Casts rays. The picture of a scene and a pose does not depend on how it is cut into tiles, which
/// is there to try few parts a ray. Const calls are re-entrant, each with a workspace of its own.
class Renderer {
 public:
  struct Workspace {
    struct PosedPart {
      Eigen::Matrix3d unit_from_camera;  ///< turns a ray's direction into the part's unit frame
      Eigen::Vector3d origin;            ///< camera centre in the unit frame
      Eigen::Matrix3d R_world_part;
      double near_m = 0.0;  ///< no point of the part has less depth
      bool in_view = false;
      double x_min = 0.0, x_max = 0.0, y_min = 0.0, y_max = 0.0;  ///< normalised, around all of it
    };
    struct ShadowSphere {
      Eigen::Vector3f center_m;  ///< world
      float radius_m = 0.0F;
      int part = 0;
    };
    struct ShadowGroup {  ///< of one body, with a sphere around what they reach
      Eigen::Vector3f center_m;
      float reach_m = 0.0F;
      std::size_t begin = 0, end = 0;
    };
    Eigen::Vector3d room_origin;  ///< camera centre in the room's unit frame
    Eigen::Matrix3d room_from_camera;
    std::vector<Pose> T_world_part;
    std::vector<PosedPart> posed;
    std::vector<std::vector<std::uint16_t>> tiles;  ///< parts that may be seen, nearest first
    std::vector<std::uint16_t> by_depth;
    std::vector<ShadowSphere> spheres;
    std::vector<ShadowGroup> groups;
    std::vector<std::uint8_t> faces;            ///< face hit at each pixel
    std::vector<Eigen::Vector3f> center_color;  ///< what the ray through each pixel's centre sees
  };

  /// `scene` must outlive the renderer. `camera` must be valid.
  Renderer(const Scene* scene, const PinholeCamera& camera);

  const PinholeCamera& camera() const { return camera_; }

  /// Pixel centres decide depth and part; colour is averaged over the pixel where parts meet.
  /// `try_all_parts` tests every part at every pixel: slow, and the same picture.
  void render(double time_s, const Pose& T_world_camera, PixelBuffers* buffers,
              Workspace* workspace, bool try_all_parts = false) const;

  /// Direction with z = 1 of the ray through a pixel (0, 0, 0 outside the lens model's domain).
  const Eigen::Vector3d& ray(int u_px, int v_px) const {
    return rays_[static_cast<std::size_t>(v_px) * static_cast<std::size_t>(camera_.width_px) +
                 static_cast<std::size_t>(u_px)];
  }

 private:
  struct Hit {
    double depth_m = 0.0;
    std::uint16_t part = kRoomPart;
  };
  void prepare(double time_s, const Pose& T_world_camera, bool try_all_parts,
               Workspace* workspace) const;
  void prepare_shadows(Workspace* workspace) const;
  void assign_tiles(bool try_all_parts, Workspace* workspace) const;
  Hit trace(const Eigen::Vector3d& direction, const std::vector<std::uint16_t>& candidates,
            const Workspace& workspace) const;
  const Shape& shape_of(const Hit& hit) const;
  /// What a ray hits, in the unit frame of its shape.
  static Eigen::Vector3d unit_point(const Eigen::Vector3d& direction, const Hit& hit,
                                    const Workspace& workspace);
  /// SurfacePoint::face of what a ray hits.
  int face_of(const Eigen::Vector3d& direction, const Hit& hit, const Workspace& workspace) const;
  Eigen::Vector3f shade(const Eigen::Vector3d& direction, const Hit& hit,
                        const Pose& T_world_camera, const Workspace& workspace, float* cosine,
                        std::uint8_t* face) const;
  float shadow(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal, int part,
               const Workspace& workspace) const;

  const Scene* scene_;
  PinholeCamera camera_;
  std::vector<Eigen::Vector3d> rays_;
  struct Bounds {
    double x_min, x_max, y_min, y_max;
  };
  int tile_columns_ = 0;
  int tile_rows_ = 0;
  std::vector<Bounds> tile_bounds_;  ///< normalised coordinates of each tile's rays
};

}  // namespace srslam::detail
