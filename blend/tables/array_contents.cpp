// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/array_contents.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "atlas/images/image_levels.h"
#include "atlas/model/content_digest.h"
#include "atlas/tiles/compressed_texels.h"

namespace lumatlas {

namespace {

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
  for (std::size_t i = sizeof(scale); i < bytes.size(); ++i) {
    const bool is_partial = bytes[i] != std::byte{0} && bytes[i] != std::byte{255};
    if (is_partial) bytes[i] = std::byte{1};
  }
  add_part(view.mask->depth, view.camera, part, bytes);
  if (!view.mask->rim.empty()) add_part(view.mask->rim, view.camera, part, bytes);
  return content_digest(bytes);
}

// Calls `take` with view, number and tile of each resident tile.
template <typename Take>
void for_each_resident(const ArrayContents& contents, const Snapshot& snapshot, const std::vector<TilePlace>& places,
                       const Take& take) {
  for (ViewSlot view{0}; view < snapshot.views.size(); ++view) {
    if (!snapshot.views[view]) continue;
    const std::uint32_t first = contents.first_tile[view];
    const std::uint32_t end = view + 1 < contents.first_tile.size() ? contents.first_tile[view + 1] : view + 1;
    for (std::uint32_t number = first; number < end; ++number) {
      if (places[number] != TilePlace::none) take(view, number, number - first);
    }
  }
}

// Which tile place of a snapshot has each place of the array.
class PlaceOwners {
 public:
  explicit PlaceOwners(ArrayContents& contents)
      : place_of_(contents.place_of), owner_(contents.shape.places(), kNoArrayPlace) {
    for (std::uint32_t place = 0; place < place_of_.size(); ++place) {
      if (place_of_[place] != kNoArrayPlace) owner_[place_of_[place]] = place;
    }
  }

  // The array's place goes from the tile place that has it, if one does, to another.
  void give(std::uint32_t array_place, TilePlace place) {
    std::uint32_t& former = place_of_[place];
    if (former != kNoArrayPlace) owner_[former] = kNoArrayPlace;
    std::uint32_t& owner = owner_[array_place];
    if (owner != kNoArrayPlace) place_of_[owner] = kNoArrayPlace;
    owner = place;
    former = array_place;
  }

 private:
  std::vector<std::uint32_t>& place_of_;
  std::vector<std::uint32_t> owner_;
};

TileUpload upload_for(ViewSlot view, std::uint32_t number, std::uint32_t tile, std::uint32_t array_place) {
  return {number, view, tile, array_place, {}, {}, {}, {}};
}

// Returns the first place from `from` on that is not used.
std::uint32_t next_free(const std::vector<bool>& used, std::uint32_t from) {
  while (used[from]) ++from;
  return from;
}

// Leaves empty what the place holds already. All levels follow from the finest one, and of its colours and validities
// either may be the same.
void prepare_levels(TileUpload& upload, const ArrayContents& contents, const HeldTile& held, const StoredView& view,
                    const ImageRect& rect) {
  ImageLevel finest = std::move(image_levels(view, rect, 1).front());
  std::vector<std::uint8_t> validity = validity_of(finest);
  const bool same_photograph = same(held.photograph, view.photograph) && held.tile == upload.tile;
  upload.digests.color = same_photograph ? held.digests.color : digest_of_colors(finest.rgba);
  upload.digests.validity = digest_of(validity);
  const bool same_colors = held.digests.color == upload.digests.color;
  if (same_colors && held.digests.validity == upload.digests.validity) return;
  const bool in_blocks = contents.stored_format != TexelFormat::rgb8;
  for (ImageLevel& level : with_coarser_levels(std::move(finest), contents.shape.levels)) {
    if (!in_blocks) {
      upload.levels.push_back(std::move(level.rgba));
      continue;
    }
    std::vector<std::uint8_t> blocks = compressed(level);
    const bool as_they_are = contents.shape.format == contents.stored_format;
    upload.levels.push_back(as_they_are ? std::move(blocks) : decompressed(level.width, level.height, blocks).rgba);
  }
  if (in_blocks || !same_colors) return;
  upload.levels.front().clear();
  upload.validity = std::move(validity);
}

void prepare_depths(TileUpload& upload, const ArrayContents& contents, const HeldTile& held, const StoredView& view,
                    std::uint32_t left, std::uint32_t top) {
  const float scale = contents.scaled[upload.view].scale;
  const ArrayShape& shape = contents.shape;
  const ImageRect part{left, top, kDepthBlockSide * shape.depth_columns, kDepthBlockSide * shape.depth_rows};
  upload.digests.depth = digest_of_depths(view, part, scale);
  if (held.digests.depth == upload.digests.depth) return;
  for (std::uint32_t row = 0; row < shape.depth_rows; ++row) {
    for (std::uint32_t column = 0; column < shape.depth_columns; ++column) {
      upload.depth.push_back(depth_block(view, left + kDepthBlockSide * column, top + kDepthBlockSide * row, scale));
    }
  }
}

}  // namespace

bool HeldTile::is(const StoredView& view, std::uint32_t tile_of_view) const {
  return same(photograph, view.photograph) && same(mask, view.mask) && tile == tile_of_view;
}

std::uint64_t TileUpload::bytes() const {
  std::uint64_t bytes = validity.size() + kDepthBlockBytes * depth.size();
  for (const std::vector<std::uint8_t>& level : levels) bytes += level.size();
  return bytes;
}

std::uint32_t ArrayContents::columns_of(const StoredView& view) const {
  return (view.camera.width + tile_size.x - 1) / tile_size.x;
}

std::vector<TilePlace> tile_places(const Snapshot& snapshot) {
  if (!snapshot.tiles.whole_views()) return snapshot.tiles.places;
  std::vector<TilePlace> places;
  for (std::uint32_t view = 0; view < snapshot.views.size(); ++view) places.emplace_back(view);
  return places;
}

void lay_out(ArrayContents& contents, const Snapshot& snapshot, const std::vector<TilePlace>& places) {
  const TileTable& tiles = snapshot.tiles;
  const bool whole_views = tiles.whole_views();
  const ArrayShape& shape = contents.shape;
  contents.stored_format = tiles.options.texels;
  contents.tile_size =
      whole_views ? glm::uvec2(shape.place_width, shape.place_height) : glm::uvec2(tiles.options.tile_px);
  contents.gutter = whole_views ? 0 : tiles.options.gutter_px;
  contents.held.resize(shape.places());
  contents.first_tile = tiles.first_tile;
  if (whole_views) contents.first_tile.assign(places.begin(), places.end());
  contents.tile_entries.assign(places.size(), kNoArrayPlace);
  for (const TilePlace place : places) {
    if (place != TilePlace::none && place >= contents.place_of.size()) {
      contents.place_of.resize(place + 1, kNoArrayPlace);
    }
  }
  contents.scaled.resize(snapshot.views.size());
  for (ViewSlot view{0}; view < snapshot.views.size(); ++view) {
    ArrayContents::Scaled& scaled = contents.scaled[view];
    if (!snapshot.views[view] || same(scaled.mask, snapshot.views[view]->mask)) continue;
    scaled = {snapshot.views[view]->mask, depth_scale(*snapshot.views[view])};
  }
}

std::vector<TileUpload> assign_in_place(ArrayContents& contents, const Snapshot& snapshot,
                                        const std::vector<TilePlace>& places) {
  std::vector<TileUpload> missing;
  std::vector<bool> used(contents.shape.places(), false);
  const auto take = [&](ViewSlot view, std::uint32_t number, std::uint32_t tile, std::uint32_t array_place) {
    used[array_place] = true;
    contents.tile_entries[number] = array_place;
    if (contents.held[array_place].is(*snapshot.views[view], tile)) return;
    missing.push_back(upload_for(view, number, tile, array_place));
  };
  for_each_resident(contents, snapshot, places, [&](ViewSlot view, std::uint32_t number, std::uint32_t tile) {
    const std::uint32_t array_place = contents.place_of[places[number]];
    if (array_place != kNoArrayPlace) take(view, number, tile, array_place);
  });
  PlaceOwners owners(contents);
  std::uint32_t free = 0;
  for_each_resident(contents, snapshot, places, [&](ViewSlot view, std::uint32_t number, std::uint32_t tile) {
    const TilePlace place = places[number];
    if (contents.tile_entries[number] != kNoArrayPlace) return;
    const bool own = place < used.size() && !used[place];
    const std::uint32_t array_place = own ? std::uint32_t{place} : free = next_free(used, free);
    owners.give(array_place, place);
    take(view, number, tile, array_place);
  });
  return missing;
}

namespace {

// Returns the array with all textures new and empty.
NextArray empty_array(const ArrayContents& former, const ArrayShape& shape, const Snapshot& snapshot,
                      const std::vector<TilePlace>& places) {
  NextArray next;
  next.is_new = true;
  next.contents.shape = shape;
  next.contents.scaled = former.scaled;
  lay_out(next.contents, snapshot, places);
  for (TileUpload& upload : assign_in_place(next.contents, snapshot, places)) {
    const TilePlace place = places[upload.number];
    next.missing.push_back({std::move(upload), place, kNoArrayPlace});
  }
  return next;
}

}  // namespace

NextArray next_array(const ArrayContents& former, const Snapshot& snapshot, const ArrayLimits& limits, bool blocks) {
  const ArrayShape needed = array_shape(snapshot, limits, blocks);
  const bool whole_views = snapshot.tiles.whole_views();
  require_limits(needed, limits, whole_views);
  const std::vector<TilePlace> places = tile_places(snapshot);
  const bool comparable = !former.held.empty() && same_layout(former.shape, needed) &&
                          former.stored_format == snapshot.tiles.options.texels;
  if (!comparable) return empty_array(former, needed, snapshot, places);

  NextArray next{former, false, 0, {}};
  ArrayContents& contents = next.contents;
  lay_out(contents, snapshot, places);
  // Places that are drawn from now, and those that stay or get their own tile.
  std::vector<bool> drawn(contents.shape.places(), false);
  for (const std::uint32_t place : former.tile_entries) {
    if (place != kNoArrayPlace) drawn[place] = true;
  }
  std::vector<bool> used = drawn;
  std::size_t kept = 0;
  std::vector<std::uint32_t> elsewhere;  // of `missing`, those that need another place than theirs
  for_each_resident(contents, snapshot, places, [&](ViewSlot view, std::uint32_t number, std::uint32_t tile) {
    const std::uint32_t own = contents.place_of[places[number]];
    if (own != kNoArrayPlace && contents.held[own].is(*snapshot.views[view], tile)) {
      contents.tile_entries[number] = own;
      used[own] = true;
      ++kept;
      return;
    }
    next.missing.push_back({upload_for(view, number, tile, own), places[number], own});
    if (own != kNoArrayPlace && !drawn[own]) {
      contents.tile_entries[number] = own;
      used[own] = true;
    } else {
      elsewhere.push_back(static_cast<std::uint32_t>(next.missing.size() - 1));
    }
  });

  // Where no tile stays, the array would be larger by all that is drawn now, and hold nothing of it.
  if (kept == 0 && !elsewhere.empty()) return empty_array(former, needed, snapshot, places);
  const std::size_t places_needed =
      static_cast<std::size_t>(std::count(used.begin(), used.end(), true)) + elsewhere.size();
  const std::size_t in_page = std::size_t{needed.columns} * needed.rows;
  const ArrayShape both =
      with_pages(needed, std::max(needed.pages, static_cast<std::uint32_t>((places_needed + in_page - 1) / in_page)));
  if (!suffices(contents.shape, both)) {
    const bool grows = both.pages > contents.shape.pages && both.pages <= limits.pages && limits.copies_textures;
    if (!grows) return empty_array(former, needed, snapshot, places);
    next.is_new = true;
    next.copied_pages = contents.shape.pages;
    contents.shape = grown(contents.shape, both, limits);
    contents.held.resize(contents.shape.places());
    used.resize(contents.shape.places(), false);
  }
  PlaceOwners owners(contents);
  std::uint32_t free = 0;
  for (const std::uint32_t index : elsewhere) {
    NextArray::Missing& missing = next.missing[index];
    free = next_free(used, free);
    used[free] = true;
    missing.upload.array_place = free;
    contents.tile_entries[missing.upload.number] = free;
    owners.give(free, missing.place);
  }
  return next;
}

void prepare_upload(TileUpload& upload, const ArrayContents& contents, const HeldTile& held, const StoredView& view) {
  const ArrayShape& shape = contents.shape;
  const std::uint32_t columns = contents.columns_of(view);
  const std::uint32_t left = upload.tile % columns * contents.tile_size.x;
  const std::uint32_t top = upload.tile / columns * contents.tile_size.y;
  const ImageRect rect{std::int64_t{left} - contents.gutter, std::int64_t{top} - contents.gutter, shape.place_width,
                       shape.place_height};
  prepare_levels(upload, contents, held, view, rect);
  prepare_depths(upload, contents, held, view, left, top);
}

bool prepare_missing(NextArray& next, std::size_t index, const ArrayContents& former, const StoredView& view) {
  auto& [upload, place, former_place] = next.missing[index];
  ArrayContents& contents = next.contents;
  const TileUpload unprepared = upload;
  if (former_place != kNoArrayPlace) {
    prepare_upload(upload, contents, former.held[former_place], view);
    if (upload.empty()) {
      upload.array_place = former_place;
      contents.place_of[place] = former_place;
      contents.tile_entries[upload.number] = former_place;
      note_held(contents, upload, view);
      return false;
    }
    // Another place holds nothing of the tile.
    const bool is_partial = !upload.validity.empty() || upload.levels.empty() || upload.depth.empty();
    if (is_partial) upload = unprepared;
  }
  if (upload.empty()) prepare_upload(upload, contents, {}, view);
  note_held(contents, upload, view);
  return true;
}

void note_held(ArrayContents& contents, const TileUpload& upload, const StoredView& view) {
  contents.held[upload.array_place] = {view.photograph, view.mask, upload.tile, upload.digests};
}

}  // namespace lumatlas
