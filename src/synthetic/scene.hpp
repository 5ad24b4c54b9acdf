#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "srslam/core/pose.hpp"
#include "synthetic/shape.hpp"
#include "synthetic/texture.hpp"

namespace srslam::detail {

constexpr int kNoObject = -1;

/// Textures of a surface: one a face for a box (-x +x -y +y -z +z), the first for everything else.
struct Material {
  std::array<int, 6> textures{};
};

/// A rigid piece of the world.
struct Part {
  Shape shape;
  int material = 0;
  int object = kNoObject;  ///< index into Scene::objects
  Eigen::Vector2d texture_offset_m = Eigen::Vector2d::Zero();
  /// Radius of the sphere that stands for the part where it darkens what is near it; 0: does not.
  double shadow_radius_m = 0.0;
};

/// Something with a name: what masks and detections tell apart.
struct SceneObject {
  std::string class_name;  ///< a detector's label, such as "person"
  bool moves = false;
  int instance = 0;  ///< value in the mask, 1 to 255; 0 for what stands still
};

/// Gives the parts of one body their poses at any time.
class BodyMotion {
 public:
  BodyMotion() = default;
  BodyMotion(const BodyMotion&) = delete;
  BodyMotion& operator=(const BodyMotion&) = delete;
  virtual ~BodyMotion() = default;
  /// T_world_part of the body's parts, in the order in which they were added to the scene.
  virtual void poses(double time_s, Pose* T_world_part) const = 0;
  /// What the body does, for the description of the sequence.
  virtual std::string description() const = 0;
};

struct Body {
  std::size_t first_part = 0;
  std::size_t num_parts = 0;
  int object = kNoObject;
  std::unique_ptr<BodyMotion> motion;
};

struct Lamp {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  float strength = 1.0F;
};

/// Everything there is to see. World frame: z up, the floor at z = 0 [m].
struct Scene {
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Part> parts;
  std::vector<Pose> T_world_part;  ///< of the parts that stand still
  std::vector<SceneObject> objects;
  std::vector<Body> bodies;  ///< what moves
  std::vector<Lamp> lamps;
  Shape room;  ///< a box seen from inside
  Pose T_world_room = Pose::Identity();
  Material room_material;

  int add_texture(Texture texture);
  /// One texture on all faces.
  int add_material(int texture);
  int add_object(const std::string& class_name, bool moves);
  /// A part that stands still.
  void add_static(const Part& part, const Pose& T_world_part_in);
  /// Parts that move together as `motion` says.
  void add_body(const std::vector<Part>& body_parts, int object,
                std::unique_ptr<BodyMotion> motion);

  /// T_world_part of every part at a time.
  void poses_at(double time_s, std::vector<Pose>* T_world_part_at) const;
};

}  // namespace srslam::detail
