// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the makers of rooms: furniture that stands in more than one kind of scene.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tools/lab/synth/shapes/builder.h"

namespace lumatlas::synth {

inline constexpr float kLampRadiance = 26;  // exposes a white wall about right

class Furnisher : protected SceneBuilder {
 protected:
  using SceneBuilder::SceneBuilder;

  // ---- Materials.

  std::int32_t oak();
  std::int32_t poster();
  std::int32_t print_page();

  // ---- Things. `at` is the middle of what they stand on, `bottom` its height; yaw is in radians.

  // Four, under the corners of a top of `size` whose lower side is at `height`.
  void legs(glm::dvec2 at, glm::dvec2 size, double height, double thick, std::int32_t material);
  void book_lying(glm::dvec2 at, double bottom, double yaw);
  // Books upright along y, their spines towards +x, now and then a gap between them.
  void fill_shelf(glm::dvec2 at, double bottom, double half_width, double tallest);
  void chair(glm::dvec2 at, double yaw);  // its back is at -y
  // A lamp of `size` flush with a ceiling at that height, and its light.
  void ceiling_panel(glm::dvec2 at, glm::dvec2 size, double ceiling, const glm::vec3& radiance);
  // A straight round bar, of 16 sides.
  void pipe(const glm::dvec3& from, const glm::dvec3& to, double radius, std::int32_t material);
};

}  // namespace lumatlas::synth
