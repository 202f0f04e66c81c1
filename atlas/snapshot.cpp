// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/snapshot.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

[[noreturn]] void refuse_snapshot(const std::string& why) {
  throw std::invalid_argument("snapshot: " + why);
}

void require_count(const char* field, std::size_t count, std::size_t expected, const char* of_each) {
  if (count == expected) return;
  refuse_snapshot(std::string(field) + " has " + std::to_string(count) + " entries, must have one per " + of_each +
                  ", " + std::to_string(expected));
}

std::string entry(const char* field, std::size_t index) {
  return std::string(field) + "[" + std::to_string(index) + "]";
}

void check_references(const Snapshot& snapshot) {
  const ReferenceTable& table = snapshot.references;
  const std::size_t cells = snapshot.surface->cells.cells.size();
  if (table.offsets.size() != cells + 1) {
    refuse_snapshot("references.offsets has " + std::to_string(table.offsets.size()) +
                    " entries, must have one more than there are cells, " + std::to_string(cells + 1));
  }
  if (table.offsets.front() != 0 || table.offsets.back() != table.views.size() ||
      !std::is_sorted(table.offsets.begin(), table.offsets.end())) {
    refuse_snapshot("references.offsets must rise from 0 to the number of references, " +
                    std::to_string(table.views.size()));
  }
  for (std::size_t i = 0; i < table.views.size(); ++i) {
    if (table.views[i] < snapshot.views.size() && snapshot.views[table.views[i]]) continue;
    refuse_snapshot(entry("references.views", i) + " is " + std::to_string(table.views[i]) +
                    ", must be a slot with a view");
  }
}

void check_tiles(const Snapshot& snapshot) {
  const TileTable& tiles = snapshot.tiles;
  if (tiles.whole_views()) return;
  check(tiles.options);
  if (tiles.options.whole_views()) refuse_snapshot("tiles.options.tile_px is 0, must be above 0 where there are tiles");
  const std::size_t slots = snapshot.views.size();
  if (tiles.first_tile.size() != slots + 1) {
    refuse_snapshot("tiles.first_tile has " + std::to_string(tiles.first_tile.size()) +
                    " entries, must have one more than views, " + std::to_string(slots + 1));
  }
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const StoredView* const view = snapshot.views[slot].get();
    const std::uint64_t count =
        view ? TileGrid(view->camera.width, view->camera.height, tiles.options.tile_px).tiles() : 0;
    if (tiles.first_tile[slot] + count == tiles.first_tile[slot + 1]) continue;
    refuse_snapshot(entry("tiles.first_tile", slot + 1) + " is " + std::to_string(tiles.first_tile[slot + 1]) +
                    ", must be " + std::to_string(tiles.first_tile[slot] + count) + " for the " +
                    std::to_string(count) + " tiles of slot " + std::to_string(slot));
  }
  if (tiles.first_tile.front() != 0) refuse_snapshot("tiles.first_tile[0] is not 0");
  require_count("tiles.places", tiles.places.size(), tiles.first_tile.back(), "tile");
  for (std::size_t tile = 0; tile < tiles.places.size(); ++tile) {
    const std::uint32_t slot = tiles.places[tile];
    if (slot == TilePlace::none || slot < kMostTilePlaces) continue;
    refuse_snapshot(entry("tiles.places", tile) + " is " + std::to_string(slot) + ", must be below " +
                    std::to_string(kMostTilePlaces) + " or TilePlace::none");
  }
}

void drop_references_to_free_slots(Snapshot& snapshot) {
  ReferenceTable kept;
  kept.offsets.reserve(snapshot.references.offsets.size());
  kept.views.reserve(snapshot.references.views.size());
  for (std::size_t cell = 0; cell + 1 < snapshot.references.offsets.size(); ++cell) {
    for (const ViewSlot slot : snapshot.references.of_cell(cell)) {
      if (snapshot.views[slot]) kept.views.push_back(slot);
    }
    kept.offsets.push_back(static_cast<std::uint32_t>(kept.views.size()));
  }
  snapshot.references = std::move(kept);
}

void drop_tiles_of_free_slots(Snapshot& snapshot) {
  TileTable kept;
  kept.options = snapshot.tiles.options;
  kept.first_tile.push_back(0);
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) {
      const auto places = snapshot.tiles.places.begin();
      kept.places.insert(kept.places.end(), places + snapshot.tiles.first_tile[slot],
                         places + snapshot.tiles.first_tile[slot + 1]);
    }
    kept.first_tile.push_back(static_cast<std::uint32_t>(kept.places.size()));
  }
  snapshot.tiles = std::move(kept);
}

// Checks a table with one number per cell, or none.
void check_numbers_of_cells(const char* table, const std::vector<float>& numbers, std::size_t cells) {
  if (numbers.empty()) return;
  require_count(table, numbers.size(), cells, "cell");
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (std::isfinite(numbers[cell]) && numbers[cell] >= 0) continue;
    refuse_snapshot(entry(table, cell) + " is " + number_text(numbers[cell]) + ", must be finite and not negative");
  }
}

}  // namespace

void check_gains(const Snapshot& snapshot) {
  require_count("gains", snapshot.gains.size(), snapshot.views.size(), "slot of views");
  for (std::size_t slot = 0; slot < snapshot.gains.size(); ++slot) {
    for (int channel = 0; channel < 3; ++channel) {
      const double gain = snapshot.gains[slot][channel];
      if (gain >= kLeastExposureGain && gain <= kMostExposureGain) continue;
      refuse_snapshot(entry("gains", slot) + " has a channel of " + number_text(gain) + ", must be in [1e-6, 1e6]");
    }
  }
}

void check(const Snapshot& snapshot) {
  if (!snapshot.surface) refuse_snapshot("surface is null");
  check(*snapshot.surface);
  check_but_surface(snapshot);
}

void check_but_surface(const Snapshot& snapshot) {
  if (!snapshot.surface) refuse_snapshot("surface is null");
  for (const auto& view : snapshot.views) {
    if (view) check(*view);
  }
  check_gains(snapshot);
  check_references(snapshot);
  require_count("cell_seen", snapshot.cell_seen.size(), snapshot.surface->cells.cells.size(), "cell");
  require_count("vertex_colors", snapshot.vertex_colors.size(), snapshot.surface->mesh.positions.size(), "vertex");
  check_tiles(snapshot);
  check_numbers_of_cells("cell_coverage", snapshot.cell_coverage, snapshot.surface->cells.cells.size());
  check_numbers_of_cells("cell_deviation", snapshot.cell_deviation, snapshot.surface->cells.cells.size());
  if (snapshot.georeference) check(*snapshot.georeference);
}

float median_deviation(const std::vector<float>& cell_deviation) {
  std::vector<float> known;
  std::copy_if(cell_deviation.begin(), cell_deviation.end(), std::back_inserter(known),
               [](float deviation) { return deviation > 0; });
  if (known.empty()) return 0;
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

Snapshot without_far_sphere(const Snapshot& snapshot) {
  if (snapshot.surface->far_faces == 0) return snapshot;
  Snapshot near = snapshot;
  near.surface = std::make_shared<const Surface>(near_surface(*snapshot.surface));
  const std::size_t cells = near.surface->cells.cells.size();
  near.cell_seen.resize(cells);
  near.references.offsets.resize(cells + 1);
  near.references.views.resize(near.references.offsets.back());
  near.vertex_colors = first_of(snapshot.vertex_colors, near.surface->mesh.positions.size());
  if (!near.cell_coverage.empty()) near.cell_coverage.resize(cells);
  if (!near.cell_deviation.empty()) near.cell_deviation.resize(cells);
  return near;
}

void leave_out_views_without_tiles(Snapshot& snapshot) {
  if (snapshot.tiles.whole_views()) return;
  bool left_out = false;
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (snapshot.tiles.has_resident_tile(slot)) continue;
    snapshot.gains[slot] = glm::dvec3(1);
    left_out = left_out || snapshot.tiles.first_tile[slot] != snapshot.tiles.first_tile[slot + 1] ||
               snapshot.views[slot] != nullptr;
    snapshot.views[slot].reset();
  }
  if (!left_out) return;
  drop_references_to_free_slots(snapshot);
  drop_tiles_of_free_slots(snapshot);
}

}  // namespace lumatlas
