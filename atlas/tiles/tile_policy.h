// SPDX-License-Identifier: GPL-3.0-or-later
// A store asks this policy which tiles to keep where its texture array does not hold all tiles that the references
// need. The store only knows how tiles come and go; the planner decides which are worth their place, see
// planner/tile_choice.h.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "atlas/reference_table.h"
#include "atlas/surface.h"
#include "atlas/tiles/tiles.h"
#include "atlas/views/stored_view.h"

namespace lumatlas {

// The store as it was at one moment. No thread changes it while a policy looks at it.
struct TileDemand {
  const Surface& surface;
  std::span<const std::shared_ptr<const StoredView>> views;  // one per view slot; null: the slot is free
  std::span<const SharedShownCells> shown;                   // one per view slot; never null
  const ReferenceTable& references;                          // each cell's references to view slots that hold a view
  std::size_t max_tiles;                                     // >= 1
  // Tiles of these views that were resident in the snapshot before, by ascending view, then tile. Empty: they are to be
  // chosen from all.
  std::span<const ViewTile> resident;
};

struct TileChoice {
  std::vector<ViewTile> tiles;  // at most max_tiles, by ascending view, then tile, each of a stored view
  ReferenceTable references;    // each cell's references to views whose tiles here show it; no more than it had
};

// Must give the same for the same demand. Called by one thread at a time, while snapshot(), set_tile_limit() and
// retile() of the store wait: where the policy calls one of these on the same thread, that throws std::logic_error,
// and it must not wait for another thread that does. All other calls of the store are free to it.
using TilePolicy = std::function<TileChoice(const TileDemand&)>;

}  // namespace lumatlas
