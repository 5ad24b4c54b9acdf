// The camera model against OpenCV's: the same parameters must mean the same camera.

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "srslam/core/camera.hpp"
#include "support/rng.hpp"
#include "support/test_cameras.hpp"

namespace srslam {
namespace {

using test::dataset_cameras;
using test::for_each_seed;
using test::NamedCamera;
using test::Rng;

cv::Matx33d camera_matrix(const PinholeCamera& c) {
  return {c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0};
}

std::vector<double> distortion_coefficients(const PinholeCamera& c) {
  return {c.k1, c.k2, c.p1, c.p2, c.k3};
}

TEST(CameraAgainstOpenCv, ProjectPointsAndItsJacobians) {
  for_each_seed(20, [](Rng& rng) {
    for (const NamedCamera& named : dataset_cameras()) {
      std::vector<cv::Point3d> points;
      for (int i = 0; i < 100; ++i) {
        const double z = rng.uniform(0.2, 8.0);
        points.emplace_back(z * rng.uniform(-0.7, 0.7), z * rng.uniform(-0.6, 0.6), z);
      }
      std::vector<cv::Point2d> expected;
      cv::Mat expected_jacobian;  // rows u, v; columns r (3), t (3), fx fy cx cy, k1 k2 p1 p2 k3
      const cv::Vec3d zero(0.0, 0.0, 0.0);
      cv::projectPoints(points, zero, zero, camera_matrix(named.camera),
                        distortion_coefficients(named.camera), expected, expected_jacobian);
      for (std::size_t i = 0; i < points.size(); ++i) {
        Eigen::Vector2d pixel;
        Eigen::Matrix<double, 2, 3> J_point;
        Eigen::Matrix<double, 2, 9> J_intrinsics;
        ASSERT_TRUE(named.camera.project({points[i].x, points[i].y, points[i].z}, &pixel, &J_point,
                                         &J_intrinsics))
            << named.name;
        EXPECT_NEAR(pixel.x(), expected[i].x, 1e-11) << named.name;
        EXPECT_NEAR(pixel.y(), expected[i].y, 1e-11) << named.name;
        for (int axis = 0; axis < 2; ++axis) {
          const int row = 2 * static_cast<int>(i) + axis;
          for (int j = 0; j < 3; ++j) {
            EXPECT_NEAR(J_point(axis, j), expected_jacobian.at<double>(row, 3 + j), 1e-9)
                << named.name;
          }
          for (int j = 0; j < 9; ++j) {
            EXPECT_NEAR(J_intrinsics(axis, j), expected_jacobian.at<double>(row, 6 + j), 1e-9)
                << named.name;
          }
        }
      }
    }
  });
}

TEST(CameraAgainstOpenCv, UndistortPoints) {
  // OpenCV iterates a fixed point, five times unless told otherwise; here until it stands still.
  const cv::TermCriteria until_it_stands(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 500,
                                         1e-15);
  for (const NamedCamera& named : dataset_cameras()) {
    std::vector<cv::Point2d> pixels;
    for (int v = 0; v < 480; v += 16) {
      for (int u = 0; u < 640; u += 16) pixels.emplace_back(u, v);
    }
    pixels.emplace_back(639.0, 479.0);
    std::vector<cv::Point2d> normalized;
    std::vector<cv::Point2d> same_intrinsics;
    const cv::Matx33d K = camera_matrix(named.camera);
    const std::vector<double> d = distortion_coefficients(named.camera);
    cv::undistortPoints(pixels, normalized, K, d, cv::noArray(), cv::noArray(), until_it_stands);
    cv::undistortPoints(pixels, same_intrinsics, K, d, cv::noArray(), K, until_it_stands);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Eigen::Vector2d pixel(pixels[i].x, pixels[i].y);
      Eigen::Vector3d point;
      Eigen::Vector2d undistorted;
      ASSERT_TRUE(named.camera.unproject(pixel, 1.0, &point)) << named.name;
      ASSERT_TRUE(named.camera.undistort_pixel(pixel, &undistorted)) << named.name;
      EXPECT_NEAR(point.x(), normalized[i].x, 1e-11) << named.name << pixel.transpose();
      EXPECT_NEAR(point.y(), normalized[i].y, 1e-11) << named.name << pixel.transpose();
      EXPECT_NEAR(undistorted.x(), same_intrinsics[i].x, 1e-8) << named.name << pixel.transpose();
      EXPECT_NEAR(undistorted.y(), same_intrinsics[i].y, 1e-8) << named.name << pixel.transpose();
    }
  }
}

TEST(CameraAgainstOpenCv, UndistortionMap) {
  for (const NamedCamera& named : dataset_cameras()) {
    const PinholeCamera& camera = named.camera;
    cv::Mat map_u;
    cv::Mat map_v;
    const cv::Matx33d K = camera_matrix(camera);
    cv::initUndistortRectifyMap(K, distortion_coefficients(camera), cv::noArray(), K,
                                cv::Size(camera.width_px, camera.height_px), CV_32FC1, map_u,
                                map_v);
    for (int v = 0; v < camera.height_px; v += 7) {
      for (int u = 0; u < camera.width_px; u += 7) {
        const Eigen::Vector2d distorted =
            camera.distort({(u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px});
        // The map is single precision.
        EXPECT_NEAR(camera.fx_px * distorted.x() + camera.cx_px, map_u.at<float>(v, u), 1e-4);
        EXPECT_NEAR(camera.fy_px * distorted.y() + camera.cy_px, map_v.at<float>(v, u), 1e-4);
      }
    }
  }
}

// scaled() belongs to images as cv::resize() makes them. In an image whose value is u, a pixel of
// the smaller image holds the coordinate that it stands for.
TEST(CameraAgainstOpenCv, ScaledMatchesResize) {
  cv::Mat ramp(48, 64, CV_32FC1);
  for (int v = 0; v < ramp.rows; ++v) {
    for (int u = 0; u < ramp.cols; ++u) ramp.at<float>(v, u) = static_cast<float>(u);
  }
  PinholeCamera camera;
  camera.width_px = ramp.cols;
  camera.height_px = ramp.rows;
  camera.fx_px = 50.0;
  camera.fy_px = 50.0;
  camera.cx_px = 30.0;
  camera.cy_px = 20.0;
  for (const double factor : {0.5, 0.25}) {
    const PinholeCamera small_camera = camera.scaled(factor);
    cv::Mat small;
    cv::resize(ramp, small, cv::Size(small_camera.width_px, small_camera.height_px), 0.0, 0.0,
               cv::INTER_AREA);
    for (int u = 0; u < small.cols; ++u) {
      // The ray of the small image's pixel, seen by the original camera.
      Eigen::Vector3d point;
      Eigen::Vector2d original;
      ASSERT_TRUE(small_camera.unproject({u, 5.0}, 1.0, &point));
      ASSERT_TRUE(camera.project(point, &original));
      EXPECT_NEAR(original.x(), small.at<float>(5, u), 1e-5);
    }
  }
}

}  // namespace
}  // namespace srslam
