// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/gltf/meshopt_compression.h"
#include "atlas/model/model_extension.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Stands for the URI of the buffer in a .glb, which has none.
constexpr const char* kBinaryChunk = "binary chunk";

// Size of the stand-in for a buffer that has no bytes in the file, because tinygltf takes no empty buffer.
constexpr std::size_t kEmptyBufferBytes = 4;

// The file system that tinygltf sees. It would otherwise look for a buffer along any path in the file, and then in the
// working directory too.
struct Folder {
  const GltfFile& file;
  fs::path path;
  std::function<std::vector<unsigned char>()> binary_chunk;  // empty: there is none
  std::set<std::string> empty_buffers;  // URIs that stand for buffers whose views are all compressed
  std::set<fs::path> read;              // a buffer that is read a thousand times would fill the memory

  static Folder& of(void* user_data) { return *static_cast<Folder*>(user_data); }

  static std::string place(const std::string& uri, void* user_data) {
    Folder& folder = of(user_data);
    if ((folder.binary_chunk && uri == kBinaryChunk) || folder.empty_buffers.contains(uri)) return uri;
    const fs::path relative(uri);
    if (!stays_in_folder(relative) || has_control_character(uri)) {
      folder.file.refuse("its buffer has the path \"" + uri + "\", must lie in the model's own folder");
    }
    const fs::path file = folder.path / relative.lexically_normal();
    if (leads_out_of(folder.path, file)) {
      folder.file.refuse("its buffer " + uri + " is a link that leads out of the model's own folder");
    }
    return file.string();
  }
  static bool exists(const std::string&, void*) { return true; }  // else the next place would be tried
  static bool read_file(std::vector<unsigned char>* bytes, std::string*, const std::string& path, void* user_data) {
    Folder& folder = of(user_data);
    if (!folder.read.insert(path).second) folder.file.refuse("has two buffers with the path \"" + path + "\"");
    if (folder.binary_chunk && path == kBinaryChunk) {
      *bytes = folder.binary_chunk();
      return true;
    }
    if (folder.empty_buffers.contains(path)) {
      bytes->assign(kEmptyBufferBytes, 0);
      return true;
    }
    const std::string text = read_whole_file(path);
    bytes->assign(text.begin(), text.end());
    return true;
  }
  static bool write_file(std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }
};

}  // namespace

GltfFile::GltfFile(fs::path file, GltfUse use) : FieldReader(std::move(file)) {
  GlbFrame frame;
  if (is_glb(path())) {
    frame = read_glb_frame(path());
  } else {
    frame.json = read_whole_file(path());
  }
  if (frame.json.size() > std::numeric_limits<std::uint32_t>::max()) {
    refuse("is larger than 4 GiB, too large for a glTF file");
  }
  const int levels = nesting(frame.json);
  if (levels > kMaxNesting) {
    refuse("nests its values " + std::to_string(levels) + " deep, must be at most " + std::to_string(kMaxNesting));
  }
  parse(frame, use);
  check_version();
}

namespace {

// Gives the buffer that is the binary chunk a URI, and returns how many bytes of the chunk it is; none if there is no
// such buffer. A chunk may end in up to three bytes that are not the buffer's.
std::optional<std::uint64_t> name_binary_chunk(nlohmann::json& document, const GlbFrame& frame) {
  if (frame.binary_bytes == 0 || !document.contains("buffers")) return std::nullopt;
  nlohmann::json& buffers = document["buffers"];
  if (!buffers.is_array() || buffers.empty() || !buffers[0].is_object() || buffers[0].contains("uri")) {
    return std::nullopt;
  }
  buffers[0]["uri"] = kBinaryChunk;
  const auto length = buffers[0].find("byteLength");
  if (length == buffers[0].end() || !length->is_number_unsigned()) return frame.binary_bytes;
  const auto bytes = length->get<std::uint64_t>();
  return bytes < frame.binary_bytes && frame.binary_bytes - bytes < 4 ? bytes : frame.binary_bytes;
}

// Gives a URI to each buffer that has no bytes because EXT_meshopt_compression compressed all of its views. Returns the
// buffers' numbers by their URIs.
std::map<std::string, int> name_empty_buffers(nlohmann::json& document) {
  std::map<std::string, int> names;
  const auto buffers = document.find("buffers");
  if (buffers == document.end() || !buffers->is_array()) return names;
  for (std::size_t i = 0; i < buffers->size(); ++i) {
    nlohmann::json& buffer = (*buffers)[i];
    if (!buffer.is_object() || buffer.contains("uri") || !buffer.contains("extensions")) continue;
    if (!buffer["extensions"].is_object() || !buffer["extensions"].contains(kMeshoptExtension)) continue;
    const std::string name = "compressed buffer " + std::to_string(i);
    buffer["uri"] = name;
    buffer["byteLength"] = kEmptyBufferBytes;
    names.emplace(name, static_cast<int>(i));
  }
  return names;
}

}  // namespace

void GltfFile::take_images(nlohmann::json& document) {
  const auto found = document.find("images");
  if (found == document.end()) return;
  if (!found->is_array()) refuse("\"images\" is not an array");
  for (const nlohmann::json& image : *found) {
    const std::string where = "image " + std::to_string(images_.size());
    if (!image.is_object() || image.contains("uri") == image.contains("bufferView")) {
      refuse(where + " must have a \"uri\" or a \"bufferView\"");
    }
    ImagePlace place;
    if (image.contains("uri")) {
      if (!image["uri"].is_string()) refuse(where + ": \"uri\" is not a string");
      place.uri = image["uri"];
    } else {
      const nlohmann::json& view = image["bufferView"];
      if (!view.is_number_unsigned() || view > kMostIndex) refuse(where + ": \"bufferView\" is " + view.dump());
      place.buffer_view = view;
    }
    images_.push_back(std::move(place));
  }
  document.erase(found);
}

namespace {

// The extensions that a file may require. None of the others may be skipped: what they leave out would be missing.
bool is_known(const std::string& extension, GltfUse use) {
  if (extension == kLumigraphExtension || extension == kUnlitExtension || extension == kMeshoptExtension) return true;
  if (use == GltfUse::model) return false;
  constexpr std::array kElsewhere{"KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"};
  return extension == "KHR_mesh_quantization" || extension == "KHR_node_visibility" ||
         std::any_of(kElsewhere.begin(), kElsewhere.end(), [&](auto start) { return extension.starts_with(start); });
}

// Extensions by which the buffers do not hold what accessors say.
struct Compression {
  const char* extension;
  const char* name;
};
constexpr std::array kCompressions{Compression{"KHR_draco_mesh_compression", "Draco"},
                                   Compression{"EXT_meshopt_compression", "meshoptimizer"},
                                   Compression{"KHR_meshopt_compression", "meshoptimizer"}};

}  // namespace

// Before the rest is parsed: what such an extension leaves out would look like damage.
void GltfFile::check_required(const nlohmann::json& document, GltfUse use) const {
  const auto required = document.find("extensionsRequired");
  if (required == document.end() || !required->is_array()) return;
  for (const nlohmann::json& entry : *required) {
    if (!entry.is_string()) refuse("\"extensionsRequired\" holds something else than names");
    const auto extension = entry.get<std::string>();
    if (is_known(extension, use)) continue;
    for (const Compression& compression : kCompressions) {
      if (extension != compression.extension) continue;
      refuse(std::string("is compressed by ") + compression.name + " (" + extension +
             "), which this program does not read: export it without compression");
    }
    refuse("requires the extension " + extension + ", which this program does not know");
  }
}

void GltfFile::parse(const GlbFrame& frame, GltfUse use) {
  Folder folder{*this, path().parent_path(), {}, {}, {}};
  std::set<int> empty_buffers;
  nlohmann::json document = nlohmann::json::parse(frame.json, nullptr, false);
  std::string json = frame.json;  // tinygltf refuses a text that is no JSON
  if (document.is_object()) {
    check_required(document, use);
    take_images(document);
    if (const std::optional<std::uint64_t> bytes = name_binary_chunk(document, frame)) {
      folder.binary_chunk = [&, count = *bytes] { return read_glb_binary(path(), frame, count); };
    }
    for (const auto& [name, number] : name_empty_buffers(document)) {
      folder.empty_buffers.insert(name);
      empty_buffers.insert(number);
    }
    json = document.dump();
  }
  tinygltf::TinyGLTF reader;
  reader.SetFsCallbacks({&Folder::exists, &Folder::place, &Folder::read_file, &Folder::write_file, &folder});
  std::string error, warning;
  bool parsed = false;
  try {
    parsed = reader.LoadASCIIFromString(&model_, &error, &warning, json.data(), static_cast<unsigned int>(json.size()),
                                        std::string());
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (!parsed) refuse("is no glTF 2.0 file that can be read: " + short_reason(error));
  decode_views(empty_buffers);
}

// Views of buffers that have bytes of their own are read from these.
void GltfFile::decode_views(const std::set<int>& empty_buffers) {
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < model_.bufferViews.size(); ++i) {
    tinygltf::BufferView& view = model_.bufferViews[i];
    const auto compression = view.extensions.find(kMeshoptExtension);
    if (!empty_buffers.contains(view.buffer) || compression == view.extensions.end()) continue;
    const std::string where = "buffer view " + std::to_string(i) + ": " + kMeshoptExtension;
    const MeshoptView shape = meshopt_view(compression->second, where);
    if (view.byteLength != shape.decoded_bytes() || (view.byteStride != 0 && view.byteStride != shape.stride)) {
      refuse(where + " holds " + std::to_string(shape.count) + " elements of " + std::to_string(shape.stride) +
             " bytes, but the buffer view has " + std::to_string(view.byteLength) + " bytes with a stride of " +
             std::to_string(view.byteStride));
    }
    view.byteStride = shape.stride;
    total += shape.decoded_bytes();
    decoded_.emplace(static_cast<int>(i), decoded_bytes(compression->second, shape, where));
    if (total > kMostMeshoptGrowth * buffer_bytes()) {  // views may share their bytes
      refuse("its compressed buffer views hold more than its buffers can: it is damaged");
    }
  }
}

MeshoptView GltfFile::meshopt_view(const Object& compression, const std::string& where) const {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  const std::string mode_name = text(compression, where, "mode");
  const std::string filter_name = compression.Has("filter") ? text(compression, where, "filter") : "NONE";
  const std::optional<MeshoptMode> mode = meshopt_mode(mode_name);
  const std::optional<MeshoptFilter> filter = meshopt_filter(filter_name);
  if (!mode) refuse(where + " has the mode " + in_quotes(mode_name) + ", which is not known");
  if (!filter) refuse(where + " has the filter " + in_quotes(filter_name) + ", which is not known");
  return {*mode, *filter, whole_number(compression, where, "count", 0, kMost),
          whole_number(compression, where, "byteStride", 0, kMost)};
}

std::vector<unsigned char> GltfFile::decoded_bytes(const Object& compression, const MeshoptView& shape,
                                                   const std::string& where) const {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  const int buffer = static_cast<int>(whole_number(compression, where, "buffer", 0, kMostIndex));
  const std::size_t offset =
      compression.Has("byteOffset") ? whole_number(compression, where, "byteOffset", 0, kMost) : 0;
  const std::size_t length = whole_number(compression, where, "byteLength", 0, kMost);
  const std::span<const unsigned char> compressed = part_of_buffer(buffer, offset, length, where);
  if (const std::string broken = broken_rule(shape, compressed.size()); !broken.empty()) refuse(where + ": " + broken);
  std::optional<std::vector<unsigned char>> bytes = decoded(shape, compressed);
  if (!bytes) refuse(where + ": its bytes cannot be decoded: they are damaged, or of a later version");
  return std::move(*bytes);
}

void GltfFile::check_version() const {
  if (!model_.asset.version.starts_with("2.")) {
    refuse("is of glTF version " + model_.asset.version + ", this program reads 2.0");
  }
  if (!model_.asset.minVersion.empty() && model_.asset.minVersion != "2.0") {
    refuse("needs a reader of glTF " + model_.asset.minVersion + ", this program reads 2.0");
  }
}

const GltfFile::Object& GltfFile::extension(const char* name) const {
  const auto found = model_.extensions.find(name);
  if (found == model_.extensions.end() || !found->second.IsObject()) {
    refuse(std::string("has no extension ") + name + ": it is a mesh without photographs");
  }
  return found->second;
}

const tinygltf::Primitive& GltfFile::triangles(std::size_t mesh) const {
  if (mesh >= model_.meshes.size() || model_.meshes[mesh].primitives.empty()) {
    refuse("holds no mesh" + (mesh == 0 ? "" : " " + std::to_string(mesh)));
  }
  const tinygltf::Primitive& primitive = model_.meshes[mesh].primitives[0];
  if (primitive.mode != TINYGLTF_MODE_TRIANGLES) {
    refuse("its mesh has mode " + std::to_string(primitive.mode) + ", must be a list of triangles, mode 4");
  }
  return primitive;
}

int GltfFile::attribute(const char* name, std::size_t mesh) const {
  const auto& attributes = triangles(mesh).attributes;
  const auto found = attributes.find(name);
  if (found == attributes.end()) refuse(std::string("its mesh has no ") + name);
  return found->second;
}

const tinygltf::Accessor& GltfFile::accessor_at(int accessor, const std::string& where) const {
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model_.accessors.size()) refuse(where + " does not exist");
  return model_.accessors[static_cast<std::size_t>(accessor)];
}

const tinygltf::BufferView& GltfFile::view_at(int view, const std::string& where) const {
  if (view < 0 || static_cast<std::size_t>(view) >= model_.bufferViews.size()) refuse(where + " does not exist");
  return model_.bufferViews[static_cast<std::size_t>(view)];
}

std::span<const unsigned char> GltfFile::part_of_buffer(int buffer, std::size_t offset, std::size_t length,
                                                        const std::string& where) const {
  if (buffer < 0 || static_cast<std::size_t>(buffer) >= model_.buffers.size()) {
    refuse(where + " is of buffer " + std::to_string(buffer) + ", which does not exist");
  }
  const std::vector<unsigned char>& bytes = model_.buffers[static_cast<std::size_t>(buffer)].data;
  if (offset > bytes.size() || length > bytes.size() - offset) {
    refuse(where + " reaches beyond its buffer of " + std::to_string(bytes.size()) + " bytes");
  }
  return std::span(bytes).subspan(offset, length);
}

std::span<const unsigned char> GltfFile::view_bytes(int view_index, const std::string& what) const {
  const std::string where = what + ": buffer view " + std::to_string(view_index);
  const tinygltf::BufferView& view = view_at(view_index, where);
  if (const auto decoded = decoded_.find(view_index); decoded != decoded_.end()) return decoded->second;
  return part_of_buffer(view.buffer, view.byteOffset, view.byteLength, where);
}

std::span<const unsigned char> GltfFile::packed_bytes(int view, const std::string& what,
                                                      std::size_t element_bytes) const {
  const std::string where = what + ": buffer view " + std::to_string(view);
  const std::size_t stride = view_at(view, where).byteStride;
  if (stride != 0 && stride != element_bytes) refuse(where + " has a stride, must be packed");
  return view_bytes(view, what);
}

GltfFile::Bytes GltfFile::bytes_of(int accessor_index, const std::string& what, const AccessorType& type,
                                   std::size_t value_size) const {
  const std::string where = what + ": accessor " + std::to_string(accessor_index);
  const tinygltf::Accessor& accessor = accessor_at(accessor_index, where);
  if (accessor.componentType != type.component || accessor.type != type.type || accessor.sparse.isSparse) {
    refuse(where + " has another type than this program writes");
  }
  if (accessor.count % type.elements_per_value != 0) {
    refuse(where + " has " + std::to_string(accessor.count) + " elements, must have a multiple of " +
           std::to_string(type.elements_per_value));
  }
  const std::span<const unsigned char> bytes =
      packed_bytes(accessor.bufferView, what, value_size / type.elements_per_value);
  const std::size_t count = accessor.count / type.elements_per_value;
  if (accessor.byteOffset > bytes.size() || count > (bytes.size() - accessor.byteOffset) / value_size) {
    refuse(where + " reaches beyond its buffer view of " + std::to_string(bytes.size()) + " bytes");
  }
  return {bytes.data() + accessor.byteOffset, count};
}

GltfElements GltfFile::elements(int accessor_index, const std::string& what) const {
  const std::string where = what + ": accessor " + std::to_string(accessor_index);
  const tinygltf::Accessor& accessor = accessor_at(accessor_index, where);
  if (accessor.sparse.isSparse) refuse(where + " is sparse, which this program does not read: write it out in full");
  if (accessor.bufferView < 0) refuse(where + " has no buffer view, as if it were compressed: write it out in full");
  const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
  if (component_bytes <= 0 || components <= 0) refuse(where + " is of a type that glTF does not have");
  const std::span<const unsigned char> bytes = view_bytes(accessor.bufferView, what);
  const auto size = static_cast<std::size_t>(component_bytes) * static_cast<std::size_t>(components);
  const std::size_t given = view_at(accessor.bufferView, where).byteStride;
  const std::size_t stride = given == 0 ? size : given;
  const bool fits =
      stride >= size && accessor.byteOffset <= bytes.size() &&
      (accessor.count == 0 || (size <= bytes.size() - accessor.byteOffset &&
                               accessor.count - 1 <= (bytes.size() - accessor.byteOffset - size) / stride));
  if (!fits) refuse(where + " reaches beyond its buffer view of " + std::to_string(bytes.size()) + " bytes");
  return {bytes.data() + accessor.byteOffset,
          accessor.count,
          stride,
          accessor.componentType,
          components,
          accessor.normalized};
}

std::uint64_t GltfFile::buffer_bytes() const {
  std::uint64_t bytes = 0;
  for (const tinygltf::Buffer& buffer : model_.buffers) bytes += buffer.data.size();
  return bytes;
}

std::uint64_t GltfFile::decoded_size() const {
  std::uint64_t bytes = 0;
  for (const auto& [view, decoded] : decoded_) bytes += decoded.size();
  return bytes;
}

std::vector<std::string> GltfFile::uris() const {
  std::vector<std::string> uris;
  for (const ImagePlace& image : images_) {
    if (image.buffer_view < 0) uris.push_back(image.uri);
  }
  for (const tinygltf::Buffer& buffer : model_.buffers) {
    const bool is_stand_in = buffer.uri == kBinaryChunk || buffer.extensions.contains(kMeshoptExtension);
    if (!buffer.uri.empty() && !is_stand_in) uris.push_back(buffer.uri);
  }
  return uris;
}

GltfImage GltfFile::image(std::uint32_t index) const {
  const std::string where = "image " + std::to_string(index);
  if (index >= images_.size()) refuse(where + " does not exist");
  const ImagePlace& place = images_[index];
  if (place.buffer_view >= 0) {
    const std::span<const unsigned char> bytes = packed_bytes(place.buffer_view, where, 1);
    if (bytes.empty()) refuse(where + " is empty");
    return {path().string() + ": " + where, bytes};
  }
  return {file_beside(place.uri, where), {}};
}

}  // namespace lumatlas
