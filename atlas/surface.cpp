// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/surface.h"

#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

[[noreturn]] void refuse_surface(const std::string& why) {
  throw std::invalid_argument("surface: " + why);
}

void check_cells(const Cells& cells, std::size_t faces) {
  if (cells.cell_of_face.size() != faces) {
    refuse_surface("cells.cell_of_face has " + std::to_string(cells.cell_of_face.size()) +
                   " entries, must have one per face, " + std::to_string(faces));
  }
  for (std::size_t face = 0; face < faces; ++face) {
    if (cells.cell_of_face[face] < cells.cells.size()) continue;
    refuse_surface("cells.cell_of_face[" + std::to_string(face) + "] is " + std::to_string(cells.cell_of_face[face]) +
                   ", must be below the number of cells, " + std::to_string(cells.cells.size()));
  }
}

void check_far(const Surface& surface) {
  const auto require = [](const char* field, std::uint32_t far, std::size_t all) {
    if (far <= all) return;
    refuse_surface(std::string(field) + " is " + std::to_string(far) + ", must be at most " + std::to_string(all));
  };
  require("far_faces", surface.far_faces, surface.mesh.faces.size());
  require("far_vertices", surface.far_vertices, surface.mesh.positions.size());
  require("far_cells", surface.far_cells, surface.cells.cells.size());
  const std::size_t near_vertices = surface.mesh.positions.size() - surface.far_vertices;
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const bool is_far = face >= surface.near_faces();
    bool fits = (surface.cells.cell_of_face[face] >= surface.near_cells()) == is_far;
    for (int corner = 0; corner < 3; ++corner) {
      fits = fits && (surface.mesh.faces[face][corner] >= near_vertices) == is_far;
    }
    if (!fits) refuse_surface("face " + std::to_string(face) + " is both near and far");
  }
}

// Copies the elements from `first` on.
template <typename T>
std::vector<T> tail(const std::vector<T>& all, std::size_t first) {
  return {all.begin() + static_cast<std::ptrdiff_t>(first), all.end()};
}

}  // namespace

void check(const Surface& surface) {
  const Mesh& mesh = surface.mesh;
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.positions.size()) {
    refuse_surface("mesh.colors has " + std::to_string(mesh.colors.size()) + " entries, must have one per vertex, " +
                   std::to_string(mesh.positions.size()) + ", or none");
  }
  check_faces(mesh);
  check_cells(surface.cells, mesh.faces.size());
  check_far(surface);
}

Surface near_surface(const Surface& surface) {
  Surface near = surface;
  near.mesh.faces.resize(surface.near_faces());
  near.mesh.positions.resize(surface.mesh.positions.size() - surface.far_vertices);
  if (!near.mesh.colors.empty()) near.mesh.colors.resize(near.mesh.positions.size());
  near.cells.cells.resize(surface.near_cells());
  near.cells.cell_of_face.resize(surface.near_faces());
  near.far_faces = near.far_vertices = near.far_cells = 0;
  return near;
}

FarSphere far_sphere_of(const Surface& surface) {
  const std::size_t vertices = surface.mesh.positions.size() - surface.far_vertices;
  FarSphere far;
  far.mesh.positions = tail(surface.mesh.positions, vertices);
  if (!surface.mesh.colors.empty()) far.mesh.colors = tail(surface.mesh.colors, vertices);
  far.mesh.faces = tail(surface.mesh.faces, surface.near_faces());
  for (glm::uvec3& face : far.mesh.faces) face -= glm::uvec3(static_cast<std::uint32_t>(vertices));
  far.cells.size = surface.cells.size;
  far.cells.cells = tail(surface.cells.cells, surface.near_cells());
  far.cells.cell_of_face = tail(surface.cells.cell_of_face, surface.near_faces());
  for (CellId& cell : far.cells.cell_of_face) cell = CellId(cell - static_cast<std::uint32_t>(surface.near_cells()));
  return far;
}

Surface with_far_sphere(const Surface& surface, const FarSphere& far) {
  Surface both = near_surface(surface);
  const auto vertices = static_cast<std::uint32_t>(both.mesh.positions.size());
  const auto cells = static_cast<std::uint32_t>(both.cells.cells.size());
  both.far_faces = static_cast<std::uint32_t>(far.mesh.faces.size());
  both.far_vertices = static_cast<std::uint32_t>(far.mesh.positions.size());
  both.far_cells = static_cast<std::uint32_t>(far.cells.cells.size());
  both.mesh.positions.insert(both.mesh.positions.end(), far.mesh.positions.begin(), far.mesh.positions.end());
  if (!both.mesh.colors.empty()) {
    both.mesh.colors.insert(both.mesh.colors.end(), far.mesh.colors.begin(), far.mesh.colors.end());
    both.mesh.colors.resize(both.mesh.positions.size());
  }
  for (const glm::uvec3& face : far.mesh.faces) both.mesh.faces.push_back(face + glm::uvec3(vertices));
  both.cells.cells.insert(both.cells.cells.end(), far.cells.cells.begin(), far.cells.cells.end());
  for (const CellId cell : far.cells.cell_of_face) both.cells.cell_of_face.emplace_back(cell + cells);
  return both;
}

float depth_before_far(const Surface& surface) {
  if (surface.far_vertices == 0) return std::numeric_limits<float>::infinity();
  // The sphere is ten times as far away as the mesh. The depth of a pixel is less than its distance by the cosine of
  // the angle from the camera's axis, which is larger than this up to 83 degrees.
  constexpr float kShare = 0.12F;
  const std::size_t first = surface.mesh.positions.size() - surface.far_vertices;
  return kShare * glm::length(surface.mesh.positions[first]);
}

void leave_out_far(const Surface& surface, VisibilityBuffer& visible) {
  if (surface.far_faces == 0) return;
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    if (visible.face[pixel] == FaceId::none || visible.face[pixel] < surface.near_faces()) continue;
    visible.face[pixel] = FaceId::none;
    visible.depth[pixel] = std::numeric_limits<float>::infinity();
  }
}

}  // namespace lumatlas
