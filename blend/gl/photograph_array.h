// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the photographs of a snapshot on the GPU, as tiles in the tile places of a texture array or, as
// the baseline, one whole view per layer. Both are looked up in the same way: view -> tile -> tile place -> texel.
//
// Colour (sRGB) with validity as alpha has coarser levels, within a tile place as far as its gutter allows. Their
// colours are means weighted by validity, so that they belong to the mask as much as to the photograph. Depth and
// rims have none, and no gutter, because they are asked for at pixels and not between them: see
// atlas/views/depth_blocks.h.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "atlas/images/image_levels.h"
#include "atlas/snapshot.h"
#include "atlas/tiles/texel_format.h"
#include "atlas/views/depth_blocks.h"
#include "blend/gl/gl_objects.h"
#include "blend/gl/mask_pass.h"
#include "mesh/base/id.h"

namespace lumatlas {

// The layout of tile places in the pages of the array.
struct ArrayShape {
  std::uint32_t place_width = 0;   // texels, gutter included
  std::uint32_t place_height = 0;  // texels, gutter included
  std::uint32_t columns = 1;       // tile places in a page
  std::uint32_t rows = 1;
  std::uint32_t pages = 1;
  std::uint32_t levels = 1;
  TexelFormat format = TexelFormat::rgb8;
  // Blocks of depth in a tile place.
  std::uint32_t depth_columns = 0;
  std::uint32_t depth_rows = 0;

  [[nodiscard]] std::uint64_t texels(std::uint32_t level) const;  // 0: the finest
  [[nodiscard]] std::uint64_t depth_bytes() const;
  [[nodiscard]] std::uint64_t bytes() const;  // that the array takes, all levels of colour and depth
  [[nodiscard]] bool operator==(const ArrayShape&) const = default;
};

// The limits of a driver. The defaults are those that OpenGL 4.5 guarantees.
struct ArrayLimits {
  std::uint32_t pages = 2048;
  std::uint32_t side = 16384;  // texels
};

// Returns the shape of an array for at least `places` tiles, or for whole views, which all take as much as the largest.
// The options must pass check().
[[nodiscard]] ArrayShape tiles_shape(std::uint32_t places, const TileOptions& options, const ArrayLimits& limits);
[[nodiscard]] ArrayShape layers_shape(std::span<const Camera> views, const TileOptions& options);

// Returns whether the driver of the current context takes textures of the format.
[[nodiscard]] bool driver_takes(TexelFormat format);

// Returns whether the driver of the current context draws in software. Such a driver decodes a block for each texel,
// which takes three times as long.
[[nodiscard]] bool draws_in_software();

// The shape that a snapshot's array has; of bounded tiles, that of all its tile places, whether they are used or not.
// Its format is rgb8 without `blocks`, or where the driver does not take the snapshot's.
[[nodiscard]] ArrayShape array_shape(const Snapshot& snapshot, bool blocks = true);

class PhotographArray {
 public:
  // Copies the parts of the snapshot to the GPU that are not there yet. A tile that stays is not copied. For a tile
  // whose view has another part, only what changed with it is: with a photograph all levels; with a mask validity, the
  // coarser levels and depths; with a pose nothing. Compressed texels hold colour and validity in one block, so that
  // all levels are copied for a mask, too. An array that becomes too small is replaced by one with a quarter more
  // pages, if the driver copies textures. Expects the state that GlStateGuard sets. Throws GlError if a limit of the
  // driver is exceeded, naming the limit, the number and what to do; the former contents are then gone. If
  // array_shape() has another format than the snapshot, texels are compressed and decompressed again, so that pictures
  // are the same.
  void load(const Snapshot& snapshot, bool blocks = true);

  // The textures that shaders/photographs.glsl reads: photographs, their depths in blocks, and the place of each tile.
  [[nodiscard]] const GlTexture& photographs() const { return photographs_; }
  [[nodiscard]] const GlTexture& depths() const { return depths_; }
  [[nodiscard]] const GlTexture& tile_slots() const { return tile_slots_.texture(); }
  // The size of a tile without the gutter, pixels.
  [[nodiscard]] glm::uvec2 tile_size() const { return {tile_width_, tile_height_}; }
  [[nodiscard]] std::uint32_t gutter() const { return gutter_; }
  [[nodiscard]] const ArrayShape& shape() const { return shape_; }
  // The number of a view's first tile in the table of tiles, and how many columns of tiles it has.
  [[nodiscard]] std::uint32_t first_tile(ViewSlot view) const { return first_tile_[view]; }
  [[nodiscard]] std::uint32_t columns_of(const StoredView& view) const;
  // The unit of a view's stored depths: a power of two near its median depth.
  [[nodiscard]] float depth_scale(ViewSlot view) const { return scaled_[view].scale; }
  // Tile places of which the last load() copied colours, masks or depths.
  [[nodiscard]] std::uint32_t uploaded_slots() const { return uploaded_; }
  // Bytes that all calls of load() together have copied to the GPU.
  [[nodiscard]] std::uint64_t color_bytes() const { return color_bytes_; }
  [[nodiscard]] std::uint64_t mask_bytes() const { return mask_bytes_; }
  [[nodiscard]] std::uint64_t depth_bytes() const { return depth_bytes_; }

 private:
  // Digests of what a tile place holds: the finest level's colours, its validities, and what the depths are made of.
  struct Digests {
    std::optional<std::uint64_t> color, validity, depth;
  };
  // The contents of a tile place. The parts of the view may be gone from memory.
  struct Held {
    std::weak_ptr<const StoredPhotograph> photograph;
    std::weak_ptr<const ViewMask> mask;
    std::uint32_t tile = 0;  // of the view
    Digests digests;
  };
  struct Scaled {
    std::weak_ptr<const ViewMask> mask;
    float scale = 1;
  };

  void allocate(const ArrayShape& shape);
  [[nodiscard]] bool grow(const ArrayShape& needed);
  void measure_depths(const Snapshot& snapshot);
  // A tile for a tile place, and what is copied there. What the tile place holds already is empty.
  struct Upload {
    TilePlace place;
    ViewSlot view;
    std::uint32_t tile;  // of the view
    Digests digests;
    std::vector<std::vector<std::uint8_t>> levels;  // texels or blocks, in the array's format; the finest may be empty
    std::vector<std::uint8_t> validity;             // of the finest level, where its colours stay
    std::vector<DepthBlock> depth;
  };
  struct Texel {
    std::uint32_t x, y, page;
  };
  [[nodiscard]] std::vector<Upload> missing_tiles(const Snapshot& snapshot, std::span<const TilePlace> places) const;
  // Returns the first texel of a tile place.
  [[nodiscard]] Texel first_texel(TilePlace place) const;
  void prepare(Upload& upload, const StoredView& view) const;
  void prepare_levels(Upload& upload, const StoredView& view, const ImageRect& rect) const;
  void prepare_depths(Upload& upload, const StoredView& view, std::uint32_t left, std::uint32_t top) const;
  void copy_levels(const Upload& upload);
  void copy_depths(const Upload& upload);
  void copy(std::span<const Upload> uploads);

  ArrayShape shape_;
  TexelFormat stored_format_ = TexelFormat::rgb8;  // the snapshot's, whatever the driver takes
  std::uint32_t tile_width_ = 0, tile_height_ = 0, gutter_ = 0;
  std::vector<std::uint32_t> first_tile_;  // one per view
  std::vector<Held> held_;                 // one per tile place
  std::vector<Scaled> scaled_;             // one per view
  std::uint32_t uploaded_ = 0;
  std::uint64_t color_bytes_ = 0, mask_bytes_ = 0, depth_bytes_ = 0;
  GlTexture photographs_, depths_;
  GlTable tile_slots_{kNumbers, "tiles"};
  MaskPass mask_pass_;
};

}  // namespace lumatlas
