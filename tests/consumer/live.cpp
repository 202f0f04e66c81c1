// SPDX-License-Identifier: GPL-3.0-or-later
// A SLAM system's use of a live model: frames of a wall with a picture on it, no GL.
#include <cstdio>
#include <memory>
#include <string>

#include "tools/live/live_model.h"

using namespace lumatlas;

namespace {

constexpr double kWallAhead = 2;  // scene units

// Walks along the wall, looking at it.
Camera camera_at(int step) {
  Camera camera = centered_camera(160, 120, 140);
  camera.cam_from_world_translation = {-0.1 * step, 0, 0};
  return camera;
}

DepthImage depth_of(const Camera& camera) {
  return {camera, std::vector<float>(std::size_t{camera.width} * camera.height, static_cast<float>(kWallAhead))};
}

// Squares that stay where they are on the wall.
Photograph photograph_of(const Camera& camera) {
  Photograph photograph;
  photograph.width = camera.width;
  photograph.height = camera.height;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const glm::dvec3 at = camera.center() + kWallAhead * camera.ray({x + 0.5, y + 0.5});
      const int square = static_cast<int>((at.x + 9) * 8) * 7 + static_cast<int>((at.y + 9) * 8) * 3;
      const auto grey = static_cast<std::uint8_t>(40 + 37 * square % 180);
      photograph.rgb.insert(photograph.rgb.end(), {grey, grey, static_cast<std::uint8_t>(255 - grey)});
    }
  }
  return photograph;
}

}  // namespace

int main() {
  LiveOptions options;
  options.max_views = 8;
  LiveModel live(options);
  for (int step = 0; step < 12; ++step) {
    const Camera camera = camera_at(step);
    const std::string name = "frame " + std::to_string(step);
    live.fuse(name, camera, [camera] { return depth_of(camera); });
    live.offer(name, camera, [camera] { return photograph_of(camera); });
    if (const auto now = live.snapshot()) std::printf("frame %d: %zu faces\n", step, now->surface->mesh.faces.size());
  }
  const LiveResult model = live.finish();
  if (!model.snapshot.surface) return 1;
  std::size_t views = 0;
  for (const auto& view : model.snapshot.views) views += view != nullptr;
  std::printf("%zu views, %zu faces\n", views, model.snapshot.surface->mesh.faces.size());
  return views > 0 ? 0 : 1;
}
