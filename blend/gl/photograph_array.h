// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the photographs of a snapshot on the GPU, as tiles in the tile places of a texture array or, as
// the baseline, one whole view per layer. Both are looked up in the same way: view -> tile -> tile place -> texel. What
// is where is in tables/array_contents.h.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "atlas/snapshot.h"
#include "atlas/tiles/texel_format.h"
#include "blend/gl/gl_objects.h"
#include "blend/gl/gradual_copies.h"
#include "blend/gl/mask_pass.h"
#include "blend/tables/array_contents.h"
#include "blend/tables/array_shape.h"

namespace lumatlas {

// Returns whether the driver of the current context takes textures of the format.
[[nodiscard]] bool driver_takes(TexelFormat format);

// Returns whether the driver of the current context draws in software. Such a driver decodes a block for each texel,
// which takes three times as long.
[[nodiscard]] bool draws_in_software();

[[nodiscard]] ArrayLimits limits_of_driver();

// Returns the shape that array_shape() gives for the driver of the current context.
[[nodiscard]] ArrayShape array_shape(const Snapshot& snapshot, bool blocks = true);

// Textures that take the place of an array's, or none where those stay.
struct ArrayTextures {
  GlTexture photographs, depths;
  // Shares the memory of `photographs`, and reads sRGB as it is stored. None where the driver draws on a GPU, where
  // texels are compressed, or where the driver makes no such texture.
  GlTexture raw_texels;
};

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

  // The functions below take a NextArray, whose tiles are copied one after another while the array is drawn from.
  // Allocates the textures of a next array that is new, and leaves them unbound. Throws GlError if there is no memory
  // for both.
  [[nodiscard]] static ArrayTextures allocate_next(const ArrayShape& shape);
  // The rows of a page that copy_page_rows() counts: of all levels, of compressed texels rows of blocks, and then those
  // of depths.
  [[nodiscard]] std::uint32_t page_rows() const;
  // Copies rows of a page of this array, from the given one on, to the same page of its next textures: one at least,
  // and at most about kPieceBytes. Returns how many, and their bytes.
  struct CopiedRows {
    std::uint32_t rows;
    std::uint64_t bytes;
  };
  CopiedRows copy_page_rows(const ArrayTextures& next, std::uint32_t page, std::uint32_t from) const;
  // Copies at least one row, and at most about kPieceBytes, of an upload that has all levels and depths: from the given
  // byte on, to this array or to its next textures. Returns the byte to go on from; at the end upload.bytes().
  std::uint64_t copy_band(const ArrayTextures& next, const ArrayShape& shape, const TileUpload& upload,
                          std::uint64_t from);
  // Returns textures that share the memory of this array's: it is freed with the last of them. Empty where the driver
  // makes none.
  [[nodiscard]] ArrayTextures memory() const;
  // Draws from the next array from now on, whose tiles have all been copied.
  void take(ArrayTextures next, ArrayContents contents, GlTable tile_entries);

  // The textures that shaders/photographs.glsl reads: photographs, their depths in blocks, and the place of each tile.
  // raw_texels() is none where ArrayTextures has none.
  [[nodiscard]] const GlTexture& photographs() const { return textures_.photographs; }
  [[nodiscard]] const GlTexture& raw_texels() const { return textures_.raw_texels; }
  [[nodiscard]] const GlTexture& depths() const { return textures_.depths; }
  [[nodiscard]] const GlTexture& tile_slots() const { return tile_entries_.texture(); }
  [[nodiscard]] const ArrayContents& contents() const { return *contents_; }
  [[nodiscard]] const ArrayShape& shape() const { return contents_->shape; }
  // Returns the same; load() and take() replace it, and change nothing in it.
  [[nodiscard]] std::shared_ptr<const ArrayContents> shared_contents() const { return contents_; }
  // Returns the places that copy_band() has written to since the last load() or take(). They hold nothing of
  // contents().
  [[nodiscard]] const std::set<std::uint32_t>& unknown_places() const { return unknown_places_; }
  // Tile places of which the last load() copied colours, masks or depths.
  [[nodiscard]] std::uint32_t uploaded_slots() const { return uploaded_; }
  // Bytes that have been copied to the GPU by all calls together.
  [[nodiscard]] std::uint64_t color_bytes() const { return color_bytes_; }
  [[nodiscard]] std::uint64_t mask_bytes() const { return mask_bytes_; }
  [[nodiscard]] std::uint64_t depth_bytes() const { return depth_bytes_; }

  // Returns an empty table of the tiles' places.
  [[nodiscard]] static GlTable tile_table() { return {kNumbers, kTilesName}; }
  // Returns a table of these places that is copied piece by piece.
  [[nodiscard]] static GradualTable gradual_tile_table(const std::vector<std::uint32_t>& entries) {
    return {kNumbers, kTilesName, entries};
  }

 private:
  static constexpr const char* kTilesName = "tiles";

  void own_contents();
  void allocate(const ArrayShape& shape);
  [[nodiscard]] bool grow(const ArrayShape& needed);
  void copy_levels(const TileUpload& upload);
  void copy_depths(const TileUpload& upload);
  void copy(std::span<const TileUpload> uploads);

  std::shared_ptr<ArrayContents> contents_ = std::make_shared<ArrayContents>();
  std::set<std::uint32_t> unknown_places_;
  std::uint32_t uploaded_ = 0;
  std::uint64_t color_bytes_ = 0, mask_bytes_ = 0, depth_bytes_ = 0;
  ArrayTextures textures_;
  GlTable tile_entries_ = tile_table();
  MaskPass mask_pass_;
};

}  // namespace lumatlas
