// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/shapes/furniture.h"

#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace lumatlas::synth {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

std::int32_t Furnisher::oak() {
  return add(Pattern::wood, {linear_from_srgb(196, 152, 100), linear_from_srgb(120, 78, 44), vec3(0.1F)});
}

std::int32_t Furnisher::poster() {
  return add(Pattern::poster, {dye(), dye(), dye()});
}

std::int32_t Furnisher::print_page() {
  return add(Pattern::print, {vec3(0.75F, 0.73F, 0.66F), dye(), dye() * 0.3F}, 0.11F);
}

void Furnisher::legs(dvec2 at, dvec2 size, double height, double thick, std::int32_t material) {
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      const dvec2 inset = size - thick - 0.04;
      Block& leg = box(at + dvec2(x, y) * inset, 0, {thick, thick, height + kSink}, material);
      leg.parts[0].material[5] = kOpen;  // it ends inside the top
    }
  }
}

void Furnisher::book_lying(dvec2 at, double bottom, double yaw) {
  Block& book = box(at, bottom, {0.24, 0.17, 0.035}, matte(vec3(0.7F, 0.68F, 0.6F)), yaw);
  book.parts[0].material[5] = poster();
  book.parts[0].material[2] = matte(dye());
}

void Furnisher::fill_shelf(dvec2 at, double bottom, double half_width, double tallest) {
  double y = -half_width;
  while (y < half_width - 0.12) {
    const double thick = random_.uniform(0.035, 0.09);
    const double high = tallest * random_.uniform(0.65, 0.95);
    if (random_.uniform() < 0.88F) {
      const std::int32_t spine = add(Pattern::book, {dye(), dye(), dye() * 0.3F + 0.5F});
      const std::int32_t cover = matte(scene_.materials.back().colors[0]);
      Block& book = box(at + dvec2(random_.uniform(-0.03, 0.02), y + 0.5 * thick), bottom, {0.2, thick, high}, cover);
      book.parts[0].material[1] = spine;
      book.parts[0].material[5] = matte(vec3(0.7F, 0.68F, 0.6F));
    }
    y += thick + 0.004;
  }
}

void Furnisher::chair(dvec2 at, double yaw) {
  const std::int32_t wood = oak();
  const std::int32_t seat = add(Pattern::fabric, {dye(), dye(), dye()});
  const dvec2 x(std::cos(yaw), std::sin(yaw));
  const dvec2 y(-x.y, x.x);
  for (const double i : {-0.19, 0.19}) {
    for (const double j : {-0.19, 0.19}) {
      box(at + i * x + j * y, 0, {0.04, 0.04, j < 0 ? 0.9 : 0.44}, wood, yaw);
    }
  }
  board(at, 0.42, {0.44, 0.44, 0.06}, seat, yaw);
  board(at - 0.19 * y, 0.62, {0.36, 0.025, 0.22}, wood, yaw);
}

void Furnisher::ceiling_panel(dvec2 at, dvec2 size, double ceiling, const vec3& radiance) {
  const double bottom = ceiling - 0.05;
  const std::int32_t rim = add_metal(vec3(0.7F), 0.2F);
  const std::int32_t glow = add_emission(Pattern::plain, radiance / kLampRadiance, vec3(1.0F), 2);
  Block& panel = board(at, bottom, {size.x, size.y, 0.1}, rim);
  panel.parts[0].material[4] = glow;
  panel.parts[0].material[5] = kOpen;
  const dvec2 low = at - 0.5 * size;
  scene_.lights.push_back({vec3(low.x, low.y, bottom - 0.003),
                           {0, static_cast<float>(size.y), 0},
                           {static_cast<float>(size.x), 0, 0},
                           radiance});
}

void Furnisher::pipe(const dvec3& from, const dvec3& to, double radius, std::int32_t material) {
  constexpr std::uint32_t kSides = 16;
  const dvec3 axis = glm::normalize(to - from);
  const dvec3 helper = std::abs(axis.z) > 0.7 ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
  const dvec3 u = glm::normalize(glm::cross(helper, axis));
  const dvec3 v = glm::cross(axis, u);
  Convex bar;
  ConvexSide start;
  ConvexSide end;
  start.material = end.material = material;
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const dvec3 out = radius * (std::cos(angle) * u + std::sin(angle) * v);
    bar.corners.push_back(out);
    bar.corners.push_back(to - from + out);
    const std::uint32_t next = (i + 1) % kSides;
    bar.sides.push_back({{2 * i, 2 * next, 2 * next + 1, 2 * i + 1}, material});
    end.corners.push_back(2 * i + 1);
    start.corners.push_back(2 * (kSides - 1 - i));
  }
  bar.sides.push_back(start);
  bar.sides.push_back(end);
  convex(bar, from);
}

}  // namespace lumatlas::synth
