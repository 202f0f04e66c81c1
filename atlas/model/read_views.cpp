// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/read_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <span>
#include <utility>

#include "atlas/images/photograph.h"
#include "atlas/model/watch.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/pixel_rect.h"
#include "mesh/visibility/ray_visibility.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Returns the rectangle with `by` more pixels on each side, cut at the border of the image.
PixelRect grown(const PixelRect& rect, std::uint32_t by, const Camera& camera) {
  const std::uint32_t x = rect.x - std::min(rect.x, by), y = rect.y - std::min(rect.y, by);
  return {x, y, std::min(rect.right() + by, camera.width) - x, std::min(rect.bottom() + by, camera.height) - y};
}

// Returns the resident tiles of a view with their gutters. Tiles beside each other in a row are one rectangle.
std::vector<PixelRect> resident_parts(const TileTable& tiles, ViewSlot view, const Camera& camera) {
  const std::uint32_t side = tiles.options.tile_px;
  const TileGrid grid(camera.width, camera.height, side);
  std::vector<PixelRect> parts;
  for (std::uint32_t row = 0; row < grid.rows; ++row) {
    const auto first = tiles.places.begin() + tiles.first_tile[view] + row * grid.columns;
    for (std::uint32_t column = 0; column < grid.columns; ++column) {
      if (first[column] == TilePlace::none) continue;
      const std::uint32_t begin = column;
      while (column + 1 < grid.columns && first[column + 1] != TilePlace::none) ++column;
      const PixelRect of_tiles{begin * side, row * side, (column + 1 - begin) * side, side};
      parts.push_back(grown(of_tiles, tiles.options.gutter_px, camera));
    }
  }
  return parts;
}

// Returns the part of an image's list; empty for an empty one.
template <typename T>
std::vector<T> part_of(std::span<const T> values, std::uint32_t width, const PixelRect& part) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(part.pixels());
  for (std::uint32_t y = part.y; y < part.bottom(); ++y) {
    const auto row = values.subspan(std::size_t{y} * width + part.x, part.width);
    result.insert(result.end(), row.begin(), row.end());
  }
  return result;
}

// Makes the depths and masks of a view's resident parts, each from a window around it, so that memory follows the parts
// and not the image.
class PartialMask {
 public:
  // `frame`: the photograph; its colours may be missing. `trust` as in ViewMask.
  PartialMask(const Camera& camera, const Photograph& frame, std::span<const std::uint8_t> trust,
              const RayVisibility& visibility, const ValidityOptions& options)
      : camera_(camera), frame_(frame), trust_(trust), visibility_(visibility), options_(options) {
    const std::uint32_t width = camera.width, height = camera.height;
    mask_->depth = {width, height, std::numeric_limits<float>::infinity()};
    mask_->validity = {width, height, 0};
    if (!trust.empty()) mask_->trust = {width, height, 255};
    if (options.edges == ValidityOptions::Edges::far_side) mask_->rim = {width, height, 0};
  }

  void add(const PixelRect& part, ReadTimes& times) {
    Watch watch;
    // The mask of a pixel depends on depths as far away as the fade, and as the edges of what is beyond it.
    const PixelRect looked_at = grown(part, options_.fade_px + 1 + options_.edge_radius_px, camera_);
    const PixelRect window = window_for_part(camera_, looked_at);
    std::vector<std::uint8_t> wanted(window.pixels(), 0);
    for (std::uint32_t y = looked_at.y; y < looked_at.bottom(); ++y) {
      const std::size_t first = std::size_t{y - window.y} * window.width + (looked_at.x - window.x);
      std::fill_n(wanted.begin() + static_cast<std::ptrdiff_t>(first), looked_at.width, std::uint8_t{1});
    }
    visibility_.trace_part(camera_, window, wanted, visible_);
    times.depth += watch.lap_ms();
    const PixelRect in_window{looked_at.x - window.x, looked_at.y - window.y, looked_at.width, looked_at.height};
    const std::vector<float> depth = part_of<float>(visible_.depth, window.width, in_window);
    const std::vector<std::uint8_t> trust = part_of<std::uint8_t>(trust_, camera_.width, looked_at);
    const Photograph frame{
        looked_at.width, looked_at.height, {}, part_of<std::uint8_t>(frame_.valid, camera_.width, looked_at)};
    const PixelRect inner{part.x - looked_at.x, part.y - looked_at.y, part.width, part.height};
    const auto set = [&]<typename T>(PixelList<T>& list, const std::vector<T>& values) {
      if (!list.empty()) list.set_part(part, part_of<T>(values, looked_at.width, inner));
    };
    set(mask_->depth, depth);
    set(mask_->trust, trust);
    set(mask_->validity, validity_mask(frame, depth, trust, options_));
    set(mask_->rim, rim_pixels(frame, depth, options_));
    times.masks += watch.lap_ms();
  }

  // Returns the mask once all parts are added.
  [[nodiscard]] std::shared_ptr<const ViewMask> mask() {
    mask_->depth.settle();
    mask_->validity.settle();
    mask_->trust.settle();
    mask_->rim.settle();
    return mask_;
  }

 private:
  const Camera& camera_;
  const Photograph& frame_;
  std::span<const std::uint8_t> trust_;
  const RayVisibility& visibility_;
  const ValidityOptions& options_;
  VisibilityBuffer visible_;
  std::shared_ptr<ViewMask> mask_ = std::make_shared<ViewMask>();
};

class ViewReader {
 public:
  ViewReader(const fs::path& model, const Mesh& mesh, const TileTable& tiles, const ValidityOptions& options)
      : model_(model), visibility_(mesh), tiles_(tiles), options_(options) {}

  // Returns null where nothing of the view is shown.
  [[nodiscard]] std::shared_ptr<const StoredView> read(const ViewEntry& entry, ViewSlot number,
                                                       ReadTimes& times) const {
    const Camera& camera = entry.camera;
    if (tiles_.whole_views()) return std::make_shared<const StoredView>(read_whole(entry, times));
    const std::vector<PixelRect> parts = resident_parts(tiles_, number, camera);
    if (parts.empty()) return nullptr;
    const auto all = tiles_.places.begin() + tiles_.first_tile[number];
    const auto end = tiles_.places.begin() + tiles_.first_tile[number + 1];
    const bool is_whole = std::find(all, end, TilePlace::none) == end;
    return std::make_shared<const StoredView>(is_whole ? read_whole(entry, times) : read_parts(entry, parts, times));
  }

 private:
  [[nodiscard]] StoredView read_whole(const ViewEntry& entry, ReadTimes& times) const {
    Watch watch;
    Photograph photograph = photograph_of(entry);
    std::vector<std::uint8_t> trust = mask(entry.trust_mask, entry.camera);
    times.images += watch.lap_ms();
    VisibilityBuffer visible = visibility_.trace_sparsely(entry.camera);
    times.depth += watch.lap_ms();
    StoredView view = make_stored_view(entry.name, entry.camera, std::move(photograph), std::move(visible), options_,
                                       std::move(trust));
    times.masks += watch.lap_ms();
    return view;
  }

  [[nodiscard]] StoredView read_parts(const ViewEntry& entry, const std::vector<PixelRect>& parts,
                                      ReadTimes& times) const {
    Watch watch;
    require_size(entry.image, entry.camera);
    const Photograph frame{entry.camera.width, entry.camera.height, {}, mask(entry.lens_mask, entry.camera)};
    const auto read_rows = [&](const PixelRows& use) {
      const GltfImage& image = entry.image;
      if (image.bytes.empty()) return (void)read_photograph_rows(image.file, use);
      (void)read_photograph_rows(image.bytes, image.file.string(), use);
    };
    const auto stored =
        std::make_shared<const StoredPhotograph>(ImageSize{frame.width, frame.height}, frame.valid, parts, read_rows);
    const std::vector<std::uint8_t> trust = mask(entry.trust_mask, entry.camera);
    times.images += watch.lap_ms();
    PartialMask mask(entry.camera, frame, trust, visibility_, options_);
    for (const PixelRect& part : parts) mask.add(part, times);
    return {entry.name, entry.camera, stored, mask.mask()};
  }

  [[nodiscard]] Photograph photograph_of(const ViewEntry& entry) const {
    Photograph photograph = sized_image(entry.image, entry.camera);
    photograph.valid = mask(entry.lens_mask, entry.camera);
    return photograph;
  }

  void require_size(const GltfImage& image, const Camera& camera) const {
    const ImageSize size = size_of(image);
    if (size.width == camera.width && size.height == camera.height) return;
    throw InputError(image.file.string() + ": is " + size_text(size.width, size.height) + ", its view in " +
                     model_.string() + " says " + size_text(camera.width, camera.height));
  }

  [[nodiscard]] Photograph sized_image(const GltfImage& image, const Camera& camera) const {
    require_size(image, camera);
    return image.bytes.empty() ? read_photograph(image.file) : read_photograph(image.bytes, image.file.string());
  }

  // Returns the red of an image, one value per pixel; none without an image.
  [[nodiscard]] std::vector<std::uint8_t> mask(const std::optional<GltfImage>& image, const Camera& camera) const {
    if (!image) return {};
    const Photograph picture = sized_image(*image, camera);
    std::vector<std::uint8_t> values(picture.rgb.size() / 3);
    for (std::size_t pixel = 0; pixel < values.size(); ++pixel) values[pixel] = picture.rgb[3 * pixel];
    return values;
  }

  const fs::path& model_;
  RayVisibility visibility_;
  const TileTable& tiles_;
  const ValidityOptions& options_;
};

}  // namespace

ImageSize size_of(const GltfImage& image) {
  return image.bytes.empty() ? photograph_size(image.file) : photograph_size(image.bytes, image.file.string());
}

std::vector<std::shared_ptr<const StoredView>> read_views(const std::vector<ViewEntry>& entries, const fs::path& model,
                                                          const Mesh& mesh, const TileTable& tiles,
                                                          const ValidityOptions& options, ReadTimes& times) {
  const ViewReader reader(model, mesh, tiles, options);
  std::vector<std::shared_ptr<const StoredView>> views(entries.size());
  std::vector<std::exception_ptr> errors(entries.size());
  std::vector<ReadTimes> of_view(entries.size());
  tbb::parallel_for(std::size_t{0}, entries.size(), [&](std::size_t i) {
    try {
      views[i] = reader.read(entries[i], ViewSlot(static_cast<std::uint32_t>(i)), of_view[i]);
    } catch (...) {
      errors[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  for (const ReadTimes& view : of_view) {
    times.images += view.images;
    times.depth += view.depth;
    times.masks += view.masks;
  }
  return views;
}

}  // namespace lumatlas
