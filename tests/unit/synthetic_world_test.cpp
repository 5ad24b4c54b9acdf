#include "srslam/synthetic/synthetic_world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "support/synthetic_support.hpp"
#include "synthetic/renderer.hpp"
#include "synthetic/scenario_recipe.hpp"

namespace srslam {
namespace {

using test::synthetic_options;
using test::synthetic_world;

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(SyntheticWorld, RefusesWhatItCannotMake) {
  SyntheticWorld world;
  SyntheticOptions options = synthetic_options("walking_xyz", 1);
  options.scenario = "flying";
  FileStatus status = world.create(options);
  EXPECT_EQ(status.code, StatusCode::kNotFound);
  EXPECT_NE(status.reason.find("walking_halfsphere"), std::string::npos) << status.reason;
  options = synthetic_options("walking_xyz", 1);
  options.num_frames = 0;
  EXPECT_EQ(world.create(options).code, StatusCode::kInvalidArgument);
  options = synthetic_options("walking_xyz", 1);
  options.camera.depth_units_per_m = 0.0;
  EXPECT_EQ(world.create(options).code, StatusCode::kInvalidArgument);
  for (const double bad : {-0.1, 0.95, std::nan("")}) {
    options = synthetic_options("walking_xyz", 1);
    options.sensor.exposure_change = bad;
    EXPECT_EQ(world.create(options).code, StatusCode::kInvalidArgument);
    options = synthetic_options("walking_xyz", 1);
    options.sensor.exposure_time_s = bad;
    EXPECT_EQ(world.create(options).code, StatusCode::kInvalidArgument);
  }
  RgbdCamera camera;
  EXPECT_EQ(synthetic_camera("tum_fr9", 640, 480, &camera).code, StatusCode::kNotFound);
  EXPECT_EQ(synthetic_camera("tum_fr3", 640, 400, &camera).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(synthetic_camera("tum_fr3", 0, 0, &camera).code, StatusCode::kInvalidArgument);

  const SyntheticWorld made = synthetic_world(synthetic_options("fixed_static", 1));
  SyntheticRenderer renderer(made);
  SyntheticFrame frame;
  ImageBuffer<Eigen::Vector2f> flow;
  EXPECT_EQ(renderer.flow_to(0, &flow).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(renderer.render(300, &frame).code, StatusCode::kInvalidArgument);
}

TEST(SyntheticWorld, ScalesTheCameraAboutPixelCentres) {
  RgbdCamera full;
  RgbdCamera half;
  ASSERT_TRUE(synthetic_camera("bonn", 640, 480, &full).ok());
  ASSERT_TRUE(synthetic_camera("bonn", 320, 240, &half).ok());
  const Eigen::Vector3d point_m(0.4, -0.3, 1.7);
  Eigen::Vector2d in_full;
  Eigen::Vector2d in_half;
  ASSERT_TRUE(full.camera.project(point_m, &in_full));
  ASSERT_TRUE(half.camera.project(point_m, &in_half));
  // Measured from the corner of the image rather than from the middle of its first pixel.
  EXPECT_NEAR(in_half.x() + 0.5, 0.5 * (in_full.x() + 0.5), 1e-9);
  EXPECT_NEAR(in_half.y() + 0.5, 0.5 * (in_full.y() + 0.5), 1e-9);
  EXPECT_EQ(half.groundtruth_frame, GroundtruthFrame::kCamera);
}

TEST(SyntheticWorld, SameSeedSameFramesInAnyOrderAndAnotherSeedOthers) {
  SyntheticOptions options = synthetic_options("crowd", 3);
  options.sensor.exposure_change = 0.3;
  const SyntheticWorld world = synthetic_world(options);
  const SyntheticWorld again = synthetic_world(options);
  options.seed = 4;
  const SyntheticWorld other = synthetic_world(options);
  SyntheticRenderer forward(world);
  SyntheticRenderer backward(again);
  SyntheticRenderer different(other);
  SyntheticFrame a;
  SyntheticFrame b;
  ASSERT_TRUE(backward.render(200, &b).ok());
  ASSERT_TRUE(forward.render(7, &a).ok());
  ASSERT_TRUE(backward.render(7, &b).ok());
  EXPECT_TRUE(same_bytes(a.color.pixels, b.color.pixels));
  EXPECT_TRUE(same_bytes(a.raw_depth.pixels, b.raw_depth.pixels));
  EXPECT_TRUE(same_bytes(a.instances.pixels, b.instances.pixels));
  EXPECT_EQ(a.T_world_camera.matrix(), b.T_world_camera.matrix());
  ASSERT_EQ(a.detections.size(), b.detections.size());
  for (std::size_t i = 0; i < a.detections.size(); ++i) {
    EXPECT_EQ(a.detections[i].score, b.detections[i].score);
    EXPECT_EQ(a.detections[i].x_min_px, b.detections[i].x_min_px);
  }
  ASSERT_TRUE(different.render(7, &b).ok());
  EXPECT_FALSE(same_bytes(a.color.pixels, b.color.pixels));
  EXPECT_FALSE(same_bytes(a.raw_depth.pixels, b.raw_depth.pixels));
  EXPECT_NE(a.T_world_camera.matrix(), b.T_world_camera.matrix());
}

TEST(SyntheticWorld, TilesDoNotChangeThePicture) {
  for (const char* name : {"fixed_multi", "walking_halfsphere", "moving_box"}) {
    const detail::BuiltScenario built = detail::build_scenario(name, 6, 10.0, 0.03);
    RgbdCamera camera;
    ASSERT_TRUE(synthetic_camera("bonn", 128, 96, &camera).ok());
    const detail::Renderer renderer(&built.scene, camera.camera);
    detail::Renderer::Workspace workspace;
    detail::PixelBuffers tiled;
    detail::PixelBuffers all;
    for (const double time_s : {0.0, 3.3, 7.1}) {
      const Pose T_world_camera = built.camera.T_world_camera(time_s);
      renderer.render(time_s, T_world_camera, &tiled, &workspace);
      renderer.render(time_s, T_world_camera, &all, &workspace, true);
      EXPECT_TRUE(same_bytes(tiled.part.pixels, all.part.pixels)) << name;
      EXPECT_TRUE(same_bytes(tiled.depth_m.pixels, all.depth_m.pixels)) << name;
      EXPECT_TRUE(same_bytes(tiled.color.pixels, all.color.pixels)) << name;
    }
  }
}

// The sign of the pose: with T_world_camera all that is seen lies inside the room, and what is seen
// lowest lies on its floor.
TEST(SyntheticWorld, PoseCarriesPixelsIntoTheRoom) {
  SyntheticOptions options = synthetic_options("static_room", 2);
  options.sensor.clean = true;
  const SyntheticWorld world = synthetic_world(options);
  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  for (const std::size_t index : {std::size_t{0}, std::size_t{120}, std::size_t{299}}) {
    ASSERT_TRUE(renderer.render(index, &frame).ok());
    EXPECT_EQ(frame.T_world_camera.matrix(), world.T_world_camera(index).matrix());
    double lowest_m = 10.0;
    int on_floor = 0;
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        Eigen::Vector3d point_m;
        ASSERT_TRUE(options.camera.camera.unproject(
            Eigen::Vector2d(u, v), double(frame.raw_depth.view()(u, v)) / 5000.0, &point_m));
        const Eigen::Vector3d in_world = frame.T_world_camera * point_m;
        EXPECT_LT(std::abs(in_world.x()), 3.602);
        EXPECT_LT(std::abs(in_world.y()), 3.202);
        lowest_m = std::min(lowest_m, in_world.z());
        on_floor += std::abs(in_world.z()) < 0.002 ? 1 : 0;
      }
    }
    EXPECT_NEAR(lowest_m, 0.0, 0.001);
    EXPECT_GT(on_floor, 300);
  }
}

// A point seen in one frame, carried by depth and poses into another and back again, comes home.
TEST(SyntheticWorld, DepthAgreesWithTheMotionToATenthOfAPixelAndColorsWithEachOther) {
  SyntheticOptions options = synthetic_options("static_room", 3, 320, 240);
  options.sensor.clean = true;
  const SyntheticWorld world = synthetic_world(options);
  SyntheticRenderer renderer(world);
  SyntheticFrame a;
  SyntheticFrame b;
  ASSERT_TRUE(renderer.render(40, &a).ok());
  ASSERT_TRUE(renderer.render(52, &b).ok());
  const PinholeCamera& camera = options.camera.camera;
  const Pose T_b_a = b.T_world_camera.inverse() * a.T_world_camera;
  const auto depth_m = [&](const SyntheticFrame& frame, int u, int v) {
    return double(frame.raw_depth.view()(u, v)) / options.camera.depth_units_per_m;
  };
  std::vector<double> errors_px;
  std::vector<double> color_differences;
  for (int v = 4; v < 236; ++v) {
    for (int u = 4; u < 316; ++u) {
      Eigen::Vector3d point_m;
      Eigen::Vector2d in_a;
      ASSERT_TRUE(camera.unproject(Eigen::Vector2d(u, v), depth_m(b, u, v), &point_m));
      if (!camera.project(T_b_a.inverse() * point_m, &in_a)) continue;
      const auto left = static_cast<int>(std::floor(in_a.x()));
      const auto top = static_cast<int>(std::floor(in_a.y()));
      if (left < 1 || top < 1 || left > 317 || top > 237) continue;
      // On one smooth surface inverse depth is linear between pixels.
      double inverse_depth = 0.0;
      double lowest = 1e9;
      double highest = 0.0;
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      for (int k = 0; k < 4; ++k) {
        const int uk = left + (k & 1);
        const int vk = top + (k >> 1);
        const double weight = (1.0 - std::abs(in_a.x() - uk)) * (1.0 - std::abs(in_a.y() - vk));
        const double depth = depth_m(a, uk, vk);
        lowest = std::min(lowest, depth);
        highest = std::max(highest, depth);
        inverse_depth += weight / depth;
        const Bgr8& pixel = a.color.view()(uk, vk);
        color += weight * Eigen::Vector3d(pixel.b, pixel.g, pixel.r);
      }
      if (highest > 1.02 * lowest) continue;  // an edge of depth
      Eigen::Vector3d back_m;
      ASSERT_TRUE(camera.unproject(in_a, 1.0 / inverse_depth, &back_m));
      const double expected_z_m = (T_b_a.inverse() * point_m).z();
      if (std::abs(back_m.z() - expected_z_m) > 0.03 * expected_z_m) continue;  // hidden in a
      Eigen::Vector2d home;
      ASSERT_TRUE(camera.project(T_b_a * back_m, &home));
      errors_px.push_back((home - Eigen::Vector2d(u, v)).norm());
      const Bgr8& pixel = b.color.view()(u, v);
      color_differences.push_back(
          (color - Eigen::Vector3d(pixel.b, pixel.g, pixel.r)).cwiseAbs().mean());
    }
  }
  ASSERT_GT(errors_px.size(), 50000U);
  std::sort(errors_px.begin(), errors_px.end());
  std::sort(color_differences.begin(), color_differences.end());
  EXPECT_LT(errors_px[errors_px.size() * 99 / 100], 0.1);
  // Resampling blurs texture a little; exposure and light are the same.
  EXPECT_LT(color_differences[color_differences.size() / 2], 2.5);
  EXPECT_LT(color_differences[color_differences.size() * 9 / 10], 12.0);
}

TEST(SyntheticWorld, FlowIsTheProjectedMotionOfWhatIsSeen) {
  SyntheticOptions options = synthetic_options("walking_xyz", 2);
  options.sensor.clean = true;
  const SyntheticWorld world = synthetic_world(options);
  SyntheticRenderer renderer(world);
  SyntheticFrame a;
  SyntheticFrame b;
  ImageBuffer<Eigen::Vector2f> flow_px;
  ASSERT_TRUE(renderer.render(60, &a).ok());
  ASSERT_TRUE(renderer.flow_to(61, &flow_px).ok());
  ASSERT_TRUE(renderer.render(61, &b).ok());
  const PinholeCamera& camera = options.camera.camera;
  const Pose T_b_a = b.T_world_camera.inverse() * a.T_world_camera;
  int num_static = 0;
  int num_moving = 0;
  int num_moving_elsewhere = 0;
  int num_same_instance = 0;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector2f flow = flow_px.view()(u, v);
      const std::uint8_t instance = a.instances.view()(u, v);
      Eigen::Vector3d point_m;
      Eigen::Vector2d rigid;
      ASSERT_TRUE(
          camera.unproject(Eigen::Vector2d(u, v), double(a.true_depth_m.view()(u, v)), &point_m));
      ASSERT_TRUE(camera.project(T_b_a * point_m, &rigid));
      const double apart_px = (rigid - Eigen::Vector2d(u, v) - flow.cast<double>()).norm();
      if (instance == 0) {
        ++num_static;
        EXPECT_LT(apart_px, 1e-3);
        continue;
      }
      ++num_moving;
      num_moving_elsewhere += apart_px > 0.2 ? 1 : 0;
      const auto to_u = static_cast<int>(std::lround(float(u) + flow.x()));
      const auto to_v = static_cast<int>(std::lround(float(v) + flow.y()));
      if (b.instances.view().contains(to_u, to_v)) {
        num_same_instance += b.instances.view()(to_u, to_v) == instance ? 1 : 0;
      }
    }
  }
  EXPECT_GT(num_static, 3000);
  ASSERT_GT(num_moving, 1000);
  // Movers move otherwise than the room, and land on themselves.
  EXPECT_GT(num_moving_elsewhere, num_moving / 2);
  EXPECT_GT(num_same_instance, num_moving * 85 / 100);
  // No motion, no flow.
  ASSERT_TRUE(renderer.flow_to(61, &flow_px).ok());
  for (const Eigen::Vector2f& flow : flow_px.pixels) EXPECT_LT(flow.norm(), 1e-4F);
}

TEST(SyntheticWorld, MasksCoverTheMoversExactly) {
  for (const char* name : {"fixed_multi", "moving_box", "occlusion"}) {
    const SyntheticOptions options = synthetic_options(name, 2);
    const SyntheticWorld world = synthetic_world(options);
    SyntheticRenderer renderer(world);
    // The same room and camera without anybody.
    detail::BuiltScenario built =
        detail::build_scenario(name, 2, 10.0, 2.4 / options.camera.camera.width_px);
    const detail::CameraPath path = built.camera;
    detail::Scene empty;
    empty.textures = built.scene.textures;
    empty.materials = built.scene.materials;
    empty.room = built.scene.room;
    empty.T_world_room = built.scene.T_world_room;
    empty.room_material = built.scene.room_material;
    for (std::size_t i = 0; i < built.scene.parts.size(); ++i) {
      const bool moves = std::any_of(
          built.scene.bodies.begin(), built.scene.bodies.end(), [&](const detail::Body& body) {
            return i >= body.first_part && i < body.first_part + body.num_parts;
          });
      if (!moves) empty.add_static(built.scene.parts[i], built.scene.T_world_part[i]);
    }
    const detail::Renderer bare(&empty, options.camera.camera);
    detail::Renderer::Workspace workspace;
    detail::PixelBuffers without;
    SyntheticFrame frame;
    std::size_t num_covered = 0;
    for (const std::size_t index : {std::size_t{30}, std::size_t{150}, std::size_t{240}}) {
      ASSERT_TRUE(renderer.render(index, &frame).ok());
      bare.render(double(index) / 30.0, frame.T_world_camera, &without, &workspace);
      for (std::size_t i = 0; i < frame.instances.pixels.size(); ++i) {
        const bool in_front = frame.true_depth_m.pixels[i] < without.depth_m.pixels[i];
        ASSERT_EQ(frame.instances.pixels[i] != 0, in_front) << name << " pixel " << i;
        if (!in_front) {
          ASSERT_EQ(frame.true_depth_m.pixels[i], without.depth_m.pixels[i]);
        }
        num_covered += in_front ? 1U : 0U;
      }
    }
    EXPECT_GT(num_covered, 1000U);
  }
}

TEST(SyntheticWorld, BoardHidesEverythingForASecond) {
  const SyntheticWorld world = synthetic_world(synthetic_options("occlusion", 1));
  SyntheticRenderer renderer(world);
  SyntheticFrame frame;
  int longest = 0;
  int run = 0;
  for (std::size_t i = 100; i < 200; ++i) {
    ASSERT_TRUE(renderer.render(i, &frame).ok());
    const auto hidden = std::count_if(frame.instances.pixels.begin(), frame.instances.pixels.end(),
                                      [](std::uint8_t instance) { return instance != 0; });
    run = hidden == static_cast<long>(frame.instances.pixels.size()) ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  EXPECT_GE(longest, 25);
  EXPECT_LE(longest, 45);
}

TEST(SyntheticWorld, MoversAreListedWithTheInstancesOfTheMasks) {
  const SyntheticWorld world = synthetic_world(synthetic_options("fixed_multi", 2));
  std::vector<std::string> classes;
  for (std::size_t i = 0; i < world.movers().size(); ++i) {
    EXPECT_EQ(world.movers()[i].instance, static_cast<int>(i) + 1);
    EXPECT_FALSE(world.movers()[i].motion.empty());
    classes.push_back(world.movers()[i].class_name);
  }
  EXPECT_EQ(std::count(classes.begin(), classes.end(), "person"), 3);
  EXPECT_EQ(std::count(classes.begin(), classes.end(), "chair"), 1);
  EXPECT_EQ(std::count(classes.begin(), classes.end(), "balloon"), 1);
  EXPECT_TRUE(synthetic_world(synthetic_options("static_room", 1)).movers().empty());
}

TEST(SyntheticWorld, ShuttersBlurWhatMovesAndLeaveWhatStands) {
  SyntheticOptions options = synthetic_options("fixed_multi", 2);
  options.sensor.clean = true;
  const SyntheticWorld sharp_world = synthetic_world(options);
  options.sensor.exposure_time_s = 0.03;
  const SyntheticWorld blurred_world = synthetic_world(options);
  SyntheticRenderer sharp_renderer(sharp_world);
  SyntheticRenderer blurred_renderer(blurred_world);
  SyntheticFrame sharp;
  SyntheticFrame blurred;
  ASSERT_TRUE(sharp_renderer.render(60, &sharp).ok());
  ASSERT_TRUE(blurred_renderer.render(60, &blurred).ok());
  EXPECT_TRUE(same_bytes(sharp.raw_depth.pixels, blurred.raw_depth.pixels));
  double change_moving = 0.0;
  double change_standing = 0.0;
  int num_moving = 0;
  int num_standing = 0;
  for (std::size_t i = 0; i < sharp.color.pixels.size(); ++i) {
    const double change = std::abs(double(sharp.color.pixels[i].g) - blurred.color.pixels[i].g);
    if (sharp.instances.pixels[i] != 0) {
      change_moving += change;
      ++num_moving;
    } else {
      change_standing += change;
      ++num_standing;
    }
  }
  ASSERT_GT(num_moving, 500);
  EXPECT_GT(change_moving / num_moving, 1.5);
  EXPECT_LT(change_standing / num_standing, 0.5 * change_moving / num_moving);
}

}  // namespace
}  // namespace srslam
