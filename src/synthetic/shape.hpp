#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace srslam::detail {

/// Convex bodies in a unit frame of their own, stretched by `scale_m` along their axes:
///   kBox        [-1, 1]^3
///   kSphere     radius 1 (an ellipsoid once stretched)
///   kCylinder   radius 1 about z, -1 <= z <= 1
///   kRoundCone  hull of a sphere of radius `radius_start` at the origin and one of radius
///               `radius_end` at (0, 0, length)
enum class ShapeKind : std::uint8_t { kBox, kSphere, kCylinder, kRoundCone };

struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  Eigen::Vector3d scale_m = Eigen::Vector3d::Ones();
  double radius_start = 1.0;  ///< round cone only
  double radius_end = 1.0;
  double length = 1.0;  ///< > |radius_start - radius_end|
};

Shape box_shape(const Eigen::Vector3d& size_m);
Shape ellipsoid_shape(const Eigen::Vector3d& semi_axes_m);
/// Axis along z, centred.
Shape cylinder_shape(double radius_m, double height_m);
/// From the origin along z. `flatten` stretches y, for limbs and trunks that are not round.
Shape round_cone_shape(double radius_start_m, double radius_end_m, double length_m,
                       double flatten = 1.0);

/// Smallest t > t_min with `origin + t direction` on the surface (unit frame), or a negative number
/// when there is none. `direction` need not have unit length.
double intersect(const Shape& shape, const Eigen::Vector3d& origin,
                 const Eigen::Vector3d& direction, double t_min);

/// Where on the surface a point is, for texture and light.
struct SurfacePoint {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< outward, part frame, unit length
  int face = 0;                                       ///< of a box: -x +x -y +y -z +z; else 0
  double u_m = 0.0;  ///< texture coordinates; to the right and down as seen from outside
  double v_m = 0.0;
};

/// `point` in the unit frame, on the surface.
SurfacePoint surface_point(const Shape& shape, const Eigen::Vector3d& point);

/// Sphere around the shape in the part frame (metres).
struct BoundingSphere {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};
BoundingSphere bounding_sphere(const Shape& shape);

}  // namespace srslam::detail
