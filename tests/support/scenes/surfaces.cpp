// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/scenes/surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "mesh/repair/repair.h"

namespace lumatlas {

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::array<Edge, 3> edges_of(const glm::uvec3& face) {
  return {{{face.x, face.y}, {face.y, face.z}, {face.z, face.x}}};
}

glm::dvec3 area_vector(const Mesh& mesh, const glm::uvec3& face) {
  const glm::dvec3 a(mesh.positions[face.x]);
  return glm::cross(glm::dvec3(mesh.positions[face.y]) - a, glm::dvec3(mesh.positions[face.z]) - a) / 2.0;
}

std::map<Edge, int> directed_edges(const Mesh& mesh) {
  std::map<Edge, int> uses;
  for (const glm::uvec3& face : mesh.faces) {
    for (const Edge& edge : edges_of(face)) ++uses[edge];
  }
  return uses;
}

bool shares_edge_at(std::uint32_t vertex, const glm::uvec3& a, const glm::uvec3& b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) shared += a[i] == b[j] && a[i] != vertex;
  }
  return shared > 0;
}

// `faces` all have the vertex.
bool hang_together(const Mesh& mesh, std::uint32_t vertex, std::vector<std::uint32_t> faces) {
  std::vector<std::uint32_t> reached{faces.back()};
  faces.pop_back();
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const auto touches = [&](std::uint32_t face) {
      return shares_edge_at(vertex, mesh.faces[reached[i]], mesh.faces[face]);
    };
    const auto first = std::partition(faces.begin(), faces.end(), [&](std::uint32_t face) { return !touches(face); });
    reached.insert(reached.end(), first, faces.end());
    faces.erase(first, faces.end());
  }
  return faces.empty();
}

Mesh octahedron() {
  Mesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

Mesh split_in_four(const Mesh& mesh) {
  Mesh fine{mesh.positions, {}, {}};
  std::map<Edge, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(fine.positions.size()));
    if (is_new) fine.positions.push_back(glm::normalize(mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  for (const glm::uvec3& f : mesh.faces) {
    const glm::uvec3 m{middle(f.x, f.y), middle(f.y, f.z), middle(f.z, f.x)};
    fine.faces.insert(fine.faces.end(), {{f.x, m.x, m.z}, {m.x, f.y, m.y}, {m.z, m.y, f.z}, m});
  }
  return fine;
}

// A unit square plane, carried to origin + x * u + y * v; faces u x v.
Mesh side_of_box(std::uint32_t quads, const glm::vec3& origin, const glm::vec3& u, const glm::vec3& v) {
  Mesh mesh = plane(quads, 1);
  mesh.colors.clear();
  for (glm::vec3& p : mesh.positions) p = origin + p.x * u + p.y * v;
  return mesh;
}

}  // namespace

Mesh plane(std::uint32_t quads, float side) {
  Mesh mesh;
  const float steps = static_cast<float>(quads);
  for (std::uint32_t j = 0; j <= quads; ++j) {
    for (std::uint32_t i = 0; i <= quads; ++i) {
      const glm::vec3 at(static_cast<float>(i) / steps, static_cast<float>(j) / steps, 0);
      mesh.positions.push_back(side * at);
      mesh.colors.emplace_back(std::lround(255 * at.x), std::lround(255 * at.y), 0);
    }
  }
  for (std::uint32_t j = 0; j < quads; ++j) {
    for (std::uint32_t i = 0; i < quads; ++i) {
      const std::uint32_t a = j * (quads + 1) + i;
      const std::uint32_t c = a + quads + 2;
      mesh.faces.insert(mesh.faces.end(), {{a, a + 1, c}, {a, c, c - 1}});
    }
  }
  return mesh;
}

Mesh sphere(int levels) {
  Mesh mesh = octahedron();
  for (int level = 0; level < levels; ++level) mesh = split_in_four(mesh);
  return mesh;
}

Mesh box(std::uint32_t quads, const glm::vec3& extent) {
  const glm::vec3 x(extent.x, 0, 0);
  const glm::vec3 y(0, extent.y, 0);
  const glm::vec3 z(0, 0, extent.z);
  Mesh mesh = joined(side_of_box(quads, {}, y, x), side_of_box(quads, z, x, y));
  mesh = joined(mesh, joined(side_of_box(quads, {}, z, y), side_of_box(quads, x, y, z)));
  mesh = joined(mesh, joined(side_of_box(quads, {}, x, z), side_of_box(quads, y, z, x)));
  return repair(to_soup(mesh), glm::dvec3(0)).mesh;  // merges the sides' edges
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  mesh.colors.insert(mesh.colors.end(), b.colors.begin(), b.colors.end());
  if (mesh.colors.size() != mesh.positions.size()) mesh.colors.clear();  // only one has colours
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  for (const glm::uvec3& face : b.faces) mesh.faces.push_back(face + first);
  return mesh;
}

Mesh moved(Mesh mesh, const glm::vec3& by) {
  for (glm::vec3& p : mesh.positions) p += by;
  return mesh;
}

Mesh turned_inside_out(Mesh mesh) {
  for (glm::uvec3& face : mesh.faces) std::swap(face.y, face.z);
  return mesh;
}

TriangleSoup to_soup(const Mesh& mesh) {
  return {{mesh.positions.begin(), mesh.positions.end()}, mesh.colors, mesh.faces};
}

double area_of(const Mesh& mesh) {
  return std::accumulate(mesh.faces.begin(), mesh.faces.end(), 0.0, [&](double sum, const glm::uvec3& face) {
    return sum + glm::length(area_vector(mesh, face));
  });
}

double volume_of(const Mesh& mesh) {
  return std::accumulate(mesh.faces.begin(), mesh.faces.end(), 0.0, [&](double sum, const glm::uvec3& face) {
    return sum + glm::dot(area_vector(mesh, face), glm::dvec3(mesh.positions[face.x])) / 3;
  });
}

double longest_edge_of(const Mesh& mesh) {
  double longest = 0;
  for (const glm::uvec3& face : mesh.faces) {
    for (const auto& [a, b] : edges_of(face)) {
      longest = std::max(longest, glm::distance(glm::dvec3(mesh.positions[a]), glm::dvec3(mesh.positions[b])));
    }
  }
  return longest;
}

bool is_manifold_and_oriented(const Mesh& mesh) {
  for (const auto& [edge, uses] : directed_edges(mesh)) {
    if (uses > 1) return false;
  }
  std::vector<std::vector<std::uint32_t>> around(mesh.positions.size());
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) around[mesh.faces[face][corner]].push_back(face);
  }
  for (std::uint32_t vertex = 0; vertex < around.size(); ++vertex) {
    if (around[vertex].empty() || !hang_together(mesh, vertex, around[vertex])) return false;
  }
  return true;
}

std::size_t boundary_edges(const Mesh& mesh) {
  const std::map<Edge, int> uses = directed_edges(mesh);
  return std::count_if(uses.begin(), uses.end(), [&](const auto& use) {
    return !uses.contains({use.first.second, use.first.first});
  });
}

}  // namespace lumatlas
