#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "srslam/core/se3.hpp"
#include "synthetic/constants.hpp"
#include "synthetic/ground_path.hpp"
#include "synthetic/person.hpp"
#include "synthetic/rigid_motion.hpp"
#include "synthetic/room.hpp"
#include "synthetic/scenario_recipe.hpp"
#include "synthetic/texture_painter.hpp"

namespace srslam::detail {

inline constexpr CameraPath::Tremor kHandHeld{0.004, 0.006};
inline constexpr CameraPath::Tremor kHeldStill{0.0008, 0.0008};
inline constexpr CameraPath::Tremor kTripod{0.0, 0.0};
inline const Eigen::Vector3d kStandpoint_m(0.0, 0.0, 1.36);
inline const Eigen::Vector3d kDeskTarget_m(0.05, 2.5, 0.98);

/// Where a scenario is set up: the furnished room, the camera's way, and who and what moves. Each
/// call adds something; the order decides which random numbers it gets.
class ScenarioStage {
 public:
  ScenarioStage(std::uint64_t seed, double duration_s, double texel_m)
      : seed_(seed),
        duration_s_(duration_s),
        random_(seed, 71),
        painter_(combine_seed(seed, 72), texel_m) {}

  void furnish(bool low_texture) {
    furnish_room(combine_seed(seed_, 74), low_texture, &painter_, &built_.scene);
  }
  double duration_s() const { return duration_s_; }
  BuiltScenario finish() { return std::move(built_); }

  // --- the camera -------------------------------------------------------------------------------

  void camera(std::function<Pose(double)> path, const CameraPath::Tremor& tremor) {
    built_.camera = CameraPath(std::move(path), tremor, combine_seed(seed_, 73));
  }
  void camera_still(const CameraPath::Tremor& tremor) {
    Pose pose = look_at(kStandpoint_m, kDeskTarget_m);
    camera([pose](double) -> Pose { return pose; }, tremor);
  }
  /// Along one axis after the other, the orientation kept.
  void camera_xyz() {
    const Pose start = look_at(kStandpoint_m, kDeskTarget_m);
    const double phase = random_.uniform(0.0, 0.4);
    camera(
        [start, phase](double time_s) {
          const double t = time_s + phase;
          Pose pose = start;
          pose.translation() +=
              start.linear() * Eigen::Vector3d(0.32 * std::sin(2.0 * kPi * 0.23 * t),
                                               0.13 * std::sin(2.0 * kPi * 0.31 * t + 0.8),
                                               0.26 * std::sin(2.0 * kPi * 0.17 * t + 1.9));
          return pose;
        },
        kHandHeld);
  }
  /// About one axis after the other, the position kept.
  void camera_rpy() {
    const Pose start = look_at(kStandpoint_m, kDeskTarget_m);
    const double phase = random_.uniform(0.0, 0.4);
    camera(
        [start, phase](double time_s) {
          const double t = time_s + phase;
          const Eigen::Vector3d angles_rad(0.14 * std::sin(2.0 * kPi * 0.30 * t),
                                           0.30 * std::sin(2.0 * kPi * 0.21 * t + 0.5),
                                           0.26 * std::sin(2.0 * kPi * 0.26 * t + 1.6));
          Pose pose = start;
          pose.linear() = start.linear() * so3_exp(angles_rad);
          return pose;
        },
        kHandHeld);
  }
  /// On a sphere of one metre diameter about the standpoint, towards the desk.
  void camera_halfsphere() {
    const double phase = random_.uniform(0.0, 0.5);
    camera(
        [phase](double time_s) {
          const double t = time_s + phase;
          const double azimuth_rad = 1.1 * std::sin(2.0 * kPi * 0.13 * t);
          const double elevation_rad = 0.25 + 0.35 * std::sin(2.0 * kPi * 0.19 * t);
          const Eigen::Vector3d position_m =
              Eigen::Vector3d(0.0, 0.45, 1.1) +
              0.5 * Eigen::Vector3d(std::sin(azimuth_rad) * std::cos(elevation_rad),
                                    -std::cos(azimuth_rad) * std::cos(elevation_rad),
                                    std::sin(elevation_rad));
          return look_at(position_m, kDeskTarget_m, 0.05 * std::sin(2.0 * kPi * 0.11 * t));
        },
        kHandHeld);
  }
  /// Strolls sideways and closer while it looks around the desk.
  void camera_stroll(double width_m, double speed) {
    const double phase = random_.uniform(0.0, 0.6);
    camera(
        [=](double time_s) {
          const double t = speed * time_s + phase;
          const Eigen::Vector3d position_m =
              kStandpoint_m + Eigen::Vector3d(width_m * std::sin(2.0 * kPi * 0.11 * t),
                                              0.25 * std::sin(2.0 * kPi * 0.08 * t + 0.7),
                                              0.10 * std::sin(2.0 * kPi * 0.17 * t + 1.1));
          const Eigen::Vector3d target_m =
              kDeskTarget_m + Eigen::Vector3d(0.55 * std::sin(2.0 * kPi * 0.09 * t + 0.4), 0.0,
                                              0.16 * std::sin(2.0 * kPi * 0.14 * t));
          return look_at(position_m, target_m, 0.06 * std::sin(2.0 * kPi * 0.12 * t));
        },
        kHandHeld);
  }

  // --- people -----------------------------------------------------------------------------------

  PersonScript script(const std::vector<Waypoint>& waypoints, double yaw_rad,
                      const std::string& description) {
    PersonScript made;
    made.path = GroundPath(waypoints, yaw_rad);
    made.phase_rad = random_.uniform(0.0, 2.0 * kPi);
    made.gesture_rad = 0.06;
    made.gesture_seed = random_.bits();
    made.description = description;
    return made;
  }
  PersonBuild person() {
    return make_person(combine_seed(seed_, 80 + num_people_++), &painter_, &built_.scene);
  }
  void add(const PersonScript& what) { add_person(person(), what, &built_.scene); }

  /// Back and forth across the view at about `lane_y_m`, with short stops.
  std::vector<Waypoint> crossings(double first_side, double lane_y_m, double half_width_m,
                                  double speed_m_per_s, double start_s = 0.0) {
    std::vector<Waypoint> waypoints;
    double side = first_side;
    double time_s = start_s - 0.4;
    Eigen::Vector2d position_m(side * half_width_m * random_.uniform(0.5, 0.7), lane_y_m);
    waypoints.push_back({time_s, position_m});
    while (time_s < duration_s_ + 1.0) {
      side = -side;
      const double next_y_m = lane_y_m + random_.uniform(-0.12, 0.12);
      const Eigen::Vector2d next_m(side * half_width_m * random_.uniform(0.85, 1.1), next_y_m);
      time_s += (next_m - position_m).norm() / (speed_m_per_s * random_.uniform(0.9, 1.1));
      waypoints.push_back({time_s, next_m});
      time_s += random_.uniform(0.1, 0.5);
      waypoints.push_back({time_s, next_m});
      position_m = next_m;
    }
    return waypoints;
  }

  void two_walkers() {
    add(script(crossings(-1.0, 1.02, 0.95, 0.62), 0.0, "walks back and forth close to the camera"));
    add(script(crossings(1.0, 1.55, 1.3, 0.80), kPi, "walks back and forth before the desk"));
  }
  void two_sitters() {
    for (const double side : {-1.0, 1.0}) {
      const double x_m = side > 0.0 ? 0.78 : -0.66;
      const double y_m = 1.45 + random_.uniform(-0.05, 0.05);
      const double yaw_rad = side > 0.0 ? -0.5 * kPi - 0.5 : -0.5 * kPi + 0.5;
      PersonScript sitter =
          script({{0.0, {x_m, y_m}}}, yaw_rad, "sits, moves trunk, head and arms");
      sitter.seated = true;
      sitter.gesture_rad = 0.45;
      const Chair chair = make_chair(random_.bits(), &painter_, &built_.scene);
      const int object = built_.scene.add_object("chair", false);
      Pose T_world_chair = Pose::Identity();
      T_world_chair.translation() = Eigen::Vector3d(x_m, y_m, 0.0);
      T_world_chair.linear() =
          Eigen::AngleAxisd(yaw_rad - 0.5 * kPi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      for (std::size_t i = 0; i < chair.parts.size(); ++i) {
        Part part = chair.parts[i];
        part.object = object;
        built_.scene.add_static(part, T_world_chair * chair.T_chair_part[i]);
      }
      add(sitter);
    }
  }

  // --- things that move -------------------------------------------------------------------------

  Part solid_box(const Eigen::Vector3d& size_m, Texture texture, double shadow_radius_m) {
    Part part;
    part.shape = box_shape(size_m);
    part.material = built_.scene.add_material(built_.scene.add_texture(std::move(texture)));
    part.shadow_radius_m = shadow_radius_m;
    return part;
  }

  /// From floor to ceiling.
  void add_pillar(double x_m, double y_m) {
    Part pillar;
    pillar.shape = cylinder_shape(0.11, kRoomHeight_m - 0.02);
    pillar.material = built_.scene.add_material(built_.scene.add_texture(
        painter_.plaster(0.8, kRoomHeight_m, Color(150, 160, 170), 18.0F)));
    Pose T_world_pillar = Pose::Identity();
    T_world_pillar.translation() = Eigen::Vector3d(x_m, y_m, 0.5 * kRoomHeight_m);
    built_.scene.add_static(pillar, T_world_pillar);
  }

  /// Somebody lifts a box from the floor, carries it over and puts it on the table at the side.
  void box_carrier(double start_s) {
    const Eigen::Vector2d pick_m(-0.85, 1.2);
    const Eigen::Vector2d put_m(1.2, 1.4);
    const Eigen::Vector3d size_m(0.46, 0.34, 0.34);
    const double picked_s = start_s + 2.3;
    const double put_s = start_s + 7.0;
    PersonScript carrier = script({{start_s, {-1.9, 1.7}},
                                   {start_s + 1.7, pick_m},
                                   {start_s + 3.1, pick_m},
                                   {start_s + 6.1, put_m},
                                   {start_s + 7.6, put_m},
                                   {start_s + 9.4, {2.0, -0.2}}},
                                  -0.6, "lifts a box, carries it across and puts it on a table");
    carrier.gesture_rad = 0.02;
    carrier.bend_rad = Timeline({{start_s + 1.6, 0.0},
                                 {picked_s - 0.1, 0.95},
                                 {picked_s + 0.9, 0.0},
                                 {put_s - 0.8, 0.0},
                                 {put_s, 0.22},
                                 {put_s + 0.5, 0.0}});
    carrier.reach_rad = Timeline({{start_s + 1.6, 0.0},
                                  {picked_s - 0.2, 0.9},
                                  {picked_s + 0.9, 1.0},
                                  {put_s, 1.0},
                                  {put_s + 0.6, 0.0}});
    const PersonBuild build = person();
    add_person(build, carrier, &built_.scene);

    Scene& scene = built_.scene;
    Part table = solid_box({0.7, 0.6, 0.03}, painter_.wood(0.9, 0.8, Color(100, 135, 170)), 0.0);
    Pose T_world_table = Pose::Identity();
    T_world_table.translation() = Eigen::Vector3d(1.6, 1.6, 0.70);
    scene.add_static(table, T_world_table);
    Part leg = solid_box({0.08, 0.08, 0.685}, painter_.metal(0.4, 0.8, Color(90, 90, 90)), 0.0);
    Pose T_world_leg = T_world_table;
    T_world_leg.translation().z() = 0.3425;
    scene.add_static(leg, T_world_leg);

    // At rest exactly where the hands take it and leave it.
    const auto hands = carried_motion(carrier, build.height_m);
    Pose T_hands_box = Pose::Identity();
    T_hands_box.translation() = Eigen::Vector3d(0.0, 0.5 * size_m.y() + 0.03, 0.0);
    Pose before = hands(picked_s) * T_hands_box;
    before.translation().z() = 0.5 * size_m.z();
    Pose after = hands(put_s) * T_hands_box;
    after.translation().z() = 0.715 + 0.5 * size_m.z();
    const auto motion = [=](double time_s) {
      if (time_s <= picked_s) return before;
      if (time_s >= put_s) return after;
      const Pose held = hands(time_s) * T_hands_box;
      // Hands and rest differ a little; the load passes smoothly from one to the other.
      const auto ease = [](double share) { return share * share * (3.0 - 2.0 * share); };
      const double lifted = ease(std::min(1.0, (time_s - picked_s) / 0.8));
      const double lowered = ease(std::min(1.0, (put_s - time_s) / 0.8));
      return se3_interpolate(after, se3_interpolate(before, held, lifted), lowered);
    };
    scene.add_body({solid_box(size_m, painter_.cardboard(0.6, 0.5, true), 0.2)},
                   scene.add_object("box", true),
                   std::make_unique<RigidMotion>(motion, std::vector<Pose>{Pose::Identity()},
                                                 "is lifted, carried and put down"));
  }

  void rolling_chair(const std::vector<Waypoint>& waypoints, double spin_rad_per_s) {
    Chair chair = make_chair(random_.bits(), &painter_, &built_.scene);
    const GroundPath path(waypoints, 0.3);
    const auto motion = [path, spin_rad_per_s](double time_s) {
      const GroundPath::State state = path.at(time_s);
      Pose pose = Pose::Identity();
      pose.translation() = Eigen::Vector3d(state.position_m.x(), state.position_m.y(), 0.0);
      // It turns only while it rolls.
      pose.linear() =
          Eigen::AngleAxisd(0.3 + spin_rad_per_s * state.walked_m, Eigen::Vector3d::UnitZ())
              .toRotationMatrix();
      return pose;
    };
    built_.scene.add_body(
        chair.parts, built_.scene.add_object("chair", true),
        std::make_unique<RigidMotion>(motion, chair.T_chair_part, "rolls across the floor"));
  }

  void balloon(const Eigen::Vector3d& center_m, double reach_m) {
    const SmoothSignal x(&random_, reach_m, 0.08, 0.3);
    const SmoothSignal y(&random_, 0.4 * reach_m, 0.08, 0.3);
    const SmoothSignal z(&random_, 0.35 * reach_m, 0.1, 0.5);
    const SmoothSignal turn(&random_, 0.8, 0.05, 0.3);
    const auto motion = [=](double time_s) {
      Pose pose = Pose::Identity();
      pose.translation() = center_m + Eigen::Vector3d(x(time_s), y(time_s), z(time_s));
      pose.linear() = Eigen::AngleAxisd(turn(time_s), Eigen::Vector3d::UnitZ()).toRotationMatrix();
      return pose;
    };
    Part part;
    part.shape = ellipsoid_shape({0.17, 0.17, 0.20});
    part.material = built_.scene.add_material(
        built_.scene.add_texture(painter_.balloon(1.1, 0.42, Color(60, 60, 200))));
    part.shadow_radius_m = 0.17;
    built_.scene.add_body(
        {part}, built_.scene.add_object("balloon", true),
        std::make_unique<RigidMotion>(motion, std::vector<Pose>{Pose::Identity()}, "floats about"));
  }

  /// Somebody carries a board past the camera that hides everything for a second.
  void board_carrier(double covered_from_s) {
    const double lane_y_m = 0.70;
    const double speed_m_per_s = 0.9;
    const double half_width_m = 1.05;
    // The middle of the board is before the camera half a second after the cover begins.
    const double middle_s = covered_from_s + 0.5;
    const auto along = [=](double time_s) { return speed_m_per_s * (time_s - middle_s); };
    PersonScript carrier = script({{middle_s - 3.2, {along(middle_s - 3.2), lane_y_m + 0.32}},
                                   {middle_s + 3.4, {along(middle_s + 3.4), lane_y_m + 0.32}}},
                                  0.0, "carries a board past the camera");
    const GroundPath path = carrier.path;
    add(carrier);
    const auto motion = [=](double time_s) {
      Pose pose = Pose::Identity();
      pose.translation() = Eigen::Vector3d(path.at(time_s).position_m.x(), lane_y_m, 1.05);
      return pose;
    };
    Part board = solid_box({2.0 * half_width_m, 0.03, 1.7}, painter_.poster(2.1, 1.7), 0.0);
    built_.scene.add_body({board}, built_.scene.add_object("board", true),
                          std::make_unique<RigidMotion>(motion, std::vector<Pose>{Pose::Identity()},
                                                        "is carried past the camera"));
  }

 private:
  std::uint64_t seed_;
  double duration_s_;
  RandomStream random_;
  TexturePainter painter_;
  std::uint64_t num_people_ = 0;
  BuiltScenario built_;
};

}  // namespace srslam::detail
