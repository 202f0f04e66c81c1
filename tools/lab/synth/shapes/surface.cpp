// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/shapes/surface.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "atlas/images/srgb.h"
#include "tools/lab/synth/random.h"

namespace lumatlas::synth {
namespace {

using glm::vec2;
using glm::vec3;

std::uint64_t cell_hash(std::uint32_t seed, float i, float j) {
  return hashed(seed, static_cast<std::uint64_t>(static_cast<std::int64_t>(i)),
                static_cast<std::uint64_t>(static_cast<std::int64_t>(j)));
}

// Another number of the same cell.
float cell_value(std::uint64_t hash, std::uint64_t which) {
  return unit_float(hashed(hash, which));
}

// Value noise in [0, 1]: random values on the integer lattice, blended smoothly.
float noise(vec2 p, std::uint32_t seed) {
  const vec2 base = glm::floor(p);
  const vec2 f = p - base;
  const vec2 w = f * f * (3.0F - 2.0F * f);
  const auto at = [&](float i, float j) { return unit_float(cell_hash(seed, base.x + i, base.y + j)); };
  return glm::mix(glm::mix(at(0, 0), at(1, 0), w.x), glm::mix(at(0, 1), at(1, 1), w.x), w.y);
}

float clouds(vec2 p, std::uint32_t seed) {
  return (4 * noise(p, seed) + 2 * noise(2.1F * p, seed + 1) + noise(4.3F * p, seed + 2)) / 7;
}

vec3 hue(float turn) {
  const auto channel = [&](float shift) {
    return 0.5F + 0.5F * std::cos(2 * std::numbers::pi_v<float> * (turn + shift));
  };
  return {channel(0), channel(-1.0F / 3), channel(1.0F / 3)};
}

// Glyphs on 5 x 7 dots, none of them symmetric: F G J L P R Q K 2 4 5 7. Rows from the top, the left dot is bit 4.
constexpr std::array<std::array<std::uint8_t, 7>, 12> kGlyphs = {{
    {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x10},
    {0x0e, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0e},
    {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0c},
    {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f},
    {0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10, 0x10},
    {0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11},
    {0x0e, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0d},
    {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11},
    {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f},
    {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02},
    {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e},
    {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08},
}};

// Returns whether a glyph covers a point of its box, [0, 1]^2 with y up; false outside.
bool glyph(std::uint64_t which, vec2 p) {
  if (p.x < 0 || p.x >= 1 || p.y <= 0 || p.y > 1) return false;
  const auto row = std::min<std::size_t>(6, static_cast<std::size_t>((1 - p.y) * 7));
  const auto column = static_cast<unsigned>(p.x * 5);
  return ((kGlyphs[which % kGlyphs.size()][row] >> (4U - std::min(column, 4U))) & 1U) != 0;
}

vec3 plaster(const Material& m, vec2 st) {
  const float shade = 0.82F + 0.18F * clouds(st / (0.25F * m.scale), m.seed);
  const vec2 grid = st / (0.09F * m.scale);
  const vec2 cell = glm::floor(grid);
  const std::uint64_t h = cell_hash(m.seed + 7, cell.x, cell.y);
  const vec2 speck(0.2F + 0.6F * cell_value(h, 1), 0.2F + 0.6F * cell_value(h, 2));
  const bool inside = cell_value(h, 0) < 0.6F && glm::length(grid - cell - speck) < 0.06F + 0.1F * cell_value(h, 3);
  return m.colors[0] * (inside ? shade * 0.6F : shade);
}

vec3 wallpaper(const Material& m, vec2 st) {
  const float column = std::floor(st.x / m.scale);
  const float shift = std::fmod(std::abs(column), 2.0F) * 0.5F;
  const float row = std::floor(st.y / m.scale + shift);
  const vec2 local(st.x / m.scale - column, st.y / m.scale + shift - row);
  const std::uint64_t h = cell_hash(m.seed, column, row);
  if (glyph(h, (local - vec2(0.34F, 0.25F)) / vec2(0.35F, 0.5F))) {
    return glm::mix(m.colors[0], glm::mix(m.colors[2], hue(cell_value(h, 1)), 0.4F) * 0.5F, 0.75F);
  }
  const bool line = local.x < 0.05F;
  const float shade = 0.88F + 0.12F * noise(st / 0.15F, m.seed + 1);
  return (line ? m.colors[2] : shift > 0 ? m.colors[0] : m.colors[1]) * shade;
}

// Fibres along s, in [0, 1].
float grain(vec2 st, std::uint32_t seed) {
  const float bend = 5 * noise(st * vec2(1.1F, 5), seed);
  const float rings = 0.5F + 0.5F * std::sin(2 * std::numbers::pi_v<float> * (st.y * 9 + bend));
  return 0.45F * rings + 0.3F * noise(st * vec2(5, 90), seed + 1) + 0.25F * noise(st * vec2(14, 240), seed + 2);
}

vec3 parquet(const Material& m, vec2 st) {
  const float row = std::floor(st.y / m.scale);
  const float length = 6 * m.scale;
  const float along = st.x / length + cell_value(cell_hash(m.seed, row, 0), 0);
  const float plank = std::floor(along);
  const std::uint64_t h = cell_hash(m.seed, row, plank);
  const vec2 local((along - plank) * length, st.y - row * m.scale);
  if (local.x < 0.006F || local.y < 0.006F) return m.colors[2];
  const float shade = 0.65F + 0.5F * cell_value(h, 1);
  const float fibre = grain(local + vec2(7 * cell_value(h, 2), 5 * cell_value(h, 3)), m.seed + 3);
  return glm::mix(m.colors[0], m.colors[1], 0.7F * fibre) * shade;
}

vec3 tiles(const Material& m, vec2 st) {
  const vec2 grid = st / m.scale;
  const vec2 cell = glm::floor(grid);
  const vec2 local = grid - cell;
  const std::uint64_t h = cell_hash(m.seed, cell.x, cell.y);
  const float joint = 0.008F / m.scale;
  if (local.x < joint || local.y < joint) return vec3(0.07F);
  const bool checker = std::fmod(std::abs(cell.x + cell.y), 2.0F) < 0.5F;
  const vec3 base = (checker ? m.colors[0] : m.colors[1]) * (0.75F + 0.4F * cell_value(h, 1));
  const vec2 corner(static_cast<float>(h & 1U), static_cast<float>((h >> 1U) & 1U));
  const float ring = glm::length(local - corner);
  if (std::abs(ring - 0.5F) < 0.07F) return m.colors[2];
  const vec2 dot = glm::abs(corner - vec2(0.2F, 0.72F));
  if (glm::length(local - dot) < 0.1F) return hue(cell_value(h, 2)) * 0.6F;
  return base * (0.9F + 0.1F * noise(st / 0.03F, m.seed));
}

vec3 wood(const Material& m, vec2 st, vec2 size) {
  if (size.y > size.x) st = {st.y, size.x - st.x};  // the grain follows the longer side
  const float knots = noise(st * vec2(2.5F, 7), m.seed + 9);
  const vec3 base = glm::mix(m.colors[0], m.colors[1], grain(st / m.scale, m.seed));
  return base * (0.75F + 0.5F * knots);
}

vec3 fabric(const Material& m, vec2 st) {
  const vec2 thread = st / (0.02F * m.scale);
  const bool over = std::fmod(std::floor(thread.x) + std::floor(thread.y) + 1024, 2.0F) < 0.5F;
  const vec2 plaid = glm::floor(st / (0.11F * m.scale));
  const float across = cell_value(cell_hash(m.seed, plaid.x, 0), 0);
  const float along = cell_value(cell_hash(m.seed, plaid.y, 1), 0);
  const vec3 color = glm::mix(m.colors[across > 0.6F ? 1 : 0], m.colors[along > 0.7F ? 2 : 0], 0.5F);
  return color * (over ? 1.0F : 0.72F) * (0.85F + 0.15F * noise(st / 0.05F, m.seed));
}

vec3 rug(const Material& m, vec2 st, vec2 size) {
  const vec2 edge = glm::min(st, size - st);
  const float border = std::min(edge.x, edge.y);
  const float pile = 0.75F + 0.25F * noise(st / 0.012F, m.seed);
  if (border < 0.05F) return m.colors[2] * pile;
  if (border < 0.12F) {
    const float run = edge.x < edge.y ? st.y : st.x;
    return (std::fmod(run, 0.08F) < 0.05F ? m.colors[1] : m.colors[0]) * pile;
  }
  const vec2 grid = st / m.scale;
  const vec2 cell = glm::floor(grid);
  const vec2 local = grid - cell - 0.5F;
  const std::uint64_t h = cell_hash(m.seed, cell.x, cell.y);
  const float diamond = std::abs(local.x) + std::abs(local.y);
  if (glyph(h, (local + vec2(0.16F, 0.22F)) / vec2(0.32F, 0.44F))) return hue(cell_value(h, 1)) * 0.5F * pile;
  return (diamond < 0.44F ? m.colors[1] : diamond < 0.5F ? m.colors[2] : m.colors[0]) * pile;
}

vec3 landscape(const Material& m, vec2 p) {
  const vec2 sun(0.2F + 0.6F * cell_value(m.seed, 1), 0.72F + 0.14F * cell_value(m.seed, 2));
  vec3 color = glm::mix(m.colors[0], m.colors[1], p.y);
  if (glm::length(p - sun) < 0.1F) color = vec3(0.9F, 0.6F, 0.1F);
  for (std::uint32_t ridge = 0; ridge < 4; ++ridge) {
    const float base = 0.72F - 0.13F * static_cast<float>(ridge);
    const float height =
        base + 0.3F * (noise(vec2(p.x * (3.0F + 2.0F * static_cast<float>(ridge)), 0), m.seed + ridge) - 0.5F);
    if (p.y < height)
      color = glm::mix(m.colors[2], hue(cell_value(m.seed, 10 + ridge)), 0.35F) *
              (0.9F - 0.18F * static_cast<float>(ridge));
  }
  return color;
}

// A line of glyphs in a box: x and y in [0, 1] over `count` glyphs.
bool text_line(std::uint64_t seed, float count, vec2 p) {
  if (p.x < 0 || p.x >= 1) return false;
  const float place = std::floor(p.x * count);
  const std::uint64_t h = hashed(seed, static_cast<std::uint64_t>(place));
  return (h >> 32U) % 7 != 0 && glyph(h, vec2((p.x * count - place) / 0.8F, p.y));
}

vec3 poster(const Material& m, vec2 st, vec2 size) {
  const vec2 p = st / size;
  const vec2 edge = glm::min(st, size - st);
  if (std::min(edge.x, edge.y) < 0.02F) return vec3(0.02F);
  if (std::min(edge.x, edge.y) < 0.05F) return vec3(0.75F);
  const float count = std::max(3.0F, std::floor(size.x / size.y * 7));
  if (text_line(m.seed, count, (p - vec2(0.14F, 0.1F)) / vec2(0.72F, 0.13F))) return vec3(0.92F, 0.9F, 0.8F);
  return landscape(m, p);
}

vec3 print(const Material& m, vec2 st, vec2 size) {
  const vec2 edge = glm::min(st, size - st);
  if (std::min(edge.x, edge.y) < 0.02F) return m.colors[2];
  const vec2 grid = st / m.scale;
  const vec2 cell = glm::floor(grid);
  const std::uint64_t h = cell_hash(m.seed, cell.x, cell.y);
  const bool ink = glyph(h, (grid - cell - vec2(0.15F, 0.1F)) / vec2(0.7F, 0.8F));
  const float place = st.x / size.x * 0.7F + st.y / size.y * 0.3F;
  const bool inverse = (h >> 40U) % 5 == 0;
  return ink != inverse ? hue(place + 0.15F * cell_value(h, 1)) * 0.55F + 0.02F : m.colors[0];
}

vec3 book(const Material& m, vec2 st, vec2 size) {
  const vec2 p = st / size;
  if (std::abs(p.y - 0.12F) < 0.03F || std::abs(p.y - 0.9F) < 0.02F) return m.colors[1];
  const vec2 turned((0.84F - p.y) / 0.64F, (p.x - 0.25F) / 0.5F);  // the title reads downwards
  if (text_line(m.seed, std::floor(4 + 5 * cell_value(m.seed, 4)), turned)) return m.colors[2];
  return m.colors[0] * (0.85F + 0.15F * noise(st / 0.02F, m.seed));
}

vec3 letter(const Material& m, vec2 st, vec2 size) {
  const vec2 p = st / size;
  const vec2 edge = glm::min(p, 1.0F - p);
  if (std::min(edge.x, edge.y) < 0.1F) return m.colors[1];
  return glyph(m.seed, (p - vec2(0.28F, 0.2F)) / vec2(0.44F, 0.6F)) ? m.colors[2] : m.colors[0];
}

vec3 globe(const Material& m, vec2 st, vec2 size) {
  const float longitude = st.x / size.x;
  const float latitude = st.y / size.y;
  const float wrap = std::min(1.0F, 8 * std::min(longitude, 1 - longitude));  // no jump where longitude wraps
  const float height = glm::mix(0.4F, clouds(vec2(longitude * 9, latitude * 5), m.seed), wrap);
  const bool line = std::fmod(longitude * 24, 1.0F) < 0.06F || std::fmod(latitude * 12, 1.0F) < 0.08F;
  const vec3 land = glm::mix(m.colors[1], m.colors[2], glm::clamp((height - 0.5F) * 5, 0.0F, 1.0F));
  return (height > 0.5F ? land : m.colors[0]) * (line ? 0.5F : 1.0F);
}

vec3 sky(const Material& m, vec2 st, vec2 size) {
  const vec2 p = st / size;
  const float block = std::floor(p.x * 11);
  const float roof = 0.12F + 0.3F * unit_float(cell_hash(m.seed, block, 0));
  if (p.y < roof) {
    const vec2 panes = glm::fract(vec2(p.x * 11 * 4, p.y * 26));
    const bool lit = panes.x > 0.35F && panes.y > 0.4F;
    return (lit ? 0.55F : 0.25F) * (0.4F + 0.6F * hue(unit_float(cell_hash(m.seed, block, 1))));
  }
  return glm::mix(m.colors[0], m.colors[1], glm::clamp(2 * clouds(p * vec2(5, 9), m.seed) - 0.6F, 0.0F, 1.0F));
}

vec3 bands(const Material& m, vec2 st) {
  const float zigzag = std::abs(std::fmod(st.x / m.scale, 1.0F) - 0.3F);
  const float level = st.y / m.scale + 0.8F * zigzag;
  const float band = std::floor(level);
  const float pick = unit_float(cell_hash(m.seed, band, 0));
  return level - band < 0.15F ? vec3(0.03F) : m.colors[pick < 0.4F ? 0 : pick < 0.75F ? 1 : 2];
}

vec3 screen(const Material& m, vec2 st, vec2 size) {
  const vec2 p = st / size;
  const vec2 edge = glm::min(st, size - st);
  if (std::min(edge.x, edge.y) < 0.015F) return vec3(0.01F);
  if (p.x < 0.45F && p.y > 0.3F) return landscape(m, vec2(p.x / 0.45F, (p.y - 0.3F) / 0.7F));
  const float row = std::floor(p.y * 13);
  const float length = 0.4F + 0.55F * unit_float(cell_hash(m.seed, row, 3));
  const vec2 line((p.x - 0.48F) / 0.5F, (p.y * 13 - row) / 0.75F);
  const bool ink =
      p.x > 0.48F && line.x < length && text_line(hashed(m.seed, static_cast<std::uint64_t>(row)), 12, line);
  return ink ? m.colors[2] : m.colors[0] * 0.3F;
}

// A row of stones, tiles or bricks, each other row shifted by half a stone: which one, and the place on it in [0, 1]^2.
struct Stone {
  vec2 local;
  std::uint64_t hash;
};
Stone stone_at(vec2 st, vec2 size, std::uint32_t seed) {
  const float row = std::floor(st.y / size.y);
  const float along = st.x / size.x + 0.5F * std::fmod(std::abs(row), 2.0F);
  const float column = std::floor(along);
  return {{along - column, st.y / size.y - row}, cell_hash(seed, column, row)};
}

// Between the first two colours, some of them dyed.
vec3 stone_color(const Material& m, std::uint64_t hash) {
  const vec3 color = glm::mix(m.colors[0], m.colors[1], cell_value(hash, 1)) * (0.75F + 0.4F * cell_value(hash, 2));
  return cell_value(hash, 3) < 0.15F ? glm::mix(color, 0.6F * hue(cell_value(hash, 4)), 0.45F) : color;
}

// Returns how much a mark covers, in [0, 1], at this distance within its rim.
float covered(const Material& m, float depth) {
  if (m.softness <= 0) return depth > 0 ? 1.0F : 0.0F;
  return glm::smoothstep(0.0F, m.softness, depth);
}

vec3 cobbles(const Material& m, vec2 st) {
  const Stone stone = stone_at(st, vec2(m.scale, 0.8F * m.scale), m.seed);
  const vec2 off = 2.0F * glm::abs(stone.local - 0.5F);
  const vec2 squared = off * off;
  const float round = std::sqrt(std::sqrt(glm::dot(squared, squared)));  // 0 in the middle, 1 where stones meet
  const vec3 color = stone_color(m, stone.hash) * (0.85F + 0.15F * noise(st / (0.25F * m.scale), m.seed + 1));
  return glm::mix(m.colors[2], color, covered(m, 0.4F * m.scale * (0.946F - round)));
}

vec3 grass(const Material& m, vec2 st) {
  const vec3 base = glm::mix(m.colors[0], m.colors[1], clouds(st / (1.5F * m.scale), m.seed)) *
                    (0.7F + 0.4F * noise(st / (0.2F * m.scale), m.seed + 3));
  const vec2 grid = st / m.scale;
  const vec2 cell = glm::floor(grid);
  const std::uint64_t h = cell_hash(m.seed + 5, cell.x, cell.y);
  if (cell_value(h, 0) >= 0.5F) return base;
  const vec2 middle(0.25F + 0.5F * cell_value(h, 1), 0.25F + 0.5F * cell_value(h, 2));
  const float depth = m.scale * (0.1F + 0.12F * cell_value(h, 3) - glm::length(grid - cell - middle));
  return glm::mix(base, 0.15F + 0.55F * hue(cell_value(h, 4)), covered(m, depth));
}

vec3 bricks(const Material& m, vec2 st) {
  const vec2 size(m.scale, 0.36F * m.scale);
  const Stone brick = stone_at(st, size, m.seed);
  const vec2 edge = glm::min(brick.local, 1.0F - brick.local) * size;
  const float coarse = 0.8F + 0.2F * noise(st / (0.12F * m.scale), m.seed + 1);
  const float fine = 0.8F + 0.2F * noise(st / (0.03F * m.scale), m.seed + 2);
  const float cover = covered(m, std::min(edge.x, edge.y) - 0.025F * m.scale);
  return glm::mix(m.colors[2], stone_color(m, brick.hash) * coarse, cover) * fine;
}

vec3 shingles(const Material& m, vec2 st) {
  const vec2 size(m.scale, 0.9F * m.scale);
  const Stone tile = stone_at(st, size, m.seed);
  const float aside = std::abs(2 * tile.local.x - 1);
  const float rim = 0.3F * aside * aside + 0.06F;  // the lower edge is round
  const float depth =
      std::min({size.y * (tile.local.y - rim), 0.5F * size.x * (0.94F - aside), size.y * (1 - tile.local.y)});
  return glm::mix(m.colors[2], stone_color(m, tile.hash) * (1.0F - 0.35F * tile.local.y), covered(m, depth));
}

vec3 foliage(const Material& m, vec2 st) {
  vec3 color = m.colors[2] * (0.7F + 0.5F * noise(st / m.scale, m.seed + 1));
  for (std::uint32_t layer = 0; layer < 2; ++layer) {
    const vec2 grid = st / m.scale + 0.37F * static_cast<float>(layer);
    const vec2 cell = glm::floor(grid);
    const std::uint64_t h = cell_hash(m.seed + 11 * layer, cell.x, cell.y);
    const float angle = std::numbers::pi_v<float> * cell_value(h, 1);
    const vec2 local = grid - cell - vec2(0.4F + 0.2F * cell_value(h, 2), 0.4F + 0.2F * cell_value(h, 3));
    const vec2 turned(std::cos(angle) * local.x + std::sin(angle) * local.y,
                      std::cos(angle) * local.y - std::sin(angle) * local.x);
    const float depth = m.scale * (0.9F - glm::length(turned * vec2(2.2F, 4.2F))) / 4.2F;
    const vec3 leaf = glm::mix(m.colors[0], m.colors[1], cell_value(h, 4));
    color = glm::mix(color, leaf * (0.8F + 0.35F * glm::smoothstep(-0.05F, 0.05F, turned.y)), covered(m, depth));
  }
  return color;
}

}  // namespace

vec2 coordinates(const Surface& surface, const vec3& point) {
  const vec3 local = point - surface.origin;
  const float along = glm::dot(local, surface.v);
  if (surface.shape == Shape::plane) return {glm::dot(local, surface.u), along};
  float angle = std::atan2(glm::dot(local, glm::cross(surface.v, surface.u)), glm::dot(local, surface.u));
  if (angle < 0) angle += 2 * std::numbers::pi_v<float>;
  if (surface.shape == Shape::cylinder) return {angle * surface.radius, along};
  const float sine = glm::clamp(along / glm::length(local), -1.0F, 1.0F);
  return {angle * surface.radius, (std::asin(sine) + std::numbers::pi_v<float> / 2) * surface.radius};
}

vec3 normal(const Surface& surface, const vec3& point) {
  if (surface.shape == Shape::plane) return glm::cross(surface.u, surface.v);
  vec3 local = point - surface.origin;
  if (surface.shape == Shape::cylinder) local -= glm::dot(local, surface.v) * surface.v;
  return glm::normalize(local);
}

vec3 pattern_color(const Material& m, const vec2& st, const vec2& size) {
  switch (m.pattern) {
    case Pattern::plain:
      return m.colors[0];
    case Pattern::plaster:
      return plaster(m, st);
    case Pattern::wallpaper:
      return wallpaper(m, st);
    case Pattern::parquet:
      return parquet(m, st);
    case Pattern::tiles:
      return tiles(m, st);
    case Pattern::wood:
      return wood(m, st, size);
    case Pattern::fabric:
      return fabric(m, st);
    case Pattern::rug:
      return rug(m, st, size);
    case Pattern::poster:
      return poster(m, st, size);
    case Pattern::print:
      return print(m, st, size);
    case Pattern::book:
      return book(m, st, size);
    case Pattern::letter:
      return letter(m, st, size);
    case Pattern::globe:
      return globe(m, st, size);
    case Pattern::sky:
      return sky(m, st, size);
    case Pattern::bands:
      return bands(m, st);
    case Pattern::screen:
      return screen(m, st, size);
    case Pattern::cobbles:
      return cobbles(m, st);
    case Pattern::grass:
      return grass(m, st);
    case Pattern::bricks:
      return bricks(m, st);
    case Pattern::shingles:
      return shingles(m, st);
    case Pattern::foliage:
      return foliage(m, st);
  }
  return m.colors[0];
}

vec3 sky_color(const Sky& sky, const vec3& direction) {
  if (direction.z < 0) return glm::mix(sky.horizon, sky.below, std::min(1.0F, -6 * direction.z));
  const vec3 clear = glm::mix(sky.horizon, sky.zenith, std::sqrt(direction.z));
  const vec2 above = vec2(direction) / (direction.z + 0.25F);  // on a vault
  const float cover = glm::clamp(3 * clouds(2.5F * above, sky.seed) - 1.4F, 0.0F, 1.0F);
  return glm::mix(clear, vec3(0.95F), cover * std::min(1.0F, 5 * direction.z));
}

vec3 linear_from_srgb(int red, int green, int blue) {
  const auto linear = [](int value) { return static_cast<float>(lumatlas::linear_from_srgb(value / 255.0)); };
  return {linear(red), linear(green), linear(blue)};
}

std::uint8_t srgb_from_linear(float value) {
  return srgb8_from_linear(static_cast<double>(value));
}

}  // namespace lumatlas::synth
