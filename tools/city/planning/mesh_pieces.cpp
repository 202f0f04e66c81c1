// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/planning/mesh_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "mesh/repair/simplification.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

glm::vec3 middle_of(const Mesh& mesh, std::uint32_t face) {
  const glm::uvec3& corners = mesh.faces[face];
  return (mesh.positions[corners.x] + mesh.positions[corners.y] + mesh.positions[corners.z]) / 3.0f;
}

int longest_axis(const Mesh& mesh, std::span<const std::uint32_t> faces) {
  glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
  for (const std::uint32_t face : faces) {
    const glm::vec3 middle = middle_of(mesh, face);
    low = glm::min(low, middle);
    high = glm::max(high, middle);
  }
  const glm::vec3 extent = high - low;
  int axis = extent.y > extent.x ? 1 : 0;
  if (extent.z > extent[axis]) axis = 2;
  return axis;
}

void cut(const Mesh& mesh, std::span<std::uint32_t> faces, std::size_t most_faces,
         const std::function<void(const std::vector<std::uint32_t>& faces)>& use) {
  throw_if_interrupted();
  if (faces.size() <= std::max<std::size_t>(1, most_faces)) {
    std::vector<std::uint32_t> part(faces.begin(), faces.end());
    std::sort(part.begin(), part.end());
    use(part);
    return;
  }
  const int axis = longest_axis(mesh, faces);
  const auto half = static_cast<std::ptrdiff_t>(faces.size() / 2);
  std::nth_element(faces.begin(), faces.begin() + half, faces.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float at_a = middle_of(mesh, a)[axis], at_b = middle_of(mesh, b)[axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  cut(mesh, faces.first(static_cast<std::size_t>(half)), most_faces, use);
  cut(mesh, faces.subspan(static_cast<std::size_t>(half)), most_faces, use);
}

// Returns the triangles with float positions less `offset`, and no face with a corner that is not finite.
Mesh around(TriangleSoup soup, const glm::dvec3& offset) {
  Mesh mesh;
  mesh.positions.reserve(soup.positions.size());
  for (const glm::dvec3& position : soup.positions) mesh.positions.emplace_back(position - offset);
  soup.positions = {};
  mesh.faces = std::move(soup.faces);
  const auto is_finite = [&](std::uint32_t vertex) {
    const glm::vec3& p = mesh.positions[vertex];
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  std::erase_if(mesh.faces,
                [&](const glm::uvec3& face) { return !is_finite(face.x) || !is_finite(face.y) || !is_finite(face.z); });
  return mesh;
}

TriangleSoup soup_of(const Mesh& mesh) {
  TriangleSoup soup;
  soup.positions.assign(mesh.positions.begin(), mesh.positions.end());
  soup.faces = mesh.faces;
  return soup;
}

// Returns no face where repair leaves none.
Mesh repaired(const Mesh& mesh) {
  try {
    return repair(soup_of(mesh), {}, throw_if_interrupted).mesh;
  } catch (const InputError&) {
    return {};
  }
}

void append(const Mesh& from, Mesh& to) {
  const auto first = static_cast<std::uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
  for (const glm::uvec3& face : from.faces) to.faces.push_back(face + first);
}

}  // namespace

void cut_faces(const Mesh& mesh, std::size_t most_faces,
               const std::function<void(const std::vector<std::uint32_t>& faces)>& use) {
  std::vector<std::uint32_t> faces(mesh.faces.size());
  std::iota(faces.begin(), faces.end(), 0u);
  cut(mesh, faces, most_faces, use);
}

Mesh mesh_of_faces(const Mesh& mesh, const std::vector<std::uint32_t>& faces) {
  std::vector<std::uint32_t> vertices;
  vertices.reserve(3 * faces.size());
  for (const std::uint32_t face : faces) {
    for (int corner = 0; corner < 3; ++corner) vertices.push_back(mesh.faces[face][corner]);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto number = [&](std::uint32_t vertex) {
    return static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), vertex) - vertices.begin());
  };
  Mesh part;
  for (const std::uint32_t vertex : vertices) part.positions.push_back(mesh.positions[vertex]);
  for (const std::uint32_t face : faces) {
    const glm::uvec3& corners = mesh.faces[face];
    part.faces.emplace_back(number(corners.x), number(corners.y), number(corners.z));
  }
  return part;
}

Mesh read_ply_mesh(const fs::path& file) {
  const TriangleSoup soup = read_triangle_soup(file);
  Mesh mesh;
  mesh.positions.reserve(soup.positions.size());
  for (const glm::dvec3& position : soup.positions) mesh.positions.emplace_back(position);
  mesh.faces = soup.faces;
  return mesh;
}

MeshPieces::MeshPieces(SoupInput input, std::size_t most_faces, std::size_t coarse_faces, fs::path folder)
    : folder_(std::move(folder)), facts_(std::move(input.facts)), offset_(scene_origin(input.soup)) {
  const Mesh mesh = around(std::move(input.soup), offset_);
  const double share = std::min(
      1.0, static_cast<double>(coarse_faces) / static_cast<double>(std::max<std::size_t>(1, mesh.faces.size())));
  cut_faces(mesh, most_faces, [&](const std::vector<std::uint32_t>& faces) {
    const Mesh piece = repaired(mesh_of_faces(mesh, faces));
    if (piece.faces.empty()) return;
    files_.push_back(folder_ / ("piece-" + std::to_string(files_.size()) + ".ply"));
    write_ply(files_.back(), piece);
    SimplificationBound bound;
    bound.faces = static_cast<std::size_t>(share * static_cast<double>(piece.faces.size()));
    append(share < 1 ? simplified(piece, bound).mesh : piece, coarse_);
  });
  if (files_.empty()) throw InputError(facts_.mesh_file.string() + ": has no face that can be used");
  if (const auto strays = stray_faces_warning(coarse_, offset_, facts_.mesh_file)) facts_.warnings.push_back(*strays);
}

Mesh MeshPieces::read(std::size_t piece) const {
  return read_ply_mesh(files_[piece]);
}

}  // namespace lumatlas
