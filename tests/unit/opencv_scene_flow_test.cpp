#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "srslam/interop/scene_flow.hpp"
#include "support/flow_scene.hpp"
#include "support/random_texture.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::flow_camera;

/// Blurred noise of 640×480 pixels that has moved by (du, dv) pixels.
cv::Mat texture(double du_px, double dv_px) {
  static const cv::Mat noise = [] {
    test::Rng rng(5);
    return test::random_texture(rng, 720, 560, 3.0);
  }();
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, du_px - 40, 0, 1, dv_px - 40);
  cv::Mat view;
  cv::warpAffine(noise, view, shift, {640, 480}, cv::INTER_LINEAR);
  return view;
}

cv::Mat halved(const cv::Mat& image) {
  cv::Mat half;
  cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_AREA);
  return half;
}

ImageView<const std::uint8_t> view_of(const cv::Mat& image) {
  return {image.ptr<std::uint8_t>(), image.cols, image.rows,
          static_cast<std::ptrdiff_t>(image.step[0])};
}

/// Report that asks for frame `id` as the reference.
SceneReport wants(std::uint64_t id) {
  SceneReport report;
  report.reference_changed = true;
  report.next_reference_id = id;
  return report;
}

TEST(SceneFlow, FollowsCornersInPixelsOfTheImageGiven) {
  for (const int max_width_px : {0, 160, 320, 640}) {
    SceneFlowOptions options;
    options.max_width_px = max_width_px;
    SceneFlow flow(flow_camera(), options);
    ASSERT_TRUE(flow.status().ok());
    EXPECT_EQ(flow.reduction_factor(), max_width_px == 0 ? 1 : 640 / max_width_px);
    const std::vector<float> depth_m(std::size_t{640} * 480, 2.5F);
    const ImageView<const float> depth(depth_m.data(), 640, 480);
    const std::vector<Detection> boxes = {{"person", 0.9, -0.5, -0.5, 319.5, 479.5}};
    ASSERT_TRUE(flow.push(1, view_of(texture(0, 0)), depth, boxes).ok());
    EXPECT_TRUE(flow.tracks().empty());
    ASSERT_TRUE(flow.follow(wants(1)).ok());
    ASSERT_TRUE(flow.push(2, view_of(texture(6, -4)), depth, boxes).ok());
    int num_alive = 0;
    int num_right = 0;
    for (const FlowTrack& track : flow.tracks()) {
      EXPECT_EQ(track.reference.depth_m, 2.5F);
      EXPECT_EQ(track.reference.suspect, track.reference.u_px <= 319.5F);
      EXPECT_GE(track.reference.u_px, 0.0F);
      EXPECT_LT(track.reference.u_px, 640.0F);
      if (!track.alive) continue;
      ++num_alive;
      EXPECT_EQ(track.current.suspect, track.current.u_px <= 319.5F);
      const double off_px = std::hypot(double(track.current.u_px - track.reference.u_px) - 6.0,
                                       double(track.current.v_px - track.reference.v_px) + 4.0);
      if (off_px < 0.3) ++num_right;
    }
    EXPECT_GT(num_alive, 100) << max_width_px;
    EXPECT_GT(num_right, 0.97 * num_alive) << max_width_px;
  }
}

TEST(SceneFlow, HalfTheImageGivesTheSameTracks) {
  SceneFlow full(flow_camera(640));
  SceneFlow half(flow_camera(320));
  EXPECT_EQ(full.reduction_factor(), 2);
  EXPECT_EQ(half.reduction_factor(), 1);
  for (int i = 1; i <= 4; ++i) {
    const cv::Mat image = texture(3.0 * i, i);
    const auto id = static_cast<std::uint64_t>(i);
    ASSERT_TRUE(full.push(id, view_of(image), {}, {}).ok());
    ASSERT_TRUE(half.push(id, view_of(halved(image)), {}, {}).ok());
    ASSERT_EQ(full.tracks().size, half.tracks().size);
    for (std::size_t k = 0; k < full.tracks().size; ++k) {
      EXPECT_EQ(full.tracks()[k].alive, half.tracks()[k].alive);
      EXPECT_EQ(full.tracks()[k].current.u_px, 2.0F * half.tracks()[k].current.u_px + 0.5F);
      EXPECT_EQ(full.tracks()[k].current.v_px, 2.0F * half.tracks()[k].current.v_px + 0.5F);
    }
    if (i == 1) {
      ASSERT_TRUE(full.follow(wants(1)).ok());
      ASSERT_TRUE(half.follow(wants(1)).ok());
    }
  }
  EXPECT_GT(full.tracks().size, 100U);
}

TEST(SceneFlow, SizesThatAreNoMultipleLoseTheirLastPixels) {
  PinholeCamera camera = flow_camera();
  camera.width_px = 637;
  camera.height_px = 479;
  SceneFlow flow(camera);
  EXPECT_EQ(flow.reduction_factor(), 2);
  for (int i = 1; i <= 2; ++i) {
    const cv::Mat image = texture(4.0 * i, 0)(cv::Rect(0, 0, 637, 479));
    ASSERT_TRUE(flow.push(static_cast<std::uint64_t>(i), view_of(image), {}, {}).ok());
    if (i == 1) {
      ASSERT_TRUE(flow.follow(wants(1)).ok());
    }
  }
  std::vector<double> steps_px;
  for (const FlowTrack& track : flow.tracks()) {
    if (track.alive) steps_px.push_back(double(track.current.u_px - track.reference.u_px));
  }
  ASSERT_GT(steps_px.size(), 100U);
  std::nth_element(steps_px.begin(), steps_px.begin() + 50, steps_px.end());
  EXPECT_NEAR(steps_px[50], 4.0, 0.2);
}

TEST(SceneFlow, TakesNoCornerWhereTheMaskIsZero) {
  SceneFlow flow(flow_camera());
  cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 400, 480)) = 0;
  ASSERT_TRUE(flow.push(1, view_of(texture(0, 0)), {}, {}, view_of(mask)).ok());
  ASSERT_TRUE(flow.follow(wants(1)).ok());
  ASSERT_TRUE(flow.push(2, view_of(texture(0, 0)), {}, {}, view_of(mask)).ok());
  EXPECT_GT(flow.tracks().size, 50U);
  for (const FlowTrack& track : flow.tracks()) EXPECT_GE(track.reference.u_px, 398.0F);
}

TEST(SceneFlow, CornersOfAnOutlineHaveTheDepthInFront) {
  std::vector<float> depth_m(std::size_t{640} * 480, 4.0F);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    if (i % 640 < 320) depth_m[i] = 1.0F;
  }
  for (const double reach_px : {0.0, 2.0}) {
    SceneFlowOptions options;
    options.edge_reach_px = reach_px;
    SceneFlow flow(flow_camera(), options);
    const ImageView<const float> depth(depth_m.data(), 640, 480);
    ASSERT_TRUE(flow.push(1, view_of(texture(0, 0)), depth, {}).ok());
    ASSERT_TRUE(flow.follow(wants(1)).ok());
    ASSERT_TRUE(flow.push(2, view_of(texture(0, 0)), depth, {}).ok());
    int num_near_edge = 0;
    for (const FlowTrack& track : flow.tracks()) {
      const float u_px = track.reference.u_px;
      if (u_px > 321.0F && u_px < 322.9F) {
        ++num_near_edge;
        EXPECT_EQ(track.reference.depth_m, reach_px > 0.0 ? 1.0F : 4.0F) << u_px;
      }
      if (u_px > 324.0F) {
        EXPECT_EQ(track.reference.depth_m, 4.0F) << u_px;
      } else if (u_px < 319.0F) {
        EXPECT_EQ(track.reference.depth_m, 1.0F) << u_px;
      }
    }
    EXPECT_GT(num_near_edge, 0);
  }
}

TEST(SceneFlow, RefusesWhatItCannotUse) {
  SceneFlow flow(flow_camera());
  const cv::Mat image = texture(0, 0);
  ASSERT_TRUE(flow.push(3, view_of(image), {}, {}).ok());
  EXPECT_EQ(flow.push(3, view_of(image), {}, {}).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(flow.push(4, view_of(halved(image)), {}, {}).code, StatusCode::kInvalidArgument);
  EXPECT_EQ(flow.push(4, {}, {}, {}).code, StatusCode::kInvalidArgument);
  const std::vector<float> depth_m(100, 1.0F);
  EXPECT_EQ(flow.push(4, view_of(image), {depth_m.data(), 10, 10}, {}).code,
            StatusCode::kInvalidArgument);
  EXPECT_EQ(flow.push(4, view_of(image), {}, {}, view_of(halved(image))).code,
            StatusCode::kInvalidArgument);
  EXPECT_EQ(flow.follow(wants(77)).code, StatusCode::kNotFound);
  EXPECT_TRUE(flow.follow(wants(3)).ok());
  EXPECT_TRUE(flow.push(4, view_of(image), {}, {}).ok());
  EXPECT_FALSE(flow.tracks().empty());

  SceneFlowOptions options;
  options.max_width_px = -1;
  EXPECT_EQ(SceneFlow(flow_camera(), options).push(1, view_of(image), {}, {}).code,
            StatusCode::kInvalidArgument);
  options = {};
  options.edge_reach_px = -1.0;
  EXPECT_FALSE(SceneFlow(flow_camera(), options).status().ok());
  options = {};
  options.corners.num_features = 0;
  EXPECT_FALSE(SceneFlow(flow_camera(), options).status().ok());
  options = {};
  options.lucas_kanade.window_px = 1;
  EXPECT_FALSE(SceneFlow(flow_camera(), options).status().ok());
  EXPECT_FALSE(SceneFlow(PinholeCamera{}).status().ok());
}

TEST(CornerPyramid, KeepsItsBorderAndItsNumbers) {
  FeatureOptions options;
  options.num_features = 400;
  options.num_levels = 3;
  for (const int border_px : {5, 19, 40}) {
    CornerPyramid corners(options, border_px);
    corners.detect(view_of(texture(0, 0)), {});
    std::size_t total = 0;
    for (const CornerPyramid::Level& level : corners.levels()) {
      EXPECT_LE(level.corners.size(), static_cast<std::size_t>(level.num_wanted));
      total += level.corners.size();
      for (const cv::KeyPoint& corner : level.corners) {
        EXPECT_GE(corner.pt.x, float(border_px));
        EXPECT_GE(corner.pt.y, float(border_px));
        EXPECT_LT(corner.pt.x, float(level.image.cols - border_px));
        EXPECT_LT(corner.pt.y, float(level.image.rows - border_px));
      }
    }
    EXPECT_EQ(total, 400U) << border_px;
  }
  // Levels that are too small for a corner are empty, and so are all of a tiny image.
  CornerPyramid corners(options, 19);
  corners.detect(view_of(texture(0, 0)(cv::Rect(0, 0, 30, 30))), {});
  for (const CornerPyramid::Level& level : corners.levels()) EXPECT_TRUE(level.corners.empty());
}

}  // namespace
}  // namespace srslam
