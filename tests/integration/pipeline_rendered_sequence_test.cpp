// The whole baseline on a rendered room: accuracy, signs, determinism, loss and recovery, bad
// input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "srslam/core/se3.hpp"
#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/pipeline/reference_pipeline.hpp"
#include "support/constants.hpp"
#include "support/rendered_world.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::kNan;
using test::RenderedFrame;
using test::RenderedWorld;
using test::Rng;

/// Half of a 640x480 camera.
PinholeCamera camera() {
  const PinholeCamera full{640, 480, 520.0, 520.0, 319.5, 239.5};
  return full.scaled(0.5);
}

/// Sixty frames, rendered once.
const std::vector<RenderedFrame>& sequence() {
  static const std::vector<RenderedFrame> frames =
      test::render_path(RenderedWorld(42), camera(), 60);
  return frames;
}

PipelineFrame frame_of(const RenderedFrame& rendered) {
  PipelineFrame frame;
  frame.timestamp_s = rendered.timestamp_s;
  frame.gray = rendered.gray.view();
  frame.depth_m = rendered.depth_m.view();
  return frame;
}

struct Recording {
  Trajectory live;  ///< every frame, tracked or not
  Trajectory optimized;
  Trajectory keyframes;
  std::vector<TrackingState> states;
  int num_tracked = 0;
  int num_keyframes_inserted = 0;
};

void record(const PipelineResult& result, double timestamp_s, Recording* run) {
  run->live.push_back({timestamp_s, result.T_world_camera});
  run->states.push_back(result.state);
  if (result.state == TrackingState::kTracked) ++run->num_tracked;
  if (result.is_keyframe) ++run->num_keyframes_inserted;
}

void finish(ReferencePipeline* pipeline, Recording* run) {
  pipeline->finish();
  run->optimized = pipeline->optimized_trajectory();
  run->keyframes = pipeline->keyframes();
}

Recording run_all(const std::vector<RenderedFrame>& frames, const PipelineOptions& options = {}) {
  ReferencePipeline pipeline(camera(), options);
  Recording run;
  for (const RenderedFrame& frame : frames) {
    const PipelineResult result = pipeline.process(frame_of(frame));
    EXPECT_TRUE(result.status.ok()) << result.status.reason;
    record(result, frame.timestamp_s, &run);
  }
  finish(&pipeline, &run);
  return run;
}

/// The undisturbed run that others are compared with.
const Recording& reference_run() {
  static const Recording run = run_all(sequence());
  return run;
}

void expect_same_bits(const Trajectory& a, const Trajectory& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].timestamp_s, b[i].timestamp_s) << what << " " << i;
    EXPECT_EQ(a[i].T_world_camera.matrix(), b[i].T_world_camera.matrix()) << what << " " << i;
  }
}

void expect_same_bits(const Recording& a, const Recording& b) {
  expect_same_bits(a.live, b.live, "live");
  expect_same_bits(a.optimized, b.optimized, "optimized");
  expect_same_bits(a.keyframes, b.keyframes, "keyframes");
  EXPECT_EQ(a.states, b.states);
}

Trajectory truth_of(const std::vector<RenderedFrame>& frames) {
  Trajectory truth;
  for (const RenderedFrame& frame : frames)
    truth.push_back({frame.timestamp_s, frame.T_world_camera});
  return truth;
}

double ate_m(const std::vector<RenderedFrame>& frames, const Trajectory& estimate) {
  const AteResult result = absolute_trajectory_error(truth_of(frames), estimate);
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  return result.translation_m.rmse;
}

double distance_m(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

// ---------------------------------------------------------------------------------------------

TEST(RenderedSequence, TracksEveryFrameToMillimetres) {
  const Recording& run = reference_run();
  EXPECT_EQ(run.num_tracked, 60);
  EXPECT_EQ(run.optimized.size(), 60U);
  EXPECT_GE(run.keyframes.size(), 2U);
  const double live_m = ate_m(sequence(), run.live);
  const double optimized_m = ate_m(sequence(), run.optimized);
  std::cout << "ATE rmse: live " << live_m << " m, optimized " << optimized_m << " m; "
            << run.keyframes.size() << " keyframes\n";
  EXPECT_LT(live_m, 0.01);
  EXPECT_LT(optimized_m, 0.01);
  // The first frame is the world's origin, here as in the rendering: no alignment is needed.
  for (std::size_t i = 0; i < 60; ++i) {
    const Vector6 error =
        se3_log(sequence()[i].T_world_camera.inverse() * run.live[i].T_world_camera);
    EXPECT_LT(error.head<3>().norm(), 0.02) << i;
    EXPECT_LT(error.tail<3>().norm(), 0.01) << i;
  }
  EXPECT_EQ(run.live.front().T_world_camera.matrix(), Pose::Identity().matrix());
}

TEST(RenderedSequence, ResultsAreConsistentFrameByFrame) {
  ReferencePipeline pipeline(camera());
  int frames_with_solve = 0;
  for (std::size_t i = 0; i < 30; ++i) {
    const PipelineResult result = pipeline.process(frame_of(sequence()[i]));
    ASSERT_TRUE(result.status.ok());
    EXPECT_EQ(result.features.size, static_cast<std::size_t>(result.num_features));
    ASSERT_EQ(result.labels.size, result.features.size);
    int num_inliers = 0;
    int num_outliers = 0;
    for (const FeatureLabel label : result.labels) {
      num_inliers += label == FeatureLabel::kInlier ? 1 : 0;
      num_outliers += label == FeatureLabel::kOutlier ? 1 : 0;
    }
    EXPECT_EQ(num_inliers, result.num_inliers) << i;
    EXPECT_EQ(num_inliers + num_outliers, result.num_matches) << i;
    EXPECT_GE(result.num_inliers, 15) << i;
    EXPECT_LE(result.num_features_with_depth, result.num_features);
    EXPECT_GT(result.num_features_with_depth, 300);
    if (i == 0) {
      EXPECT_TRUE(result.is_keyframe);
    }
    EXPECT_STRNE(result.keyframe_reason, "");
    EXPECT_GT(result.num_map_points, 100);
    EXPECT_EQ(result.num_keyframes, static_cast<int>(pipeline.keyframes().size()));
    EXPECT_GT(result.times.total_ms, 0.0);
    EXPECT_GE(result.times.total_ms, result.times.features_ms);
    frames_with_solve += result.times.bundle_adjustment_ms > 0.0 ? 1 : 0;
  }
  EXPECT_GT(frames_with_solve, 0);
  EXPECT_EQ(pipeline.optimized_trajectory().size(), 30U);
}

TEST(RenderedSequence, MotionHasTheRightSignAlongAndAboutEveryAxis) {
  const RenderedWorld world(42);
  for (int axis = 0; axis < 6; ++axis) {
    ReferencePipeline pipeline(camera());
    for (int i = 0; i < 12; ++i) {
      Vector6 tangent = Vector6::Zero();
      tangent[axis] = (axis < 3 ? 0.015 : 0.01) * i;
      RenderedFrame frame;
      frame.timestamp_s = i / 30.0;
      frame.T_world_camera = se3_exp(tangent);
      world.render(camera(), frame.T_world_camera, &frame.gray, &frame.depth_m);
      const PipelineResult result = pipeline.process(frame_of(frame));
      ASSERT_EQ(result.state, TrackingState::kTracked) << "axis " << axis << " frame " << i;
      const Vector6 measured = se3_log(result.T_world_camera);
      EXPECT_NEAR(measured[axis], tangent[axis], 0.004) << "axis " << axis << " frame " << i;
      EXPECT_LT((measured - tangent).norm(), 0.008) << "axis " << axis << " frame " << i;
    }
  }
}

TEST(RenderedSequence, SameBitsTwiceAndWithOneOrTwoThreads) {
  ASSERT_GE(reference_run().num_keyframes_inserted, 3) << "bundle adjustment must have run";
  PipelineOptions options;
  options.num_threads = 2;
  expect_same_bits(run_all(sequence(), options), reference_run());
  options.num_threads = 1;
  expect_same_bits(run_all(sequence(), options), reference_run());
}

TEST(RenderedSequence, CarriedDetectionsChangeNoBit) {
  ReferencePipeline pipeline(camera());
  Recording run;
  const std::vector<Detection> detections = {{"person", 0.9, 20.0, 20.0, 200.0, 230.0},
                                             {"chair", 0.3, 100.0, 10.0, 310.0, 200.0}};
  for (const RenderedFrame& rendered : sequence()) {
    PipelineFrame frame = frame_of(rendered);
    frame.detections = detections;
    frame.has_detections = true;
    record(pipeline.process(frame), frame.timestamp_s, &run);
  }
  finish(&pipeline, &run);
  expect_same_bits(run, reference_run());
}

TEST(RenderedSequence, MaskedFeaturesAreNotTaken) {
  ImageBuffer<std::uint8_t> mask;
  mask.resize(320, 240);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) mask.view()(u, v) = u < 200 ? 1 : 0;
  }
  ReferencePipeline pipeline(camera());
  for (std::size_t i = 0; i < 20; ++i) {
    PipelineFrame frame = frame_of(sequence()[i]);
    frame.feature_mask = mask.view();
    const PipelineResult result = pipeline.process(frame);
    ASSERT_EQ(result.state, TrackingState::kTracked) << i;
    EXPECT_GT(result.num_features, 200);
    for (const Feature& feature : result.features) EXPECT_LT(feature.u_px, 200.0F);
    EXPECT_LT(distance_m(result.T_world_camera, sequence()[i].T_world_camera), 0.02);
  }
}

TEST(RenderedSequence, NothingButMaskMeansLostUntilItIsLifted) {
  ImageBuffer<std::uint8_t> mask;
  mask.resize(320, 240);
  ReferencePipeline pipeline(camera());
  for (std::size_t i = 0; i < 30; ++i) {
    PipelineFrame frame = frame_of(sequence()[i]);
    const bool masked = i >= 15 && i < 20;
    if (masked) frame.feature_mask = mask.view();
    const PipelineResult result = pipeline.process(frame);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_EQ(result.state, masked ? TrackingState::kLost : TrackingState::kTracked) << i;
    EXPECT_TRUE(result.T_world_camera.matrix().allFinite());
    if (masked) {
      EXPECT_EQ(result.num_features, 0);
      EXPECT_EQ(result.num_inliers, 0);
      EXPECT_FALSE(result.is_keyframe);
    }
    EXPECT_EQ(result.relocalized, i == 20) << i;
  }
  EXPECT_EQ(pipeline.optimized_trajectory().size(), 25U);
}

TEST(RenderedSequence, FirstFramesWithoutEnoughDepthStartNoMap) {
  ImageBuffer<float> no_depth;
  no_depth.resize(320, 240);
  ReferencePipeline pipeline(camera());
  for (std::size_t i = 0; i < 5; ++i) {
    PipelineFrame frame = frame_of(sequence()[i]);
    if (i < 3) frame.depth_m = no_depth.view();
    const PipelineResult result = pipeline.process(frame);
    ASSERT_TRUE(result.status.ok());
    EXPECT_EQ(result.state, i < 3 ? TrackingState::kNotInitialized : TrackingState::kTracked);
    EXPECT_EQ(result.labels.size, result.features.size);
    EXPECT_EQ(result.num_keyframes, i < 3 ? 0 : 1);
  }
  EXPECT_EQ(pipeline.optimized_trajectory().size(), 2U);
}

TEST(RenderedSequence, KidnappedCameraIsLostAndFoundAgain) {
  ImageBuffer<std::uint8_t> blank;
  blank.resize(320, 240);
  std::fill(blank.pixels.begin(), blank.pixels.end(), std::uint8_t{90});
  ReferencePipeline pipeline(camera());
  double time_s = 0.0;
  const auto process = [&](const RenderedFrame& rendered, bool covered) {
    PipelineFrame frame = frame_of(rendered);
    time_s += 1.0 / 30.0;
    frame.timestamp_s = time_s;
    if (covered) frame.gray = blank.view();
    return pipeline.process(frame);
  };
  for (std::size_t i = 0; i < 40; ++i) {
    ASSERT_EQ(process(sequence()[i], false).state, TrackingState::kTracked) << i;
  }
  for (std::size_t i = 0; i < 25; ++i) {  // longer than a velocity is believed
    const PipelineResult result = process(sequence()[40], true);
    ASSERT_TRUE(result.status.ok());
    EXPECT_EQ(result.state, TrackingState::kLost);
    EXPECT_STREQ(result.keyframe_reason, "lost");
    EXPECT_TRUE(result.T_world_camera.matrix().allFinite());
    // A prediction, but not a wild one.
    EXPECT_LT(distance_m(result.T_world_camera, sequence()[40].T_world_camera), 0.1);
  }
  // It wakes up somewhere else on the path.
  for (std::size_t i = 12; i < 20; ++i) {
    const PipelineResult result = process(sequence()[i], false);
    EXPECT_EQ(result.state, TrackingState::kTracked) << i;
    EXPECT_EQ(result.relocalized, i == 12) << i;
    EXPECT_LT(distance_m(result.T_world_camera, sequence()[i].T_world_camera), 0.02) << i;
  }
  EXPECT_EQ(pipeline.optimized_trajectory().size(), 48U);
}

TEST(RenderedSequence, RefusedFramesChangeNothing) {
  ReferencePipeline pipeline(camera());
  Recording run;
  ImageBuffer<std::uint8_t> small_gray;
  small_gray.resize(160, 120);
  ImageBuffer<float> small_depth;
  small_depth.resize(160, 120);
  for (std::size_t i = 0; i < 60; ++i) {
    const PipelineFrame good = frame_of(sequence()[i]);
    std::vector<std::pair<std::string, PipelineFrame>> refused;
    const auto add = [&](const char* reason) -> PipelineFrame& {
      refused.emplace_back(reason, good);
      return refused.back().second;
    };
    add("grey").gray = small_gray.view();
    add("grey").gray = {};
    add("depth").depth_m = small_depth.view();
    add("depth").depth_m = {};
    add("depth").depth_m.stride_bytes = 3;
    add("mask").feature_mask = small_gray.view();
    add("time stamp").timestamp_s = kNan;
    add("time stamp").timestamp_s = std::numeric_limits<double>::infinity();
    if (i > 0) {
      add("time stamps must increase").timestamp_s = sequence()[i - 1].timestamp_s;
      add("time stamps must increase").timestamp_s = sequence()[0].timestamp_s - 5.0;
    }
    if (i % 7 == 0) {
      for (const auto& [reason, frame] : refused) {
        const PipelineResult result = pipeline.process(frame);
        EXPECT_EQ(result.status.code, StatusCode::kInvalidArgument);
        EXPECT_NE(std::string(result.status.reason).find(reason), std::string::npos)
            << result.status.reason;
        EXPECT_EQ(result.state, TrackingState::kNotInitialized);
        EXPECT_EQ(result.num_features, 0);
      }
    }
    record(pipeline.process(good), good.timestamp_s, &run);
  }
  finish(&pipeline, &run);
  expect_same_bits(run, reference_run());
}

TEST(RenderedSequence, InvalidDepthPixelsAreLeftOut) {
  Rng rng(31);
  std::vector<RenderedFrame> frames(sequence().begin(), sequence().begin() + 40);
  const std::vector<float> odd = {0.0F,
                                  -2.0F,
                                  1e30F,
                                  std::numeric_limits<float>::infinity(),
                                  -std::numeric_limits<float>::infinity(),
                                  std::numeric_limits<float>::quiet_NaN()};
  for (RenderedFrame& frame : frames) {
    for (float& depth : frame.depth_m.pixels) {
      if (rng.uniform_int(0, 9) < 4) {
        depth = odd[static_cast<std::size_t>(rng.uniform_int(0, static_cast<int>(odd.size()) - 1))];
      }
    }
  }
  const Recording run = run_all(frames);
  EXPECT_EQ(run.num_tracked, 40);
  EXPECT_LT(ate_m(frames, run.live), 0.01);
  for (const StampedPose& pose : run.optimized) {
    EXPECT_TRUE(pose.T_world_camera.matrix().allFinite());
  }
}

TEST(RenderedSequence, FramesWithoutAnyDepthAreTrackedByPixels) {
  std::vector<RenderedFrame> frames(sequence().begin(), sequence().begin() + 40);
  for (std::size_t i = 20; i < 30; ++i) {
    std::fill(frames[i].depth_m.pixels.begin(), frames[i].depth_m.pixels.end(), 0.0F);
  }
  const Recording run = run_all(frames);
  EXPECT_EQ(run.num_tracked, 40);
  EXPECT_LT(ate_m(frames, run.live), 0.01);
}

TEST(RenderedSequence, TheNumberOfKeyframesIsBounded) {
  PipelineOptions options;
  options.mapping.max_keyframes = 3;
  options.keyframes.reference_ratio = 1.0;  // as many keyframes as the mapper can take
  options.keyframes.young_reference_ratio = 1.0;
  ReferencePipeline pipeline(camera(), options);
  Recording run;
  int most = 0;
  for (const RenderedFrame& rendered : sequence()) {
    const PipelineResult result = pipeline.process(frame_of(rendered));
    record(result, rendered.timestamp_s, &run);
    most = std::max(most, result.num_keyframes);
  }
  finish(&pipeline, &run);
  EXPECT_GT(run.num_keyframes_inserted, 6);
  // A new keyframe joins at once, the one that leaves for it goes when its adjustment is applied.
  EXPECT_LE(most, 4);
  EXPECT_LE(run.keyframes.size(), 3U);
  EXPECT_EQ(run.num_tracked, 60);
  // Frames whose keyframe has left are still carried along.
  EXPECT_EQ(run.optimized.size(), 60U);
  EXPECT_LT(ate_m(sequence(), run.optimized), 0.015);
}

TEST(RenderedSequence, TimeStampsAHairApartGiveFinitePoses) {
  ImageBuffer<std::uint8_t> blank;
  blank.resize(320, 240);
  ReferencePipeline pipeline(camera());
  double time_s = 0.0;
  for (std::size_t i = 0; i < 12; ++i) {
    PipelineFrame frame = frame_of(sequence()[i]);
    frame.timestamp_s = time_s;
    // Any motion over the least time there is makes a velocity that overflows, and the prediction
    // of a lost frame is handed out as it is.
    time_s = i == 8 ? time_s + 0.5 : std::nextafter(time_s, 1.0);
    const bool covered = i == 4;
    if (covered) frame.gray = blank.view();
    const PipelineResult result = pipeline.process(frame);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_TRUE(result.T_world_camera.matrix().allFinite()) << i;
    EXPECT_EQ(result.state, covered ? TrackingState::kLost : TrackingState::kTracked) << i;
  }
}

TEST(ReferencePipeline, InvalidCameraOrOptionsRefuseEveryFrame) {
  PipelineOptions options;
  options.num_threads = 0;
  ReferencePipeline bad_options(camera(), options);
  EXPECT_EQ(bad_options.status().code, StatusCode::kInvalidArgument);
  const PipelineResult result = bad_options.process(frame_of(sequence()[0]));
  EXPECT_EQ(result.status.code, StatusCode::kInvalidArgument);
  EXPECT_STREQ(result.status.reason, bad_options.status().reason);
  bad_options.finish();
  EXPECT_TRUE(bad_options.keyframes().empty());
  EXPECT_TRUE(bad_options.optimized_trajectory().empty());

  PinholeCamera no_camera = camera();
  no_camera.fx_px = 0.0;
  ReferencePipeline bad_camera(no_camera);
  EXPECT_FALSE(bad_camera.status().ok());
  EXPECT_FALSE(bad_camera.process(frame_of(sequence()[0])).status.ok());
}

TEST(ReferencePipeline, MovesWithItsMapAndRefusesWhenMovedFrom) {
  ReferencePipeline first(camera());
  Recording run;
  for (std::size_t i = 0; i < 30; ++i) {
    record(first.process(frame_of(sequence()[i])), sequence()[i].timestamp_s, &run);
  }
  ReferencePipeline second(std::move(first));
  for (std::size_t i = 30; i < 60; ++i) {
    record(second.process(frame_of(sequence()[i])), sequence()[i].timestamp_s, &run);
  }
  finish(&second, &run);
  expect_same_bits(run, reference_run());
  // NOLINTNEXTLINE(bugprone-use-after-move): that is the question.
  EXPECT_FALSE(first.process(frame_of(sequence()[0])).status.ok());
  first.finish();
  EXPECT_TRUE(first.keyframes().empty());
}

TEST(ReferencePipeline, ImagesTooSmallForFeaturesStartNoMap) {
  const PinholeCamera tiny{20, 20, 20.0, 20.0, 9.5, 9.5};
  RenderedFrame frame;
  RenderedWorld(1).render(tiny, Pose::Identity(), &frame.gray, &frame.depth_m);
  ReferencePipeline pipeline(tiny);
  const PipelineResult result = pipeline.process(frame_of(frame));
  EXPECT_TRUE(result.status.ok());
  EXPECT_EQ(result.state, TrackingState::kNotInitialized);
  EXPECT_EQ(result.num_features, 0);
}

}  // namespace
}  // namespace srslam
