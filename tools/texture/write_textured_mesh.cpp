// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/write_textured_mesh.h"

#include <array>
#include <cstring>
#include <fstream>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/whole_file.h"
#include "tools/base/process/process_limits.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr const char* kWebp = "EXT_texture_webp";

// The faces of one page, with a vertex for each that a chart has.
struct PageMesh {
  std::vector<std::uint32_t> vertices;  // vertices of the mesh
  std::vector<glm::vec2> uvs;           // one per vertex, [0, 1], from the top left
  std::vector<glm::uvec3> faces;        // numbers in `vertices`
};

std::vector<PageMesh> page_meshes(const TexturedMesh& textured) {
  const Mesh& mesh = textured.mesh();
  const TextureLayout& layout = textured.layout();
  std::vector<PageMesh> pages(layout.pages);
  constexpr std::uint32_t kNoNumber = ~0u;
  std::vector<std::uint32_t> number(mesh.positions.size(), kNoNumber),
      chart_of_number(mesh.positions.size(), kNoNumber);
  for (std::uint32_t i = 0; i < textured.charts().size(); ++i) {
    const Chart& chart = textured.charts()[i];
    const ChartPlace& place = layout.places[i];
    PageMesh& page = pages[place.page];
    for (const FaceId face : chart.faces) {
      glm::uvec3 corners(0);
      for (int c = 0; c < 3; ++c) {
        const std::uint32_t vertex = mesh.faces[face][c];
        if (chart_of_number[vertex] != i) {
          chart_of_number[vertex] = i;
          number[vertex] = static_cast<std::uint32_t>(page.vertices.size());
          page.vertices.push_back(vertex);
          page.uvs.push_back(layout.uv(chart, place, glm::dvec3(mesh.positions[vertex])));
        }
        corners[c] = number[vertex];
      }
      page.faces.push_back(corners);
    }
  }
  return pages;
}

std::string page_file(std::uint32_t page, const PageCoding& image) {
  return "texture-" + std::to_string(page) + ending(image.format);
}

std::string_view text_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Adds the bytes of a list to a buffer, at a multiple of four; returns where they begin.
template <typename Value>
std::size_t append(std::vector<unsigned char>& buffer, const std::vector<Value>& values) {
  buffer.resize((buffer.size() + 3) / 4 * 4);
  const std::size_t begin = buffer.size(), bytes = values.size() * sizeof(Value);
  require_fits_glb(begin + bytes);
  buffer.resize(begin + bytes);
  if (bytes > 0) std::memcpy(buffer.data() + begin, values.data(), bytes);
  return begin;
}

// A glTF document and its buffer while it is put together.
class GltfDocument {
 public:
  explicit GltfDocument(const TexturedFileOptions& options) {
    document_["asset"] = {{"version", "2.0"}, {"generator", kExportGenerator}};
    if (!options.notes.empty()) document_["asset"]["extras"] = json::parse(options.notes);
    document_["extensionsUsed"] = {"KHR_materials_unlit"};
    if (options.image.format == PageFormat::webp) {
      document_["extensionsUsed"].push_back(kWebp);
      document_["extensionsRequired"] = {kWebp};
    }
    document_["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}};
    for (const char* const list : {"accessors", "bufferViews", "images", "textures", "materials"}) {
      document_[list] = json::array();
    }
  }

  void add_page(const PageMesh& page, const Mesh& mesh, std::uint32_t number) {
    constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementArrayBuffer = 34963;
    std::vector<glm::vec3> positions;
    glm::vec3 least(std::numeric_limits<float>::infinity()), most(-std::numeric_limits<float>::infinity());
    for (const std::uint32_t vertex : page.vertices) {
      positions.push_back(mesh.positions[vertex]);
      least = glm::min(least, positions.back());
      most = glm::max(most, positions.back());
    }
    const json at = accessor(positions, kFloat, "VEC3", positions.size(), kArrayBuffer);
    json& bounds = document_["accessors"].back();
    bounds["min"] = {least.x, least.y, least.z};
    bounds["max"] = {most.x, most.y, most.z};
    const json uv = accessor(page.uvs, kFloat, "VEC2", page.uvs.size(), kArrayBuffer);
    const json faces = accessor(page.faces, kUnsignedInt, "SCALAR", 3 * page.faces.size(), kElementArrayBuffer);
    primitives_.push_back({{"attributes", {{"POSITION", at}, {"TEXCOORD_0", uv}}},
                           {"indices", faces},
                           {"material", number},
                           {"mode", 4}});
    json texture = {{"sampler", 0}};
    if (document_.contains("extensionsRequired")) {
      texture["extensions"][kWebp]["source"] = number;
    } else {
      texture["source"] = number;
    }
    document_["textures"].push_back(texture);
    document_["materials"].push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", number}}}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
         {"doubleSided", true},
         {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  }

  void add_image_file(const std::string& name) { document_["images"].push_back({{"uri", name}}); }

  void add_image(const std::vector<std::uint8_t>& bytes, const PageCoding& image) {
    const std::size_t begin = append(buffer_, bytes);
    document_["images"].push_back(
        {{"bufferView", document_["bufferViews"].size()}, {"mimeType", mime_type(image.format)}});
    document_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes.size()}});
  }

  // Everything is in; `uri` names the buffer's file, null: it is in the .glb.
  [[nodiscard]] json finish(const TexturedFileOptions& options, const Snapshot& snapshot, const json& uri) {
    const glm::dvec3& offset = snapshot.surface->offset;
    json node = {{"mesh", 0}, {"name", "lumatlas"}};
    if (offset != glm::dvec3(0)) node["extras"]["offset"] = {offset.x, offset.y, offset.z};
    if (!options.georeference.empty()) node["extras"]["georeference"] = json::parse(options.georeference);
    document_["nodes"] = json::array({node});
    document_["nodes"][0]["rotation"] = gltf_rotation(options.file_from_scene);
    add_cameras(document_, snapshot);
    document_["meshes"] = json::array({{{"primitives", primitives_}}});
    document_["scenes"] = json::array({{{"nodes", {0}}}});
    document_["scene"] = 0;
    json buffer = {{"byteLength", buffer_.size()}};
    if (!uri.is_null()) buffer["uri"] = uri;
    document_["buffers"] = json::array({buffer});
    return std::move(document_);
  }

  [[nodiscard]] const std::vector<unsigned char>& buffer() const { return buffer_; }

 private:
  template <typename Value>
  json accessor(const std::vector<Value>& values, int component, const char* type, std::size_t count, int target) {
    const std::size_t begin = append(buffer_, values);
    document_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", values.size() * sizeof(Value)}, {"target", target}});
    document_["accessors"].push_back({{"bufferView", document_["bufferViews"].size() - 1},
                                      {"componentType", component},
                                      {"count", count},
                                      {"type", type}});
    return document_["accessors"].size() - 1;
  }

  json document_ = json::object();
  json primitives_ = json::array();
  std::vector<unsigned char> buffer_;
};

void require_rotation(const glm::dmat3& m) {
  const glm::dmat3 product = m * glm::transpose(m);
  double off = std::abs(glm::determinant(m) - 1);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) off = std::max(off, std::abs(product[i][j] - (i == j ? 1 : 0)));
  }
  if (off < 1e-6) return;
  throw std::invalid_argument("textured mesh: file_from_scene is off a rotation by " + number_text(off) +
                              ", must be orthonormal with determinant 1");
}

void check(const TexturedFileOptions& options) {
  check(options.image);
  if (!options.notes.empty() && !json::parse(options.notes, nullptr, false).is_object()) {
    throw std::invalid_argument("textured mesh: notes are not the text of a JSON object");
  }
  require_rotation(options.file_from_scene);
}

// Text that grows and is written from time to time.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path) : path_(path), stream_(path, std::ios::binary) {}
  void add(std::string_view text) {
    text_ += text;
    if (text_.size() > (1u << 20)) flush();
  }
  void close() {
    flush();
    stream_.close();
    if (!stream_) throw InputError(path_.string() + ": cannot be written to its end, " + why_not_written());
  }

 private:
  void flush() {
    stream_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
  }
  std::filesystem::path path_;
  std::ofstream stream_;
  std::string text_;
};

void write_material_library(const std::filesystem::path& folder, std::uint32_t pages, const PageCoding& image) {
  std::string text;
  for (std::uint32_t page = 0; page < pages; ++page) {
    text += "newmtl page" + std::to_string(page) + "\nKd 1 1 1\nKa 0 0 0\nKs 0 0 0\nillum 0\nmap_Kd " +
            page_file(page, image) + "\n";
  }
  write_whole_file(folder / "scene.mtl", text, Durability::left_to_folder);
}

}  // namespace

TextureFacts write_textured_gltf(const std::filesystem::path& folder, const TexturedMesh& mesh,
                                 const TexturedFileOptions& options, const CancelCheck& cancel_check) {
  check(options);
  GltfDocument gltf(options);
  std::uint32_t number = 0;
  for (const PageMesh& page : page_meshes(mesh)) gltf.add_page(page, mesh.mesh(), number++);
  const TextureFacts facts = mesh.bake(
      [&](std::uint32_t page, const Photograph& picture) {
        const std::string name = page_file(page, options.image);
        write_whole_file(folder / name, text_of(encode_page(picture, options.image)), Durability::left_to_folder);
        gltf.add_image_file(name);
      },
      cancel_check);
  const json document = gltf.finish(options, mesh.snapshot(), "scene.bin");
  write_whole_file(folder / "scene.bin", text_of(gltf.buffer()), Durability::left_to_folder);
  write_whole_file(folder / "scene.gltf", document.dump(2) + "\n", Durability::left_to_folder);
  return facts;
}

TextureFacts write_textured_glb(std::ostream& file, const TexturedMesh& mesh, const TexturedFileOptions& options,
                                const CancelCheck& cancel_check) {
  check(options);
  GltfDocument gltf(options);
  std::uint32_t number = 0;
  for (const PageMesh& page : page_meshes(mesh)) gltf.add_page(page, mesh.mesh(), number++);
  const TextureFacts facts =
      mesh.bake([&](std::uint32_t,
                    const Photograph& picture) { gltf.add_image(encode_page(picture, options.image), options.image); },
                cancel_check);
  const json document = gltf.finish(options, mesh.snapshot(), json());
  write_glb_frame(file, document.dump(), gltf.buffer());
  return facts;
}

TextureFacts write_textured_obj(const std::filesystem::path& folder, const TexturedMesh& textured,
                                const TexturedFileOptions& options, const CancelCheck& cancel_check) {
  check(options);
  if (options.image.format == PageFormat::webp) {
    throw std::invalid_argument("textured mesh: image.format is webp, which programs that read OBJ do not know");
  }
  const Mesh& mesh = textured.mesh();
  const glm::dvec3 offset = textured.snapshot().surface->offset;
  TextFile file(folder / "scene.obj");
  file.add("# lumatlas export\n");
  if (!options.georeference_sentence.empty()) file.add("# " + options.georeference_sentence + '\n');
  file.add("mtllib scene.mtl\n");
  for (const glm::vec3& position : mesh.positions) {
    const glm::dvec3 p = options.file_from_scene * (glm::dvec3(position) + offset);
    file.add("v " + number_text(p.x) + ' ' + number_text(p.y) + ' ' + number_text(p.z) + '\n');
  }
  std::size_t uvs_before = 1, number = 0;
  for (const PageMesh& page : page_meshes(textured)) {
    for (const glm::vec2& uv : page.uvs) file.add("vt " + number_text(uv.x) + ' ' + number_text(1 - uv.y) + '\n');
    file.add("usemtl page" + std::to_string(number++) + '\n');
    for (const glm::uvec3& face : page.faces) {
      file.add("f");
      for (int c = 0; c < 3; ++c) {
        file.add(' ' + std::to_string(page.vertices[face[c]] + 1) + '/' + std::to_string(uvs_before + face[c]));
      }
      file.add("\n");
    }
    uvs_before += page.uvs.size();
  }
  file.close();
  write_material_library(folder, textured.layout().pages, options.image);
  return textured.bake(
      [&](std::uint32_t page, const Photograph& picture) {
        write_whole_file(folder / page_file(page, options.image), text_of(encode_page(picture, options.image)),
                         Durability::left_to_folder);
      },
      cancel_check);
}

}  // namespace lumatlas
