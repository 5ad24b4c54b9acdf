#include "synthetic/room.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "synthetic/constants.hpp"
#include "synthetic/random.hpp"

namespace srslam::detail {
namespace {

Pose placed(double x_m, double y_m, double z_m, double yaw_rad = 0.0) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x_m, y_m, z_m);
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

/// Puts furniture into the scene.
class Furnisher {
 public:
  Furnisher(std::uint64_t seed, bool low_texture, TexturePainter* painter, Scene* scene)
      : random_(seed, 41), low_texture_(low_texture), painter_(*painter), scene_(*scene) {}

  void build_shell() {
    scene_.room.kind = ShapeKind::kBox;
    scene_.room.scale_m = {kRoomHalfX_m, 0.5 * (kRoomMaxY_m - kRoomMinY_m), 0.5 * kRoomHeight_m};
    scene_.T_world_room = placed(0.0, 0.5 * (kRoomMaxY_m + kRoomMinY_m), 0.5 * kRoomHeight_m);
    const double depth_m = kRoomMaxY_m - kRoomMinY_m;
    const float contrast = low_texture_ ? 2.0F : 13.0F;
    const Color paint(196.0F, 205.0F, 208.0F);
    const int left = texture(painter_.plaster(depth_m, kRoomHeight_m, paint, contrast));
    const int right = texture(painter_.plaster(depth_m, kRoomHeight_m, paint, contrast));
    const int front = texture(painter_.plaster(2.0 * kRoomHalfX_m, kRoomHeight_m, paint, contrast));
    const int back = texture(painter_.plaster(2.0 * kRoomHalfX_m, kRoomHeight_m, paint, contrast));
    const int floor =
        low_texture_
            ? texture(painter_.plaster(2.0 * kRoomHalfX_m, depth_m, Color(112, 118, 120), 2.5F))
            : texture(painter_.carpet(2.0 * kRoomHalfX_m, depth_m, Color(105, 98, 92)));
    const int ceiling = texture(
        painter_.plaster(2.0 * kRoomHalfX_m, depth_m, Color(222, 222, 220), 0.5F * contrast));
    scene_.room_material.textures = {left, right, back, front, floor, ceiling};
    scene_.lamps = {{{-1.5, 0.2, 2.6}, 1.0F}, {{1.7, 1.0, 2.6}, 0.9F}, {{0.2, -2.0, 2.6}, 0.7F}};
  }

  /// A flat thing on a wall whose normal points along `yaw` (0: +x).
  void hang(int front_texture, double width_m, double height_m, const Eigen::Vector3d& center_m,
            double yaw_rad) {
    Part part;
    part.shape = box_shape({0.02, width_m, height_m});
    Material material;
    material.textures.fill(frame_texture());
    material.textures[1] = front_texture;
    part.material = add(material);
    scene_.add_static(part, placed(center_m.x(), center_m.y(), center_m.z(), yaw_rad));
  }

  void box(int material, const Eigen::Vector3d& size_m, const Pose& pose, int object = kNoObject) {
    Part part;
    part.shape = box_shape(size_m);
    part.material = material;
    part.object = object;
    part.texture_offset_m = {random_.uniform(0.0, 0.6), random_.uniform(0.0, 0.4)};
    scene_.add_static(part, pose);
  }

  void desk(const Pose& pose, const Eigen::Vector2d& size_m) {
    const int wood = low_texture_ ? solid(painter_.plaster(1.0, 1.0, Color(150, 165, 175), 2.0F))
                                  : solid(painter_.wood(2.0, 1.2, Color(92, 128, 168)));
    const int steel = solid(painter_.metal(0.8, 0.8, Color(95, 95, 95)));
    box(wood, {size_m.x(), size_m.y(), 0.035}, pose * placed(0.0, 0.0, kDeskHeight_m - 0.0175));
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        box(steel, {0.05, 0.05, kDeskHeight_m - 0.035},
            pose * placed(x * (0.5 * size_m.x() - 0.06), y * (0.5 * size_m.y() - 0.06),
                          0.5 * (kDeskHeight_m - 0.035)));
      }
    }
    // A panel behind the knees.
    box(wood, {size_m.x() - 0.2, 0.02, 0.35},
        pose * placed(0.0, 0.35 * size_m.y(), kDeskHeight_m - 0.22));
  }

  void monitor(const Pose& desk_pose, double x_m, double y_m, double yaw_rad) {
    const int object = scene_.add_object("tv", false);
    const int dark = solid(painter_.plaster(0.5, 0.5, Color(38, 36, 36), 8.0F));
    const Pose pose = desk_pose * placed(x_m, y_m, kDeskHeight_m, yaw_rad);
    Part panel;
    panel.shape = box_shape({0.54, 0.035, 0.34});
    Material material;
    material.textures.fill(scene_.materials[static_cast<std::size_t>(dark)].textures[0]);
    material.textures[2] =
        texture(low_texture_ ? painter_.plain(Color(60, 55, 50)) : painter_.screen(0.54, 0.34));
    panel.material = add(material);
    panel.object = object;
    scene_.add_static(panel, pose * placed(0.0, 0.0, 0.30));
    box(dark, {0.05, 0.04, 0.16}, pose * placed(0.0, 0.02, 0.08), object);
    box(dark, {0.24, 0.18, 0.015}, pose * placed(0.0, 0.02, 0.008), object);
  }

  void flat(Texture picture, const Eigen::Vector3d& size_m, const Pose& pose) {
    Part part;
    part.shape = box_shape(size_m);
    part.material = solid(std::move(picture));
    scene_.add_static(part, pose);
  }

  void clutter(const Pose& desk_pose, const Eigen::Vector2d& size_m) {
    const double keyboard_yaw_rad = random_.uniform(-0.15, 0.15);
    const double keyboard_x_m = random_.uniform(-0.35, -0.2);
    flat(painter_.keyboard(0.44, 0.14), {0.44, 0.14, 0.022},
         desk_pose * placed(keyboard_x_m, -0.22, kDeskHeight_m + 0.011, keyboard_yaw_rad));
    if (low_texture_) return;
    for (int i = 0; i < 5; ++i) {
      const double thickness_m = 0.002 + 0.001 * i;  // no two lie in the same plane
      const double yaw_rad = random_.uniform(0.0, 2.0 * kPi);
      const double y_m = random_.uniform(-0.35, 0.1) * size_m.y();
      const double x_m = random_.uniform(-0.45, 0.45) * size_m.x();
      flat(painter_.sheet(0.21, 0.297), {0.21, 0.297, thickness_m},
           desk_pose * placed(x_m, y_m, kDeskHeight_m + 0.5 * thickness_m, yaw_rad));
    }
    for (int i = 0; i < 3; ++i) {
      Part mug;
      const double mug_height_m = random_.uniform(0.09, 0.14);
      mug.shape = cylinder_shape(random_.uniform(0.035, 0.045), mug_height_m);
      mug.material = solid(painter_.cloth(0.3, 0.15, random_color(), i));
      const double y_m = random_.uniform(-0.4, 0.3) * size_m.y();
      const double x_m = random_.uniform(-0.42, 0.42) * size_m.x();
      scene_.add_static(mug, desk_pose * placed(x_m, y_m, kDeskHeight_m + mug.shape.scale_m.z()));
    }
    double top_m = kDeskHeight_m;
    const double pile_x_m = random_.uniform(0.28, 0.40) * size_m.x();
    for (int i = 0; i < 4; ++i) {
      const double book_z_m = random_.uniform(0.02, 0.05);
      const double book_y_m = random_.uniform(0.22, 0.29);
      const Eigen::Vector3d book_m(random_.uniform(0.16, 0.22), book_y_m, book_z_m);
      flat(
          painter_.book(book_m.x(), book_m.y()), book_m,
          desk_pose * placed(pile_x_m, 0.05, top_m + 0.5 * book_m.z(), random_.uniform(-0.4, 0.4)));
      top_m += book_m.z();
    }
  }

  void shelves(const Pose& pose, double width_m) {
    const int wood = low_texture_ ? solid(painter_.plaster(1.0, 1.0, Color(170, 180, 185), 2.0F))
                                  : solid(painter_.wood(2.0, 0.6, Color(120, 150, 180)));
    constexpr double kDepth_m = 0.32;
    constexpr double kHeight_m = 1.95;
    box(wood, {width_m, 0.015, kHeight_m}, pose * placed(0.0, 0.5 * kDepth_m, 0.5 * kHeight_m));
    for (const double side : {-1.0, 1.0}) {
      box(wood, {0.025, kDepth_m, kHeight_m},
          pose * placed(side * 0.5 * width_m, 0.0, 0.5 * kHeight_m));
    }
    for (int level = 0; level < 5; ++level) {
      const double z_m = 0.08 + 0.44 * level;
      box(wood, {width_m, kDepth_m, 0.025}, pose * placed(0.0, 0.0, z_m));
      if (level == 4 || low_texture_) continue;
      double x_m = -0.5 * width_m + 0.05;
      while (x_m < 0.5 * width_m - 0.12) {
        if (random_.chance(0.08)) {
          x_m += random_.uniform(0.06, 0.2);
          continue;
        }
        const double book_z_m = random_.uniform(0.2, 0.34);
        const double book_y_m = random_.uniform(0.18, 0.26);
        const Eigen::Vector3d book_m(random_.uniform(0.025, 0.085), book_y_m, book_z_m);
        flat(painter_.book(book_m.x(), book_m.z()), book_m,
             pose * placed(x_m + 0.5 * book_m.x(), random_.uniform(-0.05, 0.02),
                           z_m + 0.0125 + 0.5 * book_m.z()));
        x_m += book_m.x() + 0.002;
      }
    }
  }

  void cardboard_boxes() {
    const int plain = solid(painter_.cardboard(1.2, 1.0, false));
    struct Place {
      double x_m, y_m, z_m, yaw_rad;
      Eigen::Vector3d size_m;
    };
    const Place places[] = {{2.45, 2.65, 0.24, 0.2, {0.62, 0.5, 0.48}},
                            {2.50, 2.70, 0.68, -0.25, {0.5, 0.42, 0.40}},
                            {2.95, 1.65, 0.21, 0.7, {0.55, 0.45, 0.42}},
                            {-1.55, 2.85, 0.17, 0.1, {0.45, 0.38, 0.34}},
                            {1.75, 2.85, 0.26, -0.1, {0.42, 0.36, 0.52}}};
    for (const Place& place : places) {
      Part part;
      part.shape = box_shape(place.size_m);
      part.material = low_texture_ ? plain : solid(painter_.cardboard(0.7, 0.6, true));
      scene_.add_static(part, placed(place.x_m, place.y_m, place.z_m, place.yaw_rad));
    }
  }

  void posters() {
    if (low_texture_) return;
    const double y = kRoomMaxY_m - 0.01;
    // Facing -y, into the room.
    for (const double x : {-2.6, -1.55, -0.62, 0.55, 1.5, 2.55}) {
      const double width_m = random_.uniform(0.55, 0.75);
      const double height_m = random_.uniform(0.75, 0.95);
      hang(texture(painter_.poster(width_m, height_m)), width_m, height_m,
           {x + random_.uniform(-0.08, 0.08), y, random_.uniform(1.5, 1.75)}, -0.5 * kPi);
    }
    for (const double along : {-2.2, -0.9, 0.5, 1.4}) {
      hang(texture(painter_.poster(0.7, 0.9)), 0.7, 0.9,
           {kRoomHalfX_m - 0.01, along, random_.uniform(1.4, 1.7)}, kPi);
    }
    for (const double along : {-2.4, -1.2, 0.0}) {
      hang(texture(painter_.poster(0.8, 0.6)), 0.8, 0.6,
           {-kRoomHalfX_m + 0.01, along, random_.uniform(1.4, 1.7)}, 0.0);
    }
    for (const double x : {-2.0, -0.4, 1.6}) {
      hang(texture(painter_.poster(0.7, 0.9)), 0.7, 0.9, {x, kRoomMinY_m + 0.01, 1.6}, 0.5 * kPi);
    }
  }

  void chair(const Pose& pose, std::uint64_t seed) {
    const int object = scene_.add_object("chair", false);
    Chair chair = make_chair(seed, &painter_, &scene_);
    for (std::size_t i = 0; i < chair.parts.size(); ++i) {
      chair.parts[i].object = object;
      chair.parts[i].shadow_radius_m = 0.0;
      scene_.add_static(chair.parts[i], pose * chair.T_chair_part[i]);
    }
  }

  void cabinet(const Pose& pose) {
    Part body;
    body.shape = box_shape({0.8, 0.42, 1.15});
    Material material;
    material.textures.fill(texture(painter_.metal(1.2, 1.2, Color(150, 155, 152))));
    body.material = add(material);
    scene_.add_static(body, pose * placed(0.0, 0.0, 0.575));
    if (low_texture_) return;
    const int handle = solid(painter_.plaster(0.1, 0.1, Color(50, 50, 50), 10.0F));
    for (const double z : {0.3, 0.65, 1.0}) {
      box(handle, {0.18, 0.02, 0.025}, pose * placed(0.0, -0.22, z));
      flat(painter_.sheet(0.12, 0.08), {0.12, 0.01, 0.08}, pose * placed(0.22, -0.212, z));
    }
    flat(painter_.cardboard(0.4, 0.3, true), {0.4, 0.3, 0.25},
         pose * placed(-0.1, 0.0, 1.275, 0.2));
  }

  double chance_yaw(double spread_rad) { return random_.uniform(-spread_rad, spread_rad); }
  std::uint64_t seed() { return random_.bits(); }

 private:
  int texture(Texture made) { return scene_.add_texture(std::move(made)); }
  int solid(Texture made) { return scene_.add_material(texture(std::move(made))); }
  int add(const Material& material) {
    scene_.materials.push_back(material);
    return static_cast<int>(scene_.materials.size()) - 1;
  }
  int frame_texture() {
    if (frame_texture_ < 0) frame_texture_ = texture(painter_.plain(Color(60, 62, 66)));
    return frame_texture_;
  }
  Color random_color() {
    return {static_cast<float>(random_.uniform(30.0, 220.0)),
            static_cast<float>(random_.uniform(30.0, 220.0)),
            static_cast<float>(random_.uniform(30.0, 220.0))};
  }

  RandomStream random_;
  bool low_texture_;
  TexturePainter& painter_;
  Scene& scene_;
  int frame_texture_ = -1;
};

}  // namespace

Chair make_chair(std::uint64_t seed, TexturePainter* painter, Scene* scene) {
  RandomStream random(seed, 51);
  const auto material = [&](Texture texture) {
    return scene->add_material(scene->add_texture(std::move(texture)));
  };
  const float red = static_cast<float>(random.uniform(40.0, 150.0));
  const float green = static_cast<float>(random.uniform(40.0, 130.0));
  const float blue = static_cast<float>(random.uniform(40.0, 150.0));
  const Color color(blue, green, red);
  const int fabric = material(painter->cloth(0.9, 0.9, color, 2));
  const int dark = material(painter->plaster(0.4, 0.4, Color(48.0F, 46.0F, 45.0F), 12.0F));
  Chair chair;
  const auto add = [&](const Shape& shape, int part_material, const Pose& pose,
                       double shadow_radius_m) {
    Part part;
    part.shape = shape;
    part.material = part_material;
    part.shadow_radius_m = shadow_radius_m;
    chair.parts.push_back(part);
    chair.T_chair_part.push_back(pose);
  };
  add(box_shape({0.46, 0.46, 0.08}), fabric, placed(0.0, 0.0, 0.46), 0.2);
  add(box_shape({0.42, 0.07, 0.48}), fabric, placed(0.0, -0.23, 0.80), 0.15);
  add(box_shape({0.06, 0.04, 0.30}), dark, placed(0.0, -0.24, 0.52), 0.0);
  add(cylinder_shape(0.03, 0.36), dark, placed(0.0, 0.0, 0.25), 0.06);
  for (int i = 0; i < 5; ++i) {
    const double yaw_rad = 2.0 * kPi * i / 5.0 + 0.3;
    const Pose leg = placed(0.0, 0.0, 0.07, yaw_rad);
    add(box_shape({0.30, 0.04, 0.03}), dark, leg * placed(0.15, 0.0, 0.0), 0.06);
    add(ellipsoid_shape({0.03, 0.02, 0.03}), dark, leg * placed(0.29, 0.0, -0.04), 0.03);
  }
  return chair;
}

void furnish_room(std::uint64_t seed, bool low_texture, TexturePainter* painter, Scene* scene) {
  Furnisher furnisher(seed, low_texture, painter, scene);
  furnisher.build_shell();
  const Pose desk = placed(kDeskX_m, kDeskY_m, 0.0);
  furnisher.desk(desk, {1.9, 0.85});
  furnisher.monitor(desk, -0.42, 0.18, 0.12 + furnisher.chance_yaw(0.08));
  furnisher.monitor(desk, 0.22, 0.20, -0.12 + furnisher.chance_yaw(0.08));
  furnisher.clutter(desk, {1.9, 0.85});
  const Pose side_desk = placed(-2.75, 1.55, 0.0, 0.5 * kPi);
  furnisher.desk(side_desk, {1.5, 0.75});
  furnisher.monitor(side_desk, 0.1, 0.15, furnisher.chance_yaw(0.3));
  furnisher.clutter(side_desk, {1.5, 0.75});
  furnisher.shelves(placed(kRoomHalfX_m - 0.2, -0.6, 0.0, -0.5 * kPi), 1.5);
  furnisher.shelves(placed(-kRoomHalfX_m + 0.2, -0.9, 0.0, 0.5 * kPi), 1.5);
  furnisher.cabinet(placed(-0.95 - 1.1, kRoomMaxY_m - 0.25, 0.0));
  furnisher.cardboard_boxes();
  furnisher.posters();
  furnisher.chair(placed(1.55, 2.05, 0.0, 0.9 + furnisher.chance_yaw(0.3)), furnisher.seed());
  furnisher.chair(placed(-1.65, 1.95, 0.0, -0.7 + furnisher.chance_yaw(0.3)), furnisher.seed());
}

}  // namespace srslam::detail
