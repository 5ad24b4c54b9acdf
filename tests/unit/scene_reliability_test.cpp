#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "srslam/scene/reliability.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

using test::flow_pose;
using test::FlowScene;

// --- Eq. 7 and 8 ---------------------------------------------------------------------------------

TEST(ResidualFactor, HandComputed) {
  EXPECT_NEAR(residual_factor(30.0, 60.0, ResidualFactorForm::kExponential), 0.6065306597, 1e-9);
  EXPECT_NEAR(residual_factor(30.0, 60.0, ResidualFactorForm::kRational), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(residual_factor(30.0, 60.0, ResidualFactorForm::kClip), 1.0);
  EXPECT_NEAR(residual_factor(90.0, 60.0, ResidualFactorForm::kClip), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(residual_factor(30.0, 60.0, ResidualFactorForm::kLinear), 0.5);
  EXPECT_EQ(residual_factor(90.0, 60.0, ResidualFactorForm::kLinear), 0.0);
  EXPECT_EQ(residual_factor(30.0, 60.0, ResidualFactorForm::kLiteral), 0.5);
  EXPECT_NEAR(scene_reliability(0.55, 60.0, 60.0), 0.55 / std::exp(1.0), 1e-12);
  EXPECT_NEAR(scene_reliability(5.4, 3.0, 60.0, ResidualFactorForm::kLiteral), 0.27, 1e-12);
}

TEST(ResidualFactor, IsOneAtRestAndFallsButForTheLiteralForm) {
  for (const ResidualFactorForm form :
       {ResidualFactorForm::kExponential, ResidualFactorForm::kRational, ResidualFactorForm::kClip,
        ResidualFactorForm::kLinear}) {
    EXPECT_EQ(residual_factor(0.0, 10.0, form), 1.0);
    double last = 1.0;
    for (double residual = 1.0; residual < 200.0; residual *= 1.5) {
      const double factor = residual_factor(residual, 10.0, form);
      EXPECT_LE(factor, last);
      EXPECT_GE(factor, 0.0);
      EXPECT_NEAR(factor, residual_factor(7.0 * residual, 70.0, form), 1e-12);
      last = factor;
    }
  }
  // As printed: the perfect frame at rest is worth nothing, and motion makes it better.
  EXPECT_EQ(residual_factor(0.0, 60.0, ResidualFactorForm::kLiteral), 0.0);
  EXPECT_GT(residual_factor(90.0, 60.0, ResidualFactorForm::kLiteral), 1.0);
  EXPECT_TRUE(std::isnan(residual_factor(-1.0, 60.0, ResidualFactorForm::kClip)));
  EXPECT_TRUE(std::isnan(residual_factor(1.0, 0.0, ResidualFactorForm::kClip)));
}

TEST(ClassifyScene, TheThresholdItselfIsGood) {
  EXPECT_EQ(classify_scene(0.20, 0.20), SceneClass::kGood);
  EXPECT_EQ(classify_scene(std::nextafter(0.20, 0.0), 0.20), SceneClass::kBad);
  EXPECT_EQ(classify_scene(std::numeric_limits<double>::quiet_NaN(), 0.20), SceneClass::kBad);
}

// --- Reference frame -----------------------------------------------------------------------------

/// Feeds frames 1, 2, ... with these current reliabilities, all GOOD and fully tracked.
std::vector<std::uint64_t> references_over(const std::vector<double>& reliabilities,
                                           const ReferenceOptions& options = {}) {
  ReferencePolicy policy(options);
  std::vector<std::uint64_t> ids;
  ids.reserve(reliabilities.size());
  for (std::size_t i = 0; i < reliabilities.size(); ++i) {
    ReferenceCandidate frame;
    frame.frame_id = i + 1;
    frame.current_reliability = reliabilities[i];
    frame.good = true;
    frame.num_alive = 100;
    const char* reason = "";
    const bool changed = policy.update(frame, &reason);
    EXPECT_EQ(changed, *reason != '\0');
    ids.push_back(policy.reference().frame_id);
  }
  return ids;
}

TEST(ReferencePolicy, TakesTheBestOfTheInitialFramesTiesEarliest) {
  const std::vector<std::uint64_t> ids = references_over({0.5, 0.7, 0.6, 0.7, 0.65});
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{1, 2, 2, 2, 2}));
}

TEST(ReferencePolicy, ABetterFrameTakesOverWhenItIsOldEnough) {
  ReferenceOptions options;
  options.max_age_frames = 30;
  // Frame 7 is better; from frame 9 on it is three frames old for the next one.
  const std::vector<std::uint64_t> ids =
      references_over({0.5, 0.7, 0.6, 0.6, 0.6, 0.6, 0.8, 0.6, 0.6, 0.6}, options);
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{1, 2, 2, 2, 2, 2, 2, 2, 7, 7}));
  // At once, as printed.
  options.min_age_frames = 1;
  EXPECT_EQ(references_over({0.5, 0.7, 0.6, 0.6, 0.6, 0.6, 0.8, 0.6}, options)[6], 7U);
  options.prefer_higher = false;
  EXPECT_EQ(references_over({0.5, 0.7, 0.6, 0.6, 0.6, 0.6, 0.8, 0.6}, options)[7], 2U);
}

TEST(ReferencePolicy, NeverOlderThanAllowedNorYoungerThanAsked) {
  test::Rng rng(7);
  for (const bool falling : {false, true}) {
    ReferenceOptions options;
    ReferencePolicy policy(options);
    const char* reason = "";
    for (int i = 1; i <= 500; ++i) {
      ReferenceCandidate frame;
      frame.frame_id = std::uint64_t(i);
      frame.current_reliability = falling ? 1.0 / i : rng.uniform(0.2, 0.9);
      frame.good = falling ? i % 7 == 0 : rng.uniform(0.0, 1.0) < 0.5;
      frame.num_alive = 100;
      policy.update(frame, &reason);
      const int age_at_next = i + 1 - static_cast<int>(policy.reference().frame_id);
      EXPECT_LE(age_at_next, options.max_age_frames + 1) << i;
      if (i > 10) {
        EXPECT_GE(age_at_next, options.min_age_frames) << i;
      }
      EXPECT_LE(age_at_next, options.num_recent_frames() + options.max_age_frames);
    }
  }
}

TEST(ReferencePolicy, LostPointsMakeItStale) {
  ReferenceOptions options;
  options.max_age_frames = 30;
  options.prefer_higher = false;
  ReferencePolicy policy(options);
  const char* reason = "";
  for (std::uint64_t id = 1; id <= 12; ++id) {
    ReferenceCandidate frame;
    frame.frame_id = id;
    frame.current_reliability = 0.5;
    frame.good = id != 10;
    frame.num_alive = 100;
    if (id == 12) frame.alive_share = 0.2;
    policy.update(frame, &reason);
  }
  // Old enough are 10, 9 and 8; the newest GOOD one of equals is taken.
  EXPECT_EQ(policy.reference().frame_id, 9U);
  EXPECT_STREQ(reason, "most points of the reference were lost");
}

TEST(ReferencePolicy, RefusesOptionsOutOfRange) {
  ReferenceOptions options;
  EXPECT_TRUE(options.validate().ok());
  options.max_age_frames = 2;
  EXPECT_FALSE(options.validate().ok());
  options = {};
  options.min_age_frames = 20;
  options.max_age_frames = 25;
  options.num_candidates = 15;
  EXPECT_FALSE(options.validate().ok());
  options = {};
  options.min_alive_share = -0.1;
  EXPECT_FALSE(options.validate().ok());
}

// --- Assessor ------------------------------------------------------------------------------------

/// A stream of frames, each with good features and depth, and the tracks of a scene.
class AssessedStream {
 public:
  explicit AssessedStream(const SceneAssessorOptions& options = {})
      : assessor_(test::flow_camera(), options), depth_m_(std::size_t{640} * 480, 2.0F) {
    test::Rng rng(3);
    for (int i = 0; i < 900; ++i) {
      Feature feature;
      feature.u_px = float(rng.uniform(0.0, 639.0));
      feature.v_px = float(rng.uniform(0.0, 479.0));
      feature.response = float(rng.uniform(20.0, 120.0));
      features_.push_back(feature);
    }
  }

  SceneReport next(const std::vector<FlowTrack>& tracks = {},
                   const Pose* T_current_reference = nullptr) {
    SceneObservation frame;
    frame.T_current_reference = T_current_reference;
    frame.frame_id = ++frame_id_;
    frame.features = features_;
    if (!depth_m_.empty()) frame.depth_m = {depth_m_.data(), 640, 480};
    frame.tracks = tracks;
    return assessor_.assess(frame);
  }

  /// Past the initial frames.
  void start() {
    for (int i = 0; i < 5; ++i) next();
  }

  std::vector<Feature>& features() { return features_; }
  std::vector<float>& depth_m() { return depth_m_; }
  SceneAssessor& assessor() { return assessor_; }

 private:
  SceneAssessor assessor_;
  std::uint64_t frame_id_ = 0;
  std::vector<Feature> features_;
  std::vector<float> depth_m_;
};

TEST(SceneAssessor, InitialFramesAreJudgedWithoutMotion) {
  AssessedStream stream;
  FlowScene scene;
  scene.mover_share = 0.9;
  for (int i = 0; i < 5; ++i) {
    const SceneReport report = stream.next(scene.tracks());
    ASSERT_TRUE(report.status.ok());
    EXPECT_TRUE(report.terms.initial);
    EXPECT_EQ(report.reliability, report.current.value);
    EXPECT_EQ(report.scene_class, SceneClass::kGood);
  }
  EXPECT_FALSE(stream.next(scene.tracks()).terms.initial);
  EXPECT_EQ(stream.assessor().reference_id(), 1U);
}

TEST(SceneAssessor, CombinesTheTermsAsDocumented) {
  SceneAssessorOptions options;
  options.inlier_share_power = 2.0;
  options.dominance_power = 1.0;
  options.alive_share_power = 0.5;
  options.residual_scale_px = 10.0;
  AssessedStream stream(options);
  stream.start();
  FlowScene scene;
  scene.mover_share = 0.2;
  const SceneReport report = stream.next(scene.tracks());
  ASSERT_TRUE(report.status.ok());
  EXPECT_NEAR(report.factor, std::exp(-report.residual.value_px / 10.0), 1e-12);
  EXPECT_NEAR(report.reliability,
              report.current.value * report.factor * std::pow(report.residual.inlier_share, 2.0) *
                  report.residual.dominance * std::sqrt(report.residual.alive_share),
              1e-12);
  // Three more fall in proportion below a limit.
  ReliabilityTerms terms = report.terms;
  terms.background_share = 0.5 * options.min_background_share;
  EXPECT_NEAR(scene_reliability(terms, options), 0.5 * report.reliability, 1e-12);
  terms.continuity = 0.1 * options.min_continuity;
  EXPECT_NEAR(scene_reliability(terms, options), 0.05 * report.reliability, 1e-12);
  terms.clear_share = 0.2 * options.min_clear_share;
  EXPECT_NEAR(scene_reliability(terms, options), 0.01 * report.reliability, 1e-12);
  terms.clear_share = options.min_clear_share;
  EXPECT_NEAR(scene_reliability(terms, options), 0.05 * report.reliability, 1e-12);
  EXPECT_LE(report.reliability, report.current.value);
  EXPECT_FALSE(report.confidence.metric.present);  // no detector looked at the frame
  EXPECT_NE(report.line().find("residual"), std::string::npos);
  EXPECT_EQ(report.line().find('\n'), std::string::npos);
}

TEST(SceneAssessor, TheLiteralFormsAreThoseOfThePrint) {
  AssessedStream stream(SceneAssessorOptions::literal());
  stream.start();
  FlowScene scene;
  scene.T_current_reference = Pose::Identity();
  scene.noise_px = 0.0;
  const SceneReport still = stream.next(scene.tracks());
  EXPECT_NEAR(still.reliability, 0.0, 1e-4);  // the perfect frame is the worst
  EXPECT_EQ(still.scene_class, SceneClass::kBad);
  scene.T_current_reference = flow_pose(0.2, 0.0, 0.0, 0.0, 0.1, 0.0);
  const SceneReport moving = stream.next(scene.tracks());
  EXPECT_NEAR(moving.reliability, moving.terms.residual_px / 60.0 * moving.current.value, 1e-12);
  EXPECT_EQ(moving.scene_class, SceneClass::kGood);
  EXPECT_GT(moving.current.value, 1.0);  // a plain sum
}

TEST(SceneAssessor, IndependentMotionMakesAFrameBadAndTheCamerasDoesNot) {
  double last = 2.0;
  bool was_bad = false;
  for (const double step_m : {0.0, 0.01, 0.02, 0.04, 0.08}) {
    AssessedStream stream;
    stream.start();
    FlowScene scene;
    scene.mover_share = 0.6;
    scene.T_mover = flow_pose(step_m, 0.0, 0.0, 0.0, 0.0, 0.0);
    const SceneReport report = stream.next(scene.tracks());
    EXPECT_LT(report.reliability, last);
    EXPECT_TRUE(!was_bad || report.scene_class == SceneClass::kBad);
    was_bad = report.scene_class == SceneClass::kBad;
    last = report.reliability;
  }
  EXPECT_TRUE(was_bad);
  for (const double amount : {0.0, 1.0, 3.0}) {
    AssessedStream stream;
    stream.start();
    FlowScene scene;
    scene.T_current_reference = flow_pose(0.05 * amount, 0.0, 0.0, 0.0, 0.03 * amount, 0.0);
    EXPECT_EQ(stream.next(scene.tracks()).scene_class, SceneClass::kGood) << amount;
  }
}

TEST(SceneAssessor, StarvationAndBlindnessMakeAFrameBad) {
  FlowScene scene;
  AssessedStream no_features;
  no_features.start();
  no_features.features().clear();
  EXPECT_EQ(no_features.next({}).scene_class, SceneClass::kBad);
  EXPECT_EQ(no_features.next(scene.tracks()).scene_class, SceneClass::kBad);
  AssessedStream no_depth;
  no_depth.start();
  std::fill(no_depth.depth_m().begin(), no_depth.depth_m().end(), 0.0F);
  const SceneReport blind = no_depth.next(scene.tracks());
  EXPECT_EQ(blind.scene_class, SceneClass::kBad);
  EXPECT_STREQ(blind.weakest, "depth");
}

TEST(SceneAssessor, AMotionSeenOnPeopleAloneIsNotTrusted) {
  AssessedStream stream;
  stream.start();
  FlowScene scene;
  std::vector<FlowTrack> tracks = scene.tracks();
  const double before = stream.next(tracks).reliability;
  // The same motion everywhere, but all of it on somebody before the camera.
  for (FlowTrack& track : tracks) track.current.suspect = true;
  const SceneReport covered = stream.next(tracks);
  EXPECT_EQ(covered.terms.background_share, 0.0);
  EXPECT_EQ(covered.reliability, 0.0);
  EXPECT_STREQ(covered.weakest, "share of background");
  for (std::size_t i = 0; i < tracks.size(); ++i) tracks[i].current.suspect = i % 4 != 0;
  EXPECT_NEAR(stream.next(tracks).terms.background_share, 0.25, 0.02);
  for (std::size_t i = 0; i < tracks.size(); ++i) tracks[i].current.suspect = i % 3 == 0;
  EXPECT_NEAR(stream.next(tracks).reliability, before, 1e-3);
}

TEST(SceneAssessor, WhatComesBeforeTheBackgroundIsNoScene) {
  FlowScene scene;
  scene.T_current_reference = Pose::Identity();
  const std::vector<FlowTrack> tracks = scene.tracks();
  AssessedStream stream;
  stream.start();
  const SceneReport open = stream.next(tracks);
  EXPECT_EQ(open.terms.clear_share, 1.0);
  EXPECT_EQ(open.scene_class, SceneClass::kGood);
  // Something fills the view, and all that is seen of it moves as one: tracks alone say GOOD.
  std::fill(stream.depth_m().begin(), stream.depth_m().end(), 0.6F);
  for (int i = 0; i < 20; ++i) {
    const SceneReport covered = stream.next(tracks);
    EXPECT_EQ(covered.terms.clear_share, 0.0);
    EXPECT_EQ(covered.reliability, 0.0);
    EXPECT_EQ(covered.scene_class, SceneClass::kBad);
    // From the second frame on its tracks are known to be no room's.
    EXPECT_EQ(covered.terms.background_share, i == 0 ? 1.0 : 0.0);
    EXPECT_STREQ(covered.weakest, i == 0 ? "share of clear view" : "share of background");
    EXPECT_NE(covered.line().find("clear 0.000"), std::string::npos);
  }
  std::fill(stream.depth_m().begin(), stream.depth_m().end(), 2.0F);
  EXPECT_EQ(stream.next(tracks).terms.clear_share, 1.0);
  EXPECT_EQ(stream.next(tracks).scene_class, SceneClass::kGood);
  // Not asked for, it is measured and changes nothing.
  SceneAssessorOptions options;
  options.min_clear_share = 0.0;
  AssessedStream careless(options);
  careless.start();
  std::fill(careless.depth_m().begin(), careless.depth_m().end(), 0.6F);
  for (int i = 0; i < 3; ++i) {
    const SceneReport covered = careless.next(tracks);
    EXPECT_EQ(covered.terms.clear_share, 0.0);
    EXPECT_EQ(covered.terms.background_share, 1.0);
    EXPECT_EQ(covered.scene_class, SceneClass::kGood);
  }
  // Without depth there is nothing to say.
  AssessedStream blind;
  blind.depth_m().clear();
  blind.start();
  EXPECT_EQ(blind.next(tracks).terms.clear_share, 1.0);
}

TEST(SceneAssessor, APoseFromElsewhereIsBelievedWhateverTheTracksAreOn) {
  FlowScene scene;
  scene.T_current_reference = Pose::Identity();
  std::vector<FlowTrack> tracks = scene.tracks();
  for (FlowTrack& track : tracks) track.current.suspect = true;
  const Pose still = Pose::Identity();
  AssessedStream told;
  AssessedStream untold;
  for (int i = 1; i <= 5; ++i) {
    told.next(scene.tracks(), &still);
    untold.next(scene.tracks());
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(told.next(tracks, &still).has_step_motion);
    EXPECT_FALSE(untold.next(tracks).has_step_motion);
  }
}

/// A camera on its way at constant velocity, whose tracks are those of the assessor's reference.
class MovingStream {
 public:
  explicit MovingStream(const SceneAssessorOptions& options = {}) : stream_(options) {}

  /// Next frame; `T_mover` moves the points of the given share between any two frames.
  SceneReport next(double mover_share = 0.0, const Pose& T_mover = Pose::Identity(),
                   double detected_share = 0.0) {
    T_world_camera_.push_back(T_world_camera_.back() * step_.inverse());
    FlowScene scene;
    scene.mover_share = mover_share;
    scene.detected_share = detected_share;
    scene.T_mover = T_mover;
    scene.seed = T_world_camera_.size();
    const std::uint64_t id = T_world_camera_.size() - 1;
    if (stream_.assessor().has_reference()) {
      const std::uint64_t reference = stream_.assessor().reference_id();
      scene.T_current_reference = T_world_camera_[id].inverse() * T_world_camera_[reference];
    }
    SceneReport report = stream_.next(scene.tracks());
    EXPECT_TRUE(report.status.ok());
    if (report.has_next_motion) {
      const Pose truth = T_world_camera_[id].inverse() * T_world_camera_[report.next_reference_id];
      next_motion_error_ = test::pose_distance(report.T_current_next_reference, truth);
    }
    return report;
  }

  /// A frame into which no point was followed.
  SceneReport next_blind() {
    T_world_camera_.push_back(T_world_camera_.back() * step_.inverse());
    return stream_.next();
  }

  double next_motion_error() const { return next_motion_error_; }

 private:
  AssessedStream stream_;
  Pose step_ = flow_pose(0.02, -0.01, 0.015, 0.004, 0.01, -0.006);
  std::vector<Pose> T_world_camera_ = {Pose::Identity()};  // of frame 0, which is not there
  double next_motion_error_ = 0.0;
};

TEST(SceneAssessor, ASteadyCameraIsPredictedFromTheFirstJudgedFrameOn) {
  MovingStream stream;
  for (int i = 1; i <= 30; ++i) {
    const SceneReport report = stream.next();
    if (report.terms.initial) continue;
    EXPECT_GT(report.terms.continuity, 0.95) << "frame " << i;
    if (report.reference_changed) {
      EXPECT_TRUE(report.has_next_motion) << "frame " << i;
      EXPECT_LT(stream.next_motion_error(), 0.01) << "frame " << i;
    }
  }
}

TEST(SceneAssessor, ALeapOfTheMotionIsDistrusted) {
  MovingStream stream;
  for (int i = 1; i <= 12; ++i) stream.next();
  // Suddenly nearly everything moves together, and there is no telling it from the room but by the
  // leap that the camera would have made.
  const SceneReport report = stream.next(0.99, flow_pose(0.3, 0.0, 0.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(report.scene_class, SceneClass::kBad) << report.line();
  EXPECT_LT(report.terms.continuity, 0.3);
  EXPECT_STREQ(report.weakest, "continuity");
}

TEST(SceneAssessor, WhilePeopleAreAllThatMovesTheCameraGoesOnAsItDid) {
  SceneAssessorOptions options;
  options.max_coasted_frames = 10;
  const Pose T_mover = flow_pose(0.1, 0.0, 0.0, 0.0, 0.0, 0.0);
  MovingStream stream(options);
  for (int i = 1; i <= 12; ++i) stream.next();
  for (int i = 0; i < options.max_coasted_frames - 2; ++i) {
    const SceneReport report = stream.next(0.97, T_mover, 1.0);
    EXPECT_EQ(report.scene_class, SceneClass::kBad) << report.line();
    EXPECT_LT(report.terms.background_share, 0.1);
    EXPECT_FALSE(report.has_step_motion);
  }
  // When they are gone, the camera is found where it would be by now.
  const SceneReport found = stream.next();
  EXPECT_GT(found.terms.continuity, 0.9) << found.line();
  EXPECT_EQ(found.scene_class, SceneClass::kGood) << found.line();
  // Not for ever: after that many frames what is seen is believed to be the camera's motion.
  MovingStream patient(options);
  for (int i = 1; i <= 12; ++i) patient.next();
  for (int i = 0; i < options.max_coasted_frames; ++i) {
    EXPECT_FALSE(patient.next(0.97, T_mover, 1.0).has_step_motion);
  }
  patient.next(0.97, T_mover, 1.0);
  EXPECT_TRUE(patient.next(0.97, T_mover, 1.0).has_step_motion);
}

TEST(SceneAssessor, AfterAllTracksWereLostItSettlesAnew) {
  SceneAssessorOptions options;
  options.num_settling_frames = 30;
  MovingStream stream(options);
  for (int i = 1; i <= 12; ++i) EXPECT_EQ(stream.next().terms.settled_share, 1.0);
  // A second of nothing: nothing is left of the path, and of the references on it.
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(stream.next_blind().scene_class, SceneClass::kBad);
  }
  double last = 0.0;
  for (int i = 0; i < 40; ++i) {
    const SceneReport report = stream.next();
    if (!report.residual.status.ok()) continue;
    EXPECT_GE(report.terms.settled_share, last);
    last = report.terms.settled_share;
    if (last < 0.2) {
      EXPECT_EQ(report.scene_class, SceneClass::kBad) << report.line();
    }
  }
  EXPECT_EQ(last, 1.0);
  EXPECT_EQ(stream.next().scene_class, SceneClass::kGood);
}

TEST(SceneAssessor, LostTracksRaiseTheResidualToTheScale) {
  AssessedStream stream;
  stream.start();
  FlowScene scene;
  std::vector<FlowTrack> tracks = scene.tracks();
  for (std::size_t i = 0; i < tracks.size(); ++i) tracks[i].alive = i % 5 == 0;
  const SceneReport report = stream.next(tracks);
  EXPECT_GE(report.terms.residual_px, stream.assessor().options().residual_scale_px);
  EXPECT_LT(report.residual.value_px, 1.0);
}

TEST(SceneAssessor, StateIsASnapshot) {
  AssessedStream a;
  AssessedStream b;
  FlowScene scene;
  scene.mover_share = 0.3;
  for (int i = 0; i < 20; ++i) a.next(scene.tracks());
  static_assert(std::is_trivially_copyable_v<SceneAssessor::State>, "");
  std::array<unsigned char, sizeof(SceneAssessor::State)> saved{};
  std::memcpy(saved.data(), &a.assessor().state(), saved.size());
  SceneAssessor::State state;
  std::memcpy(&state, saved.data(), saved.size());
  b.assessor().restore(state);
  for (int i = 0; i < 21; ++i) b.next();  // ids up to 20 are refused, 21 is not
  b.assessor().restore(state);
  for (int i = 0; i < 10; ++i) {
    scene.seed = std::uint64_t(i);
    SceneObservation frame;
    frame.frame_id = std::uint64_t(100 + i);
    const std::vector<FlowTrack> tracks = scene.tracks();
    frame.tracks = tracks;
    frame.features = a.features();
    const SceneReport from_a = a.assessor().assess(frame);
    const SceneReport from_b = b.assessor().assess(frame);
    EXPECT_EQ(from_a.reliability, from_b.reliability);
    EXPECT_EQ(from_a.next_reference_id, from_b.next_reference_id);
  }
}

TEST(SceneAssessor, RefusesWithoutChangingAnything) {
  AssessedStream stream;
  stream.start();
  SceneObservation again;
  again.frame_id = 5;
  EXPECT_EQ(stream.assessor().assess(again).status.code, StatusCode::kInvalidArgument);
  EXPECT_TRUE(stream.next().status.ok());
  SceneAssessorOptions options;
  options.residual_scale_px = 0.0;
  SceneAssessor bad(test::flow_camera(), options);
  EXPECT_EQ(bad.assess({}).status.code, StatusCode::kInvalidArgument);
  EXPECT_FALSE(SceneAssessor(PinholeCamera{}).status().ok());
}

TEST(SceneAssessor, NoInputGivesANumberThatIsNone) {
  // Nothing at all, frame after frame: BAD, and every number that is reported is one.
  SceneAssessor assessor(test::flow_camera());
  for (std::uint64_t id = 1; id < 12; ++id) {
    SceneObservation frame;
    frame.frame_id = id;
    const SceneReport report = assessor.assess(frame);
    ASSERT_TRUE(report.status.ok());
    EXPECT_EQ(report.reliability, 0.0);
    EXPECT_EQ(report.scene_class, SceneClass::kBad);
    EXPECT_TRUE(std::isfinite(report.terms.residual_px));
  }
}

}  // namespace
}  // namespace srslam
