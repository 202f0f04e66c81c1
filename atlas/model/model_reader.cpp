// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_file.h"
#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_file.h"
#include "atlas/model/model_ranges.h"
#include "atlas/model/read_views.h"
#include "atlas/model/surface/joined_surface.h"
#include "atlas/model/surface/surface_file.h"
#include "atlas/model/tileset_file.h"
#include "atlas/model/watch.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The lumigraph of a model, part by part, each checked against the parts before it.
class ModelReader {
 public:
  // `tileset`: null where there is one surface, of a .glb with all of the model.
  ModelReader(std::unique_ptr<TilesetFile> tileset, const std::vector<fs::path>& surfaces)
      : tileset_(std::move(tileset)),
        files_(opened(surfaces)),
        whole_file_(tileset_ ? static_cast<const FieldReader&>(*tileset_) : files_.front()->gltf()),
        whole_(tileset_ ? tileset_->lumigraph() : files_.front()->lumigraph()),
        view_file_(tileset_ ? tileset_->view_file() : whole_file_),
        view_lists_(tileset_ ? tileset_->view_lists() : whole_) {
    require_version(whole_file_, whole_);
    for (const auto& file : files_) require_version(file->gltf(), file->lumigraph());
  }

  [[nodiscard]] Model model() const;
  [[nodiscard]] ModelFacts facts() const;

 private:
  static void require_version(const FieldReader& file, const GltfFile::Object& lumigraph) {
    const std::uint32_t version = file.whole_number(lumigraph, kLumigraphExtension, "version", 0, 1'000'000);
    if (version == kLumigraphVersion) return;
    const std::string what = "has version " + std::to_string(version) + " of " + kLumigraphExtension;
    if (version < kLumigraphVersion) file.refuse(what + ": it was made by an older lumatlas, build it again");
    file.refuse(what + ", this program reads version " + std::to_string(kLumigraphVersion));
  }
  static std::vector<std::unique_ptr<SurfaceFile>> opened(const std::vector<fs::path>& surfaces) {
    std::vector<std::unique_ptr<SurfaceFile>> files;
    files.reserve(surfaces.size());
    for (const fs::path& surface : surfaces) files.push_back(std::make_unique<SurfaceFile>(surface));
    return files;
  }
  void require_zones(const JoinedSurface& surface) const;
  // Returns the images of base textures, each once.
  [[nodiscard]] std::vector<GltfImage> textures(const JoinedSurface& surface) const;
  [[nodiscard]] std::vector<std::string> files_beside() const;
  [[nodiscard]] std::uint64_t other_preview_bytes() const;
  [[nodiscard]] ValidityOptions validity() const;
  [[nodiscard]] TexelFormat texels() const;
  [[nodiscard]] std::optional<GeoReference> georeference() const;
  [[nodiscard]] TileTable tiles(const std::vector<ViewEntry>& views) const;
  [[nodiscard]] Camera camera(const GltfFile::Object& view, const std::string& where) const;
  [[nodiscard]] ViewEntry view_entry(const GltfFile::Object& view, const std::string& where) const;
  [[nodiscard]] std::vector<ViewEntry> view_entries() const;
  void require_own_images(const std::vector<ViewEntry>& entries) const;
  [[nodiscard]] GltfImage image(const GltfFile::Object& view, const std::string& where, const char* name) const;

  std::unique_ptr<TilesetFile> tileset_;
  std::vector<std::unique_ptr<SurfaceFile>> files_;  // the surfaces, in the order of the tileset
  const FieldReader& whole_file_;                    // the file of the whole model
  const GltfFile::Object& whole_;                    // the whole model's, in whole_file_
  const FieldReader& view_file_;                     // which lists the views
  const GltfFile::Object& view_lists_;               // in view_file_
};

ValidityOptions ModelReader::validity() const {
  const GltfFile::Object& object = whole_file_.field(whole_, kLumigraphExtension, "validity");
  ValidityOptions options;
  options.depth_edge = whole_file_.number(object, "validity", "depthEdge", 0, kMostDepthEdge);
  options.edge_radius_px = whole_file_.whole_number(object, "validity", "edgeRadius", 0, kMostEdgePixels);
  options.fade_px = whole_file_.whole_number(object, "validity", "fade", 0, kMostEdgePixels);
  const std::string edges = object.Has("edges") ? whole_file_.text(object, "validity", "edges") : "both";
  const auto known = kEdgesByName.find(edges);
  if (known == kEdgesByName.end()) {
    whole_file_.refuse("validity: \"edges\" is \"" + edges + "\", must be \"far\" or \"both\"");
  }
  options.edges = known->second;
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    whole_file_.refuse(error.what());
  }
  return options;
}

// Files of earlier versions of this program do not say.
TexelFormat ModelReader::texels() const {
  if (!whole_.Has("texels")) return TexelFormat::rgb8;
  const std::string name = whole_file_.text(whole_, kLumigraphExtension, "texels");
  const auto known = kTexelFormatsByName.find(name);
  if (known == kTexelFormatsByName.end()) {
    whole_file_.refuse("\"texels\" is \"" + name + "\", must be \"rgb8\" or \"bc7\"");
  }
  return known->second;
}

std::optional<GeoReference> ModelReader::georeference() const {
  if (!whole_.Has("georeference")) return std::nullopt;
  const char* const where = "georeference";
  const GltfFile::Object& object = whole_file_.field(whole_, kLumigraphExtension, where);
  const std::string frame = whole_file_.text(object, where, "frame");
  GeoReference reference;
  if (frame == kGeocentricFrame) {
    reference.frame = GeoReference::Frame::geocentric;
    if (object.Has("system")) reference.system = whole_file_.text(object, where, "system");
    return reference;
  }
  if (frame != kEastNorthUpFrame) {
    whole_file_.refuse("georeference: \"frame\" is " + in_quotes(frame) + ", must be \"" + kEastNorthUpFrame +
                       "\" or \"" + kGeocentricFrame + "\"");
  }
  reference.latitude_deg = whole_file_.number(object, where, "latitude", -90, 90);
  reference.longitude_deg = whole_file_.number(object, where, "longitude", -180, 180);
  reference.altitude_m = whole_file_.number(object, where, "altitude", -kMostAltitude, kMostAltitude);
  return reference;
}

// Slots are given anew, in order.
TileTable ModelReader::tiles(const std::vector<ViewEntry>& views) const {
  TileTable table;
  table.options = kWholeViews;
  table.options.texels = texels();
  if (!whole_.Has("tiles")) return table;
  const GltfFile::Object& object = whole_file_.field(whole_, kLumigraphExtension, "tiles");
  table.options.tile_px = whole_file_.whole_number(object, "tiles", "size", 8, 1024);
  table.options.gutter_px = whole_file_.whole_number(object, "tiles", "gutter", 1, 8);
  try {
    check(table.options);
  } catch (const std::invalid_argument& error) {
    whole_file_.refuse(error.what());
  }
  const GltfFile& file = files_.front()->gltf();
  const std::vector<std::uint8_t> resident = files_.front()->resident();
  std::uint64_t tiles = 0;
  for (const ViewEntry& view : views) {
    table.first_tile.push_back(static_cast<std::uint32_t>(tiles));
    tiles += TileGrid(view.camera.width, view.camera.height, table.options.tile_px).tiles();
  }
  table.first_tile.push_back(static_cast<std::uint32_t>(tiles));
  if (resident.size() != tiles) {
    file.refuse("\"resident\" says of " + std::to_string(resident.size()) +
                " tiles whether they are there, its views have " + std::to_string(tiles));
  }
  if (tiles >= TilePlace::none) file.refuse("has " + std::to_string(tiles) + " tiles, too many");
  std::uint32_t next = 0;
  for (const std::uint8_t there : resident) table.places.push_back(there ? TilePlace{next++} : TilePlace::none);
  if (next > kMostTilePlaces) {
    file.refuse("has " + std::to_string(next) + " resident tiles, must have at most " +
                std::to_string(kMostTilePlaces));
  }
  return table;
}

Camera ModelReader::camera(const GltfFile::Object& view, const std::string& where) const {
  constexpr std::uint32_t kMaxSide = 65536;
  const std::vector<double> focal = view_file_.numbers(view, where, "focalLength", 2);
  const std::vector<double> principal = view_file_.numbers(view, where, "principalPoint", 2);
  const std::vector<double> rotation = view_file_.numbers(view, where, "rotation", 9);
  const std::vector<double> translation = view_file_.numbers(view, where, "translation", 3);
  Camera camera;
  camera.width = view_file_.whole_number(view, where, "width", 1, kMaxSide);
  camera.height = view_file_.whole_number(view, where, "height", 1, kMaxSide);
  camera.fx = focal[0];
  camera.fy = focal[1];
  camera.cx = principal[0];
  camera.cy = principal[1];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      camera.cam_from_world_rotation[column][row] =
          rotation[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)];
    }
    camera.cam_from_world_translation[row] = translation[static_cast<std::size_t>(row)];
  }
  try {
    check(camera);
    check_model_ranges(camera);
  } catch (const std::invalid_argument& error) {
    view_file_.refuse(where + ": " + error.what());
  }
  return camera;
}

GltfImage ModelReader::image(const GltfFile::Object& view, const std::string& where, const char* name) const {
  const std::uint32_t number = view_file_.whole_number(view, where, name, 0, kMostIndex);
  return tileset_ ? tileset_->view_image(number) : files_.front()->gltf().image(number);
}

ViewEntry ModelReader::view_entry(const GltfFile::Object& view, const std::string& where) const {
  ViewEntry entry;
  entry.name = view_file_.text(view, where, "name");
  entry.camera = camera(view, where);
  const std::vector<double> gain = view_file_.numbers(view, where, "gain", 3, kLeastExposureGain, kMostExposureGain);
  entry.gain = {gain[0], gain[1], gain[2]};
  entry.image = image(view, where, "image");
  if (view.Has("lensMask")) entry.lens_mask = image(view, where, "lensMask");
  if (view.Has("trustMask")) entry.trust_mask = image(view, where, "trustMask");
  if (view.Has("mask")) entry.mask = image(view, where, "mask");
  if (view.Has("thumbnail")) entry.thumbnail = image(view, where, "thumbnail");
  return entry;
}

std::vector<ViewEntry> ModelReader::view_entries() const {
  std::vector<ViewEntry> entries;
  if (!view_lists_.Has("views")) return entries;  // glTF has no empty arrays
  const GltfFile::Object& views = view_lists_.Get("views");
  if (!views.IsArray()) view_file_.refuse("\"views\" is not an array");
  for (std::size_t index = 0; index < views.ArrayLen(); ++index) {
    entries.push_back(view_entry(views.Get(static_cast<int>(index)), "view " + std::to_string(index)));
  }
  require_own_images(entries);
  return entries;
}

// A file of a few kilobytes could else ask for one large photograph a million times.
void ModelReader::require_own_images(const std::vector<ViewEntry>& entries) const {
  std::set<fs::path> files;
  std::map<const unsigned char*, const unsigned char*> ends;  // for the first byte of each range in buffers, its end
  for (const ViewEntry& entry : entries) {
    const std::span<const unsigned char> bytes = entry.image.bytes;
    if (!bytes.empty()) {
      const auto next = ends.lower_bound(bytes.data());
      const bool before_next = next == ends.end() || next->first >= bytes.data() + bytes.size();
      const bool after_last = next == ends.begin() || std::prev(next)->second <= bytes.data();
      ends.emplace(bytes.data(), bytes.data() + bytes.size());
      if (before_next && after_last) continue;
    } else if (files.insert(entry.image.file.lexically_normal()).second) {
      continue;
    }
    view_file_.refuse("two views have the photograph " + entry.image.file.string() + ", each must have its own");
  }
}

void ModelReader::require_zones(const JoinedSurface& surface) const {
  for (std::size_t file = 0; file < files_.size(); ++file) files_[file]->require_zones(surface.cells_of(file));
}

std::vector<GltfImage> ModelReader::textures(const JoinedSurface& surface) const {
  std::vector<GltfImage> images;
  std::set<fs::path> files;
  for (std::size_t file = 0; file < files_.size(); ++file) {
    const std::optional<GltfImage> image = files_[file]->texture(surface.written_vertices_of(file));
    if (image && (!image->bytes.empty() || files.insert(image->file.lexically_normal()).second)) {
      images.push_back(*image);
    }
  }
  return images;
}

Model ModelReader::model() const {
  Watch watch;
  Model model;
  model.validity = validity();
  Snapshot& snapshot = model.snapshot;
  const JoinedSurface joined(files_);
  snapshot.surface = joined.surface();
  snapshot.cell_seen = joined.cells_seen();
  require_zones(joined);
  const std::vector<ViewEntry> entries = view_entries();
  snapshot.references = joined.references(entries.size());
  snapshot.tiles = tiles(entries);
  snapshot.cell_coverage = joined.numbers_of_cells("cellCoverage");
  snapshot.cell_deviation = joined.numbers_of_cells("cellDeviation");
  snapshot.vertex_colors = joined.vertex_colors();
  snapshot.georeference = georeference();
  for (const GltfImage& image : textures(joined)) (void)size_of(image);
  for (const ViewEntry& entry : entries) snapshot.gains.push_back(entry.gain);
  model.times.tables = watch.lap_ms();
  snapshot.views =
      read_views(entries, view_file_.path(), snapshot.surface->mesh, snapshot.tiles, model.validity, model.times);
  leave_out_views_without_tiles(snapshot);
  model.times.views = watch.lap_ms();
  return model;
}

std::string json_of(const fs::path& file) {
  return is_glb(file) ? read_glb_frame(file).json : read_whole_file(file);
}

std::uint64_t bytes_of(const std::optional<GltfImage>& image) {
  if (!image) return 0;
  if (!image->bytes.empty()) return image->bytes.size();
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(image->file, error);
  if (error == std::errc::no_such_file_or_directory) throw InputError(image->file.string() + ": no such file");
  if (error) throw InputError(image->file.string() + ": cannot be accessed (" + error.message() + ")");
  return bytes;
}

// Returns the names of the files beside a tileset, each of which lies in its folder. Buffers of a surface that is a
// .gltf are among them.
std::vector<std::string> ModelReader::files_beside() const {
  if (!tileset_) return {};
  std::vector<std::string> uris = tileset_->uris();
  std::set<std::string> named(uris.begin(), uris.end());
  for (const auto& file : files_) {
    for (const std::string& uri : file->gltf().uris()) {
      if (named.insert(uri).second) uris.push_back(uri);  // chunks share their base texture
    }
  }
  for (const std::string& uri : uris) (void)tileset_->file_beside(uri, "its file");
  return uris;
}

// The sizes of the poster and of the coarse surfaces.
std::uint64_t ModelReader::other_preview_bytes() const {
  std::uint64_t bytes = 0;
  if (whole_.Has("poster")) {
    const std::uint32_t number = whole_file_.whole_number(whole_, kLumigraphExtension, "poster", 0, kMostIndex);
    bytes += bytes_of(tileset_ ? tileset_->image(number) : files_.front()->gltf().image(number));
  }
  if (!tileset_) return bytes;
  for (const std::filesystem::path& file : tileset_->coarse()) bytes += bytes_of(GltfImage{file, {}});
  return bytes;
}

ModelFacts ModelReader::facts() const {
  ModelFacts facts;
  facts.file = whole_file_.path();
  const JoinedSurface joined(files_);
  facts.surface = joined.surface();
  const std::vector<std::uint8_t> seen = joined.cells_seen();
  const std::size_t cells = seen.size();
  require_zones(joined);
  facts.cells_seen = static_cast<std::size_t>(std::count_if(seen.begin(), seen.end(), [](auto s) { return s != 0; }));
  const std::vector<ViewEntry> entries = view_entries();
  facts.references = joined.references(entries.size());
  facts.tiles = tiles(entries);
  facts.georeference = georeference();
  for (const ViewEntry& entry : entries) {
    facts.views.push_back(entry.camera);
    facts.photograph_bytes += bytes_of(entry.image);
    facts.mask_bytes += bytes_of(entry.lens_mask) + bytes_of(entry.trust_mask) + bytes_of(entry.mask);
    facts.preview_bytes += bytes_of(entry.thumbnail);
  }
  facts.json = tileset_ ? tileset_->json() : json_of(whole_file_.path());
  facts.json_bytes = tileset_ ? facts.json.size() : 0;
  if (&view_file_ != &whole_file_) facts.json_bytes += bytes_of(GltfImage{view_file_.path(), {}});
  for (const auto& file : files_) facts.json_bytes += json_of(file->gltf().path()).size();
  facts.uris = files_beside();
  for (const GltfImage& image : textures(joined)) facts.texture_bytes += bytes_of(image);
  facts.preview_bytes += other_preview_bytes();
  const bool has_zones = files_.front()->has("zoneCells"), textured = files_.front()->textured();
  std::size_t zone_numbers = 0;
  for (const auto& file : files_) zone_numbers += file->zone_numbers();
  const std::size_t vertices = joined.written_vertices() + facts.surface->far_vertices;
  facts.mesh_bytes = vertices * sizeof(glm::vec3) + facts.surface->mesh.faces.size() * sizeof(glm::uvec3);
  facts.vertex_bytes = vertices * (sizeof(glm::u16vec4) + sizeof(float)) + joined.copies() * sizeof(std::uint32_t) +
                       (textured ? joined.written_vertices() * sizeof(glm::u16vec2) : 0) +
                       (has_zones ? vertices * (sizeof(float) + sizeof(glm::u8vec4)) : 0);
  facts.table_bytes =
      cells + facts.tiles.places.size() +
      sizeof(float) *
          (joined.numbers_of_cells("cellCoverage").size() + joined.numbers_of_cells("cellDeviation").size()) +
      sizeof(std::uint32_t) * (facts.references.offsets.size() + facts.references.views.size() + zone_numbers);
  return facts;
}

// Returns the file itself, or the file in a folder.
fs::path file_of(const fs::path& path) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(path, ignored);
  fs::path file = is_folder ? path / kTilesetName : path;
  if (fs::is_regular_file(file, ignored)) return file;
  if (is_folder && fs::is_regular_file(path / "scene.gltf", ignored)) {
    throw InputError(path.string() + ": is a model that an older lumatlas made, build it again");
  }
  throw InputError(file.string() + ": no such file: give a folder or a .glb that `lumatlas build` wrote");
}

bool is_gltf(const fs::path& file) {
  return is_glb(file) || file.extension() == ".gltf";
}

// Calls read() with a reader of the model. A save may put another model into the folder meanwhile, and remove files
// that the earlier tileset names; read() then fails, and is called again with a reader of the later one.
template <typename Read>
auto read_one_version(const fs::path& path, const Read& read) {
  constexpr int kMostVersions = 1000;  // of a folder that is saved to faster than it can be read
  const fs::path file = file_of(path);
  if (is_gltf(file)) return read(ModelReader(nullptr, {file}));
  for (int versions = 1;; ++versions) {
    const fs::file_time_type saved = fs::last_write_time(file);
    auto tileset = std::make_unique<TilesetFile>(file);
    const std::string version = tileset->json();
    try {
      const std::vector<fs::path> surfaces = tileset->surfaces();
      return read(ModelReader(std::move(tileset), surfaces));
    } catch (const std::runtime_error&) {  // an InputError, or what the file system says of a file that is gone
      const bool is_same = fs::last_write_time(file) == saved && read_whole_file(file) == version;
      if (versions == kMostVersions || is_same) throw;
    }
  }
}

}  // namespace

Model read_model(const fs::path& path) {
  Watch watch;
  return read_one_version(path, [&](const ModelReader& reader) {
    const double parsed = watch.lap_ms();
    Model model = reader.model();
    model.times.tables += parsed;
    return model;
  });
}

ModelFacts read_model_facts(const fs::path& path) {
  return read_one_version(path, [](const ModelReader& reader) { return reader.facts(); });
}

std::string read_model_json(const fs::path& path) {
  const fs::path file = file_of(path);
  std::string json = json_of(file);
  if (const int levels = nesting(json); levels > kMaxNesting) {
    throw InputError(file.string() + ": nests its values " + std::to_string(levels) + " deep, must be at most " +
                     std::to_string(kMaxNesting));
  }
  return json;
}

}  // namespace lumatlas
