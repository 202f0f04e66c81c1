// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the makers of scenes: materials and boxes in short calls.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "tools/lab/synth/random.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {

// Things stand this deep in what carries them: no coincident faces, no light from below.
inline constexpr double kSink = 0.002;

class SceneBuilder {
 protected:
  using Colors = std::array<glm::vec3, 3>;

  explicit SceneBuilder(std::uint64_t seed) : random_(seed) {}

  // ---- Materials, each with marks of its own; the index of the new one.

  std::int32_t add(Material material);
  // Colours come as a list so that random ones are drawn in its order, whatever the compiler.
  std::int32_t add(Pattern pattern, const Colors& colors, float scale = 1);
  std::int32_t add_glossy(Pattern pattern, const Colors& colors, float scale, float gloss);
  std::int32_t add_metal(const glm::vec3& tint, float roughness);
  std::int32_t add_emission(Pattern pattern, const glm::vec3& a, const glm::vec3& b, float emission);
  std::int32_t matte(const glm::vec3& color);
  glm::vec3 dye();  // a lively colour, not too dark
  // A grey that is tinted by chance: sRGB values from the given ones to 15 above.
  glm::vec3 tone(int red, int green, int blue);

  // ---- Solids. `middle` is that of the bottom, `size` along the solid's own axes.

  // A box that stands on something: its bottom is open.
  Block& box(glm::dvec2 middle, double bottom, glm::dvec3 size, std::int32_t material, double yaw = 0);
  // A box in the air, all of whose sides may be seen.
  Block& board(glm::dvec2 middle, double bottom, glm::dvec3 size, std::int32_t material, double yaw = 0);
  // A picture of `size` (width, height) on a wall; `side` is the block side that faces the room, `at` the middle.
  void hang(glm::dvec3 at, glm::dvec2 size, int side, std::int32_t picture, std::int32_t frame);
  void cylinder(glm::dvec2 middle, double bottom, double radius, double height, std::int32_t side, std::int32_t top);
  void sphere(glm::dvec3 center, double radius, std::int32_t material);
  void convex(Convex body, glm::dvec3 origin, double yaw = 0);
  // The same with a material of its own on each side, all of them like `pattern`: no two sides look alike.
  void convex_of(Convex body, glm::dvec3 origin, Pattern pattern, const Colors& colors, float scale,
                 float softness = 0);

  // ---- Light in the open.

  // `toward` the sun, unit; it is `wide` radians across, and a white surface that faces it sends back `light`.
  void sun(const glm::dvec3& toward, double wide, const glm::vec3& light);

  Scene scene_;
  Random random_;
};

}  // namespace lumatlas::synth
