// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <stdexcept>
#include <string>

#include "mesh/finite.h"

namespace lumatlas {

namespace {

// The lowest index in [0, count) for which `is_wrong` holds; `count` if there is none.
template <typename Predicate>
std::size_t first_wrong(std::size_t count, const Predicate& is_wrong) {
  const auto search = [&](const tbb::blocked_range<std::size_t>& range, std::size_t found) {
    for (std::size_t i = range.begin(); i < range.end() && i < found; ++i) {
      if (is_wrong(i)) return i;
    }
    return found;
  };
  return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, count, 1 << 16), count, search,
                              [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

std::uint32_t largest_corner(const glm::uvec3& face) {
  return std::max({face.x, face.y, face.z});
}

void check_faces(const char* what, std::size_t vertices, const std::vector<glm::uvec3>& faces) {
  const std::size_t wrong =
      first_wrong(faces.size(), [&](std::size_t i) { return largest_corner(faces[i]) >= vertices; });
  if (wrong == faces.size()) return;
  throw std::invalid_argument(std::string(what) + ".faces[" + std::to_string(wrong) + "] refers to vertex " +
                              std::to_string(largest_corner(faces[wrong])) + "; it must be below " +
                              std::to_string(vertices));
}

void check_count(const char* field, std::size_t count) {
  constexpr std::size_t kMost = 500'000'000;  // OpenMesh numbers halfedges, six for a vertex, as int
  if (count <= kMost) return;
  throw std::invalid_argument("mesh." + std::string(field) + " has " + std::to_string(count) +
                              " entries; it must have at most " + std::to_string(kMost));
}

void check_finite(const std::vector<glm::vec3>& positions) {
  const auto is_wrong = [&](std::size_t i) { return !is_finite(positions[i]); };
  const std::size_t wrong = first_wrong(positions.size(), is_wrong);
  if (wrong == positions.size()) return;
  const glm::vec3& p = positions[wrong];
  throw std::invalid_argument("mesh.positions[" + std::to_string(wrong) + "] is (" + std::to_string(p.x) + ", " +
                              std::to_string(p.y) + ", " + std::to_string(p.z) + "); it must be finite");
}

template <typename Positions>
Bounds bounds_of(const char* what, const Positions& positions, const std::vector<glm::uvec3>& faces) {
  check_faces(what, positions.size(), faces);
  Bounds box;
  if (faces.empty()) return box;
  box.min = box.max = glm::dvec3(positions[faces[0].x]);
  for (const glm::uvec3& face : faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(positions[face[corner]]);
      box.min = glm::min(box.min, position);
      box.max = glm::max(box.max, position);
    }
  }
  return box;
}

}  // namespace

void check_faces(const Mesh& mesh) {
  check_faces("mesh", mesh.positions.size(), mesh.faces);
}

void check(const Mesh& mesh) {
  check_count("positions", mesh.positions.size());
  check_count("faces", mesh.faces.size());
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.positions.size()) {
    throw std::invalid_argument("mesh.colors has " + std::to_string(mesh.colors.size()) +
                                " entries; it must be empty or have one per position (" +
                                std::to_string(mesh.positions.size()) + ")");
  }
  check_faces(mesh);
  check_finite(mesh.positions);
}

Bounds with(const Bounds& box, const glm::dvec3& point) {
  if (box.empty()) return {point, point};
  return {glm::min(box.min, point), glm::max(box.max, point)};
}

Bounds with(const Bounds& box, const Bounds& other) {
  return other.empty() ? box : with(with(box, other.min), other.max);
}

Bounds bounds(const TriangleSoup& soup) {
  return bounds_of("soup", soup.positions, soup.faces);
}
Bounds bounds(const Mesh& mesh) {
  return bounds_of("mesh", mesh.positions, mesh.faces);
}

}  // namespace lumatlas
