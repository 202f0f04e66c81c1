// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/photograph_array.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <string>

#include "atlas/compressed_texels.h"
#include "atlas/image_levels.h"
#include "blend/egl_context.h"

namespace lumatlas {

namespace {

constexpr std::uint16_t kHalfSign = 0x8000;
constexpr std::size_t kBytesAtOnce = 64 << 20;  // of tiles that are made ready for the GPU

std::uint32_t round_up(std::uint32_t value, std::uint32_t unit) {
  return (value + unit - 1) / unit * unit;
}

// Of slots without a view, cameras of no size.
std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras(snapshot.views.size());
  for (std::size_t slot = 0; slot < cameras.size(); ++slot) {
    if (snapshot.views[slot]) cameras[slot] = snapshot.views[slot]->camera;
  }
  return cameras;
}

ArrayLimits limits_of_driver() {
  return {static_cast<std::uint32_t>(gl_limit(GL_MAX_ARRAY_TEXTURE_LAYERS)),
          static_cast<std::uint32_t>(gl_limit(GL_MAX_TEXTURE_SIZE))};
}

void require_limit(std::uint64_t needed, GLenum name, const char* what, const char* advice) {
  const GLint most = gl_limit(name);
  if (needed > static_cast<std::uint64_t>(most)) {
    throw GlError("the model needs " + std::to_string(needed) + " " + what + ", this driver takes " +
                  std::to_string(most) + ": " + advice);
  }
}

void require_limits(const ArrayShape& shape, bool whole_views) {
  const std::uint64_t side =
      std::max(std::uint64_t{shape.columns} * shape.slot_width, std::uint64_t{shape.rows} * shape.slot_height);
  require_limit(side, GL_MAX_TEXTURE_SIZE, "pixels a side for its photographs", "scale the photographs down");
  require_limit(shape.pages, GL_MAX_ARRAY_TEXTURE_LAYERS, whole_views ? "views" : "pages of tiles",
                whole_views ? "build it with fewer (--max-views)" : "build it with a smaller --budget");
}

bool same(const std::weak_ptr<const StoredView>& a, const std::shared_ptr<const StoredView>& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

// A power of two near the median of a view's depths; 1 if it has none.
float depth_scale_of(const StoredView& view) {
  const float depth = median_depth(view);
  return depth > 0 ? std::exp2(std::floor(std::log2(depth))) : 1;
}

// In half precision, rounded up, so that what a view shows is never found behind itself.
std::uint16_t half_above(float depth) {
  constexpr float kLeastNormal = 0x1p-14f, kMost = 65504;
  if (depth >= kLeastNormal && depth <= kMost) {  // nearly all: cut the 13 bits that a half has not, and move the bias
    const std::uint32_t above = std::bit_cast<std::uint32_t>(depth) + 0x1FFFu;
    return static_cast<std::uint16_t>((above >> 13) - ((127u - 15u) << 10));
  }
  const std::uint16_t half = glm::packHalf1x16(depth);
  return glm::unpackHalf1x16(half) < depth ? static_cast<std::uint16_t>(half + 1) : half;
}

// Depth of the part of a view, as a share of `scale`, negative at rims.
std::vector<std::uint16_t> depth_of(const StoredView& view, const ImageRect& rect, float scale) {
  std::vector<std::uint16_t> depth;
  depth.reserve(std::size_t{rect.width} * rect.height);
  for (std::uint32_t row = 0; row < rect.height; ++row) {
    const std::int64_t y = std::clamp<std::int64_t>(rect.y + row, 0, std::int64_t{view.camera.height} - 1);
    for (std::uint32_t column = 0; column < rect.width; ++column) {
      const std::int64_t x = std::clamp<std::int64_t>(rect.x + column, 0, std::int64_t{view.camera.width} - 1);
      const auto pixel = static_cast<std::size_t>(y * view.camera.width + x);
      const std::uint16_t sign = view.at_rim(pixel) ? kHalfSign : std::uint16_t{0};
      depth.push_back(static_cast<std::uint16_t>(half_above(view.depth[pixel] / scale) | sign));
    }
  }
  return depth;
}

}  // namespace

std::uint64_t ArrayShape::texels(std::uint32_t level) const {
  return (std::uint64_t{columns} * slot_width >> level) * (std::uint64_t{rows} * slot_height >> level) * pages;
}

std::uint64_t ArrayShape::bytes() const {
  std::uint64_t bytes = kDepthTexelBytes * texels(0);
  for (std::uint32_t level = 0; level < levels; ++level) {
    bytes += color_bytes(format, texels(level)) + validity_bytes(format, texels(level));
  }
  return bytes;
}

// OpenGL ES names the sRGB forms in an extension of their own.
bool driver_takes(TexelFormat format) {
  if (format == TexelFormat::rgb8) return true;
  if (!epoxy_is_desktop_gl()) return epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc_srgb");
  return epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc") && epoxy_has_gl_extension("GL_EXT_texture_sRGB");
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
  shape.slot_width = round_up(width, unit);
  shape.slot_height = round_up(height, unit);
  return shape;
}

ArrayShape tiles_shape(std::uint32_t slots, const TileOptions& options, const ArrayLimits& limits) {
  const PageLayout pages = pages_for(slots, limits.pages, limits.side / options.slot_px());
  return {options.slot_px(), options.slot_px(),  pages.columns, pages.rows,
          pages.pages,       levels_of(options), options.texels};
}

ArrayShape array_shape(const Snapshot& snapshot) {
  const TileOptions& options = snapshot.tiles.options;
  const std::uint32_t slots = options.max_tiles > 0 ? options.max_tiles : snapshot.tiles.slots_needed();
  ArrayShape shape = snapshot.tiles.whole_views() ? layers_shape(cameras_of(snapshot), options)
                                                  : tiles_shape(slots, options, limits_of_driver());
  if (!driver_takes(shape.format)) shape.format = TexelFormat::rgb8;
  return shape;
}

std::uint32_t PhotographArray::columns_of(const StoredView& view) const {
  return (view.camera.width + tile_width_ - 1) / tile_width_;
}

void PhotographArray::allocate(const ArrayShape& shape) {
  if (shape == shape_ && photographs_.get() != 0) return;
  held_.clear();
  photographs_ = {};  // give the earlier ones back before asking for more
  depths_ = {};
  require_gl_memory(shape.bytes(), free_gl_memory(), "its photographs",
                    "build it with fewer views or a smaller --budget");
  const auto width = static_cast<GLsizei>(shape.columns * shape.slot_width);
  const auto height = static_cast<GLsizei>(shape.rows * shape.slot_height);
  const auto pages = static_cast<GLsizei>(shape.pages);
  const GLenum format = shape.format == TexelFormat::bc3 ? GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT : GL_SRGB8_ALPHA8;
  photographs_ = make_texture_array(format, width, height, pages, GL_LINEAR, static_cast<GLsizei>(shape.levels));
  depths_ = make_texture_array(GL_R16F, width, height, pages, GL_NEAREST);
  shape_ = shape;
}

void PhotographArray::load(const Snapshot& snapshot) {
  const TileTable& tiles = snapshot.tiles;
  const bool whole_views = tiles.whole_views();
  const ArrayShape shape = array_shape(snapshot);
  require_limits(shape, whole_views);
  if (stored_format_ != tiles.options.texels) held_.clear();  // the array may be the same: see array_shape()
  stored_format_ = tiles.options.texels;
  allocate(shape);
  tile_width_ = whole_views ? shape.slot_width : tiles.options.tile_px;
  tile_height_ = whole_views ? shape.slot_height : tiles.options.tile_px;
  gutter_ = whole_views ? 0 : tiles.options.gutter_px;
  held_.resize(std::size_t{shape.columns} * shape.rows * shape.pages);
  std::vector<std::uint32_t> slots = tiles.slots;
  first_tile_ = tiles.first_tile;
  if (whole_views) {
    for (std::uint32_t view = 0; view < snapshot.views.size(); ++view) slots.push_back(view);
    first_tile_ = slots;
  }
  measure_depths(snapshot);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::vector<Upload> missing = missing_tiles(snapshot, slots);
  uploaded_ = static_cast<std::uint32_t>(missing.size());
  // On all processors, but so many at a time that they take little memory. GL takes them from this thread.
  const std::size_t at_once =
      std::max<std::size_t>(kBytesAtOnce / (4 * std::size_t{shape.slot_width} * shape.slot_height), 1);
  for (std::size_t first = 0; first < missing.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, missing.size());
    tbb::parallel_for(first, end, [&](std::size_t i) { prepare(missing[i], *snapshot.views[missing[i].view]); });
    for (std::size_t i = first; i < end; ++i) {
      copy(missing[i]);
      held_[missing[i].slot] = {snapshot.views[missing[i].view], missing[i].tile};
      missing[i] = {};
    }
  }
  check_gl("uploading photographs");
  tile_slots_ = make_table({GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, sizeof(std::uint32_t)},
                           std::as_bytes(std::span<const std::uint32_t>(slots)), "tiles");
}

// Those that are resident, but not in their slots yet.
std::vector<PhotographArray::Upload> PhotographArray::missing_tiles(const Snapshot& snapshot,
                                                                    std::span<const std::uint32_t> slots) const {
  std::vector<Upload> missing;
  for (std::uint32_t view = 0; view < snapshot.views.size(); ++view) {
    if (!snapshot.views[view]) continue;
    const std::uint32_t end = view + 1 < first_tile_.size() ? first_tile_[view + 1] : view + 1;
    for (std::uint32_t number = first_tile_[view]; number < end; ++number) {
      if (slots[number] == kNotResident) continue;
      const std::uint32_t tile = number - first_tile_[view];
      const Held& held = held_[slots[number]];
      if (same(held.view, snapshot.views[view]) && held.tile == tile) continue;
      missing.push_back({slots[number], view, tile, {}, {}});
    }
  }
  return missing;
}

void PhotographArray::measure_depths(const Snapshot& snapshot) {
  scaled_.resize(snapshot.views.size());
  for (std::size_t view = 0; view < scaled_.size(); ++view) {
    if (!snapshot.views[view] || same(scaled_[view].view, snapshot.views[view])) continue;
    scaled_[view] = {snapshot.views[view], depth_scale_of(*snapshot.views[view])};
  }
}

void PhotographArray::prepare(Upload& upload, const StoredView& view) const {
  const std::uint32_t columns = columns_of(view);
  const ImageRect rect{std::int64_t{upload.tile % columns} * tile_width_ - gutter_,
                       std::int64_t{upload.tile / columns} * tile_height_ - gutter_, shape_.slot_width,
                       shape_.slot_height};
  for (ImageLevel& level : image_levels(view, rect, shape_.levels)) {
    if (stored_format_ == TexelFormat::rgb8) {
      upload.levels.push_back(std::move(level.rgba));
      continue;
    }
    std::vector<std::uint8_t> blocks = compressed(level);
    const bool as_they_are = shape_.format == stored_format_;
    upload.levels.push_back(as_they_are ? std::move(blocks) : decompressed(level.width, level.height, blocks).rgba);
  }
  upload.depth = depth_of(view, rect, scaled_[upload.view].scale);
}

void PhotographArray::copy(const Upload& upload) const {
  const std::uint32_t in_page = shape_.columns * shape_.rows;
  const auto page = static_cast<GLint>(upload.slot / in_page);
  const auto x = static_cast<GLint>(upload.slot % in_page % shape_.columns * shape_.slot_width);
  const auto y = static_cast<GLint>(upload.slot % in_page / shape_.columns * shape_.slot_height);
  glBindTexture(GL_TEXTURE_2D_ARRAY, photographs_.get());
  for (GLint number = 0; number < static_cast<GLint>(upload.levels.size()); ++number) {
    const std::vector<std::uint8_t>& level = upload.levels[static_cast<std::size_t>(number)];
    const auto width = static_cast<GLsizei>(shape_.slot_width >> number);
    const auto height = static_cast<GLsizei>(shape_.slot_height >> number);
    if (shape_.format == TexelFormat::bc3) {
      glCompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, number, x >> number, y >> number, page, width, height, 1,
                                GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT, static_cast<GLsizei>(level.size()),
                                level.data());
    } else {
      glTexSubImage3D(GL_TEXTURE_2D_ARRAY, number, x >> number, y >> number, page, width, height, 1, GL_RGBA,
                      GL_UNSIGNED_BYTE, level.data());
    }
  }
  glBindTexture(GL_TEXTURE_2D_ARRAY, depths_.get());
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, x, y, page, static_cast<GLsizei>(shape_.slot_width),
                  static_cast<GLsizei>(shape_.slot_height), 1, GL_RED, GL_HALF_FLOAT, upload.depth.data());
}

}  // namespace lumatlas
