// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/live_form.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_document.h"

namespace lumatlas {

namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

// A view as it was written last, and its files: the objects of the tileset's "images".
struct WrittenView {
  std::shared_ptr<const StoredView> view;  // null: none was
  json photograph, mask, thumbnail;
  std::uint64_t version = 0;  // that it was written for; without a view, the first one that should have had it

  // Returns whether the files have this view's photograph.
  [[nodiscard]] bool shows(const StoredView& other) const {
    return view && (view->photograph == other.photograph || *view->photograph == *other.photograph);
  }
};

}  // namespace

struct LiveForm::State {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const WrittenSurface> written;
  std::vector<WrittenView> views;  // one per view slot
  std::uint64_t versions = 0;
};

namespace {

bool shows_the_same(const ViewMask& a, const ViewMask& b) {
  return &a == &b || (a.validity == b.validity && a.rim == b.rim);
}

class VersionWriter {
 public:
  VersionWriter(const Snapshot& snapshot, const ImageCoding& photographs, const PutFormFile& put,
                const CancelCheck& cancel_check, std::vector<WrittenView>& views, std::uint64_t number)
      : snapshot_(snapshot),
        photographs_(photographs),
        put_(put),
        cancel_check_(cancel_check),
        views_(views),
        number_(number) {}

  // Writes the views that changed, as long as there is time, and one at least.
  void write_views(std::chrono::milliseconds time) {
    const auto until = Clock::now() + time;
    bool is_first = true;
    for (const ViewSlot slot : changed_views()) {
      step();
      if (!std::exchange(is_first, false) && Clock::now() > until) {
        version_.complete = false;
        return;
      }
      write_view(slot);
    }
  }

  FormVersion finish(const WrittenSurface& written) {
    json properties = view_list();
    const TileContent surface = put_surface(written);
    version_.tileset =
        tileset_json(snapshot_, snapshot_.surface->offset, {surface, {}}, std::move(properties)).dump() + "\n";
    return std::move(version_);
  }

 private:
  void step() const { check_cancelled(cancel_check_); }
  // Returns whether the view is shown: it is there, and its photograph was written for some version.
  [[nodiscard]] bool is_shown(std::size_t slot) const {
    return snapshot_.views[slot] && views_[slot].shows(*snapshot_.views[slot]);
  }

  // Returns the views to write: first those with a photograph that no version has, then those that were written longest
  // ago, so that each has its turn while all change all the time.
  [[nodiscard]] std::vector<ViewSlot> changed_views() {
    std::vector<std::tuple<bool, std::uint64_t, ViewSlot>> by_turn;
    views_.resize(snapshot_.views.size());
    for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
      if (!snapshot_.views[slot]) {
        views_[slot] = {};
      } else if (snapshot_.views[slot] != views_[slot].view) {
        // The files of another photograph are in no version from now on, and may be gone when it comes back.
        if (views_[slot].view && !is_shown(slot)) views_[slot] = {};
        if (views_[slot].version == 0) views_[slot].version = number_;
        by_turn.emplace_back(is_shown(slot), views_[slot].version, slot);
      }
    }
    std::sort(by_turn.begin(), by_turn.end());
    std::vector<ViewSlot> slots;
    slots.reserve(by_turn.size());
    for (const auto& [shown, turn, slot] : by_turn) slots.push_back(slot);
    return slots;
  }

  [[nodiscard]] json put_image(ModelImageKind kind, FormPart part, ViewSlot slot, const char* suffix,
                               const std::string& ending, const ImageCoding& coding) const {
    const ModelImage image{kind, slot, {numbered_image(slot) + suffix, ending}, coding, PngEffort::least};
    const std::vector<std::uint8_t> file = encoded(image, snapshot_);
    const std::string name = put_({image.name.stem, ending, mime_type(coding.format), part, file});
    return {{"uri", name}, {"byteLength", file.size()}};
  }

  void write_view(ViewSlot slot) {
    WrittenView& known = views_[slot];
    const StoredView& now = *snapshot_.views[slot];
    const bool same = known.shows(now);
    const std::shared_ptr<const StoredView> before = std::exchange(known.view, snapshot_.views[slot]);
    known.version = number_;
    if (!same) {
      const ImageCoding small{ImageFormat::jpeg, 80};
      known.photograph = put_image(ModelImageKind::photograph, FormPart::photograph, slot, "",
                                   ending(photographs_.format), photographs_);
      known.thumbnail = put_image(ModelImageKind::thumbnail, FormPart::thumbnail, slot, "-small", ".jpg", small);
    }
    if (!same || !shows_the_same(*before->mask, *now.mask)) {
      known.mask = put_image(ModelImageKind::mask, FormPart::mask, slot, "-mask", ".png", {});
    }
  }

  [[nodiscard]] json view_list() {
    std::vector<std::uint8_t> shown;
    for (std::size_t slot = 0; slot < views_.size(); ++slot) shown.push_back(is_shown(slot) ? 1 : 0);
    const float before_far = depth_before_far(*snapshot_.surface);
    json properties = model_properties(snapshot_, before_far, {}, first_view_slot(snapshot_, shown));
    json images = json::array(), views = json::array();
    const auto add = [&](const json& image) {
      version_.names.push_back(image["uri"]);
      images.push_back(image);
      return images.size() - 1;
    };
    for (std::size_t slot = 0; slot < views_.size(); ++slot) {
      if (!shown[slot]) {
        views.push_back(nullptr);
        continue;
      }
      json view = view_properties(*snapshot_.views[slot], snapshot_.gains[slot], before_far);
      view["image"] = add(views_[slot].photograph);
      view["mask"] = add(views_[slot].mask);
      view["thumbnail"] = add(views_[slot].thumbnail);
      views.push_back(std::move(view));
    }
    properties["images"] = std::move(images);
    properties["views"] = std::move(views);
    return properties;
  }

  // Views are in the order of their slots; tiles are those of the views that are shown.
  [[nodiscard]] ViewTables tables() const {
    const std::vector<ViewSlot>& references = snapshot_.references.views;
    ViewTables tables{{references.begin(), references.end()}, {}};
    const TileTable& tiles = snapshot_.tiles;
    for (std::size_t slot = 0; !tiles.whole_views() && slot < views_.size(); ++slot) {
      if (!is_shown(slot)) continue;
      for (std::uint32_t tile = tiles.first_tile[slot]; tile < tiles.first_tile[slot + 1]; ++tile) {
        tables.resident.push_back(tiles.places[tile] == TilePlace::none ? 0 : 1);
      }
    }
    return tables;
  }

  std::string put_named(const std::string& stem, const char* ending, const char* type,
                        std::span<const std::uint8_t> bytes) {
    version_.names.push_back(put_({stem, ending, type, FormPart::surface, bytes}));
    return version_.names.back();
  }

  TileContent put_surface(const WrittenSurface& written) {
    const glm::dmat3 upright = gltf_from_scene(snapshot_);
    const TileVolume volume = tile_volume(near_surface(*snapshot_.surface).mesh, {}, upright);
    GltfBuilder gltf(false);
    SurfaceForm form;
    form.apart = true;
    json properties = add_surface(gltf, snapshot_, written, tables(), form);
    add_scene(gltf.document(), upright);
    set_lumigraph(gltf.document(), std::move(properties));
    std::vector<std::string> uris;
    for (const char* stem : {"mesh", "colors", "tables"}) {
      uris.push_back(put_named(stem, ".bin", "application/octet-stream", gltf.buffers()[uris.size()]));
      step();
    }
    gltf.finish(uris);
    const std::string text = gltf.document().dump();
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    return {put_named("surface", ".gltf", "model/gltf+json", bytes), text.size(), 0, volume};
  }

  const Snapshot& snapshot_;
  const ImageCoding& photographs_;
  const PutFormFile& put_;
  const CancelCheck& cancel_check_;
  std::vector<WrittenView>& views_;
  std::uint64_t number_;  // of the version
  FormVersion version_;
};

}  // namespace

LiveForm::LiveForm(const ImageCoding& photographs, SharesOf shares_of)
    : photographs_(photographs), shares_of_(std::move(shares_of)), state_(std::make_shared<const State>()) {}

LiveForm::~LiveForm() = default;

FormVersion LiveForm::write(const Snapshot& snapshot, std::chrono::milliseconds time_for_views, const PutFormFile& put,
                            const CancelCheck& cancel_check) {
  check(snapshot);
  if (std::none_of(snapshot.views.begin(), snapshot.views.end(), [](const auto& view) { return view != nullptr; })) {
    throw std::invalid_argument("live form: the model holds no view");
  }
  auto next = std::make_shared<State>(*state_);
  const bool same = next->surface && same_mesh(*next->surface, *snapshot.surface);
  next->surface = snapshot.surface;
  // Cells that refer to the same views are not joined, so that the mesh stays as it is when these change.
  if (!same) {
    const CellShares shares = shares_of_(*snapshot.surface);
    check_cancelled(cancel_check);
    next->written =
        std::make_shared<const WrittenSurface>(written_surface(*snapshot.surface, &shares, nullptr, std::nullopt));
  }
  check_cancelled(cancel_check);
  VersionWriter writer(snapshot, photographs_, put, cancel_check, next->views, ++next->versions);
  writer.write_views(time_for_views);
  FormVersion version = writer.finish(*next->written);
  state_ = std::move(next);
  return version;
}

bool same_mesh(const Surface& a, const Surface& b) {
  return &a == &b || (a.mesh.positions == b.mesh.positions && a.mesh.faces == b.mesh.faces && a.offset == b.offset &&
                      a.cells.cell_of_face == b.cells.cell_of_face && a.cells.size == b.cells.size);
}

}  // namespace lumatlas
