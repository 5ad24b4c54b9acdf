#pragma once

#include <gtest/gtest.h>

#include <string>

#include "srslam/synthetic/synthetic_world.hpp"

namespace srslam::test {

inline SyntheticOptions synthetic_options(const std::string& scenario, std::uint64_t seed,
                                          int width_px = 160, int height_px = 120) {
  SyntheticOptions options;
  options.scenario = scenario;
  options.seed = seed;
  const FileStatus status = synthetic_camera("tum_fr3", width_px, height_px, &options.camera);
  EXPECT_TRUE(status.ok()) << status.message();
  return options;
}

inline SyntheticWorld synthetic_world(const SyntheticOptions& options) {
  SyntheticWorld world;
  const FileStatus status = world.create(options);
  EXPECT_TRUE(status.ok()) << status.message();
  return world;
}

}  // namespace srslam::test
