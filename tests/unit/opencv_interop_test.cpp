#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srslam/interop/opencv.hpp"

namespace srslam {
namespace {

TEST(AsMat, SharesPixelsAndKeepsTheStride) {
  std::vector<std::uint16_t> pixels(std::size_t{5} * 8);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint16_t>(i);
  // Six of eight columns, four of five rows.
  const ImageView<std::uint16_t> view(pixels.data() + 8 + 1, 6, 4, 8 * sizeof(std::uint16_t));
  cv::Mat mat = as_mat(view);
  EXPECT_EQ(mat.type(), CV_16UC1);
  EXPECT_EQ(mat.cols, 6);
  EXPECT_EQ(mat.rows, 4);
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 6; ++u) EXPECT_EQ(mat.at<std::uint16_t>(v, u), 8 * (v + 1) + u + 1);
  }
  mat.at<std::uint16_t>(2, 3) = 999;
  EXPECT_EQ(view(3, 2), 999);
}

TEST(AsMat, EveryPixelTypeAndEmptyViews) {
  const float depth = 1.5F;
  EXPECT_EQ(as_mat(ImageView<const float>(&depth, 1, 1)).type(), CV_32FC1);
  EXPECT_EQ(as_mat(ImageView<const float>(&depth, 1, 1)).at<float>(0, 0), 1.5F);
  const std::uint8_t gray = 7;
  EXPECT_EQ(as_mat(ImageView<const std::uint8_t>(&gray, 1, 1)).type(), CV_8UC1);
  const Bgr8 color{1, 2, 3};
  const cv::Mat mat = as_mat(ImageView<const Bgr8>(&color, 1, 1));
  ASSERT_EQ(mat.type(), CV_8UC3);
  EXPECT_EQ(mat.at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
  EXPECT_TRUE(as_mat(ImageView<const float>()).empty());
}

TEST(AsView, ReadsSubMatricesInPlace) {
  cv::Mat mat(6, 9, CV_32FC1);
  for (int v = 0; v < mat.rows; ++v) {
    for (int u = 0; u < mat.cols; ++u) mat.at<float>(v, u) = static_cast<float>(100 * v + u);
  }
  const cv::Mat part = mat(cv::Rect(2, 1, 5, 3));
  const ImageView<const float> view = as_view<float>(part);
  ASSERT_TRUE(view.validate().ok());
  EXPECT_EQ(view.width_px, 5);
  EXPECT_EQ(view.height_px, 3);
  EXPECT_EQ(view(0, 0), 102.0F);
  EXPECT_EQ(view(4, 2), 306.0F);
  mat.at<float>(3, 6) = -1.0F;
  EXPECT_EQ(view(4, 2), -1.0F);
}

TEST(AsView, RefusesOtherElementTypes) {
  const cv::Mat gray(4, 4, CV_8UC1, cv::Scalar(0));
  EXPECT_TRUE(as_view<float>(gray).empty());
  EXPECT_TRUE(as_view<Bgr8>(gray).empty());
  EXPECT_TRUE(as_view<std::uint8_t>(cv::Mat()).empty());
  const std::vector<int> sizes = {2, 3, 4};
  EXPECT_TRUE(as_view<std::uint8_t>(cv::Mat(sizes, CV_8UC1)).empty());
  EXPECT_FALSE(as_view<std::uint8_t>(gray).empty());
}

TEST(Keypoints, GoThereAndBack) {
  const cv::KeyPoint keypoint(12.25F, 34.5F, 31.0F * 1.44F, 90.0F, 17.0F, 2, 5);
  const Feature feature = feature_from_keypoint(keypoint, 1.44F);
  EXPECT_EQ(feature.u_px, 12.25F);
  EXPECT_EQ(feature.v_px, 34.5F);
  EXPECT_EQ(feature.response, 17.0F);
  EXPECT_EQ(feature.octave, 2);
  EXPECT_EQ(feature.scale, 1.44F);
  EXPECT_NEAR(feature.angle_rad, 1.5707963F, 1e-6F);

  const cv::KeyPoint back = keypoint_from_feature(feature);
  EXPECT_EQ(back.pt, keypoint.pt);
  EXPECT_NEAR(back.angle, 90.0F, 1e-4F);
  EXPECT_NEAR(back.size, keypoint.size, 1e-4F);
  EXPECT_EQ(back.response, keypoint.response);
  EXPECT_EQ(back.octave, keypoint.octave);
  EXPECT_EQ(back.class_id, -1);
}

TEST(Keypoints, UnknownAngleBecomesZero) {
  const cv::KeyPoint keypoint(1.0F, 2.0F, 31.0F);  // OpenCV: angle -1
  EXPECT_EQ(feature_from_keypoint(keypoint, 1.0F).angle_rad, 0.0F);
}

}  // namespace
}  // namespace srslam
