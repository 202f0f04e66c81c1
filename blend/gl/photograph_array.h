// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the photographs of a snapshot on the GPU, as tiles in the tile places of a texture array or, as
// the baseline, one whole view per layer. Both are looked up in the same way: view -> tile -> tile place -> texel. What
// is where is in tables/array_contents.h.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/snapshot.h"
#include "atlas/tiles/texel_format.h"
#include "blend/gl/gl_objects.h"
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
  // Returns its textures, empty where the array's own stay. Throws GlError if there is no memory for both.
  [[nodiscard]] static ArrayTextures make_next(const NextArray& next);
  // Copies one page of this array to the same page of its next textures.
  void copy_page(const ArrayTextures& next, std::uint32_t page) const;
  // Copies at least one row, and about kBandBytes, of an upload that has all levels and depths: from the given byte on,
  // to this array or to its next textures. Returns the byte to go on from; at the end upload.bytes().
  std::uint64_t copy_band(const ArrayTextures& next, const ArrayShape& shape, const TileUpload& upload,
                          std::uint64_t from);
  // Draws from the next array from now on, whose tiles have all been copied.
  void take(ArrayTextures next, ArrayContents contents, GlTable tile_entries);

  // The textures that shaders/photographs.glsl reads: photographs, their depths in blocks, and the place of each tile.
  [[nodiscard]] const GlTexture& photographs() const { return textures_.photographs; }
  [[nodiscard]] const GlTexture& depths() const { return textures_.depths; }
  [[nodiscard]] const GlTexture& tile_slots() const { return tile_entries_.texture(); }
  [[nodiscard]] const ArrayContents& contents() const { return contents_; }
  [[nodiscard]] const ArrayShape& shape() const { return contents_.shape; }
  // Tile places of which the last load() copied colours, masks or depths.
  [[nodiscard]] std::uint32_t uploaded_slots() const { return uploaded_; }
  // Bytes that have been copied to the GPU by all calls together.
  [[nodiscard]] std::uint64_t color_bytes() const { return color_bytes_; }
  [[nodiscard]] std::uint64_t mask_bytes() const { return mask_bytes_; }
  [[nodiscard]] std::uint64_t depth_bytes() const { return depth_bytes_; }

  static constexpr std::uint64_t kBandBytes = 1 << 18;
  // Returns an empty table of the tiles' places.
  [[nodiscard]] static GlTable tile_table() { return {kNumbers, "tiles"}; }

 private:
  void allocate(const ArrayShape& shape);
  [[nodiscard]] bool grow(const ArrayShape& needed);
  void copy_levels(const TileUpload& upload);
  void copy_depths(const TileUpload& upload);
  void copy(std::span<const TileUpload> uploads);

  ArrayContents contents_;
  std::uint32_t uploaded_ = 0;
  std::uint64_t color_bytes_ = 0, mask_bytes_ = 0, depth_bytes_ = 0;
  ArrayTextures textures_;
  GlTable tile_entries_ = tile_table();
  MaskPass mask_pass_;
};

}  // namespace lumatlas
