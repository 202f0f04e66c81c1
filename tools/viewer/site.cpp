// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/site.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <glm/glm.hpp>
#include <iterator>
#include <limits>
#include <ostream>
#include <span>
#include <stdexcept>
#include <utility>

#include "atlas/model/content_digest.h"
#include "blend/cubic_kernel.h"
#include "blend/exposure.h"
#include "blend/gl/shader_program.h"
#include "blend/shaders.h"
#include "blend/tables/cell_shares.h"
#include "blend/tables/zone_mesh.h"
#include "mesh/base/errors.h"
#include "mesh/upright.h"
#include "tools/base/html_text.h"
#include "tools/base/process_limits.h"
#include "tools/picture/paths/camera_tours.h"
#include "tools/picture/paths/kept_path.h"
#include "tools/viewer/base64.h"
#include "tools/viewer/packed_arrays.h"
#include "tools/viewer/page_assets.h"
#include "tools/viewer/scaled_view.h"
#include "tools/viewer/web_mesh.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// The renderer's value, see blend/renderer.cpp.
constexpr double kNearShare = 1e-8;

// Tiles of a page where the model has none.
constexpr std::uint32_t kTilePx = 64;

// Faces of the mesh that the first picture shows, about.
constexpr std::size_t kCoarseFaces = 60000;

constexpr std::uint32_t kThumbnailPx = 128;
constexpr std::uint32_t kPosterPx = 640;
constexpr ImageCoding kSmallPictures{ImageFormat::jpeg, 80};

// Returns whether a photograph's rows are within 5 degrees of the horizon, the right way up.
bool is_level(const Camera& camera, const glm::dvec3& up) {
  const glm::dvec3 up_in_camera = camera.cam_from_world_rotation * up;  // y down
  return std::abs(up_in_camera.x) <= std::sin(glm::radians(5.0)) && up_in_camera.y < 0;
}

std::vector<std::uint8_t> bytes_of_text(std::string_view text) {
  return {text.begin(), text.end()};
}

// Without white space, which would be a third of a scene's bytes.
SiteFile compact_json(std::string name, const json& value) {
  return {std::move(name), "application/json",
          bytes_of_text(value.dump(-1, ' ', false, json::error_handler_t::replace))};
}

json json_of(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json json_of(const BlendOptions& options) {
  return {{"views", options.views},
          {"lambda", options.lambda},
          {"printed_position", options.position == BlendOptions::Position::printed},
          {"rims", options.rims},
          {"fade_last", options.fade_last},
          {"consistent", options.consistent},
          {"frame_fade", options.frame_fade},
          {"cubic", options.sampling == BlendOptions::Sampling::cubic},
          {"soften", options.soften},
          {"prefilter", options.prefilter},
          {"nearby_exposure", options.exposure == BlendOptions::Exposure::nearby},
          {"supersample", options.supersample},
          {"antialias_all", options.antialias == BlendOptions::Antialias::all},
          {"occlusion_tolerance", options.occlusion_tolerance}};
}

// The shaders are the same for every version of every model, so that a browser fetches them once.
SiteFile shaders_file() {
  const json sources = {{"surface.vert", k_surface_vert},
                        {"surface.frag", k_surface_frag},
                        {"screen.vert", k_screen_vert},
                        {"blend.frag", k_blend_frag},
                        {"silhouettes.frag", k_silhouettes_frag},
                        {"diagnose.frag", k_diagnose_frag},
                        {"depth.frag", k_depth_frag},
                        {"photograph.frag", k_photograph_frag},
                        {"bc7.frag", k_bc7_frag},
                        {"etc2.frag", k_etc2_frag},
                        {"page.frag", k_page_frag},
                        {"modes.frag", k_modes_frag},
                        {"fade.frag", k_fade_frag},
                        {"glance.frag", k_glance_frag},
                        {"needs.frag", k_needs_frag}};
  return compact_json("shaders.json", {{"definitions", shared_definitions()}, {"sources", sources}});
}

// The file under a name that says what it holds, so that no cache takes one version of a file for another.
SiteFile named_by_content(SiteFile file) {
  const std::size_t dot = file.name.rfind('.');
  file.name.insert(dot, '-' + content_digits(std::as_bytes(std::span(file.bytes))));
  return file;
}

SiteFile binary(std::string name, std::vector<std::uint8_t> bytes) {
  return {std::move(name), "application/octet-stream", std::move(bytes)};
}

std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras;
}

class SiteWriter {
 public:
  SiteWriter(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
             const Tick& tick, SiteHistory* history = nullptr)
      : snapshot_(snapshot), options_(options), put_(put), tick_(tick), history_(history) {
    check(snapshot);
    check(options.blend);
    check(options.photographs);
    if (cameras_of(snapshot).empty()) throw std::invalid_argument("site: the model holds no view");
    const TileTable& tiles = snapshot.tiles;
    tile_px_ = tiles.whole_views() ? kTilePx : tiles.options.tile_px;
    std::uint32_t longest = 1;
    for (const Camera& camera : cameras_of(snapshot)) longest = std::max({longest, camera.width, camera.height});
    // A whole number of pixels a tile, so that tiles stay tiles.
    scaled_tile_px_ = std::max(1u, std::min(tile_px_, options.most_side_px * tile_px_ / longest));
    facts_.scale = static_cast<double>(scaled_tile_px_) / tile_px_;
  }

  // The page's own files are the caller's.
  SiteFacts write();

  // With a history: what is new, and the names of all files but the scene's own.
  std::vector<std::string> write_version();

 private:
  void put(SiteFile file, std::uint64_t& bytes) {
    bytes += file.bytes.size();
    sizes_[file.name] = file.bytes.size();
    put_(std::move(file));
  }
  // Without a history: returns the name, which says what the file holds.
  std::string put_named(SiteFile file, std::uint64_t& bytes) {
    file = named_by_content(std::move(file));
    std::string name = file.name;
    put(std::move(file), bytes);
    return name;
  }
  void step() const {
    if (tick_) tick_();
  }
  // With a history: whether the view was written in some version.
  [[nodiscard]] bool is_known(std::size_t slot) const {
    return snapshot_.views[slot] && (!history_ || history_->views[slot].photograph > 0);
  }
  void note(std::string name) { names_.push_back(std::move(name)); }

  // The files of a scene, as its JSON describes them.
  struct Described {
    json mesh, coarse, tables, colors, poster;
  };
  // Names of a view's files.
  struct ViewNames {
    std::string photograph, mask, thumbnail;
  };

  [[nodiscard]] Described write_surface();
  [[nodiscard]] std::string write_poster();
  void write_mesh_version();
  json write_arrays_version(const std::string& name, const PackedArrays& arrays);
  [[nodiscard]] std::vector<std::uint32_t> resident_tiles() const;
  [[nodiscard]] PackedArrays tables(const ZoneCells& zones) const;
  void note_view_version(std::size_t slot);
  [[nodiscard]] SiteFile scene_file(const Described& described) const;
  void write_views();
  void write_view(std::size_t slot, const StoredView& view);
  void write_view_version(std::size_t slot, const StoredView& view);
  [[nodiscard]] json view_json(std::size_t slot) const;
  // Returns the view where a visitor begins: the photograph that most cells refer to, which gives the widest view.
  [[nodiscard]] std::size_t first_view() const;
  [[nodiscard]] std::string stem(std::size_t slot) const;
  [[nodiscard]] SiteFile thumbnail_file(std::size_t slot) const;
  // With a history, names by the versions in which the files changed.
  [[nodiscard]] ViewNames version_names(std::size_t slot) const;

  const Snapshot& snapshot_;
  const SiteOptions& options_;
  const std::function<void(SiteFile)>& put_;
  const Tick& tick_;
  SiteHistory* history_;            // null: the site is written once
  std::vector<std::string> names_;  // with a history, of all files of its version
  std::vector<ViewNames> views_;    // without a history, of those that were written, by slot
  json sizes_ = json::object();     // bytes of the files that were put, by name
  std::uint32_t tile_px_ = 0, scaled_tile_px_ = 0;
  SiteFacts facts_;
};

// The one that most cells refer to, of those held level: a page that opens askew seems broken.
std::size_t SiteWriter::first_view() const {
  std::vector<std::size_t> cells(snapshot_.views.size(), 0);
  for (const std::uint32_t slot : snapshot_.references.views) ++cells[slot];
  const glm::dvec3 up = upward(cameras_of(snapshot_));
  std::size_t best = 0;
  std::pair<bool, std::size_t> most;
  for (std::size_t slot = 0; slot < cells.size(); ++slot) {
    if (!is_known(slot)) continue;
    const std::pair shows(is_level(snapshot_.views[slot]->camera, up), cells[slot]);
    if (is_known(best) && shows <= most) continue;
    best = slot;
    most = shows;
  }
  return best;
}

std::string SiteWriter::stem(std::size_t slot) const {
  const std::string number = std::to_string(slot);
  return std::string(5 - std::min<std::size_t>(number.size(), 5), '0') + number;
}

// The name of a file that changed in a version.
std::string versioned(const std::string& name, std::uint64_t version, const char* ending) {
  return name + '-' + std::to_string(version) + ending;
}

SiteWriter::ViewNames SiteWriter::version_names(std::size_t slot) const {
  const SiteHistory::View& known = history_->views[slot];
  return {versioned("views/" + stem(slot), known.photograph, ending(options_.photographs.format)),
          versioned("views/" + stem(slot), known.mask, ".bin"),
          versioned("thumbnails/" + stem(slot), known.photograph, ".jpg")};
}

json SiteWriter::view_json(std::size_t slot) const {
  if (!is_known(slot)) return nullptr;
  const StoredView& view = *snapshot_.views[slot];
  const Camera& camera = view.camera;
  const double scale = facts_.scale;
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera.cam_from_world_rotation[column][row]);
  }
  const double depth = median_depth(view, depth_before_far(*snapshot_.surface));
  const ViewNames names = history_ ? version_names(slot) : views_[slot];
  return {{"name", view.name},
          {"photograph", names.photograph},
          {"mask", names.mask},
          {"thumbnail", names.thumbnail},
          {"width", camera.width * scale},
          {"height", camera.height * scale},
          {"fx", camera.fx * scale},
          {"fy", camera.fy * scale},
          {"cx", camera.cx * scale},
          {"cy", camera.cy * scale},
          {"rotation", rotation},
          {"translation", json_of(camera.cam_from_world_translation)},
          {"gain", json_of(snapshot_.gains[slot])},
          {"depth", depth}};
}

// Which tiles of a view are resident; with whole views, all.
std::vector<std::uint8_t> tiles_there(const Snapshot& snapshot, std::size_t slot, std::uint32_t tile_px) {
  const Camera& camera = snapshot.views[slot]->camera;
  std::vector<std::uint8_t> there(TileGrid(camera.width, camera.height, tile_px).tiles(), 1);
  if (snapshot.tiles.whole_views()) return there;
  const std::uint32_t first = snapshot.tiles.first_tile[slot];
  for (std::size_t tile = 0; tile < there.size(); ++tile) {
    if (snapshot.tiles.slots[first + tile] == kNotResident) there[tile] = 0;
  }
  return there;
}

template <typename Records>
std::vector<std::uint32_t> flat(const Records& records, int components) {
  std::vector<std::uint32_t> values;
  for (const auto& record : records) {
    for (int i = 0; i < components; ++i) values.push_back(record[i]);
  }
  return values;
}

// For each tile of the views that the page has, as the page numbers them, 1 or 0.
std::vector<std::uint32_t> SiteWriter::resident_tiles() const {
  std::vector<std::uint32_t> resident;
  for (std::size_t slot = 0; slot < snapshot_.views.size(); ++slot) {
    if (!is_known(slot)) continue;
    const std::vector<std::uint8_t> there = tiles_there(snapshot_, slot, tile_px_);
    resident.insert(resident.end(), there.begin(), there.end());
  }
  return resident;
}

PackedArrays SiteWriter::tables(const ZoneCells& zones) const {
  const ZoneReferences lists =
      zone_references(zones, snapshot_.references, snapshot_.cell_seen, snapshot_.cell_deviation);
  PackedArrays tables;
  tables.add("zones", flat(lists.zones, 4), 4, PackedCoding::difference);
  tables.add("cells", flat(lists.cells, 3), 3, PackedCoding::difference);
  tables.add("references", lists.references, 1, PackedCoding::difference);
  tables.add("resident", resident_tiles(), 1, PackedCoding::plain);
  return tables;
}

json mesh_json(const PackedMesh& mesh, const std::string& file) {
  return {{"file", file},
          {"arrays", mesh.arrays.description()},
          {"corner_counts", mesh.corner_counts},
          {"origin", json_of(mesh.grid.origin)},
          {"step", mesh.grid.step}};
}

SiteFacts SiteWriter::write() {
  const Described described = write_surface();
  write_views();
  put(scene_file(described), facts_.scene_bytes);
  return facts_;
}

std::string SiteWriter::write_poster() {
  const std::size_t first = first_view();
  const Photograph poster =
      small_picture(*snapshot_.views[first], kPosterPx, tiles_there(snapshot_, first, tile_px_), tile_px_);
  return put_named({"poster.jpg", "image/jpeg", encode_image(poster, kSmallPictures)}, facts_.scene_bytes);
}

SiteWriter::Described SiteWriter::write_surface() {
  const Surface& surface = *snapshot_.surface;
  const double width = options_.blend.border_width;
  CellShares shares = share_cells(surface, width * surface.cells.size);
  if (width > 0) shares = joined(std::move(shares), first_of_same_references(snapshot_.references));
  const ZoneMesh mesh = zone_mesh(surface.mesh, snapshot_.vertex_colors.get(), surface.cells.cell_of_face, shares);
  const PackedMesh packed = packed_mesh(mesh, position_grid(snapshot_));
  const PackedArrays tables = this->tables(mesh.zone_cells);
  const PackedMesh coarse = packed_mesh(coarse_mesh(snapshot_, kCoarseFaces), packed.grid);
  Described described;
  described.poster = write_poster();
  if (coarse.corner_counts[0] > 0) {
    const std::string name = put_named(binary("coarse.bin", coarse.arrays.deflated()), facts_.scene_bytes);
    described.coarse = mesh_json(coarse, name);
  }
  described.mesh = mesh_json(packed, put_named(binary("mesh.bin", packed.arrays.deflated()), facts_.mesh_bytes));
  const std::string name = put_named(binary("tables.bin", tables.deflated()), facts_.table_bytes);
  described.tables = {{"file", name}, {"arrays", tables.description()}};
  step();
  return described;
}

// Cells that refer to the same views are not joined, so that the mesh stays as it is when these change.
void SiteWriter::write_mesh_version() {
  const std::shared_ptr<const Surface>& surface = snapshot_.surface;
  const bool same = history_->surface && same_mesh(*history_->surface, *surface);
  history_->surface = surface;
  if (same) return note(history_->mesh["file"]);
  const CellShares shares = share_cells(*surface, options_.blend.border_width * surface->cells.size);
  ZoneMesh mesh = zone_mesh(surface->mesh, snapshot_.vertex_colors.get(), surface->cells.cell_of_face, shares);
  step();
  const PackedMesh packed = packed_mesh(mesh, position_grid(snapshot_));
  step();
  history_->sources.clear();
  for (const std::uint32_t vertex : packed.vertices) history_->sources.push_back(mesh.sources[vertex]);
  history_->zone_cells = std::move(mesh.zone_cells);
  const std::string name = versioned("mesh", history_->version, ".bin");
  history_->mesh = mesh_json(packed, name);
  note(name);
  put(binary(name, packed.arrays.deflated(DeflateEffort::least)), facts_.mesh_bytes);
}

// Arrays that are as they were stay in the file that they are in.
json SiteWriter::write_arrays_version(const std::string& name, const PackedArrays& arrays) {
  SiteHistory::Arrays& known = history_->arrays[name];
  std::vector<std::uint8_t> packed = arrays.deflated(DeflateEffort::least);
  const json& description = arrays.description();
  if (known.packed != packed || known.described.value("arrays", json()) != description) {
    const std::string file = versioned(name, history_->version, ".bin");
    known = {{{"file", file}, {"arrays", description}}, std::move(packed)};
    put(binary(file, known.packed), facts_.table_bytes);
  }
  note(known.described["file"]);
  return known.described;
}

// Which files of a view are as they were.
void SiteWriter::note_view_version(std::size_t slot) {
  SiteHistory::View& known = history_->views[slot];
  const std::shared_ptr<const StoredView> before = std::exchange(known.view, snapshot_.views[slot]);
  if (before == known.view || !known.view) return;
  const StoredView& now = *known.view;
  // Scaled photographs are means over what is valid.
  const bool same = facts_.scale == 1 && before &&
                    (before->photograph == now.photograph || before->photograph->rgb == now.photograph->rgb);
  if (!same) known.photograph = history_->version;
  if (!same || before->mask->validity != now.mask->validity || before->mask->rim != now.mask->rim)
    known.mask = history_->version;
}

std::vector<std::string> SiteWriter::write_version() {
  ++history_->version;
  history_->complete = true;
  history_->views.resize(snapshot_.views.size());
  write_mesh_version();
  step();
  PackedArrays colors;
  std::vector<std::uint32_t> values;
  for (const std::uint32_t vertex : history_->sources) {
    for (int channel = 0; channel < 3; ++channel) values.push_back(snapshot_.vertex_colors.get()[vertex][channel]);
  }
  colors.add("colors", values, 3, PackedCoding::difference);
  const json described_colors = write_arrays_version("colors", colors);
  const auto until = std::chrono::steady_clock::now() + options_.time_for_views;
  bool has_more = false;  // than the version before
  for (std::size_t slot = 0; slot < snapshot_.views.size(); ++slot) {
    step();
    const bool changed = snapshot_.views[slot] != history_->views[slot].view;
    if (changed && snapshot_.views[slot] && has_more && std::chrono::steady_clock::now() > until) {
      history_->complete = false;
    } else {
      note_view_version(slot);
      has_more = has_more || (changed && snapshot_.views[slot]);
    }
    if (is_known(slot)) write_view_version(slot, *snapshot_.views[slot]);
  }
  const json described_tables = write_arrays_version("tables", tables(history_->zone_cells));
  put(scene_file({history_->mesh, {}, described_tables, described_colors, {}}), facts_.scene_bytes);
  return std::move(names_);
}

SiteFile SiteWriter::scene_file(const Described& described) const {
  const Mesh near = near_surface(*snapshot_.surface).mesh;
  const Bounds box = bounds(near);
  const SceneExtent extent = scene_extent(near);
  const std::vector<Camera> cameras = cameras_of(snapshot_);
  json views = json::array();
  for (std::size_t slot = 0; slot < snapshot_.views.size(); ++slot) views.push_back(view_json(slot));
  const TileOptions& tiles = snapshot_.tiles.options;
  const json scene = {
      {"lumatlas", LUMATLAS_VERSION},
      {"format", 3},
      {"title", options_.title},
      {"blend", json_of(options_.blend)},
      {"version", history_ ? json(history_->version) : json()},
      {"mesh", described.mesh},
      {"coarse", described.coarse},
      {"tables", described.tables},
      {"colors", described.colors},
      {"tile", scaled_tile_px_},
      {"levels", levels_of(tiles)},
      {"cubic_levels", cubic_levels(tiles)},
      {"depth_before_far", std::min(depth_before_far(*snapshot_.surface), std::numeric_limits<float>::max())},
      {"near_depth", kNearShare * glm::length(box.max - box.min)},
      {"inverse_depth", NearbyExposure(snapshot_).per_depth()},
      {"up", json_of(upward(cameras))},
      {"photographed",
       {{"cosine", kPhotographedCosine}, {"enlargement", kPhotographedEnlargement}, {"share", kCoveredShare}}},
      {"core", {{"min", json_of(extent.core.min)}, {"max", json_of(extent.core.max)}}},
      {"first_view", first_view()},
      {"poster", described.poster},
      {"bytes", sizes_},  // lets a page recognise a file that was cut short
      {"views", std::move(views)}};
  return compact_json("scene.json", scene);
}

void SiteWriter::write_views() {
  views_.resize(snapshot_.views.size());
  for (std::size_t slot = 0; slot < snapshot_.views.size(); ++slot) {
    if (!snapshot_.views[slot]) continue;
    write_view(slot, *snapshot_.views[slot]);
    ++facts_.views;
    step();
  }
}

// 32 pixels a number.
std::vector<std::uint32_t> bits_of(const std::vector<std::uint8_t>& flags) {
  std::vector<std::uint32_t> words((flags.size() + 31) / 32, 0);
  for (std::size_t i = 0; i < flags.size(); ++i) words[i / 32] |= (flags[i] != 0 ? 1u : 0u) << (i % 32);
  return words;
}

// The numbers of bytes of the values come first: sizes follow from the view's, but these do not.
std::vector<std::uint8_t> mask_file(const ScaledView& view, DeflateEffort effort) {
  PackedArrays mask;
  mask.add("validity", std::vector<std::uint32_t>(view.validity.begin(), view.validity.end()), 1,
           PackedCoding::difference);
  mask.add("rim", bits_of(view.rim), 1, PackedCoding::plain);
  const json description = mask.description();
  const std::vector<std::uint8_t> packed = mask.deflated(effort);
  std::vector<std::uint8_t> file(2 + packed.size());
  file[0] = static_cast<std::uint8_t>(description[0]["bytes"].get<int>());
  file[1] = static_cast<std::uint8_t>(description[1]["bytes"].get<int>());
  std::copy(packed.begin(), packed.end(), file.begin() + 2);
  return file;
}

SiteFile SiteWriter::thumbnail_file(std::size_t slot) const {
  const Photograph picture =
      small_picture(*snapshot_.views[slot], kThumbnailPx, tiles_there(snapshot_, slot, tile_px_), tile_px_);
  return {"thumbnails/" + stem(slot) + ".jpg", "image/jpeg", encode_image(picture, kSmallPictures)};
}

void SiteWriter::write_view(std::size_t slot, const StoredView& view) {
  const ScaledView scaled = scaled_view(view, facts_.scale);
  const ImageCoding& coding = options_.photographs;
  ViewNames& names = views_[slot];
  names.thumbnail = put_named(thumbnail_file(slot), facts_.photograph_bytes);
  names.photograph = put_named({"views/" + stem(slot) + ending(coding.format), mime_type(coding.format),
                                encode_image(scaled.photograph, coding)},
                               facts_.photograph_bytes);
  names.mask =
      put_named(binary("views/" + stem(slot) + ".bin", mask_file(scaled, DeflateEffort::most)), facts_.mask_bytes);
}

// Writes the new parts of a view.
void SiteWriter::write_view_version(std::size_t slot, const StoredView& view) {
  const bool photograph = history_->views[slot].photograph == history_->version;
  const bool mask = history_->views[slot].mask == history_->version;
  const ViewNames names = version_names(slot);
  for (const auto& name : {names.thumbnail, names.photograph, names.mask}) note(name);
  if (!photograph && !mask) return;
  const ScaledView scaled = scaled_view(view, facts_.scale);
  const ImageCoding& coding = options_.photographs;
  if (photograph) {
    SiteFile thumbnail = thumbnail_file(slot);
    thumbnail.name = names.thumbnail;
    put(std::move(thumbnail), facts_.photograph_bytes);
    put({names.photograph, mime_type(coding.format), encode_image(scaled.photograph, coding)}, facts_.photograph_bytes);
  }
  if (mask) put(binary(names.mask, mask_file(scaled, DeflateEffort::least)), facts_.mask_bytes);
}

// A folder's page loads scripts, styles, pictures and data from its own site alone.
constexpr std::string_view kFolderPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'";
// A page in one file has all inside, and asks no server.
constexpr std::string_view kOnePagePolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'";

// A page's HTML before and after its script.
struct PageHtml {
  std::string before, after;
};

// `attributes`: of the <html> element.
PageHtml page_html(const SiteOptions& options, std::string_view policy, const std::string& style,
                   const std::string& attributes) {
  constexpr std::string_view kScript = "{{script}}";
  const std::size_t script = k_page_html.find(kScript);
  if (script == std::string_view::npos) throw std::logic_error("the page has no place for its script");
  return {filled_template(k_page_html.substr(0, script), {{"generator", kSiteGenerator},
                                                          {"policy", std::string(policy)},
                                                          {"style", style},
                                                          {"attributes", attributes},
                                                          {"title", html_escaped(options.title)}}),
          filled_template(k_page_html.substr(script + kScript.size()), {})};
}

// The page, with the names of its other files.
SiteFile index_file(const SiteOptions& options, const std::string& style, const std::string& script,
                    const std::string& attributes) {
  const PageHtml html =
      page_html(options, kFolderPolicy, "<link rel=\"stylesheet\" href=\"" + style + "\">", attributes);
  return {"index.html", "text/html; charset=utf-8",
          bytes_of_text(html.before + "<script type=\"module\" src=\"" + script + "\"></script>" + html.after)};
}

SiteFile style_file() {
  return {"viewer.css", "text/css; charset=utf-8", bytes_of_text(k_page_style)};
}

SiteFile script_file() {
  return {"viewer.js", "text/javascript; charset=utf-8", bytes_of_text(k_page_script)};
}

// Returns the files that a browser asks for when it opens index.html. All but index.html are named by content.
std::vector<SiteFile> lasting_page_files(const SiteOptions& options) {
  std::vector<SiteFile> files{named_by_content(style_file()), named_by_content(script_file()),
                              named_by_content(shaders_file())};
  const std::string shaders = " data-shaders=\"" + files[2].name + "\"";
  files.insert(files.begin(), index_file(options, files[0].name, files[1].name, shaders));
  return files;
}

}  // namespace

std::size_t site_ticks(const Snapshot& snapshot) {
  return 1 + cameras_of(snapshot).size();
}

bool same_mesh(const Surface& a, const Surface& b) {
  return &a == &b || (a.mesh.positions == b.mesh.positions && a.mesh.faces == b.mesh.faces && a.offset == b.offset &&
                      a.cells.cell_of_face == b.cells.cell_of_face && a.cells.size == b.cells.size);
}

std::vector<SiteFile> page_files(const SiteOptions& options) {
  const std::string live = options.live ? " data-live=\"live.json\"" : "";
  return {index_file(options, "viewer.css", "viewer.js", live), style_file(), script_file(), shaders_file()};
}

SiteFacts write_site(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
                     const Tick& tick) {
  SiteWriter writer(snapshot, options, put, tick);
  const auto put_all = [&put](std::vector<SiteFile> files) {
    std::uint64_t bytes = 0;
    for (SiteFile& file : files) {
      bytes += file.bytes.size();
      put(std::move(file));
    }
    return bytes;
  };
  const std::uint64_t page_bytes = put_all(lasting_page_files(options));
  const std::uint64_t other_page_bytes = put_all({script_file(), shaders_file()});
  SiteFacts facts = writer.write();
  facts.page_bytes = page_bytes;
  facts.other_page_bytes = other_page_bytes;
  return facts;
}

std::vector<std::string> write_site_version(const Snapshot& snapshot, const SiteOptions& options, SiteHistory& history,
                                            const std::function<void(SiteFile)>& put, const Tick& tick) {
  SiteHistory next = history;
  std::vector<std::string> names = SiteWriter(snapshot, options, put, tick, &next).write_version();
  history = std::move(next);
  return names;
}

SiteFacts write_site_folder(const std::filesystem::path& folder, const Snapshot& snapshot, const SiteOptions& options,
                            const Tick& tick) {
  const auto put = [&](const SiteFile& file) {
    const std::filesystem::path path = folder / file.name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream stream(path, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(file.bytes.data()), static_cast<std::streamsize>(file.bytes.size()));
    if (!stream.flush()) throw InputError(path.string() + ": cannot be written, " + why_not_written());
  };
  return write_site(snapshot, options, put, tick);
}

std::string title_of(const std::filesystem::path& model) {
  const std::filesystem::path name = (model / "").lexically_normal().parent_path().filename();
  return name.extension() == ".glb" ? name.stem().string() : name.string();
}

SiteFacts write_one_page(std::ostream& file, const Snapshot& snapshot, const SiteOptions& options, const Tick& tick) {
  const PageHtml html = page_html(options, kOnePagePolicy, "<style>\n" + std::string(k_page_style) + "</style>", "");
  const std::string end = "<script type=\"module\">\n" + std::string(k_page_script) + "</script>" + html.after;
  file << html.before;
  std::uint64_t page_bytes = html.before.size() + end.size();
  const auto put = [&file](const SiteFile& part) {
    file << "<script type=\"application/octet-stream\" data-file=\"" << html_escaped(part.name) << "\" data-type=\""
         << html_escaped(part.type) << "\">";
    write_base64(file, part.bytes);
    file << "</script>\n";
  };
  const SiteFile shaders = shaders_file();
  page_bytes += shaders.bytes.size();
  put(shaders);
  SiteFacts facts = SiteWriter(snapshot, options, put, tick).write();
  file << end;
  facts.page_bytes = page_bytes;
  return facts;
}

}  // namespace lumatlas
