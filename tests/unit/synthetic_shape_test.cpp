#include "synthetic/shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "synthetic/random.hpp"

namespace srslam::detail {
namespace {

/// Positive outside, negative inside, zero on the surface; unit frame.
double implicit(const Shape& shape, const Eigen::Vector3d& p) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return p.cwiseAbs().maxCoeff() - 1.0;
    case ShapeKind::kSphere:
      return p.norm() - 1.0;
    case ShapeKind::kCylinder:
      return std::max(p.head<2>().norm() - 1.0, std::abs(p.z()) - 1.0);
    case ShapeKind::kRoundCone: {
      // The hull is the union of all spheres between the two, tried one by one.
      double best = 1e9;
      for (int i = 0; i <= 4000; ++i) {
        const double share = i / 4000.0;
        const double radius = (1.0 - share) * shape.radius_start + share * shape.radius_end;
        best =
            std::min(best, (p - Eigen::Vector3d(0.0, 0.0, share * shape.length)).norm() - radius);
      }
      return best;
    }
  }
  return 1e9;
}

std::vector<Shape> some_shapes() {
  return {box_shape({0.4, 1.0, 0.2}),
          ellipsoid_shape({0.3, 0.5, 0.9}),
          cylinder_shape(0.4, 1.2),
          round_cone_shape(0.5, 0.2, 1.1),
          round_cone_shape(0.2, 0.5, 0.7, 0.6),
          round_cone_shape(0.3, 0.3, 0.8)};
}

TEST(SyntheticShape, HitsAreOnTheSurfaceAndNothingLiesBefore) {
  RandomStream random(7);
  for (const Shape& shape : some_shapes()) {
    int num_hits = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const Eigen::Vector3d origin(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), -4.0);
      const Eigen::Vector3d aim(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7),
                                random.uniform(-0.6, 1.0));
      const Eigen::Vector3d direction = aim - origin;  // t = 1 at the aim
      const double t = intersect(shape, origin, direction, 1e-6);
      const bool is_hit = t > 0.0;
      num_hits += is_hit ? 1 : 0;
      if (is_hit) {
        EXPECT_NEAR(implicit(shape, origin + t * direction), 0.0, 1e-6);
      }
      for (double s = 0.0; s < (is_hit ? t - 1e-3 : 3.0); s += 0.01) {
        ASSERT_GT(implicit(shape, origin + s * direction), -1e-6)
            << "missed a surface before " << s;
      }
    }
    EXPECT_GT(num_hits, 10);
  }
}

TEST(SyntheticShape, RaysAlongAnAxis) {
  const Shape box = box_shape({2.0, 2.0, 2.0});
  EXPECT_DOUBLE_EQ(intersect(box, {0.0, 0.0, -3.0}, {0.0, 0.0, 1.0}, 0.0), 2.0);
  EXPECT_LT(intersect(box, {1.5, 0.0, -3.0}, {0.0, 0.0, 1.0}, 0.0), 0.0);
  // From within, the far side.
  EXPECT_DOUBLE_EQ(intersect(box, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.0), 1.0);
  const Shape cylinder = cylinder_shape(1.0, 2.0);
  EXPECT_DOUBLE_EQ(intersect(cylinder, {0.5, 0.0, -3.0}, {0.0, 0.0, 1.0}, 0.0), 2.0);
  EXPECT_DOUBLE_EQ(intersect(cylinder, {-3.0, 0.0, 0.5}, {2.0, 0.0, 0.0}, 0.0), 1.0);
  EXPECT_LT(intersect(cylinder, {1.5, 0.0, -3.0}, {0.0, 0.0, 1.0}, 0.0), 0.0);
  // A round cone of equal radii is a capsule: from the side and from the end.
  const Shape capsule = round_cone_shape(0.5, 0.5, 2.0);
  EXPECT_NEAR(intersect(capsule, {-2.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, 0.0), 1.5, 1e-12);
  EXPECT_NEAR(intersect(capsule, {0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}, 0.0), 2.5, 1e-12);
}

TEST(SyntheticShape, NormalsAreThoseOfTheSurface) {
  RandomStream random(8);
  for (const Shape& shape : some_shapes()) {
    for (int trial = 0; trial < 40; ++trial) {
      const Eigen::Vector3d origin(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), 4.0);
      const Eigen::Vector3d direction =
          Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0.3) - origin;
      const double t = intersect(shape, origin, direction, 1e-6);
      if (t < 0.0) continue;
      const Eigen::Vector3d point = origin + t * direction;
      const SurfacePoint surface = surface_point(shape, point);
      EXPECT_NEAR(surface.normal.norm(), 1.0, 1e-12);
      // The gradient of the implicit function by differences, carried to the stretched frame.
      Eigen::Vector3d gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = 1e-4 * Eigen::Vector3d::Unit(axis);
        gradient[axis] = implicit(shape, point + step) - implicit(shape, point - step);
      }
      const Eigen::Vector3d expected = gradient.cwiseQuotient(shape.scale_m).normalized();
      EXPECT_GT(surface.normal.dot(expected), 0.99);
    }
  }
}

TEST(SyntheticShape, TextureRunsToTheRightAndDownAsSeenFromOutside) {
  const Shape box = box_shape({2.0, 2.0, 2.0});
  // Seen against +y the right hand is +x.
  const SurfacePoint left_top = surface_point(box, {-0.5, -1.0, 0.8});
  const SurfacePoint right_bottom = surface_point(box, {0.5, -1.0, -0.8});
  EXPECT_EQ(left_top.face, 2);
  EXPECT_NEAR(right_bottom.u_m - left_top.u_m, 1.0, 1e-12);
  EXPECT_NEAR(right_bottom.v_m - left_top.v_m, 1.6, 1e-12);
  // Seen against -x the right hand is +y.
  EXPECT_GT(surface_point(box, {1.0, 0.5, 0.0}).u_m, surface_point(box, {1.0, -0.5, 0.0}).u_m);
  // Around a sphere seen from the front (+y), the right hand is -x.
  const Shape sphere = ellipsoid_shape({1.0, 1.0, 1.0});
  EXPECT_GT(surface_point(sphere, Eigen::Vector3d(-0.3, 0.9, 0.0).normalized()).u_m,
            surface_point(sphere, Eigen::Vector3d(0.3, 0.9, 0.0).normalized()).u_m);
}

TEST(SyntheticShape, BoundingSphereHoldsTheShape) {
  RandomStream random(9);
  for (const Shape& shape : some_shapes()) {
    const BoundingSphere sphere = bounding_sphere(shape);
    for (int trial = 0; trial < 200; ++trial) {
      const Eigen::Vector3d origin(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), 4.0);
      const Eigen::Vector3d direction =
          Eigen::Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.3) - origin;
      const double t = intersect(shape, origin, direction, 1e-6);
      if (t < 0.0) continue;
      const Eigen::Vector3d point_m = (origin + t * direction).cwiseProduct(shape.scale_m);
      EXPECT_LE((point_m - sphere.center_m).norm(), sphere.radius_m + 1e-9);
    }
  }
}

}  // namespace
}  // namespace srslam::detail
