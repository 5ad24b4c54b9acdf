// Module D from images to the map: what is removed, what the pipeline makes of the rest, and that
// nothing else changes.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <utility>
#include <vector>

#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/camera_file.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "srslam/synthetic/synthetic_world.hpp"
#include "support/rendered_world.hpp"

namespace srslam {
namespace {

using test::RenderedFrame;
using test::RenderedWorld;

struct MoverFrame {
  double timestamp_s = 0.0;
  Pose T_world_camera = Pose::Identity();
  ImageBuffer<std::uint8_t> gray;
  ImageBuffer<float> depth_m;
  ImageBuffer<std::uint8_t> mask;  ///< not 0 on people
  std::vector<Detection> detections;
};

struct MoverSequence {
  PinholeCamera camera;
  std::vector<MoverFrame> frames;
};

/// Two people who walk about before a camera that shifts along its axes.
const MoverSequence& walking_people() {
  static const MoverSequence sequence = [] {
    constexpr std::size_t kNumFrames = 60;
    MoverSequence made;
    SyntheticOptions options;
    options.scenario = "walking_xyz";
    options.seed = 2;
    options.num_frames = kNumFrames;
    EXPECT_TRUE(synthetic_camera("tum_fr3", 320, 240, &options.camera).ok());
    SyntheticWorld world;
    EXPECT_TRUE(world.create(options).ok());
    made.camera = options.camera.camera;
    SyntheticRenderer renderer(world);
    SyntheticFrame rendered;
    for (std::size_t i = 0; i < kNumFrames; ++i) {
      EXPECT_TRUE(renderer.render(i, &rendered).ok());
      MoverFrame frame;
      frame.timestamp_s = rendered.timestamp_s;
      frame.T_world_camera = rendered.T_world_camera;
      frame.mask = rendered.instances;
      frame.detections = rendered.detections;
      frame.gray.resize(320, 240);
      frame.depth_m.resize(320, 240);
      for (int v = 0; v < 240; ++v) {
        for (int u = 0; u < 320; ++u) {
          const Bgr8 pixel = rendered.color.view()(u, v);
          frame.depth_m.view()(u, v) = static_cast<float>(rendered.raw_depth.view()(u, v) /
                                                          options.camera.depth_units_per_m);
          frame.gray.view()(u, v) = static_cast<std::uint8_t>(
              (114 * pixel.b + 587 * pixel.g + 299 * pixel.r + 500) / 1000);
        }
      }
      made.frames.push_back(std::move(frame));
    }
    return made;
  }();
  return sequence;
}

PipelineFrame input_of(const MoverFrame& frame) {
  PipelineFrame input;
  input.timestamp_s = frame.timestamp_s;
  input.gray = frame.gray.view();
  input.depth_m = frame.depth_m.view();
  input.detections = frame.detections;
  input.has_detections = true;
  return input;
}

PipelineOptions options_with(bool culling) {
  PipelineOptions options;
  options.scene.enabled = true;
  options.culling.enabled = culling;
  options.num_threads = 1;
  return options;
}

bool same_numbers(const Pose& a, const Pose& b) {
  return (a.matrix().array() == b.matrix().array()).all();
}

bool on_person(const MoverFrame& frame, const Feature& feature) {
  const int u = static_cast<int>(std::lround(feature.u_px));
  const int v = static_cast<int>(std::lround(feature.v_px));
  const ImageView<const std::uint8_t> mask = frame.mask.view();
  return mask.contains(u, v) && mask(u, v) != 0;
}

/// Whether a person is seen within the circle that makes a corner: those on the contour move with
/// the person, also where their pixel shows what is behind.
bool touches_person(const MoverFrame& frame, const Feature& feature) {
  const ImageView<const std::uint8_t> mask = frame.mask.view();
  const float radius_px = 3.0F * feature.scale;
  for (int v = int(feature.v_px - radius_px); v <= int(feature.v_px + radius_px); ++v) {
    for (int u = int(feature.u_px - radius_px); u <= int(feature.u_px + radius_px); ++u) {
      if (mask.contains(u, v) && mask(u, v) != 0 &&
          std::hypot(float(u) - feature.u_px, float(v) - feature.v_px) <= radius_px) {
        return true;
      }
    }
  }
  return false;
}

/// Error of the trajectory that the pipeline gives [m], lost frames counted in `num_lost`.
double ate_m(const MoverSequence& sequence, const PipelineOptions& options, int* num_lost) {
  ReferencePipeline pipeline(sequence.camera, options);
  Trajectory truth;
  Trajectory estimate;
  *num_lost = 0;
  for (const MoverFrame& frame : sequence.frames) {
    const PipelineResult result = pipeline.process(input_of(frame));
    truth.push_back({frame.timestamp_s, frame.T_world_camera});
    if (result.state == TrackingState::kTracked) {
      estimate.push_back({frame.timestamp_s, result.T_world_camera});
    } else {
      ++*num_lost;
    }
  }
  const AteResult ate = absolute_trajectory_error(truth, estimate);
  EXPECT_TRUE(ate.status.ok());
  return ate.translation_m.rmse;
}

TEST(CullingModule, PeopleGoAndTheRoomStays) {
  const MoverSequence& sequence = walking_people();
  ReferencePipeline pipeline(sequence.camera, options_with(true));
  ASSERT_TRUE(pipeline.status().ok());
  int num_on_people = 0;
  int num_on_room = 0;
  int num_people_culled = 0;
  int num_room_culled = 0;
  int num_people_inliers = 0;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const MoverFrame& frame = sequence.frames[i];
    const PipelineResult result = pipeline.process(input_of(frame));
    ASSERT_TRUE(result.has_culling) << i;
    const CullingReport& report = result.culling;
    ASSERT_EQ(result.features.size, static_cast<std::size_t>(result.num_features));
    ASSERT_EQ(result.labels.size, result.features.size);
    ASSERT_EQ(report.points.size, result.features.size);
    ASSERT_EQ(report.suspicions.size, result.features.size);
    ASSERT_EQ(report.verdicts.size, result.features.size);
    int num_culled = 0;
    for (std::size_t k = 0; k < result.features.size; ++k) {
      EXPECT_EQ(report.points[k].u_px, result.features[k].u_px);
      const bool culled = is_removed(report.verdicts[k]);
      EXPECT_EQ(result.labels[k] == FeatureLabel::kCulled, culled);
      EXPECT_TRUE(!culled || report.suspicions[k].potential());
      num_culled += culled ? 1 : 0;
      if (on_person(frame, result.features[k])) {
        ++num_on_people;
        num_people_culled += culled ? 1 : 0;
        num_people_inliers += result.labels[k] == FeatureLabel::kInlier ? 1 : 0;
      } else if (!touches_person(frame, result.features[k])) {
        ++num_on_room;
        num_room_culled += culled ? 1 : 0;
      }
    }
    EXPECT_EQ(report.removal.num_removed, num_culled);
    EXPECT_EQ(report.num_restored, 0);
    EXPECT_EQ(report.removal.branch == CullingBranch::kInitialization,
              result.scene.terms.initial && report.regions.num_potential > 0)
        << i;
    EXPECT_GT(result.times.culling_ms, 0.0);
  }
  const double recall = double(num_people_culled) / num_on_people;
  const double retention = 1.0 - double(num_room_culled) / num_on_room;
  std::cout << "recall " << recall << " of " << num_on_people << ", retention " << retention
            << " of " << num_on_room << ", " << num_people_inliers << " inliers on people\n";
  EXPECT_GT(recall, 0.9);
  EXPECT_GT(retention, 0.8);
}

TEST(CullingModule, TheTrajectoryIsTheRoomsAndNotThePeoples) {
  const MoverSequence& sequence = walking_people();
  int num_lost_baseline = 0;
  int num_lost = 0;
  const double baseline_m = ate_m(sequence, options_with(false), &num_lost_baseline);
  const double culled_m = ate_m(sequence, options_with(true), &num_lost);
  std::cout << "ATE " << baseline_m << " m, with culling " << culled_m << " m\n";
  EXPECT_EQ(num_lost, 0);
  EXPECT_LT(culled_m, 0.04);
  EXPECT_GT(baseline_m, 3.0 * culled_m) << "then the sequence shows nothing";
}

TEST(CullingModule, AMaskTakesThePlaceOfBoxes) {
  const MoverSequence& sequence = walking_people();
  ReferencePipeline pipeline(sequence.camera, options_with(true));
  for (std::size_t i = 0; i < 10; ++i) {
    const MoverFrame& frame = sequence.frames[i];
    PipelineFrame input = input_of(frame);
    input.object_mask = frame.mask.view();
    const PipelineResult result = pipeline.process(input);
    ASSERT_TRUE(result.has_culling);
    for (std::size_t k = 0; k < result.features.size; ++k) {
      EXPECT_EQ(result.culling.suspicions[k].in_object, on_person(frame, result.features[k]));
    }
  }
}

TEST(CullingModule, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const MoverSequence& sequence = walking_people();
  std::vector<Pose> poses;
  std::vector<int> counts;
  for (const int num_threads : {1, 1, 2}) {
    PipelineOptions options = options_with(true);
    options.num_threads = num_threads;
    ReferencePipeline pipeline(sequence.camera, options);
    for (std::size_t i = 0; i < 30; ++i) {
      const PipelineResult result = pipeline.process(input_of(sequence.frames[i]));
      if (poses.size() < 30) {
        poses.push_back(result.T_world_camera);
        counts.push_back(result.culling.removal.num_removed);
      } else {
        EXPECT_TRUE(same_numbers(result.T_world_camera, poses[i])) << i;
        EXPECT_EQ(result.culling.removal.num_removed, counts[i]) << i;
      }
    }
  }
}

TEST(CullingModule, TurnedOffTheFeaturesAreUntouched) {
  const MoverSequence& sequence = walking_people();
  PipelineOptions baseline = options_with(false);
  baseline.scene.enabled = false;
  ReferencePipeline without(sequence.camera, baseline);
  ReferencePipeline off(sequence.camera, options_with(false));
  for (std::size_t i = 0; i < 15; ++i) {
    const PipelineResult expected = without.process(input_of(sequence.frames[i]));
    const PipelineResult result = off.process(input_of(sequence.frames[i]));
    EXPECT_FALSE(result.has_culling);
    EXPECT_EQ(result.times.culling_ms, 0.0);
    ASSERT_EQ(result.features.size, expected.features.size);
    for (std::size_t k = 0; k < result.features.size; ++k) {
      EXPECT_EQ(result.features[k].u_px, expected.features[k].u_px);
      EXPECT_EQ(result.labels[k], expected.labels[k]);
    }
    EXPECT_TRUE(same_numbers(result.T_world_camera, expected.T_world_camera)) << i;
  }
}

/// A room in which nothing moves, nobody looks for objects.
std::vector<PipelineResult> results_in_a_still_room(bool camera_moves, int* num_features,
                                                    int* num_culled) {
  const PinholeCamera camera{320, 240, 260.0, 260.0, 159.5, 119.5};
  const RenderedWorld world(7);
  ReferencePipeline pipeline(camera, options_with(true));
  std::vector<PipelineResult> results;
  RenderedFrame frame;
  for (int i = 0; i < 25; ++i) {
    if (i == 0 || camera_moves) {
      world.render(camera, RenderedWorld::path(i / 30.0), &frame.gray, &frame.depth_m);
    }
    PipelineFrame input;
    input.timestamp_s = i / 30.0;
    input.gray = frame.gray.view();
    input.depth_m = frame.depth_m.view();
    results.push_back(pipeline.process(input));
    EXPECT_EQ(results.back().state, TrackingState::kTracked) << i;
    *num_features += results.back().num_features;
    *num_culled += results.back().culling.removal.num_removed;
  }
  return results;
}

TEST(CullingModule, InAStillRoomNearlyNothingGoes) {
  int num_features = 0;
  int num_culled = 0;
  results_in_a_still_room(true, &num_features, &num_culled);
  std::cout << num_culled << " of " << num_features << " features removed\n";
  EXPECT_LT(num_culled, 0.02 * num_features);
}

TEST(CullingModule, AStillCameraHasNoEpipolarGeometryAndLosesNothingByIt) {
  int num_features = 0;
  int num_culled = 0;
  for (const PipelineResult& result : results_in_a_still_room(false, &num_features, &num_culled)) {
    EXPECT_NE(result.culling.regions.epipolar, SkippedTest::kNotSkipped);
    EXPECT_EQ(result.culling.regions.num_epipolar_anomalies, 0);
  }
  EXPECT_EQ(num_culled, 0);
}

TEST(CullingModule, WhatTrackingCannotDoWithoutComesBack) {
  const PinholeCamera camera{320, 240, 260.0, 260.0, 159.5, 119.5};
  const RenderedWorld world(7);
  PipelineOptions options = options_with(true);
  options.culling.removal.high_motion_px = 1e-9;  // all that is potential goes, however little
  options.culling.removal.min_kept_share = 0.0;
  ReferencePipeline pipeline(camera, options);
  Detection everywhere;
  everywhere.class_name = "person";
  everywhere.score = 0.9;
  everywhere.x_min_px = everywhere.y_min_px = -1.0;
  everywhere.x_max_px = 321.0;
  everywhere.y_max_px = 241.0;
  const std::vector<Detection> detections = {everywhere};
  RenderedFrame frame;
  int num_aggressive = 0;
  for (int i = 0; i < 20; ++i) {
    world.render(camera, RenderedWorld::path(i / 30.0), &frame.gray, &frame.depth_m);
    PipelineFrame input;
    input.timestamp_s = i / 30.0;
    input.gray = frame.gray.view();
    input.depth_m = frame.depth_m.view();
    input.has_detections = true;
    if (i >= 10) input.detections = detections;
    const PipelineResult result = pipeline.process(input);
    ASSERT_EQ(result.state, TrackingState::kTracked) << i;
    if (result.culling.removal.branch != CullingBranch::kAggressive || i < 10) {
      EXPECT_EQ(result.culling.num_restored, 0);
      continue;
    }
    ++num_aggressive;
    EXPECT_EQ(result.culling.removal.num_removed, result.num_features);
    EXPECT_FALSE(result.is_keyframe);
    EXPECT_GT(result.num_inliers, 15);
    int num_culled = 0;
    for (std::size_t k = 0; k < result.labels.size; ++k) {
      const bool culled = result.labels[k] == FeatureLabel::kCulled;
      EXPECT_EQ(culled, result.culling.suspicions[k].anomalous());
      num_culled += culled ? 1 : 0;
    }
    EXPECT_EQ(result.culling.num_restored, result.num_features - num_culled);
  }
  EXPECT_GT(num_aggressive, 5);
}

TEST(CullingModule, RefusesWhatItCannotUse) {
  const MoverSequence& sequence = walking_people();
  PipelineOptions options = options_with(true);
  options.scene.enabled = false;
  EXPECT_EQ(ReferencePipeline(sequence.camera, options).status().code,
            StatusCode::kInvalidArgument);
  options = options_with(true);
  options.culling.removal.min_kept_share = 2.0;
  EXPECT_EQ(ReferencePipeline(sequence.camera, options).status().code,
            StatusCode::kInvalidArgument);
  options = options_with(true);
  options.culling.regions.flow_px = -1.0;
  EXPECT_EQ(ReferencePipeline(sequence.camera, options).status().code,
            StatusCode::kInvalidArgument);

  ReferencePipeline pipeline(sequence.camera, options_with(true));
  PipelineFrame input = input_of(sequence.frames[0]);
  ImageBuffer<std::uint8_t> small;
  small.resize(10, 10);
  input.object_mask = small.view();
  EXPECT_EQ(pipeline.process(input).status.code, StatusCode::kInvalidArgument);
  EXPECT_TRUE(pipeline.process(input_of(sequence.frames[0])).status.ok()) << "nothing was changed";
}

}  // namespace
}  // namespace srslam
