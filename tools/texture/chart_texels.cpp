// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/chart_texels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace lumatlas {

namespace {

using glm::dvec2;

double cross(const dvec2& a, const dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// Shares of the second and third corner in the place of a triangle that is nearest to a point, and its distance.
ChartTexel nearest_place(const std::array<dvec2, 3>& corners, const dvec2& point) {
  const dvec2 ab = corners[1] - corners[0], ac = corners[2] - corners[0], ap = point - corners[0];
  const double area = cross(ab, ac);
  if (area != 0) {
    const double b = cross(ap, ac) / area, c = cross(ab, ap) / area;
    if (b >= 0 && c >= 0 && b + c <= 1) return {0, static_cast<float>(b), static_cast<float>(c), 0};
  }
  ChartTexel best;
  best.distance = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    const dvec2 edge = corners[next] - corners[i];
    const double length = glm::dot(edge, edge);
    const double t = length > 0 ? std::clamp(glm::dot(point - corners[i], edge) / length, 0.0, 1.0) : 0;
    const auto distance = static_cast<float>(glm::distance(point, corners[i] + t * edge));
    if (distance >= best.distance) continue;
    std::array<double, 3> shares{};
    shares[i] = 1 - t;
    shares[next] = t;
    best = {0, static_cast<float>(shares[1]), static_cast<float>(shares[2]), distance};
  }
  // A place on an edge is not in the face: at equal distance one that is inside another face wins.
  best.distance = std::max(best.distance, 1e-6f);
  return best;
}

}  // namespace

std::vector<ChartTexel> chart_texels(const Mesh& mesh, const Chart& chart, const ChartPlace& place,
                                     const TextureLayout& layout) {
  std::vector<ChartTexel> texels(std::size_t{place.width} * place.height);
  for (const std::uint32_t face : chart.faces) {
    std::array<dvec2, 3> corners;
    dvec2 low(place.width, place.height), high(0);
    for (int c = 0; c < 3; ++c) {
      const dvec2 at = layout.in_rectangle(chart, place, glm::dvec3(mesh.positions[mesh.faces[face][c]]));
      corners[static_cast<std::size_t>(c)] = at;
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    const auto first = [](double v) { return static_cast<std::uint32_t>(std::max(0.0, v - ChartTexel::kReach)); };
    const auto last = [](double v, std::uint32_t size) {
      return std::min(size, static_cast<std::uint32_t>(std::max(0.0, v + ChartTexel::kReach + 1)));
    };
    for (std::uint32_t y = first(low.y); y < last(high.y, place.height); ++y) {
      for (std::uint32_t x = first(low.x); x < last(high.x, place.width); ++x) {
        ChartTexel& texel = texels[std::size_t{y} * place.width + x];
        if (texel.face != ChartTexel::kNoFaceHere && texel.distance == 0) continue;
        ChartTexel found = nearest_place(corners, {x + 0.5, y + 0.5});
        if (found.distance > ChartTexel::kReach) continue;
        if (texel.face != ChartTexel::kNoFaceHere && texel.distance <= found.distance) continue;
        found.face = face;
        texel = found;
      }
    }
  }
  return texels;
}

}  // namespace lumatlas
