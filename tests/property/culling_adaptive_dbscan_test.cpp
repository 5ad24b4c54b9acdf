// Depth-assisted adaptive DBSCAN against its definition, written down once more without any
// cleverness, and what follows from the definition: groups that share no cluster, plain DBSCAN
// where there is one group, order and place of the points without meaning.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/culling/adaptive_dbscan.hpp"
#include "support/constants.hpp"
#include "support/culling_scene.hpp"
#include "support/dbscan_reference.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::Rng;

constexpr ClusterSpace kSpaces[] = {ClusterSpace::kImageWidth, ClusterSpace::kImageDiagonal,
                                    ClusterSpace::kFocalLength, ClusterSpace::kMetric};

struct AdaptiveRun {
  AdaptiveDbscanResult result;
  std::vector<std::int32_t> labels;
  AdaptiveDbscanWorkspace workspace;
};

AdaptiveRun run_adaptive(const std::vector<FlowPoint>& points, const AdaptiveDbscanOptions& options,
                         const FrameReliability& reliability = {0.2, 1.0},
                         const PinholeCamera& camera = test::flow_camera(),
                         const std::vector<float>& potential_depth_m = {}) {
  AdaptiveRun run;
  run.labels.assign(points.size(), 77);
  run.result = adaptive_dbscan(points, potential_depth_m, camera, reliability, options,
                               run.workspace, run.labels);
  EXPECT_TRUE(run.result.status.ok()) << run.result.status.reason;
  return run;
}

bool has_depth(const FlowPoint& point) {
  return std::isfinite(point.depth_m) && point.depth_m > 0.0F;
}

/// Group of each point, by ascending depth; those without depth are the last one.
std::vector<int> groups_by_definition(const std::vector<FlowPoint>& points,
                                      const std::vector<float>& potential_depth_m,
                                      const AdaptiveDbscanOptions& options) {
  std::vector<int> group_of(points.size(), 0);
  if (!options.group_depths) return group_of;
  std::vector<float> depth_m;
  depth_m.reserve(points.size());
  for (const FlowPoint& point : points) depth_m.push_back(point.depth_m);
  const auto keep_valid = [](std::vector<float> values) {
    values.erase(std::remove_if(values.begin(), values.end(),
                                [](float x) { return !(x > 0.0F) || !std::isfinite(x); }),
                 values.end());
    std::sort(values.begin(), values.end());
    return values;
  };
  const std::vector<float> of_quartiles =
      keep_valid(potential_depth_m.empty() ? depth_m : potential_depth_m);
  float threshold_m = 0.0F;
  if (const std::size_t n = of_quartiles.size(); n > 0) {
    threshold_m = of_quartiles[3 * n / 4] - of_quartiles[n / 4];
    if (options.depth_groups.threshold == DepthThreshold::kClamped) {
      threshold_m = std::min(std::max(threshold_m, float(options.depth_groups.min_threshold_m)),
                             float(options.depth_groups.max_threshold_m));
    }
  }
  int group = -1;
  float last_m = 0.0F;
  float first_m = 0.0F;
  std::map<float, int> group_of_depth;
  for (const float depth : keep_valid(depth_m)) {
    const float from_m =
        options.depth_groups.grouping == DepthGrouping::kAnchored ? first_m : last_m;
    if (group < 0 || depth - from_m > threshold_m) {
      ++group;
      first_m = depth;
    }
    last_m = depth;
    group_of_depth[depth] = group;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    group_of[i] = has_depth(points[i]) ? group_of_depth.at(points[i].depth_m) : group + 1;
  }
  return group_of;
}

/// Labels and kinds as the definition has them: group by group, each with every pair.
test::ReferenceClusters adaptive_by_definition(const std::vector<FlowPoint>& points,
                                               const std::vector<int>& group_of,
                                               const AdaptiveDbscanOptions& options,
                                               const AdaptiveDbscanResult& parameters,
                                               const PinholeCamera& camera) {
  test::ReferenceClusters all;
  all.labels.assign(points.size(), kNoiseLabel);
  all.kinds.assign(points.size(), PointKind::kNoise);
  const std::array<float, 2> unit = detail::image_unit(options.space, camera);
  const int num_groups =
      points.empty() ? 0 : 1 + *std::max_element(group_of.begin(), group_of.end());
  for (int group = 0; group < num_groups; ++group) {
    std::vector<std::size_t> members;
    std::vector<std::array<float, 3>> coordinates;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (group_of[i] != group) continue;
      members.push_back(i);
      const FlowPoint& p = points[i];
      if (options.space == ClusterSpace::kMetric) {
        const float z = has_depth(p) ? p.depth_m : float(test::kNan);
        coordinates.push_back({(p.u_px - float(camera.cx_px)) * unit[0] * z,
                               (p.v_px - float(camera.cy_px)) * unit[1] * z, z});
      } else {
        coordinates.push_back({p.u_px * unit[0], p.v_px * unit[1], 0.0F});
      }
    }
    const test::ReferenceClusters clusters =
        test::reference_dbscan(coordinates, parameters.eps, parameters.min_points);
    for (std::size_t k = 0; k < members.size(); ++k) {
      all.kinds[members[k]] = clusters.kinds[k];
      if (clusters.labels[k] == kNoiseLabel) continue;
      all.labels[members[k]] = all.num_clusters + clusters.labels[k];
    }
    all.num_clusters += clusters.num_clusters;
  }
  return all;
}

/// Everything that the definition says of a run.
void expect_definition(const std::vector<FlowPoint>& points, const AdaptiveDbscanOptions& options,
                       const FrameReliability& reliability, const PinholeCamera& camera,
                       const std::vector<float>& potential_depth_m = {}) {
  const AdaptiveRun run = run_adaptive(points, options, reliability, camera, potential_depth_m);
  const std::vector<int> group_of = groups_by_definition(points, potential_depth_m, options);
  const test::ReferenceClusters expected =
      adaptive_by_definition(points, group_of, options, run.result, camera);
  ASSERT_EQ(run.labels, expected.labels);
  ASSERT_EQ(run.workspace.kinds, expected.kinds);
  ASSERT_EQ(run.result.num_clusters, expected.num_clusters);

  // Every point is in exactly one group, and no cluster in two.
  const std::size_t num_groups = std::set<int>(group_of.begin(), group_of.end()).size();
  ASSERT_EQ(run.workspace.groups.size(), num_groups);
  std::size_t num_points = 0;
  std::uint64_t num_comparisons = 0;
  int num_clusters = 0;
  for (std::size_t g = 0; g < num_groups; ++g) {
    const GroupClusters& group = run.workspace.groups[g];
    EXPECT_EQ(group.num_points, std::size_t(std::count(group_of.begin(), group_of.end(), int(g))));
    num_points += group.num_points;
    num_comparisons += group.num_comparisons;
    num_clusters += group.num_clusters;
  }
  EXPECT_EQ(num_points, points.size());
  EXPECT_EQ(num_comparisons, run.result.num_comparisons);
  EXPECT_EQ(num_clusters, run.result.num_clusters);
  std::map<std::int32_t, int> group_of_cluster;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (run.labels[i] == kNoiseLabel) continue;
    EXPECT_EQ(group_of_cluster.emplace(run.labels[i], group_of[i]).first->second, group_of[i]);
  }
}

AdaptiveDbscanOptions random_options(Rng& rng) {
  AdaptiveDbscanOptions options;
  options.space = kSpaces[rng.uniform_int(0, 3)];
  options.eps_base = rng.uniform(0.005, 0.08);
  options.min_points_base = rng.uniform(1.0, 6.0);
  options.group_depths = rng.uniform(0.0, 1.0) < 0.8;
  options.depth_groups.threshold = rng.coin() ? DepthThreshold::kClamped : DepthThreshold::kLiteral;
  options.depth_groups.grouping =
      rng.coin() ? DepthGrouping::kGapLinkage : DepthGrouping::kAnchored;
  const NeighborSearch searches[] = {NeighborSearch::kAutomatic, NeighborSearch::kBruteForce,
                                     NeighborSearch::kSweep, NeighborSearch::kGrid};
  options.search = searches[rng.uniform_int(0, int(std::size(searches)) - 1)];
  return options;
}

FrameReliability random_reliability(Rng& rng) {
  return {rng.uniform(0.0, 1.0), rng.uniform(0.0, 2.0)};
}

/// The same clusters, whatever their numbers.
void expect_same_partition(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
  ASSERT_EQ(a.size(), b.size());
  std::map<std::int32_t, std::int32_t> forth;
  std::map<std::int32_t, std::int32_t> back;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i] == kNoiseLabel, b[i] == kNoiseLabel) << i;
    ASSERT_EQ(forth.emplace(a[i], b[i]).first->second, b[i]) << i;
    ASSERT_EQ(back.emplace(b[i], a[i]).first->second, a[i]) << i;
  }
}

TEST(AdaptiveScaleProperty, RisesStrictlyWithinItsBoundsAndIsOneAtTheAnchor) {
  for_each_seed(200, [](Rng& rng) {
    AdaptationOptions options;
    options.min_scale = rng.uniform(0.05, 0.9);
    options.max_scale = rng.uniform(1.1, 5.0);
    options.steepness = rng.uniform(0.1, 30.0);
    options.anchor = rng.uniform(-1.0, 2.0);
    ASSERT_TRUE(options.validate().ok());
    EXPECT_NEAR(adaptive_scale(options.anchor, options), 1.0, 1e-14);
    for (const AdaptationForm form : {AdaptationForm::kAnchored, AdaptationForm::kMinMaxSigmoid}) {
      options.form = form;
      const double middle = form == AdaptationForm::kAnchored ? options.anchor : 0.0;
      // Beyond twenty the exponential is near the rounding of its sum with 1.
      double below = options.min_scale;
      for (double x = -20.0; x <= 20.0; x += rng.uniform(0.1, 1.0)) {
        const double scale = adaptive_scale(middle + x / options.steepness, options);
        ASSERT_GT(scale, below) << x;
        ASSERT_LT(scale, options.max_scale) << x;
        below = scale;
      }
    }
    options.form = AdaptationForm::kLiteral;
    const double x = rng.uniform(0.0, 1.0);
    EXPECT_GE(adaptive_scale(x, options), 0.5 * (options.min_scale + options.max_scale));
    EXPECT_LT(adaptive_scale(x, options), options.min_scale + options.max_scale);
  });
}

TEST(AdaptiveDbscanProperty, ParametersFollowTheReliability) {
  for_each_seed(100, [](Rng& rng) {
    AdaptiveDbscanOptions options = random_options(rng);
    const FrameReliability reliability = random_reliability(rng);
    const AdaptiveDbscanResult result = run_adaptive({}, options, reliability).result;
    const double eps_scale = adaptive_scale(reliability.scene, options.eps_adaptation);
    EXPECT_DOUBLE_EQ(result.eps, options.eps_base * eps_scale);
    const double wanted = options.min_points_base *
                          adaptive_scale(reliability.features / 2.0, options.min_points_adaptation);
    // A real number of neighbours is reached by the next whole one, two being the least.
    EXPECT_GE(result.min_points, wanted);
    EXPECT_GE(result.min_points, 2);
    if (result.min_points > 2) {
      EXPECT_LT(result.min_points - 1, wanted);
    }
    const FrameReliability better = {reliability.scene + 0.1, reliability.features + 0.2};
    const AdaptiveDbscanResult of_better = run_adaptive({}, options, better).result;
    EXPECT_GT(of_better.eps, result.eps);
    EXPECT_GE(of_better.min_points, result.min_points);
  });
}

TEST(AdaptiveDbscanProperty, IsWhatItsDefinitionSays) {
  for_each_seed(150, [](Rng& rng) {
    const PinholeCamera camera = test::random_flow_camera(rng);
    const std::vector<FlowPoint> points =
        test::bodies_and_background(rng.uniform_int(0, 300), camera, rng);
    std::vector<float> potential_depth_m;
    if (rng.coin()) {
      for (const FlowPoint& point : test::bodies_and_background(400, camera, rng)) {
        potential_depth_m.push_back(point.depth_m);
      }
    }
    expect_definition(points, random_options(rng), random_reliability(rng), camera,
                      potential_depth_m);
  });
}

TEST(AdaptiveDbscanProperty, FewPointsOddDepthsAndCoordinatesAreNoExceptions) {
  for_each_seed(300, [](Rng& rng) {
    const PinholeCamera camera = test::flow_camera();
    const float odd[] = {float(test::kNan),
                         float(test::kInf),
                         -float(test::kInf),
                         0.0F,
                         -1.0F,
                         std::numeric_limits<float>::denorm_min(),
                         std::numeric_limits<float>::max()};
    std::vector<FlowPoint> points(std::size_t(rng.uniform_int(0, 5)));
    const bool equal_depths = rng.coin();
    for (FlowPoint& point : points) {
      point.u_px = float(rng.uniform_int(100, 104));
      point.v_px = float(rng.uniform_int(100, 104));
      point.depth_m = equal_depths ? 2.0F : float(rng.uniform(1.0, 3.0));
      if (!equal_depths && rng.coin()) point.depth_m = odd[rng.uniform_int(0, 6)];
      if (rng.uniform(0.0, 1.0) < 0.1) point.u_px = odd[rng.uniform_int(0, 2)];
    }
    expect_definition(points, random_options(rng), random_reliability(rng), camera);
  });
}

TEST(AdaptiveDbscanProperty, OneGroupOfDepthIsPlainDbscan) {
  for_each_seed(60, [](Rng& rng) {
    const PinholeCamera camera = test::random_flow_camera(rng);
    std::vector<FlowPoint> points =
        test::bodies_and_background(rng.uniform_int(1, 400), camera, rng);
    for (FlowPoint& point : points) {
      if (!has_depth(point)) point.depth_m = float(rng.uniform(0.5, 5.0));
    }
    AdaptiveDbscanOptions options = random_options(rng);
    options.group_depths = true;
    options.depth_groups.threshold = DepthThreshold::kClamped;
    options.depth_groups.min_threshold_m = options.depth_groups.max_threshold_m = 1e6;
    const FrameReliability reliability = random_reliability(rng);
    const AdaptiveRun grouped = run_adaptive(points, options, reliability, camera);
    ASSERT_EQ(grouped.workspace.groups.size(), 1U);
    options.group_depths = false;
    const AdaptiveRun plain = run_adaptive(points, options, reliability, camera);
    EXPECT_EQ(grouped.labels, plain.labels);
    EXPECT_EQ(grouped.workspace.kinds, plain.workspace.kinds);
    if (options.space == ClusterSpace::kMetric) return;

    const std::array<float, 2> unit = detail::image_unit(options.space, camera);
    std::vector<std::array<float, 2>> image_points;
    image_points.reserve(points.size());
    for (const FlowPoint& p : points) image_points.push_back({p.u_px * unit[0], p.v_px * unit[1]});
    DbscanOptions plain_options;
    plain_options.eps = grouped.result.eps;
    plain_options.min_points = grouped.result.min_points;
    DbscanWorkspace<float> workspace;
    std::vector<std::int32_t> labels(points.size());
    ASSERT_TRUE(dbscan(image_points, plain_options, workspace, labels).status.ok());
    EXPECT_EQ(grouped.labels, labels);
    EXPECT_EQ(grouped.workspace.kinds, workspace.kinds);
  });
}

TEST(AdaptiveDbscanProperty, WideEpsGivesAClusterAGroupAndNarrowEpsNoise) {
  for_each_seed(60, [](Rng& rng) {
    const PinholeCamera camera = test::random_flow_camera(rng);
    const std::vector<FlowPoint> points =
        test::bodies_and_background(rng.uniform_int(1, 300), camera, rng);
    AdaptiveDbscanOptions options = random_options(rng);
    options.space = kSpaces[rng.uniform_int(0, 2)];
    options.min_points_base = 1.0;
    options.eps_base = 1e3;
    const AdaptiveRun wide = run_adaptive(points, options, {0.2, 0.0}, camera);
    ASSERT_EQ(wide.result.min_points, 2) << "what is alone is no cluster";
    int num_of_several = 0;
    for (const GroupClusters& group : wide.workspace.groups) {
      EXPECT_EQ(group.num_clusters, group.num_points >= 2 ? 1 : 0);
      num_of_several += group.num_points >= 2 ? 1 : 0;
    }
    EXPECT_EQ(wide.result.num_clusters, num_of_several);
    options.eps_base = 1e-8;
    const AdaptiveRun narrow = run_adaptive(points, options, {0.2, 0.0}, camera);
    EXPECT_EQ(narrow.result.num_clusters, 0);
    EXPECT_EQ(std::count(narrow.labels.begin(), narrow.labels.end(), kNoiseLabel),
              std::ptrdiff_t(points.size()));
  });
}

TEST(AdaptiveDbscanProperty, OrderOfThePointsChangesNothingButNumbers) {
  for_each_seed(80, [](Rng& rng) {
    const PinholeCamera camera = test::random_flow_camera(rng);
    const std::vector<FlowPoint> points =
        test::bodies_and_background(rng.uniform_int(1, 400), camera, rng);
    const AdaptiveDbscanOptions options = random_options(rng);
    const FrameReliability reliability = random_reliability(rng);
    const AdaptiveRun before = run_adaptive(points, options, reliability, camera);
    const std::vector<std::size_t> order = test::random_order(points.size(), rng);
    std::vector<FlowPoint> shuffled;
    shuffled.reserve(order.size());
    for (const std::size_t i : order) shuffled.push_back(points[i]);
    const AdaptiveRun after = run_adaptive(shuffled, options, reliability, camera);
    EXPECT_EQ(before.result.depth.threshold_m, after.result.depth.threshold_m);
    std::vector<std::int32_t> labels(points.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      labels[order[k]] = after.labels[k];
      ASSERT_EQ(after.workspace.kinds[k], before.workspace.kinds[order[k]]);
    }
    expect_same_partition(before.labels, labels);
  });
}

TEST(AdaptiveDbscanProperty, ShiftsAndMirrorsThatRoundNothingChangeNothing) {
  // A width that is a power of two, quarters of pixels and 64ths of metres: every difference is
  // exact.
  const PinholeCamera camera = test::flow_camera(512);
  for_each_seed(60, [&](Rng& rng) {
    std::vector<FlowPoint> points(std::size_t(rng.uniform_int(10, 400)));
    for (FlowPoint& point : points) {
      point.u_px = 0.25F * float(rng.uniform_int(0, 1023));
      point.v_px = 0.25F * float(rng.uniform_int(0, 767));
      point.depth_m = float(rng.uniform_int(32, 256)) / 64.0F;
    }
    AdaptiveDbscanOptions options;
    options.eps_base = rng.uniform(0.01, 0.06);
    const FrameReliability reliability = random_reliability(rng);
    const auto expect_like = [&](const AdaptiveRun& before, const char* what, float u_sign,
                                 float z_sign) {
      SCOPED_TRACE(what);
      std::vector<FlowPoint> moved = points;
      for (FlowPoint& point : moved) {
        point.u_px = 300.0F + u_sign * point.u_px;
        point.v_px += 100.0F;
        point.depth_m = 8.0F + z_sign * point.depth_m;
      }
      const AdaptiveRun after = run_adaptive(moved, options, reliability, camera);
      ASSERT_EQ(before.workspace.kinds, after.workspace.kinds);
      std::vector<std::int32_t> labels_before = before.labels;
      std::vector<std::int32_t> labels_after = after.labels;
      for (std::size_t i = 0; i < points.size(); ++i) {
        // Between two equally near core points the coordinates decide, and a mirror turns them.
        if (u_sign < 0.0F && before.workspace.kinds[i] == PointKind::kBorder) {
          labels_before[i] = labels_after[i] = kNoiseLabel;
        }
      }
      expect_same_partition(labels_before, labels_after);
    };
    const AdaptiveRun before = run_adaptive(points, options, reliability, camera);
    expect_like(before, "shifted", 1.0F, 1.0F);
    expect_like(before, "mirrored", -1.0F, 1.0F);
    // The interquartile range is not the same in a mirror of the depths; a given threshold is.
    options.depth_groups.max_threshold_m = options.depth_groups.min_threshold_m;
    expect_like(run_adaptive(points, options, reliability, camera), "depth mirrored", 1.0F, -1.0F);
  });
}

TEST(AdaptiveDbscanProperty, ComparesNoMoreThanThePairsOfEachGroup) {
  for_each_seed(30, [](Rng& rng) {
    const PinholeCamera camera = test::random_flow_camera(rng);
    const std::vector<FlowPoint> points =
        test::bodies_and_background(rng.uniform_int(1, 3000), camera, rng);
    AdaptiveDbscanOptions options = random_options(rng);
    const FrameReliability reliability = random_reliability(rng);
    options.search = NeighborSearch::kBruteForce;
    for (const GroupClusters& group :
         run_adaptive(points, options, reliability, camera).workspace.groups) {
      // Where neighbours cannot be written down, core points are met once more while clusters grow.
      const std::uint64_t num_pairs = std::uint64_t(group.num_points) * group.num_points;
      EXPECT_LE(group.num_comparisons, group.num_points <= 512 ? num_pairs : 2 * num_pairs);
    }
    options.search = NeighborSearch::kAutomatic;
    const AdaptiveRun run = run_adaptive(points, options, reliability, camera);
    std::uint64_t num_pairs = 0;
    for (const GroupClusters& group : run.workspace.groups) {
      EXPECT_LE(group.num_comparisons, std::uint64_t(group.num_points) * group.num_points);
      num_pairs += std::uint64_t(group.num_points) * group.num_points;
    }
    EXPECT_LE(run.result.num_comparisons, num_pairs);
    // What the groups can save at best: n² / N, by Cauchy and Schwarz.
    const auto n = std::uint64_t(points.size());
    EXPECT_GE(num_pairs * run.workspace.groups.size(), n * n);
  });
}

}  // namespace
}  // namespace srslam
