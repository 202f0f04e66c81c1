// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/planner/refinement/painted_room.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {

namespace {

// 8-bit sRGB that varies smoothly over the room, with waves of about 20 to 100 cm in all directions.
glm::dvec3 paint(const glm::dvec3& at) {
  glm::dvec3 sum(0);
  for (int wave = 0; wave < 9; ++wave) {
    const double length = 6 + 2.5 * wave;
    const glm::dvec3 direction =
        glm::normalize(glm::dvec3(std::sin(1.3 * wave + 0.4), std::cos(2.1 * wave), std::sin(3.7 * wave + 1.1)));
    for (int channel = 0; channel < 3; ++channel) {
      sum[channel] += std::sin(length * glm::dot(direction, at) + 1.7 * wave * channel + wave);
    }
  }
  return 128.0 + 25.0 * sum;
}

}  // namespace

Camera painted_camera(std::size_t number) {
  return room_camera(number).scaled_to(240, 180);
}

Photograph painted_photograph(const Camera& camera, const Visibility& visibility,
                              const std::function<glm::dvec2(const glm::dvec2& pixel)>& shown) {
  constexpr std::uint32_t kBeside = 20;
  Camera wide = camera;
  wide.width += 2 * kBeside;
  wide.height += 2 * kBeside;
  wide.cx += kBeside;
  wide.cy += kBeside;
  const VisibilityBuffer visible = visibility.trace(wide.scaled_to(2 * wide.width, 2 * wide.height));
  Photograph photograph;
  photograph.width = camera.width;
  photograph.height = camera.height;
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const glm::dvec2 at = shown({x + 0.5, y + 0.5});
      const auto column = static_cast<std::size_t>(std::clamp(2 * (at.x + kBeside), 0.0, visible.width - 1.0));
      const auto row = static_cast<std::size_t>(std::clamp(2 * (at.y + kBeside), 0.0, visible.height - 1.0));
      const double depth = visible.depth[row * visible.width + column];
      const glm::dvec3 color = paint(camera.center() + depth * camera.ray(at));
      for (int channel = 0; channel < 3; ++channel) {
        photograph.rgb.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(color[channel], 10.0, 245.0))));
      }
    }
  }
  return photograph;
}

PlannerOptions painted_room_planner() {
  PlannerOptions options;
  options.coverage.ideal_distance = 2;
  options.min_view_gain = 0;
  options.refinement.trust.enabled = false;
  return options;
}

}  // namespace lumatlas
