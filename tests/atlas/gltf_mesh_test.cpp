// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/gltf_mesh.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

template <typename T>
std::string bytes(std::initializer_list<T> values) {
  std::string result(values.size() * sizeof(T), '\0');
  std::memcpy(result.data(), values.begin(), result.size());
  return result;
}

// One triangle: positions of a stride of 16 bytes, 16-bit indices, and colours as bytes with alpha.
struct Triangle {
  std::string buffer = bytes<float>({0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9}) + bytes<std::uint16_t>({0, 1, 2, 0}) +
                       bytes<std::uint8_t>({255, 0, 0, 255, 0, 55, 0, 255, 0, 0, 128, 255});
  json document = json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
                  {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48, "byteStride": 16}, {"buffer": 0, "byteOffset": 48, "byteLength": 6},
                    {"buffer": 0, "byteOffset": 56, "byteLength": 12}],
    "buffers": [{"uri": "mesh.bin", "byteLength": 68}]})");

  [[nodiscard]] json& primitive() { return document["meshes"][0]["primitives"][0]; }
  [[nodiscard]] TriangleSoup read(const TemporaryFolder& folder) const {
    (void)folder.with_file("mesh.bin", buffer);
    return read_gltf_mesh(folder.with_file("mesh.gltf", document.dump()));
  }
  [[nodiscard]] std::string refusal() const {
    const TemporaryFolder folder;
    try {
      (void)read(folder);
    } catch (const InputError& error) {
      const std::string sentence = error.what(), start = (folder / "mesh.gltf").string() + ": ";
      CHECK_THAT(sentence, Catch::StartsWith(start));
      return sentence.substr(start.size());
    }
    return "taken";
  }
};

TEST_CASE("a triangle with strides, small indices and linear colours is read as it is") {
  const TemporaryFolder folder;
  const TriangleSoup soup = Triangle().read(folder);
  CHECK(soup.positions == std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  CHECK(soup.faces == std::vector<glm::uvec3>{{0, 1, 2}});
  // 55/255 and 128/255 of linear light, IEC 61966-2-1.
  CHECK(soup.colors == std::vector<glm::u8vec3>{{255, 0, 0}, {0, 128, 0}, {0, 0, 188}});
}

TEST_CASE("a .glb holds the same as a .gltf with its buffer beside it") {
  const TemporaryFolder folder;
  Triangle triangle;
  triangle.document["buffers"][0].erase("uri");
  std::string text = triangle.document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto u32 = [](std::size_t value) { return bytes<std::uint32_t>({static_cast<std::uint32_t>(value)}); };
  const std::string chunks =
      u32(text.size()) + "JSON" + text + u32(triangle.buffer.size()) + std::string("BIN\0", 4) + triangle.buffer;
  const TriangleSoup soup =
      read_gltf_mesh(folder.with_file("mesh.glb", "glTF" + u32(2) + u32(12 + chunks.size()) + chunks));
  CHECK(soup.positions == Triangle().read(folder).positions);
  CHECK(soup.colors == Triangle().read(folder).colors);
}

TEST_CASE("nodes put meshes where they are: translation after rotation after scale, parents after children") {
  const TemporaryFolder folder;
  Triangle triangle;
  // A quarter turn about z takes x to y. The second node stands for the same by its matrix, by columns.
  triangle.document["nodes"] = json::parse(R"([
    {"children": [1, 2], "translation": [10, 0, 0]},
    {"mesh": 0, "translation": [0, 0, 7], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476],
     "scale": [2, 3, 1]},
    {"mesh": 0, "matrix": [0, 2, 0, 0,  -3, 0, 0, 0,  0, 0, 1, 0,  0, 0, 7, 1]}, {"mesh": 0}])");
  const TriangleSoup soup = triangle.read(folder);
  REQUIRE(soup.positions.size() == 6);  // the last node is not in the scene
  const std::array<glm::dvec3, 3> expected{{{10, 0, 7}, {10, 2, 7}, {7, 0, 7}}};
  for (std::size_t i = 0; i < 6; ++i) CHECK(glm::distance(soup.positions[i], expected[i % 3]) < 1e-12);
  CHECK(soup.faces == std::vector<glm::uvec3>{{0, 1, 2}, {3, 4, 5}});
  CHECK(soup.colors.size() == 6);
}

TEST_CASE("a node that mirrors turns its faces round, so that outside stays outside") {
  const TemporaryFolder folder;
  Triangle triangle;
  triangle.document["nodes"][0]["scale"] = {-1, 1, 1};
  CHECK(triangle.read(folder).faces == std::vector<glm::uvec3>{{0, 2, 1}});
}

TEST_CASE("strips and fans become triangles, points and lines nothing, and colours must be everywhere") {
  const TemporaryFolder folder;
  Triangle triangle;
  triangle.buffer.replace(48, 8, bytes<std::uint16_t>({0, 1, 2, 0}));
  triangle.document["accessors"][1]["count"] = 4;
  triangle.document["bufferViews"][1]["byteLength"] = 8;
  triangle.primitive()["mode"] = 5;
  CHECK(triangle.read(folder).faces == std::vector<glm::uvec3>{{0, 1, 2}, {1, 0, 2}});
  triangle.primitive()["mode"] = 6;
  CHECK(triangle.read(folder).faces == std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 0}});
  json plain = triangle.primitive();
  plain["mode"] = 4;
  plain["attributes"].erase("COLOR_0");
  plain.erase("indices");
  triangle.document["meshes"][0]["primitives"].push_back(plain);
  plain["mode"] = 1;
  triangle.document["meshes"][0]["primitives"].push_back(plain);
  const TriangleSoup both = triangle.read(folder);
  CHECK(both.faces == std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 0}, {3, 4, 5}});
  CHECK(both.colors.empty());
}

TEST_CASE("colours that a model has beside its texture are read, another program's attribute of that name is not") {
  const TemporaryFolder folder;
  Triangle triangle;
  const TriangleSoup expected = triangle.read(folder);
  json& attributes = triangle.primitive()["attributes"];
  attributes["_COLOR"] = attributes["COLOR_0"];
  attributes.erase("COLOR_0");
  CHECK(triangle.read(folder).colors == expected.colors);
  triangle.document["accessors"][2]["type"] = "SCALAR";
  CHECK(triangle.read(folder).colors.empty());
}

TEST_CASE("what this program does not read is refused by its name") {
  const auto refused = [](const auto& change) {
    Triangle triangle;
    change(triangle);
    return triangle.refusal();
  };
  // Compressed: attributes have no buffer view, and a buffer may have no bytes.
  const auto compressed = [](Triangle& t, const char* extension) {
    t.document["extensionsUsed"] = {extension};
    t.document["extensionsRequired"] = {extension};
    t.document["accessors"][0].erase("bufferView");
    t.document["accessors"][1]["bufferView"] = 7;
    t.document["buffers"].push_back({{"byteLength", 68}});
  };
  CHECK_THAT(refused([&](Triangle& t) { compressed(t, "KHR_draco_mesh_compression"); }),
             Catch::Contains("is compressed by Draco (KHR_draco_mesh_compression), which this program does not read: "
                             "export it without compression"));
  CHECK_THAT(refused([&](Triangle& t) { compressed(t, "EXT_meshopt_compression"); }),
             Catch::Contains("is compressed by meshoptimizer (EXT_meshopt_compression), which this program does not "
                             "read: export it without compression"));
  CHECK_THAT(refused([&](Triangle& t) { compressed(t, "ACME_shape"); }),
             Catch::Contains("requires the extension ACME_shape, which this program does not know"));
  CHECK_THAT(refused([](Triangle& t) { t.document["asset"]["minVersion"] = "2.1"; }),
             Catch::Contains("needs a reader of glTF 2.1, this program reads 2.0"));
  CHECK(refused([](Triangle& t) { t.document["asset"]["minVersion"] = "2.0"; }) == "taken");
  CHECK_THAT(refused([](Triangle& t) {
               t.document["nodes"][0]["extensions"] = {{"KHR_node_visibility", {{"visible", false}}}};
             }),
             Catch::Contains("has no faces"));
  CHECK(refused([](Triangle& t) { t.document["extensionsRequired"] = {"KHR_materials_ior"}; }) == "taken");
  CHECK_THAT(refused([](Triangle& t) {
               t.document["accessors"][0]["sparse"] = json::parse(
                   R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}})");
             }),
             Catch::Contains("accessor 0 is sparse"));
  CHECK_THAT(refused([](Triangle& t) { t.document["accessors"][0].erase("bufferView"); }),
             Catch::Contains("has no buffer view"));
  CHECK_THAT(refused([](Triangle& t) { t.document["nodes"][0]["skin"] = 0; }), Catch::Contains("node 0 has a skin"));
  CHECK_THAT(refused([](Triangle& t) {
               t.primitive()["targets"] = {{{"POSITION", 0}}};
             }),
             Catch::Contains("morph targets"));
}

TEST_CASE("what is damaged is refused with its place") {
  const auto refused = [](const auto& change) {
    Triangle triangle;
    change(triangle);
    return triangle.refusal();
  };
  CHECK(refused([](Triangle& t) { t.buffer[50] = 3; }) ==
        "mesh 0, primitive 0: index 1 is 3, but there are 3 vertices");
  CHECK_THAT(refused([](Triangle& t) { t.document["accessors"][0]["count"] = 4; }), Catch::Contains("reaches beyond"));
  CHECK_THAT(refused([](Triangle& t) { t.document["accessors"][0]["count"] = 4294967296; }),
             Catch::Contains("reaches beyond"));
  CHECK_THAT(refused([](Triangle& t) { t.document["nodes"][0]["children"] = {0}; }),
             Catch::Contains("node 0 hangs on two others"));
  CHECK_THAT(refused([](Triangle& t) { t.document["nodes"][0]["mesh"] = 1; }),
             Catch::Contains("mesh 1 does not exist"));
  CHECK_THAT(refused([](Triangle& t) {
               t.document["nodes"][0]["rotation"] = {0, 0, 0, 0};
             }),
             Catch::Contains("node 0: its rotation"));
  CHECK_THAT(refused([](Triangle& t) { t.primitive()["mode"] = 0; }), Catch::Contains("has no faces"));
  CHECK_THAT(refused([](Triangle& t) { t.document["buffers"][0]["uri"] = "../mesh.bin"; }),
             Catch::Contains("must lie in the model's own folder"));
  CHECK_THAT(refused([](Triangle& t) {  // so many copies of the triangle that a small file would fill the memory
               for (int i = 1; i < 300000; ++i) t.document["nodes"].push_back({{"mesh", 0}});
               t.document.erase("scenes");
               t.document.erase("scene");
             }),
             Catch::Contains("too often"));
}

TEST_CASE("a buffer behind a link that leads elsewhere is not opened") {
  const TemporaryFolder folder, elsewhere;
  const Triangle triangle;
  (void)elsewhere.with_file("mesh.bin", triangle.buffer);
  fs::create_symlink(elsewhere / "mesh.bin", folder / "mesh.bin");
  CHECK_THROWS_WITH(read_gltf_mesh(folder.with_file("mesh.gltf", triangle.document.dump())),
                    Catch::Contains("a link that leads out"));
}

}  // namespace
}  // namespace lumatlas
