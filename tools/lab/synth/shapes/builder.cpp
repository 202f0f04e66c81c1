// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/shapes/builder.h"

#include <glm/glm.hpp>
#include <numbers>
#include <utility>

namespace lumatlas::synth {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

std::int32_t SceneBuilder::add(Material material) {
  material.seed = static_cast<std::uint32_t>(random_.next());
  scene_.materials.push_back(material);
  return static_cast<std::int32_t>(scene_.materials.size() - 1);
}

std::int32_t SceneBuilder::add(Pattern pattern, const Colors& colors, float scale) {
  Material material;
  material.pattern = pattern;
  material.colors = colors;
  material.scale = scale;
  return add(material);
}

std::int32_t SceneBuilder::add_glossy(Pattern pattern, const Colors& colors, float scale, float gloss) {
  const std::int32_t id = add(pattern, colors, scale);
  scene_.materials.back().gloss = gloss;
  scene_.materials.back().roughness = 0.03F;
  return id;
}

std::int32_t SceneBuilder::add_metal(const vec3& tint, float roughness) {
  const std::int32_t id = matte(tint);
  scene_.materials.back().metal = true;
  scene_.materials.back().roughness = roughness;
  return id;
}

std::int32_t SceneBuilder::matte(const vec3& color) {
  return add(Pattern::plain, {color, color, color});
}

std::int32_t SceneBuilder::add_emission(Pattern pattern, const vec3& a, const vec3& b, float emission) {
  const std::int32_t id = add(pattern, {a, b, b});
  scene_.materials.back().emission = emission;
  return id;
}

vec3 SceneBuilder::dye() {  // a lively colour, not too dark
  const auto level = [&] { return static_cast<int>(random_.uniform(40, 225)); };
  const int red = level();
  const int green = level();
  return linear_from_srgb(red, green, level());
}

vec3 SceneBuilder::tone(int red, int green, int blue) {
  const auto more = [&] { return static_cast<int>(random_.below(16)); };
  const int r = red + more();
  const int g = green + more();
  return linear_from_srgb(r, g, blue + more());
}

Block& SceneBuilder::box(dvec2 middle, double bottom, dvec3 size, std::int32_t material, double yaw) {
  Block block;
  block.origin = dvec3(middle, bottom - kSink);
  block.yaw = yaw;
  const dvec3 half(0.5 * size.x, 0.5 * size.y, 0);
  BlockPart part{-half, half + dvec3(0, 0, size.z + kSink), {}};
  part.material.fill(material);
  part.material[4] = kOpen;
  block.parts.push_back(part);
  scene_.solids.emplace_back(block);
  return std::get<Block>(scene_.solids.back());
}

Block& SceneBuilder::board(dvec2 middle, double bottom, dvec3 size, std::int32_t material, double yaw) {
  Block& block = box(middle, bottom + kSink, size - dvec3(0, 0, kSink), material, yaw);
  block.parts[0].material[4] = material;
  return block;
}

void SceneBuilder::hang(dvec3 at, dvec2 size, int side, std::int32_t picture, std::int32_t frame) {
  const double depth = 0.03;
  const bool along_y = side / 2 == 0;
  const dvec3 extent = along_y ? dvec3(2 * depth, size.x, size.y) : dvec3(size.x, 2 * depth, size.y);
  Block& block = board({at.x, at.y}, at.z - 0.5 * size.y, extent, frame);
  block.parts[0].material[side] = picture;
  block.parts[0].material[side ^ 1] = kOpen;  // half of the depth is in the wall
}

void SceneBuilder::cylinder(dvec2 middle, double bottom, double radius, double height, std::int32_t side,
                            std::int32_t top) {
  scene_.solids.emplace_back(Cylinder{dvec3(middle, bottom - kSink), radius, height + kSink, side, kOpen, top});
}

void SceneBuilder::sphere(dvec3 center, double radius, std::int32_t material) {
  scene_.solids.emplace_back(Sphere{center, radius, material});
}

void SceneBuilder::convex(Convex body, dvec3 origin, double yaw) {
  body.origin = origin;
  body.yaw = yaw;
  scene_.solids.emplace_back(std::move(body));
}

void SceneBuilder::convex_of(Convex body, dvec3 origin, Pattern pattern, const Colors& colors, float scale,
                             float softness) {
  for (ConvexSide& side : body.sides) {
    if (side.material == kOpen) continue;
    side.material = add(pattern, colors, scale);
    scene_.materials.back().softness = softness;
  }
  convex(std::move(body), origin);
}

void SceneBuilder::sun(const dvec3& toward, double wide, const vec3& light) {
  constexpr double kFar = 300;  // scene units: nearly the same direction everywhere
  const double side = kFar * wide;
  const dvec3 u = glm::normalize(glm::cross(dvec3(0, 0, 1), toward));
  const dvec3 v = glm::cross(u, toward);  // cross(u, v) is away from the sun
  const dvec3 corner = kFar * toward - 0.5 * side * (u + v);
  const double radiance = std::numbers::pi / (wide * wide);
  scene_.lights.push_back({corner, side * u, side * v, static_cast<float>(radiance) * light});
}

}  // namespace lumatlas::synth
