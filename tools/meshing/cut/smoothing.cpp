// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/smoothing.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lumatlas {
namespace {

constexpr int kRounds = 5;
constexpr double kStep = 0.5;  // share of the way to the middle of the neighbours

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the lesser vertex first

// The edges of a surface. A border edge belongs to one face, and its two vertices are border vertices.
struct Neighbours {
  std::vector<Edge> edges;
  std::vector<bool> is_border;  // one per vertex
};

Neighbours neighbours_of(const TriangleSoup& surface) {
  Neighbours result;
  std::vector<Edge> sides;
  sides.reserve(3 * surface.faces.size());
  for (const glm::uvec3& face : surface.faces) {
    for (int i = 0; i < 3; ++i) sides.emplace_back(std::minmax(face[i], face[(i + 1) % 3]));
  }
  std::sort(sides.begin(), sides.end());
  result.is_border.assign(surface.positions.size(), false);
  for (auto side = sides.begin(); side != sides.end();) {
    const auto next = std::find_if(side, sides.end(), [&](const Edge& other) { return other != *side; });
    if (next - side == 1) {
      result.is_border[side->first] = true;
      result.is_border[side->second] = true;
    }
    result.edges.push_back(*side);
    side = next;
  }
  return result;
}

}  // namespace

void smooth(TriangleSoup& surface, std::span<const float> deviations) {
  if (deviations.size() != surface.positions.size()) {
    throw std::invalid_argument("smooth: there are " + std::to_string(deviations.size()) + " deviations, must be " +
                                std::to_string(surface.positions.size()) + ", one a vertex");
  }
  const std::vector<glm::dvec3> start = surface.positions;
  const Neighbours neighbours = neighbours_of(surface);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<glm::dvec3> sum(start.size(), glm::dvec3(0));
    std::vector<double> count(start.size(), 0);
    for (const auto& [a, b] : neighbours.edges) {
      sum[a] += surface.positions[b];
      sum[b] += surface.positions[a];
      ++count[a];
      ++count[b];
    }
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (neighbours.is_border[i] || count[i] == 0) continue;
      const glm::dvec3 moved = surface.positions[i] + kStep * (sum[i] / count[i] - surface.positions[i]);
      const glm::dvec3 way = moved - start[i];
      const double length = glm::length(way), most = deviations[i];
      surface.positions[i] = length > most ? start[i] + way * (most / length) : moved;
    }
  }
}

}  // namespace lumatlas
