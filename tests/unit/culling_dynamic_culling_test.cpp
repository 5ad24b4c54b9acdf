#include "srslam/culling/dynamic_culling.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/constants.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

using testing::Each;
using testing::ElementsAre;

/// Features and what stage 1 says of them.
struct SuspectScene {
  std::vector<FlowPoint> points;
  std::vector<FeatureSuspicion> features;

  /// `count` features in a row, a pixel apart, from (u, v) on.
  void add_row(float u_px, float v_px, float depth_m, int count, const FeatureSuspicion& feature) {
    for (int i = 0; i < count; ++i) {
      points.push_back({u_px + float(i), v_px, depth_m, feature.in_object});
      features.push_back(feature);
    }
  }
};

FeatureSuspicion anomaly(bool in_object = true) {
  FeatureSuspicion feature;
  feature.anomalies = kFlowAnomaly;
  feature.in_object = in_object;
  return feature;
}

FeatureSuspicion in_object() {
  FeatureSuspicion feature;
  feature.in_object = true;
  return feature;
}

FeatureSuspicion seen_static() {
  FeatureSuspicion feature = in_object();
  feature.flow_tested = true;
  feature.moves_with_camera = true;
  return feature;
}

struct Culled {
  DynamicCullingResult result;
  std::vector<CullingVerdict> verdicts;
};

Culled cull(const SuspectScene& scene, const DynamicCullingOptions& options,
            const CullingFrame& frame) {
  Culled culled;
  culled.verdicts.assign(scene.points.size(), CullingVerdict::kAggressive);
  DynamicCullingWorkspace workspace;
  culled.result = cull_dynamic_features(scene.points, scene.features, test::flow_camera(), frame,
                                        options, workspace, culled.verdicts);
  return culled;
}

/// A frame at the anchors of the adaptation: eps 38.4 px, three points.
CullingFrame quiet_frame(double residual_px = 1.0) {
  CullingFrame frame;
  frame.reliability = {0.2, 1.0};
  frame.residual_px = residual_px;
  return frame;
}

/// A moving body, a person at rest of whom two features twitch, and the room.
SuspectScene two_people() {
  SuspectScene scene;
  scene.add_row(100.0F, 100.0F, 2.0F, 5, anomaly());           // 0..4: moves
  scene.add_row(106.0F, 104.0F, 2.05F, 2, in_object());        // 5, 6: near them, untested
  scene.add_row(106.0F, 96.0F, 2.05F, 2, seen_static());       // 7, 8: near them, the room
  scene.add_row(300.0F, 100.0F, 2.0F, 2, anomaly());           // 9, 10: too few for a cluster
  scene.add_row(302.0F, 110.0F, 2.0F, 3, in_object());         // 11..13: with those
  scene.add_row(500.0F, 300.0F, 4.0F, 3, FeatureSuspicion{});  // 14..16: the room
  return scene;
}

TEST(DynamicCulling, RemovesClustersOfAnomaliesAndWhatIsNearThem) {
  const Culled culled = cull(two_people(), {}, quiet_frame());
  ASSERT_TRUE(culled.result.status.ok()) << culled.result.status.reason;
  EXPECT_EQ(culled.result.branch, CullingBranch::kRefined);
  using V = CullingVerdict;
  EXPECT_THAT(culled.verdicts,
              ElementsAre(V::kInCluster, V::kInCluster, V::kInCluster, V::kInCluster, V::kInCluster,
                          V::kNearCluster, V::kNearCluster, V::kKept, V::kKept, V::kKept, V::kKept,
                          V::kKept, V::kKept, V::kKept, V::kStatic, V::kStatic, V::kStatic));
  EXPECT_EQ(culled.result.num_dynamic_clusters, 1);
  EXPECT_EQ(culled.result.num_removed, 7);
  EXPECT_EQ(culled.result.num_removed_in_clusters, 5);
  EXPECT_EQ(culled.result.num_removed_near_clusters, 2);
  EXPECT_EQ(culled.result.num_kept_potential, 7);
}

TEST(DynamicCulling, AClusterReachesAMultipleOfEps) {
  // eps 38.4 px; the last core point is at u = 104 px.
  SuspectScene scene;
  scene.add_row(100.0F, 100.0F, 2.0F, 5, anomaly());
  for (const float u_px : {142.0F, 143.0F, 219.0F, 220.0F}) {
    scene.add_row(u_px, 100.0F, 3.5F, 1, in_object());
  }
  const auto num_removed = [&](double reach) {
    DynamicCullingOptions options;
    options.cluster_reach = reach;
    return cull(scene, options, quiet_frame()).result.num_removed;
  };
  EXPECT_EQ(num_removed(0.0), 5);
  EXPECT_EQ(num_removed(1.0), 6);
  EXPECT_EQ(num_removed(2.0), 7);
  EXPECT_EQ(num_removed(3.0), 8);
  EXPECT_EQ(num_removed(DynamicCullingOptions{}.cluster_reach), 8);
  EXPECT_EQ(num_removed(100.0), 9);
}

TEST(DynamicCulling, AnAnomalyThatIsNoiseNearAClusterGoes) {
  SuspectScene scene;
  scene.add_row(100.0F, 100.0F, 2.0F, 5, anomaly());
  scene.add_row(170.0F, 100.0F, 2.0F, 1, anomaly());
  scene.add_row(110.0F, 100.0F, 4.0F, 1, anomaly());  // of another depth group
  const Culled culled = cull(scene, {}, quiet_frame());
  EXPECT_EQ(culled.result.num_removed_in_clusters, 5);
  EXPECT_EQ(culled.verdicts[5], CullingVerdict::kNearCluster);
  EXPECT_EQ(culled.verdicts[6], CullingVerdict::kNearCluster);
}

TEST(DynamicCulling, BranchesOnTheResidualAboveItsLimitOnly) {
  const SuspectScene scene = two_people();
  const auto branch = [&](const DynamicCullingOptions& options, double residual_px) {
    return cull(scene, options, quiet_frame(residual_px)).result.branch;
  };
  EXPECT_EQ(branch({}, 5.0), CullingBranch::kRefined);
  EXPECT_EQ(branch({}, 5.0001), CullingBranch::kAggressive);
  DynamicCullingOptions raw;
  raw.residual = BranchResidual::kRaw;
  EXPECT_EQ(branch(raw, 60.0), CullingBranch::kRefined);
  EXPECT_EQ(branch(raw, 60.0001), CullingBranch::kAggressive);
  EXPECT_EQ(branch(raw, test::kInf), CullingBranch::kAggressive);
}

TEST(DynamicCulling, HighMotionRemovesAllThatIsPotential) {
  const SuspectScene scene = two_people();
  const Culled culled = cull(scene, {}, quiet_frame(20.0));
  EXPECT_EQ(culled.result.num_removed, 14);
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_EQ(culled.verdicts[i], i < 14 ? CullingVerdict::kAggressive : CullingVerdict::kStatic);
    EXPECT_EQ(is_removed(culled.verdicts[i]), i < 14);
  }
}

TEST(DynamicCulling, InitializationIsRefinedWhateverTheResidual) {
  CullingFrame frame = quiet_frame(test::kNan);
  frame.initializing = true;
  const Culled culled = cull(two_people(), {}, frame);
  ASSERT_TRUE(culled.result.status.ok());
  EXPECT_EQ(culled.result.branch, CullingBranch::kInitialization);
  EXPECT_EQ(culled.result.num_removed, 7);
}

TEST(DynamicCulling, AllPotentialFeaturesMayBeClustered) {
  SuspectScene scene;
  scene.add_row(100.0F, 100.0F, 2.0F, 3, anomaly());
  scene.add_row(103.0F, 100.0F, 2.0F, 7, in_object());  // with those, 30 % anomalies
  scene.add_row(300.0F, 100.0F, 2.0F, 2, anomaly());
  scene.add_row(302.0F, 100.0F, 2.0F, 8, in_object());  // 20 %
  scene.add_row(500.0F, 100.0F, 2.0F, 5, in_object());  // none
  DynamicCullingOptions options;
  options.clustered = ClusteredFeatures::kPotential;
  Culled culled = cull(scene, options, quiet_frame());
  EXPECT_EQ(culled.result.clusters.num_clusters, 3);
  EXPECT_EQ(culled.result.num_dynamic_clusters, 1);
  EXPECT_EQ(culled.result.num_removed, 10);
  options.min_anomalous_share = 0.0;
  culled = cull(scene, options, quiet_frame());
  EXPECT_EQ(culled.result.num_dynamic_clusters, 2) << "one anomaly at least";
}

TEST(DynamicCulling, HighMotionSparesFeaturesThatWouldBeTheLast) {
  SuspectScene scene = two_people();
  scene.points.resize(14);  // without the room
  scene.features.resize(14);
  const std::size_t num_potential = scene.points.size();
  const CullingFrame moving = quiet_frame(50.0);
  const Culled refined = cull(scene, {}, quiet_frame());
  Culled culled = cull(scene, {}, moving);
  EXPECT_EQ(culled.result.branch, CullingBranch::kSparing) << "nothing else is in view";
  EXPECT_EQ(culled.verdicts, refined.verdicts);
  // One more that is not potential, of all: exactly the share asked for, then less.
  scene.add_row(300.0F, 300.0F, 3.0F, 1, FeatureSuspicion{});
  DynamicCullingOptions options;
  options.min_kept_share = 1.0 / double(num_potential + 1);
  culled = cull(scene, options, moving);
  EXPECT_EQ(culled.result.branch, CullingBranch::kAggressive);
  EXPECT_EQ(culled.result.num_removed, int(num_potential));
  options.min_kept_share *= 1.001;
  EXPECT_EQ(cull(scene, options, moving).result.branch, CullingBranch::kSparing);
  EXPECT_STREQ(to_string(CullingBranch::kSparing), "sparing");
}

TEST(DynamicCulling, NothingPotentialNothingDone) {
  SuspectScene scene;
  scene.add_row(10.0F, 10.0F, 1.0F, 5, FeatureSuspicion{});
  const Culled culled = cull(scene, {}, quiet_frame(50.0));
  EXPECT_TRUE(culled.result.status.ok());
  EXPECT_EQ(culled.result.branch, CullingBranch::kNothing);
  EXPECT_THAT(culled.verdicts, Each(CullingVerdict::kStatic));
  EXPECT_TRUE(cull(SuspectScene{}, {}, quiet_frame()).result.status.ok());
}

TEST(DynamicCulling, WorksInEverySpaceAndWithoutDepth) {
  for (const ClusterSpace space : {ClusterSpace::kImageWidth, ClusterSpace::kImageDiagonal,
                                   ClusterSpace::kFocalLength, ClusterSpace::kMetric}) {
    DynamicCullingOptions options;
    options.clustering.space = space;
    const Culled culled = cull(two_people(), options, quiet_frame());
    ASSERT_TRUE(culled.result.status.ok());
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(culled.verdicts[i], CullingVerdict::kInCluster);
    EXPECT_EQ(culled.verdicts[9], CullingVerdict::kKept);
  }
  SuspectScene without_depth = two_people();
  for (FlowPoint& point : without_depth.points) point.depth_m = 0.0F;
  EXPECT_EQ(cull(without_depth, {}, quiet_frame()).result.num_removed, 7);
}

TEST(DynamicCulling, RefusesWhatItCannotDo) {
  const SuspectScene scene = two_people();
  const auto code_of = [&](const DynamicCullingOptions& options, const CullingFrame& frame) {
    const Culled culled = cull(scene, options, frame);
    EXPECT_THAT(culled.verdicts, Each(CullingVerdict::kStatic));
    return culled.result.status.code;
  };
  EXPECT_EQ(code_of({}, quiet_frame(test::kNan)), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of({}, quiet_frame(-1.0)), StatusCode::kInvalidArgument);
  CullingFrame frame = quiet_frame();
  frame.reliability.scene = test::kNan;
  EXPECT_EQ(code_of({}, frame), StatusCode::kInvalidArgument);
  DynamicCullingOptions bad[9];
  bad[0].high_motion_px = 0.0;
  bad[1].high_motion_raw_px = test::kInf;
  bad[2].min_anomalous_share = 1.1;
  bad[3].clustering.eps_base = -1.0;
  bad[4].high_motion_px = test::kNan;
  bad[5].min_kept_share = -0.1;
  bad[6].min_kept_share = test::kNan;
  bad[7].cluster_reach = -0.1;
  bad[8].cluster_reach = test::kInf;
  for (const DynamicCullingOptions& options : bad) {
    EXPECT_EQ(code_of(options, quiet_frame()), StatusCode::kInvalidArgument);
  }
  DynamicCullingWorkspace workspace;
  std::vector<CullingVerdict> too_few(3);
  EXPECT_EQ(cull_dynamic_features(scene.points, scene.features, test::flow_camera(), quiet_frame(),
                                  {}, workspace, too_few)
                .status.code,
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace srslam
