#include "synthetic/shape.hpp"

#include <algorithm>
#include <cmath>

#include "synthetic/constants.hpp"

namespace srslam::detail {
namespace {

constexpr double kMiss = -1.0;

double intersect_box(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                     double t_min) {
  double enter = -kInfinity;
  double leave = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (std::abs(origin[axis]) > 1.0) return kMiss;
      continue;
    }
    const double inverse = 1.0 / direction[axis];
    const double a = (-1.0 - origin[axis]) * inverse;
    const double b = (1.0 - origin[axis]) * inverse;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return kMiss;
  if (enter > t_min) return enter;
  return leave > t_min ? leave : kMiss;
}

/// Roots of a t² + 2 b t + c = 0 in increasing order; false without real ones.
bool solve_quadratic(double a, double b, double c, double* first, double* second) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0) || a == 0.0) return false;
  const double root = std::sqrt(discriminant);
  // The form that subtracts nothing of the same size.
  const double q = b > 0.0 ? -b - root : -b + root;
  const double t0 = q / a;
  const double t1 = q != 0.0 ? c / q : t0;
  *first = std::min(t0, t1);
  *second = std::max(t0, t1);
  return true;
}

double intersect_sphere(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double radius, double t_min) {
  double first = 0.0;
  double second = 0.0;
  if (!solve_quadratic(direction.squaredNorm(), origin.dot(direction),
                       origin.squaredNorm() - radius * radius, &first, &second)) {
    return kMiss;
  }
  if (first > t_min) return first;
  return second > t_min ? second : kMiss;
}

double intersect_cylinder(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                          double t_min) {
  double enter = -kInfinity;
  double leave = kInfinity;
  const double a = direction.head<2>().squaredNorm();
  const double c = origin.head<2>().squaredNorm() - 1.0;
  if (a > 0.0) {
    if (!solve_quadratic(a, origin.head<2>().dot(direction.head<2>()), c, &enter, &leave)) {
      return kMiss;
    }
  } else if (c > 0.0) {
    return kMiss;
  }
  if (direction.z() != 0.0) {
    const double bottom = (-1.0 - origin.z()) / direction.z();
    const double top = (1.0 - origin.z()) / direction.z();
    enter = std::max(enter, std::min(bottom, top));
    leave = std::min(leave, std::max(bottom, top));
  } else if (std::abs(origin.z()) > 1.0) {
    return kMiss;
  }
  if (enter > leave) return kMiss;
  if (enter > t_min) return enter;
  return leave > t_min ? leave : kMiss;
}

/// The surface between the spheres touches both, so that its normal leans by the angle whose sine
/// is (radius_start - radius_end) / length.
struct ConeSlope {
  double sine;
  double cosine;
};

ConeSlope cone_slope(const Shape& shape) {
  const double sine = (shape.radius_start - shape.radius_end) / shape.length;
  return {sine, std::sqrt(1.0 - sine * sine)};
}

/// Height on the axis of the sphere that touches the surface at this radius and height.
double touching_height(const ConeSlope& slope, double radius, double z) {
  return z - radius * slope.sine / slope.cosine;
}

double intersect_round_cone(const Shape& shape, const Eigen::Vector3d& origin,
                            const Eigen::Vector3d& direction, double t_min) {
  const ConeSlope slope = cone_slope(shape);
  double best = kInfinity;
  // The side: radius * cosine + z * sine = radius_start.
  const double cosine2 = slope.cosine * slope.cosine;
  const double rest = shape.radius_start - origin.z() * slope.sine;
  const double a = direction.head<2>().squaredNorm() * cosine2 -
                   direction.z() * direction.z() * slope.sine * slope.sine;
  const double b =
      origin.head<2>().dot(direction.head<2>()) * cosine2 + rest * direction.z() * slope.sine;
  const double c = origin.head<2>().squaredNorm() * cosine2 - rest * rest;
  double roots[2];
  const bool meets_cone = solve_quadratic(a, b, c, &roots[0], &roots[1]);
  // A ray less steep than the side passes through the cone from its first root to its second: the
  // body, which is inside, cannot be met outside of that.
  if (a > 0.0 && !meets_cone) return kMiss;
  if (meets_cone) {
    for (const double t : roots) {
      if (!(t > t_min) || t >= best) continue;
      const Eigen::Vector3d point = origin + t * direction;
      if (shape.radius_start - point.z() * slope.sine < 0.0) continue;  // the mirrored cone
      const double height = touching_height(slope, point.head<2>().norm(), point.z());
      if (height < 0.0 || height > shape.length) continue;
      if (a > 0.0 && t == roots[0]) return t;
      best = t;
    }
  }
  const auto try_sphere = [&](double center, double radius, bool at_end) {
    const Eigen::Vector3d from(origin.x(), origin.y(), origin.z() - center);
    if (!solve_quadratic(direction.squaredNorm(), from.dot(direction),
                         from.squaredNorm() - radius * radius, &roots[0], &roots[1])) {
      return;
    }
    for (const double t : roots) {
      if (!(t > t_min) || t >= best) continue;
      const Eigen::Vector3d point = origin + t * direction;
      const double height = touching_height(slope, point.head<2>().norm(), point.z());
      if (at_end ? height >= shape.length : height <= 0.0) best = t;
    }
  };
  try_sphere(0.0, shape.radius_start, false);
  try_sphere(shape.length, shape.radius_end, true);
  return best < kInfinity ? best : kMiss;
}

}  // namespace

Shape box_shape(const Eigen::Vector3d& size_m) {
  Shape shape;
  shape.kind = ShapeKind::kBox;
  shape.scale_m = 0.5 * size_m;
  return shape;
}

Shape ellipsoid_shape(const Eigen::Vector3d& semi_axes_m) {
  Shape shape;
  shape.kind = ShapeKind::kSphere;
  shape.scale_m = semi_axes_m;
  return shape;
}

Shape cylinder_shape(double radius_m, double height_m) {
  Shape shape;
  shape.kind = ShapeKind::kCylinder;
  shape.scale_m = {radius_m, radius_m, 0.5 * height_m};
  return shape;
}

Shape round_cone_shape(double radius_start_m, double radius_end_m, double length_m,
                       double flatten) {
  Shape shape;
  shape.kind = ShapeKind::kRoundCone;
  shape.scale_m = {1.0, flatten, 1.0};
  shape.radius_start = radius_start_m;
  shape.radius_end = radius_end_m;
  shape.length = length_m;
  return shape;
}

double intersect(const Shape& shape, const Eigen::Vector3d& origin,
                 const Eigen::Vector3d& direction, double t_min) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return intersect_box(origin, direction, t_min);
    case ShapeKind::kSphere:
      return intersect_sphere(origin, direction, 1.0, t_min);
    case ShapeKind::kCylinder:
      return intersect_cylinder(origin, direction, t_min);
    case ShapeKind::kRoundCone:
      return intersect_round_cone(shape, origin, direction, t_min);
  }
  return kMiss;
}

SurfacePoint surface_point(const Shape& shape, const Eigen::Vector3d& point) {
  SurfacePoint surface;
  const Eigen::Vector3d metric = point.cwiseProduct(shape.scale_m);
  Eigen::Vector3d unit_normal = point;
  switch (shape.kind) {
    case ShapeKind::kBox: {
      int axis = 0;
      point.cwiseAbs().maxCoeff(&axis);
      const bool positive = point[axis] > 0.0;
      surface.face = 2 * axis + (positive ? 1 : 0);
      surface.normal = Eigen::Vector3d::Unit(axis) * (positive ? 1.0 : -1.0);
      // To the right as seen from outside with z up: (-normal) x z.
      if (axis == 0) {
        surface.u_m = (positive ? 1.0 : -1.0) * metric.y() + shape.scale_m.y();
      } else if (axis == 1) {
        surface.u_m = (positive ? -1.0 : 1.0) * metric.x() + shape.scale_m.x();
      } else {
        surface.u_m = metric.x() + shape.scale_m.x();
      }
      surface.v_m = axis == 2 ? shape.scale_m.y() + (positive ? -1.0 : 1.0) * metric.y()
                              : shape.scale_m.z() - metric.z();
      return surface;
    }
    case ShapeKind::kSphere:
      break;
    case ShapeKind::kCylinder:
      if (std::abs(point.z()) > 1.0 - 1e-9 && point.head<2>().squaredNorm() < 1.0 - 1e-9) {
        surface.normal = Eigen::Vector3d::UnitZ() * (point.z() > 0.0 ? 1.0 : -1.0);
        surface.u_m = metric.x() + shape.scale_m.x();
        surface.v_m = metric.y() + shape.scale_m.y();
        return surface;
      }
      unit_normal.z() = 0.0;
      break;
    case ShapeKind::kRoundCone: {
      const double height = std::clamp(
          touching_height(cone_slope(shape), point.head<2>().norm(), point.z()), 0.0, shape.length);
      unit_normal.z() -= height;
      break;
    }
  }
  surface.normal = unit_normal.cwiseQuotient(shape.scale_m).normalized();
  // Around the axis and along it. The seam lies at the back (-y).
  const double radius = shape.kind == ShapeKind::kRoundCone
                            ? std::max(shape.radius_start, shape.radius_end)
                            : std::max(shape.scale_m.x(), shape.scale_m.y());
  surface.u_m =
      radius *
      (kPi - double(std::atan2(static_cast<float>(point.x()), static_cast<float>(point.y()))));
  surface.v_m = shape.kind == ShapeKind::kRoundCone ? shape.radius_start + metric.z()
                                                    : shape.scale_m.z() - metric.z();
  return surface;
}

BoundingSphere bounding_sphere(const Shape& shape) {
  BoundingSphere sphere;
  switch (shape.kind) {
    case ShapeKind::kBox:
      sphere.radius_m = shape.scale_m.norm();
      break;
    case ShapeKind::kSphere:
      sphere.radius_m = shape.scale_m.maxCoeff();
      break;
    case ShapeKind::kCylinder:
      sphere.radius_m =
          std::hypot(std::max(shape.scale_m.x(), shape.scale_m.y()), shape.scale_m.z());
      break;
    case ShapeKind::kRoundCone: {
      const double low = -shape.radius_start;
      const double high = shape.length + shape.radius_end;
      sphere.center_m = {0.0, 0.0,
                         0.5 *
                             (std::min(low, shape.length - shape.radius_end) +
                              std::max(high, shape.radius_start)) *
                             shape.scale_m.z()};
      // Covers both end spheres from the middle of the whole.
      const double reach_start = std::abs(sphere.center_m.z()) + shape.radius_start;
      const double reach_end = std::abs(shape.length - sphere.center_m.z()) + shape.radius_end;
      sphere.radius_m = std::max(reach_start, reach_end) * std::max(1.0, shape.scale_m.y());
      break;
    }
  }
  return sphere;
}

}  // namespace srslam::detail
