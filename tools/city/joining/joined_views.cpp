// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/joining/joined_views.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "mesh/base/pixel_rect.h"
#include "mesh/camera/lens_correction.h"

namespace lumatlas {

namespace {

bool same_camera(const Camera& a, const Camera& b) {
  return share_a_lens(a, b) && a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

std::vector<std::uint8_t> either(std::vector<std::uint8_t> a, const std::vector<std::uint8_t>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] |= b[i];
  return a;
}

// All pixels of a view while its parts are put together.
struct WholeView {
  std::vector<float> depth;
  std::vector<std::uint8_t> validity, trust, rim;
  std::vector<std::uint8_t> rgb, in_lens;

  explicit WholeView(const Camera& camera) {
    const std::size_t pixels = std::size_t{camera.width} * camera.height;
    depth.assign(pixels, std::numeric_limits<float>::infinity());
    validity.assign(pixels, 0);
    trust.assign(pixels, 255);
    rim.assign(pixels, 0);
    rgb.assign(3 * pixels, 0);
    in_lens.assign(pixels, 0);
  }

  // Takes the pixels in these parts. What stands before all else is what the camera sees: no part has a surface that
  // the whole has not.
  void take(const StoredView& view, const std::vector<PixelRect>& parts) {
    const ViewMask& mask = *view.mask;
    for_each_pixel(parts, view.camera.width, [&](std::size_t at) {
      const StoredPhotograph::Color color = view.photograph->color(at);
      std::copy(color.begin(), color.end(), rgb.begin() + static_cast<std::ptrdiff_t>(3 * at));
      in_lens[at] = view.photograph->is_inside_lens(at) ? 255 : 0;
      if (mask.depth[at] > depth[at]) return;
      depth[at] = mask.depth[at];
      validity[at] = mask.validity[at];
      trust[at] = mask.trust.empty() ? std::uint8_t{255} : mask.trust[at];
      rim[at] = mask.at_rim(at) ? 1 : 0;
    });
  }

 private:
  template <typename Use>
  static void for_each_pixel(const std::vector<PixelRect>& parts, std::uint32_t width, const Use& use) {
    for (const PixelRect& part : parts) {
      for (std::uint32_t y = part.y; y < part.bottom(); ++y) {
        for (std::uint32_t x = part.x; x < part.right(); ++x) use(std::size_t{y} * width + x);
      }
    }
  }
};

// Returns a list that keeps the values in these parts.
template <typename T>
PixelList<T> kept_parts(const std::vector<T>& all, const std::vector<PixelRect>& parts, const Camera& camera,
                        const T& elsewhere) {
  PixelList<T> list(camera.width, camera.height, elsewhere);
  std::vector<T> values;
  for (const PixelRect& part : parts) {
    values.clear();
    for (std::uint32_t y = part.y; y < part.bottom(); ++y) {
      const auto row = all.begin() + static_cast<std::ptrdiff_t>(std::size_t{y} * camera.width + part.x);
      values.insert(values.end(), row, row + part.width);
    }
    list.set_part(part, values);
  }
  list.settle();
  return list;
}

}  // namespace

void JoinedViews::add(const Snapshot& part) {
  for (ViewSlot slot{0}; slot < part.views.size(); ++slot) {
    const std::shared_ptr<const StoredView>& view = part.views[slot];
    if (!view) continue;
    if (views_.empty()) {
      layout_ = part.tiles.options;
      layout_.max_tiles = 0;
    } else if (layout_.tile_px != part.tiles.options.tile_px || layout_.gutter_px != part.tiles.options.gutter_px) {
      throw std::invalid_argument("views: " + view->name + " is cut into other tiles than the views before");
    }
    std::vector<std::uint8_t> resident;
    if (!part.tiles.whole_views()) {
      for (std::uint32_t tile = part.tiles.first_tile[slot]; tile < part.tiles.first_tile[slot + 1]; ++tile) {
        resident.push_back(part.tiles.places[tile] == TilePlace::none ? 0 : 1);
      }
    }
    View& joined = views_[view->name];
    if (!joined.parts.empty() && !same_camera(joined.parts.front().view->camera, view->camera)) {
      throw std::invalid_argument("views: " + view->name + " has another camera in another part");
    }
    joined.gain = part.gains[slot];
    joined.parts.push_back({view, std::move(resident)});
  }
}

std::vector<ViewSlot> JoinedViews::slots_of(const Snapshot& part) const {
  std::vector<ViewSlot> slots;
  for (const auto& view : part.views) {
    const auto place = view ? std::distance(views_.begin(), views_.find(view->name)) : 0;
    slots.push_back(view ? ViewSlot(static_cast<std::uint32_t>(place)) : ViewSlot::none);
  }
  return slots;
}

// Returns the tiles with their gutters, within the image.
std::vector<PixelRect> JoinedViews::rectangles(const Camera& camera, const std::vector<std::uint8_t>& tiles) const {
  const std::uint32_t columns = TileGrid(camera.width, camera.height, layout_.tile_px).columns;
  std::vector<PixelRect> parts;
  for (std::uint32_t tile = 0; tile < tiles.size(); ++tile) {
    if (tiles[tile] == 0) continue;
    const std::uint32_t x = tile % columns * layout_.tile_px, y = tile / columns * layout_.tile_px;
    const std::uint32_t left = x - std::min(x, layout_.gutter_px), top = y - std::min(y, layout_.gutter_px);
    const std::uint32_t right = std::min(x + layout_.tile_px + layout_.gutter_px, camera.width);
    const std::uint32_t bottom = std::min(y + layout_.tile_px + layout_.gutter_px, camera.height);
    parts.push_back({left, top, right - left, bottom - top});
  }
  return parts;
}

std::shared_ptr<const StoredView> JoinedViews::joined(const View& view) const {
  const StoredView& first = *view.parts.front().view;
  if (view.parts.size() == 1 || layout_.whole_views()) return view.parts.front().view;
  const Camera& camera = first.camera;
  WholeView whole(camera);
  std::vector<std::uint8_t> tiles(view.parts.front().resident.size(), 0);
  bool trusts = false, has_rims = false;
  for (const Part& part : view.parts) {
    whole.take(*part.view, rectangles(camera, part.resident));
    tiles = either(std::move(tiles), part.resident);
    trusts = trusts || !part.view->mask->trust.empty();
    has_rims = has_rims || !part.view->mask->rim.empty();
  }
  const std::vector<PixelRect> parts = rectangles(camera, tiles);
  auto mask = std::make_shared<ViewMask>();
  mask->depth = kept_parts(whole.depth, parts, camera, std::numeric_limits<float>::infinity());
  mask->validity = kept_parts(whole.validity, parts, camera, std::uint8_t{0});
  if (trusts) mask->trust = kept_parts(whole.trust, parts, camera, std::uint8_t{255});
  if (has_rims) mask->rim = kept_parts(whole.rim, parts, camera, std::uint8_t{0});
  const bool has_lens_mask = std::any_of(view.parts.begin(), view.parts.end(),
                                         [](const Part& part) { return part.view->photograph->has_lens_mask(); });
  auto photograph = std::make_shared<const StoredPhotograph>(
      ImageSize{camera.width, camera.height}, has_lens_mask ? whole.in_lens : std::vector<std::uint8_t>(), parts,
      [&](const PixelRows& rows) { rows(0, whole.rgb); });
  return std::make_shared<const StoredView>(StoredView{first.name, camera, std::move(photograph), std::move(mask)});
}

void JoinedViews::fill(Snapshot& snapshot) {
  snapshot.views.clear();
  snapshot.gains.clear();
  snapshot.tiles = {};
  snapshot.tiles.options = layout_;
  std::uint32_t next = 0;
  for (auto& [name, view] : views_) {
    snapshot.views.push_back(joined(view));
    snapshot.gains.push_back(view.gain);
    const std::vector<Part> parts = std::move(view.parts);
    if (layout_.whole_views()) continue;
    std::vector<std::uint8_t> tiles(parts.front().resident.size(), 0);
    for (const Part& part : parts) tiles = either(std::move(tiles), part.resident);
    snapshot.tiles.first_tile.push_back(static_cast<std::uint32_t>(snapshot.tiles.places.size()));
    for (const std::uint8_t there : tiles) {
      snapshot.tiles.places.push_back(there != 0 ? TilePlace(next++) : TilePlace::none);
    }
  }
  if (!layout_.whole_views()) {
    snapshot.tiles.first_tile.push_back(static_cast<std::uint32_t>(snapshot.tiles.places.size()));
  }
}

}  // namespace lumatlas
