// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/site.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/glm.hpp>
#include <iterator>
#include <ostream>
#include <stdexcept>
#include <utility>

#include "blend/cell_shares.h"
#include "blend/cubic_kernel.h"
#include "blend/exposure.h"
#include "blend/shader_program.h"
#include "blend/shaders.h"
#include "blend/zone_mesh.h"
#include "mesh/base/errors.h"
#include "tools/base/html_text.h"
#include "tools/base/output_folder.h"
#include "tools/paths/camera_tours.h"
#include "tools/paths/kept_path.h"
#include "tools/viewer/base64.h"
#include "tools/viewer/packed_arrays.h"
#include "tools/viewer/page_assets.h"
#include "tools/viewer/scaled_view.h"
#include "tools/viewer/web_mesh.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// As the renderer's, see blend/renderer.cpp.
constexpr double kNearShare = 1e-8;

// Tiles of a page where the model has none.
constexpr std::uint32_t kTilePx = 64;

// Of the mesh that the first picture is of.
constexpr std::size_t kCoarseFaces = 60000;

constexpr std::uint32_t kThumbnailPx = 128;
constexpr std::uint32_t kPosterPx = 640;
constexpr ImageCoding kSmallPictures{ImageFormat::jpeg, 80};

std::vector<std::uint8_t> bytes_of_text(std::string_view text) {
  return {text.begin(), text.end()};
}

std::string replaced(std::string text, std::string_view place, std::string_view by) {
  const std::size_t at = text.find(place);
  if (at == std::string::npos) throw std::logic_error("the page has no place for " + std::string(place));
  return text.replace(at, place.size(), by);
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
          {"cubic", options.sampling == BlendOptions::Sampling::cubic},
          {"prefilter", options.prefilter},
          {"nearby_exposure", options.exposure == BlendOptions::Exposure::nearby},
          {"supersample", options.supersample},
          {"antialias_all", options.antialias == BlendOptions::Antialias::all},
          {"occlusion_tolerance", options.occlusion_tolerance}};
}

json shaders() {
  return {
      {"surface.vert", k_surface_vert}, {"surface.frag", k_surface_frag},         {"screen.vert", k_screen_vert},
      {"blend.frag", k_blend_frag},     {"silhouettes.frag", k_silhouettes_frag}, {"diagnose.frag", k_diagnose_frag},
      {"depth.frag", k_depth_frag},     {"photograph.frag", k_photograph_frag},   {"page.frag", k_page_frag},
      {"modes.frag", k_modes_frag},     {"fade.frag", k_fade_frag},             {"glance.frag", k_glance_frag}};
}

std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras;
}

// Where a visitor begins: at the photograph that most cells refer to, which gives the widest view.
std::size_t first_view(const Snapshot& snapshot) {
  std::vector<std::size_t> cells(snapshot.views.size(), 0);
  for (const std::uint32_t slot : snapshot.references.views) ++cells[slot];
  std::size_t best = 0;
  for (std::size_t slot = 0; slot < cells.size(); ++slot) {
    if (snapshot.views[slot] && (!snapshot.views[best] || cells[slot] > cells[best])) best = slot;
  }
  return best;
}

class SiteWriter {
 public:
  SiteWriter(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
             const Tick& tick)
      : snapshot_(snapshot), options_(options), put_(put), tick_(tick) {
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
  SiteFacts write() {
    write_surface();
    write_views();
    return facts_;
  }

 private:
  void put(SiteFile file, std::uint64_t& bytes) {
    bytes += file.bytes.size();
    put_(std::move(file));
  }
  void step() const {
    if (tick_) tick_();
  }

  void write_surface();
  void write_scene(const PackedMesh& mesh, const PackedMesh& coarse, const PackedArrays& tables);
  void write_views();
  void write_view(std::size_t slot, const StoredView& view);
  [[nodiscard]] json view_json(std::size_t slot) const;
  [[nodiscard]] std::string stem(std::size_t slot) const;

  const Snapshot& snapshot_;
  const SiteOptions& options_;
  const std::function<void(SiteFile)>& put_;
  const Tick& tick_;
  std::uint32_t tile_px_ = 0, scaled_tile_px_ = 0;
  SiteFacts facts_;
};

std::string SiteWriter::stem(std::size_t slot) const {
  const std::string number = std::to_string(slot);
  return std::string(5 - std::min<std::size_t>(number.size(), 5), '0') + number;
}

json SiteWriter::view_json(std::size_t slot) const {
  if (!snapshot_.views[slot]) return nullptr;
  const StoredView& view = *snapshot_.views[slot];
  const Camera& camera = view.camera;
  const double scale = facts_.scale;
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera.cam_from_world_rotation[column][row]);
  }
  const double depth = median_depth(view);
  return {{"name", view.name},
          {"photograph", "views/" + stem(slot) + ending(options_.photographs.format)},
          {"mask", "views/" + stem(slot) + ".bin"},
          {"thumbnail", "thumbnails/" + stem(slot) + ".jpg"},
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

// Which tiles are resident, view by view; with whole views, all.
std::vector<std::uint32_t> resident_tiles(const Snapshot& snapshot, std::uint32_t tile_px) {
  std::vector<std::uint32_t> resident;
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const Camera& camera = snapshot.views[slot]->camera;
    const std::uint32_t tiles = TileGrid(camera.width, camera.height, tile_px).tiles();
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      resident.push_back(snapshot.tiles.whole_views() ||
                         snapshot.tiles.slots[snapshot.tiles.first_tile[slot] + tile] != kNotResident);
    }
  }
  return resident;
}

template <typename Records>
std::vector<std::uint32_t> flat(const Records& records, int components) {
  std::vector<std::uint32_t> values;
  for (const auto& record : records) {
    for (int i = 0; i < components; ++i) values.push_back(record[i]);
  }
  return values;
}

void SiteWriter::write_surface() {
  const Surface& surface = *snapshot_.surface;
  const double width = options_.blend.border_width;
  CellShares shares = share_cells(surface, width * surface.cells.size);
  if (width > 0) shares = joined(std::move(shares), first_of_same_references(snapshot_.references));
  const ZoneMesh mesh = zone_mesh(surface.mesh, snapshot_.vertex_colors, surface.cells.cell_of_face, shares);
  const ZoneReferences lists = zone_references(mesh.zone_cells, snapshot_.references, snapshot_.cell_seen);
  const PackedMesh packed = packed_mesh(mesh, position_grid(snapshot_));
  PackedArrays tables;
  tables.add("zones", flat(lists.zones, 3), 3, PackedCoding::difference);
  tables.add("cells", flat(lists.cells, 3), 3, PackedCoding::difference);
  tables.add("references", lists.references, 1, PackedCoding::difference);
  tables.add("resident", resident_tiles(snapshot_, tile_px_), 1, PackedCoding::plain);
  const PackedMesh coarse = packed_mesh(coarse_mesh(snapshot_, kCoarseFaces), packed.grid);
  write_scene(packed, coarse, tables);
  if (coarse.corner_counts[0] > 0) {
    put({"coarse.bin", "application/octet-stream", coarse.arrays.deflated()}, facts_.scene_bytes);
  }
  put({"mesh.bin", "application/octet-stream", packed.arrays.deflated()}, facts_.mesh_bytes);
  put({"tables.bin", "application/octet-stream", tables.deflated()}, facts_.table_bytes);
  step();
}

json mesh_json(const PackedMesh& mesh, const char* file) {
  return {{"file", file},
          {"arrays", mesh.arrays.description()},
          {"corner_counts", mesh.corner_counts},
          {"origin", json_of(mesh.grid.origin)},
          {"step", mesh.grid.step}};
}

void SiteWriter::write_scene(const PackedMesh& mesh, const PackedMesh& coarse, const PackedArrays& tables) {
  const Surface& surface = *snapshot_.surface;
  const Bounds box = bounds(surface.mesh);
  const SceneExtent extent = scene_extent(surface.mesh);
  const std::vector<Camera> cameras = cameras_of(snapshot_);
  json views = json::array();
  for (std::size_t slot = 0; slot < snapshot_.views.size(); ++slot) views.push_back(view_json(slot));
  const TileOptions& tiles = snapshot_.tiles.options;
  const json scene = {{"lumatlas", LUMATLAS_VERSION},
                      {"format", 1},
                      {"title", options_.title},
                      {"shaders", shaders()},
                      {"definitions", shared_definitions()},
                      {"blend", json_of(options_.blend)},
                      {"mesh", mesh_json(mesh, "mesh.bin")},
                      {"coarse", coarse.corner_counts[0] > 0 ? mesh_json(coarse, "coarse.bin") : json()},
                      {"tables", {{"file", "tables.bin"}, {"arrays", tables.description()}}},
                      {"tile", scaled_tile_px_},
                      {"levels", levels_of_gutter(tiles.gutter_px)},
                      {"cubic_levels", cubic_levels(tiles)},
                      {"near_depth", kNearShare * glm::length(box.max - box.min)},
                      {"inverse_depth", NearbyExposure(snapshot_).per_depth()},
                      {"up", json_of(upward(cameras))},
                      {"photographed",
                       {{"cosine", kPhotographedCosine},
                        {"enlargement", kPhotographedEnlargement},
                        {"share", kCoveredShare}}},
                      {"core", {{"min", json_of(extent.core.min)}, {"max", json_of(extent.core.max)}}},
                      {"first_view", first_view(snapshot_)},
                      {"poster", "poster.jpg"},
                      {"views", std::move(views)}};
  put({"scene.json", "application/json", bytes_of_text(json_text(scene))}, facts_.scene_bytes);
  const StoredView& first = *snapshot_.views[first_view(snapshot_)];
  put({"poster.jpg", "image/jpeg", encode_image(small_picture(first, kPosterPx), kSmallPictures)}, facts_.scene_bytes);
}

void SiteWriter::write_views() {
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

void SiteWriter::write_view(std::size_t slot, const StoredView& view) {
  const ScaledView scaled = scaled_view(view, facts_.scale);
  const ImageCoding& coding = options_.photographs;
  put({"thumbnails/" + stem(slot) + ".jpg", "image/jpeg",
       encode_image(small_picture(view, kThumbnailPx), kSmallPictures)},
      facts_.photograph_bytes);
  put({"views/" + stem(slot) + ending(coding.format), mime_type(coding.format),
       encode_image(scaled.photograph, coding)},
      facts_.photograph_bytes);
  PackedArrays mask;
  mask.add("validity", std::vector<std::uint32_t>(scaled.validity.begin(), scaled.validity.end()), 1,
           PackedCoding::difference);
  mask.add("rim", bits_of(scaled.rim), 1, PackedCoding::plain);
  // The arrays' sizes follow from the view's, but not how many bytes their values have.
  json description = mask.description();
  const std::vector<std::uint8_t> packed = mask.deflated();
  std::vector<std::uint8_t> file{static_cast<std::uint8_t>(description[0]["bytes"].get<int>()),
                                 static_cast<std::uint8_t>(description[1]["bytes"].get<int>())};
  file.insert(file.end(), packed.begin(), packed.end());
  put({"views/" + stem(slot) + ".bin", "application/octet-stream", std::move(file)}, facts_.mask_bytes);
}

// Of scripts and pictures of the site's own alone.
constexpr std::string_view kFolderPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'";
// All is inside; nothing is asked of anybody.
constexpr std::string_view kOnePagePolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'";

std::string page(const SiteOptions& options, std::string_view policy, std::string_view style, std::string_view script) {
  std::string html(k_page_html);
  html = replaced(std::move(html), "{{generator}}", kSiteGenerator);
  html = replaced(std::move(html), "{{policy}}", policy);
  html = replaced(std::move(html), "{{script}}", script);
  html = replaced(std::move(html), "{{style}}", style);
  return replaced(std::move(html), "{{title}}", html_escaped(options.title));
}

}  // namespace

std::size_t site_ticks(const Snapshot& snapshot) {
  return 1 + cameras_of(snapshot).size();
}

SiteFacts write_site(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
                     const Tick& tick) {
  SiteWriter writer(snapshot, options, put, tick);
  const std::array<SiteFile, 3> files{
      SiteFile{"index.html", "text/html; charset=utf-8",
               bytes_of_text(page(options, kFolderPolicy, R"(<link rel="stylesheet" href="viewer.css">)",
                                  R"(<script type="module" src="viewer.js"></script>)"))},
      SiteFile{"viewer.css", "text/css; charset=utf-8", bytes_of_text(k_page_style)},
      SiteFile{"viewer.js", "text/javascript; charset=utf-8", bytes_of_text(k_page_script)}};
  std::uint64_t page_bytes = 0;
  for (const SiteFile& file : files) {
    page_bytes += file.bytes.size();
    put(file);
  }
  SiteFacts facts = writer.write();
  facts.page_bytes = page_bytes;
  return facts;
}

SiteFacts write_site_folder(const std::filesystem::path& folder, const Snapshot& snapshot, const SiteOptions& options,
                            const Tick& tick) {
  const auto put = [&](const SiteFile& file) {
    const std::filesystem::path path = folder / file.name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream stream(path, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(file.bytes.data()), static_cast<std::streamsize>(file.bytes.size()));
    if (!stream.flush()) throw InputError(path.string() + ": cannot be written, is the disk full?");
  };
  return write_site(snapshot, options, put, tick);
}

std::string title_of(const std::filesystem::path& model) {
  const std::filesystem::path name = (model / "").lexically_normal().parent_path().filename();
  return name.extension() == ".glb" ? name.stem().string() : name.string();
}

SiteFacts write_one_page(std::ostream& file, const Snapshot& snapshot, const SiteOptions& options, const Tick& tick) {
  const std::string style = "<style>\n" + std::string(k_page_style) + "</style>";
  const std::string script = "<script type=\"module\">\n" + std::string(k_page_script) + "</script>";
  const std::string html = page(options, kOnePagePolicy, style, "{{data}}" + script);
  const std::size_t place = html.find("{{data}}");
  file << html.substr(0, place);
  std::uint64_t page_bytes = html.size();
  const auto put = [&](const SiteFile& part) {
    file << "<script type=\"application/octet-stream\" data-file=\"" << html_escaped(part.name) << "\" data-type=\""
         << html_escaped(part.type) << "\">";
    write_base64(file, part.bytes);
    file << "</script>\n";
  };
  SiteFacts facts = SiteWriter(snapshot, options, put, tick).write();
  file << html.substr(place + 8);
  facts.page_bytes = page_bytes;
  return facts;
}

}  // namespace lumatlas
