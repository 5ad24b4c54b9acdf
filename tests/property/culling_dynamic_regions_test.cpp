// Stage 1 of Algorithm 1 on tracks of random cameras that move at random through a room: who is
// suspected, who is not, and by which test.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "srslam/culling/dynamic_culling.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "support/culling_scene.hpp"
#include "support/flow_scene.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::flow_pose;
using test::FlowScene;
using test::for_each_seed;
using test::Rng;

constexpr EpipolarSource kSources[] = {EpipolarSource::kCameraMotion, EpipolarSource::kEightPoint};

struct RegionsRun {
  DynamicRegionsResult result;
  std::vector<FeatureSuspicion> features;
  DynamicRegionWorkspace workspace;
};

RegionsRun run_regions(const DynamicRegionInput& input, const PinholeCamera& camera,
                       const DynamicRegionOptions& options = {}) {
  RegionsRun run;
  run.features.resize(input.tracks.size);
  run.result = find_dynamic_regions(input, camera, options, run.workspace, run.features);
  return run;
}

RegionsRun run_regions(const std::vector<FlowTrack>& tracks, const PinholeCamera& camera,
                       const DynamicRegionOptions& options = {},
                       SceneClass scene_class = SceneClass::kGood) {
  DynamicRegionInput input;
  input.tracks = tracks;
  input.scene_class = scene_class;
  return run_regions(input, camera, options);
}

/// A room through which a camera moves, as it is seen by tracks half a pixel and depths a sigma
/// off.
FlowScene random_scene(Rng& rng) {
  FlowScene scene;
  scene.camera = test::random_flow_camera(rng);
  scene.num_tracks = rng.uniform_int(300, 1000);
  scene.noise_px = 0.5 * scene.camera.width_px / 640.0;
  scene.depth_noise = 1.0;
  scene.seed = rng.next();
  scene.T_current_reference =
      flow_pose(rng.uniform(-0.06, 0.06), rng.uniform(-0.06, 0.06), rng.uniform(-0.06, 0.06),
                rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05));
  return scene;
}

/// The same, moving sideways enough for epipolar geometry.
FlowScene sideways_scene(Rng& rng) {
  FlowScene scene = random_scene(rng);
  const double direction = rng.uniform(0.0, 6.28);
  scene.T_current_reference =
      flow_pose(0.1 * std::cos(direction), 0.1 * std::sin(direction), rng.uniform(-0.02, 0.02),
                rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02));
  return scene;
}

int count_of(const RegionsRun& run, std::uint8_t tests, const std::vector<std::size_t>& among) {
  int count = 0;
  for (const std::size_t i : among) count += (run.features[i].anomalies & tests) != 0 ? 1 : 0;
  return count;
}

TEST(DynamicRegionsProperty, AMovingCameraInAStaticSceneLosesHardlyAnything) {
  int num_frames = 0;
  int num_with_geometry = 0;
  for_each_seed(30, [&](Rng& rng) {
    const FlowScene scene = random_scene(rng);
    const std::vector<FlowTrack> tracks = scene.tracks();
    for (const EpipolarSource source : kSources) {
      DynamicRegionOptions options;
      options.epipolar_source = source;
      options.use_depth = true;
      const RegionsRun run = run_regions(tracks, scene.camera, options);
      ASSERT_TRUE(run.result.status.ok()) << run.result.status.reason;
      ++num_frames;
      num_with_geometry += run.result.epipolar == SkippedTest::kNotSkipped ? 1 : 0;
      EXPECT_LT(run.result.num_anomalies, 0.02 * run.result.num_tracked)
          << run.result.num_flow_anomalies << " by flow, " << run.result.num_epipolar_anomalies
          << " by epipolar geometry, " << run.result.num_depth_anomalies << " by depth";

      std::vector<FlowPoint> points;
      points.reserve(tracks.size());
      for (const FlowTrack& track : tracks) points.push_back(track.current);
      CullingFrame frame;
      frame.reliability = {rng.uniform(0.2, 1.0), rng.uniform(0.5, 2.0)};
      frame.residual_px = 1.0;
      std::vector<CullingVerdict> verdicts(tracks.size());
      DynamicCullingWorkspace workspace;
      const DynamicCullingResult culled =
          cull_dynamic_features(points, run.features, scene.camera, frame, {}, workspace, verdicts);
      ASSERT_TRUE(culled.status.ok());
      EXPECT_LT(culled.num_removed, 0.02 * run.result.num_tracked);
    }
  });
  if (num_frames > 2) {  // more than a replayed scene
    EXPECT_GT(num_with_geometry, num_frames / 2);
  }
}

TEST(DynamicRegionsProperty, AStaticCameraHasNoEpipolarGeometryToCullBy) {
  for_each_seed(30, [](Rng& rng) {
    FlowScene scene = random_scene(rng);
    scene.T_current_reference = Pose::Identity();
    scene.mover_share = rng.coin() ? 0.0 : rng.uniform(0.05, 0.3);
    scene.detected_share = 0.0;
    scene.T_mover = flow_pose(rng.uniform(0.05, 0.2), rng.uniform(0.05, 0.2), 0.0, 0.0, 0.0, 0.0);
    const std::vector<FlowTrack> tracks = scene.tracks();
    for (const EpipolarSource source : kSources) {
      DynamicRegionOptions options;
      options.epipolar_source = source;
      const RegionsRun run = run_regions(tracks, scene.camera, options);
      ASSERT_TRUE(run.result.status.ok());
      EXPECT_EQ(run.result.epipolar, SkippedTest::kStaticCamera);
      EXPECT_EQ(run.result.num_epipolar_anomalies, 0);
      if (scene.mover_share == 0.0) {
        EXPECT_EQ(run.result.num_potential, 0);
      } else {
        EXPECT_GT(run.result.num_flow_anomalies, 0) << "the flow test does not need it";
      }
    }
  });
}

TEST(DynamicRegionsProperty, ABadSceneNeverAsksForEpipolarGeometry) {
  for_each_seed(20, [](Rng& rng) {
    FlowScene scene = sideways_scene(rng);
    scene.mover_share = rng.uniform(0.0, 0.3);
    const std::vector<FlowTrack> tracks = scene.tracks();
    const FundamentalMatrix F = fundamental_from_pose(scene.T_current_reference, scene.camera);
    for (const EpipolarSource source : kSources) {
      for (const bool is_given : {false, true}) {
        DynamicRegionOptions options;
        options.epipolar_source = source;
        DynamicRegionInput input;
        input.tracks = tracks;
        input.F = is_given ? &F : nullptr;
        EXPECT_EQ(run_regions(input, scene.camera, options).result.epipolar,
                  SkippedTest::kNotSkipped);
        input.scene_class = SceneClass::kBad;
        const RegionsRun bad = run_regions(input, scene.camera, options);
        ASSERT_TRUE(bad.result.status.ok());
        EXPECT_EQ(bad.result.epipolar, SkippedTest::kBadScene);
        EXPECT_EQ(bad.result.fundamental.num_samples, 0);
        EXPECT_EQ(bad.result.fundamental.F, FundamentalMatrix::Zero());
        EXPECT_TRUE(bad.workspace.fundamental.normalized.empty()) << "nothing was prepared for it";
        EXPECT_EQ(bad.result.num_epipolar_anomalies, 0);
        for (const FeatureSuspicion& feature : bad.features) {
          ASSERT_FALSE(feature.epipolar_tested);
          ASSERT_EQ(feature.epipolar_px, 0.0F);
        }
      }
    }
  });
}

TEST(DynamicRegionsProperty, MotionAlongEpipolarLinesIsSeenByFlowOnly) {
  for_each_seed(30, [](Rng& rng) {
    const FlowScene scene = sideways_scene(rng);
    std::vector<FlowTrack> tracks = scene.tracks();
    // Along its ray of the reference camera a point stays on its epipolar line.
    std::vector<std::size_t> movers;
    for (std::size_t i = 0; i < tracks.size() && movers.size() < tracks.size() / 8; ++i) {
      FlowTrack& track = tracks[i];
      Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
      Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
      ASSERT_TRUE(scene.camera.unproject(
          {double(track.reference.u_px), double(track.reference.v_px)},
          double(track.reference.depth_m) * rng.uniform(0.3, 0.45), &point_m));
      if (!track.alive || !scene.camera.project(scene.T_current_reference * point_m, &pixel)) {
        continue;
      }
      track.current.u_px = float(pixel.x() + rng.uniform(-scene.noise_px, scene.noise_px));
      track.current.v_px = float(pixel.y() + rng.uniform(-scene.noise_px, scene.noise_px));
      movers.push_back(i);
    }
    ASSERT_GT(movers.size(), 20U);
    for (const EpipolarSource source : kSources) {
      DynamicRegionOptions options;
      options.epipolar_source = source;
      const RegionsRun run = run_regions(tracks, scene.camera, options);
      ASSERT_EQ(run.result.epipolar, SkippedTest::kNotSkipped);
      EXPECT_LE(count_of(run, kEpipolarAnomaly, movers), 0.05 * double(movers.size()));
      EXPECT_GE(count_of(run, kFlowAnomaly, movers), 0.95 * double(movers.size()));
    }
  });
}

TEST(DynamicRegionsProperty, MotionAcrossEpipolarLinesIsSeenByThem) {
  for_each_seed(30, [](Rng& rng) {
    const FlowScene scene = sideways_scene(rng);
    std::vector<FlowTrack> tracks = scene.tracks();
    const FundamentalMatrix F = fundamental_from_pose(scene.T_current_reference, scene.camera);
    const double px_scale = scene.camera.width_px / 640.0;
    std::vector<std::size_t> movers;
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      FlowTrack& track = tracks[i];
      if (!track.alive) continue;
      if (rng.uniform(0.0, 1.0) > 0.15) {
        others.push_back(i);
        continue;
      }
      Eigen::Vector2d undistorted = Eigen::Vector2d::Zero();
      ASSERT_TRUE(scene.camera.undistort_pixel(
          {double(track.reference.u_px), double(track.reference.v_px)}, &undistorted));
      const Eigen::Vector3d line = F * undistorted.homogeneous();
      const Eigen::Vector2d step_px =
          line.head<2>().normalized() * (rng.coin() ? 1.0 : -1.0) * rng.uniform(3.0, 15.0);
      track.current.u_px += float(step_px.x() * px_scale);
      track.current.v_px += float(step_px.y() * px_scale);
      movers.push_back(i);
    }
    ASSERT_GT(movers.size(), 20U);
    for (const EpipolarSource source : kSources) {
      DynamicRegionOptions options;
      options.epipolar_source = source;
      const RegionsRun run = run_regions(tracks, scene.camera, options);
      ASSERT_EQ(run.result.epipolar, SkippedTest::kNotSkipped);
      EXPECT_GE(count_of(run, kEpipolarAnomaly, movers), 0.97 * double(movers.size()));
      EXPECT_LE(count_of(run, kEpipolarAnomaly, others), 0.02 * double(others.size()));
      for (const std::size_t i : movers) EXPECT_TRUE(run.features[i].epipolar_tested);
    }
  });
}

TEST(DynamicRegionsProperty, EverythingInABoxOfWhatMayMoveIsPotential) {
  for_each_seed(60, [](Rng& rng) {
    FlowScene scene = random_scene(rng);
    scene.num_tracks = rng.uniform_int(1, 300);  // so few that there may be no motion
    scene.mover_share = rng.uniform(0.0, 0.5);
    std::vector<FlowTrack> tracks = scene.tracks();
    for (FlowTrack& track : tracks) {
      if (rng.uniform(0.0, 1.0) < 0.2) track.alive = false;
      if (rng.uniform(0.0, 1.0) < 0.1) track.current.depth_m = track.reference.depth_m = 0.0F;
    }
    const std::vector<std::string> classes = {"person", "dog", "chair", "tv", "car"};
    std::vector<Detection> detections(std::size_t(rng.uniform_int(0, 5)));
    for (Detection& detection : detections) {
      detection.class_name = classes[std::size_t(rng.uniform_int(0, 4))];
      detection.score = rng.uniform(0.0, 1.0);
      detection.x_min_px = rng.uniform(-0.2, 0.8) * scene.camera.width_px;
      detection.y_min_px = rng.uniform(-0.2, 0.8) * scene.camera.height_px;
      detection.x_max_px = detection.x_min_px + rng.uniform(0.0, 0.5) * scene.camera.width_px;
      detection.y_max_px = detection.y_min_px + rng.uniform(0.0, 0.5) * scene.camera.height_px;
    }
    DynamicRegionInput input;
    input.tracks = tracks;
    input.detections = detections;
    input.scene_class = rng.coin() ? SceneClass::kGood : SceneClass::kBad;
    DynamicRegionOptions options;
    const bool is_named = rng.coin();
    if (is_named) options.classes = {"chair", "tv"};
    const RegionsRun run = run_regions(input, scene.camera, options);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      bool inside = false;
      for (const Detection& box : detections) {
        const bool may_move = is_named ? box.class_name == "chair" || box.class_name == "tv"
                                       : box.class_name != "chair" && box.class_name != "tv";
        inside = inside || (may_move && box.score >= options.min_score &&
                            box_contains(box, double(tracks[i].current.u_px),
                                         double(tracks[i].current.v_px)));
      }
      EXPECT_EQ(run.features[i].in_object, inside);
      EXPECT_TRUE(run.features[i].potential() || !inside);
    }
  });
}

TEST(DynamicRegionsProperty, MoreMotionIsSeenMore) {
  for_each_seed(20, [](Rng& rng) {
    FlowScene scene = random_scene(rng);
    scene.noise_px *= 0.2;
    scene.depth_noise = 0.0;
    scene.mover_share = 0.15;
    scene.detected_share = 0.0;
    double share_before = -1.0;
    for (const double step_m : {0.0, 0.01, 0.03, 0.1}) {
      scene.T_mover = flow_pose(step_m, step_m, 0.0, 0.0, 0.0, 0.0);
      const std::vector<FlowTrack> tracks = scene.tracks();
      const RegionsRun run = run_regions(tracks, scene.camera, {}, SceneClass::kBad);
      std::vector<std::size_t> movers;
      for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (tracks[i].alive && tracks[i].reference.depth_m < 1.4F) movers.push_back(i);
      }
      const double share =
          count_of(run, kFlowAnomaly, movers) / double(movers.empty() ? 1 : movers.size());
      EXPECT_GE(share, share_before - 0.03) << step_m;
      if (step_m == 0.0) {
        EXPECT_EQ(share, 0.0);
      }
      share_before = share;
    }
    EXPECT_GT(share_before, 0.95);
  });
}

TEST(DynamicRegionsProperty, ASmallerImageOfTheSameTellsTheSame) {
  for_each_seed(20, [](Rng& rng) {
    FlowScene scene = sideways_scene(rng);
    scene.mover_share = 0.15;
    scene.detected_share = 0.0;
    const std::vector<FlowTrack> tracks = scene.tracks();
    std::vector<FlowTrack> small_tracks = tracks;
    PinholeCamera small = scene.camera;
    small.width_px /= 2;
    small.height_px /= 2;
    for (double* value : {&small.fx_px, &small.fy_px, &small.cx_px, &small.cy_px}) *value *= 0.5;
    for (FlowTrack& track : small_tracks) {
      for (FlowPoint* point : {&track.reference, &track.current}) {
        point->u_px *= 0.5F;
        point->v_px *= 0.5F;
      }
    }
    for (const EpipolarSource source : kSources) {
      DynamicRegionOptions options;
      options.epipolar_source = source;
      const RegionsRun whole = run_regions(tracks, scene.camera, options);
      const RegionsRun half = run_regions(small_tracks, small, options);
      EXPECT_EQ(whole.result.epipolar, half.result.epipolar);
      std::size_t num_different = 0;
      for (std::size_t i = 0; i < tracks.size(); ++i) {
        num_different += whole.features[i].anomalies != half.features[i].anomalies ? 1U : 0U;
        num_different += whole.features[i].potential() != half.features[i].potential() ? 1U : 0U;
      }
      EXPECT_LE(num_different, tracks.size() / 100);
      EXPECT_GT(whole.result.num_anomalies, 0);
    }
  });
}

TEST(DynamicRegionsProperty, TheSameInputGivesTheSameBitsWhateverTheWorkspaceSawBefore) {
  DynamicRegionWorkspace workspace;
  for_each_seed(20, [&](Rng& rng) {
    FlowScene scene = random_scene(rng);
    scene.mover_share = rng.uniform(0.0, 0.4);
    const std::vector<FlowTrack> tracks = scene.tracks();
    DynamicRegionOptions options;
    options.use_depth = rng.coin();
    options.epipolar_source = kSources[rng.uniform_int(0, 1)];
    options.flow_model = rng.coin() ? FlowModel::kRigid : FlowModel::kAffine;
    const RegionsRun afresh = run_regions(tracks, scene.camera, options);
    DynamicRegionInput input;
    input.tracks = tracks;
    std::vector<FeatureSuspicion> features(tracks.size());
    const DynamicRegionsResult again =
        find_dynamic_regions(input, scene.camera, options, workspace, features);
    EXPECT_EQ(again.flow_limit_px, afresh.result.flow_limit_px);
    EXPECT_EQ(again.parallax_share, afresh.result.parallax_share);
    EXPECT_EQ(again.fundamental.F, afresh.result.fundamental.F);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      ASSERT_EQ(features[i].anomalies, afresh.features[i].anomalies);
      ASSERT_EQ(features[i].near_anomaly, afresh.features[i].near_anomaly);
      ASSERT_EQ(features[i].flow_px, afresh.features[i].flow_px);
      ASSERT_EQ(features[i].epipolar_px, afresh.features[i].epipolar_px);
    }
  });
}

}  // namespace
}  // namespace srslam
