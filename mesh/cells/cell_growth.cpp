// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/cell_growth.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "mesh/base/id.h"
#include "mesh/cells/cluster_mesh.h"
#include "mesh/cells/partitions.h"
#include "mesh/face_corners.h"
#include "mesh/face_geometry.h"
#include "mesh/repair/slivers.h"

namespace lumatlas {

namespace {

[[noreturn]] void refuse(const std::string& complaint) {
  throw std::invalid_argument("cells: " + complaint);
}

std::string text(double value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

void check_before(const Mesh& mesh, const Cells& cells) {
  if (cells.cell_of_face.size() != mesh.faces.size()) {
    refuse("those before have " + std::to_string(cells.cell_of_face.size()) +
           " faces, must have as many as the mesh before, " + std::to_string(mesh.faces.size()));
  }
  std::vector<std::uint32_t> faces(cells.cells.size(), 0);
  for (const CellId cell : cells.cell_of_face) {
    if (cell >= faces.size()) {
      refuse("a face before is in cell " + std::to_string(cell) + " of " + std::to_string(faces.size()) +
             ", must be in one of them");
    }
    ++faces[cell];
  }
  for (std::size_t cell = 0; cell < faces.size(); ++cell) {
    if (cells.cells[cell].faces == faces[cell]) continue;
    refuse("cell " + std::to_string(cell) + " before has " + std::to_string(faces[cell]) + " faces, must have the " +
           std::to_string(cells.cells[cell].faces) + " that were measured");
  }
}

void check_previous(const Mesh& mesh_before, const Mesh& mesh, std::span<const FaceId> previous_face) {
  if (previous_face.size() != mesh.faces.size()) {
    refuse("previous_face has " + std::to_string(previous_face.size()) + " entries, must have one per face, " +
           std::to_string(mesh.faces.size()));
  }
  std::vector<std::uint8_t> named(mesh_before.faces.size(), 0);
  for (std::size_t face = 0; face < previous_face.size(); ++face) {
    const std::uint32_t previous = previous_face[face];
    if (previous == FaceId::none) continue;
    const auto refuse_entry = [&](const std::string& rule) {
      refuse("previous_face[" + std::to_string(face) + "] is " + std::to_string(previous) + ", must " + rule);
    };
    if (previous >= named.size()) refuse_entry("be below the number of faces before, " + std::to_string(named.size()));
    if (named[previous]) refuse_entry("not name a face that an earlier entry names");
    named[previous] = 1;
  }
}

void check_size(const Cells& before, const CellOptions& options) {
  if (!(std::isfinite(before.size) && before.size > 0)) {
    refuse("the size before is " + text(before.size) + ", must be finite and above 0");
  }
  if (options.size != 0 && options.size != before.size) {
    refuse("size is " + text(options.size) + ", must be that of the cells before, " + text(before.size) + ", or 0");
  }
}

// These faces of a mesh, in their order, with the vertices that they use.
Mesh part_of(const Mesh& mesh, std::span<const FaceId> faces) {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> number_of(mesh.positions.size(), kUnused);
  Mesh part;
  part.faces.reserve(faces.size());
  for (const FaceId face : faces) {
    glm::uvec3 corners = mesh.faces[face];
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& number = number_of[corners[corner]];
      if (number == kUnused) {
        number = static_cast<std::uint32_t>(part.positions.size());
        part.positions.push_back(mesh.positions[corners[corner]]);
      }
      corners[corner] = number;
    }
    part.faces.push_back(corners);
  }
  return part;
}

// The faces of cells that touch one of `added`, with those: all that joining these to cells depends on.
std::vector<FaceId> faces_around(const Mesh& mesh, std::span<const FaceId> added, std::span<const std::uint32_t> labels,
                                 std::size_t cells) {
  std::vector<std::uint8_t> touched_vertex(mesh.positions.size(), 0);
  std::vector<std::uint8_t> touched_cell(cells, 0);
  for (const FaceId face : added) {
    for (int corner = 0; corner < 3; ++corner) touched_vertex[mesh.faces[face][corner]] = 1;
    touched_cell[labels[face]] = 1;
  }
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    const glm::uvec3& corners = mesh.faces[face];
    if (touched_vertex[corners.x] || touched_vertex[corners.y] || touched_vertex[corners.z]) {
      touched_cell[labels[face]] = 1;
    }
  }
  std::vector<FaceId> faces;
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    if (touched_cell[labels[face]]) faces.push_back(face);
  }
  return faces;
}

// Gives new cells, those from `first_new` on, to a neighbour where they or it are small.
void join_small(const Mesh& mesh, double size, std::span<const FaceId> added, std::uint32_t first_new,
                std::vector<std::uint32_t>& labels) {
  const std::size_t cells = std::size_t{*std::max_element(labels.begin(), labels.end())} + 1;
  const std::vector<FaceId> faces = faces_around(mesh, added, labels, cells);
  const Mesh part = part_of(mesh, faces);
  std::vector<std::uint32_t> part_labels;
  part_labels.reserve(faces.size());
  for (const FaceId face : faces) part_labels.push_back(labels[face]);
  merge_slivers(ClusterMesh(part, face_geometry(part), size), size, part_labels, first_new);
  for (std::size_t i = 0; i < faces.size(); ++i) labels[faces[i]] = part_labels[i];
}

// Returns for each face the cell before that it belongs to, or for a new cell a label from the number of cells before
// on.
std::vector<std::uint32_t> grown_clusters(const Cells& before, const Mesh& mesh, std::span<const FaceId> previous_face,
                                          double normal_weight) {
  const auto first_new = static_cast<std::uint32_t>(before.cells.size());
  std::vector<std::uint32_t> labels(mesh.faces.size());
  std::vector<FaceId> added;
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    if (previous_face[face] == FaceId::none) {
      added.push_back(face);
    } else {
      labels[face] = before.cell_of_face[previous_face[face]];
    }
  }
  if (added.empty()) return labels;
  const Mesh part = part_of(mesh, added);
  const std::vector<std::uint32_t> clusters = cluster_labels(part, face_geometry(part), before.size, normal_weight);
  for (std::size_t i = 0; i < added.size(); ++i) labels[added[i]] = first_new + clusters[i];
  join_small(mesh, before.size, added, first_new, labels);
  return labels;
}

// The same labels for a grid, where a face's cube alone decides.
std::vector<std::uint32_t> grown_grid(const Mesh& mesh_before, const Cells& before, const Mesh& mesh) {
  Mesh both = mesh_before;
  both.positions.insert(both.positions.end(), mesh.positions.begin(), mesh.positions.end());
  const auto shift = static_cast<std::uint32_t>(mesh_before.positions.size());
  for (const glm::uvec3& face : mesh.faces) both.faces.push_back(face + shift);
  const std::vector<std::uint32_t> cubes = grid_labels(both, before.size);

  constexpr std::uint32_t kNoCube = ~0u;
  std::vector<CellId> cell_of_cube(std::size_t{*std::max_element(cubes.begin(), cubes.end())} + 1, CellId::none);
  std::vector<std::uint32_t> cube_of_cell(before.cells.size(), kNoCube);
  for (std::size_t face = 0; face < mesh_before.faces.size(); ++face) {
    const CellId cell = before.cell_of_face[face];
    if (cell_of_cube[cubes[face]] == CellId::none) cell_of_cube[cubes[face]] = cell;
    if (cube_of_cell[cell] == kNoCube) cube_of_cell[cell] = cubes[face];
    if (cell_of_cube[cubes[face]] == cell && cube_of_cell[cell] == cubes[face]) continue;
    refuse("cell " + std::to_string(cell) + " before is not the faces in one cube of size " + text(before.size) +
           ", must be for a grid");
  }
  std::vector<std::uint32_t> labels(cubes.begin() + static_cast<std::ptrdiff_t>(mesh_before.faces.size()), cubes.end());
  for (std::uint32_t& label : labels) {
    const std::uint32_t cell = cell_of_cube[label];
    label = cell != CellId::none ? cell : static_cast<std::uint32_t>(before.cells.size()) + label;
  }
  return labels;
}

// Numbers the labels in place in the order that CellGrowth promises, and returns its previous_cell.
std::vector<CellId> number_old_first(std::vector<std::uint32_t>& labels, std::size_t cells_before) {
  const std::size_t largest = *std::max_element(labels.begin(), labels.end());
  std::vector<std::uint8_t> occurs(std::max(largest + 1, cells_before), 0);
  for (const std::uint32_t label : labels) occurs[label] = 1;
  std::vector<std::uint32_t> number_of(occurs.size(), CellId::none);
  std::vector<CellId> previous_cell;
  for (CellId cell{0}; cell < cells_before; ++cell) {
    if (!occurs[cell]) continue;
    number_of[cell] = static_cast<std::uint32_t>(previous_cell.size());
    previous_cell.emplace_back(cell);
  }
  for (std::uint32_t& label : labels) {
    if (number_of[label] == CellId::none) {
      number_of[label] = static_cast<std::uint32_t>(previous_cell.size());
      previous_cell.push_back(CellId::none);
    }
    label = number_of[label];
  }
  return previous_cell;
}

// Returns whether a face is where a face before was, with the same turn.
bool is_at_same_place(const Mesh& mesh_before, FaceId before, const Mesh& mesh, FaceId face) {
  const glm::uvec3& then = mesh_before.faces[before];
  const glm::uvec3& now = mesh.faces[face];
  const auto same = [&](int corner) { return mesh_before.positions[then[corner]] == mesh.positions[now[corner]]; };
  return (same(0) && same(1) && same(2)) || face_corners(mesh_before, before) == face_corners(mesh, face);
}

// Returns for each cell how many of its faces it had before, at the same place.
std::vector<std::uint32_t> faces_as_before(const Mesh& mesh_before, const Cells& before, const Mesh& mesh,
                                           std::span<const FaceId> previous_face, const CellGrowth& growth) {
  const std::vector<CellId>& cell_of_face = growth.cells.cell_of_face;
  std::vector<std::uint8_t> stays(mesh.faces.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(stays.size()), 1024),
                    [&](const auto& range) {
                      for (FaceId face{range.begin()}; face < range.end(); ++face) {
                        const FaceId previous = previous_face[face];
                        if (previous == FaceId::none) continue;
                        stays[face] = before.cell_of_face[previous] == growth.previous_cell[cell_of_face[face]] &&
                                      is_at_same_place(mesh_before, previous, mesh, face);
                      }
                    });
  std::vector<std::uint32_t> faces(growth.previous_cell.size(), 0);
  for (std::size_t face = 0; face < stays.size(); ++face) faces[cell_of_face[face]] += stays[face];
  return faces;
}

// Measures the changed cells, and takes the others from before: in another order their faces may add up otherwise.
void measure_changed(const Mesh& mesh, const Cells& before, CellGrowth& growth) {
  constexpr std::uint32_t kUnchanged = ~0u;
  std::vector<std::uint32_t> number(growth.changed.size(), kUnchanged);
  std::uint32_t changed = 0;
  for (std::size_t cell = 0; cell < number.size(); ++cell) {
    if (growth.changed[cell] != 0) number[cell] = changed++;
  }
  std::vector<FaceId> faces;
  std::vector<CellId> cell_of_face;
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    const std::uint32_t cell = number[growth.cells.cell_of_face[face]];
    if (cell == kUnchanged) continue;
    faces.push_back(face);
    cell_of_face.emplace_back(cell);
  }
  const Cells measured = measure_cells(part_of(mesh, faces), std::move(cell_of_face), before.size);
  growth.cells.cells.resize(number.size());
  for (std::size_t cell = 0; cell < number.size(); ++cell) {
    growth.cells.cells[cell] =
        number[cell] == kUnchanged ? before.cells[growth.previous_cell[cell]] : measured.cells[number[cell]];
  }
}

}  // namespace

CellGrowth grow_cells(const Mesh& mesh_before, const Cells& before, const Mesh& mesh,
                      std::span<const FaceId> previous_face, const CellOptions& options) {
  check(options);
  check(mesh_before);
  check(mesh);
  if (mesh.faces.empty()) refuse("the changed mesh has no face, must have at least one");
  check_before(mesh_before, before);
  check_previous(mesh_before, mesh, previous_face);
  CellGrowth growth;
  if (before.cells.empty()) {
    growth.cells = make_cells(mesh, options);
    growth.previous_cell.assign(growth.cells.cells.size(), CellId::none);
    growth.changed.assign(growth.cells.cells.size(), 1);
    return growth;
  }
  check_size(before, options);
  std::vector<std::uint32_t> labels = options.partition == Partition::grid
                                          ? grown_grid(mesh_before, before, mesh)
                                          : grown_clusters(before, mesh, previous_face, options.normal_weight);
  growth.previous_cell = number_old_first(labels, before.cells.size());
  growth.cells.size = before.size;
  growth.cells.cell_of_face = std::vector<CellId>(labels.begin(), labels.end());
  std::vector<std::uint32_t> faces(growth.previous_cell.size(), 0);
  for (const CellId cell : growth.cells.cell_of_face) ++faces[cell];
  const std::vector<std::uint32_t> kept = faces_as_before(mesh_before, before, mesh, previous_face, growth);
  growth.changed.assign(kept.size(), 1);
  for (std::size_t cell = 0; cell < kept.size(); ++cell) {
    const std::uint32_t previous = growth.previous_cell[cell];
    if (previous == CellId::none || kept[cell] != before.cells[previous].faces) continue;
    if (kept[cell] == faces[cell]) growth.changed[cell] = 0;
  }
  measure_changed(mesh, before, growth);
  return growth;
}

}  // namespace lumatlas
