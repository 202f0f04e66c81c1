// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/atlas.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "atlas/tile_choice.h"
#include "atlas/vertex_colors.h"

namespace lumatlas {

namespace {

void require_gain(std::uint32_t slot, const glm::dvec3& gain) {
  for (int channel = 0; channel < 3; ++channel) {
    if (gain[channel] >= kLeastExposureGain && gain[channel] <= kMostExposureGain) continue;
    throw std::invalid_argument("atlas: gain[" + std::to_string(channel) + "] of slot " + std::to_string(slot) +
                                " is " + std::to_string(gain[channel]) + ", must be in [1e-6, 1e6]");
  }
}

void require_previous_cells(std::span<const std::uint32_t> previous_cell, std::size_t cells, std::size_t cells_before) {
  if (previous_cell.size() != cells) {
    throw std::invalid_argument("atlas: previous_cell has " + std::to_string(previous_cell.size()) +
                                " entries, must have one per cell of the new surface, " + std::to_string(cells));
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (previous_cell[cell] < cells_before || previous_cell[cell] == kNoCell) continue;
    throw std::invalid_argument("atlas: previous_cell[" + std::to_string(cell) + "] is " +
                                std::to_string(previous_cell[cell]) + ", must be below the number of cells before, " +
                                std::to_string(cells_before));
  }
}

// By cell of the surface before: which it is now.
std::vector<std::vector<std::uint32_t>> cells_that_were(std::span<const std::uint32_t> previous_cell,
                                                        std::size_t cells_before) {
  std::vector<std::vector<std::uint32_t>> now(cells_before);
  for (std::size_t cell = 0; cell < previous_cell.size(); ++cell) {
    if (previous_cell[cell] != kNoCell) now[previous_cell[cell]].push_back(static_cast<std::uint32_t>(cell));
  }
  return now;
}

std::vector<ShownCell> renumbered(std::span<const ShownCell> shown,
                                  const std::vector<std::vector<std::uint32_t>>& cells_now) {
  std::vector<ShownCell> renumbered;
  for (const ShownCell& part : shown) {
    for (const std::uint32_t cell : cells_now[part.cell]) renumbered.push_back({part.tile, cell, part.pixels});
  }
  std::sort(renumbered.begin(), renumbered.end(),
            [](const ShownCell& a, const ShownCell& b) { return std::tie(a.tile, a.cell) < std::tie(b.tile, b.cell); });
  return renumbered;
}

void require_size(const std::string& view, const char* what, std::uint32_t width, std::uint32_t height,
                  const Camera& camera) {
  if (width == camera.width && height == camera.height) return;
  throw std::invalid_argument("view " + view + ": the " + what + " is " + std::to_string(width) + "x" +
                              std::to_string(height) + ", must be as large as its camera, " +
                              std::to_string(camera.width) + "x" + std::to_string(camera.height));
}

}  // namespace

void require_photograph_of(const std::string& view, const Camera& camera, const Photograph& photograph) {
  require_size(view, "photograph", photograph.width, photograph.height, camera);
}

StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph, VisibilityBuffer visible,
                            const ValidityOptions& options, std::vector<std::uint8_t> trust) {
  require_photograph_of(name, camera, photograph);
  require_size(name, "visibility buffer", visible.width, visible.height, camera);
  StoredView view;
  view.name = std::move(name);
  view.camera = camera;
  view.photograph = std::move(photograph);
  view.depth = std::move(visible.depth);
  view.trust = std::move(trust);
  view.validity = validity_mask(view.photograph, view.depth, view.trust, options);
  view.rim = rim_pixels(view.photograph, view.depth, options);
  return view;
}

TiledView make_tiled_view(std::string name, const Camera& camera, Photograph photograph, VisibilityBuffer visible,
                          const Cells& cells, const TileOptions& layout, const ValidityOptions& options,
                          std::vector<std::uint8_t> trust) {
  const std::vector<std::uint32_t> face = std::move(visible.face);
  TiledView tiled;
  tiled.view =
      make_stored_view(std::move(name), camera, std::move(photograph), std::move(visible), options, std::move(trust));
  tiled.shown = shown_cells(tiled.view, face, cells, layout);
  return tiled;
}

Atlas::Atlas(std::shared_ptr<const Surface> surface, std::uint32_t max_views, const TileOptions& layout)
    : surface_(std::move(surface)),
      layout_(layout),
      views_(max_views),
      gains_(max_views, glm::dvec3(1)),
      references_to_slot_(max_views, 0),
      references_(surface_->cells.cells.size()),
      cell_seen_(surface_->cells.cells.size(), 0),
      shown_(max_views) {
  if (max_views == 0) throw std::invalid_argument("atlas: max_views is 0, must be at least 1");
  if (!layout.whole_views()) tile_slots_.emplace(layout);
}

const Surface& Atlas::surface() const {
  const std::scoped_lock lock(mutex_);
  return *surface_;
}

std::uint32_t Atlas::size() const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::uint32_t>(std::count_if(views_.begin(), views_.end(), [](const auto& view) { return view; }));
}

std::uint32_t Atlas::insert(StoredView view, std::vector<ShownCell> shown) {
  auto stored = std::make_shared<const StoredView>(std::move(view));
  const std::scoped_lock lock(mutex_);
  const auto free_slot = std::find(views_.begin(), views_.end(), nullptr);
  if (free_slot == views_.end()) throw std::logic_error("atlas: insert into a full store");
  *free_slot = std::move(stored);
  const auto slot = static_cast<std::uint32_t>(free_slot - views_.begin());
  shown_[slot] = std::move(shown);
  return slot;
}

void Atlas::replace(std::uint32_t slot, StoredView view, std::vector<ShownCell> shown) {
  auto stored = std::make_shared<const StoredView>(std::move(view));
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  views_[slot].swap(stored);  // so that the old view is freed after the lock
  shown_[slot] = std::move(shown);
}

void Atlas::erase(std::uint32_t slot) {
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  if (references_to_slot_[slot] != 0) {
    throw std::logic_error("atlas: erase of slot " + std::to_string(slot) + ", which " +
                           std::to_string(references_to_slot_[slot]) + " cells refer to");
  }
  views_[slot].reset();
  shown_[slot].clear();
  gains_[slot] = glm::dvec3(1);
}

std::shared_ptr<const StoredView> Atlas::view(std::uint32_t slot) const {
  const std::scoped_lock lock(mutex_);
  return views_.at(slot);
}

void Atlas::set_gain(std::uint32_t slot, const glm::dvec3& gain) {
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  require_gain(slot, gain);
  gains_[slot] = gain;
}

glm::dvec3 Atlas::gain(std::uint32_t slot) const {
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  return gains_[slot];
}

void Atlas::set_references(std::uint32_t cell, std::vector<std::uint32_t> slots) {
  const std::scoped_lock lock(mutex_);
  for (const std::uint32_t slot : slots) require_stored(slot);
  for (const std::uint32_t slot : references_.at(cell)) --references_to_slot_[slot];
  for (const std::uint32_t slot : slots) ++references_to_slot_[slot];
  references_[cell] = std::move(slots);
}

std::vector<std::uint32_t> Atlas::references(std::uint32_t cell) const {
  const std::scoped_lock lock(mutex_);
  return references_.at(cell);
}

void Atlas::mark_seen(std::span<const CellPixels> cells) {
  const std::scoped_lock lock(mutex_);
  for (const CellPixels& seen : cells) cell_seen_.at(seen.cell) = 1;
}

void Atlas::replace_surface(std::shared_ptr<const Surface> surface, std::span<const std::uint32_t> previous_cell) {
  const std::scoped_lock lock(mutex_);
  require_previous_cells(previous_cell, surface->cells.cells.size(), references_.size());
  if (surface->offset != surface_->offset) {
    throw std::invalid_argument("atlas: the new surface has another offset than the one before, must have the same");
  }
  std::vector<std::vector<std::uint32_t>> references(previous_cell.size());
  std::vector<std::uint32_t> references_to_slot(views_.size(), 0);
  std::vector<std::uint8_t> cell_seen(previous_cell.size(), 0);
  for (std::size_t cell = 0; cell < previous_cell.size(); ++cell) {
    if (previous_cell[cell] == kNoCell) continue;
    references[cell] = references_[previous_cell[cell]];
    cell_seen[cell] = cell_seen_[previous_cell[cell]];
    for (const std::uint32_t slot : references[cell]) ++references_to_slot[slot];
  }
  const std::vector<std::vector<std::uint32_t>> cells_now = cells_that_were(previous_cell, references_.size());
  for (std::vector<ShownCell>& shown : shown_) shown = renumbered(shown, cells_now);
  surface_.swap(surface);  // so that the old one is freed after the lock
  references_ = std::move(references);
  references_to_slot_ = std::move(references_to_slot);
  cell_seen_ = std::move(cell_seen);
}

void Atlas::assign_tiles(Snapshot& snapshot) const {
  std::vector<std::uint32_t> tiles_of_view;
  for (const auto& view : views_) {
    tiles_of_view.push_back(view ? TileGrid(view->camera.width, view->camera.height, layout_.tile_px).tiles() : 0);
  }
  std::vector<ViewTile> tiles = needed_tiles(snapshot.references, shown_);
  if (layout_.max_tiles > 0 && tiles.size() > layout_.max_tiles) {
    tiles = choose_tiles(views_, surface_->cells, shown_, layout_.max_tiles, snapshot.references);
  }
  tile_slots_->assign(tiles, tiles_of_view);
  snapshot.tiles = tile_slots_->table();
}

Snapshot Atlas::snapshot() const {
  Snapshot snapshot;
  {
    const std::scoped_lock lock(mutex_);
    snapshot.surface = surface_;
    snapshot.views = views_;
    snapshot.gains = gains_;
    snapshot.cell_seen = cell_seen_;
    for (const std::vector<std::uint32_t>& slots : references_) {
      snapshot.references.views.insert(snapshot.references.views.end(), slots.begin(), slots.end());
      snapshot.references.offsets.push_back(static_cast<std::uint32_t>(snapshot.references.views.size()));
    }
    if (tile_slots_) assign_tiles(snapshot);
  }
  VertexColorMean colors(snapshot.surface->mesh);
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) colors.add(*snapshot.views[slot], snapshot.gains[slot]);
  }
  snapshot.vertex_colors = colors.colors();
  return snapshot;
}

void Atlas::require_stored(std::uint32_t slot) const {
  if (slot >= views_.size() || !views_[slot]) {
    throw std::logic_error("atlas: slot " + std::to_string(slot) + " holds no view");
  }
}

}  // namespace lumatlas
