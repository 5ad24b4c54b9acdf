#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "srslam/interop/opencv.hpp"
#include "support/random_texture.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

/// Smooth random texture that is larger than the view into it.
cv::Mat random_texture(std::uint64_t seed) {
  test::Rng rng(seed);
  return test::random_texture(rng, 500, 400, 2.5);
}

/// 320×240 pixels of the texture, whose content moves by (du, dv) for du, dv > 0.
cv::Mat view_of(const cv::Mat& texture, double du, double dv) {
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, du - 90, 0, 1, dv - 80);
  cv::Mat view;
  cv::warpAffine(texture, view, shift, {320, 240}, cv::INTER_LINEAR);
  return view;
}

std::vector<FlowPoint> grid_points() {
  std::vector<FlowPoint> points;
  points.reserve(130);
  for (int v = 20; v < 230; v += 20) {
    for (int u = 20; u < 310; u += 24) {
      FlowPoint point;
      point.u_px = float(u);
      point.v_px = float(v);
      point.depth_m = float(u);  // must come through untouched
      points.push_back(point);
    }
  }
  return points;
}

TEST(LucasKanadeTracker, FollowsPointsOfTheNewestFrameOneFrameBack) {
  const cv::Mat texture = random_texture(2);
  const std::vector<FlowPoint> points = grid_points();
  LucasKanadeTracker tracker;
  std::vector<FlowTrack> tracks(3);
  EXPECT_EQ(tracker.track_back(points, {}, &tracks).code, StatusCode::kInsufficientData);
  ASSERT_TRUE(tracker.push(1, as_view<std::uint8_t>(view_of(texture, 0, 0)), points).ok());
  EXPECT_EQ(tracker.track_back(points, {}, &tracks).code, StatusCode::kInsufficientData);
  EXPECT_TRUE(tracks.empty());
  ASSERT_TRUE(tracker.follow(1).ok());
  ASSERT_TRUE(tracker.push(2, as_view<std::uint8_t>(view_of(texture, 4.2, -2.6)), {}).ok());
  ASSERT_TRUE(tracker.push(3, as_view<std::uint8_t>(view_of(texture, 7.5, -1.5)), {}).ok());
  const std::vector<FlowTrack> forward(tracker.tracks().begin(), tracker.tracks().end());

  std::vector<FlowPoint> guess = points;
  for (FlowPoint& point : guess) point.u_px -= 3.0F;
  for (const ArrayView<const FlowPoint> guesses : {ArrayView<const FlowPoint>(), {guess}}) {
    ASSERT_TRUE(tracker.track_back(points, guesses, &tracks).ok());
    ASSERT_EQ(tracks.size(), points.size());
    std::size_t num_alive = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(tracks[i].current.u_px, points[i].u_px) << "the point stays as it was given";
      EXPECT_EQ(tracks[i].current.depth_m, points[i].depth_m);
      if (!tracks[i].alive) continue;
      ++num_alive;
      EXPECT_NEAR(double(tracks[i].reference.u_px), double(points[i].u_px) - 3.3, 0.3);
      EXPECT_NEAR(double(tracks[i].reference.v_px), double(points[i].v_px) - 1.1, 0.3);
    }
    EXPECT_GT(num_alive, points.size() * 8 / 10);
  }

  // The reference and its tracks are as they were.
  EXPECT_EQ(tracker.reference_id(), 1U);
  ASSERT_EQ(tracker.tracks().size, forward.size());
  for (std::size_t i = 0; i < forward.size(); ++i) {
    EXPECT_EQ(tracker.tracks()[i].alive, forward[i].alive);
    EXPECT_EQ(tracker.tracks()[i].current.u_px, forward[i].current.u_px);
  }
  guess.pop_back();
  EXPECT_EQ(tracker.track_back(points, guess, &tracks).code, StatusCode::kInvalidArgument);
  // Points at the border, or nowhere, are not followed.
  FlowPoint outside;
  outside.u_px = 2.0F;
  outside.v_px = 100.0F;
  FlowPoint nowhere;
  nowhere.u_px = std::nanf("");
  ASSERT_TRUE(tracker.track_back(std::vector<FlowPoint>{outside, nowhere}, {}, &tracks).ok());
  EXPECT_FALSE(tracks[0].alive);
  EXPECT_FALSE(tracks[1].alive);
}

TEST(LucasKanadeTracker, FollowsThePointsOfTheReferenceOverManyFrames) {
  const cv::Mat texture = random_texture(1);
  const std::vector<FlowPoint> points = grid_points();
  LucasKanadeTracker tracker;
  ASSERT_TRUE(tracker.status().ok());
  ASSERT_TRUE(tracker.push(1, as_view<std::uint8_t>(view_of(texture, 0, 0)), points).ok());
  EXPECT_FALSE(tracker.following());
  ASSERT_TRUE(tracker.follow(1).ok());
  double du = 0.0;
  double dv = 0.0;
  for (std::uint64_t id = 2; id <= 12; ++id) {
    du += 2.3;
    dv -= 1.4;
    // Other points for this frame: those of the reference must keep their identity.
    ASSERT_TRUE(tracker.push(id, as_view<std::uint8_t>(view_of(texture, du, dv)), {}).ok());
    ASSERT_EQ(tracker.tracks().size, points.size());
    std::size_t num_alive = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const FlowTrack& track = tracker.tracks()[i];
      EXPECT_EQ(track.reference.u_px, points[i].u_px);
      EXPECT_EQ(track.reference.depth_m, points[i].depth_m);
      if (!track.alive) continue;
      ++num_alive;
      EXPECT_NEAR(double(track.current.u_px), double(points[i].u_px) + du, 0.3) << id;
      EXPECT_NEAR(double(track.current.v_px), double(points[i].v_px) + dv, 0.3) << id;
      EXPECT_LE(track.current.u_px, 320.0F - 6.0F);
    }
    EXPECT_GT(num_alive, points.size() * 8 / 10) << id;
  }
}

TEST(LucasKanadeTracker, AnyRecentFrameCanBecomeTheReference) {
  const cv::Mat texture = random_texture(2);
  LucasKanadeOptions options;
  options.history = 4;
  LucasKanadeTracker tracker(options);
  const std::vector<FlowPoint> points = grid_points();
  for (std::uint64_t id = 1; id <= 9; ++id) {
    ASSERT_TRUE(
        tracker.push(id, as_view<std::uint8_t>(view_of(texture, 1.5 * double(id), 0)), points)
            .ok());
  }
  EXPECT_EQ(tracker.follow(5).code, StatusCode::kNotFound);
  EXPECT_EQ(tracker.follow(10).code, StatusCode::kNotFound);
  EXPECT_FALSE(tracker.following());
  for (std::uint64_t id = 6; id <= 9; ++id) {
    ASSERT_TRUE(tracker.follow(id).ok());
    EXPECT_EQ(tracker.reference_id(), id);
    std::size_t num_alive = 0;
    for (const FlowTrack& track : tracker.tracks()) {
      if (!track.alive) continue;
      ++num_alive;
      EXPECT_NEAR(double(track.current.u_px - track.reference.u_px), 1.5 * double(9 - id), 0.2);
    }
    EXPECT_GT(num_alive, points.size() * 8 / 10);
  }
}

// Sixty pixels between the reference and now are too many to be found from where points were.
TEST(LucasKanadeTracker, AGuessIsWhereThePointIsSought) {
  const cv::Mat texture = random_texture(5);
  const std::vector<FlowPoint> points = grid_points();
  LucasKanadeOptions options;
  options.num_levels = 2;
  LucasKanadeTracker tracker(options);
  ASSERT_TRUE(tracker.push(1, as_view<std::uint8_t>(view_of(texture, 0, 0)), points).ok());
  ASSERT_TRUE(tracker.push(2, as_view<std::uint8_t>(view_of(texture, 60, 0)), {}).ok());
  EXPECT_EQ(tracker.points_of(1).size, points.size());
  EXPECT_EQ(tracker.points_of(2).size, 0U);
  EXPECT_EQ(tracker.points_of(3).size, 0U);
  const auto num_found = [&] {
    std::size_t count = 0;
    for (const FlowTrack& track : tracker.tracks()) {
      if (track.alive && std::abs(track.current.u_px - track.reference.u_px - 60.0F) < 0.3F)
        ++count;
    }
    return count;
  };
  ASSERT_TRUE(tracker.follow(1).ok());
  EXPECT_LT(num_found(), points.size() / 10);
  std::vector<FlowPoint> guess = points;
  for (FlowPoint& point : guess) point.u_px += 57.0F;
  ASSERT_TRUE(tracker.follow(1, guess).ok());
  EXPECT_GT(num_found(), points.size() * 6 / 10);
  guess.pop_back();
  EXPECT_EQ(tracker.follow(1, guess).code, StatusCode::kInvalidArgument);
}

TEST(LucasKanadeTracker, DropsWhatItCannotFollow) {
  const cv::Mat texture = random_texture(3);
  LucasKanadeTracker tracker;
  const std::vector<FlowPoint> points = grid_points();
  ASSERT_TRUE(tracker.push(1, as_view<std::uint8_t>(view_of(texture, 0, 0)), points).ok());
  ASSERT_TRUE(tracker.follow(1).ok());
  // Another texture in the right half: what was there is gone.
  cv::Mat changed = view_of(texture, 1, 0);
  view_of(random_texture(4), 0, 0)(cv::Rect(160, 0, 160, 240))
      .copyTo(changed(cv::Rect(160, 0, 160, 240)));
  ASSERT_TRUE(tracker.push(2, as_view<std::uint8_t>(changed), points).ok());
  std::size_t alive_left = 0;
  std::size_t alive_right = 0;
  std::size_t num_right = 0;
  for (const FlowTrack& track : tracker.tracks()) {
    if (track.reference.u_px < 140) alive_left += track.alive ? 1 : 0;
    if (track.reference.u_px < 180) continue;
    ++num_right;
    alive_right += track.alive ? 1 : 0;
  }
  EXPECT_GT(alive_left, 50U);
  EXPECT_LT(alive_right, num_right / 3);
  // A grey wall: nothing is left, and what is lost stays lost.
  const cv::Mat wall(240, 320, CV_8UC1, cv::Scalar(128));
  ASSERT_TRUE(tracker.push(3, as_view<std::uint8_t>(wall), points).ok());
  ASSERT_TRUE(tracker.push(4, as_view<std::uint8_t>(view_of(texture, 0, 0)), points).ok());
  for (const FlowTrack& track : tracker.tracks()) EXPECT_FALSE(track.alive);
}

TEST(LucasKanadeTracker, RefusesWhatItCannotUse) {
  LucasKanadeOptions options;
  options.window_px = 2;
  LucasKanadeTracker bad(options);
  EXPECT_EQ(bad.push(1, {}, {}).code, StatusCode::kInvalidArgument);
  LucasKanadeTracker tracker;
  EXPECT_EQ(tracker.follow(0).code, StatusCode::kNotFound);
  EXPECT_FALSE(tracker.push(1, {}, {}).ok());
  const cv::Mat image = view_of(random_texture(5), 0, 0);
  ASSERT_TRUE(tracker.push(1, as_view<std::uint8_t>(image), {}).ok());
  EXPECT_EQ(tracker.push(1, as_view<std::uint8_t>(image), {}).code, StatusCode::kInvalidArgument);
  const cv::Mat small = image(cv::Rect(0, 0, 160, 120));
  EXPECT_EQ(tracker.push(2, as_view<std::uint8_t>(small), {}).code, StatusCode::kInvalidArgument);
  ASSERT_TRUE(tracker.push(2, as_view<std::uint8_t>(image), {}).ok());
  ASSERT_TRUE(tracker.follow(2).ok());
  EXPECT_TRUE(tracker.tracks().empty());
  // An image hardly larger than the window has fewer levels.
  LucasKanadeTracker tiny;
  const cv::Mat patch = image(cv::Rect(10, 10, 24, 24)).clone();
  const std::vector<FlowPoint> one(1, FlowPoint{12.0F, 12.0F, 0.0F, false});
  ASSERT_TRUE(tiny.push(1, as_view<std::uint8_t>(patch), one).ok());
  ASSERT_TRUE(tiny.follow(1).ok());
  ASSERT_TRUE(tiny.push(2, as_view<std::uint8_t>(patch), one).ok());
  EXPECT_TRUE(tiny.tracks()[0].alive);
}

}  // namespace
}  // namespace srslam
