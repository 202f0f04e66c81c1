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

inline LiveVerdict offer_room(LiveModel& live, std::size_t number) {
  const Camera camera = room_camera(number);
  return live.offer(room_view(number), camera, [camera, number] { return pattern_photograph(camera, number); });
}

}  // namespace lumatlas
