// SPDX-License-Identifier: GPL-3.0-or-later
// A stream of the room of tests/support/scenes/small_scenes.h: its walk with depth frames.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/small_scenes.h"
#include "tools/live/live_model.h"

namespace lumatlas {

// Exact depths of the room, by rays.
[[nodiscard]] inline DepthImage room_depth(const Camera& camera) {
  static const std::unique_ptr<Visibility> visibility = make_ray_visibility(room_surface()->mesh);
  DepthImage image{camera, visibility->trace(camera).depth};
  for (float& depth : image.depth) depth = std::isfinite(depth) ? depth : 0.0F;
  return image;
}

[[nodiscard]] inline std::string room_view(std::size_t number) {
  return "view " + std::to_string(number);
}

// Photographs of different views show different patterns, which refinement would take for outliers.
[[nodiscard]] inline LiveOptions room_live_options() {
  LiveOptions options;
  options.max_views = 12;
  options.surface.voxel = 0.1;
  options.surface.cell_size = 0.5;
  options.surface_interval = std::chrono::milliseconds(1);
  options.longest_wait = std::chrono::hours(1);
  options.planner.visibility_px = 64;
  options.planner.refinement.alignment.pose = false;
  options.planner.refinement.alignment.exposure = false;
  options.planner.refinement.trust.enabled = false;
  return options;
}

inline void fuse_room(LiveModel& live, std::size_t number) {
  const Camera camera = room_camera(number);
  live.fuse(room_view(number), camera, [camera] { return room_depth(camera); });
}

// The faces of the room in which a face's first corner is in an octant around the room's middle, `octant` in [0, 8).
[[nodiscard]] inline TriangleSoup room_piece(std::uint32_t octant) {
  const std::shared_ptr<const Surface> surface = room_surface();
  const Mesh& room = surface->mesh;
  const glm::vec3 middle(2, 2, 1.5);
  TriangleSoup piece;
  for (const glm::uvec3& face : room.faces) {
    const glm::vec3 at = room.positions[face.x];
    const std::uint32_t of_face =
        (at.x > middle.x ? 1U : 0U) + (at.y > middle.y ? 2U : 0U) + (at.z > middle.z ? 4U : 0U);
    if (of_face != octant) continue;
    const auto first = static_cast<std::uint32_t>(piece.positions.size());
    for (int corner = 0; corner < 3; ++corner) piece.positions.emplace_back(room.positions[face[corner]]);
    piece.faces.emplace_back(first, first + 1, first + 2);
  }
  return piece;
}

inline LiveVerdict offer_room(LiveModel& live, std::size_t number) {
  const Camera camera = room_camera(number);
  return live.offer(room_view(number), camera, [camera, number] { return pattern_photograph(camera, number); });
}

}  // namespace lumatlas
