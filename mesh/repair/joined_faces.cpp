// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/joined_faces.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace lumatlas {

std::vector<glm::uvec3> joined_faces(const Mesh& mesh) {
  check_faces(mesh);
  const std::vector<glm::vec3>& places = mesh.positions;
  std::vector<std::uint32_t> order(places.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(places[a].x, places[a].y, places[a].z, a) < std::tie(places[b].x, places[b].y, places[b].z, b);
  });
  std::vector<std::uint32_t> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && places[order[i]] == places[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  std::vector<glm::uvec3> faces;
  faces.reserve(mesh.faces.size());
  for (const glm::uvec3& face : mesh.faces) faces.emplace_back(first[face.x], first[face.y], first[face.z]);
  return faces;
}

}  // namespace lumatlas
