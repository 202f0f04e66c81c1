// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs in tiles: square parts of a stored view, each resident in a slot of a bounded texture array only if the
// references of some cell need it. In place of the whole views of Erat et al. 2019, section 3.4, most of whose texels
// show surface that other views cover better.
//
// A slot holds a tile and around it a gutter of the pixels next to it (held at the image's border), so that filtering
// within a slot gives what filtering in the photograph would. All slots are alike: what comes takes the place of what
// goes, and nothing is ever moved.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/camera.h"
#include "mesh/cells.h"

namespace lumatlas {

struct StoredView;
struct ReferenceTable;

struct TileOptions {
  std::uint32_t tile_px = 64;   // side of a tile without its gutter; a multiple of 8 in [8, 1024]; 0: whole views
  std::uint32_t gutter_px = 2;  // 2 to the number of coarser levels in the array: 1, 2, 4 or 8
  std::uint32_t max_tiles = 0;  // slots of the texture array; 0: as many as are needed

  [[nodiscard]] bool whole_views() const { return tile_px == 0; }
  [[nodiscard]] std::uint32_t slot_px() const { return tile_px + 2 * gutter_px; }
};

inline constexpr TileOptions kWholeViews{0, 4, 0};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const TileOptions& options);

// What a slot takes, bytes: sRGB colour and validity with their coarser levels, and depth in half precision.
[[nodiscard]] std::uint64_t slot_bytes(const TileOptions& options);
// The most slots of a texture array within so many bytes, whole pages of them: see pages_for().
[[nodiscard]] std::uint32_t slots_within(std::uint64_t bytes, const TileOptions& options);

// A texture array's pages, each of columns x rows slots.
struct PageLayout {
  std::uint32_t columns, rows, pages;
};
// For at least that many slots; small pages, so that little is allocated and not used, but no more than `most_pages` as
// long as their sides stay within `most_columns` slots.
[[nodiscard]] PageLayout pages_for(std::uint32_t slots, std::uint32_t most_pages, std::uint32_t most_columns);

// How an image is cut: tiles row by row from the top left, those at the right and at the bottom reaching beyond it.
struct TileGrid {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;

  TileGrid(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t tile_px)
      : columns((width_px + tile_px - 1) / tile_px), rows((height_px + tile_px - 1) / tile_px) {}
  [[nodiscard]] std::uint32_t tiles() const { return columns * rows; }
};

// A cell in a tile of a view: how many pixels of the tile show it and may be used (validity above 0). 0: only the
// gutter does.
struct ShownCell {
  std::uint32_t tile;
  std::uint32_t cell;
  std::uint32_t pixels;
};

// By ascending tile, then cell. `face` is what each pixel of the view shows, as in VisibilityBuffer.
[[nodiscard]] std::vector<ShownCell> shown_cells(const StoredView& view, std::span<const std::uint32_t> face,
                                                 const Cells& cells, const TileOptions& options);

inline constexpr std::uint32_t kNotResident = ~0u;

// Where each tile of each view is in the texture array: the last step from a face to a texel. Tiles of the view in slot
// v of the store are slots[first_tile[v]] up to slots[first_tile[v + 1]], row by row.
struct TileTable {
  TileOptions options;
  std::vector<std::uint32_t> first_tile;  // one more than the store has slots; empty: whole views
  std::vector<std::uint32_t> slots;       // of the texture array, kNotResident: the tile is not there

  [[nodiscard]] bool whole_views() const { return first_tile.empty(); }
  // Whether the tile that holds an image position (pixels from the top left corner, inside the image) is resident.
  [[nodiscard]] bool resident(std::uint32_t view, const Camera& camera, double x, double y) const;
  // One value per pixel of a view: 1 where it is in a resident tile or its gutter.
  [[nodiscard]] std::vector<std::uint8_t> resident_pixels(std::uint32_t view, const Camera& camera) const;
  [[nodiscard]] std::uint32_t resident_tiles() const;
  // Slots that a texture array must have, for each number in `slots` to be one of them.
  [[nodiscard]] std::uint32_t slots_needed() const;
};

struct ViewTile {
  std::uint32_t view;  // slot of the store
  std::uint32_t tile;
};

// Those that show some cell which refers to their view, by ascending view, then tile. `shown` by slot of the store.
[[nodiscard]] std::vector<ViewTile> needed_tiles(const ReferenceTable& references,
                                                 std::span<const std::vector<ShownCell>> shown);

// Gives tiles their slots, and takes them away again, so that a tile that stays resident keeps its slot.
class TileSlots {
 public:
  // Throws std::invalid_argument unless the options pass check() and cut views into tiles.
  explicit TileSlots(const TileOptions& options);

  // Makes those tiles resident and no others; there must not be more than max_tiles (std::logic_error).
  // `tiles_of_view`: how many each slot of the store has, 0: it is free.
  void assign(std::span<const ViewTile> tiles, std::span<const std::uint32_t> tiles_of_view);
  [[nodiscard]] const TileTable& table() const { return table_; }

 private:
  void resize(std::span<const std::uint32_t> tiles_of_view);

  TileTable table_;
  std::vector<std::uint32_t> free_;  // slots below used_, the lowest last
  std::uint32_t used_ = 0;           // slots that were ever given
};

}  // namespace lumatlas
