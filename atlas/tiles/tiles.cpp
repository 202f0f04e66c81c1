// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tiles/tiles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "atlas/images/image_levels.h"

namespace lumatlas {

namespace {

void require(bool holds, const char* field, std::uint32_t value, const char* rule) {
  if (holds) return;
  throw std::invalid_argument(std::string("tiles: ") + field + " is " + std::to_string(value) + ", must be " + rule);
}

void require_tiles(const TileOptions& options) {
  check(options);
  require(!options.whole_views(), "tile_px", options.tile_px, "above 0, for whole views have no places");
}

void require_count(const StoredView& view, const char* what, std::size_t count) {
  const std::size_t pixels = std::size_t{view.camera.width} * view.camera.height;
  if (count == pixels) return;
  throw std::invalid_argument("tiles: view " + view.name + ": " + what + " has " + std::to_string(count) +
                              " values, must have one per pixel, " + std::to_string(pixels));
}

// Counts pixels by tile and cell in any order; they are sorted and merged at the end.
class ShownCount {
 public:
  void add(std::uint32_t tile, CellId cell, std::uint32_t pixels) {
    if (!counts_.empty() && counts_.back().tile == tile && counts_.back().cell == cell) {
      counts_.back().pixels += pixels;  // neighbouring pixels mostly show the same
    } else {
      counts_.push_back({tile, cell, pixels});
    }
  }

  [[nodiscard]] std::vector<ShownCell> merged() {
    std::sort(counts_.begin(), counts_.end(), [](const ShownCell& a, const ShownCell& b) {
      return std::tie(a.tile, a.cell) < std::tie(b.tile, b.cell);
    });
    std::vector<ShownCell> merged;
    for (const ShownCell& count : counts_) {
      if (!merged.empty() && merged.back().tile == count.tile && merged.back().cell == count.cell) {
        merged.back().pixels += count.pixels;
      } else {
        merged.push_back(count);
      }
    }
    return merged;
  }

 private:
  std::vector<ShownCell> counts_;
};

// The tiles along one axis whose tile or gutter holds a pixel.
struct TileRange {
  std::uint32_t first, last;

  TileRange(std::uint32_t pixel, std::uint32_t tiles, const TileOptions& options)
      : first(pixel < options.gutter_px ? 0 : (pixel - options.gutter_px) / options.tile_px),
        last(std::min((pixel + options.gutter_px) / options.tile_px, tiles - 1)) {}
};

// The cells that the pixels of one row of tiles show, for these tiles and for those in whose gutter they are.
class ShownInRow {
 public:
  ShownInRow(const StoredView& view, std::span<const FaceId> face, const Cells& cells, const TileGrid& grid,
             const TileOptions& options)
      : view_(view), face_(face), cells_(cells), grid_(grid), options_(options) {
    for (std::uint32_t x = 0; x < view.camera.width; ++x) columns_.emplace_back(x, grid.columns, options);
  }

  [[nodiscard]] std::vector<ShownCell> operator()(std::uint32_t tile_row) const {
    ShownCount inside, around;
    const std::uint32_t end = std::min((tile_row + 1) * options_.tile_px, view_.camera.height);
    for (std::uint32_t y = tile_row * options_.tile_px; y < end; ++y) {
      const TileRange rows(y, grid_.rows, options_);
      for (std::uint32_t x = 0; x < view_.camera.width; ++x) {
        const std::optional<CellId> cell = cell_at(std::size_t{y} * view_.camera.width + x);
        if (!cell) continue;
        const std::uint32_t own = tile_row * grid_.columns + x / options_.tile_px;
        inside.add(own, *cell, 1);
        if (rows.first != rows.last || columns_[x].first != columns_[x].last) {
          add_around(own, *cell, rows, columns_[x], around);
        }
      }
    }
    for (const ShownCell& shown : around.merged()) inside.add(shown.tile, shown.cell, 0);
    return inside.merged();
  }

 private:
  [[nodiscard]] std::optional<CellId> cell_at(std::size_t pixel) const {
    const FaceId face = face_[pixel];
    if (view_.mask->validity[pixel] == 0 || face == FaceId::none) return std::nullopt;
    if (face < cells_.cell_of_face.size()) return cells_.cell_of_face[face];
    throw std::invalid_argument("tiles: view " + view_.name + " shows face " + std::to_string(face) +
                                ", the mesh has " + std::to_string(cells_.cell_of_face.size()));
  }

  void add_around(std::uint32_t own, CellId cell, const TileRange& rows, const TileRange& columns,
                  ShownCount& around) const {
    for (std::uint32_t row = rows.first; row <= rows.last; ++row) {
      for (std::uint32_t column = columns.first; column <= columns.last; ++column) {
        if (const std::uint32_t tile = row * grid_.columns + column; tile != own) around.add(tile, cell, 0);
      }
    }
  }

  const StoredView& view_;
  std::span<const FaceId> face_;
  const Cells& cells_;
  const TileGrid& grid_;
  const TileOptions& options_;
  std::vector<TileRange> columns_;  // one per column of pixels
};

}  // namespace

void check(const TileOptions& options) {
  if (options.whole_views()) return;
  require(options.tile_px % 8 == 0 && options.tile_px <= 1024, "tile_px", options.tile_px,
          "a multiple of 8 from 8 to 1024, or 0 for whole views");
  const std::uint32_t gutter = options.gutter_px;
  require(gutter == 1 || gutter == 2 || gutter == 4 || gutter == 8, "gutter_px", gutter, "1, 2, 4 or 8");
  if (options.texels == TexelFormat::rgb8) return;
  require(gutter > 1, "gutter_px", gutter, "2, 4 or 8 for texels in blocks");
  require(gutter < 8 || options.tile_px % 16 == 0, "tile_px", options.tile_px,
          "a multiple of 16 for texels in blocks with a gutter of 8");
}

std::uint32_t levels_of(const TileOptions& options) {
  const std::uint32_t levels = levels_of_gutter(options.gutter_px);
  return options.texels == TexelFormat::rgb8 ? levels : std::max(levels, 2u) - 1;
}

std::uint64_t place_bytes(const TileOptions& options) {
  const std::uint64_t side = options.place_px();
  const std::uint64_t blocks = depth_blocks(options.tile_px);
  std::uint64_t bytes = kDepthBlockBytes * blocks * blocks;
  for (std::uint32_t level = 0; level < levels_of(options); ++level) {
    const std::uint64_t texels = (side >> level) * (side >> level);
    bytes += color_bytes(options.texels, texels) + validity_bytes(options.texels, texels);
  }
  return bytes;
}

PageLayout pages_for(std::uint32_t places, std::uint32_t most_pages, std::uint32_t most_columns) {
  require(most_pages >= 1, "most_pages", most_pages, "at least 1");
  require(most_columns >= 1, "most_columns", most_columns, "at least 1");
  places = std::max(places, 1u);
  std::uint32_t side = 4;
  if (places < side * side && places <= most_columns) return {places, 1, 1};
  while (std::uint64_t{side} * side * most_pages < places && 2 * side <= most_columns) side *= 2;
  PageLayout layout{std::min(side, places), 1, 1};
  layout.rows = std::min(side, (places + layout.columns - 1) / layout.columns);
  layout.pages = (places + layout.columns * layout.rows - 1) / (layout.columns * layout.rows);
  return layout;
}

std::uint32_t places_within(std::uint64_t bytes, const TileOptions& options) {
  require_tiles(options);
  // GL 4.5 promises 2048 layers and 16384 pixels a side: what any driver lays out alike.
  constexpr std::uint32_t kPromisedPages = 2048, kPromisedSide = 16384;
  const auto fit = static_cast<std::uint32_t>(std::min(bytes / place_bytes(options), std::uint64_t{kMostTilePlaces}));
  if (fit == 0) return 0;
  const PageLayout layout = pages_for(fit, kPromisedPages, kPromisedSide / options.place_px());
  if (layout.pages > 1) return fit / (layout.columns * layout.rows) * (layout.columns * layout.rows);
  return fit / layout.columns * layout.columns;
}

TileGrid::TileGrid(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t tile_px) {
  require(tile_px >= 1, "tile_px", tile_px, "above 0 to cut an image");
  columns = (width_px + tile_px - 1) / tile_px;
  rows = (height_px + tile_px - 1) / tile_px;
}

std::vector<ShownCell> shown_cells(const StoredView& view, std::span<const FaceId> face, const Cells& cells,
                                   const TileOptions& options) {
  check(options);
  if (options.whole_views()) return {};
  require_count(view, "face", face.size());
  require_count(view, "validity", view.mask->validity.size());
  const TileGrid grid(view.camera.width, view.camera.height, options.tile_px);
  const ShownInRow shown_in_row(view, face, cells, grid, options);
  std::vector<std::vector<ShownCell>> rows(grid.rows);
  tbb::parallel_for(std::uint32_t{0}, grid.rows, [&](std::uint32_t row) { rows[row] = shown_in_row(row); });
  ShownCount all;
  for (const std::vector<ShownCell>& row : rows) {
    for (const ShownCell& shown : row) all.add(shown.tile, shown.cell, shown.pixels);
  }
  return all.merged();
}

void require_shown_cells_of(const std::string& view, const Camera& camera, std::span<const ShownCell> shown,
                            const TileOptions& layout) {
  const auto refuse = [&](const std::string& why) { throw std::invalid_argument("view " + view + ": " + why); };
  if (shown.empty()) return;
  if (layout.whole_views()) {
    refuse("shown has " + std::to_string(shown.size()) + " entries, must have none where views are whole");
  }
  const std::uint32_t tiles = TileGrid(camera.width, camera.height, layout.tile_px).tiles();
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto entry = [i] { return "shown[" + std::to_string(i) + "]"; };
    if (shown[i].tile >= tiles) {
      refuse(entry() + " is of tile " + std::to_string(shown[i].tile) + ", must be below " + std::to_string(tiles));
    }
    if (shown[i].pixels > layout.tile_px * layout.tile_px) {
      refuse(entry() + " has " + std::to_string(shown[i].pixels) + " pixels, a tile has " +
             std::to_string(layout.tile_px * layout.tile_px));
    }
    if (i == 0 || std::tie(shown[i - 1].tile, shown[i - 1].cell) < std::tie(shown[i].tile, shown[i].cell)) continue;
    refuse(entry() + " does not come after the one before it, must rise by tile, then cell");
  }
}

TiledView make_tiled_view(std::string name, const Camera& camera, std::shared_ptr<const StoredPhotograph> photograph,
                          VisibilityBuffer visible, const Cells& cells, const TileOptions& layout,
                          const ValidityOptions& options, std::vector<std::uint8_t> trust) {
  const std::vector<FaceId> face = std::move(visible.face);
  TiledView tiled;
  tiled.view =
      make_stored_view(std::move(name), camera, std::move(photograph), std::move(visible), options, std::move(trust));
  tiled.shown = shown_cells(tiled.view, face, cells, layout);
  return tiled;
}

TiledView make_tiled_view(std::string name, const Camera& camera, Photograph photograph, VisibilityBuffer visible,
                          const Cells& cells, const TileOptions& layout, const ValidityOptions& options,
                          std::vector<std::uint8_t> trust) {
  return make_tiled_view(std::move(name), camera, std::make_shared<const StoredPhotograph>(std::move(photograph)),
                         std::move(visible), cells, layout, options, std::move(trust));
}

bool TileTable::resident(ViewSlot view, const Camera& camera, double x, double y) const {
  const TileGrid grid(camera.width, camera.height, options.tile_px);
  const auto column = static_cast<std::uint32_t>(x) / options.tile_px;
  const auto row = static_cast<std::uint32_t>(y) / options.tile_px;
  return places[first_tile[view] + row * grid.columns + column] != TilePlace::none;
}

std::vector<std::uint8_t> TileTable::resident_pixels(ViewSlot view, const Camera& camera) const {
  const TileGrid grid(camera.width, camera.height, options.tile_px);
  std::vector<std::uint8_t> mask(std::size_t{camera.width} * camera.height, 0);
  for (std::uint32_t tile = 0; tile < grid.tiles(); ++tile) {
    if (places[first_tile[view] + tile] == TilePlace::none) continue;
    const std::uint32_t x = tile % grid.columns * options.tile_px;
    const std::uint32_t y = tile / grid.columns * options.tile_px;
    const std::uint32_t first_x = x - std::min(x, options.gutter_px);
    const std::uint32_t end_x = std::min(x + options.tile_px + options.gutter_px, camera.width);
    const std::uint32_t end_y = std::min(y + options.tile_px + options.gutter_px, camera.height);
    for (std::uint32_t row = y - std::min(y, options.gutter_px); row < end_y; ++row) {
      std::fill_n(mask.begin() + static_cast<std::ptrdiff_t>(std::size_t{row} * camera.width + first_x),
                  end_x - first_x, 1);
    }
  }
  return mask;
}

bool TileTable::has_resident_tile(ViewSlot view) const {
  return std::any_of(places.begin() + first_tile[view], places.begin() + first_tile[view + 1],
                     [](TilePlace place) { return place != TilePlace::none; });
}

std::uint32_t TileTable::resident_tiles() const {
  return static_cast<std::uint32_t>(
      std::count_if(places.begin(), places.end(), [](TilePlace place) { return place != TilePlace::none; }));
}

std::uint32_t TileTable::places_needed() const {
  std::uint32_t needed = 0;
  for (const TilePlace place : places) needed = place == TilePlace::none ? needed : std::max(needed, place + 1);
  return needed;
}

TilePlaces::TilePlaces(const TileOptions& options) {
  require_tiles(options);
  table_.options = options;
}

// Gives the places of tiles back whose views are gone, or have another number of tiles than before.
void TilePlaces::resize(std::span<const std::uint32_t> tiles_of_view) {
  TileTable table;
  table.options = table_.options;
  table.first_tile.push_back(0);
  for (std::size_t view = 0; view < tiles_of_view.size(); ++view) {
    table.first_tile.push_back(table.first_tile.back() + tiles_of_view[view]);
    table.places.resize(table.first_tile.back(), TilePlace::none);
    if (view + 1 >= table_.first_tile.size()) continue;
    const std::span<const TilePlace> before =
        std::span<const TilePlace>(table_.places)
            .subspan(table_.first_tile[view], table_.first_tile[view + 1] - table_.first_tile[view]);
    if (before.size() == tiles_of_view[view]) {
      std::copy(before.begin(), before.end(), table.places.begin() + table.first_tile[view]);
    } else {
      std::copy_if(before.begin(), before.end(), std::back_inserter(free_),
                   [](TilePlace place) { return place != TilePlace::none; });
    }
  }
  table_ = std::move(table);
}

void TilePlaces::assign(std::span<const ViewTile> tiles, std::span<const std::uint32_t> tiles_of_view) {
  const std::uint32_t most = table_.options.max_tiles;
  if (most > 0 && tiles.size() > most) {
    throw std::logic_error("tiles: " + std::to_string(tiles.size()) + " are to be resident, at most " +
                           std::to_string(most) + " can be");
  }
  for (const ViewTile& tile : tiles) {
    if (tile.view < tiles_of_view.size() && tile.tile < tiles_of_view[tile.view]) continue;
    throw std::logic_error("tiles: tile " + std::to_string(tile.tile) + " of slot " + std::to_string(tile.view) +
                           " is to be resident, but there is no such tile");
  }
  resize(tiles_of_view);
  std::vector<std::uint8_t> stays(table_.places.size(), 0);
  for (const ViewTile& tile : tiles) stays[table_.first_tile[tile.view] + tile.tile] = 1;
  for (std::size_t tile = 0; tile < stays.size(); ++tile) {
    if (stays[tile] || table_.places[tile] == TilePlace::none) continue;
    free_.push_back(table_.places[tile]);
    table_.places[tile] = TilePlace::none;
  }
  std::sort(free_.begin(), free_.end(), std::greater<>());
  for (std::size_t tile = 0; tile < stays.size(); ++tile) {
    if (!stays[tile] || table_.places[tile] != TilePlace::none) continue;
    if (free_.empty()) free_.emplace_back(used_++);
    table_.places[tile] = free_.back();
    free_.pop_back();
  }
}

}  // namespace lumatlas
