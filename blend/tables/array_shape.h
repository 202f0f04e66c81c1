// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: how a texture array holds the tiles of photographs, without OpenGL.
#pragma once

#include <cstdint>
#include <span>

#include "atlas/snapshot.h"
#include "atlas/tiles/texel_format.h"
#include "mesh/camera/camera.h"

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

  [[nodiscard]] std::uint32_t places() const { return columns * rows * pages; }
  [[nodiscard]] std::uint64_t texels(std::uint32_t level) const;  // 0: the finest
  [[nodiscard]] std::uint64_t depth_bytes() const;
  [[nodiscard]] std::uint64_t bytes() const;  // that the array takes, all levels of colour and depth
  [[nodiscard]] bool operator==(const ArrayShape&) const = default;
};

// What a driver takes. The defaults are those that OpenGL 4.5 guarantees.
struct ArrayLimits {
  std::uint32_t pages = 2048;
  std::uint32_t side = 16384;  // texels
  bool takes_bc7 = true;
  bool copies_textures = true;
};

// Returns the shape of an array for at least `places` tiles, or for whole views, which all take as much as the largest.
// The options must pass check().
[[nodiscard]] ArrayShape tiles_shape(std::uint32_t places, const TileOptions& options, const ArrayLimits& limits);
[[nodiscard]] ArrayShape layers_shape(std::span<const Camera> views, const TileOptions& options);

// Returns the shape that a snapshot's array has; of bounded tiles, that of all its tile places, whether they are used
// or not. Its format is rgb8 without `blocks`, or where the driver does not take the snapshot's.
[[nodiscard]] ArrayShape array_shape(const Snapshot& snapshot, const ArrayLimits& limits, bool blocks);

// Returns the shape with another number of pages.
[[nodiscard]] ArrayShape with_pages(ArrayShape shape, std::uint32_t pages);

// Returns whether both have their tile places at the same texels.
[[nodiscard]] bool same_layout(const ArrayShape& a, const ArrayShape& b);

// Returns whether an array may stay where as many pages as `needed` says are: it has them, and no more than half of it
// would be of no use.
[[nodiscard]] bool suffices(const ArrayShape& there, const ArrayShape& needed);

// Returns the shape that replaces an array that has become too small: a quarter more, so that all copies of a store
// that grows view by view are a few times its size.
[[nodiscard]] ArrayShape grown(const ArrayShape& there, const ArrayShape& needed, const ArrayLimits& limits);

// Throws GlError, naming the limit, the number and what to do, if the driver does not take an array of this shape.
void require_limits(const ArrayShape& shape, const ArrayLimits& limits, bool whole_views);

}  // namespace lumatlas
