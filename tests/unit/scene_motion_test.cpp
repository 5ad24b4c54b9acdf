#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "srslam/scene/flow_prediction.hpp"
#include "srslam/scene/motion_residual.hpp"
#include "support/flow_scene.hpp"

namespace srslam {
namespace {

using test::flow_camera;
using test::flow_pose;
using test::FlowScene;
using test::pose_distance;

FlowTrack moved(float u, float v, float du, float dv) {
  FlowTrack track;
  track.reference.u_px = u;
  track.reference.v_px = v;
  track.current.u_px = u + du;
  track.current.v_px = v + dv;
  track.alive = true;
  return track;
}

MotionResidualOptions raw_motion() {
  MotionResidualOptions options;
  options.compensation = MotionCompensation::kNone;
  return options;
}

MotionResidualResult residual_of(const std::vector<FlowTrack>& tracks,
                                 const MotionResidualOptions& options = {},
                                 const PinholeCamera& camera = flow_camera()) {
  DominantMotionWorkspace workspace;
  return motion_residual(tracks, camera, nullptr, options, &workspace);
}

// --- Eq. 6 ---------------------------------------------------------------------------------------

TEST(MotionResidual, HandComputed) {
  // Two tracks in the first cell, one in the last: lengths 5, 5 and 10, mean 20 / 3. The cells'
  // mean vectors are (3, 0) and (0, 10), of length 3 and 10.
  std::vector<FlowTrack> tracks = {moved(10, 10, 3, 4), moved(20, 20, 3, -4),
                                   moved(600, 460, 0, 10)};
  MotionResidualOptions options = raw_motion();
  MotionResidualResult result = residual_of(tracks, options);
  ASSERT_TRUE(result.status.ok());
  EXPECT_NEAR(result.mean_magnitude_px, 20.0 / 3.0, 1e-6);
  EXPECT_NEAR(result.mean_cell_px, 13.0 / 2.0, 1e-6);
  EXPECT_NEAR(result.value_px, 20.0 / 3.0 + 6.5, 1e-6);
  EXPECT_EQ(result.cells[0].num_tracks, 2);
  EXPECT_NEAR(result.cells[0].mean_u_px, 3.0, 1e-6);
  EXPECT_NEAR(result.cells[8].mean_v_px, 10.0, 1e-6);
  EXPECT_EQ(result.alive_share, 1.0);
  // As printed the mean is over all nine cells.
  options.cell_mean = CellMean::kAllCells;
  EXPECT_NEAR(residual_of(tracks, options).value_px, 20.0 / 3.0 + 13.0 / 9.0, 1e-6);
  // Lost tracks do not count, but are told.
  tracks.push_back(moved(300, 200, 50, 50));
  tracks.back().alive = false;
  result = residual_of(tracks, raw_motion());
  EXPECT_NEAR(result.value_px, 20.0 / 3.0 + 6.5, 1e-6);
  EXPECT_EQ(result.num_alive, 3);
  EXPECT_EQ(result.alive_share, 0.75);
}

TEST(MotionResidual, OfATranslationIsTwiceItsLength) {
  std::vector<FlowTrack> tracks;
  tracks.reserve(60);
  for (int i = 0; i < 60; ++i) {
    tracks.push_back(moved(float(10 * i + 5), float((37 * i) % 470), 6, 8));
  }
  EXPECT_NEAR(residual_of(tracks, raw_motion()).value_px, 20.0, 1e-5);
  // Opposite motions cancel in the second term only.
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    FlowTrack opposite = tracks[i];
    opposite.current.u_px -= 12;
    opposite.current.v_px -= 16;
    tracks.push_back(opposite);
    if (tracks.size() == 120) break;
  }
  const MotionResidualResult result = residual_of(tracks, raw_motion());
  EXPECT_NEAR(result.mean_magnitude_px, 10.0, 1e-5);
  EXPECT_NEAR(result.mean_cell_px, 0.0, 1e-5);
}

TEST(MotionResidual, HasTheResolutionTakenOut) {
  FlowScene scene;
  scene.noise_px = 0.0;
  scene.mover_share = 0.2;
  // The same frames at half the size: pixel u becomes (u + 0.5) / 2 - 0.5.
  const std::vector<FlowTrack> tracks = scene.tracks();
  std::vector<FlowTrack> half = tracks;
  for (FlowTrack& track : half) {
    for (FlowPoint* point : {&track.reference, &track.current}) {
      point->u_px = (point->u_px + 0.5F) / 2.0F - 0.5F;
      point->v_px = (point->v_px + 0.5F) / 2.0F - 0.5F;
    }
  }
  for (const MotionCompensation compensation :
       {MotionCompensation::kNone, MotionCompensation::kAffine, MotionCompensation::kRigid}) {
    MotionResidualOptions options;
    options.compensation = compensation;
    const MotionResidualResult large = residual_of(tracks, options);
    const MotionResidualResult small = residual_of(half, options, scene.camera.scaled(0.5));
    ASSERT_TRUE(large.status.ok());
    EXPECT_NEAR(small.value_px, large.value_px, 0.01 * large.value_px) << to_string(compensation);
    EXPECT_NEAR(small.inlier_share, large.inlier_share, 0.01);
  }
}

TEST(MotionResidual, IgnoresTheCamerasMotionWhenCompensated) {
  // Translation and rotation, from none to much: the raw residual follows, the other does not.
  double last_raw = -1.0;
  for (const double amount : {0.0, 0.5, 1.0, 2.0}) {
    FlowScene scene;
    scene.T_current_reference = flow_pose(0.1 * amount, -0.04 * amount, 0.08 * amount,
                                          0.02 * amount, 0.06 * amount, 0.04 * amount);
    const MotionResidualResult rigid = residual_of(scene.tracks());
    ASSERT_TRUE(rigid.status.ok());
    EXPECT_EQ(rigid.compensation, MotionCompensation::kRigid);
    EXPECT_LT(rigid.value_px, 0.5);
    EXPECT_GT(rigid.inlier_share, 0.99);
    EXPECT_LT(pose_distance(rigid.motion.T_current_reference, scene.T_current_reference), 3e-3);
    const double raw = residual_of(scene.tracks(), raw_motion()).value_px;
    EXPECT_GT(raw, last_raw);
    last_raw = raw;
  }
  EXPECT_GT(last_raw, 60.0);
}

TEST(MotionResidual, GrowsWithIndependentMotion) {
  double last = -1.0;
  double last_share = 1.0;
  for (const double step_m : {0.0, 0.005, 0.01, 0.02, 0.04}) {
    FlowScene scene;
    scene.mover_share = 0.3;
    scene.T_mover = flow_pose(step_m, 0.0, 0.0, 0.0, 0.0, 0.0);
    MotionResidualOptions options;
    options.noise_px = 0.0;
    const MotionResidualResult result = residual_of(scene.tracks(), options);
    ASSERT_TRUE(result.status.ok());
    EXPECT_GT(result.value_px, last);
    EXPECT_LE(result.inlier_share, last_share);
    last = result.value_px;
    last_share = result.inlier_share;
  }
  EXPECT_NEAR(last_share, 0.7 / 0.95, 0.05);
}

TEST(MotionResidual, ASpuriousShareDoesNotCount) {
  // Nothing moves but every tenth track, by 5, 6, ..., 14 px.
  std::vector<FlowTrack> tracks;
  for (int i = 0; i < 100; ++i) {
    const float step_px = i % 10 == 0 ? 5.0F + 0.1F * float(i) : 0.0F;
    FlowTrack track = moved(float(6 * i + 15), float((53 * i) % 470), 0, step_px);
    track.reference.depth_m = 2.0F;
    tracks.push_back(track);
  }
  DominantMotionWorkspace workspace;
  MotionResidualOptions options;
  options.noise_px = 0.0;
  options.max_vector_px = 100.0;
  const auto measured = [&](double spurious_share) {
    options.spurious_share = spurious_share;
    return motion_residual_given_pose(tracks, flow_camera(), Pose::Identity(), options, &workspace);
  };
  const MotionResidualResult all = measured(0.0);
  EXPECT_NEAR(all.mean_magnitude_px, 95.0 / 100.0, 1e-4);
  EXPECT_NEAR(all.inlier_share, 0.9, 1e-12);
  EXPECT_EQ(all.num_used, 100);
  const MotionResidualResult some = measured(0.05);  // 10 to 14 px are left out
  EXPECT_NEAR(some.mean_magnitude_px, 35.0 / 95.0, 1e-4);
  EXPECT_NEAR(some.inlier_share, 0.9 / 0.95, 1e-12);
  EXPECT_EQ(some.num_used, 95);
  const MotionResidualResult without = measured(0.1);
  EXPECT_NEAR(without.value_px, 0.0, 1e-4);
  EXPECT_NEAR(without.inlier_share, 1.0, 1e-12);
  EXPECT_NEAR(measured(0.2).inlier_share, 1.0, 1e-12);
  options.spurious_share = 1.0;
  EXPECT_FALSE(options.validate().ok());
}

TEST(MotionResidual, WithoutDepthFallsBackToAffineFlow) {
  FlowScene scene;
  scene.T_current_reference = flow_pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.05);  // a roll is affine
  std::vector<FlowTrack> tracks = scene.tracks();
  for (FlowTrack& track : tracks) track.reference.depth_m = 0.0F;
  const MotionResidualResult result = residual_of(tracks);
  ASSERT_TRUE(result.status.ok());
  EXPECT_EQ(result.compensation, MotionCompensation::kAffine);
  EXPECT_LT(result.value_px, 0.5);
  EXPECT_NEAR(result.motion.affine(0, 1), -std::sin(0.05), 1e-3);
}

TEST(MotionResidual, AgainstAGivenPoseEstimatesNothing) {
  FlowScene scene;
  scene.mover_share = 0.7;  // would win without votes
  scene.detected_share = 0.0;
  const std::vector<FlowTrack> tracks = scene.tracks();
  DominantMotionWorkspace workspace;
  const MotionResidualResult result =
      motion_residual_given_pose(tracks, scene.camera, scene.T_current_reference, {}, &workspace);
  ASSERT_TRUE(result.status.ok());
  EXPECT_NEAR(result.inlier_share, 0.3, 0.05);
  EXPECT_EQ(result.motion.certainty, 1.0);
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(motion_residual_given_pose(tracks, scene.camera, broken, {}, &workspace).status.code,
            StatusCode::kInvalidArgument);
}

TEST(MotionResidual, NothingToMeasureIsSaidAndIsNoNumber) {
  for (const MotionCompensation compensation :
       {MotionCompensation::kNone, MotionCompensation::kAffine, MotionCompensation::kRigid}) {
    MotionResidualOptions options;
    options.compensation = compensation;
    MotionResidualResult result = residual_of({}, options);
    EXPECT_EQ(result.status.code, StatusCode::kInsufficientData);
    EXPECT_TRUE(std::isnan(result.value_px));
    EXPECT_EQ(result.alive_share, 0.0);
    FlowTrack lost = moved(5, 5, 1, 1);
    lost.alive = false;
    EXPECT_EQ(residual_of({lost}, options).status.code, StatusCode::kInsufficientData);
  }
  // Too few, all in one place, all NaN: no crash, no answer.
  EXPECT_EQ(residual_of({moved(5, 5, 1, 1)}).status.code, StatusCode::kInsufficientData);
  std::vector<FlowTrack> same(50, moved(100, 100, 2, 2));
  for (FlowTrack& track : same) track.reference.depth_m = 2.0F;
  const MotionResidualResult one_place = residual_of(same);
  EXPECT_TRUE(one_place.status.ok() || one_place.status.code == StatusCode::kDegenerate);
  if (one_place.status.ok()) {
    EXPECT_TRUE(std::isfinite(one_place.value_px));
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<FlowTrack> broken(50, moved(nan, 100, 2, nan));
  EXPECT_FALSE(residual_of(broken).status.ok());
  EXPECT_FALSE(residual_of(broken, raw_motion()).status.ok());
  MotionResidualOptions bad;
  bad.motion.inlier_px = 0.0;
  EXPECT_EQ(residual_of(same, bad).status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(residual_of(same, {}, PinholeCamera{}).status.code, StatusCode::kInvalidArgument);
}

// --- The camera's motion -------------------------------------------------------------------------

DominantMotionResult rigid_motion(const FlowScene& scene, const Pose* predicted = nullptr,
                                  const DominantMotionOptions& options = {}) {
  DominantMotionWorkspace workspace;
  return dominant_rigid_motion(scene.tracks(), scene.camera, predicted, options, &workspace);
}

TEST(DominantMotion, VotesFindTheCameraBehindPeopleOverMostOfTheImage) {
  for (const double share : {0.3, 0.5, 0.65}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      FlowScene scene;
      scene.mover_share = share;
      scene.seed = seed;
      scene.detected_share = 0.8;
      const DominantMotionResult result = rigid_motion(scene);
      ASSERT_TRUE(result.status.ok());
      EXPECT_EQ(result.num_motions, 2);
      EXPECT_LT(pose_distance(result.T_current_reference, scene.T_current_reference), 5e-3)
          << share << " seed " << seed;
      EXPECT_NEAR(result.inlier_share, 1.0 - share, 0.12);
      EXPECT_GT(result.certainty, 0.3);
      // Without votes the larger one is taken.
      DominantMotionOptions no_votes;
      no_votes.vote_floor = 1.0;
      if (share > 0.6) {
        EXPECT_GT(pose_distance(rigid_motion(scene, nullptr, no_votes).T_current_reference,
                                scene.T_current_reference),
                  0.1);
      }
    }
  }
}

TEST(DominantMotion, EachVoteCountsByItself) {
  FlowScene scene;
  scene.mover_share = 0.55;
  scene.detected_share = 0.0;  // nothing detected: what is behind wins
  EXPECT_LT(pose_distance(rigid_motion(scene).T_current_reference, scene.T_current_reference),
            5e-3);
  // With equal depths the prediction decides.
  std::vector<FlowTrack> tracks = scene.tracks();
  DominantMotionWorkspace workspace;
  const DominantMotionResult predicted =
      dominant_rigid_motion(tracks, scene.camera, &scene.T_current_reference, {}, &workspace);
  EXPECT_NEAR(predicted.candidates[std::size_t(predicted.chosen)].continuity, 1.0, 0.05);
  EXPECT_GT(predicted.certainty, rigid_motion(scene).certainty);
}

TEST(DominantMotion, SameInputSameBitsInAnyOrderTheSameMotion) {
  FlowScene scene;
  scene.mover_share = 0.3;
  const DominantMotionResult a = rigid_motion(scene);
  const DominantMotionResult b = rigid_motion(scene);
  EXPECT_TRUE(a.T_current_reference.matrix() == b.T_current_reference.matrix());
  std::vector<FlowTrack> backwards = scene.tracks();
  std::reverse(backwards.begin(), backwards.end());
  DominantMotionWorkspace workspace;
  const DominantMotionResult c =
      dominant_rigid_motion(backwards, scene.camera, nullptr, {}, &workspace);
  EXPECT_LT(pose_distance(a.T_current_reference, c.T_current_reference), 1e-3);
}

TEST(DominantMotion, StepIsTheGradientsByDifferences) {
  // One Gauss-Newton step from near the truth must land on it: a wrong Jacobian would not.
  FlowScene scene;
  scene.noise_px = 0.0;
  scene.num_tracks = 50;
  const std::vector<FlowTrack> tracks = scene.tracks();
  DominantMotionWorkspace workspace;
  detail::collect_rigid_tracks(tracks, scene.camera, &workspace);
  detail::activate_all(&workspace);
  const detail::RigidModel model(scene.camera);
  for (int axis = 0; axis < 6; ++axis) {
    Vector6 off = Vector6::Zero();
    off[axis] = 1e-4;
    Pose pose = se3_exp(off) * scene.T_current_reference;
    double step_norm = 0.0;
    ASSERT_TRUE(model.step(workspace, workspace.active, detail::kNoLimit_px2, &pose, &step_norm));
    EXPECT_NEAR(step_norm, 1e-4, 2e-6) << axis;
    EXPECT_LT(pose_distance(pose, scene.T_current_reference), 3e-6) << axis;
  }
}

TEST(DominantMotion, RefusesOptionsOutOfRange) {
  const auto refused = [](auto&& change) {
    DominantMotionOptions options;
    change(options);
    return !options.validate().ok();
  };
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.inlier_px = -1.0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.reference_width_px = 0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.min_tracks = 3; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.max_motions = 4; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.min_motion_share = 0.0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.max_samples = 0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.sample_confidence = 1.0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.max_scored = 1; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.refine_iterations = 0; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.vote_floor = 1.5; }));
  EXPECT_TRUE(refused([](DominantMotionOptions& o) { o.velocity_scale_px = 0.0; }));
}

// --- Flow points ---------------------------------------------------------------------------------

TEST(FlowPoint, TakesDepthAndSuspicionFromTheFrame) {
  std::vector<float> depth = {1.0F, 2.0F, -1.0F, std::numeric_limits<float>::infinity()};
  const ImageView<const float> view(depth.data(), 2, 2);
  Detection person;
  person.class_name = "person";
  person.x_min_px = 0.5;
  person.x_max_px = 1.5;
  person.y_min_px = -0.5;
  person.y_max_px = 0.5;
  Detection chair = person;
  chair.class_name = "chair";
  chair.x_min_px = -0.5;
  const std::vector<Detection> detections = {chair, person};
  FlowPoint point;
  describe_flow_point(view, detections, &point);
  EXPECT_EQ(point.depth_m, 1.0F);
  EXPECT_FALSE(point.suspect);  // a chair does not move by itself
  point.u_px = 1.2F;
  describe_flow_point(view, detections, &point);
  EXPECT_EQ(point.depth_m, 2.0F);
  EXPECT_TRUE(point.suspect);
  point.v_px = 1.0F;
  describe_flow_point(view, detections, &point);
  EXPECT_EQ(point.depth_m, 0.0F);
  point.u_px = 7.0F;
  describe_flow_point(view, detections, &point);
  EXPECT_EQ(point.depth_m, 0.0F);
  describe_flow_point({}, {}, &point);
  EXPECT_FALSE(point.suspect);
}

TEST(PredictFlowPoints, IsWhereStillPointsAre) {
  FlowScene scene;
  scene.noise_px = 0.0;
  const std::vector<FlowTrack> tracks = scene.tracks();
  std::vector<FlowPoint> points;
  points.reserve(tracks.size());
  for (const FlowTrack& track : tracks) points.push_back(track.reference);
  points[0].depth_m = 0.0F;
  std::vector<FlowPoint> predicted;
  predict_flow_points(points, scene.camera, scene.T_current_reference, &predicted);
  ASSERT_EQ(predicted.size(), points.size());
  EXPECT_EQ(predicted[0].u_px, points[0].u_px);  // without depth there is no telling
  for (std::size_t i = 1; i < predicted.size(); ++i) {
    if (!tracks[i].alive) continue;
    EXPECT_NEAR(predicted[i].u_px, tracks[i].current.u_px, 1e-3F);
    EXPECT_NEAR(predicted[i].v_px, tracks[i].current.v_px, 1e-3F);
    EXPECT_EQ(predicted[i].depth_m, points[i].depth_m);
  }
  // Behind the camera, and out of the image.
  predict_flow_points(points, scene.camera, flow_pose(0.0, 0.0, -9.0, 0.0, 0.0, 0.0), &predicted);
  EXPECT_EQ(predicted[5].u_px, points[5].u_px);
  predict_flow_points(points, scene.camera, flow_pose(90.0, 0.0, 0.0, 0.0, 0.0, 0.0), &predicted);
  EXPECT_EQ(predicted[5].u_px, points[5].u_px);
}

}  // namespace
}  // namespace srslam
