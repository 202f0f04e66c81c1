// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/live_form.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_document.h"
#include "atlas/model/model_ranges.h"
#include "atlas/model/surface/live_chunks.h"

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

// A chunk as it was written last: what its files hold, and their names.
struct WrittenChunk {
  std::shared_ptr<const LiveChunkForm> form;
  Snapshot tables;                     // chunk_snapshot()
  std::vector<std::uint8_t> resident;  // as in ViewTables
  TileContent content;
  std::array<std::string, 3> parts;  // names of the files of mesh, colours and tables

  // Returns whether the files are those of a chunk with these tables.
  [[nodiscard]] bool holds(const LiveChunkForm* of, const Snapshot& now, const ViewTables& views) const {
    return form.get() == of && tables.cell_seen == now.cell_seen && tables.cell_deviation == now.cell_deviation &&
           tables.references.offsets == now.references.offsets && tables.references.views == now.references.views &&
           tables.vertex_colors.get() == now.vertex_colors.get() && resident == views.resident;
  }
};

// The chunks of a surface, and the files that were written of them.
struct WrittenChunks {
  std::shared_ptr<const LiveChunks> surface;
  std::vector<std::shared_ptr<const WrittenChunk>> files;  // one per chunk
  glm::dmat3 upright{1.0};  // gltf_from_scene() of the first version, because it changes a little with each view
};

}  // namespace

struct LiveForm::State {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const WrittenSurface> written;  // null: the surface is in chunks
  WrittenChunks chunks;
  std::vector<WrittenView> views;  // one per view slot
  std::uint64_t versions = 0;
};

namespace {

// Returns whether colours differ by so little that those which are written stay.
bool are_close(const std::vector<glm::u8vec3>& a, const std::vector<glm::u8vec3>& b) {
  constexpr int kMostApart = 8;  // of 255
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const glm::u8vec3& x, const glm::u8vec3& y) {
    const glm::ivec3 apart = glm::abs(glm::ivec3(x) - glm::ivec3(y));
    return std::max({apart.r, apart.g, apart.b}) <= kMostApart;
  });
}

bool shows_the_same(const ViewMask& a, const ViewMask& b) {
  return &a == &b || (a.validity == b.validity && a.rim == b.rim);
}

constexpr SurfaceForm kApart{.apart = true};

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

  FormVersion finish(const WrittenSurface& written) { return finished({put_surface(written), {}}); }

  // Writes the chunks that changed. `before`: what was written last, which becomes what is written now.
  FormVersion finish(const std::shared_ptr<const LiveChunks>& chunks, WrittenChunks& before) {
    WrittenChunks written{chunks, std::vector<std::shared_ptr<const WrittenChunk>>(chunks->chunks.size()),
                          before.surface ? before.upright : gltf_from_scene(snapshot_)};
    const std::vector<std::shared_ptr<const WrittenChunk>> same = files_of_same_cubes(*chunks, before);
    cell_size_ = std::min(snapshot_.surface->cells.size, most_cell_size(snapshot_.surface->mesh));
    static_cast<void>(snapshot_.vertex_colors.get());  // makes them, before several threads ask
    step();
    tbb::parallel_for(std::size_t{0}, written.files.size(),
                      [&](std::size_t i) { written.files[i] = put_chunk(written, i, same[i]); });
    step();
    ModelTile root;
    for (const std::shared_ptr<const WrittenChunk>& chunk : written.files) {
      root.children.push_back({chunk->content, {}});
      version_.names.push_back(chunk->content.uri);
      version_.names.insert(version_.names.end(), chunk->parts.begin(), chunk->parts.end());
    }
    before = std::move(written);
    return finished(root);
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

  FormVersion finished(const ModelTile& root) {
    version_.tileset = tileset_json(snapshot_, snapshot_.surface->offset, root, view_list()).dump() + "\n";
    return std::move(version_);
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
  [[nodiscard]] std::vector<std::uint8_t> resident_tiles() const {
    std::vector<std::uint8_t> resident;
    const TileTable& tiles = snapshot_.tiles;
    for (std::size_t slot = 0; !tiles.whole_views() && slot < views_.size(); ++slot) {
      if (!is_shown(slot)) continue;
      for (std::uint32_t tile = tiles.first_tile[slot]; tile < tiles.first_tile[slot + 1]; ++tile) {
        resident.push_back(tiles.places[tile] == TilePlace::none ? 0 : 1);
      }
    }
    return resident;
  }

  // Returns for each chunk the files of the one that was in its cube before; null: there was none.
  [[nodiscard]] static std::vector<std::shared_ptr<const WrittenChunk>> files_of_same_cubes(
      const LiveChunks& chunks, const WrittenChunks& before) {
    std::vector<std::shared_ptr<const WrittenChunk>> same(chunks.chunks.size());
    for (std::size_t i = 0, at = 0; before.surface && i < same.size(); ++i) {
      const std::vector<LiveChunk>& former = before.surface->chunks;
      while (at < former.size() && former[at].cube < chunks.chunks[i].cube) ++at;
      if (at < former.size() && former[at].cube == chunks.chunks[i].cube) same[i] = before.files[at];
    }
    return same;
  }

  // Safe from several threads.
  [[nodiscard]] std::shared_ptr<const WrittenChunk> put_chunk(const WrittenChunks& chunks, std::size_t number,
                                                              std::shared_ptr<const WrittenChunk> before) const {
    const LiveChunk& chunk = chunks.surface->chunks[number];
    Snapshot part = chunk_snapshot(snapshot_, chunks.surface->faces, chunk);
    const std::vector<ViewSlot>& references = part.references.views;
    // The tiles of the whole model are in the first.
    const ViewTables tables{{references.begin(), references.end()},
                            number == 0 ? resident_tiles() : std::vector<std::uint8_t>()};
    const bool same_mesh = before && before->form == chunk.form;
    if (same_mesh && are_close(before->tables.vertex_colors.get(), part.vertex_colors.get())) {
      part.vertex_colors = before->tables.vertex_colors;
    }
    if (before && before->holds(chunk.form.get(), part, tables)) return before;
    auto written = std::make_shared<WrittenChunk>();
    written->form = chunk.form;
    written->resident = tables.resident;
    const glm::dvec3& origin = chunk.form->origin;
    GltfBuilder gltf(false);
    json properties = add_surface(gltf, part, chunk.form->mesh, tables, kApart);
    properties["cellSize"] = cell_size_;
    properties["origin"] = {origin.x, origin.y, origin.z};
    if (!chunk.form->guests.empty()) properties["guestCells"] = chunk.form->guests.size();
    add_moved_scene(gltf.document(), chunks.upright, origin);
    set_lumigraph(gltf.document(), std::move(properties));
    for (std::size_t i = 0; i < written->parts.size(); ++i) {
      written->parts.at(i) = i == 0 && same_mesh ? before->parts.front() : put_part(gltf, i);
    }
    written->content = put_gltf(gltf, written->parts);
    written->content.volume =
        same_mesh ? before->content.volume : tile_volume(chunk.form->surface.mesh, origin, chunks.upright);
    written->tables = std::move(part);
    return written;
  }

  [[nodiscard]] std::string put_part(const GltfBuilder& gltf, std::size_t number) const {
    constexpr std::array<const char*, 3> kStems{"mesh", "colors", "tables"};
    return put_({kStems.at(number), ".bin", "application/octet-stream", FormPart::surface, gltf.buffers()[number]});
  }

  [[nodiscard]] TileContent put_gltf(GltfBuilder& gltf, std::span<const std::string> parts) const {
    gltf.finish(parts);
    const std::string text = gltf.document().dump();
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    return {put_({"surface", ".gltf", "model/gltf+json", FormPart::surface, bytes}), text.size(), 0, {}};
  }

  TileContent put_surface(const WrittenSurface& written) {
    const std::vector<ViewSlot>& references = snapshot_.references.views;
    const glm::dmat3 upright = gltf_from_scene(snapshot_);
    GltfBuilder gltf(false);
    json properties =
        add_surface(gltf, snapshot_, written, {{references.begin(), references.end()}, resident_tiles()}, kApart);
    add_scene(gltf.document(), upright);
    set_lumigraph(gltf.document(), std::move(properties));
    std::vector<std::string> parts;
    while (parts.size() < gltf.buffers().size()) {
      parts.push_back(put_part(gltf, parts.size()));
      step();
    }
    TileContent content = put_gltf(gltf, parts);
    content.volume = tile_volume(near_surface(*snapshot_.surface).mesh, {}, upright);
    version_.names.insert(version_.names.end(), parts.begin(), parts.end());
    version_.names.push_back(content.uri);
    return content;
  }

  const Snapshot& snapshot_;
  const ImageCoding& photographs_;
  const PutFormFile& put_;
  const CancelCheck& cancel_check_;
  std::vector<WrittenView>& views_;
  std::uint64_t number_;  // of the version
  double cell_size_ = 0;  // as files have it
  FormVersion version_;
};

}  // namespace

LiveForm::LiveForm(const LiveFormOptions& options, SharesOf shares_of)
    : options_(options), shares_of_(std::move(shares_of)), state_(std::make_shared<const State>()) {}

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
  auto chunks = next->chunks.surface;
  if (!same) {
    const LiveChunkOptions cut{options_.least_chunked, options_.chunk_cells,
                               options_.border_width * snapshot.surface->cells.size};
    chunks = std::make_shared<const LiveChunks>(live_chunks(*snapshot.surface, cut, shares_of_, chunks.get()));
    if (chunks->chunks.empty()) chunks = nullptr;
    next->written = nullptr;
  }
  check_cancelled(cancel_check);
  // Cells that refer to the same views are not joined, so that the mesh stays as it is when these change.
  if (!chunks && !next->written) {
    const CellShares shares = shares_of_(*snapshot.surface);
    check_cancelled(cancel_check);
    next->written =
        std::make_shared<const WrittenSurface>(written_surface(*snapshot.surface, &shares, nullptr, std::nullopt));
  }
  check_cancelled(cancel_check);
  VersionWriter writer(snapshot, options_.photographs, put, cancel_check, next->views, ++next->versions);
  writer.write_views(time_for_views);
  if (!chunks) next->chunks = {};
  FormVersion version = chunks ? writer.finish(chunks, next->chunks) : writer.finish(*next->written);
  state_ = std::move(next);
  return version;
}

bool same_mesh(const Surface& a, const Surface& b) {
  return &a == &b || (a.mesh.positions == b.mesh.positions && a.mesh.faces == b.mesh.faces && a.offset == b.offset &&
                      a.cells.cell_of_face == b.cells.cell_of_face && a.cells.size == b.cells.size);
}

}  // namespace lumatlas
