// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/surface_file.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <span>
#include <utility>

#include "atlas/fade_zones.h"
#include "atlas/images/srgb.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_ranges.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

constexpr AccessorType kWholeNumbers{TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kTriangles{TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 3};
constexpr AccessorType kFlags{TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kNumbers{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kPositions{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3};
constexpr AccessorType kColors{TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4};
constexpr AccessorType kShares{TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4};
constexpr AccessorType kPlaces{TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC2};

std::string out_of(std::uint32_t index, std::size_t count) {
  return std::to_string(index) + " of " + std::to_string(count);
}

// The surface's mesh: every copy gives way to its original.
void leave_out(const std::vector<std::uint32_t>& copies, Mesh& mesh) {
  const std::size_t first = mesh.positions.size() - copies.size();
  mesh.positions.resize(first);
  for (glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      if (face[corner] >= first) face[corner] = copies[face[corner] - first];
    }
  }
}

}  // namespace

SurfaceFile::SurfaceFile(const std::filesystem::path& path)
    : file_(path), lumigraph_(file_.extension(kLumigraphExtension)) {}

bool SurfaceFile::textured() const {
  const auto& attributes = file_.triangles().attributes;
  return attributes.contains(kTexturedColorAttribute) || attributes.contains(kPlaceAttribute);
}

std::vector<std::uint32_t> SurfaceFile::whole_numbers(const char* name) const {
  return file_.values<std::uint32_t>(file_.accessor(lumigraph_, kLumigraphExtension, name), name, kWholeNumbers);
}

Mesh SurfaceFile::written_mesh(std::size_t number) const {
  Mesh mesh;
  mesh.positions = file_.values<glm::vec3>(file_.attribute("POSITION", number), "POSITION", kPositions);
  mesh.faces = file_.values<glm::uvec3>(file_.triangles(number).indices, "indices", kTriangles);
  if (mesh.faces.empty()) file_.refuse("its mesh has no faces");
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.faces[face][corner];
      if (vertex < mesh.positions.size()) continue;
      file_.refuse("face " + std::to_string(face) + " has the vertex " + out_of(vertex, mesh.positions.size()));
    }
  }
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const glm::vec3& p = mesh.positions[vertex];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      file_.refuse("vertex " + std::to_string(vertex) + " has a coordinate that is not finite");
    }
  }
  return mesh;
}

// Returns for each of the last vertices the one that it is a copy of; none without a texture.
std::vector<std::uint32_t> SurfaceFile::copies(const Mesh& written) const {
  if (!lumigraph_.Has("vertexCopies")) return {};
  std::vector<std::uint32_t> copies = whole_numbers("vertexCopies");
  const std::size_t vertices = written.positions.size();
  if (copies.size() > vertices) {
    file_.refuse("vertexCopies has " + std::to_string(copies.size()) + " entries for " + std::to_string(vertices) +
                 " vertices");
  }
  const std::size_t first = vertices - copies.size();
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const std::string what = "vertex " + std::to_string(first + i) + " is a copy of vertex ";
    if (copies[i] >= first) file_.refuse(what + out_of(copies[i], first) + " that are none");
    if (written.positions[copies[i]] != written.positions[first + i]) {
      file_.refuse(what + std::to_string(copies[i]) + ", but lies elsewhere");
    }
  }
  return copies;
}

// Returns for each vertex of a mesh the number of its cell less `first`, in [0, count).
std::vector<CellId> SurfaceFile::cell_of_vertex(std::size_t vertices, std::size_t first, std::size_t count,
                                                std::size_t mesh) const {
  const auto numbers = file_.values<float>(file_.attribute(kCellAttribute, mesh), kCellAttribute, kNumbers);
  if (numbers.size() != vertices) {
    file_.refuse(std::string(kCellAttribute) + " has " + std::to_string(numbers.size()) + " cells for " +
                 std::to_string(vertices) + " vertices");
  }
  const auto least = static_cast<float>(first), end = static_cast<float>(first + count);
  std::vector<CellId> cells;
  cells.reserve(vertices);
  for (const float number : numbers) {
    // Written so that NaN is refused too.
    if (!(number >= least && number < end && number == std::floor(number))) {
      file_.refuse("vertex " + std::to_string(cells.size()) + (mesh == 0 ? "" : " of mesh " + std::to_string(mesh)) +
                   " is in cell " + number_text(number) + " of " + std::to_string(count) +
                   (first == 0 ? "" : " from cell " + std::to_string(first)));
    }
    cells.emplace_back(static_cast<std::uint32_t>(number) - static_cast<std::uint32_t>(first));
  }
  return cells;
}

std::vector<CellId> SurfaceFile::cell_of_face(const Mesh& written, std::size_t first, std::size_t count,
                                              std::size_t mesh) const {
  if (first + count > kMostCells) {
    file_.refuse("has " + std::to_string(first + count) + " cells, must be at most " + std::to_string(kMostCells));
  }
  const std::vector<CellId> of_vertex = cell_of_vertex(written.positions.size(), first, count, mesh);
  std::vector<CellId> cells;
  cells.reserve(written.faces.size());
  for (const glm::uvec3& face : written.faces) {
    const CellId cell = of_vertex[face[0]];
    if (of_vertex[face[1]] != cell || of_vertex[face[2]] != cell) {
      file_.refuse("face " + std::to_string(cells.size()) + " has vertices in cells " + std::to_string(cell) + ", " +
                   std::to_string(of_vertex[face[1]]) + " and " + std::to_string(of_vertex[face[2]]) +
                   ", must be in one");
    }
    cells.push_back(cell);
  }
  return cells;
}

FarPart SurfaceFile::far_part(std::size_t cells) const {
  if (!lumigraph_.Has("far")) return {};
  const GltfFile::Object& far = file_.field(lumigraph_, kLumigraphExtension, "far");
  const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(cells, kMostCells));
  return {file_.whole_number(far, "far", "mesh", 1, 1'000'000), file_.whole_number(far, "far", "cells", 1, most)};
}

FarSphere SurfaceFile::far_sphere(const FarPart& part, std::size_t cells, double cell_size) const {
  if (part.cells == 0) return {};
  FarSphere far;
  far.mesh = written_mesh(part.mesh);
  std::vector<CellId> of_face = cell_of_face(far.mesh, cells - part.cells, part.cells, part.mesh);
  require_no_empty_cell(of_face, cells - part.cells, part.cells);
  far.cells = measure_cells(far.mesh, std::move(of_face), cell_size);
  return far;
}

// `of_face`: for each face the number of its cell less `first`.
void SurfaceFile::require_no_empty_cell(const std::vector<CellId>& of_face, std::size_t first,
                                        std::size_t count) const {
  std::vector<std::uint8_t> used(count, 0);
  for (const CellId cell : of_face) used[cell] = 1;
  const auto empty = std::find(used.begin(), used.end(), 0);
  if (empty == used.end()) return;
  file_.refuse("cell " + std::to_string(first + static_cast<std::size_t>(empty - used.begin())) + " has no faces");
}

// Adds the colours of a mesh to `colors`, without those of the last vertices, which are copies.
void SurfaceFile::add_colors(const char* name, std::size_t mesh, std::size_t vertices, std::size_t copies,
                             std::vector<glm::u8vec3>& colors) const {
  const auto linear = file_.values<glm::u16vec4>(file_.attribute(name, mesh), name, kColors);
  if (linear.size() != vertices) {
    file_.refuse(std::string(name) + " has " + std::to_string(linear.size()) + " colours for " +
                 std::to_string(vertices) + " vertices");
  }
  for (const glm::u16vec4& c : std::span(linear).first(vertices - copies)) {
    colors.emplace_back(srgb8_from_linear(c.r / 65535.0), srgb8_from_linear(c.g / 65535.0),
                        srgb8_from_linear(c.b / 65535.0));
  }
}

std::vector<glm::u8vec3> SurfaceFile::colors(std::size_t vertices, std::size_t copies) const {
  std::vector<glm::u8vec3> colors;
  add_colors(textured() ? kTexturedColorAttribute : kColorAttribute, 0, vertices, copies, colors);
  return colors;
}

std::vector<glm::u8vec3> SurfaceFile::far_colors(std::size_t mesh, std::size_t vertices) const {
  std::vector<glm::u8vec3> colors;
  add_colors(kColorAttribute, mesh, vertices, 0, colors);
  return colors;
}

ReferenceTable SurfaceFile::references(std::size_t own_cells, std::size_t views) const {
  const std::size_t cells = own_cells + guest_cells();
  ReferenceTable table;
  table.offsets = whole_numbers("referenceOffsets");
  if (lumigraph_.Has("references")) {
    const int accessor = file_.accessor(lumigraph_, kLumigraphExtension, "references");
    table.views = file_.values<ViewSlot>(accessor, "references", kWholeNumbers);
  }
  if (table.offsets.size() != cells + 1) {
    file_.refuse("referenceOffsets has " + std::to_string(table.offsets.size()) + " entries, must have " +
                 std::to_string(cells + 1) + " for " + std::to_string(cells) + " cells");
  }
  if (table.offsets.front() != 0 || table.offsets.back() != table.views.size() ||
      !std::is_sorted(table.offsets.begin(), table.offsets.end())) {
    file_.refuse("referenceOffsets do not rise from 0 to the number of references, " +
                 std::to_string(table.views.size()));
  }
  for (std::size_t i = 0; i < table.views.size(); ++i) {
    if (table.views[i] >= views) {
      file_.refuse("reference " + std::to_string(i) + " is to view " + out_of(table.views[i], views));
    }
  }
  require_each_view_once(table, views);
  return table;
}

// A cell could else have many more references than there are views, all of which the renderer looks at in each pixel.
void SurfaceFile::require_each_view_once(const ReferenceTable& table, std::size_t views) const {
  std::vector<std::size_t> last_cell(views, table.offsets.size());  // that refers to each view
  for (CellId cell{0}; cell + 1 < table.offsets.size(); ++cell) {
    for (const std::uint32_t view : table.of_cell(cell)) {
      if (std::exchange(last_cell[view], cell) != cell) continue;
      file_.refuse("cell " + std::to_string(cell) + " refers to view " + std::to_string(view) +
                   " twice, must refer to each view once at most");
    }
  }
}

std::vector<float> SurfaceFile::numbers_of_cells(const char* name, std::size_t cells) const {
  if (!lumigraph_.Has(name)) return {};
  auto numbers = file_.values<float>(file_.accessor(lumigraph_, kLumigraphExtension, name), name, kNumbers);
  if (numbers.size() != cells) {
    file_.refuse(std::string(name) + " has " + std::to_string(numbers.size()) + " entries for " +
                 std::to_string(cells) + " cells");
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (std::isfinite(numbers[cell]) && numbers[cell] >= 0) continue;
    file_.refuse(std::string(name) + " says of cell " + std::to_string(cell) + " " + number_text(numbers[cell]) +
                 ", must be finite and not negative");
  }
  return numbers;
}

std::vector<std::uint8_t> SurfaceFile::cells_seen() const {
  return file_.values<std::uint8_t>(file_.accessor(lumigraph_, kLumigraphExtension, "cellSeen"), "cellSeen", kFlags);
}

ChunkSurface SurfaceFile::surface() const {
  ChunkSurface chunk;
  chunk.mesh = written_mesh();
  const std::vector<double> offset =
      file_.numbers(lumigraph_, kLumigraphExtension, "offset", 3, -kMostOffset, kMostOffset);
  chunk.offset = {offset[0], offset[1], offset[2]};
  const std::size_t all_cells = cells_seen().size();
  chunk.far = far_part(all_cells);
  chunk.near_cells = all_cells - chunk.far.cells;
  chunk.cell_of_face = cell_of_face(chunk.mesh, 0, chunk.near_cells, 0);
  const std::vector<std::uint32_t> left_out = copies(chunk.mesh);
  chunk.written_vertices = chunk.mesh.positions.size();
  chunk.copies = left_out.size();
  leave_out(left_out, chunk.mesh);
  require_no_empty_cell(chunk.cell_of_face, 0, chunk.near_cells);
  move_by_origin(chunk.mesh.positions);
  return chunk;
}

// Positions of a chunk are counted from its origin. Of a model's only surface they are those of the model.
void SurfaceFile::move_by_origin(std::vector<glm::vec3>& positions) const {
  if (!lumigraph_.Has("origin")) return;
  const std::vector<double> origin =
      file_.numbers(lumigraph_, kLumigraphExtension, "origin", 3, -kMostOffset, kMostOffset);
  for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
    for (int axis = 0; axis < 3; ++axis) {
      const double from = origin[static_cast<std::size_t>(axis)];
      if (from == 0) continue;  // the sign of a zero stays
      float& coordinate = positions[vertex][axis];
      coordinate = static_cast<float>(static_cast<double>(coordinate) + from);
      if (!std::isfinite(coordinate)) {
        file_.refuse("vertex " + std::to_string(vertex) + " is too far from 0 with its \"origin\"");
      }
    }
  }
}

std::uint32_t SurfaceFile::guest_cells() const {
  if (!lumigraph_.Has("guestCells")) return 0;
  return file_.whole_number(lumigraph_, kLumigraphExtension, "guestCells", 1, kMostCells);
}

std::vector<std::uint32_t> SurfaceFile::numbers_of_runs(const char* name, std::size_t count) const {
  const std::vector<std::uint32_t> runs = whole_numbers(name);
  if (runs.size() % 2 != 0)
    file_.refuse(std::string(name) + " has " + std::to_string(runs.size()) + " entries, must have pairs");
  std::vector<std::uint32_t> numbers;
  numbers.reserve(count);
  for (std::size_t i = 0; i < runs.size(); i += 2) {
    if (runs[i + 1] > count - numbers.size() || runs[i] > kMostIndex) break;
    for (std::uint32_t k = 0; k < runs[i + 1]; ++k) numbers.push_back(runs[i] + k);
    if (i + 2 == runs.size() && numbers.size() == count) return numbers;
  }
  if (runs.empty() && count == 0) return numbers;
  file_.refuse(std::string(name) + " does not give " + std::to_string(count) + " numbers, of which each is at most " +
               std::to_string(kMostIndex));
}

double SurfaceFile::cell_size(double most) const {
  return file_.number(lumigraph_, kLumigraphExtension, "cellSize", 0, most);
}

std::vector<std::uint8_t> SurfaceFile::resident() const {
  if (!lumigraph_.Has("resident")) return {};
  return file_.values<std::uint8_t>(file_.accessor(lumigraph_, kLumigraphExtension, "resident"), "resident", kFlags);
}

// Returns the image number of the only material's texture.
int SurfaceFile::texture_number() const {
  const tinygltf::Model& file = file_.contents();
  const auto chosen = [&](int number, std::size_t count, const std::string& what) {
    if (number >= 0 && static_cast<std::size_t>(number) < count) return static_cast<std::size_t>(number);
    file_.refuse(what + " " + std::to_string(number) + ", which does not exist");
  };
  const std::size_t material = chosen(file_.triangles().material, file.materials.size(), "its mesh has material");
  const tinygltf::TextureInfo& info = file.materials[material].pbrMetallicRoughness.baseColorTexture;
  const std::size_t texture = chosen(info.index, file.textures.size(), "its material has the base texture");
  if (info.texCoord != 0) {
    file_.refuse("its base texture is placed by TEXCOORD_" + std::to_string(info.texCoord) + ", must be by " +
                 kPlaceAttribute);
  }
  return file.textures[texture].source;
}

std::optional<GltfImage> SurfaceFile::texture(std::size_t vertices) const {
  if (!textured()) return std::nullopt;
  const auto places = file_.values<glm::u16vec2>(file_.attribute(kPlaceAttribute), kPlaceAttribute, kPlaces);
  if (places.size() != vertices) {
    file_.refuse(std::string(kPlaceAttribute) + " has " + std::to_string(places.size()) + " places for " +
                 std::to_string(vertices) + " vertices");
  }
  const int number = texture_number();
  if (number < 0) file_.refuse("its base texture has no image");
  return file_.image(static_cast<std::uint32_t>(number));
}

// Refuses zones that are of no cell: a page reads them. The renderer makes its own.
void SurfaceFile::require_zones(std::size_t own_cells) const {
  const std::size_t cells = own_cells + guest_cells();
  if (!lumigraph_.Has("zoneCells")) return;
  const std::vector<std::uint32_t> zones = whole_numbers("zoneCells");
  constexpr std::size_t kColumns = 1 + kCellsPerZone;
  if (zones.size() % kColumns != 0) {
    file_.refuse("zoneCells has " + std::to_string(zones.size()) + " entries, must have a multiple of " +
                 std::to_string(kColumns));
  }
  const std::size_t count = zones.size() / kColumns;
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const bool may_be_none = i >= 2 * count;
    if (zones[i] < cells || (may_be_none && zones[i] == CellId::none)) continue;
    file_.refuse("zone " + std::to_string(i % count) + " has the cell " + out_of(zones[i], cells));
  }
  for (const std::size_t mesh : {std::size_t{0}, far_part(own_cells).mesh}) require_zones_of_mesh(mesh, count);
}

void SurfaceFile::require_zones_of_mesh(std::size_t mesh, std::size_t zones) const {
  const auto numbers = file_.values<float>(file_.attribute(kZoneAttribute, mesh), kZoneAttribute, kNumbers);
  const auto shares = file_.values<glm::u8vec4>(file_.attribute(kSharesAttribute, mesh), kSharesAttribute, kShares);
  if (numbers.size() != shares.size()) file_.refuse("its vertices have zones without shares");
  const auto end = static_cast<float>(zones);
  const auto wrong = std::find_if(numbers.begin(), numbers.end(),
                                  [&](float zone) { return !(zone >= 0 && zone < end && zone == std::floor(zone)); });
  if (wrong == numbers.end()) return;
  file_.refuse("vertex " + std::to_string(wrong - numbers.begin()) + " is in zone " + number_text(*wrong) + " of " +
               std::to_string(zones));
}

}  // namespace lumatlas
