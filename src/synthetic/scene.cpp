#include "synthetic/scene.hpp"

#include <algorithm>
#include <utility>

namespace srslam::detail {

int Scene::add_texture(Texture texture) {
  textures.push_back(std::move(texture));
  return static_cast<int>(textures.size()) - 1;
}

int Scene::add_material(int texture) {
  Material material;
  material.textures.fill(texture);
  materials.push_back(material);
  return static_cast<int>(materials.size()) - 1;
}

int Scene::add_object(const std::string& class_name, bool moves) {
  SceneObject object;
  object.class_name = class_name;
  object.moves = moves;
  if (moves) {
    object.instance =
        1 + static_cast<int>(std::count_if(objects.begin(), objects.end(),
                                           [](const SceneObject& other) { return other.moves; }));
  }
  objects.push_back(object);
  return static_cast<int>(objects.size()) - 1;
}

void Scene::add_static(const Part& part, const Pose& T_world_part_in) {
  parts.push_back(part);
  T_world_part.push_back(T_world_part_in);
}

void Scene::add_body(const std::vector<Part>& body_parts, int object,
                     std::unique_ptr<BodyMotion> motion) {
  Body body;
  body.first_part = parts.size();
  body.num_parts = body_parts.size();
  body.object = object;
  body.motion = std::move(motion);
  for (const Part& part : body_parts) {
    parts.push_back(part);
    parts.back().object = object;
    T_world_part.push_back(Pose::Identity());
  }
  bodies.push_back(std::move(body));
}

void Scene::poses_at(double time_s, std::vector<Pose>* T_world_part_at) const {
  *T_world_part_at = T_world_part;
  for (const Body& body : bodies) {
    body.motion->poses(time_s, T_world_part_at->data() + body.first_part);
  }
}

}  // namespace srslam::detail
