#pragma once

#include <cstdint>

#include "synthetic/scene.hpp"
#include "synthetic/texture_painter.hpp"

namespace srslam::detail {

/// Inside of the room: |x| <= kRoomHalfX_m, kRoomMinY_m <= y <= kRoomMaxY_m, 0 <= z <=
/// kRoomHeight_m.
constexpr double kRoomHalfX_m = 3.6;
constexpr double kRoomMinY_m = -3.2;
constexpr double kRoomMaxY_m = 3.2;
constexpr double kRoomHeight_m = 2.8;
/// The desk that every scenario looks at.
constexpr double kDeskX_m = 0.1;
constexpr double kDeskY_m = 2.55;
constexpr double kDeskHeight_m = 0.74;

/// A furnished office: desks with screens and clutter, shelves, boxes, chairs, posters. With
/// `low_texture` the walls are bare, the floor is plain and little stands on the desks.
void furnish_room(std::uint64_t seed, bool low_texture, TexturePainter* painter, Scene* scene);

/// Parts of an office chair that faces +y, with the floor at z = 0, and their poses in its frame.
struct Chair {
  std::vector<Part> parts;
  std::vector<Pose> T_chair_part;
};
Chair make_chair(std::uint64_t seed, TexturePainter* painter, Scene* scene);

}  // namespace srslam::detail
