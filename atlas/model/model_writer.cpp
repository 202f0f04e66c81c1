// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/glm.hpp>
#include <locale>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "atlas/images/srgb.h"
#include "atlas/model/content_digest.h"
#include "atlas/model/glb_file.h"
#include "atlas/model/gltf_cameras.h"
#include "atlas/model/json_nesting.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_file.h"
#include "atlas/model/model_images.h"
#include "atlas/model/model_ranges.h"
#include "atlas/model/tiny_gltf.h"
#include "atlas/vertex_split.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/temporary_entry.h"

namespace lumatlas {

namespace {

using Json = tinygltf::Value;

constexpr const char* kBufferStem = "scene";

// Appends bytes to the model's only buffer. glTF wants what accessors refer to aligned to its component.
int add_view(tinygltf::Model& model, const void* first, std::size_t bytes, int target = 0) {
  std::vector<unsigned char>& buffer = model.buffers[0].data;
  buffer.resize((buffer.size() + 3) / 4 * 4);
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = buffer.size();
  view.byteLength = bytes;
  view.target = target;
  buffer.resize(buffer.size() + bytes);
  if (bytes > 0) std::memcpy(&buffer[view.byteOffset], first, bytes);
  model.bufferViews.push_back(std::move(view));
  return static_cast<int>(model.bufferViews.size()) - 1;
}

template <typename T>
int add_accessor(tinygltf::Model& model, const std::vector<T>& values, int component, int type, int target = 0) {
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(model, values.data(), values.size() * sizeof(T), target);
  accessor.componentType = component;
  accessor.type = type;
  accessor.count = values.size();
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

int add_scalars(tinygltf::Model& model, const std::vector<std::uint32_t>& values) {
  return add_accessor(model, values, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
}

// glTF wants COLOR_0 aligned to four bytes, hence alpha, and in linear light: so 16 bit, to keep what sRGB tells apart.
std::vector<glm::u16vec4> linear_colors(const std::vector<glm::u8vec3>& srgb) {
  const auto& linear = linear_from_srgb8();
  const auto convert = [&](std::uint8_t value) {
    return static_cast<std::uint16_t>(std::lround(65535 * linear[value]));
  };
  std::vector<glm::u16vec4> colors;
  colors.reserve(srgb.size());
  for (const glm::u8vec3& c : srgb) colors.emplace_back(convert(c.r), convert(c.g), convert(c.b), 65535);
  return colors;
}

Json array_of(const glm::dvec3& v) {
  return Json(Json::Array{Json(v.x), Json(v.y), Json(v.z)});
}

// Image number `image`, clamped at its borders and filtered between its levels.
void add_texture(tinygltf::Model& model, std::size_t image) {
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  model.samplers.push_back(std::move(sampler));
  tinygltf::Texture texture;
  texture.sampler = 0;
  texture.source = static_cast<int>(image);
  model.textures.push_back(std::move(texture));
}

// The photographs' light is in the colours already, and rooms are seen from inside.
int add_unlit_material(tinygltf::Model& model, bool textured) {
  tinygltf::Material material;
  material.pbrMetallicRoughness.metallicFactor = 0;
  if (textured) material.pbrMetallicRoughness.baseColorTexture.index = 0;
  material.doubleSided = true;
  material.extensions[kUnlitExtension] = Json(Json::Object{});
  model.materials.push_back(std::move(material));
  model.extensionsUsed.emplace_back(kUnlitExtension);
  return static_cast<int>(model.materials.size()) - 1;
}

// Returns for each split vertex the value of the vertex that it copies.
template <typename T>
std::vector<T> repeated(const std::vector<T>& values, const std::vector<std::uint32_t>& source) {
  std::vector<T> split;
  split.reserve(source.size());
  for (const std::uint32_t vertex : source) split.push_back(values[vertex]);
  return split;
}

// glTF has no vertex attributes of 32-bit whole numbers.
int add_cells(tinygltf::Model& model, const std::vector<std::uint32_t>& cell_of_vertex) {
  return add_accessor(model, std::vector<float>(cell_of_vertex.begin(), cell_of_vertex.end()),
                      TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ARRAY_BUFFER);
}

int add_positions(tinygltf::Model& model, const Mesh& mesh, const std::vector<std::uint32_t>& source) {
  const int accessor = add_accessor(model, repeated(mesh.positions, source), TINYGLTF_COMPONENT_TYPE_FLOAT,
                                    TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
  const Bounds box = bounds(mesh);
  tinygltf::Accessor& positions = model.accessors[static_cast<std::size_t>(accessor)];
  for (int axis = 0; axis < 3; ++axis) {
    positions.minValues.push_back(box.min[axis]);
    positions.maxValues.push_back(box.max[axis]);
  }
  return accessor;
}

// Places in a texture of at most 16384 texels a side are exact to an eighth of a texel.
std::uint32_t packed_place(const glm::vec2& share) {
  const auto part = [](float x) { return static_cast<std::uint32_t>(std::lround(65535 * x)); };
  return part(share.x) | part(share.y) << 16;
}

// Adds vertices packed by packed_place().
int add_places(tinygltf::Model& model, const std::vector<std::uint32_t>& packed) {
  std::vector<glm::u16vec2> places;
  places.reserve(packed.size());
  for (const std::uint32_t place : packed) places.emplace_back(place & 0xffff, place >> 16);
  const int accessor = add_accessor(model, places, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC2,
                                    TINYGLTF_TARGET_ARRAY_BUFFER);
  model.accessors[static_cast<std::size_t>(accessor)].normalized = true;
  return accessor;
}

int add_colors(tinygltf::Model& model, const std::vector<glm::u8vec3>& srgb) {
  const int accessor = add_accessor(model, linear_colors(srgb), TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                                    TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER);
  model.accessors[static_cast<std::size_t>(accessor)].normalized = true;
  return accessor;
}

// The mesh as it is written.
struct WrittenMesh {
  VertexSplit cells;                  // the mesh's vertices, a copy for each cell
  std::vector<glm::uvec3> faces;      // vertices of `cells`, then copies of them
  std::vector<std::uint32_t> copies;  // which of `cells` each copy is
  std::vector<std::uint32_t> places;  // one per vertex, in the base texture; empty without one

  // Returns the values of `cells` with copies for the texture's vertices.
  template <typename T>
  [[nodiscard]] std::vector<T> with_copies(std::vector<T> values) const {
    for (const std::uint32_t vertex : copies) values.push_back(values[vertex]);
    return values;
  }
};

WrittenMesh written_mesh(const Surface& surface, const BaseTexture* texture) {
  WrittenMesh written;
  const Mesh& mesh = surface.mesh;
  written.cells = split_vertices(mesh.faces, mesh.positions.size(),
                                 [&](std::size_t face, int) { return surface.cells.cell_of_face[face]; });
  written.faces = std::move(written.cells.faces);
  if (!texture) return written;
  const std::size_t vertices = written.cells.source.size();
  VertexSplit split = split_vertices(written.faces, vertices, [&](std::size_t face, int corner) {
    return packed_place(texture->faces[face][static_cast<std::size_t>(corner)]);
  });
  written.faces = std::move(split.faces);
  written.copies.assign(split.source.begin() + static_cast<std::ptrdiff_t>(vertices), split.source.end());
  written.places = std::move(split.values);
  return written;
}

// `colors`: one for each vertex of `given`, which is the mesh that is written.
tinygltf::Primitive add_triangles(tinygltf::Model& model, const Mesh& given, const std::vector<glm::u8vec3>& colors,
                                  const WrittenMesh& mesh) {
  const bool textured = !mesh.places.empty();
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = add_unlit_material(model, textured);
  primitive.attributes["POSITION"] = add_positions(model, given, mesh.with_copies(mesh.cells.source));
  primitive.attributes[textured ? kTexturedColorAttribute : kColorAttribute] =
      add_colors(model, mesh.with_copies(repeated(colors, mesh.cells.source)));
  primitive.attributes[kCellAttribute] = add_cells(model, mesh.with_copies(mesh.cells.values));
  if (textured) primitive.attributes[kPlaceAttribute] = add_places(model, mesh.places);
  primitive.indices = add_accessor(model, mesh.faces, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                                   TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  model.accessors[static_cast<std::size_t>(primitive.indices)].count = 3 * mesh.faces.size();
  return primitive;
}

void add_mesh(tinygltf::Model& model, const Mesh& given, const std::vector<glm::u8vec3>& colors,
              const WrittenMesh& mesh) {
  tinygltf::Mesh gltf_mesh;
  gltf_mesh.primitives.push_back(add_triangles(model, given, colors, mesh));
  model.meshes.push_back(std::move(gltf_mesh));
}

// Adds the far sphere as a mesh that no node refers to, because other programs would draw it as part of the scene.
void add_far_mesh(tinygltf::Model& model, const Snapshot& snapshot) {
  const Surface& surface = *snapshot.surface;
  if (surface.far_faces == 0) return;
  const FarSphere far = far_sphere_of(surface);
  const auto near_cells = static_cast<std::uint32_t>(surface.near_cells());
  WrittenMesh written;
  written.cells = split_vertices(far.mesh.faces, far.mesh.positions.size(),
                                 [&](std::size_t face, int) { return near_cells + far.cells.cell_of_face[face]; });
  written.faces = std::move(written.cells.faces);
  const FallbackColors::Colors& colors = snapshot.vertex_colors.get();
  const auto first = colors.end() - static_cast<std::ptrdiff_t>(far.mesh.positions.size());
  add_mesh(model, far.mesh, {first, colors.end()}, written);
}

// Adds the scene, whose only node refers to the first mesh.
void add_scene(tinygltf::Model& model) {
  tinygltf::Node node;
  node.mesh = 0;
  model.nodes.push_back(std::move(node));
  tinygltf::Scene scene;
  scene.nodes.push_back(0);
  model.scenes.push_back(std::move(scene));
  model.defaultScene = 0;
}

const char* property_of(ModelImageKind kind) {
  if (kind == ModelImageKind::lens_mask) return "lensMask";
  return kind == ModelImageKind::trust_mask ? "trustMask" : "image";
}

Json view_json(const StoredView& view, const glm::dvec3& gain) {
  const Camera& camera = view.camera;
  Json::Array rotation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.emplace_back(camera.cam_from_world_rotation[column][row]);
  }
  Json::Object object;
  object["name"] = Json(unicode_name(view.name));
  object["width"] = Json(static_cast<int>(camera.width));
  object["height"] = Json(static_cast<int>(camera.height));
  object["focalLength"] = Json(Json::Array{Json(camera.fx), Json(camera.fy)});
  object["principalPoint"] = Json(Json::Array{Json(camera.cx), Json(camera.cy)});
  object["rotation"] = Json(std::move(rotation));
  object["translation"] = array_of(camera.cam_from_world_translation);
  object["gain"] = array_of(gain);
  return Json(std::move(object));
}

// The stored views in their order, and which of the file's images are theirs.
Json views_json(const Snapshot& snapshot, const std::vector<ModelImage>& images) {
  Json::Array views;
  for (std::size_t image = 0; image < images.size(); ++image) {
    const std::uint32_t slot = images[image].slot;
    if (images[image].kind == ModelImageKind::photograph) {
      views.push_back(view_json(*snapshot.views[slot], snapshot.gains[slot]));
    }
    views.back().Get<Json::Object>()[property_of(images[image].kind)] = Json(static_cast<int>(image));
  }
  return Json(std::move(views));
}

// References by the views' numbers in the file instead of their slots.
std::vector<std::uint32_t> renumbered(const Snapshot& snapshot) {
  std::vector<std::uint32_t> number(snapshot.views.size(), 0);
  std::uint32_t next = 0;
  for (std::size_t slot = 0; slot < number.size(); ++slot) number[slot] = snapshot.views[slot] ? next++ : 0;
  std::vector<std::uint32_t> references;
  references.reserve(snapshot.references.views.size());
  for (const std::uint32_t slot : snapshot.references.views) references.push_back(number[slot]);
  return references;
}

// How the views are cut, and which of their tiles are there: 1 or 0 for each, views in their order in the file.
Json tiles_json(tinygltf::Model& model, const Snapshot& snapshot) {
  const TileTable& tiles = snapshot.tiles;
  std::vector<std::uint8_t> resident;
  for (const std::uint32_t slot : tiles.slots) resident.push_back(slot == kNotResident ? 0 : 1);
  Json::Object object{{"size", Json(static_cast<int>(tiles.options.tile_px))},
                      {"gutter", Json(static_cast<int>(tiles.options.gutter_px))}};
  if (!resident.empty()) {
    object["resident"] =
        Json(add_accessor(model, resident, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR));
  }
  return Json(std::move(object));
}

void add_lumigraph(tinygltf::Model& model, const Snapshot& snapshot, const WrittenMesh& mesh,
                   const std::vector<ModelImage>& images, const ValidityOptions& validity) {
  const Surface& surface = *snapshot.surface;
  Json::Object extension;
  extension["version"] = Json(mesh.places.empty() ? kLumigraphVersion : kTexturedLumigraphVersion);
  extension["offset"] = array_of(surface.offset);
  extension["cellSize"] = Json(std::min(surface.cells.size, most_cell_size(near_surface(surface).mesh)));
  if (surface.far_faces > 0) {
    extension["far"] = Json(Json::Object{{"mesh", Json(1)}, {"cells", Json(static_cast<int>(surface.far_cells))}});
  }
  if (!mesh.copies.empty()) extension["vertexCopies"] = Json(add_scalars(model, mesh.copies));
  extension["cellSeen"] =
      Json(add_accessor(model, snapshot.cell_seen, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR));
  extension["referenceOffsets"] = Json(add_scalars(model, snapshot.references.offsets));
  const std::vector<std::uint32_t> references = renumbered(snapshot);
  // glTF has neither empty accessors nor empty arrays.
  if (!references.empty()) extension["references"] = Json(add_scalars(model, references));
  if (!snapshot.cell_coverage.empty()) {
    extension["cellCoverage"] =
        Json(add_accessor(model, snapshot.cell_coverage, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR));
  }
  if (!snapshot.cell_deviation.empty()) {
    extension["cellDeviation"] =
        Json(add_accessor(model, snapshot.cell_deviation, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR));
  }
  extension["validity"] = Json(Json::Object{{"depthEdge", Json(validity.depth_edge)},
                                            {"edgeRadius", Json(static_cast<int>(validity.edge_radius_px))},
                                            {"fade", Json(static_cast<int>(validity.fade_px))},
                                            {"edges", Json(name_of(validity.edges))}});
  extension["texels"] = Json(std::string(name_of(snapshot.tiles.options.texels)));
  if (!snapshot.tiles.whole_views()) extension["tiles"] = tiles_json(model, snapshot);
  if (!images.empty()) extension["views"] = views_json(snapshot, images);
  model.extensions[kLumigraphExtension] = Json(std::move(extension));
  model.extensionsUsed.emplace_back(kLumigraphExtension);
}

// The name of a file with these bytes. Files of one name have the same bytes, so that a reader which is still at an
// earlier model never meets a photograph of a later one.
std::string name_by_content(const ModelFileName& name, std::span<const std::uint8_t> bytes) {
  return name.stem + "-" + content_digits(std::as_bytes(bytes)) + name.ending;
}

// Returns whether a file's name is one that name_by_content() makes.
bool is_name_by_content(const std::filesystem::path& file) {
  static const std::regex by_content(".*-[0-9a-f]{16}\\.(png|jpg|bin)");
  return std::regex_match(file.filename().string(), by_content);
}

// The files of a model's folder. All are written into a temporary folder in it before the first takes its place. None
// of them replaces a file of other content but scene.gltf, which comes last: the folder holds the earlier model until
// then and the new one from then on, whenever the process or the machine stops. One folder instead of one pending file
// each: a pending file keeps a descriptor open, and models have more images than a process may have open files.
class PendingFiles {
 public:
  // Throws InputError unless `folder` exists and can be written to.
  PendingFiles(const std::filesystem::path& folder, std::size_t count) : folder_(folder), names_(count) {
    try {
      temporary_ = std::make_unique<TemporaryEntry>(TemporaryEntry::Kind::folder, folder_,
                                                    [] { return random_temporary_name(); });
    } catch (const std::system_error& error) {
      throw InputError(folder.string() + ": cannot be written to: " + error.code().message());
    }
  }

  // Writes a file under a name of its content, which it returns, relative to the folder. Safe from several threads for
  // different numbers.
  std::string write(std::size_t number, const ModelFileName& name, std::span<const std::uint8_t> bytes) {
    write_as(number, name_by_content(name, bytes), bytes);
    return names_[number];
  }

  // Writes scene.gltf, whose number is the last.
  void write_gltf(std::span<const std::uint8_t> bytes) { write_as(names_.size() - 1, kModelFileName, bytes); }

  // Puts the files into their places in the order of their numbers, once the disk has them all. Throws InputError; the
  // folder is then as it was.
  void commit() {
    require_on_disk(sync_file_system(folder_));
    const auto paused = removal_paused();
    std::vector<std::filesystem::path> added;
    try {
      for (std::size_t number = 0; number + 1 < names_.size(); ++number) {
        std::error_code ignored;
        const std::filesystem::path file = folder_ / names_[number];
        const bool is_new =
            std::filesystem::symlink_status(file, ignored).type() == std::filesystem::file_type::not_found;
        put_in_place(number);
        if (is_new) added.push_back(file);
      }
      require_on_disk(sync_to_disk(folder_ / kImageFolder) && sync_to_disk(folder_));
      put_in_place(names_.size() - 1);
    } catch (...) {
      std::error_code ignored;
      for (const std::filesystem::path& file : added) std::filesystem::remove(file, ignored);
      throw;
    }
  }

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  void write_as(std::size_t number, const std::string& name, std::span<const std::uint8_t> bytes) {
    std::ofstream stream(pending(number), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream || std::filesystem::is_directory(folder_ / name)) {
      throw InputError((folder_ / name).string() +
                       ": cannot be written: check that the disk has room and the folder is writable");
    }
    names_[number] = name;
  }

  void put_in_place(std::size_t number) const {
    std::error_code error;
    std::filesystem::rename(pending(number), folder_ / names_[number], error);
    if (error) throw InputError((folder_ / names_[number]).string() + ": cannot be written: " + error.message());
  }

  void require_on_disk(bool is_on_disk) const {
    if (!is_on_disk) throw InputError(folder_.string() + ": cannot be written: check that the disk has room");
  }

  [[nodiscard]] std::filesystem::path pending(std::size_t number) const {
    return temporary_->path() / std::to_string(number);
  }

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::unique_ptr<TemporaryEntry> temporary_;
};

// The images of a model. They are removed if the model is not completed.
class ImageFolder {
 public:
  explicit ImageFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    made_ = std::filesystem::create_directories(folder_, error);
    if (error) throw InputError(folder_.string() + ": cannot be made: " + error.message());
  }
  ~ImageFolder() {
    std::error_code ignored;
    if (made_ && !kept_) std::filesystem::remove(folder_, ignored);  // only if it is empty
  }
  ImageFolder(const ImageFolder&) = delete;
  ImageFolder& operator=(const ImageFolder&) = delete;
  void keep() { kept_ = true; }

 private:
  std::filesystem::path folder_;
  bool made_ = false;
  bool kept_ = false;
};

// The files that an object of a glTF file lists, "images" or "buffers", as far as it can be read.
std::vector<std::string> uris_in(const nlohmann::json& document, const char* list) {
  std::vector<std::string> uris;
  if (!document.is_object() || !document.contains(list) || !document[list].is_array()) return uris;
  for (const nlohmann::json& entry : document[list]) {
    const nlohmann::json uri = entry.is_object() ? entry.value("uri", nlohmann::json()) : nlohmann::json();
    if (uri.is_string()) uris.push_back(uri.get<std::string>());
  }
  return uris;
}

// The files of the model that was written into the folder before: those in places where models have theirs.
std::vector<std::string> files_of_earlier(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(folder / kModelFileName, ignored)) return names;
  std::ifstream file(folder / kModelFileName);
  const nlohmann::json document = nlohmann::json::parse(file, nullptr, false);
  for (const std::string& uri : uris_in(document, "images")) {
    const std::filesystem::path name = uri;
    if (name.parent_path() == kImageFolder && name.has_filename()) names.push_back(name.string());
  }
  for (const std::string& uri : uris_in(document, "buffers")) {
    if (uri == std::string(kBufferStem) + ".bin")
      names.push_back(uri);  // the name in models that were not named by content
  }
  return names;
}

// Files with names by content, which a save leaves behind that is cut off before its end.
std::vector<std::string> files_named_by_content(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const std::filesystem::path& part : {std::filesystem::path(), std::filesystem::path(kImageFolder)}) {
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder / part, error), end; !error && entry != end;
         entry.increment(error)) {
      const std::filesystem::path name = part / entry->path().filename();
      const bool is_buffer_or_image = !part.empty() || name.string().starts_with(kBufferStem);
      if (is_buffer_or_image && is_name_by_content(name)) names.push_back(name.string());
    }
  }
  return names;
}

// Removes those files of earlier saves that are not among the model's files now.
void remove_unused(const std::filesystem::path& folder, std::vector<std::string> of_earlier_saves,
                   const std::unordered_set<std::string>& names) {
  std::erase_if(of_earlier_saves, [&](const std::string& name) { return names.contains(name); });
  for (const std::string& name : of_earlier_saves) {
    std::error_code ignored;
    if (std::filesystem::symlink_status(folder / name, ignored).type() == std::filesystem::file_type::regular) {
      std::filesystem::remove(folder / name, ignored);
    }
  }
}

// In the model's only buffer.
void add_image(tinygltf::Model& model, const std::vector<std::uint8_t>& file, const ImageCoding& coding) {
  model.images.emplace_back();
  model.images.back().mimeType = mime_type(coding.format);
  model.images.back().bufferView = add_view(model, file.data(), file.size());
  require_fits_glb(model.buffers[0].data.size());
}

// Those of the views, then that of the texture.
void add_images(tinygltf::Model& model, const Snapshot& snapshot, const std::vector<ModelImage>& images,
                const BaseTexture* texture) {
  std::vector<std::vector<std::uint8_t>> files(images.size());
  tbb::parallel_for(std::size_t{0}, images.size(),
                    [&](std::size_t index) { files[index] = encoded(images[index], snapshot); });
  for (std::size_t index = 0; index < images.size(); ++index) {
    add_image(model, files[index], images[index].coding);
    std::vector<std::uint8_t>().swap(files[index]);
  }
  if (texture) add_image(model, encode_image(texture->image, texture->coding), texture->coding);
}

// Everything but the images and the notes.
tinygltf::Model model_of(const Snapshot& snapshot, const std::vector<ModelImage>& images,
                         const ValidityOptions& validity, const BaseTexture* texture) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "lumatlas";
  model.buffers.emplace_back();
  const Surface near = near_surface(*snapshot.surface);
  const WrittenMesh mesh = written_mesh(near, texture);
  add_mesh(model, near.mesh, snapshot.vertex_colors.get(), mesh);
  add_far_mesh(model, snapshot);
  add_scene(model);
  if (texture) add_texture(model, images.size());
  add_lumigraph(model, snapshot, mesh, images, validity);
  return model;
}

// tinygltf's JSON of a model whose buffer was taken out: it would put its bytes into the text.
nlohmann::json json_of(tinygltf::Model& model, const Snapshot& snapshot, nlohmann::json buffer) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  tinygltf::TinyGLTF writer;
  (void)writer.WriteGltfSceneToStream(&model, text, false, false);
  nlohmann::json document = nlohmann::json::parse(text.str());
  document["buffers"][0] = std::move(buffer);
  add_cameras(document, snapshot, gltf_from_scene(snapshot));
  return document;
}

// tinygltf would leave out what is null in the notes.
nlohmann::json parsed_notes(const std::string& notes) {
  if (nesting(notes) > kMaxNesting) {
    throw std::invalid_argument("model: notes nest their values more than " + std::to_string(kMaxNesting) + " deep");
  }
  nlohmann::json parsed = nlohmann::json::parse(notes, nullptr, false);
  if (!parsed.is_object()) throw std::invalid_argument("model: notes are not the text of a JSON object");
  return parsed;
}

// Refuses what read_model() would refuse, of a snapshot that passes check().
void require_readable(const Snapshot& snapshot) {
  const glm::dvec3& offset = snapshot.surface->offset;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(offset[axis]) <= kMostOffset) continue;
    throw InputError("the surface's offset[" + std::to_string(axis) + "] is " + number_text(offset[axis]) +
                     ", a model file holds at most " + number_text(kMostOffset) + ": move the scene nearer to 0");
  }
  for (const auto& view : snapshot.views) {
    try {
      if (view) check_model_ranges(view->camera);
    } catch (const std::invalid_argument& error) {
      throw InputError("view " + unicode_name(view->name) + " does not fit into a model file: " + error.what());
    }
  }
}

// Leaves out views without a resident tile, which show nothing.
Snapshot checked(const Snapshot& snapshot) {
  if (snapshot.cell_seen.size() > kMostCells) {
    throw InputError("the model has " + std::to_string(snapshot.cell_seen.size()) + " cells, a model file holds " +
                     std::to_string(kMostCells) + ": give a larger --cell-size");
  }
  check(snapshot);
  Snapshot shown = snapshot;  // the photographs are shared
  leave_out_views_without_tiles(shown);
  require_readable(shown);
  return shown;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

void write_model(const std::filesystem::path& folder, const Snapshot& given, const ValidityOptions& validity,
                 const ImageCoding& photographs, const BaseTexture* texture) {
  check(validity);
  check(photographs);
  const Snapshot snapshot = checked(given);
  if (texture) check(*texture, snapshot.surface->near_faces());
  const std::vector<ModelImage> images = images_of(snapshot, photographs);
  std::vector<ModelFileName> names;
  names.reserve(images.size() + 1);
  for (const ModelImage& image : images) names.push_back(image.name);
  if (texture) names.push_back(texture_name(texture->coding));
  tinygltf::Model model = model_of(snapshot, images, validity, texture);
  const std::vector<unsigned char> buffer = std::exchange(model.buffers[0].data, {});
  const std::vector<std::string> earlier = files_of_earlier(folder);
  ImageFolder image_folder(folder / kImageFolder);
  PendingFiles files(folder, names.size() + 2);
  model.images.resize(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t index) {
    const bool of_view = index < images.size();
    model.images[index].uri =
        files.write(index, names[index],
                    of_view ? encoded(images[index], snapshot) : encode_image(texture->image, texture->coding));
  });
  const std::string buffer_name = files.write(names.size(), {kBufferStem, ".bin"}, buffer);
  files.write_gltf(
      bytes_of(json_of(model, snapshot, {{"byteLength", buffer.size()}, {"uri", buffer_name}}).dump(2) + "\n"));
  files.commit();
  image_folder.keep();
  // Until the disk has the new scene.gltf, a crash may bring the earlier one back, which needs its files.
  if (!sync_to_disk(folder)) return;
  const std::unordered_set<std::string> now(files.names().begin(), files.names().end());
  remove_unused(folder, earlier, now);
  remove_unused(folder, files_named_by_content(folder), now);
}

void write_glb(std::ostream& file, const Snapshot& given, const ValidityOptions& validity,
               const ImageCoding& photographs, const std::string& notes, const BaseTexture* texture) {
  check(validity);
  check(photographs);
  const Snapshot snapshot = checked(given);
  if (texture) check(*texture, snapshot.surface->near_faces());
  const nlohmann::json extras = notes.empty() ? nlohmann::json() : parsed_notes(notes);
  const std::vector<ModelImage> images = images_of(snapshot, photographs);
  tinygltf::Model model = model_of(snapshot, images, validity, texture);
  add_images(model, snapshot, images, texture);
  const std::vector<unsigned char> buffer = std::exchange(model.buffers[0].data, {});
  nlohmann::json document = json_of(model, snapshot, {{"byteLength", buffer.size()}});
  if (!notes.empty()) document["asset"]["extras"] = extras;
  write_glb_frame(file, document.dump(), buffer);
}

}  // namespace lumatlas
