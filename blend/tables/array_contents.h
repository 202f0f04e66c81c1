// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: what the texture array of a renderer holds, and what has to be copied there for another snapshot.
// Needs no OpenGL, so that any thread may prepare it.
//
// A snapshot numbers its tile places; the array has places of its own. So a tile may come to a free place of the array
// while the tile that had its tile place before is still drawn.
//
// Colour (sRGB) with validity as alpha has coarser levels, within a tile place as far as its gutter allows. Their
// colours are means weighted by validity, so that they belong to the mask as much as to the photograph. Depth and
// rims have none, and no gutter, because they are asked for at pixels and not between them: see
// atlas/views/depth_blocks.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/snapshot.h"
#include "atlas/tiles/texel_format.h"
#include "atlas/views/depth_blocks.h"
#include "blend/tables/array_shape.h"
#include "mesh/base/id.h"

namespace lumatlas {

// In place of the number of a place of the array; the shaders read it as a tile that is not resident.
inline constexpr std::uint32_t kNoArrayPlace = 0xFFFFFFFF;

// Digests of what a place holds: the finest level's colours, its validities, and what the depths are made of.
struct TileDigests {
  std::optional<std::uint64_t> color, validity, depth;
};

// The contents of a place. The parts of the view may be gone from memory.
struct HeldTile {
  std::weak_ptr<const StoredPhotograph> photograph;
  std::weak_ptr<const ViewMask> mask;
  std::uint32_t tile = 0;  // of the view
  TileDigests digests;

  [[nodiscard]] bool is(const StoredView& view, std::uint32_t tile_of_view) const;
};

// A tile for a place of the array, and what is copied there.
struct TileUpload {
  std::uint32_t number;  // of the tile among those of all views
  ViewSlot view;
  std::uint32_t tile;  // of the view
  std::uint32_t array_place;
  TileDigests digests;
  std::vector<std::vector<std::uint8_t>> levels;  // texels or blocks, in the array's format; the finest may be empty
  std::vector<std::uint8_t> validity;             // of the finest level, where its colours stay
  std::vector<DepthBlock> depth;

  [[nodiscard]] bool empty() const { return levels.empty() && depth.empty(); }
  [[nodiscard]] std::uint64_t bytes() const;
};

struct ArrayContents {
  ArrayShape shape;
  TexelFormat stored_format = TexelFormat::rgb8;  // the snapshot's, whatever the driver takes
  glm::uvec2 tile_size{0};                        // without the gutter, pixels
  std::uint32_t gutter = 0;
  std::vector<std::uint32_t> first_tile;  // one per view
  std::vector<HeldTile> held;             // one per place of the array
  std::vector<std::uint32_t> place_of;    // for each tile place of a snapshot its place in the array, or none
  std::vector<std::uint32_t>
      tile_entries;  // for each tile of a view its place in the array, or none: the shaders' table

  // The unit of a view's stored depths: a power of two near its median depth.
  struct Scaled {
    std::weak_ptr<const ViewMask> mask;
    float scale = 1;
  };
  std::vector<Scaled> scaled;  // one per view

  // Returns how many columns of tiles a view has.
  [[nodiscard]] std::uint32_t columns_of(const StoredView& view) const;
};

// Takes the snapshot's tiles, sizes and depths for an array whose shape and held tiles are there; copies nothing.
// Places stay; `places`: tile place of each tile.
void lay_out(ArrayContents& contents, const Snapshot& snapshot, const std::vector<TilePlace>& places);

// Returns the tile place of each tile of a snapshot's views.
[[nodiscard]] std::vector<TilePlace> tile_places(const Snapshot& snapshot);

// Gives each resident tile of a snapshot that lay_out() has taken the place of its tile place, or one that no resident
// tile has. Returns the tiles that are not in their places yet.
[[nodiscard]] std::vector<TileUpload> assign_in_place(ArrayContents& contents, const Snapshot& snapshot,
                                                      const std::vector<TilePlace>& places);

// What becomes of an array for the next snapshot while the former one is drawn.
struct NextArray {
  ArrayContents contents;
  bool is_new = false;             // other textures take the place of the former ones
  std::uint32_t copied_pages = 0;  // that the new ones take over from these
  // Not prepared yet. Their places are those of no tile that is drawn.
  struct Missing {
    TileUpload upload;
    TilePlace place;
    std::uint32_t former;  // the place of the former array that its tile place had, or none
  };
  std::vector<Missing> missing;
};

// Makes a missing tile. Returns whether it has to be copied: else the place that its tile place had holds it already,
// and is its place again. May be called for several tiles at once.
[[nodiscard]] bool prepare_missing(NextArray& next, std::size_t index, const ArrayContents& former,
                                   const StoredView& view);

// Returns the array for the next snapshot. No place that the former snapshot is drawn from gets another tile, so that
// the array has places for the tiles of both. Throws GlError as require_limits() does.
[[nodiscard]] NextArray next_array(const ArrayContents& former, const Snapshot& snapshot, const ArrayLimits& limits,
                                   bool blocks);

// Makes what is copied to the upload's place, which holds `held`: nothing that it holds already.
void prepare_upload(TileUpload& upload, const ArrayContents& contents, const HeldTile& held, const StoredView& view);

// Notes that an upload's place holds its tile.
void note_held(ArrayContents& contents, const TileUpload& upload, const StoredView& view);

}  // namespace lumatlas
