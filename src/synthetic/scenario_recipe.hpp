#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synthetic/camera_path.hpp"
#include "synthetic/scene.hpp"

namespace srslam::detail {

/// What a scenario is, before anything is built.
struct ScenarioRecipe {
  const char* name;
  const char* description;
};
const std::vector<ScenarioRecipe>& scenario_recipes();

/// A scenario with everything in place.
struct BuiltScenario {
  Scene scene;
  CameraPath camera;
};

/// `name` must be that of a recipe. `duration_s`: how long the movers have something to do.
/// `texel_m`: size of a texel of large surfaces.
BuiltScenario build_scenario(const std::string& name, std::uint64_t seed, double duration_s,
                             double texel_m);

}  // namespace srslam::detail
