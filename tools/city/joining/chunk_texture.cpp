// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/joining/chunk_texture.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "tools/pipeline/surface/baked_texture.h"
#include "tools/texture/layout/texture_layout.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kNotTaken = std::numeric_limits<std::uint32_t>::max();

// Gives what is taken consecutive numbers, in the order in which it is asked for first.
class Renumbering {
 public:
  explicit Renumbering(std::size_t count) : number_(count, kNotTaken) {}

  std::uint32_t operator()(std::uint32_t given) {
    std::uint32_t& number = number_[given];
    if (number == kNotTaken) {
      number = static_cast<std::uint32_t>(taken_.size());
      taken_.push_back(given);
    }
    return number;
  }
  [[nodiscard]] const std::vector<std::uint32_t>& taken() const { return taken_; }

 private:
  std::vector<std::uint32_t> number_, taken_;
};

std::shared_ptr<const Surface> surface_of_cells(const Surface& surface, const std::vector<CellId>& cells,
                                                Renumbering& vertices) {
  std::vector<std::uint32_t> number(surface.near_cells(), kNotTaken);
  for (std::size_t i = 0; i < cells.size(); ++i) number[cells[i]] = static_cast<std::uint32_t>(i);
  Mesh mesh;
  std::vector<CellId> cell_of_face;
  for (std::size_t face = 0; face < surface.near_faces(); ++face) {
    const std::uint32_t cell = number[surface.cells.cell_of_face[face]];
    if (cell == kNotTaken) continue;
    const glm::uvec3& corners = surface.mesh.faces[face];
    const std::uint32_t a = vertices(corners.x), b = vertices(corners.y), c = vertices(corners.z);
    mesh.faces.emplace_back(a, b, c);
    cell_of_face.emplace_back(cell);
  }
  for (const std::uint32_t vertex : vertices.taken()) mesh.positions.push_back(surface.mesh.positions[vertex]);
  auto part = std::make_shared<Surface>();
  part->cells = measure_cells(mesh, std::move(cell_of_face), surface.cells.size);
  part->mesh = std::move(mesh);
  part->offset = surface.offset;
  return part;
}

// Takes the views that the part refers to, with their tiles.
void take_views(const Snapshot& whole, const std::vector<std::uint32_t>& slots, Snapshot& part) {
  part.tiles.options = whole.tiles.options;
  std::uint32_t next = 0;
  for (const std::uint32_t slot : slots) {
    part.views.push_back(whole.views[slot]);
    part.gains.push_back(whole.gains[slot]);
    if (whole.tiles.whole_views()) continue;
    part.tiles.first_tile.push_back(static_cast<std::uint32_t>(part.tiles.places.size()));
    for (std::uint32_t tile = whole.tiles.first_tile[slot]; tile < whole.tiles.first_tile[slot + 1]; ++tile) {
      const bool there = whole.tiles.places[tile] != TilePlace::none;
      part.tiles.places.push_back(there ? TilePlace(next++) : TilePlace::none);
    }
  }
  if (!whole.tiles.whole_views()) {
    part.tiles.first_tile.push_back(static_cast<std::uint32_t>(part.tiles.places.size()));
  }
}

}  // namespace

Snapshot snapshot_of_cells(const Snapshot& snapshot, const std::vector<CellId>& cells) {
  Snapshot part;
  Renumbering vertices(snapshot.surface->mesh.positions.size()), views(snapshot.views.size());
  part.surface = surface_of_cells(*snapshot.surface, cells, vertices);
  for (const CellId cell : cells) {
    for (const ViewSlot slot : snapshot.references.of_cell(cell)) part.references.views.emplace_back(views(slot));
    part.references.offsets.push_back(static_cast<std::uint32_t>(part.references.views.size()));
    part.cell_seen.push_back(snapshot.cell_seen[cell]);
    if (!snapshot.cell_deviation.empty()) part.cell_deviation.push_back(snapshot.cell_deviation[cell]);
  }
  take_views(snapshot, views.taken(), part);
  const std::vector<glm::u8vec3>& all = snapshot.vertex_colors.get();
  std::vector<glm::u8vec3> colors;
  for (const std::uint32_t vertex : vertices.taken()) colors.push_back(all[vertex]);
  part.vertex_colors = std::move(colors);
  return part;
}

std::shared_ptr<const BaseTexture> chunk_texture(const Snapshot& snapshot, const std::vector<CellId>& cells,
                                                 std::uint32_t most_side_px) {
  try {
    return std::make_shared<const BaseTexture>(bake_texture(snapshot_of_cells(snapshot, cells), most_side_px).texture);
  } catch (const ChartsDoNotFit&) {
    return nullptr;
  }
}

}  // namespace lumatlas
