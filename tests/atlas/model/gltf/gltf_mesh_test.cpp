// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/gltf_mesh.h"

#include <meshoptimizer.h>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/model/gltf/meshopt_compression.h"
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
  CHECK_THAT(refused([&](Triangle& t) { compressed(t, "KHR_meshopt_compression"); }),
             Catch::Contains("is compressed by meshoptimizer (KHR_meshopt_compression), which this program does not "
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

// The triangle of Triangle with its positions and indices compressed, colours as they were.
class MeshoptTriangle : public Triangle {
 public:
  // Filtered: positions by exponents, and indices one by one instead of by triangles.
  explicit MeshoptTriangle(bool filtered = false) {
    std::vector<float> points{0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9};
    if (filtered) meshopt_encodeFilterExp(points.data(), 3, 16, 24, std::vector<float>(points).data());
    std::string attributes(meshopt_encodeVertexBufferBound(3, 16), '\0');
    attributes.resize(meshopt_encodeVertexBuffer(bytes_of(attributes), attributes.size(), points.data(), 3, 16));
    const std::vector<unsigned> corners{0, 1, 2};
    std::string indices(256, '\0');
    unsigned char* const first = bytes_of(indices);
    indices.resize(filtered ? meshopt_encodeIndexSequence(first, indices.size(), corners.data(), 3)
                            : meshopt_encodeIndexBuffer(first, indices.size(), corners.data(), 3));
    const std::size_t start = buffer.size();
    buffer += attributes + indices;
    document["buffers"][0]["byteLength"] = buffer.size();
    document["buffers"].push_back({{"byteLength", 54}, {"extensions", {{kExtension, {{"fallback", true}}}}}});
    document["extensionsUsed"] = {kExtension};
    document["extensionsRequired"] = {kExtension};
    compress(0, {{"byteOffset", start}, {"byteLength", attributes.size()}, {"byteStride", 16}, {"mode", "ATTRIBUTES"}});
    compress(1, {{"byteOffset", start + attributes.size()},
                 {"byteLength", indices.size()},
                 {"byteStride", 2},
                 {"mode", filtered ? "INDICES" : "TRIANGLES"}});
    if (filtered) compression(0)["filter"] = "EXPONENTIAL";
  }

  [[nodiscard]] json& compression(std::size_t view) { return document["bufferViews"][view]["extensions"][kExtension]; }

  static constexpr const char* kExtension = "EXT_meshopt_compression";

 private:
  static unsigned char* bytes_of(std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); }

  void compress(std::size_t view, json compression) {
    document["bufferViews"][view]["buffer"] = 1;
    document["bufferViews"][view]["byteOffset"] = 0;
    compression["buffer"] = 0;
    compression["count"] = 3;
    document["bufferViews"][view]["extensions"] = {{kExtension, compression}};
  }
};

TEST_CASE("what EXT_meshopt_compression compressed is decoded") {
  const TemporaryFolder folder;
  const TriangleSoup expected = Triangle().read(folder);
  MeshoptTriangle triangle;
  const TriangleSoup soup = triangle.read(folder);
  CHECK(soup.positions == expected.positions);
  CHECK(soup.colors == expected.colors);
  CHECK(soup.faces == expected.faces);
  CHECK(MeshoptTriangle(true).read(folder).positions == expected.positions);
  CHECK(MeshoptTriangle(true).read(folder).faces == expected.faces);
  // The stride may be said by the compression alone.
  triangle.document["bufferViews"][0].erase("byteStride");
  CHECK(triangle.read(folder).positions == expected.positions);
  // Bytes that the file has are read as they are.
  triangle.document["buffers"][1]["uri"] = "data:application/octet-stream;base64," + std::string(72, 'A');
  triangle.document["buffers"][1].erase("extensions");
  CHECK(triangle.read(folder).positions == std::vector<glm::dvec3>(3));
}

TEST_CASE("filters of compressed views give unit vectors and quaternions back within their bits") {
  const auto round_trip = [](std::vector<std::int16_t> encoded, MeshoptFilter filter) {
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(2, 8));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), encoded.data(), 2, 8));
    const auto bytes = decoded({MeshoptMode::attributes, filter, 2, 8}, packed);
    REQUIRE(bytes);
    std::vector<double> values;
    for (std::size_t i = 0; i < 8; ++i) {
      std::int16_t value = 0;
      std::memcpy(&value, bytes->data() + 2 * i, 2);
      values.push_back(value / 32767.0);
    }
    return values;
  };
  const std::vector<float> vectors{0.6F, 0, 0.8F, 0, -0.48F, 0.6F, -0.64F, 0},
      turns{0.5F, 0.5F, -0.5F, 0.5F, 0, 0, 0.6F, 0.8F};
  std::vector<std::int16_t> encoded(8);
  const auto check_close = [](const std::vector<double>& values, const std::vector<float>& expected,
                              std::size_t parts) {
    for (std::size_t i = 0; i < 8; ++i) {
      if (i % 4 < parts) CHECK(std::abs(values[i] - static_cast<double>(expected[i])) < 1e-3);
    }
  };
  meshopt_encodeFilterOct(encoded.data(), 2, 8, 12, vectors.data());
  check_close(round_trip(encoded, MeshoptFilter::octahedral), vectors, 3);
  meshopt_encodeFilterQuat(encoded.data(), 2, 8, 12, turns.data());
  check_close(round_trip(encoded, MeshoptFilter::quaternion), turns, 4);
}

TEST_CASE("compressed views that are damaged are refused with their place") {
  const auto refused = [](const auto& change) {
    MeshoptTriangle triangle;
    change(triangle);
    return triangle.refusal();
  };
  const std::string first = "buffer view 0: EXT_meshopt_compression", second = "buffer view 1: EXT_meshopt_compression";
  const auto set = [&](std::size_t view, const char* name, const json& value) {
    return refused([&](MeshoptTriangle& t) { t.compression(view)[name] = value; });
  };
  CHECK(set(0, "mode", "POINTS") == first + " has the mode 'POINTS', which is not known");
  CHECK(set(0, "filter", "COLOR") == first + " has the filter 'COLOR', which is not known");
  CHECK(set(0, "buffer", 2) == first + " is of buffer 2, which does not exist");
  CHECK_THAT(set(0, "buffer", 1), Catch::Contains(first + " reaches beyond its buffer of 4 bytes"));
  CHECK_THAT(set(0, "byteLength", 2147483647), Catch::Contains(first + " reaches beyond its buffer of"));
  CHECK_THAT(set(0, "byteOffset", 2147483647), Catch::Contains(first + " reaches beyond its buffer of"));
  CHECK(set(0, "count", 4) ==
        first + " holds 4 elements of 16 bytes, but the buffer view has 48 bytes with a stride of 16");
  CHECK(set(0, "byteStride", 12) ==
        first + " holds 3 elements of 12 bytes, but the buffer view has 48 bytes with a stride of 16");
  CHECK(set(0, "byteLength", 20) == first + ": its bytes cannot be decoded: they are damaged, or of a later version");
  CHECK(set(0, "filter", "QUATERNION") == first + ": its stride is 16, must be 8");
  CHECK(set(1, "filter", "OCTAHEDRAL") == second + ": its indices have a filter, which only attributes may have");
  CHECK(refused([&](MeshoptTriangle& t) { t.compression(0).erase("count"); }) == first + " has no \"count\"");
  CHECK_THAT(refused([&](MeshoptTriangle& t) {
               t.compression(0)["count"] = 100000000;
               t.document["bufferViews"][0]["byteLength"] = 1600000000;
             }),
             Catch::Contains(first + ": its count is 100000000, too many for"));
  CHECK_THAT(refused([&](MeshoptTriangle& t) {  // each may decode to 64 times its bytes, but they share these
               const std::string zeros(256 * 64, '\0');
               std::string packed(meshopt_encodeVertexBufferBound(1024, 16), '\0');
               packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()), packed.size(),
                                                        zeros.data(), 1024, 16));
               json view = t.document["bufferViews"][0];
               view["byteLength"] = 16384;
               view["extensions"][t.kExtension]["byteOffset"] = t.buffer.size();
               view["extensions"][t.kExtension]["byteLength"] = packed.size();
               view["extensions"][t.kExtension]["count"] = 1024;
               t.buffer += packed;
               t.document["buffers"][0]["byteLength"] = t.buffer.size();
               for (int i = 0; i < 10; ++i) t.document["bufferViews"].push_back(view);
             }),
             Catch::Contains("its compressed buffer views hold more than its buffers can"));
  // A view of such a buffer that is not compressed has no bytes.
  CHECK_THAT(refused([&](MeshoptTriangle& t) { t.document["bufferViews"][0].erase("extensions"); }),
             Catch::Contains("reaches beyond its buffer of 4 bytes"));
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
