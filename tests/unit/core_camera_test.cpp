#include "srslam/core/camera.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "support/constants.hpp"
#include "support/test_cameras.hpp"

namespace srslam {
namespace {

using test::dataset_cameras;
using test::kInf;
using test::kNan;
using test::NamedCamera;

PinholeCamera ideal_camera() {
  PinholeCamera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = 500.0;
  camera.fy_px = 400.0;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  return camera;
}

TEST(PinholeCameraValidate, DefaultIsRefused) {
  const Status status = PinholeCamera{}.validate();
  EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
}

TEST(PinholeCameraValidate, DatasetCamerasAreValid) {
  for (const NamedCamera& named : dataset_cameras()) {
    EXPECT_TRUE(named.camera.validate().ok()) << named.name << named.camera.validate().reason;
  }
  EXPECT_FALSE(dataset_cameras()[2].camera.has_distortion());
  EXPECT_TRUE(dataset_cameras()[0].camera.has_distortion());
}

TEST(PinholeCameraValidate, EveryMemberIsChecked) {
  for (double PinholeCamera::*member :
       {&PinholeCamera::fx_px, &PinholeCamera::fy_px, &PinholeCamera::cx_px, &PinholeCamera::cy_px,
        &PinholeCamera::k1, &PinholeCamera::k2, &PinholeCamera::p1, &PinholeCamera::p2,
        &PinholeCamera::k3}) {
    for (const double bad : {kNan, kInf, -kInf}) {
      PinholeCamera camera = ideal_camera();
      camera.*member = bad;
      EXPECT_EQ(camera.validate().code, StatusCode::kInvalidArgument) << bad;
    }
  }
  for (double PinholeCamera::*member : {&PinholeCamera::fx_px, &PinholeCamera::fy_px}) {
    for (const double bad : {0.0, -500.0}) {
      PinholeCamera camera = ideal_camera();
      camera.*member = bad;
      EXPECT_FALSE(camera.validate().ok()) << bad;
    }
  }
  for (int PinholeCamera::*member : {&PinholeCamera::width_px, &PinholeCamera::height_px}) {
    for (const int bad : {0, -640}) {
      PinholeCamera camera = ideal_camera();
      camera.*member = bad;
      EXPECT_FALSE(camera.validate().ok()) << bad;
    }
  }
  PinholeCamera crop = ideal_camera();
  crop.cx_px = -1000.0;
  EXPECT_TRUE(crop.validate().ok()) << "the principal point may lie outside a crop";
}

TEST(PinholeCameraValidate, EachDistortionCoefficientCounts) {
  for (double PinholeCamera::*member : {&PinholeCamera::k1, &PinholeCamera::k2, &PinholeCamera::p1,
                                        &PinholeCamera::p2, &PinholeCamera::k3}) {
    PinholeCamera camera = ideal_camera();
    EXPECT_FALSE(camera.has_distortion());
    camera.*member = 1e-12;
    EXPECT_TRUE(camera.has_distortion());
  }
}

TEST(PinholeCameraProject, HandComputedWithoutDistortion) {
  Eigen::Vector2d pixel;
  // Right of and below the axis: u and v above the principal point.
  ASSERT_TRUE(ideal_camera().project({0.2, 0.1, 2.0}, &pixel));
  EXPECT_DOUBLE_EQ(pixel.x(), 319.5 + 50.0);
  EXPECT_DOUBLE_EQ(pixel.y(), 239.5 + 20.0);
  ASSERT_TRUE(ideal_camera().project({0.0, 0.0, 7.0}, &pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(319.5, 239.5));
}

TEST(PinholeCameraDistort, HandComputed) {
  PinholeCamera camera = ideal_camera();
  camera.k1 = 0.1;
  camera.k2 = 0.01;
  camera.p1 = 0.001;
  camera.p2 = 0.002;
  camera.k3 = 0.001;
  // s = 1.25, radial = 1 + 0.125 + 0.015625 + 0.001953125 = 1.142578125.
  const Eigen::Vector2d distorted = camera.distort({1.0, 0.5});
  EXPECT_NEAR(distorted.x(), 1.142578125 + 0.001 + 0.0065, 1e-15);
  EXPECT_NEAR(distorted.y(), 0.5712890625 + 0.00175 + 0.002, 1e-15);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.project({3.0, 1.5, 3.0}, &pixel));
  EXPECT_NEAR(pixel.x(), 500.0 * 1.150078125 + 319.5, 1e-12);
  EXPECT_NEAR(pixel.y(), 400.0 * 0.5750390625 + 239.5, 1e-12);
}

TEST(PinholeCameraProject, RefusesPointsThatTheCameraCannotSee) {
  for (const NamedCamera& named : dataset_cameras()) {
    const Eigen::Vector2d before(-7.0, -8.0);
    const Eigen::Matrix<double, 2, 3> J_before = Eigen::Matrix<double, 2, 3>::Constant(-9.0);
    const Eigen::Matrix<double, 2, 9> K_before = Eigen::Matrix<double, 2, 9>::Constant(-9.0);
    for (const Eigen::Vector3d& point : std::vector<Eigen::Vector3d>{
             {0.1, 0.1, 0.0},
             {0.1, 0.1, -0.0},
             {0.1, 0.1, -1.0},
             {kNan, 0.1, 1.0},
             {0.1, kNan, 1.0},
             {0.1, 0.1, kNan},
             {kInf, 0.1, 1.0},
             {0.1, -kInf, 1.0},
             {0.1, 0.1, kInf},
             {1e300, 1e300, 1e-300},
             {0.0, 0.0, std::numeric_limits<double>::denorm_min()},
         }) {
      Eigen::Vector2d pixel = before;
      Eigen::Matrix<double, 2, 3> J_point = J_before;
      Eigen::Matrix<double, 2, 9> J_intrinsics = K_before;
      EXPECT_FALSE(named.camera.project(point, &pixel, &J_point, &J_intrinsics))
          << named.name << ": " << point.transpose();
      EXPECT_EQ(pixel, before);
      EXPECT_EQ(J_point, J_before);
      EXPECT_EQ(J_intrinsics, K_before);
    }
  }
}

TEST(PinholeCameraProject, RefusesJacobiansThatAreNotRepresentable) {
  const PinholeCamera camera = ideal_camera();
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J_point;
  Eigen::Matrix<double, 2, 9> J_intrinsics;
  // The pixel is the principal point, but it would move by fx / z per metre.
  const Eigen::Vector3d nearest(0.0, 0.0, 1e-307);
  EXPECT_TRUE(camera.project(nearest, &pixel));
  EXPECT_FALSE(camera.project(nearest, &pixel, &J_point));
  // The pixel is linear in x, but it would move by fx x⁷ per unit of k3.
  const Eigen::Vector3d sideways(1e60, 0.0, 1.0);
  EXPECT_TRUE(camera.project(sideways, &pixel, &J_point));
  EXPECT_FALSE(camera.project(sideways, &pixel, &J_point, &J_intrinsics));
}

TEST(PinholeCameraProject, OutputsMayBeNull) {
  for (const NamedCamera& named : dataset_cameras()) {
    EXPECT_TRUE(named.camera.project({0.1, 0.1, 1.0}, nullptr));
    EXPECT_TRUE(named.camera.unproject({100.0, 100.0}, 1.0, nullptr));
    EXPECT_TRUE(named.camera.undistort({0.1, 0.1}, nullptr));
    EXPECT_TRUE(named.camera.undistort_pixel({100.0, 100.0}, nullptr));
  }
}

// Barrel distortion r (1 - r² / 2) turns back at r² = 2/3.
TEST(PinholeCameraDomain, BarrelTurnsBack) {
  PinholeCamera camera = ideal_camera();
  camera.k1 = -0.5;
  const double fold = std::sqrt(2.0 / 3.0);
  for (const double azimuth : {0.0, 0.7, 1.6, 2.9, 4.0, 5.5}) {
    const Eigen::Vector3d ray(std::cos(azimuth), std::sin(azimuth), 0.0);
    Eigen::Vector2d pixel;
    EXPECT_TRUE(camera.project((fold - 1e-6) * ray + Eigen::Vector3d::UnitZ(), &pixel));
    EXPECT_FALSE(camera.project((fold + 1e-6) * ray + Eigen::Vector3d::UnitZ(), &pixel));
    // Further out the polynomial comes back into the image.
    const Eigen::Vector3d outside = 1.2 * ray + Eigen::Vector3d::UnitZ();
    const Eigen::Vector2d distorted = camera.distort(outside.head<2>());
    ASSERT_LT(distorted.norm(), 0.34);
    EXPECT_FALSE(camera.project(outside, &pixel));
  }
  // No ray is distorted to more than fold * (1 - 1/3).
  Eigen::Vector2d normalized;
  EXPECT_TRUE(camera.undistort({0.0, 2.0 / 3.0 * fold - 1e-9}, &normalized));
  EXPECT_NEAR(normalized.y(), fold, 1e-4);
  EXPECT_FALSE(camera.undistort({0.0, 2.0 / 3.0 * fold + 1e-9}, &normalized));
  EXPECT_FALSE(camera.undistort({30.0, 40.0}, &normalized));
  EXPECT_FALSE(camera.unproject({camera.cx_px + 0.6 * camera.fx_px, camera.cy_px}, 1.0, nullptr));
}

// The radius grows, shrinks between r² = 1/2 and 1, and grows again: the growth at the point itself
// is not enough.
TEST(PinholeCameraDomain, RingThatTurnsBackHidesWhatIsBeyond) {
  PinholeCamera camera = ideal_camera();
  camera.k1 = -1.0;
  camera.k2 = 0.4;  // 1 + 3 k1 s + 5 k2 s² = (1 - s) (1 - 2 s)
  EXPECT_TRUE(camera.project({std::sqrt(0.49), 0.0, 1.0}, nullptr));
  EXPECT_FALSE(camera.project({std::sqrt(0.51), 0.0, 1.0}, nullptr));
  EXPECT_FALSE(camera.project({std::sqrt(0.99), 0.0, 1.0}, nullptr));
  EXPECT_FALSE(camera.project({std::sqrt(1.5), 0.0, 1.0}, nullptr));
}

// The same with the cubic's minimum only just above and below zero.
TEST(PinholeCameraDomain, CubicMinimumDecides) {
  for (const double sign : {-1.0, 1.0}) {
    PinholeCamera camera = ideal_camera();
    // g(s) = 1 + 7 k3 s³ + 5 k2 s² with its minimum at s = 1, where g = 1 + 5 k2 / 3.
    camera.k2 = -0.6 * (1.0 + sign * 1e-6);
    camera.k3 = -10.0 * camera.k2 / 21.0;
    EXPECT_TRUE(camera.project({0.99, 0.0, 1.0}, nullptr));
    EXPECT_EQ(camera.project({1.1, 0.0, 1.0}, nullptr), sign < 0.0);
    EXPECT_EQ(camera.project({5.0, 0.0, 1.0}, nullptr), sign < 0.0);
  }
}

TEST(PinholeCameraDomain, TangentialDistortionAloneFoldsOnOneSide) {
  PinholeCamera camera = ideal_camera();
  camera.p1 = 0.1;
  // Along y: y + 3 p1 y², slope 1 + 6 p1 y, which vanishes at y = -1/0.6.
  EXPECT_TRUE(camera.project({0.0, -1.66, 1.0}, nullptr));
  EXPECT_FALSE(camera.project({0.0, -1.67, 1.0}, nullptr));
  EXPECT_TRUE(camera.project({0.0, 1.67, 1.0}, nullptr));
  // Beyond y = -5 both directions are reversed and the determinant is positive again.
  Eigen::Matrix2d J;
  camera.distort({0.0, -6.0}, &J);
  ASSERT_GT(J.determinant(), 0.0);
  EXPECT_FALSE(camera.project({0.0, -6.0, 1.0}, nullptr));
}

// The polynomials of TUM fr1 and fr2 have large coefficients of alternating signs, but grow
// everywhere: their slope 1 + 3 k1 s + 5 k2 s² + 7 k3 s³ never falls below 1. BONN's folds at a
// radius of 1.24, which is 150 pixels outside the nearest corner of its image.
TEST(PinholeCameraDomain, DatasetCamerasCoverTheirImagesAndSurroundings) {
  for (const NamedCamera& named : dataset_cameras()) {
    const PinholeCamera& camera = named.camera;
    for (int v = -60; v < camera.height_px + 60; v += 4) {
      for (int u = -80; u < camera.width_px + 80; u += 4) {
        const Eigen::Vector2d pixel(u, v);
        Eigen::Vector3d point;
        ASSERT_TRUE(camera.unproject(pixel, 1.5, &point)) << named.name << pixel.transpose();
        ASSERT_EQ(point.z(), 1.5);
        Eigen::Vector2d back;
        ASSERT_TRUE(camera.project(point, &back)) << named.name << pixel.transpose();
        ASSERT_LT((back - pixel).norm(), 1e-10) << named.name << pixel.transpose();
      }
    }
  }
}

TEST(PinholeCameraDomain, BonnFoldsOutsideItsImage) {
  const PinholeCamera camera = dataset_cameras()[3].camera;
  EXPECT_TRUE(camera.project({1.2, 0.0, 1.0}, nullptr));
  EXPECT_FALSE(camera.project({1.3, 0.0, 1.0}, nullptr));
  EXPECT_FALSE(camera.unproject({-160.0, -120.0}, 1.0, nullptr)) << "no ray reaches this far";
  // Without a check this point would be drawn inside the image.
  const Eigen::Vector2d distorted = camera.distort({1.9, 0.0});
  ASSERT_TRUE(camera.in_image({camera.fx_px * distorted.x() + camera.cx_px, 240.0}));
  EXPECT_FALSE(camera.project({1.9, 0.0, 1.0}, nullptr));
}

TEST(PinholeCameraDomain, CornersOfTheImage) {
  for (const NamedCamera& named : dataset_cameras()) {
    for (const double u : {-0.5, 0.0, 639.0, 639.5}) {
      for (const double v : {-0.5, 0.0, 479.0, 479.5}) {
        Eigen::Vector3d point;
        Eigen::Vector2d back;
        ASSERT_TRUE(named.camera.unproject({u, v}, 4.0, &point)) << named.name;
        ASSERT_TRUE(named.camera.project(point, &back)) << named.name;
        EXPECT_LT((back - Eigen::Vector2d(u, v)).norm(), 1e-11) << named.name;
      }
    }
  }
}

// A point that the camera cannot see must not land in the image: rays at up to 89.99° to the axis.
TEST(PinholeCameraDomain, NothingFromOutsideTheFieldOfViewLandsInTheImage) {
  for (const NamedCamera& named : dataset_cameras()) {
    const PinholeCamera& camera = named.camera;
    for (int step = 0; step < 178; ++step) {
      const double radius = std::pow(1.05, step);  // 1 to 5600; the image's corners are below 0.8
      for (int i = 0; i < 64; ++i) {
        const double azimuth = i * 3.14159265358979 / 32.0;
        Eigen::Vector2d pixel;
        if (camera.project({radius * std::cos(azimuth), radius * std::sin(azimuth), 1.0}, &pixel)) {
          EXPECT_FALSE(camera.in_image(pixel)) << named.name << " radius " << radius;
        }
      }
    }
  }
}

TEST(PinholeCameraUnproject, RefusesWhatHasNoPoint) {
  for (const NamedCamera& named : dataset_cameras()) {
    const Eigen::Vector3d before(-1.0, -2.0, -3.0);
    const Eigen::Matrix3d J_before = Eigen::Matrix3d::Constant(-4.0);
    Eigen::Vector3d point = before;
    Eigen::Matrix3d J = J_before;
    for (const double depth : {0.0, -0.0, -1.0, kNan, kInf, -kInf}) {
      EXPECT_FALSE(named.camera.unproject({320.0, 240.0}, depth, &point, &J)) << depth;
    }
    for (const double bad : {kNan, kInf, -kInf}) {
      EXPECT_FALSE(named.camera.unproject({bad, 240.0}, 1.0, &point, &J)) << bad;
      EXPECT_FALSE(named.camera.unproject({320.0, bad}, 1.0, &point, &J)) << bad;
      Eigen::Vector2d pixel(5.0, 6.0);
      EXPECT_FALSE(named.camera.undistort({bad, 0.0}, &pixel));
      EXPECT_FALSE(named.camera.undistort({0.0, bad}, &pixel));
      EXPECT_FALSE(named.camera.undistort_pixel({bad, 0.0}, &pixel));
      EXPECT_EQ(pixel, Eigen::Vector2d(5.0, 6.0));
    }
    EXPECT_EQ(point, before);
    EXPECT_EQ(J, J_before);
  }
}

TEST(PinholeCameraUndistortPixel, IsTheDistortionFreePixelOfTheSameRay) {
  for (const NamedCamera& named : dataset_cameras()) {
    PinholeCamera ideal = named.camera;
    ideal.k1 = ideal.k2 = ideal.p1 = ideal.p2 = ideal.k3 = 0.0;
    const Eigen::Vector3d point(0.4, -0.3, 1.0);
    Eigen::Vector2d seen;
    Eigen::Vector2d expected;
    Eigen::Vector2d undistorted;
    ASSERT_TRUE(named.camera.project(point, &seen));
    ASSERT_TRUE(ideal.project(point, &expected));
    ASSERT_TRUE(named.camera.undistort_pixel(seen, &undistorted));
    EXPECT_LT((undistorted - expected).norm(), 1e-11) << named.name;
  }
}

TEST(PinholeCameraScaled, MapsPixelAreasNotPixelCentres) {
  const PinholeCamera camera = dataset_cameras()[0].camera;
  const PinholeCamera half = camera.scaled(0.5);
  EXPECT_TRUE(half.validate().ok());
  EXPECT_EQ(half.width_px, 320);
  EXPECT_EQ(half.height_px, 240);
  EXPECT_EQ(half.k1, camera.k1);
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  for (const double factor : {0.5, 0.25, 1.0 / 3.0, 1.0, 2.0}) {
    Eigen::Vector2d original;
    Eigen::Vector2d scaled;
    ASSERT_TRUE(camera.project(point, &original));
    ASSERT_TRUE(camera.scaled(factor).project(point, &scaled));
    // The image's upper left corner, (-0.5, -0.5), stays where it is.
    const Eigen::Vector2d corner(-0.5, -0.5);
    EXPECT_LT((scaled - corner - factor * (original - corner)).norm(), 1e-12) << factor;
  }
  // Halving twice is quartering.
  const PinholeCamera quarter = half.scaled(0.5);
  EXPECT_DOUBLE_EQ(quarter.cx_px, camera.scaled(0.25).cx_px);
  EXPECT_EQ(quarter.width_px, 160);
}

TEST(PinholeCameraScaled, SizesAreRoundedDown) {
  PinholeCamera camera = ideal_camera();
  camera.width_px = 641;
  camera.height_px = 3;
  EXPECT_EQ(camera.scaled(0.5).width_px, 320);
  EXPECT_EQ(camera.scaled(1.0 / 3.0).height_px, 1);
  EXPECT_EQ(camera.scaled(1.0).width_px, 641);
}

TEST(PinholeCameraScaled, ImpossibleFactorsGiveAnInvalidCamera) {
  for (const double factor : {0.0, -1.0, 1e-9, 1e12, kNan, kInf, -kInf}) {
    EXPECT_FALSE(ideal_camera().scaled(factor).validate().ok()) << factor;
  }
}

TEST(PinholeCameraInImage, EdgesAreHalfAPixelOutsideTheOutermostCentres) {
  const PinholeCamera camera = ideal_camera();
  EXPECT_TRUE(camera.in_image({-0.5, -0.5}));
  EXPECT_TRUE(camera.in_image({0.0, 0.0}));
  EXPECT_TRUE(camera.in_image({639.0, 479.0}));
  EXPECT_TRUE(camera.in_image({639.499, 479.499}));
  EXPECT_FALSE(camera.in_image({639.5, 100.0}));
  EXPECT_FALSE(camera.in_image({100.0, 479.5}));
  EXPECT_FALSE(camera.in_image({-0.501, 100.0}));
  EXPECT_FALSE(camera.in_image({100.0, -0.501}));
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(camera.in_image({bad, 100.0}));
    EXPECT_FALSE(camera.in_image({100.0, bad}));
  }
}

TEST(PinholeCameraInImage, BorderOfHalfAPixelIsWhatBilinearInterpolationNeeds) {
  const PinholeCamera camera = ideal_camera();
  EXPECT_TRUE(camera.in_image({0.0, 0.0}, 0.5));
  EXPECT_FALSE(camera.in_image({-0.001, 0.0}, 0.5));
  EXPECT_TRUE(camera.in_image({638.999, 478.999}, 0.5));
  EXPECT_FALSE(camera.in_image({639.0, 100.0}, 0.5));
  EXPECT_FALSE(camera.in_image({320.0, 240.0}, 240.5)) << "nothing is that far from the edges";
}

}  // namespace
}  // namespace srslam
