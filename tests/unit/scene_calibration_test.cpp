// R_cb and th_scene from frames of stable sequences.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/scene/calibration.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::Rng;

ReliabilityTerms stable_frame(double current, double residual_px) {
  ReliabilityTerms terms;
  terms.current = current;
  terms.residual_px = residual_px;
  return terms;
}

/// Residuals 1, 2, ... 100 px, all with the current reliability 0.5.
std::vector<ReliabilityTerms> hundred_frames() {
  std::vector<ReliabilityTerms> frames;
  for (int i = 1; i <= 100; ++i) frames.push_back(stable_frame(0.5, i));
  return frames;
}

TEST(Calibration, HandComputed) {
  const CalibrationResult result = calibrate_reliability(hundred_frames(), {});
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.num_frames, 100U);
  EXPECT_EQ(result.residual_scale_px, 99.0);  // 99 of 100 do not exceed it
  // The smallest reliability is that of the largest residual; 1 % of 100 frames is one frame.
  EXPECT_NEAR(result.threshold, 0.5 * std::exp(-100.0 / 99.0), 1e-12);
  EXPECT_EQ(result.good_share, 1.0);
  EXPECT_EQ(result.high_motion_share, 0.01);
}

TEST(Calibration, ExtremesAreTheLargestAndTheSmallest) {
  std::vector<ReliabilityTerms> frames = hundred_frames();
  frames.push_back(stable_frame(0.5, 5000.0));  // one bad track
  CalibrationOptions options;
  const CalibrationResult robust = calibrate_reliability(frames, {}, options);
  options.rule = CalibrationRule::kExtremes;
  const CalibrationResult extremes = calibrate_reliability(frames, {}, options);
  EXPECT_EQ(robust.residual_scale_px, 100.0);
  EXPECT_EQ(extremes.residual_scale_px, 5000.0);
  EXPECT_NEAR(extremes.threshold, 0.5 / std::exp(1.0), 1e-12);
  EXPECT_EQ(extremes.high_motion_share, 0.0);
}

TEST(Calibration, TheScaleDoesNotFallBelowTheNoise) {
  const std::vector<ReliabilityTerms> still(50, stable_frame(0.5, 0.0));
  const CalibrationResult result = calibrate_reliability(still, {});
  EXPECT_EQ(result.residual_scale_px, CalibrationOptions().min_residual_scale_px);
  EXPECT_EQ(result.threshold, 0.5);
}

TEST(Calibration, InitialFramesAndWhatIsNoNumberDoNotCount) {
  std::vector<ReliabilityTerms> frames = hundred_frames();
  ReliabilityTerms initial = stable_frame(0.01, 0.0);
  initial.initial = true;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  frames.insert(frames.end(), {initial, stable_frame(nan, 1.0), stable_frame(0.5, nan)});
  const CalibrationResult with = calibrate_reliability(frames, {});
  const CalibrationResult without = calibrate_reliability(hundred_frames(), {});
  EXPECT_EQ(with.num_frames, 100U);
  EXPECT_EQ(with.threshold, without.threshold);
}

// With the values it gives, at least the asked shares of the stable frames are GOOD and at rest;
// the order of the frames means nothing.
TEST(Calibration, MostStableFramesPassWhatTheyGave) {
  for_each_seed(20, [](Rng& rng) {
    std::vector<ReliabilityTerms> frames;
    for (int i = rng.uniform_int(30, 400); i > 0; --i) {
      frames.push_back(stable_frame(rng.uniform(0.2, 0.9), rng.uniform(0.0, 8.0)));
      frames.back().inlier_share = rng.uniform(0.5, 1.0);
    }
    CalibrationOptions options;
    options.residual_percentile = rng.uniform(50.0, 100.0);
    options.reliability_percentile = rng.uniform(0.0, 50.0);
    const CalibrationResult result = calibrate_reliability(frames, {}, options);
    ASSERT_TRUE(result.status.ok());
    SceneAssessorOptions assessor;
    assessor.residual_scale_px = result.residual_scale_px;
    const auto good = std::count_if(frames.begin(), frames.end(), [&](const auto& frame) {
      return scene_reliability(frame, assessor) >= result.threshold;
    });
    EXPECT_DOUBLE_EQ(result.good_share, double(good) / double(frames.size()));
    EXPECT_GE(result.good_share, 1.0 - options.reliability_percentile / 100.0);
    EXPECT_LE(result.high_motion_share, 1.0 - options.residual_percentile / 100.0);
    std::reverse(frames.begin(), frames.end());
    EXPECT_EQ(calibrate_reliability(frames, {}, options).threshold, result.threshold);
  });
}

TEST(Calibration, RefusesTooFewFramesAndBadOptions) {
  const std::vector<ReliabilityTerms> few(29, stable_frame(0.5, 1.0));
  EXPECT_EQ(calibrate_reliability(few, {}).status.code, StatusCode::kInsufficientData);
  EXPECT_EQ(calibrate_reliability({}, {}).status.code, StatusCode::kInsufficientData);
  SceneAssessorOptions assessor;
  assessor.residual_scale_px = 0.0;
  EXPECT_EQ(calibrate_reliability(hundred_frames(), assessor).status.code,
            StatusCode::kInvalidArgument);
  const auto refused = [](auto member, auto value) {
    CalibrationOptions options;
    options.*member = value;
    return calibrate_reliability(hundred_frames(), {}, options).status.code ==
           StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused(&CalibrationOptions::residual_percentile, 0.0));
  EXPECT_TRUE(refused(&CalibrationOptions::residual_percentile, 100.1));
  EXPECT_TRUE(refused(&CalibrationOptions::reliability_percentile, -1.0));
  EXPECT_TRUE(refused(&CalibrationOptions::reliability_percentile, 100.0));
  EXPECT_TRUE(refused(&CalibrationOptions::min_residual_scale_px, 0.0));
  EXPECT_TRUE(refused(&CalibrationOptions::min_frames, 1));
}

}  // namespace
}  // namespace srslam
