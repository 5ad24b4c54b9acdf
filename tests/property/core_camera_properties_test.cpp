// What holds for every camera, point and pixel, on random ones with fixed seeds.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/core/camera.hpp"
#include "support/constants.hpp"
#include "support/numeric_jacobian.hpp"
#include "support/rng.hpp"
#include "support/test_cameras.hpp"

namespace srslam {
namespace {

using test::dataset_cameras;
using test::for_each_seed;
using test::kPi;
using test::matrices_near;
using test::NamedCamera;
using test::numeric_jacobian;
using test::Rng;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix29 = Eigen::Matrix<double, 2, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

/// Distortion far stronger than that of real lenses, often folding inside the image.
PinholeCamera random_camera(Rng& rng) {
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = rng.uniform(300.0, 700.0);
  camera.fy_px = rng.uniform(300.0, 700.0);
  camera.cx_px = rng.uniform(250.0, 390.0);
  camera.cy_px = rng.uniform(190.0, 290.0);
  camera.k1 = rng.uniform(-0.6, 0.6);
  camera.k2 = rng.uniform(-1.0, 1.0);
  camera.p1 = rng.uniform(-0.02, 0.02);
  camera.p2 = rng.uniform(-0.02, 0.02);
  camera.k3 = rng.uniform(-1.5, 1.5);
  return camera;
}

std::vector<NamedCamera> cameras(Rng& rng) {
  std::vector<NamedCamera> all = dataset_cameras();
  for (int i = 0; i < 20; ++i) all.push_back({"random " + std::to_string(i), random_camera(rng)});
  return all;
}

Eigen::Vector3d random_point(Rng& rng) {
  const double z = rng.uniform(0.1, 10.0);
  return {z * rng.uniform(-1.0, 1.0), z * rng.uniform(-1.0, 1.0), z};
}

Eigen::Matrix2d distortion_jacobian(const PinholeCamera& camera, const Eigen::Vector3d& point) {
  Eigen::Matrix2d J;
  camera.distort(point.head<2>() / point.z(), &J);
  return J;
}

TEST(CameraProperties, UnprojectInvertsProjectInTheWholeDomain) {
  int num_points = 0;
  for_each_seed(200, [&](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector3d point = random_point(rng);
      Eigen::Vector2d pixel;
      if (!named.camera.project(point, &pixel)) continue;
      ++num_points;
      Eigen::Vector3d back;
      ASSERT_TRUE(named.camera.unproject(pixel, point.z(), &back))
          << named.name << ": " << point.transpose();
      // Near the fold the inverse is ill-conditioned: a rounding of the pixel moves the point by
      // the inverse of the determinant.
      const double determinant = distortion_jacobian(named.camera, point).determinant();
      EXPECT_LT((back - point).norm() / point.z() * determinant, 1e-11)
          << named.name << ": " << point.transpose() << " back: " << back.transpose();
      EXPECT_EQ(back.z(), point.z());
    }
  });
  EXPECT_GT(num_points, 200 * 10) << "the test must not be empty";
}

TEST(CameraProperties, ProjectInvertsUnproject) {
  int num_pixels = 0;
  for_each_seed(200, [&](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector2d pixel(rng.uniform(-0.5, 639.5), rng.uniform(-0.5, 479.5));
      const double depth = rng.uniform(0.1, 10.0);
      Eigen::Vector3d point;
      if (!named.camera.unproject(pixel, depth, &point)) continue;
      ++num_pixels;
      Eigen::Vector2d back;
      ASSERT_TRUE(named.camera.project(point, &back)) << named.name << ": " << pixel.transpose();
      EXPECT_LT((back - pixel).norm(), 2e-10) << named.name << ": " << pixel.transpose();
    }
  });
  EXPECT_GT(num_pixels, 200 * 10) << "the test must not be empty";
}

// Whatever is nearer to the centre than a visible point is visible, and lands nearer to the centre.
TEST(CameraProperties, DomainIsStarShapedAndMonotone) {
  for_each_seed(200, [](Rng& rng) {
    const PinholeCamera camera = random_camera(rng);
    const double azimuth = rng.uniform(0.0, 2.0 * kPi);
    const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
    bool inside = true;
    double previous = 0.0;
    for (int step = 1; step < 300; ++step) {
      const double radius = 0.01 * step;
      const Eigen::Vector2d normalized = radius * direction;
      const bool visible = camera.project({normalized.x(), normalized.y(), 1.0}, nullptr);
      EXPECT_TRUE(inside || !visible) << radius;
      inside = visible;
      if (!visible) continue;
      const double along = direction.dot(camera.distort(normalized));
      EXPECT_GT(along, previous) << radius;
      previous = along;
    }
  });
}

TEST(CameraProperties, JacobianByThePointMatchesDifferences) {
  int num_points = 0;
  for_each_seed(100, [&](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector3d point = random_point(rng);
      Matrix23 J;
      if (!named.camera.project(point, nullptr, &J)) continue;
      ++num_points;
      // distort() in place of project(), which may refuse a neighbour.
      const auto pixel_of = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
        const Eigen::Vector2d distorted = named.camera.distort(p.head<2>() / p.z());
        return {named.camera.fx_px * distorted.x() + named.camera.cx_px,
                named.camera.fy_px * distorted.y() + named.camera.cy_px};
      };
      const Matrix23 numeric = numeric_jacobian(pixel_of, point, 1e-3 * point.z());
      EXPECT_TRUE(matrices_near(J, numeric, 1e-8)) << named.name << ": " << point.transpose();
    }
  });
  EXPECT_GT(num_points, 100 * 10);
}

TEST(CameraProperties, JacobianByTheIntrinsicsMatchesDifferences) {
  int num_points = 0;
  for_each_seed(100, [&](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector3d point = random_point(rng);
      Matrix29 J;
      if (!named.camera.project(point, nullptr, nullptr, &J)) continue;
      ++num_points;
      const PinholeCamera& c = named.camera;
      Vector9 parameters;
      parameters << c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1, c.k2, c.p1, c.p2, c.k3;
      const auto pixel_of = [&](const Vector9& p) -> Eigen::Vector2d {
        const PinholeCamera moved = {c.width_px, c.height_px, p[0], p[1], p[2], p[3],
                                     p[4],       p[5],        p[6], p[7], p[8]};
        const Eigen::Vector2d distorted = moved.distort(point.head<2>() / point.z());
        return {moved.fx_px * distorted.x() + moved.cx_px,
                moved.fy_px * distorted.y() + moved.cy_px};
      };
      const Matrix29 numeric = numeric_jacobian(pixel_of, parameters, 1e-2);
      EXPECT_TRUE(matrices_near(J, numeric, 1e-10)) << named.name << ": " << point.transpose();
    }
  });
  EXPECT_GT(num_points, 100 * 10);
}

TEST(CameraProperties, JacobianOfTheDistortionMatchesDifferences) {
  for_each_seed(300, [](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector2d normalized(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
      Eigen::Matrix2d J;
      named.camera.distort(normalized, &J);
      const Eigen::Matrix2d numeric = numeric_jacobian(
          [&](const Eigen::Vector2d& at) { return named.camera.distort(at); }, normalized, 1e-3);
      EXPECT_TRUE(matrices_near(J, numeric, 1e-9)) << named.name;
    }
  });
}

// unproject() followed by project() is the identity of the pixel, whatever the depth: by the chain
// rule the product of the Jacobians is [I 0]. unproject()'s depth column is checked by differences.
TEST(CameraProperties, JacobianOfUnprojectIsTheInverse) {
  int num_pixels = 0;
  for_each_seed(100, [&](Rng& rng) {
    for (const NamedCamera& named : cameras(rng)) {
      const Eigen::Vector2d pixel(rng.uniform(-0.5, 639.5), rng.uniform(-0.5, 479.5));
      const double depth = rng.uniform(0.1, 10.0);
      Eigen::Vector3d point;
      Eigen::Matrix3d J_unproject;
      if (!named.camera.unproject(pixel, depth, &point, &J_unproject)) continue;
      ++num_pixels;
      Matrix23 J_project;
      ASSERT_TRUE(named.camera.project(point, nullptr, &J_project));
      EXPECT_TRUE(matrices_near(J_project * J_unproject, Matrix23::Identity(), 1e-12));
      EXPECT_EQ(J_unproject.row(2), Eigen::RowVector3d(0.0, 0.0, 1.0));
      Eigen::Vector3d further;
      ASSERT_TRUE(named.camera.unproject(pixel, depth + 1.0, &further));
      EXPECT_TRUE(matrices_near(J_unproject.col(2), further - point, 1e-13));
    }
  });
  EXPECT_GT(num_pixels, 100 * 10);
}

TEST(CameraProperties, JacobiansDoNotChangeTheAnswer) {
  for_each_seed(200, [](Rng& rng) {
    const PinholeCamera camera = random_camera(rng);
    const Eigen::Vector3d point = random_point(rng);
    Eigen::Vector2d plain = Eigen::Vector2d::Zero();
    Eigen::Vector2d with = Eigen::Vector2d::Zero();
    Matrix23 J_point;
    Matrix29 J_intrinsics;
    EXPECT_EQ(camera.project(point, &plain), camera.project(point, &with, &J_point, &J_intrinsics));
    EXPECT_EQ(plain, with);
  });
}

TEST(CameraProperties, ScalingCommutesWithProjection) {
  for_each_seed(200, [](Rng& rng) {
    const PinholeCamera camera = random_camera(rng);
    const Eigen::Vector3d point = random_point(rng);
    const double factor = rng.uniform(0.05, 3.0);
    Eigen::Vector2d original;
    Eigen::Vector2d scaled;
    ASSERT_EQ(camera.project(point, &original), camera.scaled(factor).project(point, &scaled));
    if (!camera.project(point, &original)) return;
    const Eigen::Vector2d expected =
        factor * (original + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
    EXPECT_TRUE(matrices_near(scaled, expected, 1e-13));
  });
}

/// Any double at all, from its bits: subnormal, huge, infinite, NaN.
double any_double(Rng& rng) {
  if (rng.coin()) return rng.uniform(-2.0, 2.0);
  const std::uint64_t bits = rng.next();
  double value = 0.0;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

TEST(CameraProperties, NoInputGivesANan) {
  for_each_seed(20000, [](Rng& rng) {
    PinholeCamera camera = random_camera(rng);
    if (rng.uniform(0.0, 1.0) < 0.3) {
      for (double PinholeCamera::*member :
           {&PinholeCamera::fx_px, &PinholeCamera::cy_px, &PinholeCamera::k1, &PinholeCamera::k2,
            &PinholeCamera::p1, &PinholeCamera::p2, &PinholeCamera::k3}) {
        if (rng.coin()) camera.*member = any_double(rng);
      }
    }
    const Eigen::Vector3d point(any_double(rng), any_double(rng), any_double(rng));
    Eigen::Vector2d pixel;
    Matrix23 J_point;
    Matrix29 J_intrinsics;
    if (camera.project(point, &pixel, &J_point, &J_intrinsics)) {
      EXPECT_TRUE(pixel.allFinite());
      EXPECT_TRUE(J_point.allFinite());
      EXPECT_TRUE(J_intrinsics.allFinite());
    }
    const Eigen::Vector2d any_pixel(any_double(rng), any_double(rng));
    Eigen::Vector3d unprojected;
    Eigen::Matrix3d J;
    if (camera.unproject(any_pixel, any_double(rng), &unprojected, &J)) {
      EXPECT_TRUE(unprojected.allFinite());
      EXPECT_TRUE(J.allFinite());
    }
    Eigen::Vector2d normalized;
    if (camera.undistort(any_pixel, &normalized)) {
      EXPECT_TRUE(normalized.allFinite());
    }
    if (camera.undistort_pixel(any_pixel, &pixel)) {
      EXPECT_TRUE(pixel.allFinite());
    }
    camera.in_image(any_pixel, any_double(rng));
    const PinholeCamera scaled = camera.scaled(any_double(rng));
    EXPECT_TRUE(scaled.width_px >= 0 && scaled.height_px >= 0);
  });
}

}  // namespace
}  // namespace srslam
