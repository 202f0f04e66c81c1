// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/cells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <stdexcept>

#include "mesh/base/requirement.h"
#include "mesh/cells/partitions.h"
#include "mesh/face_geometry.h"
#include "mesh/scene_extent.h"

namespace lumatlas {

namespace {

constexpr Requirement cells_require{"cells"};

// Numbers the labels that occur by their first face; returns how many there are.
std::uint32_t number_by_first_face(std::vector<std::uint32_t>& labels) {
  constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();
  const std::uint32_t largest = *std::max_element(labels.begin(), labels.end());
  std::vector<std::uint32_t> number_of(static_cast<std::size_t>(largest) + 1, kUnseen);
  std::uint32_t count = 0;
  for (std::uint32_t& label : labels) {
    if (number_of[label] == kUnseen) number_of[label] = count++;
    label = number_of[label];
  }
  return count;
}

std::vector<std::vector<std::uint32_t>> faces_by_cell(const std::vector<CellId>& cell_of_face, std::uint32_t cells) {
  std::vector<std::uint32_t> counts(cells, 0);
  for (const CellId cell : cell_of_face) ++counts[cell];
  std::vector<std::vector<std::uint32_t>> faces(cells);
  for (CellId cell{0}; cell < cells; ++cell) faces[cell].reserve(counts[cell]);
  for (std::uint32_t face = 0; face < cell_of_face.size(); ++face) faces[cell_of_face[face]].push_back(face);
  return faces;
}

std::array<glm::dvec3, 3> corners_of(const Mesh& mesh, std::uint32_t index) {
  const glm::uvec3& face = mesh.faces[index];
  return {glm::dvec3(mesh.positions[face.x]), glm::dvec3(mesh.positions[face.y]), glm::dvec3(mesh.positions[face.z])};
}

// Cell::normal, unless what is left of the normals is rounding.
glm::dvec3 mean_normal(const glm::dvec3& area_weighted_sum, double area) {
  constexpr double kCancelled = 1e-9;
  const double length = glm::length(area_weighted_sum);
  return length > kCancelled * area ? area_weighted_sum / length : glm::dvec3(0);
}

void measure_extent(const Mesh& mesh, std::span<const FaceGeometry> geometry, const std::vector<std::uint32_t>& faces,
                    Cell& cell) {
  const bool has_normal = cell.normal != glm::dvec3(0);
  cell.normal_cone_cos = has_normal ? 1 : -1;
  for (const std::uint32_t face : faces) {
    for (const glm::dvec3& corner : corners_of(mesh, face)) {
      cell.radius = std::max(cell.radius, glm::distance(corner, cell.centroid));
    }
    if (!has_normal) continue;
    cell.normal_cone_cos = std::min(cell.normal_cone_cos, glm::dot(geometry[face].normal, cell.normal));
  }
}

Cell measure(const Mesh& mesh, std::span<const FaceGeometry> geometry, const std::vector<std::uint32_t>& faces) {
  Cell cell;
  cell.faces = static_cast<std::uint32_t>(faces.size());
  glm::dvec3 moment(0), normal(0), sum(0);
  for (const std::uint32_t face : faces) {
    const auto [a, b, c] = corners_of(mesh, face);
    const glm::dvec3 centroid = (a + b + c) / 3.0;
    cell.area += geometry[face].area;
    moment += geometry[face].area * centroid;
    normal += geometry[face].area * geometry[face].normal;
    sum += centroid;
  }
  cell.centroid = cell.area > 0 ? moment / cell.area : sum / static_cast<double>(faces.size());
  cell.normal = mean_normal(normal, cell.area);
  measure_extent(mesh, geometry, faces, cell);
  return cell;
}

// Throws unless cells are numbered from 0 without gaps.
std::vector<std::vector<std::uint32_t>> checked_faces_by_cell(const std::vector<CellId>& cell_of_face) {
  const std::uint32_t last = *std::max_element(cell_of_face.begin(), cell_of_face.end());
  if (last >= cell_of_face.size()) {
    throw std::invalid_argument("cells: a face is in cell " + std::to_string(last) + " of a mesh with " +
                                std::to_string(cell_of_face.size()) + " faces, cells must be numbered without gaps");
  }
  auto faces = faces_by_cell(cell_of_face, last + 1);
  const auto empty = std::find_if(faces.begin(), faces.end(), [](const auto& members) { return members.empty(); });
  if (empty != faces.end()) {
    throw std::invalid_argument("cells: cell " + std::to_string(empty - faces.begin()) +
                                " has no face, cells must be numbered without gaps");
  }
  return faces;
}

Cells measured(const Mesh& mesh, std::span<const FaceGeometry> geometry, std::vector<CellId> cell_of_face,
               double size) {
  Cells result;
  result.size = size;
  result.cell_of_face = std::move(cell_of_face);
  if (mesh.faces.empty()) return result;
  const auto faces = checked_faces_by_cell(result.cell_of_face);
  result.cells.resize(faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, faces.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) result.cells[i] = measure(mesh, geometry, faces[i]);
  });
  return result;
}

double size_of_diameter(double diameter) {
  constexpr double kCellsAcross = 60;
  return diameter / kCellsAcross;
}

double size_for(const Mesh& mesh, std::span<const FaceGeometry> geometry, const CellOptions& options) {
  if (options.size > 0) return options.size;
  std::vector<double> areas;
  areas.reserve(geometry.size());
  for (const FaceGeometry& face : geometry) areas.push_back(face.area);
  const double size = size_of_diameter(scene_extent(mesh, areas).diameter);
  if (!(size > 0)) {
    throw std::invalid_argument("mesh: its faces have no area, must have some for an automatic cell size");
  }
  return size;
}

}  // namespace

void check(const CellOptions& options) {
  cells_require(std::isfinite(options.size) && options.size >= 0, "size", options.size, "finite and not negative");
  cells_require(std::isfinite(options.normal_weight) && options.normal_weight >= 0, "normal_weight",
                options.normal_weight, "finite and not negative");
}

double automatic_cell_size(const Mesh& mesh) {
  return size_of_diameter(scene_diameter(mesh));
}

Cells measure_cells(const Mesh& mesh, std::vector<CellId> cell_of_face, double size) {
  check(mesh);
  cells_require(std::isfinite(size) && size >= 0, "size", size, "finite and not negative");
  if (cell_of_face.size() != mesh.faces.size()) {
    throw std::invalid_argument("cells: cell_of_face has " + std::to_string(cell_of_face.size()) +
                                " entries, must have one per face, " + std::to_string(mesh.faces.size()));
  }
  return measured(mesh, face_geometry(mesh), std::move(cell_of_face), size);
}

Cells make_cells(const Mesh& mesh, const CellOptions& options, const CancelCheck& cancel_check) {
  check(options);
  check(mesh);
  const std::vector<FaceGeometry> geometry = face_geometry(mesh);
  if (mesh.faces.empty()) return measured(mesh, geometry, {}, options.size);
  const double size = size_for(mesh, geometry, options);
  std::vector<std::uint32_t> labels = options.partition == Partition::grid
                                          ? grid_labels(mesh, size)
                                          : cluster_labels(mesh, geometry, size, options.normal_weight, cancel_check);
  number_by_first_face(labels);
  return measured(mesh, geometry, {labels.begin(), labels.end()}, size);
}

}  // namespace lumatlas
