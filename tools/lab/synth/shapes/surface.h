// SPDX-License-Identifier: GPL-3.0-or-later
// The appearance of surfaces in a synthetic scene: coordinates on them, procedural patterns, gloss. A pattern is a
// function of the position on the surface alone, so it does not change with the mesh's tessellation.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace lumatlas::synth {

// Every pattern but `plain` encodes position: its marks differ from place to place and have no mirror symmetry, so that
// a flipped axis or a shift shows.
enum class Pattern {
  plain,      // colors[0] alone
  plaster,    // colors[0], clouded, with specks
  wallpaper,  // stripes of colors[0] and [1], a glyph in colors[2] per repeat
  parquet,    // planks of width `scale` along s, between colors[0] and [1]
  tiles,      // squares of side `scale`, colors[0] and [1] with an arc in colors[2]
  wood,       // grain along s, between colors[0] and [1]
  fabric,     // a weave with a plaid
  rug,        // borders, diamonds, and a glyph in each repeat
  poster,     // a landscape with a title
  print,      // a page of glyphs whose hue says where they are
  book,       // a spine: bands and a vertical title
  letter,     // one framed glyph, as on a toy block
  globe,      // land and sea, meridians
  sky,        // clouds over a skyline, for what is outside a window
  bands,      // zigzag bands, as on a vase
  screen,     // windows with lines of text
  cobbles,    // rounded stones of width `scale`, between colors[0] and [1], joints in colors[2]
  grass,      // between colors[0] and [1], a flower in every other square of side `scale`
  bricks,     // bricks of length `scale`, between colors[0] and [1], mortar in colors[2]
  shingles,   // rounded roof tiles of width `scale`, between colors[0] and [1], gaps in colors[2]
  foliage,    // leaves of length `scale`, between colors[0] and [1], on colors[2]
};

struct Material {
  Pattern pattern = Pattern::plain;
  std::array<glm::vec3, 3> colors{glm::vec3(0.5F), glm::vec3(0.3F), glm::vec3(0.1F)};  // linear reflectances
  float scale = 1;  // the pattern's unit, scene units
  // Width over which the marks of cobbles, grass, bricks, shingles and foliage fade in, scene units, >= 0. A photograph
  // whose pixels are much smaller loses nothing when it is resampled.
  float softness = 0;
  std::uint32_t seed = 0;  // for the pattern's marks
  float gloss = 0;         // mirror reflectance at normal incidence, [0, 1]; 0: none at any angle
  float roughness = 0;     // radius of the reflection's lobe, at distance 1
  bool metal = false;      // no diffuse light; the mirror reflectance is the pattern's colour, whatever gloss is
  float emission = 0;      // > 0: radiance is this times the pattern's colour, and nothing is reflected
};

enum class Shape { plane, cylinder, sphere };

// Coordinates (s, t) in scene units. plane: origin + s u + t v. cylinder: round the axis v through origin, s the arc
// from direction u. sphere: origin is the centre, s the longitude's arc from u, t the latitude's from its south pole.
struct Surface {
  Shape shape = Shape::plane;
  glm::vec3 origin{0.0F};
  glm::vec3 u{1, 0, 0}, v{0, 0, 1};  // unit, orthogonal
  glm::vec2 size{1.0F};              // s is in [0, size.x], t in [0, size.y]
  float radius = 0;
  std::uint32_t material = 0;
};

[[nodiscard]] glm::vec2 coordinates(const Surface& surface, const glm::vec3& point);
// Unit, of the smooth shape: planes towards cross(u, v), the others outwards.
[[nodiscard]] glm::vec3 normal(const Surface& surface, const glm::vec3& point);

// The colour in linear light, >= 0.
[[nodiscard]] glm::vec3 pattern_color(const Material& material, const glm::vec2& st, const glm::vec2& size);

// The sky beyond all surfaces: radiances, and clouds by the seed.
struct Sky {
  glm::vec3 zenith{0.3F, 0.5F, 0.85F}, horizon{0.75F, 0.82F, 0.9F}, below{0.3F, 0.32F, 0.28F};
  std::uint32_t seed = 0;
};
// The light that comes from a unit direction; linear, >= 0.
[[nodiscard]] glm::vec3 sky_color(const Sky& sky, const glm::vec3& direction);

// Linear light of an 8-bit sRGB colour, and back: rounded to nearest, clamped to [0, 1] first.
[[nodiscard]] glm::vec3 linear_from_srgb(int red, int green, int blue);
[[nodiscard]] std::uint8_t srgb_from_linear(float value);

}  // namespace lumatlas::synth
