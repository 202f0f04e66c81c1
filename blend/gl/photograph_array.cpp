// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/photograph_array.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "atlas/images/image_levels.h"
#include "atlas/model/content_digest.h"
#include "atlas/tiles/compressed_texels.h"
#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

constexpr std::size_t kBytesAtOnce = 64 << 20;  // tiles that are prepared for the GPU at once

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
      std::max(std::uint64_t{shape.columns} * shape.place_width, std::uint64_t{shape.rows} * shape.place_height);
  require_limit(side, GL_MAX_TEXTURE_SIZE, "pixels a side for its photographs", "scale the photographs down");
  require_limit(shape.pages, GL_MAX_ARRAY_TEXTURE_LAYERS, whole_views ? "views" : "pages of tiles",
                whole_views ? "build it with fewer (--max-views)" : "build it with a smaller --budget");
}

ArrayShape with_pages(ArrayShape shape, std::uint32_t pages) {
  shape.pages = pages;
  return shape;
}

// An array stays where as many pages or fewer are needed, unless more than half of it would be of no use.
bool suffices(const ArrayShape& there, const ArrayShape& needed) {
  return with_pages(needed, there.pages) == there && needed.pages <= there.pages && there.pages <= 2 * needed.pages;
}

// Returns the shape that replaces an array that has become too small: a quarter more, so that all copies of a store
// that grows view by view are a few times its size.
ArrayShape grown(const ArrayShape& there, const ArrayShape& needed) {
  const std::uint32_t most = std::max(limits_of_driver().pages, needed.pages);
  return with_pages(needed, std::clamp(there.pages + there.pages / 4, needed.pages, most));
}

bool driver_copies_textures() {
  return epoxy_gl_version() >= (epoxy_is_desktop_gl() ? 43 : 32);
}

// The photographs, sRGB with validity, and their depths.
GlTexture make_photographs(const ArrayShape& shape) {
  const GLenum format = shape.format == TexelFormat::bc7 ? GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM : GL_SRGB8_ALPHA8;
  return make_texture_array(format, static_cast<GLsizei>(shape.columns * shape.place_width),
                            static_cast<GLsizei>(shape.rows * shape.place_height), static_cast<GLsizei>(shape.pages),
                            GL_LINEAR, static_cast<GLsizei>(shape.levels));
}

GlTexture make_depths(const ArrayShape& shape) {
  return make_texture_array(GL_RGBA32UI, static_cast<GLsizei>(shape.columns * shape.depth_columns),
                            static_cast<GLsizei>(shape.rows * shape.depth_rows), static_cast<GLsizei>(shape.pages),
                            GL_NEAREST);
}

// All pages of one level of an array that another one has as its first.
void copy_level(const GlTexture& from, const GlTexture& to, GLint level, std::uint32_t width, std::uint32_t height,
                std::uint32_t pages) {
  glCopyImageSubData(from.get(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, to.get(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0,
                     static_cast<GLsizei>(width >> level), static_cast<GLsizei>(height >> level),
                     static_cast<GLsizei>(pages));
}

template <typename Part>
bool same(const std::weak_ptr<const Part>& a, const std::shared_ptr<const Part>& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

std::uint64_t digest_of(std::span<const std::uint8_t> bytes) {
  return content_digest(std::as_bytes(bytes));
}

std::uint64_t digest_of_colors(std::vector<std::uint8_t> rgba) {
  for (std::size_t alpha = 3; alpha < rgba.size(); alpha += 4) rgba[alpha] = 0;
  return digest_of(rgba);
}

std::vector<std::uint8_t> validity_of(const ImageLevel& level) {
  std::vector<std::uint8_t> validity(level.rgba.size() / 4);
  for (std::size_t texel = 0; texel < validity.size(); ++texel) validity[texel] = level.rgba[4 * texel + 3];
  return validity;
}

// Appends the rows of a part of an image; what lies beyond the image has no values.
template <typename T>
void add_part(const PixelList<T>& values, const Camera& image, const ImageRect& part, std::vector<std::byte>& bytes) {
  const std::int64_t left = std::max<std::int64_t>(part.x, 0), top = std::max<std::int64_t>(part.y, 0);
  const std::int64_t right = std::min<std::int64_t>(part.x + part.width, image.width);
  const std::int64_t bottom = std::min<std::int64_t>(part.y + part.height, image.height);
  std::vector<T> row(static_cast<std::size_t>(std::max<std::int64_t>(right - left, 0)));
  for (std::int64_t y = top; y < bottom && !row.empty(); ++y) {
    values.copy(static_cast<std::size_t>(y * image.width + left), row);
    const auto row_bytes = std::as_bytes(std::span(row));
    bytes.insert(bytes.end(), row_bytes.begin(), row_bytes.end());
  }
}

// Returns a digest of all that depth_block() looks at in a part of a view.
std::uint64_t digest_of_depths(const StoredView& view, const ImageRect& part, float scale) {
  std::vector<std::byte> bytes(sizeof(scale));
  bytes.reserve(sizeof(scale) + 6 * std::size_t{part.width + 2} * (part.height + 2));
  std::memcpy(bytes.data(), &scale, sizeof(scale));
  add_part(view.mask->validity, view.camera, {part.x - 1, part.y - 1, part.width + 2, part.height + 2}, bytes);
  for (std::size_t i = sizeof(scale); i < bytes.size(); ++i) bytes[i] = std::byte{bytes[i] != std::byte{0}};
  add_part(view.mask->depth, view.camera, part, bytes);
  if (!view.mask->rim.empty()) add_part(view.mask->rim, view.camera, part, bytes);
  return content_digest(bytes);
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

// OpenGL has had BC7 since 4.2; OpenGL ES has it as an extension.
bool driver_takes(TexelFormat format) {
  return format == TexelFormat::rgb8 || epoxy_is_desktop_gl() ||
         epoxy_has_gl_extension("GL_EXT_texture_compression_bptc");
}

bool draws_in_software() {
  const auto* const name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  if (name == nullptr) throw GlError("the current OpenGL context does not tell its renderer");
  const std::string renderer = name;
  return renderer.find("llvmpipe") != std::string::npos || renderer.find("softpipe") != std::string::npos ||
         renderer.find("SwiftShader") != std::string::npos;
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

ArrayShape array_shape(const Snapshot& snapshot, bool blocks) {
  const TileOptions& options = snapshot.tiles.options;
  const std::uint32_t places = options.max_tiles > 0 ? options.max_tiles : snapshot.tiles.places_needed();
  ArrayShape shape = snapshot.tiles.whole_views() ? layers_shape(cameras_of(snapshot), options)
                                                  : tiles_shape(places, options, limits_of_driver());
  if (!blocks || !driver_takes(shape.format)) shape.format = TexelFormat::rgb8;
  return shape;
}

std::uint32_t PhotographArray::columns_of(const StoredView& view) const {
  return (view.camera.width + tile_width_ - 1) / tile_width_;
}

// A larger one beside the one that is there, with what that one holds. False if the driver cannot do that.
bool PhotographArray::grow(const ArrayShape& needed) {
  const bool only_more = photographs_.get() != 0 && with_pages(needed, shape_.pages) == shape_;
  if (!only_more || needed.pages < shape_.pages || !driver_copies_textures()) return false;
  const ArrayShape shape = grown(shape_, needed);
  if (const auto available = free_gl_memory(); available && shape.bytes() > *available) return false;
  try {
    GlTexture photographs = make_photographs(shape);
    GlTexture depths = make_depths(shape);
    for (std::uint32_t level = 0; level < shape_.levels; ++level) {
      copy_level(photographs_, photographs, static_cast<GLint>(level), shape_.columns * shape_.place_width,
                 shape_.rows * shape_.place_height, shape_.pages);
    }
    copy_level(depths_, depths, 0, shape_.columns * shape_.depth_columns, shape_.rows * shape_.depth_rows,
               shape_.pages);
    check_gl("copying photographs");
    photographs_ = std::move(photographs);
    depths_ = std::move(depths);
  } catch (const GlError&) {  // there is no room for both
    return false;
  }
  shape_ = shape;
  return true;
}

void PhotographArray::allocate(const ArrayShape& shape) {
  if (photographs_.get() != 0 && suffices(shape_, shape)) return;
  if (grow(shape)) return;
  held_.clear();
  photographs_ = {};  // give the earlier ones back before asking for more
  depths_ = {};
  require_gl_memory(shape.bytes(), free_gl_memory(), "its photographs",
                    "build it with fewer views or a smaller --budget");
  photographs_ = make_photographs(shape);
  depths_ = make_depths(shape);
  shape_ = shape;
}

void PhotographArray::load(const Snapshot& snapshot, bool blocks) {
  const TileTable& tiles = snapshot.tiles;
  const bool whole_views = tiles.whole_views();
  const ArrayShape shape = array_shape(snapshot, blocks);
  require_limits(shape, whole_views);
  if (stored_format_ != tiles.options.texels) held_.clear();  // the array may be the same: see array_shape()
  stored_format_ = tiles.options.texels;
  allocate(shape);
  tile_width_ = whole_views ? shape.place_width : tiles.options.tile_px;
  tile_height_ = whole_views ? shape.place_height : tiles.options.tile_px;
  gutter_ = whole_views ? 0 : tiles.options.gutter_px;
  held_.resize(std::size_t{shape_.columns} * shape_.rows * shape_.pages);
  std::vector<TilePlace> places = tiles.places;
  first_tile_ = tiles.first_tile;
  if (whole_views) {
    for (std::uint32_t view = 0; view < snapshot.views.size(); ++view) places.emplace_back(view);
    first_tile_.assign(places.begin(), places.end());
  }
  measure_depths(snapshot);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::vector<Upload> missing = missing_tiles(snapshot, places);
  uploaded_ = 0;
  // Tiles are prepared on all processors, kBytesAtOnce of them at a time. GL takes them from this thread.
  const std::size_t at_once =
      std::max<std::size_t>(kBytesAtOnce / (4 * std::size_t{shape.place_width} * shape.place_height), 1);
  for (std::size_t first = 0; first < missing.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, missing.size());
    tbb::parallel_for(first, end, [&](std::size_t i) { prepare(missing[i], *snapshot.views[missing[i].view]); });
    // Should copying fail, it is not known what the tile places hold.
    for (std::size_t i = first; i < end; ++i) held_[missing[i].place] = {};
    copy(std::span(missing).subspan(first, end - first));
    for (std::size_t i = first; i < end; ++i) {
      const StoredView& view = *snapshot.views[missing[i].view];
      held_[missing[i].place] = {view.photograph, view.mask, missing[i].tile, missing[i].digests};
      missing[i] = {};
    }
  }
  check_gl("uploading photographs");
  tile_slots_.store(std::as_bytes(std::span<const TilePlace>(places)));
}

// Returns the tiles that are resident, but not in their tile places yet.
std::vector<PhotographArray::Upload> PhotographArray::missing_tiles(const Snapshot& snapshot,
                                                                    std::span<const TilePlace> places) const {
  std::vector<Upload> missing;
  for (ViewSlot view{0}; view < snapshot.views.size(); ++view) {
    if (!snapshot.views[view]) continue;
    const std::uint32_t end = view + 1 < first_tile_.size() ? first_tile_[view + 1] : view + 1;
    for (std::uint32_t number = first_tile_[view]; number < end; ++number) {
      const TilePlace place = places[number];
      if (place == TilePlace::none) continue;
      const std::uint32_t tile = number - first_tile_[view];
      const Held& held = held_[place];
      if (same(held.photograph, snapshot.views[view]->photograph) && same(held.mask, snapshot.views[view]->mask) &&
          held.tile == tile) {
        continue;
      }
      missing.push_back({place, view, tile, {}, {}, {}, {}});
    }
  }
  return missing;
}

void PhotographArray::measure_depths(const Snapshot& snapshot) {
  scaled_.resize(snapshot.views.size());
  for (ViewSlot view{0}; view < scaled_.size(); ++view) {
    if (!snapshot.views[view] || same(scaled_[view].mask, snapshot.views[view]->mask)) continue;
    scaled_[view] = {snapshot.views[view]->mask, lumatlas::depth_scale(*snapshot.views[view])};
  }
}

void PhotographArray::prepare(Upload& upload, const StoredView& view) const {
  const std::uint32_t columns = columns_of(view);
  const std::uint32_t left = upload.tile % columns * tile_width_, top = upload.tile / columns * tile_height_;
  const ImageRect rect{std::int64_t{left} - gutter_, std::int64_t{top} - gutter_, shape_.place_width,
                       shape_.place_height};
  prepare_levels(upload, view, rect);
  prepare_depths(upload, view, left, top);
}

// Leaves empty what the tile place holds already. All levels follow from the finest one, and of its colours and
// validities either may be the same.
void PhotographArray::prepare_levels(Upload& upload, const StoredView& view, const ImageRect& rect) const {
  const Held& held = held_[upload.place];
  ImageLevel finest = std::move(image_levels(view, rect, 1).front());
  std::vector<std::uint8_t> validity = validity_of(finest);
  const bool same_photograph = same(held.photograph, view.photograph) && held.tile == upload.tile;
  upload.digests.color = same_photograph ? held.digests.color : digest_of_colors(finest.rgba);
  upload.digests.validity = digest_of(validity);
  const bool same_colors = held.digests.color == upload.digests.color;
  if (same_colors && held.digests.validity == upload.digests.validity) return;
  const bool in_blocks = stored_format_ != TexelFormat::rgb8;
  for (ImageLevel& level : with_coarser_levels(std::move(finest), shape_.levels)) {
    if (!in_blocks) {
      upload.levels.push_back(std::move(level.rgba));
      continue;
    }
    std::vector<std::uint8_t> blocks = compressed(level);
    const bool as_they_are = shape_.format == stored_format_;
    upload.levels.push_back(as_they_are ? std::move(blocks) : decompressed(level.width, level.height, blocks).rgba);
  }
  if (in_blocks || !same_colors) return;
  upload.levels.front().clear();
  upload.validity = std::move(validity);
}

void PhotographArray::prepare_depths(Upload& upload, const StoredView& view, std::uint32_t left,
                                     std::uint32_t top) const {
  const float scale = scaled_[upload.view].scale;
  const ImageRect part{left, top, kDepthBlockSide * shape_.depth_columns, kDepthBlockSide * shape_.depth_rows};
  upload.digests.depth = digest_of_depths(view, part, scale);
  if (held_[upload.place].digests.depth == upload.digests.depth) return;
  for (std::uint32_t row = 0; row < shape_.depth_rows; ++row) {
    for (std::uint32_t column = 0; column < shape_.depth_columns; ++column) {
      upload.depth.push_back(depth_block(view, left + kDepthBlockSide * column, top + kDepthBlockSide * row, scale));
    }
  }
}

PhotographArray::Texel PhotographArray::first_texel(TilePlace place) const {
  const std::uint32_t in_page = shape_.columns * shape_.rows;
  return {place % in_page % shape_.columns * shape_.place_width, place % in_page / shape_.columns * shape_.place_height,
          place / in_page};
}

void PhotographArray::copy(std::span<const Upload> uploads) {
  std::vector<PlacedMask> masks;
  for (const Upload& upload : uploads) {
    uploaded_ += upload.levels.empty() && upload.depth.empty() ? 0 : 1;
    copy_levels(upload);
    copy_depths(upload);
    if (upload.validity.empty()) continue;
    const Texel first = first_texel(upload.place);
    masks.push_back({first.x, first.y, first.page, upload.validity});
    mask_bytes_ += upload.validity.size();
  }
  if (!masks.empty()) mask_pass_.write(photographs_, shape_.place_width, shape_.place_height, masks);
}

void PhotographArray::copy_levels(const Upload& upload) {
  const Texel first = first_texel(upload.place);
  const auto x = static_cast<GLint>(first.x), y = static_cast<GLint>(first.y), page = static_cast<GLint>(first.page);
  glBindTexture(GL_TEXTURE_2D_ARRAY, photographs_.get());
  for (GLint number = 0; number < static_cast<GLint>(upload.levels.size()); ++number) {
    const std::vector<std::uint8_t>& level = upload.levels[static_cast<std::size_t>(number)];
    if (level.empty()) continue;
    (upload.validity.empty() ? color_bytes_ : mask_bytes_) += level.size();
    const auto width = static_cast<GLsizei>(shape_.place_width >> number);
    const auto height = static_cast<GLsizei>(shape_.place_height >> number);
    if (shape_.format == TexelFormat::bc7) {
      glCompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, number, x >> number, y >> number, page, width, height, 1,
                                GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM, static_cast<GLsizei>(level.size()), level.data());
    } else {
      glTexSubImage3D(GL_TEXTURE_2D_ARRAY, number, x >> number, y >> number, page, width, height, 1, GL_RGBA,
                      GL_UNSIGNED_BYTE, level.data());
    }
  }
}

void PhotographArray::copy_depths(const Upload& upload) {
  if (upload.depth.empty()) return;
  depth_bytes_ += kDepthBlockBytes * upload.depth.size();
  const Texel first = first_texel(upload.place);
  glBindTexture(GL_TEXTURE_2D_ARRAY, depths_.get());
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, static_cast<GLint>(first.x / shape_.place_width * shape_.depth_columns),
                  static_cast<GLint>(first.y / shape_.place_height * shape_.depth_rows), static_cast<GLint>(first.page),
                  static_cast<GLsizei>(shape_.depth_columns), static_cast<GLsizei>(shape_.depth_rows), 1,
                  GL_RGBA_INTEGER, GL_UNSIGNED_INT, upload.depth.data());
}

}  // namespace lumatlas
