#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "srslam/core/se3.hpp"
#include "synthetic/camera_path.hpp"
#include "synthetic/ground_path.hpp"
#include "synthetic/scenario_recipe.hpp"
#include "synthetic/smooth_signal.hpp"

namespace srslam::detail {
namespace {

constexpr double kCoarseTexel_m = 0.05;

TEST(SyntheticMotion, LookAtPointsTheOpticalAxis) {
  const Pose pose = look_at({1.0, -2.0, 1.5}, {1.0, 3.0, 1.5});
  // Looking along +y with z up: right is +x, down is -z.
  EXPECT_TRUE(pose.linear().col(0).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(pose.linear().col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(pose.linear().col(2).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-12);
}

TEST(SyntheticMotion, PathPassesItsStopsAndHeadsWhereItGoes) {
  const GroundPath path(
      {{0.0, {0.0, 0.0}}, {2.0, {2.0, 0.0}}, {4.0, {2.0, 0.0}}, {6.0, {2.0, 2.0}}}, 0.3);
  EXPECT_NEAR((path.at(-5.0).position_m - Eigen::Vector2d(0.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((path.at(3.0).position_m - Eigen::Vector2d(2.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((path.at(99.0).position_m - Eigen::Vector2d(2.0, 2.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(path.at(1.0).yaw_rad, 0.0, 1e-6);        // along +x
  EXPECT_NEAR(path.at(5.0).yaw_rad, 1.5707963, 1e-6);  // along +y
  EXPECT_NEAR(path.at(1.0).speed_m_per_s, 1.0, 1e-6);
  EXPECT_NEAR(path.at(3.0).speed_m_per_s, 0.0, 1e-9);
  EXPECT_NEAR(path.at(99.0).walked_m, 4.0, 1e-2);
}

TEST(SyntheticMotion, SignalHasTheRmsAskedForAndNoJumps) {
  RandomStream random(3);
  const SmoothSignal signal(&random, 0.5, 0.3, 6.0);
  double sum = 0.0;
  const int count = 200000;
  for (int i = 0; i < count; ++i) sum += std::pow(signal(i * 0.01), 2.0);
  EXPECT_NEAR(std::sqrt(sum / count), 0.5, 0.02);
  for (int i = 0; i < 1000; ++i) {
    // No faster than all its sines together at the highest frequency.
    EXPECT_LT(std::abs(signal(i * 0.01 + 0.001) - signal(i * 0.01)), 0.04);
  }
}

class Scenario : public ::testing::TestWithParam<std::string> {};

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const ScenarioRecipe& recipe : scenario_recipes()) names.emplace_back(recipe.name);
  return names;
}

TEST_P(Scenario, EverythingStaysInTheRoomAndMovesSmoothly) {
  const BuiltScenario built = build_scenario(GetParam(), 5, 10.0, kCoarseTexel_m);
  const Scene& scene = built.scene;
  std::vector<Pose> before;
  std::vector<Pose> now;
  Pose camera_before = built.camera.T_world_camera(0.0);
  scene.poses_at(0.0, &before);
  std::vector<double> largest_way_m(scene.parts.size(), 0.0);
  std::vector<Pose> first = before;
  for (int frame = 1; frame < 300; ++frame) {
    scene.poses_at(frame / 30.0, &now);
    const Pose camera = built.camera.T_world_camera(frame / 30.0);
    ASSERT_TRUE(camera.matrix().allFinite());
    EXPECT_LT((camera.translation() - camera_before.translation()).norm(), 0.08);
    EXPECT_LT(rotation_angle_rad(camera_before.linear().transpose() * camera.linear()), 0.08);
    EXPECT_LT(std::abs(camera.translation().x()), 3.3);
    EXPECT_GT(camera.translation().z(), 0.5);
    EXPECT_LT(camera.translation().z(), 2.0);
    camera_before = camera;
    for (std::size_t i = 0; i < now.size(); ++i) {
      ASSERT_TRUE(now[i].matrix().allFinite());
      ASSERT_NEAR(now[i].linear().determinant(), 1.0, 1e-9);
      // Nobody's limb is faster than 6 m/s.
      EXPECT_LT((now[i].translation() - before[i].translation()).norm(), 0.2) << i;
      largest_way_m[i] =
          std::max(largest_way_m[i], (now[i].translation() - first[i].translation()).norm());
    }
    before = now;
  }
  // Bodies move, everything else does not.
  std::set<std::size_t> moving;
  for (const Body& body : scene.bodies) {
    double way_m = 0.0;
    for (std::size_t i = body.first_part; i < body.first_part + body.num_parts; ++i) {
      moving.insert(i);
      way_m = std::max(way_m, largest_way_m[i]);
    }
    EXPECT_GT(way_m, 0.05) << body.motion->description();
    EXPECT_TRUE(scene.objects[static_cast<std::size_t>(body.object)].moves);
  }
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    if (moving.count(i) == 0) {
      EXPECT_EQ(largest_way_m[i], 0.0);
    }
  }
}

TEST_P(Scenario, OnlyFixedCamerasStandStill) {
  const std::string name = GetParam();
  const BuiltScenario built = build_scenario(name, 2, 10.0, kCoarseTexel_m);
  double way_m = 0.0;
  for (int frame = 1; frame < 300; ++frame) {
    way_m = std::max(way_m, (built.camera.T_world_camera(frame / 30.0).translation() -
                             built.camera.T_world_camera(0.0).translation())
                                .norm());
  }
  if (name.rfind("fixed_", 0) == 0) {
    EXPECT_EQ(way_m, 0.0);
  } else if (name == "walking_static" || name == "sitting_static") {
    EXPECT_LT(way_m, 0.02);
  } else {
    EXPECT_GT(way_m, 0.02);
  }
}

TEST_P(Scenario, FeetStandOnTheFloor) {
  const BuiltScenario built = build_scenario(GetParam(), 4, 10.0, kCoarseTexel_m);
  std::vector<Pose> poses;
  for (int frame = 0; frame < 300; frame += 7) {
    built.scene.poses_at(frame / 30.0, &poses);
    for (const Body& body : built.scene.bodies) {
      if (built.scene.objects[static_cast<std::size_t>(body.object)].class_name != "person")
        continue;
      double lowest_m = 10.0;
      double highest_m = 0.0;
      for (std::size_t i = body.first_part; i < body.first_part + body.num_parts; ++i) {
        const BoundingSphere sphere = bounding_sphere(built.scene.parts[i].shape);
        const double z_m = (poses[i] * sphere.center_m).z();
        lowest_m = std::min(lowest_m, z_m);
        highest_m = std::max(highest_m, z_m);
      }
      // Centres of feet are a few centimetres above the floor, heads at most 1.9 m.
      EXPECT_GT(lowest_m, 0.0);
      EXPECT_LT(lowest_m, 0.12);
      EXPECT_LT(highest_m, 1.9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Scenario, ::testing::ValuesIn(scenario_names()),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace srslam::detail
