#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "synthetic/ground_path.hpp"
#include "synthetic/random.hpp"
#include "synthetic/scene.hpp"
#include "synthetic/texture_painter.hpp"

namespace srslam::detail {

/// What a person does over time. All timelines are in seconds from the start of the sequence.
struct PersonScript {
  GroundPath path;
  Timeline bend_rad;   ///< of the trunk, forward
  Timeline reach_rad;  ///< both arms raised forward, elbows nearly straight
  Timeline turn_rad;   ///< added to the heading of the path, such as towards a desk
  bool seated = false;
  double gesture_rad = 0.0;  ///< RMS of the free motion of the arms
  double phase_rad = 0.0;    ///< of the gait at the start
  std::uint64_t gesture_seed = 0;
  std::string description;
};

struct PersonBuild {
  double height_m = 1.75;
  std::vector<Part> parts;
};

/// Clothes, skin, hair and size of a person, from a seed.
PersonBuild make_person(std::uint64_t seed, TexturePainter* painter, Scene* scene);

/// Adds a person to the scene. The same script gives the same motion to any build.
void add_person(const PersonBuild& build, const PersonScript& script, Scene* scene);

/// Pose over time of a load held before the chest by somebody who follows `script`.
std::function<Pose(double time_s)> carried_motion(const PersonScript& script, double height_m);

}  // namespace srslam::detail
