// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/array_shape.h"

#include <algorithm>
#include <string>
#include <vector>

#include "atlas/tiles/compressed_texels.h"
#include "atlas/views/depth_blocks.h"
#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

std::uint32_t round_up(std::uint32_t value, std::uint32_t unit) {
  return (value + unit - 1) / unit * unit;
}

// Returns cameras of no size for view slots without a view.
std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras(snapshot.views.size());
  for (ViewSlot slot{0}; slot < cameras.size(); ++slot) {
    if (snapshot.views[slot]) cameras[slot] = snapshot.views[slot]->camera;
  }
  return cameras;
}

void require_limit(std::uint64_t needed, std::uint32_t most, const char* what, const char* advice) {
  if (needed <= most) return;
  throw GlError("the model needs " + std::to_string(needed) + " " + what + ", this driver takes " +
                std::to_string(most) + ": " + advice);
}

}  // namespace

std::uint64_t ArrayShape::texels(std::uint32_t level) const {
  return (std::uint64_t{columns} * place_width >> level) * (std::uint64_t{rows} * place_height >> level) * pages;
}

std::uint64_t ArrayShape::depth_bytes() const {
  return kDepthBlockBytes * columns * depth_columns * rows * depth_rows * pages;
}

std::uint64_t ArrayShape::bytes() const {
  std::uint64_t bytes = depth_bytes();
  for (std::uint32_t level = 0; level < levels; ++level) {
    bytes += color_bytes(format, texels(level)) + validity_bytes(format, texels(level));
  }
  return bytes;
}

ArrayShape layers_shape(std::span<const Camera> views, const TileOptions& options) {
  ArrayShape shape;
  shape.levels = levels_of(options);
  shape.format = options.texels;
  shape.pages = std::max<std::uint32_t>(static_cast<std::uint32_t>(views.size()), 1);
  std::uint32_t width = 1, height = 1;
  for (const Camera& view : views) {
    width = std::max(width, view.width);
    height = std::max(height, view.height);
  }
  const std::uint32_t unit = (options.texels == TexelFormat::rgb8 ? 1 : kBlockSide) << (shape.levels - 1);
  shape.place_width = round_up(width, unit);
  shape.place_height = round_up(height, unit);
  shape.depth_columns = depth_blocks(shape.place_width);
  shape.depth_rows = depth_blocks(shape.place_height);
  return shape;
}

ArrayShape tiles_shape(std::uint32_t places, const TileOptions& options, const ArrayLimits& limits) {
  const PageLayout pages = pages_for(places, limits.pages, limits.side / options.place_px());
  const std::uint32_t side = options.place_px(), blocks = depth_blocks(options.tile_px);
  return {side, side, pages.columns, pages.rows, pages.pages, levels_of(options), options.texels, blocks, blocks};
}

ArrayShape array_shape(const Snapshot& snapshot, const ArrayLimits& limits, bool blocks) {
  const TileOptions& options = snapshot.tiles.options;
  const std::uint32_t places = options.max_tiles > 0 ? options.max_tiles : snapshot.tiles.places_needed();
  ArrayShape shape =
      snapshot.tiles.whole_views() ? layers_shape(cameras_of(snapshot), options) : tiles_shape(places, options, limits);
  if (!blocks || !limits.takes_bc7) shape.format = TexelFormat::rgb8;
  return shape;
}

ArrayShape with_pages(ArrayShape shape, std::uint32_t pages) {
  shape.pages = pages;
  return shape;
}

bool same_layout(const ArrayShape& a, const ArrayShape& b) {
  return with_pages(a, b.pages) == b;
}

bool suffices(const ArrayShape& there, const ArrayShape& needed) {
  return same_layout(there, needed) && needed.pages <= there.pages && there.pages <= 2 * needed.pages;
}

ArrayShape grown(const ArrayShape& there, const ArrayShape& needed, const ArrayLimits& limits) {
  const std::uint32_t most = std::max(limits.pages, needed.pages);
  return with_pages(needed, std::clamp(there.pages + there.pages / 4, needed.pages, most));
}

void require_limits(const ArrayShape& shape, const ArrayLimits& limits, bool whole_views) {
  const std::uint64_t side =
      std::max(std::uint64_t{shape.columns} * shape.place_width, std::uint64_t{shape.rows} * shape.place_height);
  require_limit(side, limits.side, "pixels a side for its photographs", "scale the photographs down");
  require_limit(shape.pages, limits.pages, whole_views ? "views" : "pages of tiles",
                whole_views ? "build it with fewer (--max-views)" : "build it with a smaller --budget");
}

}  // namespace lumatlas
