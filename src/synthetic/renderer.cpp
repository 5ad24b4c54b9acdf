#include "synthetic/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "synthetic/constants.hpp"

namespace srslam::detail {
namespace {

constexpr int kTileSize_px = 16;
constexpr double kNear_m = 0.05;
constexpr float kAmbient = 0.50F;
constexpr float kLampShare = 0.62F;
// Beyond so many radii a sphere's shadow is below one grey level.
constexpr float kShadowReach = 6.0F;

/// Where a part may be seen, in normalised image coordinates: the corners of its box.
void set_bounds(const Shape& shape, const Pose& T_camera_part,
                Renderer::Workspace::PosedPart* posed) {
  Eigen::Vector3d low = -shape.scale_m;
  Eigen::Vector3d high = shape.scale_m;
  if (shape.kind == ShapeKind::kRoundCone) {
    const double radius = std::max(shape.radius_start, shape.radius_end);
    low = Eigen::Vector3d(-radius, -radius,
                          std::min(-shape.radius_start, shape.length - shape.radius_end))
              .cwiseProduct(shape.scale_m);
    high = Eigen::Vector3d(radius, radius,
                           std::max(shape.radius_start, shape.length + shape.radius_end))
               .cwiseProduct(shape.scale_m);
  }
  Eigen::Vector3d corners[8];
  posed->near_m = kInfinity;
  double far_m = -kInfinity;
  for (int i = 0; i < 8; ++i) {
    corners[i] = T_camera_part * Eigen::Vector3d((i & 1) != 0 ? high.x() : low.x(),
                                                 (i & 2) != 0 ? high.y() : low.y(),
                                                 (i & 4) != 0 ? high.z() : low.z());
    posed->near_m = std::min(posed->near_m, corners[i].z());
    far_m = std::max(far_m, corners[i].z());
  }
  posed->in_view = far_m > kNear_m;
  posed->x_min = posed->y_min = kInfinity;
  posed->x_max = posed->y_max = -kInfinity;
  const auto include = [&](const Eigen::Vector3d& point) {
    posed->x_min = std::min(posed->x_min, point.x() / point.z());
    posed->x_max = std::max(posed->x_max, point.x() / point.z());
    posed->y_min = std::min(posed->y_min, point.y() / point.z());
    posed->y_max = std::max(posed->y_max, point.y() / point.z());
  };
  for (int i = 0; i < 8; ++i) {
    if (corners[i].z() >= kNear_m) include(corners[i]);
    // Edges lead to the corner that differs in one bit. What lies before the near plane is the hull
    // of the corners there and of the points where edges cross it.
    for (const int bit : {1, 2, 4}) {
      const Eigen::Vector3d& a = corners[i];
      const Eigen::Vector3d& b = corners[i | bit];
      if ((i & bit) != 0 || (a.z() < kNear_m) == (b.z() < kNear_m)) continue;
      Eigen::Vector3d crossing = a + (kNear_m - a.z()) / (b.z() - a.z()) * (b - a);
      crossing.z() = kNear_m;
      include(crossing);
    }
  }
}

}  // namespace

Renderer::Renderer(const Scene* scene, const PinholeCamera& camera)
    : scene_(scene), camera_(camera) {
  rays_.reserve(static_cast<std::size_t>(camera.width_px) *
                static_cast<std::size_t>(camera.height_px));
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
      const bool valid = camera.unproject(Eigen::Vector2d(u, v), 1.0, &point_m);
      rays_.push_back(valid ? point_m : Eigen::Vector3d::Zero());
    }
  }
  tile_columns_ = (camera.width_px + kTileSize_px - 1) / kTileSize_px;
  tile_rows_ = (camera.height_px + kTileSize_px - 1) / kTileSize_px;
  for (int row = 0; row < tile_rows_; ++row) {
    for (int column = 0; column < tile_columns_; ++column) {
      Bounds bounds{kInfinity, -kInfinity, kInfinity, -kInfinity};
      const int v_end = std::min((row + 1) * kTileSize_px, camera.height_px);
      const int u_end = std::min((column + 1) * kTileSize_px, camera.width_px);
      for (int v = row * kTileSize_px; v < v_end; ++v) {
        for (int u = column * kTileSize_px; u < u_end; ++u) {
          const Eigen::Vector3d& direction = ray(u, v);
          if (direction.z() == 0.0) continue;
          bounds.x_min = std::min(bounds.x_min, direction.x());
          bounds.x_max = std::max(bounds.x_max, direction.x());
          bounds.y_min = std::min(bounds.y_min, direction.y());
          bounds.y_max = std::max(bounds.y_max, direction.y());
        }
      }
      // Samples inside a pixel reach half a pixel further.
      const double margin = 1.0 / std::min(camera.fx_px, camera.fy_px);
      tile_bounds_.push_back({bounds.x_min - margin, bounds.x_max + margin, bounds.y_min - margin,
                              bounds.y_max + margin});
    }
  }
}

void Renderer::prepare(double time_s, const Pose& T_world_camera, bool try_all_parts,
                       Workspace* workspace) const {
  scene_->poses_at(time_s, &workspace->T_world_part);
  const Pose T_camera_world = T_world_camera.inverse();
  workspace->posed.resize(scene_->parts.size());
  for (std::size_t i = 0; i < scene_->parts.size(); ++i) {
    const Shape& shape = scene_->parts[i].shape;
    const Pose T_camera_part = T_camera_world * workspace->T_world_part[i];
    Workspace::PosedPart& posed = workspace->posed[i];
    const Eigen::Vector3d inverse_scale = shape.scale_m.cwiseInverse();
    const Eigen::Matrix3d R_part_camera = T_camera_part.linear().transpose();
    posed.unit_from_camera = inverse_scale.asDiagonal() * R_part_camera;
    posed.origin = -(posed.unit_from_camera * T_camera_part.translation());
    posed.R_world_part = workspace->T_world_part[i].linear();
    set_bounds(shape, T_camera_part, &posed);
  }
  const Pose T_room_world = scene_->T_world_room.inverse();
  const Eigen::Vector3d inverse_scale = scene_->room.scale_m.cwiseInverse();
  workspace->room_origin = inverse_scale.cwiseProduct(T_room_world * T_world_camera.translation());
  workspace->room_from_camera =
      inverse_scale.asDiagonal() * (T_room_world.linear() * T_world_camera.linear());
  prepare_shadows(workspace);
  assign_tiles(try_all_parts, workspace);
}

void Renderer::prepare_shadows(Workspace* workspace) const {
  workspace->spheres.clear();
  workspace->groups.clear();
  for (const Body& body : scene_->bodies) {
    Workspace::ShadowGroup group;
    group.begin = workspace->spheres.size();
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t i = body.first_part; i < body.first_part + body.num_parts; ++i) {
      const Part& part = scene_->parts[i];
      if (part.shadow_radius_m <= 0.0) continue;
      Workspace::ShadowSphere sphere;
      sphere.center_m =
          (workspace->T_world_part[i] * bounding_sphere(part.shape).center_m).cast<float>();
      sphere.radius_m = static_cast<float>(part.shadow_radius_m);
      sphere.part = static_cast<int>(i);
      sum += sphere.center_m;
      workspace->spheres.push_back(sphere);
    }
    group.end = workspace->spheres.size();
    if (group.end == group.begin) continue;
    group.center_m = sum / static_cast<float>(group.end - group.begin);
    for (std::size_t i = group.begin; i < group.end; ++i) {
      const Workspace::ShadowSphere& sphere = workspace->spheres[i];
      group.reach_m = std::max(group.reach_m, (sphere.center_m - group.center_m).norm() +
                                                  kShadowReach * sphere.radius_m);
    }
    workspace->groups.push_back(group);
  }
}

void Renderer::assign_tiles(bool try_all_parts, Workspace* workspace) const {
  workspace->by_depth.clear();
  for (std::size_t i = 0; i < workspace->posed.size(); ++i) {
    if (try_all_parts) workspace->posed[i].near_m = 0.0;
    if (workspace->posed[i].in_view || try_all_parts) {
      workspace->by_depth.push_back(static_cast<std::uint16_t>(i));
    }
  }
  std::sort(workspace->by_depth.begin(), workspace->by_depth.end(),
            [&](std::uint16_t a, std::uint16_t b) {
              const double near_a = workspace->posed[a].near_m;
              const double near_b = workspace->posed[b].near_m;
              return near_a != near_b ? near_a < near_b : a < b;
            });
  workspace->tiles.resize(tile_bounds_.size());
  for (auto& tile : workspace->tiles) tile.clear();
  for (const std::uint16_t i : workspace->by_depth) {
    const Workspace::PosedPart& posed = workspace->posed[i];
    for (std::size_t k = 0; k < tile_bounds_.size(); ++k) {
      const Bounds& bounds = tile_bounds_[k];
      if (try_all_parts || (posed.x_min <= bounds.x_max && posed.x_max >= bounds.x_min &&
                            posed.y_min <= bounds.y_max && posed.y_max >= bounds.y_min)) {
        workspace->tiles[k].push_back(i);
      }
    }
  }
}

Renderer::Hit Renderer::trace(const Eigen::Vector3d& direction,
                              const std::vector<std::uint16_t>& candidates,
                              const Workspace& workspace) const {
  Hit hit;
  double best = kInfinity;
  for (const std::uint16_t i : candidates) {
    const Workspace::PosedPart& posed = workspace.posed[i];
    if (posed.near_m >= best) break;
    const Eigen::Vector3d in_unit = posed.unit_from_camera * direction;
    const double t = intersect(scene_->parts[i].shape, posed.origin, in_unit, kNear_m);
    // Of two parts at the same depth the first one is seen, whatever the order of trial.
    if (t > 0.0 && (t < best || (t == best && i < hit.part))) {
      best = t;
      hit.part = i;
    }
  }
  hit.depth_m = best;
  return hit;
}

const Shape& Renderer::shape_of(const Hit& hit) const {
  return hit.part == kRoomPart ? scene_->room : scene_->parts[hit.part].shape;
}

Eigen::Vector3d Renderer::unit_point(const Eigen::Vector3d& direction, const Hit& hit,
                                     const Workspace& workspace) {
  if (hit.part == kRoomPart) {
    return workspace.room_origin + hit.depth_m * (workspace.room_from_camera * direction);
  }
  const Workspace::PosedPart& posed = workspace.posed[hit.part];
  return posed.origin + hit.depth_m * (posed.unit_from_camera * direction);
}

int Renderer::face_of(const Eigen::Vector3d& direction, const Hit& hit,
                      const Workspace& workspace) const {
  const Shape& shape = shape_of(hit);
  if (shape.kind != ShapeKind::kBox) return 0;
  return surface_point(shape, unit_point(direction, hit, workspace)).face;
}

float Renderer::shadow(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal, int part,
                       const Workspace& workspace) const {
  float light = 1.0F;
  for (const Workspace::ShadowGroup& group : workspace.groups) {
    if ((group.center_m - point_m).squaredNorm() > group.reach_m * group.reach_m) continue;
    for (std::size_t i = group.begin; i < group.end; ++i) {
      const Workspace::ShadowSphere& sphere = workspace.spheres[i];
      if (sphere.part == part) continue;
      const Eigen::Vector3f offset = sphere.center_m - point_m;
      const float height = normal.dot(offset);
      if (height <= 0.0F) continue;
      const float reach = kShadowReach * sphere.radius_m;
      const float distance2 = std::max(offset.squaredNorm(), 1e-8F);
      if (distance2 > reach * reach) continue;
      // Share of the hemisphere above the surface that the sphere hides, weighted by the cosine.
      const float distance = std::sqrt(distance2);
      const float hidden =
          height / distance * std::min(1.0F, sphere.radius_m * sphere.radius_m / distance2);
      // Fades out at the end of its reach.
      const float fade = 1.0F - distance / reach;
      light *= 1.0F - 0.85F * hidden * fade;
    }
  }
  return light;
}

Eigen::Vector3f Renderer::shade(const Eigen::Vector3d& direction, const Hit& hit,
                                const Pose& T_world_camera, const Workspace& workspace,
                                float* cosine, std::uint8_t* face) const {
  const Eigen::Vector3d point_world = T_world_camera * (hit.depth_m * direction);
  SurfacePoint surface = surface_point(shape_of(hit), unit_point(direction, hit, workspace));
  Eigen::Vector3d normal;
  const Material* material = &scene_->room_material;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  if (hit.part == kRoomPart) {
    normal = scene_->T_world_room.linear() * -surface.normal;
    // Seen from inside, right and left change places.
    const int axis = surface.face / 2;
    if (axis != 2) surface.u_m = 2.0 * scene_->room.scale_m[1 - axis] - surface.u_m;
  } else {
    const Part& part = scene_->parts[hit.part];
    normal = workspace.posed[hit.part].R_world_part * surface.normal;
    material = &scene_->materials[static_cast<std::size_t>(part.material)];
    offset = part.texture_offset_m;
  }
  const Eigen::Vector3d ray_world = T_world_camera.linear() * direction;
  const double facing = std::min(1.0, std::abs(normal.dot(ray_world)) / ray_world.norm());
  *cosine = static_cast<float>(facing);
  *face = static_cast<std::uint8_t>(surface.face);
  const double footprint_m = hit.depth_m / camera_.fx_px / std::sqrt(std::max(facing, 0.1));
  const auto texture =
      static_cast<std::size_t>(material->textures[static_cast<std::size_t>(surface.face)]);
  const Eigen::Vector3f color = scene_->textures[texture].sample(
      surface.u_m + offset.x(), surface.v_m + offset.y(), footprint_m);

  const Eigen::Vector3f point = point_world.cast<float>();
  const Eigen::Vector3f unit_normal = normal.cast<float>();
  float light = kAmbient * (1.0F + 0.15F * unit_normal.z());
  for (const Lamp& lamp : scene_->lamps) {
    const Eigen::Vector3f to_lamp = lamp.position_m.cast<float>() - point;
    const float distance2 = to_lamp.squaredNorm();
    const float slope = unit_normal.dot(to_lamp) / std::sqrt(std::max(distance2, 1e-6F));
    if (slope > 0.0F) light += kLampShare * lamp.strength * slope * 4.0F / (distance2 + 2.5F);
  }
  return color * light * shadow(point, unit_normal, hit.part, workspace);
}

void Renderer::render(double time_s, const Pose& T_world_camera, PixelBuffers* buffers,
                      Workspace* workspace, bool try_all_parts) const {
  prepare(time_s, T_world_camera, try_all_parts, workspace);
  const int width = camera_.width_px;
  const int height = camera_.height_px;
  buffers->color.resize(width, height);
  buffers->depth_m.resize(width, height);
  buffers->cosine.resize(width, height);
  buffers->part.resize(width, height);
  workspace->faces.resize(rays_.size());

  const auto look = [&](const Eigen::Vector3d& direction, std::size_t tile) {
    Hit hit = trace(direction, workspace->tiles[tile], *workspace);
    const double room_depth_m = intersect(scene_->room, workspace->room_origin,
                                          workspace->room_from_camera * direction, kNear_m);
    if (room_depth_m > 0.0 && room_depth_m < hit.depth_m) hit = {room_depth_m, kRoomPart};
    return hit;
  };

  auto color = buffers->color.view();
  auto depth = buffers->depth_m.view();
  auto cosine = buffers->cosine.view();
  auto part = buffers->part.view();
  const auto tile_of = [&](int u, int v) {
    return static_cast<std::size_t>(v / kTileSize_px) * static_cast<std::size_t>(tile_columns_) +
           static_cast<std::size_t>(u / kTileSize_px);
  };
  const auto at = [&](int u, int v) {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(u);
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3d& direction = ray(u, v);
      const Hit hit =
          direction.z() == 0.0 ? Hit{kInfinity, kRoomPart} : look(direction, tile_of(u, v));
      part(u, v) = hit.part;
      if (!std::isfinite(hit.depth_m)) {
        color(u, v).setZero();
        depth(u, v) = 0.0F;
        cosine(u, v) = 0.0F;
        workspace->faces[at(u, v)] = 0;
        continue;
      }
      depth(u, v) = static_cast<float>(hit.depth_m);
      color(u, v) = shade(direction, hit, T_world_camera, *workspace, &cosine(u, v),
                          &workspace->faces[at(u, v)]);
    }
  }

  // Where surfaces meet one ray a pixel would give stairs.
  workspace->center_color = buffers->color.pixels;
  const auto differs = [&](int u, int v, int other_u, int other_v) {
    return part(u, v) != part(other_u, other_v) ||
           workspace->faces[at(u, v)] != workspace->faces[at(other_u, other_v)];
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - 1, 0);
      const int right = std::min(u + 1, width - 1);
      const int above = std::max(v - 1, 0);
      const int below = std::min(v + 1, height - 1);
      if (depth(u, v) == 0.0F || !(differs(u, v, left, v) || differs(u, v, right, v) ||
                                   differs(u, v, u, above) || differs(u, v, u, below))) {
        continue;
      }
      if (left == right || above == below) continue;
      const Eigen::Vector3d across = (ray(right, v) - ray(left, v)) / double(right - left);
      const Eigen::Vector3d down = (ray(u, below) - ray(u, above)) / double(below - above);
      struct Seen {
        int u, v;
      };
      const Seen nearby[] = {{u, v}, {left, v}, {right, v}, {u, above}, {u, below}};
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int num_samples = 0;
      for (const auto& offset : {Eigen::Vector2d(-0.375, -0.125), Eigen::Vector2d(0.125, -0.375),
                                 Eigen::Vector2d(0.375, 0.125), Eigen::Vector2d(-0.125, 0.375)}) {
        const Eigen::Vector3d direction = ray(u, v) + offset.x() * across + offset.y() * down;
        const Hit hit = look(direction, tile_of(u, v));
        if (!std::isfinite(hit.depth_m)) continue;
        ++num_samples;
        // Most samples show what this pixel or one beside it shows.
        const int face = face_of(direction, hit, *workspace);
        const auto same = std::find_if(std::begin(nearby), std::end(nearby), [&](const Seen& seen) {
          return part(seen.u, seen.v) == hit.part && workspace->faces[at(seen.u, seen.v)] == face;
        });
        if (same != std::end(nearby)) {
          sum += workspace->center_color[at(same->u, same->v)];
          continue;
        }
        float sample_cosine = 0.0F;
        std::uint8_t sample_face = 0;
        sum += shade(direction, hit, T_world_camera, *workspace, &sample_cosine, &sample_face);
      }
      if (num_samples > 0) color(u, v) = sum / static_cast<float>(num_samples);
    }
  }
}

}  // namespace srslam::detail
