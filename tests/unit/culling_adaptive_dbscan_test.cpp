#include "srslam/culling/adaptive_dbscan.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/constants.hpp"

namespace srslam {
namespace {

using testing::ElementsAre;

PinholeCamera adaptive_camera() {
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 500.0;
  camera.fy_px = 400.0;
  camera.cx_px = 320.0;
  camera.cy_px = 240.0;
  return camera;
}

struct AdaptiveClusters {
  AdaptiveDbscanResult result;
  std::vector<std::int32_t> labels;
  AdaptiveDbscanWorkspace workspace;
};

AdaptiveClusters cluster(const std::vector<FlowPoint>& points, const AdaptiveDbscanOptions& options,
                         const FrameReliability& reliability = {0.2, 1.0},
                         const std::vector<float>& potential_depth_m = {}) {
  AdaptiveClusters clusters;
  clusters.labels.assign(points.size(), 77);
  clusters.result = adaptive_dbscan(points, potential_depth_m, adaptive_camera(), reliability,
                                    options, clusters.workspace, clusters.labels);
  return clusters;
}

/// Points at one place of the image, `count` at each depth.
std::vector<FlowPoint> stack(const std::vector<float>& depth_m, int count) {
  std::vector<FlowPoint> points;
  for (int i = 0; i < count; ++i) {
    for (const float depth : depth_m) points.push_back({100.0F + float(i), 200.0F, depth, false});
  }
  return points;
}

TEST(AdaptiveScale, AsPrintedIsNeverBelowFiveQuarters) {
  AdaptationOptions options;
  options.form = AdaptationForm::kLiteral;
  EXPECT_DOUBLE_EQ(adaptive_scale(0.0, options), 1.25);
  // 2.5 / (1 + exp(-1)) = 1.827646...
  EXPECT_NEAR(adaptive_scale(0.2, options), 1.8276464, 1e-6);
  EXPECT_NEAR(adaptive_scale(1.0, options), 2.4832678, 1e-6);
  EXPECT_GT(adaptive_scale(std::log(4.0) / 5.0 + 1e-6, options), options.max_scale)
      << "beyond the bound that the paper gives";
  options.form = AdaptationForm::kLiteralClamped;
  EXPECT_DOUBLE_EQ(adaptive_scale(0.0, options), 1.25);
  EXPECT_DOUBLE_EQ(adaptive_scale(1.0, options), 2.0);
}

TEST(AdaptiveScale, WithTheLikelyTypingErrorMended) {
  AdaptationOptions options;
  options.form = AdaptationForm::kMinMaxSigmoid;
  EXPECT_DOUBLE_EQ(adaptive_scale(0.0, options), 1.25);
  EXPECT_NEAR(adaptive_scale(0.2, options), 0.5 + 1.5 * 0.7310586, 1e-6);
}

TEST(AdaptiveScale, AnchoredIsOneAtItsAnchor) {
  AdaptationOptions options;
  EXPECT_DOUBLE_EQ(adaptive_scale(0.2, options), 1.0);
  // 0.5 + 1.5 / (1 + 2 e^1), 0.5 + 1.5 / (1 + 2 e^-1.35), 0.5 + 1.5 / (1 + 2 e^-4)
  EXPECT_NEAR(adaptive_scale(0.0, options), 0.7330, 1e-4);
  EXPECT_NEAR(adaptive_scale(0.47, options), 1.48783, 1e-5);
  EXPECT_NEAR(adaptive_scale(1.0, options), 1.9470, 1e-4);
  options.anchor = 0.5;
  options.min_scale = 0.25;
  options.max_scale = 4.0;
  EXPECT_DOUBLE_EQ(adaptive_scale(0.5, options), 1.0);
}

TEST(AdaptiveScale, RisesWithinItsBounds) {
  for (const AdaptationForm form :
       {AdaptationForm::kAnchored, AdaptationForm::kMinMaxSigmoid, AdaptationForm::kLiteral}) {
    AdaptationOptions options;
    options.form = form;
    double before = -1.0;
    for (double x = -1.0; x <= 2.0; x += 0.05) {
      const double scale = adaptive_scale(x, options);
      EXPECT_GT(scale, before);
      if (form != AdaptationForm::kLiteral) {
        EXPECT_GT(scale, options.min_scale);
        EXPECT_LT(scale, options.max_scale);
      }
      before = scale;
    }
    EXPECT_TRUE(std::isfinite(adaptive_scale(1e6, options)));
    EXPECT_TRUE(std::isfinite(adaptive_scale(-1e6, options)));
  }
}

TEST(AdaptiveDbscan, BaseValuesHoldAtTheAnchors) {
  const AdaptiveClusters at_anchor = cluster({}, {});
  ASSERT_TRUE(at_anchor.result.status.ok());
  EXPECT_DOUBLE_EQ(at_anchor.result.eps, 0.06);
  EXPECT_EQ(at_anchor.result.min_points, 3);
  // Better scenes search wider (Eq. 13), richer ones ask for more points (Eq. 14).
  const AdaptiveClusters better = cluster({}, {}, {0.47, 2.0});
  EXPECT_NEAR(better.result.eps, 0.06 * 1.48783, 3e-7);
  EXPECT_EQ(better.result.min_points, 6) << "3 * 1.98 rounded up";
  const AdaptiveClusters worse = cluster({}, {}, {0.0, 0.0});
  EXPECT_NEAR(worse.result.eps, 0.06 * 0.7330, 3e-6);
  EXPECT_EQ(worse.result.min_points, 2);
  AdaptiveDbscanOptions literal;
  literal.eps_base = 0.02;
  literal.eps_adaptation.form = AdaptationForm::kLiteral;
  literal.min_points_adaptation.form = AdaptationForm::kLiteral;
  const AdaptiveClusters as_printed = cluster({}, literal, {0.0, 0.0});
  EXPECT_DOUBLE_EQ(as_printed.result.eps, 0.025);
  EXPECT_EQ(as_printed.result.min_points, 4) << "3.75 rounded up";
}

TEST(AdaptiveDbscan, DepthsPartWhatTheImageJoins) {
  const std::vector<FlowPoint> points = stack({1.0F, 2.5F}, 5);
  const AdaptiveClusters parted = cluster(points, {});
  EXPECT_EQ(parted.result.num_clusters, 2);
  EXPECT_THAT(parted.labels, ElementsAre(0, 1, 0, 1, 0, 1, 0, 1, 0, 1));
  ASSERT_EQ(parted.workspace.groups.size(), 2U);
  EXPECT_EQ(parted.workspace.groups[1].min_depth_m, 2.5F);
  AdaptiveDbscanOptions together;
  together.group_depths = false;
  EXPECT_EQ(cluster(points, together).result.num_clusters, 1);
  // As printed the interquartile range reaches from one to the other.
  AdaptiveDbscanOptions literal;
  literal.depth_groups.threshold = DepthThreshold::kLiteral;
  const AdaptiveClusters as_printed = cluster(points, literal);
  EXPECT_EQ(as_printed.result.num_clusters, 1);
  EXPECT_EQ(as_printed.result.depth.threshold_m, 1.5F);
  // Unless the two bodies are few among the potential points.
  std::vector<float> potential_m(20, 1.0F);
  potential_m.insert(potential_m.end(), 5, 2.5F);
  EXPECT_EQ(cluster(points, literal, {0.2, 1.0}, potential_m).result.num_clusters, 2);
}

TEST(AdaptiveDbscan, PointsWithoutDepthAreAGroupOfTheirOwn) {
  const std::vector<FlowPoint> points = stack({1.0F, float(test::kNan)}, 4);
  const AdaptiveClusters found = cluster(points, {});
  EXPECT_THAT(found.labels, ElementsAre(0, 1, 0, 1, 0, 1, 0, 1));
  ASSERT_EQ(found.workspace.groups.size(), 2U);
  EXPECT_EQ(found.workspace.groups[1].min_depth_m, 0.0F);
  const AdaptiveClusters none = cluster(stack({0.0F}, 4), {});
  EXPECT_TRUE(none.result.status.ok());
  EXPECT_EQ(none.result.depth.status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(none.result.num_clusters, 1);
  AdaptiveDbscanOptions metric;
  metric.space = ClusterSpace::kMetric;
  EXPECT_THAT(cluster(points, metric).labels,
              ElementsAre(0, kNoiseLabel, 0, kNoiseLabel, 0, kNoiseLabel, 0, kNoiseLabel));
}

TEST(AdaptiveDbscan, ComparesOnceAGroup) {
  // Four groups of the same size: a quarter of the pairs.
  AdaptiveDbscanOptions options;
  options.search = NeighborSearch::kBruteForce;
  const std::vector<FlowPoint> points = stack({1.0F, 2.0F, 3.0F, 4.0F}, 10);
  const AdaptiveClusters parted = cluster(points, options);
  EXPECT_EQ(parted.result.num_comparisons, 4U * 10U * 10U);
  for (const GroupClusters& group : parted.workspace.groups) {
    EXPECT_EQ(group.num_comparisons, 100U);
    EXPECT_EQ(group.num_points, 10U);
  }
  options.group_depths = false;
  EXPECT_EQ(cluster(points, options).result.num_comparisons, 40U * 40U);
}

TEST(AdaptiveDbscan, EpsIsInTheUnitOfTheSpace) {
  // Two groups of three, `distance` pixels apart along u and along v.
  const auto num_clusters = [](ClusterSpace space, double eps_base, float du_px, float dv_px) {
    std::vector<FlowPoint> points;
    for (int i = 0; i < 3; ++i) {
      points.push_back({100.0F, 100.0F, 2.0F, false});
      points.push_back({100.0F + du_px, 100.0F + dv_px, 2.0F, false});
    }
    AdaptiveDbscanOptions options;
    options.space = space;
    options.eps_base = eps_base;
    return cluster(points, options).result.num_clusters;
  };
  EXPECT_EQ(num_clusters(ClusterSpace::kImageWidth, 0.02, 12.7F, 0.0F), 1);
  EXPECT_EQ(num_clusters(ClusterSpace::kImageWidth, 0.02, 0.0F, 12.9F), 2);
  EXPECT_EQ(num_clusters(ClusterSpace::kImageDiagonal, 0.02, 15.9F, 0.0F), 1);
  EXPECT_EQ(num_clusters(ClusterSpace::kImageDiagonal, 0.02, 0.0F, 16.1F), 2);
  EXPECT_EQ(num_clusters(ClusterSpace::kFocalLength, 0.02, 9.9F, 0.0F), 1);
  EXPECT_EQ(num_clusters(ClusterSpace::kFocalLength, 0.02, 0.0F, 8.1F), 2);
  // 2 m away a pixel is 4 mm wide and 5 mm high.
  EXPECT_EQ(num_clusters(ClusterSpace::kMetric, 0.02, 4.9F, 0.0F), 1);
  EXPECT_EQ(num_clusters(ClusterSpace::kMetric, 0.02, 0.0F, 4.1F), 2);
}

TEST(AdaptiveDbscan, RefusesWhatItCannotDo) {
  const std::vector<FlowPoint> points = stack({1.0F}, 3);
  const auto code_of = [&](const AdaptiveDbscanOptions& options,
                           const FrameReliability& reliability = {}) {
    const AdaptiveClusters clusters = cluster(points, options, reliability);
    EXPECT_THAT(clusters.labels, ElementsAre(77, 77, 77));
    return clusters.result.status.code;
  };
  EXPECT_EQ(code_of({}, {test::kNan, 1.0}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of({}, {0.5, test::kInf}), StatusCode::kInvalidArgument);
  for (const double eps : {0.0, -1.0, test::kNan, test::kInf, 1e-40}) {
    AdaptiveDbscanOptions options;
    options.eps_base = eps;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument) << eps;
  }
  for (const double min_points : {0.5, 1e7, test::kNan}) {
    AdaptiveDbscanOptions options;
    options.min_points_base = min_points;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument) << min_points;
  }
  AdaptationOptions bad[6];
  bad[0].min_scale = 0.0;
  bad[1].min_scale = 1.0;
  bad[2].max_scale = 1.0;
  bad[3].steepness = 0.0;
  bad[4].anchor = test::kNan;
  bad[5].max_scale = test::kInf;
  for (const AdaptationOptions& adaptation : bad) {
    AdaptiveDbscanOptions options;
    options.eps_adaptation = adaptation;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
    options = {};
    options.min_points_adaptation = adaptation;
    EXPECT_EQ(code_of(options), StatusCode::kInvalidArgument);
  }
  AdaptiveDbscanOptions kd_tree;
  kd_tree.search = NeighborSearch::kKdTree;
  EXPECT_EQ(code_of(kd_tree), StatusCode::kInvalidArgument);
  AdaptiveDbscanWorkspace workspace;
  std::vector<std::int32_t> too_few(2);
  EXPECT_EQ(adaptive_dbscan(points, {}, adaptive_camera(), {}, {}, workspace, too_few).status.code,
            StatusCode::kInvalidArgument);
  std::vector<std::int32_t> labels(3);
  EXPECT_EQ(adaptive_dbscan(points, {}, {}, {}, {}, workspace, labels).status.code,
            StatusCode::kInvalidArgument)
      << "a camera without a size";
}

}  // namespace
}  // namespace srslam
