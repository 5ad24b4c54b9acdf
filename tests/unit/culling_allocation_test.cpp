#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/culling/dbscan.hpp"
#include "srslam/culling/dynamic_culling.hpp"
#include "srslam/culling/dynamic_regions.hpp"
#include "srslam/culling/removal_baselines.hpp"
#include "support/allocation_counter.hpp"
#include "support/cluster_inputs.hpp"
#include "support/culling_scene.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

TEST(CullingAllocation, ClusteringAStreamAllocatesOnlyAtItsStart) {
  DbscanOptions options;
  options.eps = 0.06;
  for (const NeighborSearch search :
       {NeighborSearch::kBruteForce, NeighborSearch::kSweep, NeighborSearch::kGrid}) {
    for (const std::size_t n : {200U, 2000U}) {
      options.search = search;
      DbscanWorkspace<float> workspace;
      std::vector<std::array<float, 3>> points(n);
      std::vector<std::int32_t> labels(n);
      const auto cluster_frames = [&](std::size_t count) {
        for (std::size_t frame = 0; frame < count; ++frame) {
          for (std::size_t i = 0; i < n; ++i) {
            const std::size_t k = i + frame;
            points[i] = {float((37 * k) % 101) / 101.0F, float((53 * k) % 97) / 97.0F,
                         float((71 * k) % 89) / 89.0F};
          }
          ASSERT_TRUE(dbscan(points, options, workspace, labels).status.ok());
        }
      };
      EXPECT_GT(test::count_allocations([&] { cluster_frames(10); }), 0U);
      EXPECT_EQ(test::count_allocations([&] { cluster_frames(40); }), 0U) << to_string(search);
    }
  }
}

TEST(CullingAllocation, HowPointsAreSpreadDoesNotMatter) {
  // From points that see none of the others to points that see all of them.
  for (const NeighborSearch search : {NeighborSearch::kBruteForce, NeighborSearch::kSweep}) {
    for (const std::size_t n : {100U, 500U, 3000U}) {
      DbscanOptions options;
      options.search = search;
      DbscanWorkspace<float> workspace;
      std::vector<std::int32_t> labels(n);
      const auto points = test::cluster_input<float, 2>(test::ClusterInput::kUniform, n, &options);
      options.eps = 1e-4;
      ASSERT_TRUE(dbscan(points, options, workspace, labels).status.ok());
      const std::size_t num_allocations = test::count_allocations([&] {
        for (const double eps : {1e-3, 1e-2, 1e-1, 1.0, 10.0}) {
          options.eps = eps;
          ASSERT_TRUE(dbscan(points, options, workspace, labels).status.ok());
        }
      });
      EXPECT_EQ(num_allocations, 0U) << n << ' ' << to_string(search);
    }
  }
}

/// Frames with as many tracks each, of which more or fewer move; the one with the most is the
/// first.
std::vector<std::vector<FlowTrack>> stream_of_tracks(test::FlowScene* scene) {
  std::vector<std::vector<FlowTrack>> frames;
  scene->num_tracks = 1000;
  scene->detected_share = 0.5;
  for (int frame = 0; frame < 8; ++frame) {
    scene->seed = std::uint64_t(frame + 1);
    scene->mover_share = 0.35 - 0.04 * frame;
    frames.push_back(scene->tracks());
  }
  return frames;
}

TEST(CullingAllocation, FindingRegionsInAStreamAllocatesOnlyAtItsStart) {
  test::FlowScene scene;
  const std::vector<std::vector<FlowTrack>> frames = stream_of_tracks(&scene);
  std::vector<Detection> detections(2);
  for (Detection& box : detections) {
    box.class_name = "person";
    box.score = 0.9;
    box.x_max_px = 200.0;
    box.y_max_px = 400.0;
  }
  std::vector<FeatureSuspicion> features(1000);
  for (const FlowModel model : {FlowModel::kRigid, FlowModel::kAffine}) {
    for (const EpipolarSource source :
         {EpipolarSource::kCameraMotion, EpipolarSource::kEightPoint}) {
      DynamicRegionOptions options;
      options.flow_model = model;
      options.epipolar_source = source;
      options.use_depth = true;
      DynamicRegionWorkspace workspace;
      const auto find_in_frames = [&] {
        for (const std::vector<FlowTrack>& tracks : frames) {
          DynamicRegionInput input;
          input.tracks = tracks;
          input.detections = detections;
          const DynamicRegionsResult result =
              find_dynamic_regions(input, scene.camera, options, workspace, features);
          ASSERT_TRUE(result.status.ok());
          ASSERT_NE(result.epipolar, SkippedTest::kNoParallax);
          ASSERT_GT(result.num_anomalies, 0);
        }
      };
      EXPECT_GT(test::count_allocations(find_in_frames), 0U);
      EXPECT_EQ(test::count_allocations(find_in_frames), 0U);
    }
  }
}

TEST(CullingAllocation, CullingAStreamAllocatesOnlyAtItsStart) {
  const PinholeCamera camera = test::flow_camera();
  test::Rng rng(3);
  std::vector<std::vector<FlowPoint>> frames;
  std::vector<std::vector<FeatureSuspicion>> suspicions;
  std::vector<Detection> boxes(1);
  boxes[0].class_name = "person";
  boxes[0].x_max_px = 640.0;
  boxes[0].y_max_px = 480.0;
  constexpr std::size_t kNumFeatures = 500;
  for (int frame = 0; frame < 8; ++frame) {
    frames.push_back(test::bodies_and_background(int(kNumFeatures), camera, rng));
    suspicions.push_back(test::random_suspicions(kNumFeatures, rng));
  }
  std::vector<CullingVerdict> verdicts(kNumFeatures);
  std::vector<std::uint8_t> removed(kNumFeatures);
  for (const ClusteredFeatures clustered :
       {ClusteredFeatures::kAnomalies, ClusteredFeatures::kPotential}) {
    for (const ClusterSpace space : {ClusterSpace::kImageWidth, ClusterSpace::kMetric}) {
      DynamicCullingOptions options;
      options.clustered = clustered;
      options.clustering.space = space;
      DynamicCullingWorkspace workspace;
      RemovalBaselineWorkspace baseline_workspace;
      CullingFrame frame;
      frame.reliability = {0.5, 0.5};
      const auto cull_frames = [&] {
        int num_removed = 0;
        for (std::size_t i = 0; i < frames.size(); ++i) {
          for (const double residual_px : {1.0, 20.0}) {  // refined and aggressive
            frame.residual_px = residual_px;
            const DynamicCullingResult result = cull_dynamic_features(
                frames[i], suspicions[i], camera, frame, options, workspace, verdicts);
            ASSERT_TRUE(result.status.ok());
            num_removed += result.num_removed;
          }
          for (const RemovalBaseline baseline :
               {RemovalBaseline::kProportion, RemovalBaseline::kKMeans,
                RemovalBaseline::kConvexHull, RemovalBaseline::kDbscan}) {
            ASSERT_TRUE(remove_by_baseline(baseline, frames[i], suspicions[i], boxes, camera, {},
                                           baseline_workspace, removed)
                            .status.ok());
          }
        }
        ASSERT_GT(num_removed, 0);
      };
      EXPECT_GT(test::count_allocations(cull_frames), 0U);
      EXPECT_EQ(test::count_allocations(cull_frames), 0U);
    }
  }
}

}  // namespace
}  // namespace srslam
