// Stage 2 of Algorithm 1 on random frames: each verdict against its definition, and what must hold
// whatever stage 1 said.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/culling/dynamic_culling.hpp"
#include "support/constants.hpp"
#include "support/culling_scene.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::Rng;

/// A frame as stage 2 gets it.
struct CullingInput {
  PinholeCamera camera;
  std::vector<FlowPoint> points;
  std::vector<FeatureSuspicion> features;
  CullingFrame frame;
  DynamicCullingOptions options;
};

CullingInput random_culling_input(Rng& rng) {
  CullingInput input;
  input.camera = test::random_flow_camera(rng);
  input.points = test::bodies_and_background(rng.uniform_int(0, 400), input.camera, rng);
  input.features = test::random_suspicions(input.points.size(), rng);
  input.frame.reliability = {rng.uniform(0.0, 1.0), rng.uniform(0.0, 2.0)};
  input.frame.residual_px = rng.uniform(0.0, 4.0);
  input.options.clustering.eps_base = rng.uniform(0.005, 0.05);
  input.options.cluster_reach = rng.uniform(0.0, 4.0);
  input.options.min_kept_share = 0.0;  // the branch as printed; see the test of the other
  input.options.clustering.group_depths = rng.uniform(0.0, 1.0) < 0.8;
  if (rng.coin()) input.options.clustered = ClusteredFeatures::kPotential;
  constexpr ClusterSpace kImageSpaces[] = {ClusterSpace::kImageWidth, ClusterSpace::kImageDiagonal,
                                           ClusterSpace::kFocalLength};
  input.options.clustering.space = kImageSpaces[rng.uniform_int(0, 2)];
  return input;
}

struct CullingRun {
  DynamicCullingResult result;
  std::vector<CullingVerdict> verdicts;

  bool removes(std::size_t i) const { return is_removed(verdicts[i]); }
};

CullingRun run_culling(const CullingInput& input) {
  CullingRun run;
  run.verdicts.assign(input.points.size(), CullingVerdict::kAggressive);
  DynamicCullingWorkspace workspace;
  run.result = cull_dynamic_features(input.points, input.features, input.camera, input.frame,
                                     input.options, workspace, run.verdicts);
  EXPECT_TRUE(run.result.status.ok()) << run.result.status.reason;
  return run;
}

/// Verdicts of the refined branch as its definition reads.
std::vector<CullingVerdict> refined_by_definition(const CullingInput& input) {
  const std::size_t n = input.points.size();
  std::vector<FlowPoint> clustered;
  std::vector<std::size_t> index;
  std::vector<float> potential_depth_m;
  std::vector<CullingVerdict> verdicts(n, CullingVerdict::kStatic);
  for (std::size_t i = 0; i < n; ++i) {
    if (!input.features[i].potential()) continue;
    verdicts[i] = CullingVerdict::kKept;
    potential_depth_m.push_back(input.points[i].depth_m);
    if (input.options.clustered == ClusteredFeatures::kPotential || input.features[i].anomalous()) {
      clustered.push_back(input.points[i]);
      index.push_back(i);
    }
  }
  std::vector<std::int32_t> labels(clustered.size());
  AdaptiveDbscanWorkspace workspace;
  const AdaptiveDbscanResult clusters =
      adaptive_dbscan(clustered, potential_depth_m, input.camera, input.frame.reliability,
                      input.options.clustering, workspace, labels);
  EXPECT_TRUE(clusters.status.ok());
  const auto is_dynamic = [&](std::int32_t cluster) {
    if (cluster == kNoiseLabel) return false;
    if (input.options.clustered == ClusteredFeatures::kAnomalies) return true;
    int num_members = 0;
    int num_anomalous = 0;
    for (std::size_t k = 0; k < labels.size(); ++k) {
      if (labels[k] != cluster) continue;
      ++num_members;
      num_anomalous += input.features[index[k]].anomalous() ? 1 : 0;
    }
    return num_anomalous > 0 && num_anomalous >= input.options.min_anomalous_share * num_members;
  };
  const std::array<float, 2> unit =
      detail::image_unit(input.options.clustering.space, input.camera);
  const auto reach = float(input.options.cluster_reach * clusters.eps);
  for (std::size_t k = 0; k < labels.size(); ++k) {
    if (is_dynamic(labels[k])) verdicts[index[k]] = CullingVerdict::kInCluster;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (verdicts[i] != CullingVerdict::kKept || input.features[i].moves_with_camera) continue;
    const FlowPoint& point = input.points[i];
    for (std::size_t k = 0; k < labels.size(); ++k) {
      if (!is_dynamic(labels[k]) || workspace.kinds[k] != PointKind::kCore) continue;
      const FlowPoint& core = clustered[k];
      const float du = core.u_px * unit[0] - point.u_px * unit[0];
      const float dv = core.v_px * unit[1] - point.v_px * unit[1];
      if (du * du + dv * dv <= reach * reach) verdicts[i] = CullingVerdict::kNearCluster;
    }
  }
  return verdicts;
}

TEST(DynamicCullingProperty, TheRefinedBranchIsWhatItsDefinitionSays) {
  for_each_seed(200, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.frame.initializing = rng.coin();
    const CullingRun run = run_culling(input);
    ASSERT_EQ(run.verdicts, refined_by_definition(input));
  });
}

TEST(DynamicCullingProperty, EveryFeatureIsCountedOnce) {
  for_each_seed(100, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.frame.residual_px = rng.uniform(0.0, 10.0);
    const CullingRun run = run_culling(input);
    int num_potential = 0;
    int num_removed = 0;
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      num_potential += input.features[i].potential() ? 1 : 0;
      num_removed += run.removes(i) ? 1 : 0;
      EXPECT_EQ(run.verdicts[i] == CullingVerdict::kStatic, !input.features[i].potential());
    }
    EXPECT_EQ(run.result.num_removed, num_removed);
    EXPECT_EQ(run.result.num_removed + run.result.num_kept_potential, num_potential);
    if (run.result.branch == CullingBranch::kAggressive) {
      EXPECT_EQ(num_removed, num_potential);
    } else {
      EXPECT_EQ(run.result.num_removed_in_clusters + run.result.num_removed_near_clusters,
                num_removed);
    }
  });
}

TEST(DynamicCullingProperty, TheBranchTurnsJustAboveTheLimit) {
  for_each_seed(100, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.features.resize(input.points.size() + 1);
    input.points.resize(input.features.size());
    input.features.back().in_object = true;  // there is something to decide
    double limit_px = 60.0;
    if (rng.coin()) {
      input.options.residual = BranchResidual::kRaw;
    } else {
      input.options.high_motion_px = limit_px = rng.uniform(0.5, 60.0);
    }
    input.frame.residual_px = limit_px;
    const CullingRun at_limit = run_culling(input);
    input.frame.residual_px = std::nextafter(limit_px, 1e9);
    const CullingRun above = run_culling(input);
    EXPECT_EQ(at_limit.result.branch, CullingBranch::kRefined);
    EXPECT_EQ(above.result.branch, CullingBranch::kAggressive);
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      EXPECT_EQ(above.removes(i), input.features[i].potential());
      EXPECT_TRUE(above.removes(i) || !at_limit.removes(i)) << "more goes, never less";
    }
  });
}

TEST(DynamicCullingProperty, TooFewThatWouldBeLeftAreSpared) {
  int num_spared = 0;
  int num_aggressive = 0;
  for_each_seed(100, [&](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.frame.residual_px = input.options.high_motion_px + 1.0;
    int num_potential = 0;
    for (const FeatureSuspicion& feature : input.features) {
      num_potential += feature.potential() ? 1 : 0;
    }
    if (num_potential == 0) return;
    input.options.min_kept_share = rng.uniform(0.0, 1.0);
    const double share_left = 1.0 - double(num_potential) / double(input.features.size());
    const CullingRun run = run_culling(input);
    if (share_left >= input.options.min_kept_share) {
      ++num_aggressive;
      EXPECT_EQ(run.result.branch, CullingBranch::kAggressive);
      EXPECT_EQ(run.result.num_removed, num_potential);
    } else {
      ++num_spared;
      EXPECT_EQ(run.result.branch, CullingBranch::kSparing);
      EXPECT_EQ(run.verdicts, refined_by_definition(input));
    }
  });
  if (num_spared + num_aggressive > 1) {  // more than a replayed one
    EXPECT_GT(num_spared, 0);
    EXPECT_GT(num_aggressive, 0);
  }
}

TEST(DynamicCullingProperty, WithoutAnomaliesNothingGoesUnlessMotionIsHigh) {
  for_each_seed(50, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    for (FeatureSuspicion& feature : input.features) feature.anomalies = kNoAnomaly;
    EXPECT_EQ(run_culling(input).result.num_removed, 0);
  });
}

TEST(DynamicCullingProperty, AnomaliesThatAreAloneStay) {
  for_each_seed(50, [](Rng& rng) {
    // At least 40 px apart: twice eps at its widest.
    CullingInput input;
    input.camera = test::flow_camera();
    input.options.clustering.eps_base = 0.02;
    for (int u = 0; u < 16; ++u) {
      for (int v = 0; v < 12; ++v) {
        input.points.push_back({float(40 * u), float(40 * v), float(rng.uniform(1.0, 1.1)), false});
        FeatureSuspicion feature;
        feature.anomalies = kFlowAnomaly;
        input.features.push_back(feature);
      }
    }
    input.frame.reliability = {rng.uniform(0.0, 1.0), rng.uniform(0.0, 2.0)};
    const CullingRun run = run_culling(input);
    EXPECT_EQ(run.result.branch, CullingBranch::kRefined);
    EXPECT_EQ(run.result.num_removed, 0);
    EXPECT_EQ(run.result.num_kept_potential, 16 * 12);
  });
}

TEST(DynamicCullingProperty, AMoreReliableSceneLosesMoreAndARicherOneLess) {
  int num_frames = 0;
  int num_more = 0;
  int num_less = 0;
  for_each_seed(60, [&](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.options.clustered = ClusteredFeatures::kAnomalies;
    const CullingRun before = run_culling(input);
    CullingInput reliable = input;
    reliable.frame.reliability.scene += 0.3;
    const CullingRun of_reliable = run_culling(reliable);
    CullingInput rich = input;
    rich.frame.reliability.features += 0.6;
    const CullingRun of_rich = run_culling(rich);
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      EXPECT_TRUE(of_reliable.removes(i) || !before.removes(i)) << i;
      EXPECT_TRUE(before.removes(i) || !of_rich.removes(i)) << i;
    }
    ++num_frames;
    num_more += of_reliable.result.num_removed > before.result.num_removed ? 1 : 0;
    num_less += of_rich.result.num_removed < before.result.num_removed ? 1 : 0;
  });
  if (num_frames > 1) {  // more than a replayed one: somewhere it matters
    EXPECT_GT(num_more, 0);
    EXPECT_GT(num_less, 0);
  }
}

TEST(DynamicCullingProperty, OrderOfTheFeaturesChangesNothing) {
  for_each_seed(80, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.frame.residual_px = rng.uniform(0.0, 6.0);
    const CullingRun before = run_culling(input);
    CullingInput shuffled = input;
    const std::vector<std::size_t> order = test::random_order(input.points.size(), rng);
    for (std::size_t k = 0; k < order.size(); ++k) {
      shuffled.points[k] = input.points[order[k]];
      shuffled.features[k] = input.features[order[k]];
    }
    const CullingRun after = run_culling(shuffled);
    EXPECT_EQ(before.result.num_dynamic_clusters, after.result.num_dynamic_clusters);
    for (std::size_t k = 0; k < order.size(); ++k) {
      ASSERT_EQ(after.verdicts[k], before.verdicts[order[k]]);
    }
  });
}

TEST(DynamicCullingProperty, AWorkspaceRemembersNothing) {
  DynamicCullingWorkspace workspace;
  for_each_seed(60, [&](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    input.frame.residual_px = rng.uniform(0.0, 6.0);
    std::vector<CullingVerdict> verdicts(input.points.size());
    const DynamicCullingResult result =
        cull_dynamic_features(input.points, input.features, input.camera, input.frame,
                              input.options, workspace, verdicts);
    const CullingRun afresh = run_culling(input);
    EXPECT_EQ(verdicts, afresh.verdicts);
    EXPECT_EQ(result.clusters.num_comparisons, afresh.result.clusters.num_comparisons);
  });
}

TEST(DynamicCullingProperty, PlacesAndDepthsThatAreNoNumbersHarmNothing) {
  for_each_seed(80, [](Rng& rng) {
    CullingInput input = random_culling_input(rng);
    const float odd[] = {float(test::kNan), float(test::kInf), -float(test::kInf),
                         std::numeric_limits<float>::max()};
    std::vector<std::size_t> lost;
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      if (rng.uniform(0.0, 1.0) > 0.2) continue;
      (rng.coin() ? input.points[i].u_px : input.points[i].v_px) = odd[rng.uniform_int(0, 2)];
      input.points[i].depth_m = odd[rng.uniform_int(0, 3)];
      lost.push_back(i);
    }
    const CullingRun refined = run_culling(input);
    for (const std::size_t i : lost) EXPECT_FALSE(refined.removes(i)) << "it is nowhere";
    ASSERT_EQ(refined.verdicts, refined_by_definition(input));
    input.frame.residual_px = test::kInf;
    const CullingRun aggressive = run_culling(input);
    for (const std::size_t i : lost) {
      EXPECT_EQ(aggressive.removes(i), input.features[i].potential());
    }
  });
}

}  // namespace
}  // namespace srslam
