// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/photograph_array.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/gl/gradual_copies.h"

namespace lumatlas {

namespace {

constexpr std::size_t kBytesAtOnce = 64 << 20;  // tiles that are prepared for the GPU at once
constexpr GLenum kDepthFormat = GL_RGBA32UI;

GLenum format_of_photographs(const ArrayShape& shape) {
  return shape.format == TexelFormat::bc7 ? GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM : GL_SRGB8_ALPHA8;
}

// Returns a view of the first levels and pages of an array.
GlTexture view_of(const GlTexture& array, GLenum format, std::uint32_t levels, std::uint32_t pages) {
  GLuint name = 0;
  glGenTextures(1, &name);
  GlTexture view(name);
  glTextureView(name, GL_TEXTURE_2D_ARRAY, array.get(), format, 0, levels, 0, pages);
  return view;
}

// Returns ArrayTextures::raw_texels of the photographs.
GlTexture raw_texels_of(const GlTexture& photographs, const ArrayShape& shape) {
  const bool has_views = epoxy_is_desktop_gl() && epoxy_gl_version() >= 43;
  if (!has_views || shape.format == TexelFormat::bc7 || !draws_in_software()) return {};
  return view_of(photographs, GL_RGBA8, shape.levels, shape.pages);
}

// The photographs, sRGB with validity, and their depths.
ArrayTextures make_textures(const ArrayShape& shape) {
  const auto pages = static_cast<GLsizei>(shape.pages);
  ArrayTextures textures{
      make_texture_array(format_of_photographs(shape), static_cast<GLsizei>(shape.columns * shape.place_width),
                         static_cast<GLsizei>(shape.rows * shape.place_height), pages, GL_LINEAR,
                         static_cast<GLsizei>(shape.levels)),
      make_texture_array(kDepthFormat, static_cast<GLsizei>(shape.columns * shape.depth_columns),
                         static_cast<GLsizei>(shape.rows * shape.depth_rows), pages, GL_NEAREST),
      {}};
  textures.raw_texels = raw_texels_of(textures.photographs, shape);
  return textures;
}

// Rows that are copied between two arrays, the same in each of some pages.
struct PageRows {
  GLint level;
  std::uint32_t width;        // texels
  std::uint32_t first, rows;  // of texels
  std::uint32_t first_page, pages;
};

// Copies texels of an array to the same places of another one.
void copy_texels(const GlTexture& from, const GlTexture& to, const PageRows& part) {
  const auto y = static_cast<GLint>(part.first), page = static_cast<GLint>(part.first_page);
  glCopyImageSubData(from.get(), GL_TEXTURE_2D_ARRAY, part.level, 0, y, page, to.get(), GL_TEXTURE_2D_ARRAY, part.level,
                     0, y, page, static_cast<GLsizei>(part.width), static_cast<GLsizei>(part.rows),
                     static_cast<GLsizei>(part.pages));
}

// One level of the photographs, or their depths, in each page of an array.
struct PageLevel {
  std::uint32_t width, height;  // texels
  std::uint32_t group_rows;     // rows that are copied together
  std::uint64_t group_bytes;

  [[nodiscard]] std::uint32_t groups() const { return height / group_rows; }
};

// The levels of an array, finest first, and then its depths.
std::vector<PageLevel> page_levels(const ArrayShape& shape) {
  std::vector<PageLevel> levels;
  const std::uint32_t group_rows = shape.format == TexelFormat::bc7 ? 4 : 1;
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    const std::uint32_t width = shape.columns * shape.place_width >> level;
    levels.push_back({width, shape.rows * shape.place_height >> level, group_rows, std::uint64_t{4} * width});
  }
  const std::uint32_t columns = shape.columns * shape.depth_columns;
  levels.push_back({columns, shape.rows * shape.depth_rows, 1, kDepthBlockBytes * columns});
  return levels;
}

// Returns how many groups of rows one step copies.
std::uint32_t groups_of_piece(std::uint64_t group_bytes, std::uint32_t left) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(left, std::max<std::uint64_t>(kPieceBytes / group_bytes, 1)));
}

// Copies the first pages.
void copy_pages(const ArrayTextures& from, const ArrayTextures& to, const ArrayShape& shape, std::uint32_t pages) {
  const std::vector<PageLevel> levels = page_levels(shape);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const bool is_depth = i == shape.levels;
    copy_texels(is_depth ? from.depths : from.photographs, is_depth ? to.depths : to.photographs,
                {is_depth ? 0 : static_cast<GLint>(i), levels[i].width, 0, levels[i].height, 0, pages});
  }
  check_gl("copying photographs");
}

struct Texel {
  std::uint32_t x, y, page;
};

// Returns the first texel of a place.
Texel first_texel(const ArrayShape& shape, std::uint32_t place) {
  const std::uint32_t in_page = shape.columns * shape.rows;
  return {place % in_page % shape.columns * shape.place_width, place % in_page / shape.columns * shape.place_height,
          place / in_page};
}

// Copies rows of a level of a place; of compressed texels rows of blocks. `bytes`: of these rows.
void copy_rows(const GlTexture& photographs, const ArrayShape& shape, std::uint32_t place, GLint level,
               std::uint32_t first_row, std::uint32_t rows, std::span<const std::uint8_t> bytes) {
  const Texel first = first_texel(shape, place);
  const auto x = static_cast<GLint>(first.x >> level);
  const auto y = static_cast<GLint>((first.y >> level) + first_row);
  const auto page = static_cast<GLint>(first.page);
  const auto width = static_cast<GLsizei>(shape.place_width >> level), height = static_cast<GLsizei>(rows);
  glBindTexture(GL_TEXTURE_2D_ARRAY, photographs.get());
  if (shape.format == TexelFormat::bc7) {
    glCompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, x, y, page, width, height, 1,
                              GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM, static_cast<GLsizei>(bytes.size()), bytes.data());
  } else {
    glTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, x, y, page, width, height, 1, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  }
}

void copy_block_rows(const GlTexture& depths, const ArrayShape& shape, std::uint32_t place, std::uint32_t first_row,
                     std::uint32_t rows, const DepthBlock* blocks) {
  const Texel first = first_texel(shape, place);
  glBindTexture(GL_TEXTURE_2D_ARRAY, depths.get());
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, static_cast<GLint>(first.x / shape.place_width * shape.depth_columns),
                  static_cast<GLint>(first.y / shape.place_height * shape.depth_rows + first_row),
                  static_cast<GLint>(first.page), static_cast<GLsizei>(shape.depth_columns), static_cast<GLsizei>(rows),
                  1, GL_RGBA_INTEGER, GL_UNSIGNED_INT, blocks);
}

}  // namespace

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

ArrayLimits limits_of_driver() {
  return {static_cast<std::uint32_t>(gl_limit(GL_MAX_ARRAY_TEXTURE_LAYERS)),
          static_cast<std::uint32_t>(gl_limit(GL_MAX_TEXTURE_SIZE)), driver_takes(TexelFormat::bc7),
          epoxy_gl_version() >= (epoxy_is_desktop_gl() ? 43 : 32)};
}

ArrayShape array_shape(const Snapshot& snapshot, bool blocks) {
  return array_shape(snapshot, limits_of_driver(), blocks);
}

// A larger one beside the one that is there, with what that one holds. False if the driver cannot do that.
bool PhotographArray::grow(const ArrayShape& needed) {
  const ArrayLimits limits = limits_of_driver();
  const ArrayShape& there = contents_->shape;
  const bool only_more = textures_.photographs.get() != 0 && same_layout(needed, there);
  if (!only_more || needed.pages < there.pages || !limits.copies_textures) return false;
  const ArrayShape shape = grown(there, needed, limits);
  if (const auto available = free_gl_memory(); available && shape.bytes() > *available) return false;
  try {
    ArrayTextures larger = make_textures(shape);
    copy_pages(textures_, larger, there, there.pages);
    textures_ = std::move(larger);
  } catch (const GlError&) {  // there is no room for both
    return false;
  }
  contents_->shape = shape;
  return true;
}

// Makes contents that may change, and whose places hold what they say.
void PhotographArray::own_contents() {
  contents_ = std::make_shared<ArrayContents>(*contents_);
  for (const std::uint32_t place : unknown_places_) contents_->held[place] = {};
  unknown_places_.clear();
}

void PhotographArray::allocate(const ArrayShape& shape) {
  if (textures_.photographs.get() != 0 && suffices(contents_->shape, shape)) return;
  if (grow(shape)) return;
  contents_->held.clear();
  contents_->place_of.clear();
  textures_ = {};  // give the earlier ones back before asking for more
  require_gl_memory(shape.bytes(), free_gl_memory(), "its photographs",
                    "build it with fewer views or a smaller --budget");
  textures_ = make_textures(shape);
  contents_->shape = shape;
}

void PhotographArray::load(const Snapshot& snapshot, bool blocks) {
  const ArrayLimits limits = limits_of_driver();
  const ArrayShape shape = array_shape(snapshot, limits, blocks);
  require_limits(shape, limits, snapshot.tiles.whole_views());
  own_contents();
  // The array may be the same: see array_shape().
  if (contents_->stored_format != snapshot.tiles.options.texels) contents_->held.clear();
  allocate(shape);
  const std::vector<TilePlace> places = tile_places(snapshot);
  lay_out(*contents_, snapshot, places);
  std::vector<TileUpload> missing = assign_in_place(*contents_, snapshot, places);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  uploaded_ = 0;
  // Tiles are prepared on all processors, kBytesAtOnce of them at a time. GL takes them from this thread.
  const std::size_t at_once =
      std::max<std::size_t>(kBytesAtOnce / (4 * std::size_t{shape.place_width} * shape.place_height), 1);
  for (std::size_t first = 0; first < missing.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, missing.size());
    tbb::parallel_for(first, end, [&](std::size_t i) {
      prepare_upload(missing[i], *contents_, contents_->held[missing[i].array_place], *snapshot.views[missing[i].view]);
    });
    // Should copying fail, it is not known what the places hold.
    for (std::size_t i = first; i < end; ++i) contents_->held[missing[i].array_place] = {};
    copy(std::span(missing).subspan(first, end - first));
    for (std::size_t i = first; i < end; ++i) {
      note_held(*contents_, missing[i], *snapshot.views[missing[i].view]);
      missing[i] = {};
    }
  }
  check_gl("uploading photographs");
  tile_entries_.store(std::as_bytes(std::span(contents_->tile_entries)));
}

void PhotographArray::copy(std::span<const TileUpload> uploads) {
  std::vector<PlacedMask> masks;
  for (const TileUpload& upload : uploads) {
    uploaded_ += upload.empty() ? 0 : 1;
    copy_levels(upload);
    copy_depths(upload);
    if (upload.validity.empty()) continue;
    const Texel first = first_texel(contents_->shape, upload.array_place);
    masks.push_back({first.x, first.y, first.page, upload.validity});
    mask_bytes_ += upload.validity.size();
  }
  if (!masks.empty()) {
    mask_pass_.write(textures_.photographs, contents_->shape.place_width, contents_->shape.place_height, masks);
  }
}

void PhotographArray::copy_levels(const TileUpload& upload) {
  for (std::uint32_t level = 0; level < upload.levels.size(); ++level) {
    const std::vector<std::uint8_t>& texels = upload.levels[level];
    if (texels.empty()) continue;
    (upload.validity.empty() ? color_bytes_ : mask_bytes_) += texels.size();
    copy_rows(textures_.photographs, contents_->shape, upload.array_place, static_cast<GLint>(level), 0,
              contents_->shape.place_height >> level, texels);
  }
}

void PhotographArray::copy_depths(const TileUpload& upload) {
  if (upload.depth.empty()) return;
  depth_bytes_ += kDepthBlockBytes * upload.depth.size();
  copy_block_rows(textures_.depths, contents_->shape, upload.array_place, 0, contents_->shape.depth_rows,
                  upload.depth.data());
}

ArrayTextures PhotographArray::allocate_next(const ArrayShape& shape) {
  require_gl_memory(shape.bytes(), free_gl_memory(), "its photographs beside those that are drawn meanwhile",
                    "load it at once");
  ArrayTextures textures = make_textures(shape);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  return textures;
}

std::uint32_t PhotographArray::page_rows() const {
  std::uint32_t rows = 0;
  for (const PageLevel& level : page_levels(contents_->shape)) rows += level.groups();
  return rows;
}

PhotographArray::CopiedRows PhotographArray::copy_page_rows(const ArrayTextures& next, std::uint32_t page,
                                                            std::uint32_t from) const {
  const std::vector<PageLevel> levels = page_levels(contents_->shape);
  std::size_t level = 0;
  std::uint32_t first = from;
  while (first >= levels[level].groups()) first -= levels[level++].groups();
  const bool is_depth = level == contents_->shape.levels;
  const PageLevel& of = levels[level];
  const std::uint32_t count = groups_of_piece(of.group_bytes, of.groups() - first);
  copy_texels(
      is_depth ? textures_.depths : textures_.photographs, is_depth ? next.depths : next.photographs,
      {is_depth ? 0 : static_cast<GLint>(level), of.width, first * of.group_rows, count * of.group_rows, page, 1});
  check_gl("copying photographs");
  return {count, count * of.group_bytes};
}

std::uint64_t PhotographArray::copy_band(const ArrayTextures& next, const ArrayShape& shape, const TileUpload& upload,
                                         std::uint64_t from) {
  const bool in_place = next.photographs.get() == 0;
  const ArrayTextures& textures = in_place ? textures_ : next;
  if (in_place) unknown_places_.insert(upload.array_place);                   // the next snapshot may be given up
  const std::uint32_t texel_rows = shape.format == TexelFormat::bc7 ? 4 : 1;  // that are copied together
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::uint64_t before = 0;
  for (std::uint32_t level = 0; level < upload.levels.size(); before += upload.levels[level].size(), ++level) {
    const std::span<const std::uint8_t> texels(upload.levels[level]);
    if (from >= before + texels.size()) continue;
    const std::uint32_t groups = (shape.place_height >> level) / texel_rows;
    const std::uint64_t group_bytes = texels.size() / groups;
    const auto first = static_cast<std::uint32_t>((from - before) / group_bytes);
    const std::uint32_t count = groups_of_piece(group_bytes, groups - first);
    copy_rows(textures.photographs, shape, upload.array_place, static_cast<GLint>(level), first * texel_rows,
              count * texel_rows, texels.subspan(first * group_bytes, count * group_bytes));
    color_bytes_ += count * group_bytes;
    check_gl("uploading photographs");
    return from + count * group_bytes;
  }
  const std::uint64_t row_bytes = kDepthBlockBytes * shape.depth_columns;
  const auto first = static_cast<std::uint32_t>((from - before) / row_bytes);
  const std::uint32_t count = groups_of_piece(row_bytes, shape.depth_rows - first);
  copy_block_rows(textures.depths, shape, upload.array_place, first, count,
                  &upload.depth[std::size_t{first} * shape.depth_columns]);
  depth_bytes_ += count * row_bytes;
  check_gl("uploading depths");
  return from + count * row_bytes;
}

ArrayTextures PhotographArray::memory() const {
  if (!epoxy_is_desktop_gl() || textures_.photographs.get() == 0) return {};
  ArrayTextures memory{view_of(textures_.photographs, format_of_photographs(shape()), 1, 1),
                       view_of(textures_.depths, kDepthFormat, 1, 1),
                       {}};
  check_gl("keeping the memory of photographs");
  return memory;
}

void PhotographArray::take(ArrayTextures next, ArrayContents contents, GlTable tile_entries) {
  if (next.photographs.get() != 0) textures_ = std::move(next);
  contents_ = std::make_shared<ArrayContents>(std::move(contents));
  unknown_places_.clear();
  tile_entries_ = std::move(tile_entries);
}

}  // namespace lumatlas
