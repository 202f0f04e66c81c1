// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs in tiles: square parts of a stored view, each resident in a tile place of a bounded texture array only if
// the references of some cell need it. In place of the whole views of Erat et al. 2019, section 3.4, most of whose
// texels show surface that other views cover better.
//
// A tile place holds a tile and around it a gutter of the pixels next to it; beyond the image's border the pixels at
// the border are repeated. So filtering within a tile place gives what filtering in the photograph would. All tile
// places are alike: what comes takes the place of what goes, and nothing is ever moved.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "atlas/reference_table.h"
#include "atlas/tiles/texel_format.h"
#include "atlas/views/stored_view.h"
#include "mesh/base/id.h"
#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"

namespace lumatlas {

// Larger than any texture array: this many tiles of the smallest size take a hundred gigabytes.
inline constexpr std::uint32_t kMostTilePlaces = 1u << 30;

struct TileOptions {
  std::uint32_t tile_px = 64;   // side of a tile without its gutter; a multiple of 8 in [8, 1024]; 0: whole views
  std::uint32_t gutter_px = 2;  // 1, 2, 4 or 8: see levels_of()
  std::uint32_t max_tiles = 0;  // tile places in the texture array; 0: as many as are needed
  // bc7 needs a gutter of at least 2, and of 8 a tile_px that is a multiple of 16: so all levels of a tile place, and
  // of the tile in it, are whole blocks.
  TexelFormat texels = TexelFormat::rgb8;

  [[nodiscard]] bool whole_views() const { return tile_px == 0; }
  [[nodiscard]] std::uint32_t place_px() const { return tile_px + 2 * gutter_px; }
};

inline constexpr TileOptions kWholeViews{0, 4, 0};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const TileOptions& options);

// Levels of a photograph in the array, the finest among them: as many as the gutter has a pixel for, of compressed
// texels two.
[[nodiscard]] std::uint32_t levels_of(const TileOptions& options);

// Returns the bytes of one tile place, in the format of atlas/tiles/texel_format.h with its coarser levels.
[[nodiscard]] std::uint64_t place_bytes(const TileOptions& options);
// Returns how many tile places a texture array within `bytes` has at most, in whole pages: see pages_for(). Throws
// std::invalid_argument unless the options pass check() and cut views into tiles.
[[nodiscard]] std::uint32_t places_within(std::uint64_t bytes, const TileOptions& options);

// A texture array's pages, each of columns x rows tile places.
struct PageLayout {
  std::uint32_t columns, rows, pages;
};
// Returns the pages for at least `places` tile places. Pages are small, so that few places stay unused, but there are
// no more than `most_pages` as long as their sides stay within `most_columns` tile places. Both must be at least 1
// (std::invalid_argument).
[[nodiscard]] PageLayout pages_for(std::uint32_t places, std::uint32_t most_pages, std::uint32_t most_columns);

// An image cut into tiles, row by row from the top left; those at the right and at the bottom reach beyond it.
// `tile_px` must not be 0 (std::invalid_argument).
struct TileGrid {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;

  TileGrid(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t tile_px);
  [[nodiscard]] std::uint32_t tiles() const { return columns * rows; }
};

// A cell in a tile of a view: how many pixels of the tile show it and may be used (validity above 0). With 0 pixels it
// is the tile's gutter alone that shows the cell.
struct ShownCell {
  std::uint32_t tile;
  CellId cell;
  std::uint32_t pixels;
};

using SharedShownCells = std::shared_ptr<const std::vector<ShownCell>>;

// Returns which cells each tile of a view shows, by ascending tile, then cell; nothing for whole views.
// `face` is what each pixel of the view shows, as in VisibilityBuffer. Throws std::invalid_argument unless the options
// pass check(), `face` and the view's validity have one value per pixel, and every face is one of the cells' mesh.
[[nodiscard]] std::vector<ShownCell> shown_cells(const StoredView& view, std::span<const FaceId> face,
                                                 const Cells& cells, const TileOptions& options);

// Throws std::invalid_argument, naming the view and the entry, unless `shown` rises by tile, then cell, names tiles
// that the view has in this layout, and no more pixels than a tile has; with whole views it must be empty.
void require_shown_cells_of(const std::string& view, const Camera& camera, std::span<const ShownCell> shown,
                            const TileOptions& layout);

// A view that is ready to be stored, and which cells of the surface each of its tiles shows.
struct TiledView {
  StoredView view;
  std::vector<ShownCell> shown;
};
// Returns make_stored_view() with shown_cells() of its result. Throws as both do.
[[nodiscard]] TiledView make_tiled_view(std::string name, const Camera& camera,
                                        std::shared_ptr<const StoredPhotograph> photograph, VisibilityBuffer visible,
                                        const Cells& cells, const TileOptions& layout, const ValidityOptions& options,
                                        std::vector<std::uint8_t> trust = {});
[[nodiscard]] TiledView make_tiled_view(std::string name, const Camera& camera, Photograph photograph,
                                        VisibilityBuffer visible, const Cells& cells, const TileOptions& layout,
                                        const ValidityOptions& options, std::vector<std::uint8_t> trust = {});

// The position of each tile of each view in the texture array: the last step from a face to a texel. Tiles of the view
// in view slot v are places[first_tile[v]] up to places[first_tile[v + 1]], row by row. Its functions take a table that
// passes check(Snapshot), and a view and camera that belong to it. They do not check again.
struct TileTable {
  TileOptions options;
  std::vector<std::uint32_t> first_tile;  // one more than the store has view slots; empty: whole views
  std::vector<TilePlace> places;          // tile places in the texture array; TilePlace::none: the tile is not there

  [[nodiscard]] bool whole_views() const { return first_tile.empty(); }
  // Returns whether the tile that holds an image position (pixels from the top left corner, inside the image) is
  // resident.
  [[nodiscard]] bool resident(ViewSlot view, const Camera& camera, double x, double y) const;
  // One value per pixel of a view: 1 where it is in a resident tile or its gutter.
  [[nodiscard]] std::vector<std::uint8_t> resident_pixels(ViewSlot view, const Camera& camera) const;
  [[nodiscard]] bool has_resident_tile(ViewSlot view) const;
  [[nodiscard]] std::uint32_t resident_tiles() const;
  // Tile places that a texture array must have, so that each entry of `places` is one of them.
  [[nodiscard]] std::uint32_t places_needed() const;
};

struct ViewTile {
  ViewSlot view;
  std::uint32_t tile;
};

// Gives tiles their tile places, and frees them, so that a tile that stays resident keeps its tile place.
class TilePlaces {
 public:
  // Throws std::invalid_argument unless the options pass check() and cut views into tiles.
  explicit TilePlaces(const TileOptions& options);

  // Makes those tiles resident and no others. `tiles_of_view` says how many each view slot has; a free one has
  // none. Throws std::logic_error, and changes nothing, for more tiles than max_tiles, or one that its view has not.
  void assign(std::span<const ViewTile> tiles, std::span<const std::uint32_t> tiles_of_view);
  [[nodiscard]] const TileTable& table() const { return table_; }

 private:
  void resize(std::span<const std::uint32_t> tiles_of_view);

  TileTable table_;
  std::vector<TilePlace> free_;  // tile places below used_ that are free, the lowest last
  std::uint32_t used_ = 0;       // tile places that were ever used
};

}  // namespace lumatlas
