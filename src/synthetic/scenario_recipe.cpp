#include "synthetic/scenario_recipe.hpp"

#include "synthetic/scenario_stage.hpp"

namespace srslam::detail {
namespace {

/// Camera, people and things of a scenario.
void set_up(const std::string& name, ScenarioStage& stage) {
  if (name == "walking_static") {
    stage.camera_still(kHeldStill);
    stage.two_walkers();
  } else if (name == "walking_xyz") {
    stage.camera_xyz();
    stage.two_walkers();
  } else if (name == "walking_rpy") {
    stage.camera_rpy();
    stage.two_walkers();
  } else if (name == "walking_halfsphere") {
    stage.camera_halfsphere();
    stage.two_walkers();
  } else if (name == "sitting_static") {
    stage.camera_still(kHeldStill);
    stage.two_sitters();
  } else if (name == "sitting_xyz") {
    stage.camera_xyz();
    stage.two_sitters();
  } else if (name == "crowd") {
    stage.camera_stroll(0.35, 1.0);
    const double lanes_y_m[] = {0.88, 1.15, 1.45, 1.75};
    for (int i = 0; i < 4; ++i) {
      stage.add(stage.script(
          stage.crossings(i < 3 ? -1.0 : 1.0, lanes_y_m[i], 0.75 + 0.2 * i, 0.45 + 0.08 * i),
          i < 3 ? 0.0 : kPi, "walks about in the crowd"));
    }
  } else if (name == "moving_box") {
    stage.camera_stroll(0.35, 1.0);
    stage.box_carrier(0.2);
  } else if (name == "person_tracking") {
    // The camera follows somebody who walks and stops, at arm's length and a half.
    const std::vector<Waypoint> way{{0.0, {-1.5, 1.0}}, {3.6, {0.2, 1.1}}, {4.4, {0.2, 1.1}},
                                    {7.4, {1.4, 0.9}},  {8.0, {1.4, 0.9}}, {10.6, {0.1, 1.05}}};
    const PersonScript walker = stage.script(way, 0.0, "walks on, followed by the camera");
    const GroundPath path = walker.path;
    stage.add(walker);
    stage.add(stage.script({{0.0, {-1.05, 1.5}},
                            {3.6, {0.65, 1.55}},
                            {4.4, {0.65, 1.55}},
                            {7.4, {1.9, 1.4}},
                            {8.0, {1.9, 1.4}},
                            {10.6, {0.55, 1.5}}},
                           0.0, "walks beside them"));
    stage.camera(
        [path](double time_s) {
          // A little late, as one is who follows.
          const Eigen::Vector2d at_m = path.at(time_s - 0.25).position_m;
          const Eigen::Vector3d position_m(at_m.x() + 0.1, at_m.y() - 1.2, 1.35);
          return look_at(position_m, {at_m.x() + 0.05, at_m.y() + 1.6, 1.08});
        },
        kHandHeld);
  } else if (name == "synchronous") {
    stage.camera_stroll(0.25, 0.9);
    const std::vector<Waypoint> steps = stage.crossings(-1.0, 1.05, 0.6, 0.38);
    for (const double side : {-1.0, 1.0}) {
      std::vector<Waypoint> waypoints = steps;
      for (Waypoint& waypoint : waypoints) {
        waypoint.position_m += Eigen::Vector2d(0.33 * side, 0.05 * side);
      }
      PersonScript twin = stage.script(waypoints, 0.0, "walks in step with the other");
      twin.phase_rad = 0.0;
      stage.add(twin);
    }
  } else if (name == "static_room" || name == "low_texture") {
    stage.camera_stroll(0.55, 1.0);
  } else if (name == "occlusion") {
    stage.camera_stroll(0.12, 0.6);
    stage.board_carrier(0.45 * stage.duration_s());
  } else if (name == "robot_line") {
    stage.camera(
        [](double time_s) {
          const double driven_m = 0.20 * time_s;
          return look_at({0.0, -1.7 + driven_m, 1.0}, {0.05, 3.0 + driven_m, 0.98});
        },
        kHandHeld);
    stage.add(stage.script(stage.crossings(-1.0, 1.65, 1.3, 0.8), 0.0, "crosses far ahead"));
    stage.add(stage.script({{1.5, {-2.2, 0.2}},
                            {4.7, {0.7, 0.55}},
                            {5.4, {0.7, 0.55}},
                            {8.6, {-2.0, 1.1}},
                            {9.2, {-2.4, 1.2}}},
                           0.0, "crosses close before the robot"));
  } else {
    stage.camera_still(kTripod);
    if (name == "fixed_minor") {
      stage.add(
          stage.script(stage.crossings(1.0, 1.75, 1.6, 0.7), kPi, "walks behind chairs and desk"));
    } else if (name == "fixed_major") {
      stage.add(stage.script(stage.crossings(-1.0, 0.9, 0.8, 0.45), 0.0,
                             "walks close before the camera"));
      stage.add_pillar(0.30, 0.75);  // hides part of the view for good
      stage.rolling_chair(
          {{2.0, {-1.4, 1.6}}, {5.5, {1.0, 1.5}}, {6.5, {1.0, 1.5}}, {9.5, {-0.9, 1.6}}}, 0.8);
    } else if (name == "fixed_multi") {
      stage.two_walkers();
      stage.add(stage.script(
          {{0.5, {2.2, 1.3}}, {4.5, {-0.3, 0.85}}, {6.0, {-0.3, 0.85}}, {9.5, {2.0, 1.3}}}, kPi,
          "comes close, stands and goes"));
      stage.rolling_chair({{1.0, {1.5, 1.75}}, {5.0, {-0.8, 1.8}}, {9.0, {1.2, 1.75}}}, 1.0);
      stage.balloon({0.4, 1.5, 1.7}, 0.35);
    }
  }
}

}  // namespace

const std::vector<ScenarioRecipe>& scenario_recipes() {
  static const std::vector<ScenarioRecipe> recipes = {
      {"walking_static", "two people walk, the camera is held still"},
      {"walking_xyz", "two people walk, the camera moves along its axes"},
      {"walking_rpy", "two people walk, the camera turns about its axes"},
      {"walking_halfsphere", "two people walk, the camera moves on a half sphere"},
      {"sitting_static", "two people sit and gesture, the camera is held still"},
      {"sitting_xyz", "two people sit and gesture, the camera moves along its axes"},
      {"crowd", "four people walk about close to a strolling camera"},
      {"moving_box", "somebody carries a box from the floor to a table"},
      {"person_tracking", "the camera follows somebody who walks"},
      {"synchronous", "two people walk in step"},
      {"static_room", "nobody, a hand-held camera"},
      {"low_texture", "nobody, bare walls and desks, a hand-held camera"},
      {"occlusion", "a board hides everything for a second"},
      {"robot_line", "a straight drive, somebody close and somebody distant"},
      {"fixed_static", "camera on a tripod, nobody"},
      {"fixed_minor", "camera on a tripod, one person half hidden behind furniture"},
      {"fixed_major", "camera on a tripod, somebody close, a pillar and a rolling chair"},
      {"fixed_multi", "camera on a tripod, three people, a chair and a balloon"},
  };
  return recipes;
}

BuiltScenario build_scenario(const std::string& name, std::uint64_t seed, double duration_s,
                             double texel_m) {
  ScenarioStage stage(seed, duration_s, texel_m);
  stage.furnish(name == "low_texture");
  set_up(name, stage);
  return stage.finish();
}

}  // namespace srslam::detail
