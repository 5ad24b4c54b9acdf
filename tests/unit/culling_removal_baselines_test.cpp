#include "srslam/culling/removal_baselines.hpp"

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

constexpr RemovalBaseline kBaselines[] = {RemovalBaseline::kProportion, RemovalBaseline::kKMeans,
                                          RemovalBaseline::kConvexHull, RemovalBaseline::kDbscan};

struct BoxedScene {
  std::vector<FlowPoint> points;
  std::vector<FeatureSuspicion> features;
  std::vector<Detection> boxes;

  void add(float u_px, float v_px, float depth_m, bool anomalous, bool in_object = true) {
    points.push_back({u_px, v_px, depth_m, in_object});
    FeatureSuspicion feature;
    feature.anomalies = anomalous ? kFlowAnomaly : kNoAnomaly;
    feature.in_object = in_object;
    features.push_back(feature);
  }
  void add_box(double x_min_px, double x_max_px) {
    Detection box;
    box.class_name = "person";
    box.score = 0.9;
    box.x_min_px = x_min_px;
    box.x_max_px = x_max_px;
    box.y_min_px = 0.0;
    box.y_max_px = 479.0;
    boxes.push_back(box);
  }
};

std::vector<std::uint8_t> removed_by(RemovalBaseline baseline, const BoxedScene& scene,
                                     const RemovalBaselineOptions& options = {}) {
  RemovalBaselineWorkspace workspace;
  std::vector<std::uint8_t> removed(scene.points.size(), 7);
  const RemovalBaselineResult result =
      remove_by_baseline(baseline, scene.points, scene.features, scene.boxes, test::flow_camera(),
                         options, workspace, removed);
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  int num_removed = 0;
  for (const std::uint8_t gone : removed) num_removed += gone;
  EXPECT_EQ(result.num_removed, num_removed);
  return removed;
}

TEST(RemovalBaselines, ProportionTakesABoxOrItsAnomalies) {
  BoxedScene scene;
  scene.add_box(0.0, 100.0);
  scene.add_box(200.0, 300.0);
  for (int i = 0; i < 10; ++i) scene.add(10.0F + float(i), 50.0F, 2.0F, i < 3);   // 30 %
  for (int i = 0; i < 10; ++i) scene.add(210.0F + float(i), 50.0F, 2.0F, i < 2);  // 20 %
  scene.add(400.0F, 50.0F, 2.0F, true, false);
  scene.add(410.0F, 50.0F, 2.0F, false, false);
  EXPECT_THAT(removed_by(RemovalBaseline::kProportion, scene),
              ElementsAre(1, 1, 1, 1, 1, 1, 1, 1, 1, 1,  //
                          1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0));
  RemovalBaselineOptions options;
  options.min_anomalous_share = 0.5;
  EXPECT_THAT(removed_by(RemovalBaseline::kProportion, scene, options),
              ElementsAre(1, 1, 1, 0, 0, 0, 0, 0, 0, 0,  //
                          1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0));
}

TEST(RemovalBaselines, ConvexHullTakesWhatLiesBetweenAnomalies) {
  BoxedScene scene;
  scene.add_box(0.0, 200.0);
  scene.add(10.0F, 10.0F, 2.0F, true);
  scene.add(110.0F, 10.0F, 2.0F, true);
  scene.add(110.0F, 110.0F, 2.0F, true);
  scene.add(10.0F, 110.0F, 2.0F, true);
  scene.add(60.0F, 60.0F, 5.0F, false);         // inside, however deep
  scene.add(115.0F, 60.0F, 2.0F, false);        // outside
  scene.add(10.0F, 60.0F, 2.0F, false);         // on the rim
  scene.add(160.0F, 60.0F, 3.5F, true);         // an anomaly behind: not of the hull
  scene.add(60.0F, 60.0F, 2.0F, false, false);  // of no object
  EXPECT_THAT(removed_by(RemovalBaseline::kConvexHull, scene),
              ElementsAre(1, 1, 1, 1, 1, 0, 1, 1, 0));
  scene.features[0].anomalies = scene.features[1].anomalies = kNoAnomaly;
  EXPECT_THAT(removed_by(RemovalBaseline::kConvexHull, scene),
              ElementsAre(0, 0, 1, 1, 0, 0, 0, 1, 0))
      << "two corners are no hull";
}

TEST(RemovalBaselines, ConvexHullIsTheHull) {
  std::vector<std::array<float, 2>> points = {{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2},
                                              {1, 0}, {2, 1}, {0, 0}, {1, 2}};
  std::vector<std::array<float, 2>> hull;
  detail::convex_hull(points, hull);
  using P = std::array<float, 2>;
  EXPECT_THAT(hull, ElementsAre(P{0, 0}, P{2, 0}, P{2, 2}, P{0, 2}));
  points = {{1, 1}, {1, 1}, {1, 1}};
  detail::convex_hull(points, hull);
  EXPECT_LT(hull.size(), 3U);
  points = {{0, 0}, {1, 1}, {2, 2}, {3, 3}};
  detail::convex_hull(points, hull);
  EXPECT_FALSE(detail::in_hull(hull, {1.0F, 1.0F, 0.0F, false}));
}

TEST(RemovalBaselines, KMeansPartsInTwoByPlaceAndDepth) {
  BoxedScene scene;
  for (int i = 0; i < 10; ++i) scene.add(100.0F + float(i), 50.0F, 1.0F, i < 4);
  for (int i = 0; i < 10; ++i) scene.add(100.0F + float(i), 50.0F, 3.0F, i < 1);
  scene.add(105.0F, 50.0F, 1.0F, false, false);  // no potential feature
  const std::vector<std::uint8_t> removed = removed_by(RemovalBaseline::kKMeans, scene);
  for (std::size_t i = 0; i < scene.points.size(); ++i) EXPECT_EQ(removed[i], i < 10 ? 1 : 0) << i;
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    RemovalBaselineOptions options;
    options.seed = seed;
    EXPECT_EQ(removed_by(RemovalBaseline::kKMeans, scene, options), removed);
  }
}

TEST(RemovalBaselines, DbscanTakesClustersWithoutRegardToDepth) {
  BoxedScene scene;
  for (int i = 0; i < 4; ++i) scene.add(100.0F + float(i), 50.0F, i % 2 == 0 ? 1.0F : 3.0F, true);
  scene.add(105.0F, 50.0F, 4.0F, false);         // near them
  scene.add(105.0F, 50.0F, 4.0F, false, false);  // near, but not potential
  scene.add(300.0F, 50.0F, 1.0F, true);          // alone: noise
  EXPECT_THAT(removed_by(RemovalBaseline::kDbscan, scene), ElementsAre(1, 1, 1, 1, 1, 0, 0));
}

TEST(RemovalBaselines, NothingSuspectedNothingRemoved) {
  BoxedScene scene;
  scene.add_box(0.0, 639.0);
  for (const RemovalBaseline baseline : kBaselines) {
    EXPECT_TRUE(removed_by(baseline, scene).empty());
    BoxedScene quiet = scene;
    for (int i = 0; i < 20; ++i) quiet.add(float(10 * i), 50.0F, 2.0F, false);
    EXPECT_THAT(removed_by(baseline, quiet), Each(0)) << to_string(baseline);
    BoxedScene odd = quiet;
    odd.add(float(test::kNan), 50.0F, float(test::kInf), true);
    odd.add(50.0F, float(test::kInf), 0.0F, true);
    removed_by(baseline, odd);
  }
}

TEST(RemovalBaselines, RefuseWhatTheyCannotDo) {
  BoxedScene scene;
  scene.add(10.0F, 10.0F, 1.0F, true);
  RemovalBaselineWorkspace workspace;
  RemovalBaselineOptions bad[5];
  bad[0].min_anomalous_share = 1.5;
  bad[1].max_iterations = 0;
  bad[2].eps = 0.0;
  bad[3].min_points = 0;
  bad[4].depth.min_threshold_m = -1.0;
  for (const RemovalBaselineOptions& options : bad) {
    std::vector<std::uint8_t> removed(1, 7);
    EXPECT_EQ(remove_by_baseline(RemovalBaseline::kKMeans, scene.points, scene.features, {},
                                 test::flow_camera(), options, workspace, removed)
                  .status.code,
              StatusCode::kInvalidArgument);
    EXPECT_EQ(removed[0], 0);
  }
  std::vector<std::uint8_t> none;
  EXPECT_EQ(remove_by_baseline(RemovalBaseline::kKMeans, scene.points, scene.features, {},
                               test::flow_camera(), {}, workspace, none)
                .status.code,
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace srslam
