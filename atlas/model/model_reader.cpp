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

#include "atlas/images/srgb.h"
#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_file.h"
#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_file.h"
#include "atlas/model/model_ranges.h"
#include "atlas/model/read_views.h"
#include "atlas/model/tileset_file.h"
#include "atlas/model/watch.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr AccessorType kWholeNumbers{TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kTriangles{TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 3};
constexpr AccessorType kFlags{TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kNumbers{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR};
constexpr AccessorType kPositions{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3};
constexpr AccessorType kColors{TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4};
constexpr AccessorType kShares{TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4};
constexpr AccessorType kPlaces{TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC2};

// The last vertices of a file may be copies for fade zones or for a base texture, which are left out of the surface.
struct ReadSurface {
  std::shared_ptr<const Surface> surface;
  std::size_t vertices = 0, copies = 0;  // the first mesh's in the file, and how many of them are copies
};

// The far sphere in a file: the number of its mesh, and its number of cells. Both are 0 where there is none.
struct FarPart {
  std::size_t mesh = 0;
  std::uint32_t cells = 0;
};

// The lumigraph of a model, part by part, each checked against the parts before it.
class ModelReader {
 public:
  // `tileset`: null where `surface` is a .glb with all of the model.
  explicit ModelReader(std::unique_ptr<TilesetFile> tileset, const fs::path& surface)
      : tileset_(std::move(tileset)),
        file_(surface),
        lumigraph_(file_.extension(kLumigraphExtension)),
        whole_file_(tileset_ ? static_cast<const FieldReader&>(*tileset_) : file_),
        whole_(tileset_ ? tileset_->lumigraph() : lumigraph_) {
    require_version(whole_file_, whole_);
    require_version(file_, lumigraph_);
    const auto& attributes = file_.triangles().attributes;
    textured_ = attributes.contains(kTexturedColorAttribute) || attributes.contains(kPlaceAttribute);
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
  [[nodiscard]] std::vector<std::uint32_t> whole_numbers(const char* name) const;
  [[nodiscard]] std::vector<std::uint8_t> cells_seen() const;
  [[nodiscard]] FarPart far_part(std::size_t cells) const;
  [[nodiscard]] FarSphere far_sphere(const FarPart& part, std::size_t cells, double cell_size) const;
  [[nodiscard]] Mesh written_mesh(std::size_t number = 0) const;
  [[nodiscard]] std::vector<std::uint32_t> copies(const Mesh& written) const;
  [[nodiscard]] std::vector<CellId> cell_of_vertex(std::size_t vertices, std::size_t first, std::size_t count,
                                                   std::size_t mesh) const;
  [[nodiscard]] std::vector<CellId> cell_of_face(const Mesh& written, std::size_t first, std::size_t count,
                                                 std::size_t mesh) const;
  void require_no_empty_cell(const std::vector<CellId>& of_face, std::size_t first, std::size_t count) const;
  [[nodiscard]] Cells cells(const Mesh& mesh, std::vector<CellId> of_face, std::size_t count) const;
  [[nodiscard]] ReadSurface surface() const;
  [[nodiscard]] std::vector<glm::u8vec3> vertex_colors(const ReadSurface& of) const;
  void add_colors(const char* name, std::size_t mesh, std::size_t vertices, std::size_t copies,
                  std::vector<glm::u8vec3>& colors) const;
  [[nodiscard]] std::vector<std::string> files_beside() const;
  [[nodiscard]] std::uint64_t other_preview_bytes() const;
  [[nodiscard]] int texture_number() const;
  [[nodiscard]] std::optional<GltfImage> texture(std::size_t vertices) const;
  void require_zones(std::size_t cells) const;
  void require_zones_of_mesh(std::size_t mesh, std::size_t zones) const;
  [[nodiscard]] ReferenceTable references(std::size_t cells, std::size_t views) const;
  void require_each_view_once(const ReferenceTable& table, std::size_t views) const;
  // Reads the accessor `name`, one number per cell; empty where the file has none.
  [[nodiscard]] std::vector<float> numbers_of_cells(const char* name, std::size_t cells) const;
  [[nodiscard]] ValidityOptions validity() const;
  [[nodiscard]] TexelFormat texels() const;
  [[nodiscard]] TileTable tiles(const std::vector<ViewEntry>& views) const;
  [[nodiscard]] Camera camera(const GltfFile::Object& view, const std::string& where) const;
  [[nodiscard]] ViewEntry view_entry(const GltfFile::Object& view, const std::string& where) const;
  [[nodiscard]] std::vector<ViewEntry> view_entries() const;
  void require_own_images(const std::vector<ViewEntry>& entries) const;
  [[nodiscard]] GltfImage image(const GltfFile::Object& view, const std::string& where, const char* name) const;

  std::unique_ptr<TilesetFile> tileset_;
  GltfFile file_;                      // the surface
  const GltfFile::Object& lumigraph_;  // the surface's, in file_
  const FieldReader& whole_file_;      // the file of the whole model, which lists the views
  const GltfFile::Object& whole_;      // the whole model's, in whole_file_
  bool textured_ = false;              // it has a base texture
};

std::string out_of(std::uint32_t index, std::size_t count) {
  return std::to_string(index) + " of " + std::to_string(count);
}

std::vector<std::uint32_t> ModelReader::whole_numbers(const char* name) const {
  return file_.values<std::uint32_t>(file_.accessor(lumigraph_, kLumigraphExtension, name), name, kWholeNumbers);
}

Mesh ModelReader::written_mesh(std::size_t number) const {
  Mesh mesh;
  mesh.positions = file_.values<glm::vec3>(file_.attribute("POSITION", number), "POSITION", kPositions);
  mesh.faces = file_.values<glm::uvec3>(file_.triangles(number).indices, "indices", kTriangles);
  if (mesh.faces.empty()) file_.refuse("its mesh has no faces");
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.faces[face][corner];
      if (vertex < mesh.positions.size()) continue;
      file_.refuse("face " + std::to_string(face) + " has the vertex " + out_of(vertex, mesh.positions.size()));
    }
  }
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const glm::vec3& p = mesh.positions[vertex];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      file_.refuse("vertex " + std::to_string(vertex) + " has a coordinate that is not finite");
    }
  }
  return mesh;
}

// Which vertex each of the last ones is a copy of; none without a texture.
std::vector<std::uint32_t> ModelReader::copies(const Mesh& written) const {
  if (!lumigraph_.Has("vertexCopies")) return {};
  std::vector<std::uint32_t> copies = whole_numbers("vertexCopies");
  const std::size_t vertices = written.positions.size();
  if (copies.size() > vertices) {
    file_.refuse("vertexCopies has " + std::to_string(copies.size()) + " entries for " + std::to_string(vertices) +
                 " vertices");
  }
  const std::size_t first = vertices - copies.size();
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const std::string what = "vertex " + std::to_string(first + i) + " is a copy of vertex ";
    if (copies[i] >= first) file_.refuse(what + out_of(copies[i], first) + " that are none");
    if (written.positions[copies[i]] != written.positions[first + i]) {
      file_.refuse(what + std::to_string(copies[i]) + ", but lies elsewhere");
    }
  }
  return copies;
}

// The surface's mesh: every copy gives way to its original.
void leave_out(const std::vector<std::uint32_t>& copies, Mesh& mesh) {
  const std::size_t first = mesh.positions.size() - copies.size();
  mesh.positions.resize(first);
  for (glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      if (face[corner] >= first) face[corner] = copies[face[corner] - first];
    }
  }
}

// Returns for each vertex of a mesh the number of its cell less `first`, in [0, count).
std::vector<CellId> ModelReader::cell_of_vertex(std::size_t vertices, std::size_t first, std::size_t count,
                                                std::size_t mesh) const {
  const auto numbers = file_.values<float>(file_.attribute(kCellAttribute, mesh), kCellAttribute, kNumbers);
  if (numbers.size() != vertices) {
    file_.refuse(std::string(kCellAttribute) + " has " + std::to_string(numbers.size()) + " cells for " +
                 std::to_string(vertices) + " vertices");
  }
  const auto least = static_cast<float>(first), end = static_cast<float>(first + count);
  std::vector<CellId> cells;
  cells.reserve(vertices);
  for (const float number : numbers) {
    // Written so that NaN is refused too.
    if (!(number >= least && number < end && number == std::floor(number))) {
      file_.refuse("vertex " + std::to_string(cells.size()) + (mesh == 0 ? "" : " of mesh " + std::to_string(mesh)) +
                   " is in cell " + number_text(number) + " of " + std::to_string(count) +
                   (first == 0 ? "" : " from cell " + std::to_string(first)));
    }
    cells.emplace_back(static_cast<std::uint32_t>(number) - static_cast<std::uint32_t>(first));
  }
  return cells;
}

std::vector<CellId> ModelReader::cell_of_face(const Mesh& written, std::size_t first, std::size_t count,
                                              std::size_t mesh) const {
  if (first + count > kMostCells) {
    file_.refuse("has " + std::to_string(first + count) + " cells, must be at most " + std::to_string(kMostCells));
  }
  const std::vector<CellId> of_vertex = cell_of_vertex(written.positions.size(), first, count, mesh);
  std::vector<CellId> cells;
  cells.reserve(written.faces.size());
  for (const glm::uvec3& face : written.faces) {
    const CellId cell = of_vertex[face[0]];
    if (of_vertex[face[1]] != cell || of_vertex[face[2]] != cell) {
      file_.refuse("face " + std::to_string(cells.size()) + " has vertices in cells " + std::to_string(cell) + ", " +
                   std::to_string(of_vertex[face[1]]) + " and " + std::to_string(of_vertex[face[2]]) +
                   ", must be in one");
    }
    cells.push_back(cell);
  }
  return cells;
}

FarPart ModelReader::far_part(std::size_t cells) const {
  if (!lumigraph_.Has("far")) return {};
  const GltfFile::Object& far = file_.field(lumigraph_, kLumigraphExtension, "far");
  const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(cells, kMostCells));
  return {file_.whole_number(far, "far", "mesh", 1, 1'000'000), file_.whole_number(far, "far", "cells", 1, most)};
}

FarSphere ModelReader::far_sphere(const FarPart& part, std::size_t cells, double cell_size) const {
  if (part.cells == 0) return {};
  FarSphere far;
  far.mesh = written_mesh(part.mesh);
  std::vector<CellId> of_face = cell_of_face(far.mesh, cells - part.cells, part.cells, part.mesh);
  require_no_empty_cell(of_face, cells - part.cells, part.cells);
  far.cells = measure_cells(far.mesh, std::move(of_face), cell_size);
  return far;
}

// `of_face`: for each face the number of its cell less `first`.
void ModelReader::require_no_empty_cell(const std::vector<CellId>& of_face, std::size_t first,
                                        std::size_t count) const {
  std::vector<std::uint8_t> used(count, 0);
  for (const CellId cell : of_face) used[cell] = 1;
  const auto empty = std::find(used.begin(), used.end(), 0);
  if (empty == used.end()) return;
  file_.refuse("cell " + std::to_string(first + static_cast<std::size_t>(empty - used.begin())) + " has no faces");
}

Cells ModelReader::cells(const Mesh& mesh, std::vector<CellId> of_face, std::size_t count) const {
  const double size = file_.number(lumigraph_, kLumigraphExtension, "cellSize", 0, most_cell_size(mesh));
  require_no_empty_cell(of_face, 0, count);
  return measure_cells(mesh, std::move(of_face), size);
}

// Adds the colours of a mesh to `colors`, without those of the last vertices, which are copies.
void ModelReader::add_colors(const char* name, std::size_t mesh, std::size_t vertices, std::size_t copies,
                             std::vector<glm::u8vec3>& colors) const {
  const auto linear = file_.values<glm::u16vec4>(file_.attribute(name, mesh), name, kColors);
  if (linear.size() != vertices) {
    file_.refuse(std::string(name) + " has " + std::to_string(linear.size()) + " colours for " +
                 std::to_string(vertices) + " vertices");
  }
  for (const glm::u16vec4& c : std::span(linear).first(vertices - copies)) {
    colors.emplace_back(srgb8_from_linear(c.r / 65535.0), srgb8_from_linear(c.g / 65535.0),
                        srgb8_from_linear(c.b / 65535.0));
  }
}

std::vector<glm::u8vec3> ModelReader::vertex_colors(const ReadSurface& of) const {
  std::vector<glm::u8vec3> colors;
  colors.reserve(of.surface->mesh.positions.size());
  add_colors(textured_ ? kTexturedColorAttribute : kColorAttribute, 0, of.vertices, of.copies, colors);
  const FarPart far = far_part(of.surface->cells.cells.size());
  if (far.cells > 0) add_colors(kColorAttribute, far.mesh, of.surface->far_vertices, 0, colors);
  return colors;
}

ReferenceTable ModelReader::references(std::size_t cells, std::size_t views) const {
  ReferenceTable table;
  table.offsets = whole_numbers("referenceOffsets");
  if (lumigraph_.Has("references")) {
    const int accessor = file_.accessor(lumigraph_, kLumigraphExtension, "references");
    table.views = file_.values<ViewSlot>(accessor, "references", kWholeNumbers);
  }
  if (table.offsets.size() != cells + 1) {
    file_.refuse("referenceOffsets has " + std::to_string(table.offsets.size()) + " entries, must have " +
                 std::to_string(cells + 1) + " for " + std::to_string(cells) + " cells");
  }
  if (table.offsets.front() != 0 || table.offsets.back() != table.views.size() ||
      !std::is_sorted(table.offsets.begin(), table.offsets.end())) {
    file_.refuse("referenceOffsets do not rise from 0 to the number of references, " +
                 std::to_string(table.views.size()));
  }
  for (std::size_t i = 0; i < table.views.size(); ++i) {
    if (table.views[i] >= views) {
      file_.refuse("reference " + std::to_string(i) + " is to view " + out_of(table.views[i], views));
    }
  }
  require_each_view_once(table, views);
  return table;
}

// A cell could else have many more references than there are views, all of which the renderer looks at in each pixel.
void ModelReader::require_each_view_once(const ReferenceTable& table, std::size_t views) const {
  std::vector<std::size_t> last_cell(views, table.offsets.size());  // that refers to each view
  for (CellId cell{0}; cell + 1 < table.offsets.size(); ++cell) {
    for (const std::uint32_t view : table.of_cell(cell)) {
      if (std::exchange(last_cell[view], cell) != cell) continue;
      file_.refuse("cell " + std::to_string(cell) + " refers to view " + std::to_string(view) +
                   " twice, must refer to each view once at most");
    }
  }
}

std::vector<float> ModelReader::numbers_of_cells(const char* name, std::size_t cells) const {
  if (!lumigraph_.Has(name)) return {};
  auto numbers = file_.values<float>(file_.accessor(lumigraph_, kLumigraphExtension, name), name, kNumbers);
  if (numbers.size() != cells) {
    file_.refuse(std::string(name) + " has " + std::to_string(numbers.size()) + " entries for " +
                 std::to_string(cells) + " cells");
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (std::isfinite(numbers[cell]) && numbers[cell] >= 0) continue;
    file_.refuse(std::string(name) + " says of cell " + std::to_string(cell) + " " + number_text(numbers[cell]) +
                 ", must be finite and not negative");
  }
  return numbers;
}

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
  std::vector<std::uint8_t> resident;
  if (lumigraph_.Has("resident")) {
    resident =
        file_.values<std::uint8_t>(file_.accessor(lumigraph_, kLumigraphExtension, "resident"), "resident", kFlags);
  }
  std::uint64_t tiles = 0;
  for (const ViewEntry& view : views) {
    table.first_tile.push_back(static_cast<std::uint32_t>(tiles));
    tiles += TileGrid(view.camera.width, view.camera.height, table.options.tile_px).tiles();
  }
  table.first_tile.push_back(static_cast<std::uint32_t>(tiles));
  if (resident.size() != tiles) {
    file_.refuse("\"resident\" says of " + std::to_string(resident.size()) +
                 " tiles whether they are there, its views have " + std::to_string(tiles));
  }
  if (tiles >= TilePlace::none) file_.refuse("has " + std::to_string(tiles) + " tiles, too many");
  std::uint32_t next = 0;
  for (const std::uint8_t there : resident) table.slots.push_back(there ? TilePlace{next++} : TilePlace::none);
  if (next > kMostTileSlots) {
    file_.refuse("has " + std::to_string(next) + " resident tiles, must have at most " +
                 std::to_string(kMostTileSlots));
  }
  return table;
}

Camera ModelReader::camera(const GltfFile::Object& view, const std::string& where) const {
  constexpr std::uint32_t kMaxSide = 65536;
  const std::vector<double> focal = whole_file_.numbers(view, where, "focalLength", 2);
  const std::vector<double> principal = whole_file_.numbers(view, where, "principalPoint", 2);
  const std::vector<double> rotation = whole_file_.numbers(view, where, "rotation", 9);
  const std::vector<double> translation = whole_file_.numbers(view, where, "translation", 3);
  Camera camera;
  camera.width = whole_file_.whole_number(view, where, "width", 1, kMaxSide);
  camera.height = whole_file_.whole_number(view, where, "height", 1, kMaxSide);
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
    whole_file_.refuse(where + ": " + error.what());
  }
  return camera;
}

GltfImage ModelReader::image(const GltfFile::Object& view, const std::string& where, const char* name) const {
  const std::uint32_t number = whole_file_.whole_number(view, where, name, 0, kMostIndex);
  return tileset_ ? tileset_->image(number) : file_.image(number);
}

ViewEntry ModelReader::view_entry(const GltfFile::Object& view, const std::string& where) const {
  ViewEntry entry;
  entry.name = whole_file_.text(view, where, "name");
  entry.camera = camera(view, where);
  const std::vector<double> gain = whole_file_.numbers(view, where, "gain", 3, kLeastExposureGain, kMostExposureGain);
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
  if (!whole_.Has("views")) return entries;  // glTF has no empty arrays
  const GltfFile::Object& views = whole_.Get("views");
  if (!views.IsArray()) whole_file_.refuse("\"views\" is not an array");
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
    whole_file_.refuse("two views have the photograph " + entry.image.file.string() + ", each must have its own");
  }
}

std::vector<std::uint8_t> ModelReader::cells_seen() const {
  return file_.values<std::uint8_t>(file_.accessor(lumigraph_, kLumigraphExtension, "cellSeen"), "cellSeen", kFlags);
}

ReadSurface ModelReader::surface() const {
  auto surface = std::make_shared<Surface>();
  surface->mesh = written_mesh();
  const std::vector<double> offset =
      file_.numbers(lumigraph_, kLumigraphExtension, "offset", 3, -kMostOffset, kMostOffset);
  surface->offset = {offset[0], offset[1], offset[2]};
  const std::size_t all_cells = cells_seen().size();
  const FarPart far = far_part(all_cells);
  const std::size_t count = all_cells - far.cells;
  std::vector<CellId> of_face = cell_of_face(surface->mesh, 0, count, 0);
  const std::vector<std::uint32_t> left_out = copies(surface->mesh);
  ReadSurface read{surface, surface->mesh.positions.size(), left_out.size()};
  leave_out(left_out, surface->mesh);
  surface->cells = cells(surface->mesh, std::move(of_face), count);
  if (far.cells > 0) *surface = with_far_sphere(*surface, far_sphere(far, all_cells, surface->cells.size));
  return read;
}

// Returns the image number of the only material's texture.
int ModelReader::texture_number() const {
  const tinygltf::Model& file = file_.contents();
  const auto chosen = [&](int number, std::size_t count, const std::string& what) {
    if (number >= 0 && static_cast<std::size_t>(number) < count) return static_cast<std::size_t>(number);
    file_.refuse(what + " " + std::to_string(number) + ", which does not exist");
  };
  const std::size_t material = chosen(file_.triangles().material, file.materials.size(), "its mesh has material");
  const tinygltf::TextureInfo& info = file.materials[material].pbrMetallicRoughness.baseColorTexture;
  const std::size_t texture = chosen(info.index, file.textures.size(), "its material has the base texture");
  if (info.texCoord != 0) {
    file_.refuse("its base texture is placed by TEXCOORD_" + std::to_string(info.texCoord) + ", must be by " +
                 kPlaceAttribute);
  }
  return file.textures[texture].source;
}

std::optional<GltfImage> ModelReader::texture(std::size_t vertices) const {
  if (!textured_) return std::nullopt;
  const auto places = file_.values<glm::u16vec2>(file_.attribute(kPlaceAttribute), kPlaceAttribute, kPlaces);
  if (places.size() != vertices) {
    file_.refuse(std::string(kPlaceAttribute) + " has " + std::to_string(places.size()) + " places for " +
                 std::to_string(vertices) + " vertices");
  }
  const int number = texture_number();
  if (number < 0) file_.refuse("its base texture has no image");
  return file_.image(static_cast<std::uint32_t>(number));
}

// Refuses zones that are of no cell: a page reads them. The renderer makes its own.
void ModelReader::require_zones(std::size_t cells) const {
  if (!lumigraph_.Has("zoneCells")) return;
  const std::vector<std::uint32_t> zones = whole_numbers("zoneCells");
  constexpr std::size_t kColumns = 1 + kCellsPerZone;
  if (zones.size() % kColumns != 0) {
    file_.refuse("zoneCells has " + std::to_string(zones.size()) + " entries, must have a multiple of " +
                 std::to_string(kColumns));
  }
  const std::size_t count = zones.size() / kColumns;
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const bool may_be_none = i >= 2 * count;
    if (zones[i] < cells || (may_be_none && zones[i] == CellId::none)) continue;
    file_.refuse("zone " + std::to_string(i % count) + " has the cell " + out_of(zones[i], cells));
  }
  for (const std::size_t mesh : {std::size_t{0}, far_part(cells).mesh}) require_zones_of_mesh(mesh, count);
}

void ModelReader::require_zones_of_mesh(std::size_t mesh, std::size_t zones) const {
  const auto numbers = file_.values<float>(file_.attribute(kZoneAttribute, mesh), kZoneAttribute, kNumbers);
  const auto shares = file_.values<glm::u8vec4>(file_.attribute(kSharesAttribute, mesh), kSharesAttribute, kShares);
  if (numbers.size() != shares.size()) file_.refuse("its vertices have zones without shares");
  const auto end = static_cast<float>(zones);
  const auto wrong = std::find_if(numbers.begin(), numbers.end(),
                                  [&](float zone) { return !(zone >= 0 && zone < end && zone == std::floor(zone)); });
  if (wrong == numbers.end()) return;
  file_.refuse("vertex " + std::to_string(wrong - numbers.begin()) + " is in zone " + number_text(*wrong) + " of " +
               std::to_string(zones));
}

Model ModelReader::model() const {
  Watch watch;
  Model model;
  model.validity = validity();
  Snapshot& snapshot = model.snapshot;
  const ReadSurface read = surface();
  snapshot.surface = read.surface;
  snapshot.cell_seen = cells_seen();
  require_zones(snapshot.cell_seen.size());
  const std::vector<ViewEntry> entries = view_entries();
  snapshot.references = references(snapshot.cell_seen.size(), entries.size());
  snapshot.tiles = tiles(entries);
  snapshot.cell_coverage = numbers_of_cells("cellCoverage", snapshot.cell_seen.size());
  snapshot.cell_deviation = numbers_of_cells("cellDeviation", snapshot.cell_seen.size());
  snapshot.vertex_colors = vertex_colors(read);
  if (const std::optional<GltfImage> image = texture(read.vertices)) (void)size_of(*image);
  for (const ViewEntry& entry : entries) snapshot.gains.push_back(entry.gain);
  model.times.tables = watch.lap_ms();
  snapshot.views =
      read_views(entries, whole_file_.path(), snapshot.surface->mesh, snapshot.tiles, model.validity, model.times);
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
  if (error) throw InputError(image->file.string() + ": cannot be looked at (" + error.message() + ")");
  return bytes;
}

// Returns the names of the files beside a tileset, each of which lies in its folder. Buffers of a surface that is a
// .gltf are among them.
std::vector<std::string> ModelReader::files_beside() const {
  if (!tileset_) return {};
  std::vector<std::string> uris = tileset_->uris();
  for (const std::string& uri : file_.uris()) uris.push_back(uri);
  for (const std::string& uri : uris) (void)tileset_->file_beside(uri, "its file");
  return uris;
}

// The sizes of the poster and of the coarse mesh.
std::uint64_t ModelReader::other_preview_bytes() const {
  std::uint64_t bytes = 0;
  if (whole_.Has("poster")) bytes += bytes_of(image(whole_, kLumigraphExtension, "poster"));
  if (tileset_ && tileset_->coarse()) bytes += bytes_of(GltfImage{*tileset_->coarse(), {}});
  return bytes;
}

ModelFacts ModelReader::facts() const {
  ModelFacts facts;
  facts.file = whole_file_.path();
  const ReadSurface read = surface();
  facts.surface = read.surface;
  const std::vector<std::uint8_t> seen = cells_seen();
  const std::size_t cells = seen.size();
  require_zones(cells);
  facts.cells_seen = static_cast<std::size_t>(std::count_if(seen.begin(), seen.end(), [](auto s) { return s != 0; }));
  const std::vector<ViewEntry> entries = view_entries();
  facts.references = references(cells, entries.size());
  facts.tiles = tiles(entries);
  for (const ViewEntry& entry : entries) {
    facts.views.push_back(entry.camera);
    facts.photograph_bytes += bytes_of(entry.image);
    facts.mask_bytes += bytes_of(entry.lens_mask) + bytes_of(entry.trust_mask) + bytes_of(entry.mask);
    facts.preview_bytes += bytes_of(entry.thumbnail);
  }
  const std::string of_surface = json_of(file_.path());
  facts.json = tileset_ ? tileset_->json() : of_surface;
  facts.json_bytes = of_surface.size() + (tileset_ ? facts.json.size() : 0);
  facts.uris = files_beside();
  facts.texture_bytes = bytes_of(texture(read.vertices));
  facts.preview_bytes += other_preview_bytes();
  const bool has_zones = lumigraph_.Has("zoneCells");
  const std::size_t vertices = read.vertices + read.surface->far_vertices;
  facts.mesh_bytes = vertices * sizeof(glm::vec3) + read.surface->mesh.faces.size() * sizeof(glm::uvec3);
  facts.vertex_bytes = vertices * (sizeof(glm::u16vec4) + sizeof(float)) + read.copies * sizeof(std::uint32_t) +
                       (textured_ ? read.vertices * sizeof(glm::u16vec2) : 0) +
                       (has_zones ? vertices * (sizeof(float) + sizeof(glm::u8vec4)) : 0);
  facts.table_bytes = cells + facts.tiles.slots.size() +
                      sizeof(float) * (numbers_of_cells("cellCoverage", cells).size() +
                                       numbers_of_cells("cellDeviation", cells).size()) +
                      sizeof(std::uint32_t) * (facts.references.offsets.size() + facts.references.views.size() +
                                               (has_zones ? whole_numbers("zoneCells").size() : 0));
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
  if (is_gltf(file)) return read(ModelReader(nullptr, file));
  for (int versions = 1;; ++versions) {
    const fs::file_time_type saved = fs::last_write_time(file);
    auto tileset = std::make_unique<TilesetFile>(file);
    const std::string version = tileset->json();
    try {
      const fs::path surface = tileset->surface();
      return read(ModelReader(std::move(tileset), surface));
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
