// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: makes a store's snapshots, each from the one before and what has changed since.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "atlas/colors/vertex_colors.h"
#include "atlas/snapshot.h"
#include "atlas/tiles/tile_policy.h"

namespace lumatlas {

// The view slots that one cell refers to. Never null; a change replaces the whole list.
using SharedSlots = std::shared_ptr<const std::vector<ViewSlot>>;

struct CellReferences {
  CellId cell;
  SharedSlots slots;
};

// A store at one moment, as far as its last snapshot does not know it.
struct StoreChanges {
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;  // one per view slot
  std::vector<SharedShownCells> shown;                   // one per view slot
  std::vector<glm::dvec3> gains;                         // one per view slot
  std::vector<std::uint64_t> tenants;  // one per view slot; another number for each view that was inserted
  bool all_cells = false;              // the fields below have every cell; else those that changed
  std::vector<CellReferences> references;
  std::vector<CellId> seen;  // cells
  bool choose_tiles_anew = false;
};

class SnapshotMaker {
 public:
  // `policy` may be empty.
  SnapshotMaker(const TileOptions& layout, TilePolicy policy);

  // The first changes must be of all cells. Throws std::logic_error where tiles must be chosen but there is no policy,
  // or it chose what it must not, and whatever the policy throws. After any exception this object is of no use.
  [[nodiscard]] Snapshot snapshot(StoreChanges changes);

  // Bounds the tiles from the next snapshot on, which chooses them anew; with whole views it changes nothing.
  void set_tile_limit(std::uint32_t max_tiles);

 private:
  void follow(StoreChanges& changes);
  void follow_cells(StoreChanges& changes, std::vector<std::uint8_t>& view_changed);
  void flatten_references();
  [[nodiscard]] std::vector<std::uint32_t> needed_tiles(ViewSlot slot) const;
  void make_tiles_resident(Snapshot& snapshot);
  [[nodiscard]] TileChoice chosen_tiles() const;

  TileOptions layout_;
  TilePolicy policy_;
  StoreChanges store_;                              // its lists of changes are empty
  std::vector<SharedSlots> references_;             // one per cell
  std::vector<std::uint8_t> cell_seen_;             // one per cell
  ReferenceTable table_;                            // made from references_
  std::vector<std::vector<std::uint32_t>> needed_;  // one per view slot: the tiles that the references need
  std::vector<ViewTile> resident_;                  // in the last snapshot, of views that are still there
  std::optional<TilePlaces> places_;                // none: whole views
  std::shared_ptr<VertexColors> colors_;            // shared with snapshots whose colours are not made yet
};

}  // namespace lumatlas
