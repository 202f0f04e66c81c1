// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: makes a store's snapshots, each from the one before and what has changed since.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "atlas/snapshot.h"
#include "atlas/tiles/tile_policy.h"
#include "atlas/vertex_colors.h"

namespace lumatlas {

// The slots that one cell refers to. Never null; whoever changes them puts another list in its place.
using SharedSlots = std::shared_ptr<const std::vector<std::uint32_t>>;

struct CellReferences {
  std::uint32_t cell;
  SharedSlots slots;
};

// A store at one moment, as far as its last snapshot does not know it.
struct StoreChanges {
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;  // by slot
  std::vector<SharedShownCells> shown;                   // by slot
  std::vector<glm::dvec3> gains;                         // by slot
  std::vector<std::uint64_t> tenants;                    // by slot, another number for each view that was inserted
  bool all_cells = false;                                // what follows is of every cell; else of those that changed
  std::vector<CellReferences> references;
  std::vector<std::uint32_t> seen;  // cells
  bool choose_tiles_anew = false;
};

class SnapshotMaker {
 public:
  // `policy` may be empty.
  SnapshotMaker(const TileOptions& layout, TilePolicy policy);

  // The first changes must be of all cells. Throws std::logic_error where tiles must be chosen but there is no policy,
  // or it chose what it must not, and whatever the policy throws. After any exception this object is of no use.
  [[nodiscard]] Snapshot snapshot(StoreChanges changes);

  // From the next snapshot on, whose tiles are chosen from all; with whole views it changes nothing.
  void bound_tiles(std::uint32_t max_tiles);

 private:
  void follow(StoreChanges& changes);
  void follow_cells(StoreChanges& changes, std::vector<std::uint8_t>& view_changed);
  void flatten_references();
  [[nodiscard]] std::vector<std::uint32_t> needed_tiles(std::uint32_t slot) const;
  void make_tiles_resident(Snapshot& snapshot);
  [[nodiscard]] TileChoice chosen_tiles() const;

  TileOptions layout_;
  TilePolicy policy_;
  StoreChanges store_;                              // its lists of changes are empty
  std::vector<SharedSlots> references_;             // by cell
  std::vector<std::uint8_t> cell_seen_;             // by cell
  ReferenceTable table_;                            // of references_
  std::vector<std::vector<std::uint32_t>> needed_;  // by slot, the tiles that the references need
  std::vector<ViewTile> resident_;                  // in the last snapshot, of views that are still there
  std::optional<TileSlots> slots_;                  // none: whole views
  VertexColors colors_;
};

}  // namespace lumatlas
