#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "srslam/scene/background_depth.hpp"
#include "srslam/scene/flow_track.hpp"
#include "support/flow_scene.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::flow_camera;
using test::flow_pose;

static_assert(std::is_trivially_copyable_v<BackgroundDepth::State>);

/// A depth image that can be painted.
class DepthImage {
 public:
  explicit DepthImage(float depth_m, int width_px = 640)
      : width_px_(width_px),
        height_px_(width_px * 3 / 4),
        pixels_(static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_),
                depth_m) {}

  /// Columns [first, last), as shares of the width.
  DepthImage& paint(double first, double last, float depth_m) {
    for (int v = 0; v < height_px_; ++v) {
      for (int u = 0; u < width_px_; ++u) {
        const double place = (u + 0.5) / width_px_;
        if (place < first || place >= last) continue;
        pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_) +
                static_cast<std::size_t>(u)] = depth_m;
      }
    }
    return *this;
  }
  ImageView<const float> view() const { return {pixels_.data(), width_px_, height_px_}; }

 private:
  int width_px_;
  int height_px_;
  std::vector<float> pixels_;
};

class Stream {
 public:
  explicit Stream(const BackgroundDepthOptions& options = {})
      : background_(flow_camera(), options) {}

  CoveredResult see(const DepthImage& image, const Pose& T_current_previous = Pose::Identity()) {
    return background_.update(image.view(), &T_current_previous, &state_);
  }
  CoveredResult see_blindly(const DepthImage& image) {
    return background_.update(image.view(), nullptr, &state_);
  }
  bool is_covered(double u_px, double v_px) const {
    return background_.is_covered(state_, u_px, v_px);
  }

 private:
  BackgroundDepth background_;
  BackgroundDepth::State state_;
};

TEST(BackgroundDepth, CountsTheCellsThatSomethingCameBefore) {
  Stream stream;
  const CoveredResult first = stream.see(DepthImage(4.0F));
  ASSERT_TRUE(first.status.ok());
  EXPECT_EQ(first.num_compared, 0);  // nothing is known before the first frame
  EXPECT_EQ(first.covered_share, 0.0);
  EXPECT_EQ(stream.see(DepthImage(4.0F)).num_compared, kBackgroundCells);
  // A board over eight of 32 columns.
  const CoveredResult board = stream.see(DepthImage(4.0F).paint(0.25, 0.5, 1.0F));
  EXPECT_EQ(board.num_covered, kBackgroundCells / 4);
  EXPECT_EQ(board.covered_share, 0.25);
  EXPECT_TRUE(stream.is_covered(240.0, 100.0));
  EXPECT_FALSE(stream.is_covered(100.0, 100.0));
  EXPECT_FALSE(stream.is_covered(400.0, 100.0));
  EXPECT_FALSE(stream.is_covered(-20.0, 100.0));
  EXPECT_FALSE(stream.is_covered(std::numeric_limits<double>::quiet_NaN(), 100.0));
  // It fills the view, and nothing else is to be seen: it is still before the background.
  for (int i = 0; i < 20; ++i) EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 1.0);
  EXPECT_EQ(stream.see(DepthImage(4.0F)).covered_share, 0.0);
  EXPECT_FALSE(stream.is_covered(240.0, 100.0));
}

TEST(BackgroundDepth, NearerIsMeantAsDocumented) {
  for (const auto& [depth_m, share] :
       {std::pair<float, double>{3.09F, 1.0}, {3.11F, 0.0}, {5.0F, 0.0}}) {
    Stream stream;
    stream.see(DepthImage(4.0F));
    // 0.8 of 4 m, less 0.1 m.
    EXPECT_EQ(stream.see(DepthImage(depth_m)).covered_share, share) << depth_m;
  }
  BackgroundDepthOptions options;
  options.nearer_ratio = 0.5;
  options.nearer_margin_m = 0.0;
  for (const auto& [depth_m, share] : {std::pair<float, double>{1.99F, 1.0}, {2.01F, 0.0}}) {
    Stream stream(options);
    stream.see(DepthImage(4.0F));
    EXPECT_EQ(stream.see(DepthImage(depth_m)).covered_share, share) << depth_m;
  }
}

TEST(BackgroundDepth, WhatStaysBecomesBackgroundAndWhatLeavesWasNone) {
  BackgroundDepthOptions options;
  options.max_covered_frames = 5;
  Stream stream(options);
  stream.see(DepthImage(4.0F));
  for (int i = 1; i <= 6; ++i) EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 1.0) << i;
  EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 0.0);
  // What was there from the start leaves, and comes back.
  EXPECT_EQ(stream.see(DepthImage(4.0F)).covered_share, 0.0);
  EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 1.0);
}

TEST(BackgroundDepth, MovesWithTheCamera) {
  // Two metres towards a wall, in steps: nothing has come between.
  Stream stream;
  Stream blind;
  const Pose step = flow_pose(0.0, 0.0, -0.05, 0.0, 0.0, 0.0);  // the wall comes nearer
  double largest_blind = 0.0;
  for (int i = 0; i <= 40; ++i) {
    const DepthImage image(4.0F - 0.05F * float(i));
    EXPECT_LT(stream.see(image, step).covered_share, 0.02) << i;
    largest_blind = std::max(largest_blind, blind.see_blindly(image).covered_share);
  }
  // Background that agrees with what is seen follows it, known motion or not.
  EXPECT_EQ(largest_blind, 0.0);

  // A pillar that stands still while the camera turns does not cover what it passes.
  Stream turning;
  const double turn_rad = 0.01;
  const double turn_share = std::tan(turn_rad) * 0.82;  // of the width, near its middle
  double largest = 0.0;
  for (int i = 0; i < 20; ++i) {
    const double left = 0.4 + turn_share * i;
    const CoveredResult result = turning.see(DepthImage(4.0F).paint(left, left + 0.1, 1.5F),
                                             flow_pose(0.0, 0.0, 0.0, 0.0, turn_rad, 0.0));
    largest = std::max(largest, result.covered_share);
  }
  EXPECT_LE(largest, 2.0 / kBackgroundCols);  // its edges
  // The same images from a camera that stands still show a pillar that moves.
  Stream still;
  double last = 0.0;
  for (int i = 0; i < 20; ++i) {
    const double left = 0.4 + turn_share * i;
    last = still.see(DepthImage(4.0F).paint(left, left + 0.1, 1.5F)).covered_share;
  }
  EXPECT_GT(last, 0.08);
}

TEST(BackgroundDepth, AMotionSeenWhileTheViewIsCoveredIsNotTheCameras) {
  Stream stream;
  stream.see(DepthImage(4.0F));
  EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 1.0);
  // Were this motion believed, the background would be out of sight at once.
  const Pose leap = flow_pose(3.0, 0.0, 0.0, 0.0, 1.0, 0.0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(stream.see(DepthImage(1.0F), leap).covered_share, 1.0);
  Stream open;
  open.see(DepthImage(4.0F));
  open.see(DepthImage(4.0F), leap);
  EXPECT_LT(open.see(DepthImage(1.0F), leap).num_compared, kBackgroundCells / 2);
}

TEST(BackgroundDepth, CellsWithoutDepthAreNotCompared) {
  Stream stream;
  stream.see(DepthImage(4.0F));
  for (const float none : {0.0F, -1.0F, 9.0F, std::numeric_limits<float>::quiet_NaN(),
                           std::numeric_limits<float>::infinity()}) {
    const CoveredResult result = stream.see(DepthImage(1.0F).paint(0.5, 1.0, none));
    EXPECT_EQ(result.num_compared, kBackgroundCells / 2) << none;
    EXPECT_EQ(result.covered_share, 1.0) << none;
  }
  // What was behind is remembered while nothing is seen there.
  EXPECT_EQ(stream.see(DepthImage(1.0F)).covered_share, 1.0);
  Stream nothing;
  for (int i = 0; i < 3; ++i) {
    const CoveredResult result = nothing.see(DepthImage(0.0F));
    EXPECT_TRUE(result.status.ok());
    EXPECT_EQ(result.covered_share, 0.0);
  }
}

TEST(BackgroundDepth, DependsOnNoResolutionAndNoSide) {
  test::for_each_seed(20, [](test::Rng& rng) {
    Stream large;
    Stream small;
    Stream mirrored;
    for (int frame = 0; frame < 6; ++frame) {
      DepthImage image(4.0F);
      DepthImage half(4.0F, 320);
      DepthImage mirror(4.0F);
      for (int stripe = 0; stripe < 3; ++stripe) {
        // Whole cells, so that no sample lies on an edge.
        const int first = rng.uniform_int(0, kBackgroundCols - 1);
        const int last = rng.uniform_int(first, kBackgroundCols);
        const auto depth_m = float(rng.uniform(0.5, 6.0));
        image.paint(first / 32.0, last / 32.0, depth_m);
        half.paint(first / 32.0, last / 32.0, depth_m);
        mirror.paint(1.0 - last / 32.0, 1.0 - first / 32.0, depth_m);
      }
      const CoveredResult result = large.see(image);
      for (Stream* other : {&small, &mirrored}) {
        const CoveredResult same = other->see(other == &small ? half : mirror);
        EXPECT_EQ(same.num_compared, result.num_compared);
        EXPECT_EQ(same.num_covered, result.num_covered);
      }
      EXPECT_GE(result.covered_share, 0.0);
      EXPECT_LE(result.covered_share, 1.0);
    }
  });
}

TEST(BackgroundDepth, RefusesWhatItCannotUse) {
  BackgroundDepth background(flow_camera());
  BackgroundDepth::State state;
  background.update(DepthImage(4.0F).view(), nullptr, &state);
  const float before_m = state.points[100].z_m;
  const Pose none = Pose::Identity();
  EXPECT_EQ(background.update({}, &none, &state).status.code, StatusCode::kInvalidArgument);
  EXPECT_EQ(state.points[100].z_m, before_m);
  // A motion that is no number is none.
  Pose broken = Pose::Identity();
  broken(0, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(background.update(DepthImage(4.0F).view(), &broken, &state).status.ok());
  EXPECT_EQ(state.points[100].z_m, before_m);
  const auto refused = [](const auto& change) {
    BackgroundDepthOptions options;
    change(&options);
    BackgroundDepth::State unused;
    return !options.validate().ok() && !BackgroundDepth(flow_camera(), options)
                                            .update(DepthImage(4.0F).view(), nullptr, &unused)
                                            .status.ok();
  };
  EXPECT_TRUE(refused([](auto* o) { o->nearer_ratio = 0.0; }));
  EXPECT_TRUE(refused([](auto* o) { o->nearer_ratio = 1.1; }));
  EXPECT_TRUE(refused([](auto* o) { o->nearer_margin_m = -0.1; }));
  EXPECT_TRUE(refused([](auto* o) { o->max_covered_frames = 0; }));
  EXPECT_TRUE(refused([](auto* o) { o->max_share_to_move = 1.5; }));
  EXPECT_TRUE(refused([](auto* o) { o->max_depth_m = 0.05; }));
  EXPECT_FALSE(BackgroundDepth(PinholeCamera{}).status().ok());
}

TEST(FrontDepth, OfAnEdgeIsTheNearerSurfaces) {
  const DepthImage image = DepthImage(4.0F).paint(0.0, 0.5, 2.0F);  // edge at u = 319.5
  EXPECT_EQ(front_depth_at(image.view(), 321.0F, 100.0F, 4.0F, 0.1F), 2.0F);
  EXPECT_EQ(front_depth_at(image.view(), 318.0F, 100.0F, 4.0F, 0.1F), 2.0F);
  EXPECT_EQ(front_depth_at(image.view(), 326.0F, 100.0F, 4.0F, 0.1F), 4.0F);
  EXPECT_EQ(front_depth_at(image.view(), 321.0F, 100.0F, 0.0F, 0.1F), 4.0F);
  EXPECT_EQ(front_depth_at(image.view(), 321.0F, 100.0F, 4.0F, 1.1F), 4.0F);  // no such step
  // Beyond the image and where depth is missing there is no surface.
  EXPECT_EQ(front_depth_at(image.view(), 0.0F, 0.0F, 4.0F, 0.1F), 2.0F);
  EXPECT_EQ(front_depth_at(DepthImage(0.0F).view(), 5.0F, 5.0F, 4.0F, 0.1F), 0.0F);
  const DepthImage holes = DepthImage(4.0F).paint(0.0, 0.5, 0.0F);
  EXPECT_EQ(front_depth_at(holes.view(), 321.0F, 100.0F, 4.0F, 0.1F), 4.0F);
}

}  // namespace
}  // namespace srslam
