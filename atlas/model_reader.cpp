// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <string>

#include "atlas/model_extension.h"
#include "atlas/model_file.h"
#include "atlas/srgb.h"
#include "atlas/tiny_gltf.h"
#include "mesh/errors.h"

namespace lumatlas {

namespace {

using Json = tinygltf::Value;

constexpr double kMaxViews = 1 << 20;

// Reads the parts of one model file; every refusal names the file and the field.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file) { parse(); }

  [[nodiscard]] Snapshot snapshot() const;
  [[nodiscard]] ValidityOptions validity() const;

 private:
  struct ViewEntry {
    std::string name;
    Camera camera;
    double gain;
    std::filesystem::path image, lens_mask;
  };

  [[noreturn]] void refuse(const std::string& why) const { throw InputError(file_.string() + ": " + why); }
  void parse();
  [[nodiscard]] const Json& field(const Json& object, const std::string& where, const char* name) const;
  [[nodiscard]] double number(const Json& object, const std::string& where, const char* name, double least,
                              double most) const;
  [[nodiscard]] std::vector<double> numbers(const Json& object, const std::string& where, const char* name,
                                            std::size_t count) const;
  template <typename T>
  [[nodiscard]] std::vector<T> values(int accessor, const std::string& what, int component, int type,
                                      std::size_t scalars_per_value) const;
  [[nodiscard]] std::vector<std::uint32_t> scalars(const char* name) const;
  [[nodiscard]] Mesh mesh() const;
  [[nodiscard]] std::vector<glm::u8vec3> vertex_colors(std::size_t count) const;
  [[nodiscard]] const tinygltf::Primitive& primitive() const;
  [[nodiscard]] int attribute(const char* name) const;
  [[nodiscard]] ReferenceTable references(std::size_t cells, std::size_t views) const;
  [[nodiscard]] std::filesystem::path image_path(const Json& view, const std::string& where, const char* name) const;
  [[nodiscard]] ViewEntry view_entry(const Json& view, std::size_t index) const;
  [[nodiscard]] std::vector<ViewEntry> view_entries() const;
  [[nodiscard]] StoredView load(const ViewEntry& entry, const Visibility& visibility,
                                const ValidityOptions& validity) const;

  std::filesystem::path file_;
  tinygltf::Model model_;
  Json lumigraph_;
};

// One sentence of what tinygltf may report on several lines.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

void Reader::parse() {
  if (!std::filesystem::is_regular_file(file_)) {
    refuse("no such file: give a folder that `lumatlas build` wrote, or the scene.gltf in it");
  }
  tinygltf::TinyGLTF reader;
  std::string error;
  std::string warning;
  bool parsed = false;
  try {
    parsed = reader.LoadASCIIFromFile(&model_, &error, &warning, file_.string());
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (!parsed) refuse("is no glTF 2.0 file that can be read: " + one_line(error));
  const auto extension = model_.extensions.find(kLumigraphExtension);
  if (extension == model_.extensions.end() || !extension->second.IsObject()) {
    refuse(std::string("has no extension ") + kLumigraphExtension + ": it is a mesh without photographs");
  }
  lumigraph_ = extension->second;
  const double version = number(lumigraph_, kLumigraphExtension, "version", 0, 1e9);
  if (version != kLumigraphVersion) {
    refuse("has version " + std::to_string(static_cast<int>(version)) + " of " + kLumigraphExtension +
           ", this program reads version " + std::to_string(kLumigraphVersion));
  }
}

const Json& Reader::field(const Json& object, const std::string& where, const char* name) const {
  if (!object.IsObject() || !object.Has(name)) refuse(where + " has no \"" + name + "\"");
  return object.Get(name);
}

double Reader::number(const Json& object, const std::string& where, const char* name, double least, double most) const {
  const Json& value = field(object, where, name);
  if (!value.IsNumber()) refuse(where + ": \"" + name + "\" is not a number");
  const double x = value.GetNumberAsDouble();
  if (!(x >= least && x <= most)) {
    refuse(where + ": \"" + name + "\" is " + std::to_string(x) + ", must be in [" + std::to_string(least) + ", " +
           std::to_string(most) + "]");
  }
  return x;
}

std::vector<double> Reader::numbers(const Json& object, const std::string& where, const char* name,
                                    std::size_t count) const {
  const Json& array = field(object, where, name);
  if (!array.IsArray() || array.ArrayLen() != count) {
    refuse(where + ": \"" + name + "\" is not an array of " + std::to_string(count) + " numbers");
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    if (!array.Get(static_cast<int>(i)).IsNumber() || !std::isfinite(array.Get(static_cast<int>(i)).GetNumberAsDouble())) {
      refuse(where + ": \"" + name + "\"[" + std::to_string(i) + "] is not a finite number");
    }
    numbers.push_back(array.Get(static_cast<int>(i)).GetNumberAsDouble());
  }
  return numbers;
}

template <typename T>
std::vector<T> Reader::values(int accessor_index, const std::string& what, int component, int type,
                              std::size_t scalars_per_value) const {
  if (accessor_index < 0 || static_cast<std::size_t>(accessor_index) >= model_.accessors.size()) {
    refuse(what + ": accessor " + std::to_string(accessor_index) + " does not exist");
  }
  const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(accessor_index)];
  if (accessor.componentType != component || accessor.type != type || accessor.count % scalars_per_value != 0 ||
      accessor.sparse.isSparse) {
    refuse(what + ": accessor " + std::to_string(accessor_index) + " has another type than this program writes");
  }
  if (accessor.bufferView < 0 || static_cast<std::size_t>(accessor.bufferView) >= model_.bufferViews.size()) {
    refuse(what + ": buffer view " + std::to_string(accessor.bufferView) + " does not exist");
  }
  const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
  const std::size_t count = accessor.count / scalars_per_value;
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model_.buffers.size() || view.byteStride != 0 ||
      accessor.byteOffset != 0 || count > view.byteLength / sizeof(T)) {
    refuse(what + ": accessor " + std::to_string(accessor_index) + " reaches beyond its buffer view");
  }
  const std::vector<unsigned char>& bytes = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > bytes.size() || view.byteLength > bytes.size() - view.byteOffset) {
    refuse(what + ": buffer view " + std::to_string(accessor.bufferView) + " reaches beyond its buffer of " +
           std::to_string(bytes.size()) + " bytes");
  }
  std::vector<T> values(count);
  if (count > 0) std::memcpy(values.data(), &bytes[view.byteOffset], count * sizeof(T));
  return values;
}

std::vector<std::uint32_t> Reader::scalars(const char* name) const {
  const auto accessor = static_cast<int>(number(lumigraph_, kLumigraphExtension, name, 0, 1e9));
  return values<std::uint32_t>(accessor, name, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 1);
}

const tinygltf::Primitive& Reader::primitive() const {
  if (model_.meshes.empty() || model_.meshes[0].primitives.empty()) refuse("holds no mesh");
  return model_.meshes[0].primitives[0];
}

int Reader::attribute(const char* name) const {
  const auto& attributes = primitive().attributes;
  const auto found = attributes.find(name);
  if (found == attributes.end()) refuse(std::string("its mesh has no ") + name);
  return found->second;
}

Mesh Reader::mesh() const {
  Mesh mesh;
  mesh.positions = values<glm::vec3>(attribute("POSITION"), "POSITION", TINYGLTF_COMPONENT_TYPE_FLOAT,
                                     TINYGLTF_TYPE_VEC3, 1);
  mesh.faces = values<glm::uvec3>(primitive().indices, "its mesh's indices", TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                  TINYGLTF_TYPE_SCALAR, 3);
  if (mesh.faces.empty()) refuse("its mesh has no faces");
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.faces[face][corner] >= mesh.positions.size()) {
        refuse("face " + std::to_string(face) + " refers to vertex " + std::to_string(mesh.faces[face][corner]) +
               " of " + std::to_string(mesh.positions.size()));
      }
    }
  }
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const glm::vec3& p = mesh.positions[vertex];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      refuse("vertex " + std::to_string(vertex) + " has a coordinate that is not finite");
    }
  }
  return mesh;
}

std::vector<glm::u8vec3> Reader::vertex_colors(std::size_t count) const {
  const auto linear = values<glm::u16vec4>(attribute("COLOR_0"), "COLOR_0", TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                                           TINYGLTF_TYPE_VEC4, 1);
  if (linear.size() != count) {
    refuse("COLOR_0 has " + std::to_string(linear.size()) + " colours for " + std::to_string(count) + " vertices");
  }
  std::vector<glm::u8vec3> colors;
  colors.reserve(count);
  for (const glm::u16vec4& c : linear) {
    colors.emplace_back(srgb8_from_linear(c.r / 65535.0), srgb8_from_linear(c.g / 65535.0),
                        srgb8_from_linear(c.b / 65535.0));
  }
  return colors;
}

ReferenceTable Reader::references(std::size_t cells, std::size_t views) const {
  ReferenceTable table;
  table.offsets = scalars("referenceOffsets");
  if (lumigraph_.Has("references")) table.views = scalars("references");
  if (table.offsets.size() != cells + 1) {
    refuse("referenceOffsets has " + std::to_string(table.offsets.size()) + " entries, must have " +
           std::to_string(cells + 1) + " for " + std::to_string(cells) + " cells");
  }
  if (table.offsets.front() != 0 || table.offsets.back() != table.views.size() ||
      !std::is_sorted(table.offsets.begin(), table.offsets.end())) {
    refuse("referenceOffsets do not rise from 0 to the number of references, " + std::to_string(table.views.size()));
  }
  for (std::size_t i = 0; i < table.views.size(); ++i) {
    if (table.views[i] >= views) {
      refuse("reference " + std::to_string(i) + " is to view " + std::to_string(table.views[i]) + " of " +
             std::to_string(views));
    }
  }
  return table;
}

std::filesystem::path Reader::image_path(const Json& view, const std::string& where, const char* name) const {
  const auto index = static_cast<std::size_t>(number(view, where, name, 0, 1e9));
  if (index >= model_.images.size()) refuse(where + ": image " + std::to_string(index) + " does not exist");
  const std::filesystem::path relative = model_.images[index].uri;
  const bool climbs = std::find(relative.begin(), relative.end(), "..") != relative.end();
  if (relative.empty() || relative.is_absolute() || climbs) {
    refuse("image " + std::to_string(index) + " has the path \"" + relative.string() +
           "\", must lie in the model's own folder");
  }
  return file_.parent_path() / relative;
}

Reader::ViewEntry Reader::view_entry(const Json& view, std::size_t index) const {
  constexpr double kMaxSide = 65536;
  const std::string where = "view " + std::to_string(index);
  const Json& name = field(view, where, "name");
  if (!name.IsString()) refuse(where + ": \"name\" is not a string");
  ViewEntry entry;
  entry.name = name.Get<std::string>();
  entry.image = image_path(view, where, "image");
  if (view.Has("lensMask")) entry.lens_mask = image_path(view, where, "lensMask");
  Camera& camera = entry.camera;
  camera.width = static_cast<std::uint32_t>(number(view, where, "width", 1, kMaxSide));
  camera.height = static_cast<std::uint32_t>(number(view, where, "height", 1, kMaxSide));
  const std::vector<double> focal = numbers(view, where, "focalLength", 2);
  const std::vector<double> principal = numbers(view, where, "principalPoint", 2);
  const std::vector<double> rotation = numbers(view, where, "rotation", 9);
  const std::vector<double> translation = numbers(view, where, "translation", 3);
  camera.fx = focal[0];
  camera.fy = focal[1];
  camera.cx = principal[0];
  camera.cy = principal[1];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      camera.cam_from_world_rotation[column][row] = rotation[static_cast<std::size_t>(3 * row + column)];
    }
    camera.cam_from_world_translation[row] = translation[static_cast<std::size_t>(row)];
  }
  entry.gain = number(view, where, "gain", 1e-6, 1e6);
  try {
    check(camera);
  } catch (const std::invalid_argument& error) {
    refuse(where + ": " + error.what());
  }
  return entry;
}

std::vector<Reader::ViewEntry> Reader::view_entries() const {
  const Json& views = field(lumigraph_, kLumigraphExtension, "views");
  if (!views.IsArray() || static_cast<double>(views.ArrayLen()) > kMaxViews) refuse("\"views\" is not an array of views");
  std::vector<ViewEntry> entries;
  for (std::size_t index = 0; index < views.ArrayLen(); ++index) {
    entries.push_back(view_entry(views.Get(static_cast<int>(index)), index));
  }
  return entries;
}

StoredView Reader::load(const ViewEntry& entry, const Visibility& visibility, const ValidityOptions& validity) const {
  Photograph photograph = read_photograph(entry.image);
  const auto require_size = [&](const Photograph& image, const std::filesystem::path& path) {
    if (image.width == entry.camera.width && image.height == entry.camera.height) return;
    throw InputError(path.string() + ": is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                     ", its view in " + file_.string() + " says " + std::to_string(entry.camera.width) + "x" +
                     std::to_string(entry.camera.height));
  };
  require_size(photograph, entry.image);
  if (!entry.lens_mask.empty()) {
    const Photograph mask = read_photograph(entry.lens_mask);
    require_size(mask, entry.lens_mask);
    photograph.valid.resize(mask.rgb.size() / 3);
    for (std::size_t pixel = 0; pixel < photograph.valid.size(); ++pixel) photograph.valid[pixel] = mask.rgb[3 * pixel];
  }
  StoredView view = make_stored_view(entry.name, entry.camera, std::move(photograph), visibility.trace(entry.camera),
                                     validity);
  view.gain = entry.gain;
  return view;
}

ValidityOptions Reader::validity() const {
  const Json& object = field(lumigraph_, kLumigraphExtension, "validity");
  ValidityOptions options;
  options.depth_edge = number(object, "validity", "depthEdge", 1e-9, 1e9);
  options.edge_radius_px = static_cast<std::uint32_t>(number(object, "validity", "edgeRadius", 0, 16));
  options.fade_px = static_cast<std::uint32_t>(number(object, "validity", "fade", 0, 255));
  return options;
}

Snapshot Reader::snapshot() const {
  Snapshot snapshot;
  const auto surface = std::make_shared<Surface>();
  surface->mesh = mesh();
  const std::vector<double> offset = numbers(lumigraph_, kLumigraphExtension, "offset", 3);
  surface->offset = {offset[0], offset[1], offset[2]};
  snapshot.cell_seen = values<std::uint8_t>(
      static_cast<int>(number(lumigraph_, kLumigraphExtension, "cellSeen", 0, 1e9)), "cellSeen",
      TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR, 1);
  const double cell_size = number(lumigraph_, kLumigraphExtension, "cellSize", 0, 1e300);
  const std::vector<std::uint32_t> cell_of_face = scalars("cellOfFace");
  if (cell_of_face.size() != surface->mesh.faces.size()) {
    refuse("cellOfFace has " + std::to_string(cell_of_face.size()) + " entries for " +
           std::to_string(surface->mesh.faces.size()) + " faces");
  }
  for (std::size_t face = 0; face < cell_of_face.size(); ++face) {
    if (cell_of_face[face] >= snapshot.cell_seen.size()) {
      refuse("face " + std::to_string(face) + " is in cell " + std::to_string(cell_of_face[face]) + " of " +
             std::to_string(snapshot.cell_seen.size()));
    }
  }
  const std::vector<ViewEntry> entries = view_entries();
  snapshot.references = references(snapshot.cell_seen.size(), entries.size());
  snapshot.vertex_colors = vertex_colors(surface->mesh.positions.size());
  surface->cells = measure_cells(surface->mesh, cell_of_face, cell_size);
  if (surface->cells.cells.size() != snapshot.cell_seen.size()) {
    refuse("cellSeen has " + std::to_string(snapshot.cell_seen.size()) + " cells, cellOfFace uses " +
           std::to_string(surface->cells.cells.size()));
  }
  snapshot.surface = surface;
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface->mesh);
  const ValidityOptions options = validity();
  snapshot.views.resize(entries.size());
  tbb::parallel_for(std::size_t{0}, entries.size(), [&](std::size_t i) {
    snapshot.views[i] = std::make_shared<const StoredView>(load(entries[i], *visibility, options));
  });
  return snapshot;
}

}  // namespace

Model read_model(const std::filesystem::path& path) {
  const Reader reader(std::filesystem::is_directory(path) ? path / kModelFileName : path);
  return {reader.snapshot(), reader.validity()};
}

}  // namespace lumatlas
