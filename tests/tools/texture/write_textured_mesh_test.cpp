// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/write_textured_mesh.h"

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/glm.hpp>
#include <sstream>

#include "atlas/model/gltf/tiny_gltf.h"
#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "mesh/upright.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

TexturedMesh room(std::uint32_t most_side_px = 8192, const glm::dvec3& offset = glm::dvec3(0)) {
  Snapshot snapshot = room_snapshot(8, {});
  const auto moved = std::make_shared<Surface>(*snapshot.surface);
  moved->offset = offset;
  snapshot.surface = moved;
  TextureOptions options;
  options.layout.most_side_px = most_side_px;
  options.layout.most_pages = 8;
  return {std::move(snapshot), options};
}

// Images stay as they are encoded.
tinygltf::Model read_gltf(const std::filesystem::path& file) {
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader(
      [](tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
         void*) {
        image->image.assign(bytes, bytes + size);
        return true;
      },
      nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const bool read = file.extension() == ".glb" ? reader.LoadBinaryFromFile(&model, &error, &warning, file.string())
                                               : reader.LoadASCIIFromFile(&model, &error, &warning, file.string());
  CAPTURE(error);
  CHECK(warning.empty());
  REQUIRE(read);
  return model;
}

template <typename Value>
std::vector<Value> values_of(const tinygltf::Model& model, int accessor, int component, std::size_t elements) {
  const tinygltf::Accessor& a = model.accessors.at(static_cast<std::size_t>(accessor));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(a.bufferView));
  const std::vector<unsigned char>& bytes = model.buffers.at(static_cast<std::size_t>(view.buffer)).data;
  CHECK(a.componentType == component);
  CHECK(view.byteOffset % 4 == 0);
  REQUIRE(view.byteOffset + view.byteLength <= bytes.size());
  REQUIRE(a.byteOffset + a.count * elements * 4 <= view.byteLength);
  std::vector<Value> values(a.count * elements * 4 / sizeof(Value));
  std::memcpy(values.data(), bytes.data() + view.byteOffset + a.byteOffset, values.size() * sizeof(Value));
  return values;
}

using Corners = std::array<std::array<float, 3>, 3>;

Corners corners(const std::vector<glm::vec3>& positions, const glm::uvec3& face) {
  Corners result;
  for (std::size_t c = 0; c < 3; ++c) {
    const glm::vec3& p = positions.at(face[static_cast<int>(c)]);
    result[c] = {p.x, p.y, p.z};
  }
  return result;
}

std::vector<Corners> sorted_faces(const Mesh& mesh) {
  std::vector<Corners> faces;
  for (const glm::uvec3& face : mesh.faces) faces.push_back(corners(mesh.positions, face));
  std::sort(faces.begin(), faces.end());
  return faces;
}

// Checks what the Khronos validator checks, and that the surface is the mesh's, corner by corner to the bit: then it
// has no T-junction that the mesh has not.
void check_gltf(const tinygltf::Model& model, const TexturedMesh& mesh, const std::filesystem::path& folder) {
  CHECK(model.asset.version == "2.0");
  CHECK(model.asset.generator == kExportGenerator);
  CHECK(model.extensionsUsed == std::vector<std::string>{"KHR_materials_unlit"});
  CHECK(model.extensionsRequired.empty());
  REQUIRE(model.meshes.size() == 1);
  const std::size_t pages = mesh.layout().pages;
  REQUIRE(model.meshes[0].primitives.size() == pages);
  REQUIRE(model.images.size() == pages);
  std::vector<Corners> faces;
  for (std::size_t page = 0; page < pages; ++page) {
    const tinygltf::Primitive& primitive = model.meshes[0].primitives[page];
    CHECK(primitive.mode == TINYGLTF_MODE_TRIANGLES);
    const int at = primitive.attributes.at("POSITION");
    const auto positions = values_of<glm::vec3>(model, at, TINYGLTF_COMPONENT_TYPE_FLOAT, 3);
    const auto uvs =
        values_of<glm::vec2>(model, primitive.attributes.at("TEXCOORD_0"), TINYGLTF_COMPONENT_TYPE_FLOAT, 2);
    const auto indices = values_of<std::uint32_t>(model, primitive.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 1);
    REQUIRE(uvs.size() == positions.size());
    REQUIRE(indices.size() % 3 == 0);
    for (const glm::vec2& uv : uvs) REQUIRE((uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1));
    glm::vec3 least(positions[0]), most(positions[0]);
    for (const glm::vec3& p : positions) {
      least = glm::min(least, p);
      most = glm::max(most, p);
    }
    const tinygltf::Accessor& bounds = model.accessors.at(static_cast<std::size_t>(at));
    for (int c = 0; c < 3; ++c) {
      CHECK(static_cast<float>(bounds.minValues.at(static_cast<std::size_t>(c))) == least[c]);
      CHECK(static_cast<float>(bounds.maxValues.at(static_cast<std::size_t>(c))) == most[c]);
    }
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      faces.push_back(corners(positions, {indices[i], indices[i + 1], indices[i + 2]}));
    }
    const tinygltf::Material& material = model.materials.at(static_cast<std::size_t>(primitive.material));
    CHECK(material.extensions.contains("KHR_materials_unlit"));
    const int texture = material.pbrMetallicRoughness.baseColorTexture.index;
    const int source = model.textures.at(static_cast<std::size_t>(texture)).source;
    const tinygltf::Image& image = model.images.at(static_cast<std::size_t>(source));
    const Photograph picture =
        image.uri.empty() ? read_photograph(image.image, "page") : read_photograph(folder / image.uri);
    CHECK(picture.width == mesh.layout().side_px);
    CHECK(picture.height == mesh.layout().side_px);
  }
  std::sort(faces.begin(), faces.end());
  CHECK(faces == sorted_faces(mesh.mesh()));
}

TEST_CASE("a .glb holds the mesh to the bit, its texture and how it was made") {
  const TemporaryFolder folder;
  const TexturedMesh mesh = room();
  TexturedFileOptions options;
  options.notes = R"({"made": "by a test"})";
  options.file_from_scene = upright(std::array{room_camera(0)}, {0, 0, 1});
  std::ofstream file(folder / "room.glb", std::ios::binary);
  const TextureFacts facts = write_textured_glb(file, mesh, options);
  file.close();
  CHECK(facts.texels > 0);
  const tinygltf::Model model = read_gltf(folder / "room.glb");
  check_gltf(model, mesh, folder.path());
  CHECK(model.asset.extras.Get("made").Get<std::string>() == "by a test");
  CHECK(model.images[0].mimeType == "image/png");
  // The root turns z up into y up.
  const std::vector<double>& q = model.nodes.at(0).rotation;
  REQUIRE(q.size() == 4);
  const glm::dquat turn(q[3], q[0], q[1], q[2]);
  CHECK(glm::length(turn * glm::dvec3(0, 0, 1) - glm::dvec3(0, 1, 0)) < 1e-9);
  CHECK(model.nodes.at(0).children.size() == model.cameras.size());
  CHECK(model.cameras.size() ==
        static_cast<std::size_t>(std::count_if(mesh.snapshot().views.begin(), mesh.snapshot().views.end(),
                                               [](const auto& view) { return view != nullptr; })));
}

TEST_CASE("a glTF folder of several pages, as JPEG") {
  const TemporaryFolder folder;
  const TexturedMesh mesh = room(256, {1000, -2000, 0.5});
  REQUIRE(mesh.layout().pages > 1);
  TexturedFileOptions options;
  options.image.format = PageFormat::jpeg;
  std::atomic<std::size_t> ticks = 0;
  (void)write_textured_gltf(folder.path(), mesh, options, [&] { ++ticks; });
  CHECK(ticks == mesh.charts().size());
  const tinygltf::Model model = read_gltf(folder / "scene.gltf");
  check_gltf(model, mesh, folder.path());
  CHECK(model.images[0].uri == "texture-0.jpg");
  const tinygltf::Value& offset = model.nodes.at(0).extras.Get("offset");
  CHECK(offset.Get(1).GetNumberAsDouble() == -2000);
}

TEST_CASE("WebP pages are what readers of EXT_texture_webp find") {
  const TemporaryFolder folder;
  const TexturedMesh mesh = room(512);
  TexturedFileOptions options;
  options.image = {PageFormat::webp, 90};
  (void)write_textured_gltf(folder.path(), mesh, options);
  const tinygltf::Model model = read_gltf(folder / "scene.gltf");
  CHECK(model.extensionsUsed == std::vector<std::string>{"KHR_materials_unlit", "EXT_texture_webp"});
  CHECK(model.extensionsRequired == std::vector<std::string>{"EXT_texture_webp"});
  std::vector<Photograph> exact;
  (void)mesh.bake([&](std::uint32_t, const Photograph& page) { exact.push_back(page); });
  REQUIRE(model.textures.size() == exact.size());
  for (std::size_t page = 0; page < exact.size(); ++page) {
    const tinygltf::Texture& texture = model.textures[page];
    CHECK(texture.source == -1);
    const int source = texture.extensions.at("EXT_texture_webp").Get("source").GetNumberAsInt();
    const std::string& uri = model.images.at(static_cast<std::size_t>(source)).uri;
    CHECK(uri == "texture-" + std::to_string(page) + ".webp");
    CHECK(bytes_of(folder / uri).substr(8, 4) == "WEBP");
    const Photograph read = read_photograph(folder / uri);
    REQUIRE(read.rgb.size() == exact[page].rgb.size());
    double squares = 0;
    for (std::size_t i = 0; i < read.rgb.size(); ++i) {
      squares += std::pow(static_cast<double>(read.rgb[i]) - exact[page].rgb[i], 2);
    }
    CHECK(std::sqrt(squares / static_cast<double>(read.rgb.size())) < 12);  // colour has half the resolution
  }
  CHECK_THROWS_AS(write_textured_obj(folder.path(), mesh, options), std::invalid_argument);
  CHECK(encode_page(exact[0], options.image) == encode_page(exact[0], options.image));
  CHECK_THROWS_AS(encode_page({}, options.image), std::invalid_argument);
  Photograph wide{kLongestWebp + 1, 1, std::vector<std::uint8_t>(3 * std::size_t{kLongestWebp + 1}), {}};
  CHECK_THROWS_AS(encode_page(wide, options.image), InputError);
}

TEST_CASE("an OBJ has the scene's coordinates, turned, and texture coordinates from the bottom left") {
  const TemporaryFolder folder;
  const TexturedMesh mesh = room(512, {1e6, 0, 0});
  TexturedFileOptions options;
  options.file_from_scene = upright(std::array{room_camera(0)}, {0, 0, 1});
  (void)write_textured_obj(folder.path(), mesh, options);
  const TriangleSoup soup = read_triangle_soup(folder / "scene.obj");
  REQUIRE(soup.faces.size() == mesh.mesh().faces.size());
  REQUIRE(soup.positions.size() == mesh.mesh().positions.size());
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    const glm::dvec3 expected =
        options.file_from_scene * (glm::dvec3(mesh.mesh().positions[i]) + glm::dvec3(1e6, 0, 0));
    REQUIRE(glm::distance(soup.positions[i], expected) < 1e-9);
  }
  std::istringstream text(bytes_of(folder / "scene.obj"));
  std::size_t uvs = 0;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with("vt ")) continue;
    ++uvs;
    std::istringstream numbers(line.substr(3));
    double u = -1, v = -1;
    REQUIRE(numbers >> u >> v);
    REQUIRE((u >= 0 && u <= 1 && v >= 0 && v <= 1));
  }
  CHECK(uvs >= mesh.mesh().positions.size());
  CHECK_THAT(bytes_of(folder / "scene.mtl"), Catch::Contains("map_Kd texture-0.png"));
  CHECK(read_photograph(folder / "texture-0.png").width == mesh.layout().side_px);
}

TEST_CASE("upright is a rotation that stands the scene on its feet and looks into it") {
  const Camera camera = room_camera(3);
  const glm::dvec3 up = glm::normalize(glm::dvec3(0.2, -1, 0.1));
  const glm::dmat3 turn = upright(std::array{camera}, up);
  CHECK(glm::determinant(turn) == Approx(1));
  CHECK(glm::length(turn * up - glm::dvec3(0, 1, 0)) < 1e-12);
  const glm::dvec3 ahead = turn * camera.viewing_direction();
  CHECK(std::abs(ahead.x) < 1e-12);
  CHECK(ahead.z < 0);
  Camera back = camera;  // turned about up: together they look nowhere
  const glm::dvec3 y(0, 1, 0);
  back.cam_from_world_rotation = camera.cam_from_world_rotation * (2.0 * glm::outerProduct(up, up) - glm::dmat3(1));
  CHECK(glm::length(upright(std::array{camera, back}, up) * up - y) < 1e-12);
}

TEST_CASE("what is no rotation, and notes that are no JSON, are refused") {
  const TemporaryFolder folder;
  const TexturedMesh mesh = room(512);
  TexturedFileOptions options;
  options.file_from_scene = glm::dmat3(2);
  CHECK_THROWS_AS(write_textured_obj(folder.path(), mesh, options), std::invalid_argument);
  options = {};
  options.notes.push_back('{');
  CHECK_THROWS_AS(write_textured_gltf(folder.path(), mesh, options), std::invalid_argument);
  options = {};
  options.image.quality = 0;
  CHECK_THROWS_AS(write_textured_gltf(folder.path(), mesh, options), std::invalid_argument);
  CHECK_THROWS_AS(write_textured_gltf(folder / "nowhere", mesh, {}), InputError);
  CHECK_THROWS_AS(write_textured_obj(folder / "nowhere", mesh, {}), InputError);
}

}  // namespace
}  // namespace lumatlas
