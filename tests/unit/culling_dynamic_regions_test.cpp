#include "srslam/culling/dynamic_regions.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "support/constants.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

using test::flow_pose;
using test::FlowScene;

struct Regions {
  DynamicRegionsResult result;
  std::vector<FeatureSuspicion> features;
};

Regions regions_of(const DynamicRegionInput& input, const PinholeCamera& camera,
                   const DynamicRegionOptions& options = {}) {
  Regions regions;
  DynamicRegionWorkspace workspace;
  regions.features.resize(input.tracks.size);
  regions.result = find_dynamic_regions(input, camera, options, workspace, regions.features);
  return regions;
}

Regions regions_of(const FlowScene& scene, const std::vector<FlowTrack>& tracks,
                   const DynamicRegionOptions& options = {},
                   SceneClass scene_class = SceneClass::kGood) {
  DynamicRegionInput input;
  input.tracks = tracks;
  input.scene_class = scene_class;
  return regions_of(input, scene.camera, options);
}

/// In a FlowScene what moves is nearer than the room.
bool is_mover(const FlowTrack& track) { return track.reference.depth_m < 1.4F; }

struct Score {
  int num_movers = 0;
  int num_static = 0;
  int num_movers_caught = 0;
  int num_static_caught = 0;
};

Score score_of(const std::vector<FlowTrack>& tracks, const std::vector<FeatureSuspicion>& features,
               std::uint8_t tests) {
  Score score;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!tracks[i].alive) continue;
    const bool caught = (features[i].anomalies & tests) != 0;
    (is_mover(tracks[i]) ? score.num_movers : score.num_static) += 1;
    if (caught) (is_mover(tracks[i]) ? score.num_movers_caught : score.num_static_caught) += 1;
  }
  return score;
}

constexpr std::uint8_t kAnyTest = kFlowAnomaly | kEpipolarAnomaly | kDepthAnomaly;

Detection box(const char* class_name, double x_min_px, double x_max_px, double score = 0.9) {
  Detection detection;
  detection.class_name = class_name;
  detection.score = score;
  detection.x_min_px = x_min_px;
  detection.x_max_px = x_max_px;
  detection.y_min_px = 0.0;
  detection.y_max_px = 480.0;
  return detection;
}

TEST(DynamicRegions, ARigidSceneHasNone) {
  FlowScene scene;
  const std::vector<FlowTrack> tracks = scene.tracks();
  DynamicRegionOptions options;
  options.use_depth = true;
  const Regions regions = regions_of(scene, tracks, options);
  ASSERT_TRUE(regions.result.status.ok());
  EXPECT_EQ(regions.result.epipolar, SkippedTest::kNotSkipped);
  EXPECT_EQ(regions.result.depth, SkippedTest::kNotSkipped);
  EXPECT_GT(regions.result.num_tracked, 500);
  EXPECT_EQ(regions.result.num_potential, 0);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    EXPECT_EQ(regions.features[i].flow_tested, tracks[i].alive);
    EXPECT_EQ(regions.features[i].epipolar_tested, tracks[i].alive);
    EXPECT_LT(regions.features[i].flow_px, 1.0F);
  }
}

TEST(DynamicRegions, FindWhatMovesOtherwiseThanTheCamera) {
  for (const FlowModel model : {FlowModel::kRigid, FlowModel::kAffine}) {
    FlowScene scene;
    scene.mover_share = 0.25;
    scene.detected_share = 0.0;
    scene.T_mover = flow_pose(-0.1, 0.15, 0.02, 0.0, 0.0, 0.1);
    if (model == FlowModel::kAffine) {
      scene.T_current_reference = flow_pose(0.005, 0.0, 0.0, 0.004, 0.006, -0.01);  // nearly affine
    }
    const std::vector<FlowTrack> tracks = scene.tracks();
    DynamicRegionOptions options;
    options.flow_model = model;
    const Regions regions = regions_of(scene, tracks, options, SceneClass::kBad);
    ASSERT_TRUE(regions.result.status.ok());
    EXPECT_EQ(regions.result.motion.model, model);
    const Score score = score_of(tracks, regions.features, kFlowAnomaly);
    ASSERT_GT(score.num_movers, 80);
    EXPECT_GE(score.num_movers_caught, 0.97 * score.num_movers);
    EXPECT_LE(score.num_static_caught, 0.01 * score.num_static);
  }
}

TEST(DynamicRegions, WhatFollowsTheCameraIsSeenTo) {
  FlowScene scene;
  scene.mover_share = 0.25;
  scene.T_mover = flow_pose(-0.1, 0.15, 0.02, 0.0, 0.0, 0.1);
  const std::vector<FlowTrack> tracks = scene.tracks();
  DynamicRegionOptions options;
  options.static_px = 0.25;
  const Regions regions = regions_of(scene, tracks, options);
  int num_static = 0;
  int num_followers = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const FeatureSuspicion& feature = regions.features[i];
    EXPECT_EQ(feature.moves_with_camera,
              feature.flow_tested && !feature.anomalous() && feature.flow_px <= 0.25F);
    if (!tracks[i].alive) continue;
    EXPECT_FALSE(is_mover(tracks[i]) && feature.moves_with_camera);
    num_static += is_mover(tracks[i]) ? 0 : 1;
    num_followers += feature.moves_with_camera ? 1 : 0;
  }
  EXPECT_GT(num_followers, 0.2 * num_static);
  EXPECT_LT(num_followers, num_static) << "some are further off than a quarter of a pixel";
}

TEST(DynamicRegions, ADepthOfThisFrameStandsForOneThatThePreviousLacks) {
  FlowScene scene;
  scene.mover_share = 0.25;
  scene.detected_share = 0.0;
  scene.T_mover = flow_pose(-0.1, 0.15, 0.02, 0.0, 0.0, 0.1);
  const std::vector<FlowTrack> tracks = scene.tracks();
  const Regions whole = regions_of(scene, tracks);
  std::vector<FlowTrack> lacking = tracks;
  for (std::size_t i = 0; i < tracks.size(); i += 3) lacking[i].reference.depth_m = 0.0F;
  DynamicRegionOptions options;
  options.use_depth = true;
  const Regions regions = regions_of(scene, lacking, options);
  for (std::size_t i = 0; i < tracks.size(); i += 3) {
    if (!tracks[i].alive) continue;
    EXPECT_TRUE(regions.features[i].flow_tested);
    EXPECT_FALSE(regions.features[i].depth_tested) << "there are no two depths to compare";
    EXPECT_EQ(regions.features[i].anomalous(), whole.features[i].anomalous());
    if (!is_mover(tracks[i])) {
      EXPECT_NEAR(regions.features[i].flow_px, whole.features[i].flow_px, 0.5F);
    }
  }
}

TEST(DynamicRegions, EpipolarGeometrySeesMotionAcrossItsLinesOnly) {
  FlowScene scene;
  scene.T_current_reference = flow_pose(0.08, 0.0, 0.0, 0.0, 0.0, 0.0);
  scene.mover_share = 0.2;
  scene.detected_share = 0.0;
  for (const EpipolarSource source : {EpipolarSource::kCameraMotion, EpipolarSource::kEightPoint}) {
    DynamicRegionOptions options;
    options.epipolar_source = source;
    scene.T_mover = flow_pose(0.0, 0.1, 0.0, 0.0, 0.0, 0.0);
    std::vector<FlowTrack> tracks = scene.tracks();
    Regions regions = regions_of(scene, tracks, options);
    ASSERT_EQ(regions.result.epipolar, SkippedTest::kNotSkipped);
    Score score = score_of(tracks, regions.features, kEpipolarAnomaly);
    EXPECT_GE(score.num_movers_caught, 0.97 * score.num_movers);
    EXPECT_LE(score.num_static_caught, 0.01 * score.num_static);

    scene.T_mover = flow_pose(0.1, 0.0, 0.0, 0.0, 0.0, 0.0);
    tracks = scene.tracks();
    regions = regions_of(scene, tracks, options);
    ASSERT_EQ(regions.result.epipolar, SkippedTest::kNotSkipped);
    score = score_of(tracks, regions.features, kEpipolarAnomaly);
    EXPECT_LE(score.num_movers_caught, 0.02 * score.num_movers) << "it moves along the lines";
    score = score_of(tracks, regions.features, kFlowAnomaly);
    EXPECT_GE(score.num_movers_caught, 0.97 * score.num_movers) << "the flow tells, though";
  }
}

TEST(DynamicRegions, EpipolarGeometryIsLeftOutWhereItMeansNothing) {
  FlowScene scene;
  scene.T_current_reference = Pose::Identity();
  scene.mover_share = 0.2;
  scene.detected_share = 0.0;
  const auto skipped = [](const FlowScene& of, const DynamicRegionOptions& options = {},
                          SceneClass scene_class = SceneClass::kGood) {
    const Regions regions = regions_of(of, of.tracks(), options, scene_class);
    EXPECT_TRUE(regions.result.status.ok());
    EXPECT_EQ(regions.result.num_epipolar_anomalies, 0);
    for (const FeatureSuspicion& feature : regions.features) {
      EXPECT_FALSE(feature.epipolar_tested);
    }
    return regions.result.epipolar;
  };
  EXPECT_EQ(skipped(scene), SkippedTest::kStaticCamera);
  scene.mover_share = 0.0;
  scene.T_current_reference = flow_pose(0.0, 0.0, 0.0, 0.004, 0.006, 0.01);
  EXPECT_EQ(skipped(scene), SkippedTest::kNoParallax) << "it only turns";
  scene.T_current_reference = flow_pose(0.08, 0.02, 0.0, 0.0, 0.0, 0.0);
  EXPECT_EQ(skipped(scene, {}, SceneClass::kBad), SkippedTest::kBadScene);
  DynamicRegionOptions options;
  options.use_epipolar = false;
  EXPECT_EQ(skipped(scene, options), SkippedTest::kTurnedOff);
  options = {};
  options.epipolar_source = EpipolarSource::kEightPoint;
  options.fundamental.min_pairs = 5000;
  EXPECT_EQ(skipped(scene, options), SkippedTest::kNoGeometry);
  options = {};
  options.flow_model = FlowModel::kAffine;
  options.fundamental.min_inlier_share = 1.0;
  scene.noise_px = 2.0;
  EXPECT_EQ(skipped(scene, options), SkippedTest::kNoGeometry);
}

TEST(DynamicRegions, ParallaxIsWhatTheCamerasTranslationMakes) {
  const auto seen_from = [](const Pose& T_current_reference, bool is_wall,
                            const DynamicRegionOptions& options = {}) {
    FlowScene scene;
    std::vector<FlowTrack> tracks = scene.tracks();
    for (FlowTrack& track : tracks) {
      if (is_wall) track.reference.depth_m = 2.5F;
      Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
      Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
      EXPECT_TRUE(
          scene.camera.unproject({double(track.reference.u_px), double(track.reference.v_px)},
                                 double(track.reference.depth_m), &point_m));
      track.alive = scene.camera.project(T_current_reference * point_m, &pixel);
      track.current.u_px = float(pixel.x());
      track.current.v_px = float(pixel.y());
    }
    return regions_of(scene, tracks, options).result;
  };
  const Pose sideways = flow_pose(0.08, 0.02, 0.0, 0.0, 0.0, 0.0);
  const DynamicRegionsResult room = seen_from(sideways, false);
  EXPECT_EQ(room.epipolar, SkippedTest::kNotSkipped);
  EXPECT_GT(room.parallax_share, 0.6);
  EXPECT_LT(room.parallax_share, 0.95);
  const DynamicRegionsResult wall = seen_from(sideways, true);
  EXPECT_EQ(wall.epipolar, SkippedTest::kNoParallax);
  EXPECT_EQ(wall.parallax_share, 0.0);
  // A turn is no affine flow, yet no parallax either, however fast.
  for (const double turn_rad : {0.01, 0.05, 0.15}) {
    const Pose turned = flow_pose(0.0, 0.0, 0.0, 0.3 * turn_rad, turn_rad, -0.5 * turn_rad);
    const DynamicRegionsResult result = seen_from(turned, false);
    EXPECT_EQ(result.epipolar, SkippedTest::kNoParallax) << turn_rad;
    EXPECT_EQ(result.parallax_share, 0.0) << turn_rad;
    const Pose both = sideways * turned;
    EXPECT_NEAR(seen_from(both, false).parallax_share, room.parallax_share, 0.05);
  }
  // Without depth the flow has to tell, and a turn is not told from a translation.
  DynamicRegionOptions options;
  options.flow_model = FlowModel::kAffine;
  EXPECT_NEAR(seen_from(sideways, false, options).parallax_share, room.parallax_share, 0.1);
  EXPECT_EQ(seen_from(sideways, true, options).parallax_share, 0.0);
}

TEST(DynamicRegions, TakeMotionAndGeometryFromElsewhere) {
  FlowScene scene;
  scene.mover_share = 0.7;
  scene.detected_share = 0.0;
  scene.T_mover = flow_pose(0.0, 0.15, 0.0, 0.0, 0.0, 0.0);
  const std::vector<FlowTrack> tracks = scene.tracks();
  DynamicRegionInput input;
  input.tracks = tracks;
  input.T_current_previous = &scene.T_current_reference;
  const Regions regions = regions_of(input, scene.camera);
  ASSERT_TRUE(regions.result.status.ok());
  const Score score = score_of(tracks, regions.features, kFlowAnomaly);
  EXPECT_GE(score.num_movers_caught, 0.9 * score.num_movers);
  EXPECT_EQ(score.num_static_caught, 0) << "though most of the tracks move otherwise";

  const FundamentalMatrix F = fundamental_from_pose(scene.T_current_reference, scene.camera);
  input.T_current_previous = nullptr;
  input.F = &F;
  const Regions given = regions_of(input, scene.camera);
  EXPECT_EQ(given.result.fundamental.F, F);
  EXPECT_EQ(given.result.epipolar, SkippedTest::kNotSkipped);
}

TEST(DynamicRegions, DepthTellsWhatComesNearer) {
  // Towards the camera: in the middle of the image that is no motion of the image.
  FlowScene scene;
  scene.T_current_reference = Pose::Identity();
  scene.mover_share = 0.2;
  scene.detected_share = 0.0;
  scene.T_mover = flow_pose(0.0, 0.0, 0.12, 0.0, 0.0, 0.0);
  const std::vector<FlowTrack> tracks = scene.tracks();
  DynamicRegionOptions options;
  Score score = score_of(tracks, regions_of(scene, tracks, options).features, kAnyTest);
  const int by_flow = score.num_movers_caught;
  options.use_depth = true;
  const Regions regions = regions_of(scene, tracks, options);
  score = score_of(tracks, regions.features, kDepthAnomaly);
  EXPECT_EQ(score.num_movers_caught, score.num_movers);
  EXPECT_GT(score.num_movers_caught, by_flow);
  EXPECT_EQ(score.num_static_caught, 0);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!regions.features[i].depth_tested) continue;
    EXPECT_NEAR(regions.features[i].depth_error_m, is_mover(tracks[i]) ? 0.12 : 0.0, 0.01);
  }
  options.flow_model = FlowModel::kAffine;
  EXPECT_EQ(regions_of(scene, tracks, options).result.depth, SkippedTest::kNoMotion);
}

TEST(DynamicRegions, EverythingInAnObjectIsPotential) {
  FlowScene scene;
  const std::vector<FlowTrack> tracks = scene.tracks();
  const std::vector<Detection> detections = {
      box("person", 100.0, 200.0), box("chair", 300.0, 400.0), box("person", 500.0, 600.0, 0.2)};
  DynamicRegionInput input;
  input.tracks = tracks;
  input.detections = detections;
  const auto expect_objects = [&](const Regions& regions, double low_px, double high_px) {
    ASSERT_TRUE(regions.result.status.ok());
    int num_in_objects = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const double u = double(tracks[i].current.u_px);
      const bool inside = u >= low_px && u <= high_px && tracks[i].current.v_px >= 0.0F &&
                          tracks[i].current.v_px <= 480.0F;
      EXPECT_EQ(regions.features[i].in_object, inside) << u;
      EXPECT_EQ(regions.features[i].potential(), inside);
      num_in_objects += inside ? 1 : 0;
    }
    EXPECT_EQ(regions.result.num_in_objects, num_in_objects);
    EXPECT_EQ(regions.result.num_potential, num_in_objects);
  };
  expect_objects(regions_of(input, scene.camera), 100.0, 200.0);
  DynamicRegionOptions options;
  options.classes = {"chair"};
  expect_objects(regions_of(input, scene.camera, options), 300.0, 400.0);
  // A mask says it pixel by pixel, and boxes are not looked at.
  std::vector<std::uint8_t> mask(std::size_t{640} * 480, 0);
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 640 >= 50 && i % 640 < 80 ? 255 : 0;
  input.object_mask = {mask.data(), 640, 480};
  const Regions masked = regions_of(input, scene.camera);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!tracks[i].alive) continue;
    const auto u = std::lround(tracks[i].current.u_px);
    EXPECT_EQ(masked.features[i].in_object, u >= 50 && u < 80);
  }
}

TEST(DynamicRegions, ReachAroundAnomaliesOutsideObjects) {
  FlowScene scene;
  std::vector<FlowTrack> tracks = scene.tracks();
  tracks.resize(300);
  // One that moves, and three in its neighbourhood: at 30, 38.3 and 38.6 px of 38.4.
  FlowTrack mover = tracks[0];
  mover.current = {320.0F, 240.0F, 2.0F, false};
  mover.reference = {300.0F, 260.0F, 2.0F, false};
  mover.alive = true;
  tracks.push_back(mover);
  for (const float distance_px : {30.0F, 38.3F, 38.6F}) {
    FlowTrack neighbor;
    neighbor.current = {320.0F + distance_px, 240.0F, 2.0F, false};
    neighbor.alive = false;
    tracks.push_back(neighbor);
  }
  for (std::size_t i = 0; i < 300; ++i) {
    if (std::hypot(tracks[i].current.u_px - 320.0F, tracks[i].current.v_px - 240.0F) < 45.0F) {
      tracks[i].current.u_px += 100.0F;
      tracks[i].alive = false;
    }
  }
  Regions regions = regions_of(scene, tracks);
  EXPECT_TRUE(regions.features[300].anomalous());
  EXPECT_FALSE(regions.features[300].near_anomaly);
  EXPECT_TRUE(regions.features[301].near_anomaly);
  EXPECT_TRUE(regions.features[302].near_anomaly);
  EXPECT_FALSE(regions.features[303].near_anomaly);
  EXPECT_EQ(regions.result.num_near_anomaly, 2);
  EXPECT_EQ(regions.result.num_potential, 3);
  DynamicRegionOptions options;
  options.region_radius = 0.0;
  EXPECT_EQ(regions_of(scene, tracks, options).result.num_near_anomaly, 0);
}

TEST(DynamicRegions, LimitsHoldAtAnyResolution) {
  double median_flow_px = 0.0;
  for (const int width_px : {320, 640, 1280}) {
    FlowScene scene;
    scene.camera = test::flow_camera(width_px);
    scene.noise_px = 0.2 * width_px / 640.0;
    scene.mover_share = 0.2;
    scene.detected_share = 0.0;
    const Regions regions = regions_of(scene, scene.tracks());
    EXPECT_NEAR(regions.result.flow_limit_px, 3.0 * width_px / 640.0, 1e-9);
    if (width_px == 320) median_flow_px = regions.result.median_flow_px;
    EXPECT_GT(median_flow_px, 10.0);
    EXPECT_NEAR(regions.result.median_flow_px, median_flow_px, 0.1) << width_px;
  }
}

TEST(DynamicRegions, WithoutAMotionOnlyObjectsAreKnown) {
  FlowScene scene;
  scene.num_tracks = 5;
  const std::vector<FlowTrack> tracks = scene.tracks();
  const std::vector<Detection> detections = {box("person", -1.0, 641.0)};
  DynamicRegionInput input;
  input.tracks = tracks;
  input.detections = detections;
  const Regions regions = regions_of(input, scene.camera);
  EXPECT_EQ(regions.result.status.code, StatusCode::kInsufficientData);
  EXPECT_GT(regions.result.num_in_objects, 0);
  EXPECT_EQ(regions.result.num_anomalies, 0);
  const Regions nothing = regions_of(DynamicRegionInput{}, scene.camera);
  EXPECT_EQ(nothing.result.status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(nothing.result.num_potential, 0);
}

TEST(DynamicRegions, OddTracksGiveNoNan) {
  FlowScene scene;
  std::vector<FlowTrack> tracks = scene.tracks();
  const float odd[] = {float(test::kNan), float(test::kInf), -1e30F, 0.0F};
  for (std::size_t i = 0; i < 80; ++i) {
    FlowPoint& point = i % 2 == 0 ? tracks[i].reference : tracks[i].current;
    (i % 3 == 0 ? point.u_px : (i % 3 == 1 ? point.v_px : point.depth_m)) = odd[i % 4];
  }
  DynamicRegionOptions options;
  options.use_depth = true;
  const std::vector<Detection> detections = {box("person", test::kNan, 200.0)};
  DynamicRegionInput input;
  input.tracks = tracks;
  input.detections = detections;
  const Regions regions = regions_of(input, scene.camera, options);
  EXPECT_TRUE(regions.result.status.ok());
  EXPECT_TRUE(std::isfinite(regions.result.flow_limit_px));
  for (const FeatureSuspicion& feature : regions.features) {
    EXPECT_TRUE(std::isfinite(feature.flow_px) && std::isfinite(feature.epipolar_px) &&
                std::isfinite(feature.depth_error_m));
  }
}

TEST(DynamicRegions, RefuseWhatTheyCannotDo) {
  FlowScene scene;
  const std::vector<FlowTrack> tracks = scene.tracks();
  const auto code_of = [&](const DynamicRegionOptions& options) {
    return regions_of(scene, tracks, options).result.status.code;
  };
  DynamicRegionOptions bad[13];
  bad[12].static_px = 0.0;
  bad[0].flow_px = 0.0;
  bad[1].flow_sigmas = -1.0;
  bad[2].epipolar_px = test::kNan;
  bad[3].min_median_flow_px = -1.0;
  bad[4].min_parallax_share = 1.5;
  bad[5].depth_sigmas = 0.0;
  bad[6].min_depth_error_m = 0.0;
  bad[7].min_score = -0.1;
  bad[8].region_radius = test::kInf;
  bad[9].motion.min_tracks = 0;
  bad[10].fundamental.min_pairs = 3;
  bad[11].flow_px = test::kInf;
  for (const DynamicRegionOptions& options : bad) {
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
  }
  DynamicRegionInput input;
  input.tracks = tracks;
  EXPECT_EQ(regions_of(input, PinholeCamera{}).result.status.code, StatusCode::kInvalidArgument);
  std::vector<std::uint8_t> mask(100);
  input.object_mask = {mask.data(), 10, 10};
  EXPECT_EQ(regions_of(input, scene.camera).result.status.code, StatusCode::kInvalidArgument);
  input.object_mask = {};
  Pose odd = Pose::Identity();
  odd.translation().x() = test::kNan;
  input.T_current_previous = &odd;
  EXPECT_EQ(regions_of(input, scene.camera).result.status.code, StatusCode::kInvalidArgument);
  DynamicRegionWorkspace workspace;
  std::vector<FeatureSuspicion> too_few(3);
  input.T_current_previous = nullptr;
  EXPECT_EQ(find_dynamic_regions(input, scene.camera, {}, workspace, too_few).status.code,
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace srslam
