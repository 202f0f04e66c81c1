// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gpu_bytes.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/tiles/texel_format.h"
#include "blend/gl/gl_objects.h"
#include "blend/gl/photograph_array.h"
#include "blend/tables/drawn_zones.h"
#include "blend/tables/fade_zone_shares.h"
#include "blend/tables/view_table.h"
#include "blend/tables/zone_mesh.h"

namespace lumatlas {

namespace {

// Entries of the table of tiles.
std::size_t tile_entries(std::span<const Camera> views, const TileOptions& layout) {
  if (layout.whole_views()) return views.size();
  std::size_t tiles = 0;
  for (const Camera& view : views) tiles += TileGrid(view.width, view.height, layout.tile_px).tiles();
  return tiles;
}

// The numbers of views are in a uniform block if they fit, else in a table.
std::uint64_t views_bytes(std::size_t views) {
  const std::size_t texels = kViewTexels * views;
  return texels <= kBlockTexels ? kBlockTexels * kVectors.entry_bytes : table_bytes(kVectors, texels);
}

ArrayShape shape_of(std::span<const Camera> views, const TileOptions& layout, std::uint32_t resident_tiles) {
  return layout.whole_views() ? layers_shape(views, layout) : tiles_shape(resident_tiles, layout, ArrayLimits{});
}

}  // namespace

GpuByteCount::GpuByteCount(std::shared_ptr<const Surface> surface, double border_width)
    : surface_(std::move(surface)), border_width_(border_width) {
  if (!surface_) throw std::invalid_argument("GPU bytes: there is no surface");
  shares_ = std::make_shared<const CellShares>(share_cells(*surface_, border_width * surface_->cells.size));
}

GpuBytes GpuByteCount::of(const ReferenceTable& references, std::span<const Camera> views, const TileOptions& layout,
                          std::uint32_t resident_tiles) const {
  check(layout);
  const std::size_t cells = surface_->cells.cells.size();
  if (references.offsets.size() != cells + 1) {
    throw std::invalid_argument("GPU bytes: references are of " + std::to_string(references.offsets.size()) +
                                " offsets, must be one more than the surface's " + std::to_string(cells) + " cells");
  }
  ZoneOptions options;
  options.border_width = border_width_;
  if (border_width_ > 0) options.stands_for = first_of_same_references(references);
  options.shares = shares_;
  const MadeZones made = make_zones(surface_, options, nullptr);
  const ZoneReferences lists = zone_references(made.zones->cells, references, std::vector<std::uint8_t>(cells), {});
  const ZoneMesh mesh = made.mesh.value_or(ZoneMesh());
  GpuBytes bytes;
  bytes.mesh = buffer_bytes(mesh.positions) + buffer_bytes(mesh.faces);
  bytes.vertices =
      buffer_bytes(sizeof(glm::u8vec3) * mesh.positions.size()) + buffer_bytes(mesh.shares) + buffer_bytes(mesh.zones);
  bytes.tables = table_bytes(kRecords, lists.zones.size()) + table_bytes(kRecords, lists.cells.size()) +
                 table_bytes(kPairs, lists.references.size()) + views_bytes(views.size()) +
                 table_bytes(kNumbers, tile_entries(views, layout));
  const ArrayShape shape = shape_of(views, layout, resident_tiles);
  bytes.depth = shape.depth_bytes();
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    bytes.colors += color_bytes(shape.format, shape.texels(level));
    bytes.masks += validity_bytes(shape.format, shape.texels(level));
  }
  return bytes;
}

GpuBytes GpuByteCount::of(const ReferenceTable& references, std::span<const Camera> views,
                          const TileTable& tiles) const {
  if (!tiles.whole_views()) return of(references, views, tiles.options, tiles.resident_tiles());
  return of(references, views, TileOptions{0, tiles.options.gutter_px, 0, tiles.options.texels}, 0);
}

GpuBytes GpuByteCount::of(const Snapshot& snapshot) const {
  std::vector<Camera> views;
  for (const auto& view : snapshot.views) {
    if (view) views.push_back(view->camera);
  }
  return of(snapshot.references, views, snapshot.tiles);
}

std::uint64_t GpuByteCount::of_surface() const {
  ReferenceTable none;
  none.offsets.assign(surface_->cells.cells.size() + 1, 0);
  const GpuBytes bytes = of(none, {}, TileOptions{}, 0);
  return bytes.sum() - bytes.photographs();
}

}  // namespace lumatlas
