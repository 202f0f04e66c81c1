// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/snapshot_maker.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

namespace lumatlas {

namespace {

bool contains(const std::vector<ViewSlot>& slots, ViewSlot slot) {
  return std::find(slots.begin(), slots.end(), slot) != slots.end();
}

// Marks the slots that are in one list only.
void mark_difference(const std::vector<ViewSlot>& before, const std::vector<ViewSlot>& now,
                     std::vector<std::uint8_t>& marks) {
  for (const ViewSlot slot : before)
    if (!contains(now, slot)) marks[slot] = 1;
  for (const ViewSlot slot : now)
    if (!contains(before, slot)) marks[slot] = 1;
}

void require_choice(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error("atlas: its tile policy " + what);
}

void check_choice(const TileChoice& choice, const TileDemand& demand) {
  require_choice(choice.tiles.size() <= demand.max_tiles, "chose " + std::to_string(choice.tiles.size()) +
                                                              " tiles, at most " + std::to_string(demand.max_tiles) +
                                                              " can be resident");
  const std::vector<std::uint32_t>& offsets = choice.references.offsets;
  require_choice(offsets.size() == demand.references.offsets.size() && offsets.front() == 0 &&
                     offsets.back() == choice.references.views.size() && std::is_sorted(offsets.begin(), offsets.end()),
                 "gave references that are not those of every cell");
  for (const ViewSlot slot : choice.references.views) {
    require_choice(slot < demand.views.size() && demand.views[slot] != nullptr,
                   "gave a reference to slot " + std::to_string(slot) + ", which holds no view");
  }
}

}  // namespace

SnapshotMaker::SnapshotMaker(const TileOptions& layout, TilePolicy policy)
    : layout_(layout), policy_(std::move(policy)), colors_(std::make_shared<VertexColors>()) {
  if (!layout.whole_views()) places_.emplace(layout);
}

void SnapshotMaker::set_tile_limit(std::uint32_t max_tiles) {
  if (!places_) return;
  TileOptions layout = layout_;
  layout.max_tiles = max_tiles;
  places_ = TilePlaces(layout);
  layout_ = layout;
  resident_.clear();
}

void SnapshotMaker::follow_cells(StoreChanges& changes, std::vector<std::uint8_t>& view_changed) {
  if (changes.all_cells) {
    references_.assign(changes.surface->cells.cells.size(), nullptr);
    cell_seen_.assign(references_.size(), 0);
    std::fill(view_changed.begin(), view_changed.end(), std::uint8_t{1});
  }
  for (CellReferences& changed : changes.references) {
    if (!changes.all_cells) mark_difference(*references_[changed.cell], *changed.slots, view_changed);
    references_[changed.cell] = std::move(changed.slots);
  }
  for (const CellId cell : changes.seen) cell_seen_[cell] = 1;
  if (changes.all_cells || !changes.references.empty()) flatten_references();
}

void SnapshotMaker::follow(StoreChanges& changes) {
  const std::size_t slots = changes.views.size();
  std::vector<std::uint8_t> view_changed(slots, 0);
  follow_cells(changes, view_changed);
  std::erase_if(resident_, [&](const ViewTile& tile) {
    return changes.choose_tiles_anew || !changes.views[tile.view] ||
           changes.tenants[tile.view] != store_.tenants[tile.view];
  });
  needed_.resize(slots);
  for (ViewSlot slot{0}; slot < slots; ++slot) {
    if (store_.shown.size() != slots || store_.shown[slot] != changes.shown[slot]) view_changed[slot] = 1;
  }
  store_ = std::move(changes);
  store_.references.clear();
  store_.seen.clear();
  if (!places_) return;
  for (ViewSlot slot{0}; slot < slots; ++slot) {
    if (view_changed[slot] != 0) needed_[slot] = needed_tiles(slot);
  }
}

void SnapshotMaker::flatten_references() {
  table_.offsets.assign(1, 0);
  table_.views.clear();
  for (const SharedSlots& slots : references_) {
    table_.views.insert(table_.views.end(), slots->begin(), slots->end());
    table_.offsets.push_back(static_cast<std::uint32_t>(table_.views.size()));
  }
}

// The tiles that show some cell which refers to their view, in ascending order.
std::vector<std::uint32_t> SnapshotMaker::needed_tiles(ViewSlot slot) const {
  std::vector<std::uint32_t> needed;
  for (const ShownCell& part : *store_.shown[slot]) {
    if (!needed.empty() && needed.back() == part.tile) continue;
    if (contains(*references_[part.cell], slot)) needed.push_back(part.tile);
  }
  return needed;
}

TileChoice SnapshotMaker::chosen_tiles() const {
  if (!policy_) {
    throw std::logic_error("atlas: the references need more than the " + std::to_string(layout_.max_tiles) +
                           " tiles of its layout, and it was given no policy to choose by");
  }
  const TileDemand demand{*store_.surface, store_.views, store_.shown, table_, layout_.max_tiles, resident_};
  TileChoice choice = policy_(demand);
  check_choice(choice, demand);
  return choice;
}

void SnapshotMaker::make_tiles_resident(Snapshot& snapshot) {
  std::vector<ViewTile> tiles;
  for (ViewSlot slot{0}; slot < needed_.size(); ++slot) {
    for (const std::uint32_t tile : needed_[slot]) tiles.push_back({slot, tile});
  }
  if (layout_.max_tiles > 0 && tiles.size() > layout_.max_tiles) {
    TileChoice choice = chosen_tiles();
    tiles = std::move(choice.tiles);
    snapshot.references = std::move(choice.references);
  }
  std::vector<std::uint32_t> tiles_of_view;
  for (const auto& view : store_.views) {
    tiles_of_view.push_back(view ? TileGrid(view->camera.width, view->camera.height, layout_.tile_px).tiles() : 0);
  }
  places_->assign(tiles, tiles_of_view);
  snapshot.tiles = places_->table();
  resident_ = std::move(tiles);
}

Snapshot SnapshotMaker::snapshot(StoreChanges changes) {
  follow(changes);
  Snapshot snapshot;
  snapshot.surface = store_.surface;
  snapshot.views = store_.views;
  snapshot.gains = store_.gains;
  snapshot.cell_seen = cell_seen_;
  snapshot.references = table_;
  if (places_) make_tiles_resident(snapshot);
  // Whole views in blocks have the levels of kWholeViews, as a file that is read has them.
  if (!places_ && layout_.texels != TexelFormat::rgb8) {
    snapshot.tiles.options = {0, kWholeViews.gutter_px, 0, layout_.texels};
  }
  snapshot.vertex_colors = {store_.surface->mesh.positions.size(),
                            [colors = colors_, surface = store_.surface, views = store_.views, gains = store_.gains] {
                              return colors->of(surface, views, gains);
                            }};
  leave_out_views_without_tiles(snapshot);
  store_.views.clear();  // a photograph that leaves the store is not to be kept alive from here
  return snapshot;
}

}  // namespace lumatlas
