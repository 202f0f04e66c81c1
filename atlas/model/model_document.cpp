// SPDX-License-Identifier: GPL-3.0-or-later
// 3D Tiles 1.1, sections 6.7.1.6 (y is up in glTF, z in tiles) and 6.8 (tileset JSON).
#include "atlas/model/model_document.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <utility>

#include "atlas/images/pixel_memory.h"
#include "atlas/images/srgb.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_ranges.h"
#include "mesh/upright.h"

namespace lumatlas {

namespace {

using nlohmann::json;

json json_of(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json json_of(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    json geocentric{{"frame", kGeocentricFrame}};
    if (!reference.system.empty()) geocentric["system"] = unicode_name(reference.system);
    return geocentric;
  }
  return {{"frame", kEastNorthUpFrame},
          {"latitude", reference.latitude_deg},
          {"longitude", reference.longitude_deg},
          {"altitude", reference.altitude_m}};
}

std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras;
}

// Returns whether a photograph's rows are within 5 degrees of the horizon, the right way up.
bool is_level(const Camera& camera, const glm::dvec3& up) {
  const glm::dvec3 up_in_camera = camera.cam_from_world_rotation * up;  // y down
  return std::abs(up_in_camera.x) <= std::sin(glm::radians(5.0)) && up_in_camera.y < 0;
}

const char* property_of(ModelImageKind kind) {
  switch (kind) {
    case ModelImageKind::photograph:
      return "image";
    case ModelImageKind::lens_mask:
      return "lensMask";
    case ModelImageKind::trust_mask:
      return "trustMask";
    case ModelImageKind::mask:
      return "mask";
    case ModelImageKind::thumbnail:
      return "thumbnail";
    case ModelImageKind::poster:
      break;
  }
  return "poster";
}

// Image number `image`, clamped at its borders and filtered between its levels.
void add_texture(json& document, int image) {
  constexpr int kLinear = 9729, kLinearOfLevels = 9987, kClamped = 33071;
  document["samplers"].push_back(
      {{"magFilter", kLinear}, {"minFilter", kLinearOfLevels}, {"wrapS", kClamped}, {"wrapT", kClamped}});
  document["textures"].push_back({{"sampler", 0}, {"source", image}});
}

// The photographs' light is in the colours already, and rooms are seen from inside. Returns its number.
int add_unlit_material(json& document, bool textured) {
  json surface = {{"metallicFactor", 0}};
  if (textured) surface["baseColorTexture"] = {{"index", 0}};
  json& materials = document["materials"];
  materials.push_back({{"pbrMetallicRoughness", std::move(surface)},
                       {"doubleSided", true},
                       {"extensions", {{kUnlitExtension, json::object()}}}});
  if (materials.size() == 1) document["extensionsUsed"].push_back(kUnlitExtension);
  return static_cast<int>(materials.size()) - 1;
}

int add_positions(GltfBuilder& gltf, const std::vector<glm::vec3>& positions) {
  const int number = gltf.add(positions, {kGltfFloat, "VEC3"}, GltfPacking::grid, kGltfVertices);
  glm::vec3 low = positions.front(), high = positions.front();
  for (const glm::vec3& p : positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  gltf.accessor(number)["min"] = {low.x, low.y, low.z};
  gltf.accessor(number)["max"] = {high.x, high.y, high.z};
  return number;
}

int add_faces(GltfBuilder& gltf, const std::vector<glm::uvec3>& faces) {
  return gltf.add(faces, {kGltfWhole, "SCALAR"}, GltfPacking::triangles, kGltfFaces);
}

int add_normalized(GltfBuilder& gltf, int accessor) {
  gltf.accessor(accessor)["normalized"] = true;
  return accessor;
}

int add_colors(GltfBuilder& gltf, const std::vector<glm::u16vec4>& colors) {
  return add_normalized(gltf, gltf.add(colors, {kGltfShort, "VEC4"}, GltfPacking::attributes, kGltfVertices));
}

// A mesh without its colours.
json primitive_json(GltfBuilder& gltf, const WrittenMesh& mesh, bool textured) {
  json attributes = {
      {"POSITION", add_positions(gltf, mesh.positions)},
      {kCellAttribute, gltf.add(mesh.cells, {kGltfFloat, "SCALAR"}, GltfPacking::attributes, kGltfVertices)}};
  if (!mesh.zones.empty()) {
    attributes[kZoneAttribute] = gltf.add(mesh.zones, {kGltfFloat, "SCALAR"}, GltfPacking::attributes, kGltfVertices);
    attributes[kSharesAttribute] =
        add_normalized(gltf, gltf.add(mesh.shares, {kGltfByte, "VEC4"}, GltfPacking::attributes, kGltfVertices));
  }
  if (textured) {
    attributes[kPlaceAttribute] =
        add_normalized(gltf, gltf.add(mesh.places, {kGltfShort, "VEC2"}, GltfPacking::attributes, kGltfVertices));
  }
  return {{"mode", 4},
          {"material", add_unlit_material(gltf.document(), textured)},
          {"attributes", std::move(attributes)},
          {"indices", add_faces(gltf, mesh.faces)}};
}

int add_numbers(GltfBuilder& gltf, const std::vector<float>& numbers) {
  return gltf.add(numbers, {kGltfFloat, "SCALAR"}, GltfPacking::attributes);
}

int add_flags(GltfBuilder& gltf, const std::vector<std::uint8_t>& flags) {
  return gltf.add(flags, {kGltfByte, "SCALAR"}, GltfPacking::none);
}

// glTF has no empty accessors.
void add_tables(GltfBuilder& gltf, const Snapshot& snapshot, const WrittenSurface& written, const ViewTables& tables,
                const SurfaceForm& form, json& properties) {
  properties["cellSeen"] = add_flags(gltf, snapshot.cell_seen);
  properties["referenceOffsets"] = add_whole_numbers(gltf, snapshot.references.offsets);
  if (!tables.references.empty()) properties["references"] = add_whole_numbers(gltf, tables.references);
  if (!snapshot.cell_coverage.empty() && !form.packed) {
    properties["cellCoverage"] = add_numbers(gltf, snapshot.cell_coverage);
  }
  if (!snapshot.cell_deviation.empty()) properties["cellDeviation"] = add_numbers(gltf, snapshot.cell_deviation);
  if (!tables.resident.empty()) properties["resident"] = add_flags(gltf, tables.resident);
  if (!written.near.copies.empty()) properties["vertexCopies"] = add_whole_numbers(gltf, written.near.copies);
  if (!written.zone_cells.empty()) properties["zoneCells"] = add_whole_numbers(gltf, written.zone_cells);
}

// Returns a bounding volume of 3D Tiles: the middle of a box, and half of its axes.
json volume_json(const Bounds& box) {
  const glm::dvec3 middle = 0.5 * (box.min + box.max), half = 0.5 * (box.max - box.min);
  return {{"box", {middle.x, middle.y, middle.z, half.x, 0, 0, 0, half.y, 0, 0, 0, half.z}}};
}

// Returns the matrix, column by column, from the frame of tiles, which has z upwards where glTF has y, to geocentric
// coordinates; null if the model's position on the Earth is not known.
json root_transform(const Snapshot& snapshot, const glm::dvec3& offset) {
  if (!snapshot.georeference) return nullptr;
  const std::optional<glm::dmat4> geocentric = geocentric_from_scene(*snapshot.georeference);
  if (!geocentric) return nullptr;
  const glm::dmat3 tile_from_gltf({1, 0, 0}, {0, 0, 1}, {0, -1, 0});
  const glm::dmat3 model_from_tile = glm::transpose(tile_from_gltf * gltf_from_scene(snapshot));
  const glm::dmat3 rotation = glm::dmat3(*geocentric) * model_from_tile;
  const glm::dvec4 origin = *geocentric * glm::dvec4(offset, 1);
  json numbers = json::array();
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) numbers.push_back(rotation[column][row]);
    numbers.push_back(0);
  }
  for (const double number : {origin.x, origin.y, origin.z, 1.0}) numbers.push_back(number);
  return numbers;
}

json content_json(const TileContent& content) {
  return {{"uri", content.uri}, {"extras", {{"byteLength", content.bytes}}}};
}

// Returns the number in six digits, which take few bytes as text.
double rounded(double number) {
  constexpr int kDigits = 6;
  char text[64];
  const char* const end = std::to_chars(text, text + sizeof(text), number, std::chars_format::general, kDigits).ptr;
  double result = number;
  std::from_chars(text, end, result);
  return result;
}

// Returns the greatest error of the tiles below a tile.
double error_below(const ModelTile& tile) {
  double error = 0;
  for (const ModelTile& child : tile.children) {
    error = std::max({error, child.content.geometric_error, error_below(child)});
  }
  return error;
}

// Returns where the chunks of a tile lie.
TileVolume volume_of(const ModelTile& tile) {
  if (tile.children.empty()) return tile.content.volume;
  TileVolume all;
  for (const ModelTile& child : tile.children) {
    const TileVolume one = volume_of(child);
    all.in_scene = with(all.in_scene, one.in_scene);
    all.in_tile = with(all.in_tile, one.in_tile);
  }
  return all;
}

// Returns the least x, y and z, then the largest.
json corners_json(const Bounds& box) {
  json corners = json::array();
  for (const glm::dvec3& corner : {box.min, box.max}) {
    for (int axis = 0; axis < 3; ++axis) corners.push_back(rounded(corner[axis]));
  }
  return corners;
}

// A tile below the root, with those below it.
json tile_json(const ModelTile& tile) {
  const TileVolume volume = volume_of(tile);
  json content = content_json(tile.content);
  if (tile.children.empty()) content["extras"]["box"] = corners_json(volume.in_scene);
  json result = {{"boundingVolume", volume_json(volume.in_tile)},
                 {"geometricError", std::max(tile.content.geometric_error, error_below(tile))},
                 {"content", std::move(content)}};
  for (const ModelTile& child : tile.children) result["children"].push_back(tile_json(child));
  return result;
}

}  // namespace

int add_whole_numbers(GltfBuilder& gltf, const std::vector<std::uint32_t>& numbers) {
  return gltf.add(numbers, {kGltfWhole, "SCALAR"}, GltfPacking::attributes);
}

double written_cell_size(const Surface& surface) {
  return std::min(surface.cells.size, most_cell_size(near_surface(surface).mesh));
}

ViewSlot first_view_slot(const Snapshot& snapshot, const std::vector<std::uint8_t>& shown) {
  std::vector<std::size_t> cells(snapshot.views.size(), 0);
  for (const ViewSlot slot : snapshot.references.views) ++cells[slot];
  const glm::dvec3 up = upward(cameras_of(snapshot));
  std::size_t best = cells.size();
  std::pair<bool, std::size_t> most;
  for (std::size_t slot = 0; slot < cells.size(); ++slot) {
    if (!shown[slot]) continue;
    const std::pair shows(is_level(snapshot.views[slot]->camera, up), cells[slot]);
    if (best < cells.size() && shows <= most) continue;
    best = slot;
    most = shows;
  }
  return ViewSlot(static_cast<std::uint32_t>(best));
}

json model_properties(const Snapshot& snapshot, float before_far, const ValidityOptions& validity,
                      std::uint32_t first_view) {
  const TileOptions& tiles = snapshot.tiles.options;
  json properties = {{"version", kLumigraphVersion},
                     {"validity",
                      {{"depthEdge", validity.depth_edge},
                       {"edgeRadius", validity.edge_radius_px},
                       {"fade", validity.fade_px},
                       {"edges", name_of(validity.edges)}}},
                     {"texels", std::string(name_of(tiles.texels))}};
  if (!snapshot.tiles.whole_views()) properties["tiles"] = {{"size", tiles.tile_px}, {"gutter", tiles.gutter_px}};
  if (std::isfinite(before_far)) properties["depthBeforeFar"] = before_far;
  if (const float median = median_deviation(snapshot.cell_deviation); median > 0)
    properties["medianDeviation"] = median;
  if (snapshot.georeference) properties["georeference"] = json_of(*snapshot.georeference);
  const std::vector<Camera> cameras = cameras_of(snapshot);
  if (cameras.empty()) return properties;
  properties["up"] = json_of(upward(cameras));
  properties["firstView"] = first_view;
  return properties;
}

json view_properties(const StoredView& view, const glm::dvec3& gain, float before_far) {
  const Camera& camera = view.camera;
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera.cam_from_world_rotation[column][row]);
  }
  return {{"name", unicode_name(view.name)},
          {"width", camera.width},
          {"height", camera.height},
          {"focalLength", {camera.fx, camera.fy}},
          {"principalPoint", {camera.cx, camera.cy}},
          {"rotation", std::move(rotation)},
          {"translation", json_of(camera.cam_from_world_translation)},
          {"gain", json_of(gain)},
          {"depth", median_depth(view, before_far)}};
}

json views_with_images(const Snapshot& snapshot, float before_far, const std::vector<ModelImage>& images) {
  json views = json::array();
  for (std::size_t image = 0; image < images.size(); ++image) {
    const auto& [kind, slot, name, coding, effort] = images[image];
    if (kind == ModelImageKind::poster) continue;
    if (kind == ModelImageKind::photograph) {
      views.push_back(view_properties(*snapshot.views[slot], snapshot.gains[slot], before_far));
      give_back_scratch_pages();  // the median depth reads all depths of the view
    }
    views.back()[property_of(kind)] = image;
  }
  return views;
}

// References by the views' numbers in the file instead of their slots.
ViewTables view_tables(const Snapshot& snapshot) {
  std::vector<std::uint32_t> number(snapshot.views.size(), 0);
  std::uint32_t next = 0;
  for (std::size_t slot = 0; slot < number.size(); ++slot) number[slot] = snapshot.views[slot] ? next++ : 0;
  ViewTables tables;
  tables.references.reserve(snapshot.references.views.size());
  for (const ViewSlot slot : snapshot.references.views) tables.references.push_back(number[slot]);
  if (snapshot.tiles.whole_views()) return tables;
  for (const TilePlace place : snapshot.tiles.places) tables.resident.push_back(place == TilePlace::none ? 0 : 1);
  return tables;
}

json add_surface(GltfBuilder& gltf, const Snapshot& snapshot, const WrittenSurface& written, const ViewTables& tables,
                 const SurfaceForm& form) {
  const Surface& surface = *snapshot.surface;
  const bool textured = form.texture >= 0, has_far = surface.far_faces > 0;
  json& document = gltf.document();
  if (textured) add_texture(document, form.texture);
  document["meshes"].push_back({{"primitives", {primitive_json(gltf, written.near, textured)}}});
  // No node refers to the far sphere, because other programs would draw it as part of the scene.
  if (has_far) document["meshes"].push_back({{"primitives", {primitive_json(gltf, written.far, false)}}});
  if (form.apart) gltf.begin_buffer();
  const std::span colors(snapshot.vertex_colors.get());
  const auto attributes = [&](std::size_t mesh) -> json& {
    return document["meshes"][mesh]["primitives"][0]["attributes"];
  };
  const int near_colors = add_colors(gltf, linear_colors(colors, written.near.sources, form.packed));
  attributes(0)[textured ? kTexturedColorAttribute : kColorAttribute] = near_colors;
  if (has_far) {
    const std::span far_colors = colors.last(surface.far_vertices);
    const int number = add_colors(gltf, linear_colors(far_colors, written.far.sources, form.packed));
    attributes(1)[kColorAttribute] = number;
  }
  if (form.apart) gltf.begin_buffer();
  json properties = {
      {"version", kLumigraphVersion}, {"offset", json_of(surface.offset)}, {"cellSize", written_cell_size(surface)}};
  if (has_far) properties["far"] = {{"mesh", 1}, {"cells", surface.far_cells}};
  add_tables(gltf, snapshot, written, tables, form, properties);
  return properties;
}

int add_coarse_surface(GltfBuilder& gltf, const CoarseSurface& coarse, std::optional<double> packed) {
  Surface surface;
  surface.mesh = coarse.mesh;
  surface.cells.cell_of_face.assign(coarse.mesh.faces.size(), 0);
  surface.cells.cells.resize(1);
  const WrittenMesh mesh = written_surface(surface, nullptr, nullptr, packed).near;
  json& document = gltf.document();
  const int positions = add_positions(gltf, mesh.positions);
  const int colors = add_colors(gltf, linear_colors(coarse.mesh.colors, mesh.sources, packed.has_value()));
  const int faces = add_faces(gltf, mesh.faces);
  const int material = add_unlit_material(document, false);
  document["meshes"].push_back({{"primitives",
                                 {{{"mode", 4},
                                   {"material", material},
                                   {"attributes", {{"POSITION", positions}, {kColorAttribute, colors}}},
                                   {"indices", faces}}}}});
  return static_cast<int>(document["meshes"].size()) - 1;
}

void add_scene(json& document, const glm::dmat3& file_from_scene) {
  document["nodes"].push_back({{"mesh", 0}, {"rotation", gltf_rotation(file_from_scene)}});
  document["scenes"].push_back({{"nodes", {0}}});
  document["scene"] = 0;
}

void set_lumigraph(json& document, json properties) {
  document["extensions"][kLumigraphExtension] = std::move(properties);
  document["extensionsUsed"].push_back(kLumigraphExtension);
}

void add_moved_scene(json& document, const glm::dmat3& file_from_scene, const glm::dvec3& origin) {
  document["nodes"].push_back({{"rotation", gltf_rotation(file_from_scene)}, {"children", {1}}});
  document["nodes"].push_back({{"mesh", 0}, {"translation", json_of(origin)}});
  document["scenes"].push_back({{"nodes", {0}}});
  document["scene"] = 0;
}

TileVolume tile_volume(const Mesh& mesh, const glm::dvec3& origin, const glm::dmat3& file_from_scene) {
  TileVolume volume{bounds(mesh), {}};
  if (volume.in_scene.empty()) return volume;
  volume.in_scene = {volume.in_scene.min + origin, volume.in_scene.max + origin};
  for (const glm::vec3& position : mesh.positions) {
    const glm::dvec3 p = file_from_scene * (glm::dvec3(position) + origin);
    volume.in_tile = with(volume.in_tile, glm::dvec3(p.x, -p.z, p.y));
  }
  return volume;
}

json tileset_json(const Snapshot& snapshot, const glm::dvec3& offset, const ModelTile& root, json properties) {
  const TileVolume volume = volume_of(root);
  const bool is_empty = volume.in_scene.empty();  // a model of what is far alone
  const double extent = is_empty ? 0 : glm::length(volume.in_scene.max - volume.in_scene.min);
  const bool has_content = !root.content.uri.empty();
  const double error = std::max({root.content.geometric_error, error_below(root), extent});
  json tile = {{"boundingVolume", volume_json(is_empty ? Bounds{{}, {}} : volume.in_tile)},
               {"refine", "REPLACE"},
               {"geometricError", 0}};
  if (json transform = root_transform(snapshot, offset); !transform.is_null()) tile["transform"] = std::move(transform);
  if (!root.children.empty()) {
    tile["geometricError"] = has_content ? std::max(root.content.geometric_error, error_below(root)) : error;
  }
  if (has_content) tile["content"] = content_json(root.content);
  if (root.children.size() == 1) {
    tile["children"] = {{{"boundingVolume", tile["boundingVolume"]},
                         {"geometricError", 0},
                         {"content", content_json(root.children.front().content)}}};
  } else {
    for (const ModelTile& child : root.children) tile["children"].push_back(tile_json(child));
  }
  json document = {{"asset", {{"version", "1.1"}, {"extras", {{"generator", "lumatlas"}}}}},
                   {"geometricError", error},
                   {"root", std::move(tile)}};
  set_lumigraph(document, std::move(properties));
  return document;
}

}  // namespace lumatlas
