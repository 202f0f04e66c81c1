// SPDX-License-Identifier: GPL-3.0-or-later
// Models with one thing wrong, each with the sentence that it gets.
#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A good model on disk, to be damaged.
class DamagedModel {
 public:
  explicit DamagedModel(Snapshot good = small_snapshot(), bool textured = false) {
    good.cell_coverage.assign(good.cell_seen.size(), 0.5f);
    good.cell_deviation.assign(good.cell_seen.size(), 0.25f);
    const BaseTexture texture = small_texture(*good.surface);
    write_model(folder_.path(), good, {}, {.texture = textured ? &texture : nullptr});
    make_one_gltf(folder_.path());
    gltf_ = json::parse(bytes_of(file()));
  }

  [[nodiscard]] fs::path file() const { return folder_ / "scene.gltf"; }
  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] json& gltf() { return gltf_; }
  [[nodiscard]] json& lumigraph() { return gltf_["extensions"]["LUMATLAS_lumigraph"]; }
  [[nodiscard]] json& view(std::size_t index) { return lumigraph()["views"][index]; }
  [[nodiscard]] json& primitive() { return gltf_["meshes"][0]["primitives"][0]; }
  [[nodiscard]] json& accessor(const json& index) { return gltf_["accessors"][index.get<std::size_t>()]; }
  [[nodiscard]] json& view_of(const json& index) {
    return gltf_["bufferViews"][accessor(index)["bufferView"].get<std::size_t>()];
  }

  // Overwrites value number `index` of an accessor in the buffer.
  template <typename T>
  void poke(const json& of_accessor, std::size_t index, T value) {
    std::string bytes = bytes_of(folder_ / "scene.bin");
    const std::size_t at = view_of(of_accessor).value("byteOffset", std::size_t{0}) + index * sizeof(T);
    REQUIRE(at + sizeof(T) <= bytes.size());
    std::memcpy(&bytes[at], &value, sizeof(T));
    (void)folder_.with_file("scene.bin", bytes);
  }
  void replace(const std::string& name, const std::string& bytes) const { (void)folder_.with_file(name, bytes); }

  // Returns the reader's message, without the path of the glTF file or the folder before it.
  [[nodiscard]] std::string sentence() {
    replace("scene.gltf", gltf_.dump());
    return sentence_as_it_is();
  }
  [[nodiscard]] std::string sentence_as_it_is() const {
    try {
      (void)read_model(file());
    } catch (const InputError& error) {
      std::string text = error.what();
      CHECK(text.find('\n') == std::string::npos);
      for (const std::string& start : {file().string() + ": ", folder().string() + "/"}) {
        if (text.starts_with(start)) return text.substr(start.size());
      }
      return text;
    }
    return "accepted";
  }

 private:
  TemporaryFolder folder_;
  json gltf_;
};

struct Case {
  const char* what;
  std::function<void(DamagedModel&)> damage;
  std::string sentence;
};

void check_all(const std::vector<Case>& cases, const Snapshot& good = small_snapshot(), bool textured = false) {
  for (const Case& damaged : cases) {
    DamagedModel model(good, textured);
    damaged.damage(model);
    CAPTURE(damaged.what);
    CHECK(model.sentence() == damaged.sentence);
  }
}

constexpr double kHuge = 1e300;

TEST_CASE("the good model is accepted") {
  DamagedModel model, textured(small_snapshot(), true);
  CHECK(model.sentence() == "accepted");
  CHECK(textured.sentence() == "accepted");
}

TEST_CASE("a path without a model is refused") {
  const TemporaryFolder folder;
  const std::string advice = ": no such file: give a folder or a .glb that `lumatlas build` wrote";
  CHECK_THROWS_WITH(read_model(folder / "missing"), (folder / "missing").string() + advice);
  CHECK_THROWS_WITH(read_model(folder.path()), (folder / "tileset.json").string() + advice);
}

TEST_CASE("a file that is no glTF is refused") {
  DamagedModel model;
  const auto sentence_for = [&](const std::string& text) {
    model.replace("scene.gltf", text);
    return model.sentence_as_it_is();
  };
  const std::string no_gltf = "is no glTF 2.0 file that can be read: ";
  CHECK(sentence_for("") == "is empty");
  CHECK(sentence_for("{") == no_gltf + "JSON string too short.");
  CHECK(sentence_for("[1,2,3]") == no_gltf + "Root element is not a JSON object");
  CHECK(sentence_for("{\"asset\": 3}") == no_gltf + "\"asset\" object not found in .gltf or not an object type");
  CHECK_THAT(sentence_for("hello, world"), Catch::StartsWith(no_gltf + "[json.exception.parse_error.101] "));
  CHECK_THAT(sentence_for("{\"asset\": \"\xff\xfe\"}"), Catch::StartsWith(no_gltf));
  CHECK(sentence_for(std::string("{\"a\": \"") + std::string(5'000'000, 'x')).size() < 1100);
}

TEST_CASE("a model's JSON is not handed on if it is nested without end") {
  const TemporaryFolder folder;
  std::string deep = "{\"asset\":";
  deep.append(100'000, '[').append(100'000, ']').append("}");
  const fs::path file = folder.with_file("scene.gltf", deep);
  CHECK_THROWS_WITH(read_model_json(file), file.string() + ": nests its values 100001 deep, must be at most 64");
}

TEST_CASE("a tileset that is damaged, or names what is not its own, is refused in one sentence") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {});
  const fs::path file = folder / "tileset.json";
  const json good = json::parse(bytes_of(file));
  const auto sentence_of_text = [&](const std::string& text) -> std::string {
    (void)folder.with_file("tileset.json", text);
    try {
      (void)read_model(folder.path());
    } catch (const InputError& error) {
      const std::string said = error.what();
      return said.starts_with(file.string() + ": ") ? said.substr(file.string().size() + 2) : said;
    }
    return "accepted";
  };
  const auto sentence = [&](const std::string& place, const json& value) {
    json damaged = good;
    damaged[json::json_pointer(place)] = value;
    return sentence_of_text(damaged.dump());
  };
  const std::string lumigraph = "/extensions/LUMATLAS_lumigraph", elsewhere = "must lie in the model's own folder";
  CHECK(sentence("/asset/version", "1.0") == "accepted");
  CHECK(sentence("/asset/version", "2.0") == "is of 3D Tiles version '2.0', this program reads 1.1");
  CHECK(sentence("/root/children", {1, 2}) == "a tile is not an object");
  CHECK(sentence("/root/content", 3) == "\"content\" is not an object");
  CHECK(sentence("/root/content/uri", "../a.glb") == "its surface has the path \"../a.glb\", " + elsewhere);
  CHECK(sentence("/root/content/uri", "/dev/zero") == "its surface has the path \"/dev/zero\", " + elsewhere);
  CHECK(sentence(lumigraph, 3) == "LUMATLAS_lumigraph is not an object");
  CHECK(sentence(lumigraph + "/version", 4) ==
        "has version 4 of LUMATLAS_lumigraph: it was made by an older lumatlas, build it again");
  CHECK(sentence(lumigraph + "/images/0/uri", "%2e%2e/a.png") == "image 0 has the path \"../a.png\", " + elsewhere);
  CHECK(sentence(lumigraph + "/images/0/uri", "data:,") == "image 0 is a data URI, must be a file or in a buffer");
  CHECK(sentence(lumigraph + "/images", 7) == "\"images\" is not an array");
  CHECK(sentence(lumigraph + "/views/0/mask", 99) == "image 99 does not exist");
  CHECK(sentence_of_text("") == "is empty");
  CHECK_THAT(sentence_of_text("[1"), Catch::StartsWith("is no JSON that can be read: "));
  CHECK(sentence_of_text("[1]") == "it is not an object");
  CHECK(sentence_of_text(std::string(1000, '[') + std::string(1000, ']')) ==
        "nests its values 1000 deep, must be at most 64");
  const std::string text = good.dump();
  for (std::size_t length = 0; length + 2 < text.size(); length += 13) {
    CHECK(sentence_of_text(text.substr(0, length)) != "accepted");
  }
  fs::remove(file);
  (void)folder.with_file("scene.gltf", "{}");
  CHECK_THROWS_WITH(read_model(folder.path()),
                    folder.path().string() + ": is a model that an older lumatlas made, build it again");
}

TEST_CASE("a damaged file of views is refused by its name") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {}, {.listed_views = 1});
  const json tileset = json::parse(bytes_of(folder / "tileset.json"));
  const auto sentence = [&] {
    try {
      (void)read_model(folder.path());
    } catch (const InputError& error) {
      const std::string said = error.what(), start = folder.path().string() + "/";
      return said.starts_with(start) ? said.substr(start.size()) : said;
    }
    return std::string("accepted");
  };
  CHECK(sentence() == "accepted");
  const std::string name = tileset["extensions"]["LUMATLAS_lumigraph"]["viewFile"]["uri"];
  const std::string good = bytes_of(folder / name);
  const auto with_text = [&](const std::string& text) {
    (void)folder.with_file(name, text);
    return sentence();
  };
  const auto with = [&](const std::string& place, const json& value) {
    json damaged = json::parse(good);
    damaged[json::json_pointer(place)] = value;
    return with_text(damaged.dump());
  };
  CHECK(with("/views/1/image", 99) == name + ": image 99 does not exist");
  CHECK(with("/views/1/width", 0) == name + ": view 1: \"width\" is 0, must be in [1, 65536]");
  CHECK(with("/views", 3) == name + ": \"views\" is not an array");
  CHECK(with("/images/0/uri", "../a.png") ==
        name + ": image 0 has the path \"../a.png\", must lie in the model's own folder");
  CHECK(with_text("[]") == name + ": is no object that lists \"views\"");
  CHECK(with_text("") == name + ": is empty");
  CHECK(with_text("{}") != "accepted");  // the chunks refer to views
  CHECK(with_text(std::string(1000, '[') + std::string(1000, ']')) ==
        name + ": nests its values 1000 deep, must be at most 64");
  for (std::size_t length = 0; length + 2 < good.size(); length += 13) {
    CHECK(with_text(good.substr(0, length)) != "accepted");
  }
  fs::remove(folder / name);
  CHECK(sentence() == name + ": no such file");

  const auto with_uri = [&](const std::string& uri) {
    json damaged = tileset;
    damaged["extensions"]["LUMATLAS_lumigraph"]["viewFile"]["uri"] = uri;
    (void)folder.with_file("tileset.json", damaged.dump());
    return sentence();
  };
  const std::string must = ", must be the name of a file beside it";
  CHECK(with_uri("../views.json") == "tileset.json: \"viewFile\" is '../views.json'" + must);
  CHECK(with_uri("/dev/zero") == "tileset.json: \"viewFile\" is '/dev/zero'" + must);
  CHECK(with_uri("") == "tileset.json: \"viewFile\" is ''" + must);
}

TEST_CASE("links that lead out of a model's folder are not followed, others are") {
  const TemporaryFolder elsewhere;
  DamagedModel model;
  const fs::path image = model.folder() / "images/00000.png", buffer = model.folder() / "scene.bin";
  fs::rename(image, model.folder() / "images/here.png");
  fs::create_symlink("here.png", image);
  CHECK(model.sentence() == "accepted");
  fs::copy(image, elsewhere / "there.png");
  fs::remove(image);
  fs::create_symlink(elsewhere / "there.png", image);
  CHECK(model.sentence() == "image 0, images/00000.png, is a link that leads out of the model's own folder");
  fs::remove(image);
  fs::rename(model.folder() / "images/here.png", image);
  fs::rename(model.folder() / "images", elsewhere / "images");
  fs::create_directory_symlink(elsewhere / "images", model.folder() / "images");
  CHECK(model.sentence() == "image 0, images/00000.png, is a link that leads out of the model's own folder");
  fs::remove(model.folder() / "images");
  fs::rename(elsewhere / "images", model.folder() / "images");
  fs::rename(buffer, elsewhere / "scene.bin");
  fs::create_symlink(elsewhere / "scene.bin", buffer);
  CHECK(model.sentence() == "its buffer scene.bin is a link that leads out of the model's own folder");
}

TEST_CASE("JSON nested without end does not end the stack") {
  DamagedModel model;
  constexpr std::size_t kDepth = 1'000'000;
  const std::string arrays = std::string(kDepth, '[') + std::string(kDepth, ']');
  std::string objects;
  for (std::size_t level = 0; level < kDepth; ++level) objects += "{\"a\":";
  objects += '1';
  objects.append(kDepth, '}');
  const std::string& value = GENERATE(true, false) ? arrays : objects;
  model.replace("scene.gltf", "{\"asset\": {\"version\": \"2.0\", \"extras\": " + value + "}}");
  CHECK(model.sentence_as_it_is() == "nests its values 1000002 deep, must be at most 64");
}

TEST_CASE("brackets in strings are no nesting") {
  DamagedModel model;
  model.gltf()["asset"]["copyright"] = std::string(500, '[') + "\\\"" + std::string(500, '{');
  CHECK(model.sentence() == "accepted");
}

TEST_CASE("a glTF file that is not a model of this program is refused") {
  check_all({
      {"no extensions", [](DamagedModel& m) { m.gltf().erase("extensions"); },
       "has no extension LUMATLAS_lumigraph: it is a mesh without photographs"},
      {"another extension",
       [](DamagedModel& m) {
         m.gltf()["extensions"] = {{"EXT_other", {{"version", 1}}}};
       },
       "has no extension LUMATLAS_lumigraph: it is a mesh without photographs"},
      {"the extension is a number", [](DamagedModel& m) { m.lumigraph() = 3; },
       "has no extension LUMATLAS_lumigraph: it is a mesh without photographs"},
      {"an empty extension", [](DamagedModel& m) { m.lumigraph() = json::object(); },
       "LUMATLAS_lumigraph has no \"version\""},
      {"a later version", [](DamagedModel& m) { m.lumigraph()["version"] = 6; },
       "has version 6 of LUMATLAS_lumigraph, this program reads version 5"},
      {"an earlier version", [](DamagedModel& m) { m.lumigraph()["version"] = 4; },
       "has version 4 of LUMATLAS_lumigraph: it was made by an older lumatlas, build it again"},
      {"version 0", [](DamagedModel& m) { m.lumigraph()["version"] = 0; },
       "has version 0 of LUMATLAS_lumigraph: it was made by an older lumatlas, build it again"},
      {"a fraction of a version", [](DamagedModel& m) { m.lumigraph()["version"] = 1.5; },
       "LUMATLAS_lumigraph: \"version\" is 1.5, must be a whole number"},
      {"a version in words", [](DamagedModel& m) { m.lumigraph()["version"] = "1"; },
       "LUMATLAS_lumigraph: \"version\" is not a number"},
      {"glTF 1", [](DamagedModel& m) { m.gltf()["asset"]["version"] = "1.0"; },
       "is of glTF version 1.0, this program reads 2.0"},
      {"a required extension", [](DamagedModel& m) { m.gltf()["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
       "is compressed by Draco (KHR_draco_mesh_compression), which this program does not read: export it without "
       "compression"},
      {"a sentence on two lines", [](DamagedModel& m) { m.gltf()["asset"]["version"] = "3\n\x1b[31m"; },
       "is of glTF version 3  [31m, this program reads 2.0"},
  });
}

TEST_CASE("the extensions that a model uses may be required") {
  DamagedModel model;
  model.gltf()["extensionsRequired"] = model.gltf()["extensionsUsed"];
  CHECK(model.sentence() == "accepted");
}

TEST_CASE("a buffer that is not there or not whole is refused") {
  DamagedModel model;
  const std::string bytes = bytes_of(model.folder() / "scene.bin");
  SECTION("missing") {
    fs::remove(model.folder() / "scene.bin");
    CHECK(model.sentence() == "scene.bin: no such file");
  }
  SECTION("empty") {
    model.replace("scene.bin", "");
    CHECK(model.sentence() == "scene.bin: is empty");
  }
  SECTION("a folder") {
    fs::remove(model.folder() / "scene.bin");
    fs::create_directory(model.folder() / "scene.bin");
    CHECK(model.sentence() == "scene.bin: is not a file");
  }
  SECTION("cut off") {
    model.replace("scene.bin", bytes.substr(0, 100));
    CHECK(model.sentence() ==
          "is no glTF 2.0 file that can be read: File size mismatch : " + (model.folder() / "scene.bin").string() +
              ", requestedBytes " + std::to_string(bytes.size()) + ", but got 100");
  }
  SECTION("a huge claim") {
    model.gltf()["buffers"][0]["byteLength"] = 1'000'000'000'000'000;
    CHECK_THAT(model.sentence(), Catch::Contains("requestedBytes 1000000000000000, but got"));
  }
  SECTION("cut off, and the claim with it") {
    model.replace("scene.bin", bytes.substr(0, 100));
    model.gltf()["buffers"][0]["byteLength"] = 100;
    CHECK(model.sentence() == "POSITION: buffer view 0 reaches beyond its buffer of 100 bytes");
  }
  SECTION("none") {
    model.gltf().erase("buffers");
    CHECK(model.sentence() == "POSITION: buffer view 0 is of buffer 0, which does not exist");
  }
  SECTION("the same one again and again") {
    for (int i = 0; i < 1000; ++i) model.gltf()["buffers"].push_back(json(model.gltf()["buffers"][0]));
    CHECK(model.sentence() == "has two buffers with the path \"" + (model.folder() / "scene.bin").string() + "\"");
  }
}

TEST_CASE("nothing outside of the model's folder is opened") {
  // The files exist, so that a reader that follows the paths finds them.
  DamagedModel model;
  const TemporaryFolder outside;
  const fs::path secret = outside.with_file("secret.bin", bytes_of(model.folder() / "scene.bin"));
  fs::copy_file(model.folder() / "images/00000.png", outside / "secret.png");
  const std::string climb = "../" + outside.path().filename().string() + "/";
  const auto buffer_sentence = [&](const std::string& uri) {
    model.gltf()["buffers"][0]["uri"] = uri;
    return model.sentence();
  };
  const auto image_sentence = [&](const std::string& uri) {
    model.gltf()["images"][0]["uri"] = uri;
    return model.sentence();
  };
  const auto refused = [](const std::string& what, const std::string& path) {
    return what + " has the path \"" + path + "\", must lie in the model's own folder";
  };
  SECTION("a buffer") {
    CHECK(buffer_sentence(secret.string()) == refused("its buffer", secret.string()));
    CHECK(buffer_sentence(climb + "secret.bin") == refused("its buffer", climb + "secret.bin"));
    CHECK(buffer_sentence("images/../" + climb + "secret.bin") ==
          refused("its buffer", "images/../" + climb + "secret.bin"));
    CHECK(buffer_sentence("%2e%2E/" + climb.substr(3) + "secret.bin") == refused("its buffer", climb + "secret.bin"));
    CHECK(buffer_sentence("%2fetc/passwd") == refused("its buffer", "/etc/passwd"));
    CHECK(buffer_sentence("") == refused("its buffer", ""));
    CHECK(buffer_sentence("a\nb.bin") == refused("its buffer", "a b.bin"));
    CHECK(buffer_sentence("https://example.org/scene.bin") == "https:/example.org/scene.bin: no such file");
  }
  SECTION("an image") {
    CHECK(image_sentence((outside / "secret.png").string()) == refused("image 0", (outside / "secret.png").string()));
    CHECK(image_sentence(climb + "secret.png") == refused("image 0", climb + "secret.png"));
    CHECK(image_sentence("%2e%2e/" + climb.substr(3) + "secret.png") == refused("image 0", climb + "secret.png"));
    CHECK(image_sentence("images/00000.png\n") == refused("image 0", "images/00000.png "));
    CHECK(image_sentence(std::string("images/00000.png\0.jpg", 21)) == refused("image 0", "images/00000.png .jpg"));
    CHECK(image_sentence("") == refused("image 0", ""));
  }
}

TEST_CASE("a buffer is not looked for in the working directory") {
  DamagedModel model;
  const TemporaryFolder elsewhere;
  fs::rename(model.folder() / "scene.bin", elsewhere / "scene.bin");
  const fs::path before = fs::current_path();
  fs::current_path(elsewhere.path());
  const std::string sentence = model.sentence();
  fs::current_path(before);
  CHECK(sentence == "scene.bin: no such file");
}

TEST_CASE("a percent-encoded path is decoded") {
  DamagedModel model;
  fs::rename(model.folder() / "images/00000.png", model.folder() / "images/a %41+.png");
  fs::rename(model.folder() / "scene.bin", model.folder() / "the scene.bin");
  model.gltf()["images"][0]["uri"] = "images/a%20%2541+.png";
  model.gltf()["buffers"][0]["uri"] = "the%20scene.bin";
  CHECK(model.sentence() == "accepted");
}

TEST_CASE("accessors that do not fit are refused") {
  const auto positions = [](DamagedModel& m) -> json& { return m.accessor(m.primitive()["attributes"]["POSITION"]); };
  const auto indices = [](DamagedModel& m) -> json& { return m.accessor(m.primitive()["indices"]); };
  check_all({
      {"a huge count", [&](DamagedModel& m) { positions(m)["count"] = 4'000'000'000'000; },
       "POSITION: accessor 0 reaches beyond its buffer view of 588 bytes"},
      {"a count whose bytes overflow",
       [&](DamagedModel& m) { positions(m)["count"] = std::numeric_limits<std::uint64_t>::max(); },
       "POSITION: accessor 0 reaches beyond its buffer view of 588 bytes"},
      {"an offset too far", [&](DamagedModel& m) { positions(m)["byteOffset"] = 12; },
       "POSITION: accessor 0 reaches beyond its buffer view of 588 bytes"},
      {"an offset that overflows",
       [&](DamagedModel& m) { positions(m)["byteOffset"] = std::numeric_limits<std::uint64_t>::max() - 3; },
       "POSITION: accessor 0 reaches beyond its buffer view of 588 bytes"},
      {"a view whose end overflows",
       [](DamagedModel& m) {
         m.gltf()["bufferViews"][0]["byteOffset"] = std::numeric_limits<std::uint64_t>::max() - 7;
       },
       "POSITION: buffer view 0 reaches beyond its buffer of 1684 bytes"},
      {"a huge view", [](DamagedModel& m) { m.gltf()["bufferViews"][0]["byteLength"] = 1'000'000'000'000; },
       "POSITION: buffer view 0 reaches beyond its buffer of 1684 bytes"},
      {"a stride", [](DamagedModel& m) { m.gltf()["bufferViews"][0]["byteStride"] = 16; },
       "POSITION: buffer view 0 has a stride, must be packed"},
      {"no buffer view", [&](DamagedModel& m) { positions(m).erase("bufferView"); },
       "POSITION: buffer view -1 does not exist"},
      {"a buffer view too many", [&](DamagedModel& m) { positions(m)["bufferView"] = 77; },
       "POSITION: buffer view 77 does not exist"},
      {"another buffer", [](DamagedModel& m) { m.gltf()["bufferViews"][0]["buffer"] = 1; },
       "POSITION: buffer view 0 is of buffer 1, which does not exist"},
      {"a negative buffer", [](DamagedModel& m) { m.gltf()["bufferViews"][0]["buffer"] = -1; },
       "POSITION: buffer view 0 is of buffer -1, which does not exist"},
      {"another component", [&](DamagedModel& m) { positions(m)["componentType"] = 5125; },
       "POSITION: accessor 0 has another type than this program writes"},
      {"another type", [&](DamagedModel& m) { positions(m)["type"] = "VEC4"; },
       "POSITION: accessor 0 has another type than this program writes"},
      {"no such component", [&](DamagedModel& m) { positions(m)["componentType"] = 99; },
       "is no glTF 2.0 file that can be read: Invalid `componentType` in accessor. Got 99"},
      {"an accessor too many", [](DamagedModel& m) { m.primitive()["attributes"]["POSITION"] = 99; },
       "POSITION: accessor 99 does not exist"},
      {"a negative accessor", [](DamagedModel& m) { m.primitive()["attributes"]["COLOR_0"] = -5; },
       "COLOR_0: accessor -5 does not exist"},
      {"no indices", [](DamagedModel& m) { m.primitive().erase("indices"); }, "indices: accessor -1 does not exist"},
      {"indices not in triples", [&](DamagedModel& m) { indices(m)["count"] = 100; },
       "indices: accessor 2 has 100 elements, must have a multiple of 3"},
      {"no indices at all", [&](DamagedModel& m) { indices(m)["count"] = 0; }, "its mesh has no faces"},
      {"no accessors", [](DamagedModel& m) { m.gltf().erase("accessors"); },
       "is no glTF 2.0 file that can be read: primitive indices accessor out of bounds"},
  });
}

TEST_CASE("a mesh that is not there or not usable is refused") {
  const auto positions = [](DamagedModel& m) { return json(m.primitive()["attributes"]["POSITION"]); };
  check_all({
      {"no meshes", [](DamagedModel& m) { m.gltf().erase("meshes"); }, "holds no mesh"},
      {"no primitives", [](DamagedModel& m) { m.gltf()["meshes"][0]["primitives"] = json::array(); }, "holds no mesh"},
      {"lines", [](DamagedModel& m) { m.primitive()["mode"] = 1; },
       "its mesh has mode 1, must be a list of triangles, mode 4"},
      {"no positions", [](DamagedModel& m) { m.primitive()["attributes"].erase("POSITION"); },
       "its mesh has no POSITION"},
      {"no colours", [](DamagedModel& m) { m.primitive()["attributes"].erase("COLOR_0"); }, "its mesh has no COLOR_0"},
      {"a vertex too many", [](DamagedModel& m) { m.poke<std::uint32_t>(m.primitive()["indices"], 3 * 5 + 1, 49); },
       "face 5 has the vertex 49 of 49"},
      {"the largest vertex", [](DamagedModel& m) { m.poke<std::uint32_t>(m.primitive()["indices"], 0, 0xffffffffu); },
       "face 0 has the vertex 4294967295 of 49"},
      {"NaN", [&](DamagedModel& m) { m.poke<float>(positions(m), 3 * 7 + 2, std::nanf("")); },
       "vertex 7 has a coordinate that is not finite"},
      {"infinity", [&](DamagedModel& m) { m.poke<float>(positions(m), 3, -std::numeric_limits<float>::infinity()); },
       "vertex 1 has a coordinate that is not finite"},
      {"fewer colours", [](DamagedModel& m) { m.accessor(m.primitive()["attributes"]["COLOR_0"])["count"] = 28; },
       "COLOR_0 has 28 colours for 49 vertices"},
      {"no vertices", [&](DamagedModel& m) { m.accessor(positions(m))["count"] = 0; }, "face 0 has the vertex 0 of 0"},
  });
}

TEST_CASE("a base texture that is not there or does not fit is refused") {
  const auto attribute = [](const char* name) {
    return [=](DamagedModel& m) -> json& { return m.primitive()["attributes"][name]; };
  };
  const auto colors = attribute("_COLOR"), places = attribute("TEXCOORD_0");
  const auto reference = [](DamagedModel& m) -> json& {
    return m.gltf()["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  };
  const auto copies = [](DamagedModel& m) { return json(m.lumigraph()["vertexCopies"]); };
  const std::size_t all = [&] {
    DamagedModel model(small_snapshot(), true);
    return model.accessor(colors(model))["count"].get<std::size_t>();
  }();
  const std::string vertices = std::to_string(all);
  REQUIRE(all > 49);
  check_all(
      {
          {"no colours", [](DamagedModel& m) { m.primitive()["attributes"].erase("_COLOR"); },
           "its mesh has no _COLOR"},
          {"fewer colours", [=](DamagedModel& m) { m.accessor(colors(m))["count"] = 28; },
           "_COLOR has 28 colours for " + vertices + " vertices"},
          {"no places", [](DamagedModel& m) { m.primitive()["attributes"].erase("TEXCOORD_0"); },
           "its mesh has no TEXCOORD_0"},
          {"fewer places", [=](DamagedModel& m) { m.accessor(places(m))["count"] = 28; },
           "TEXCOORD_0 has 28 places for " + vertices + " vertices"},
          {"places in space", [=](DamagedModel& m) { places(m) = 0; },
           "TEXCOORD_0: accessor 0 has another type than this program writes"},
          {"no material", [](DamagedModel& m) { m.primitive().erase("material"); },
           "its mesh has material -1, which does not exist"},
          {"a material too many", [](DamagedModel& m) { m.primitive()["material"] = 1; },
           "its mesh has material 1, which does not exist"},
          {"no texture", [=](DamagedModel& m) { m.gltf()["materials"][0].erase("pbrMetallicRoughness"); },
           "its material has the base texture -1, which does not exist"},
          {"a texture too many", [=](DamagedModel& m) { reference(m)["index"] = 1; },
           "its material has the base texture 1, which does not exist"},
          {"no textures", [](DamagedModel& m) { m.gltf().erase("textures"); },
           "its material has the base texture 0, which does not exist"},
          {"by other places", [=](DamagedModel& m) { reference(m)["texCoord"] = 1; },
           "its base texture is placed by TEXCOORD_1, must be by TEXCOORD_0"},
          {"no image", [](DamagedModel& m) { m.gltf()["textures"][0].erase("source"); },
           "its base texture has no image"},
          {"an image too many", [](DamagedModel& m) { m.gltf()["textures"][0]["source"] = 99; },
           "image 99 does not exist"},
          {"an image elsewhere", [](DamagedModel& m) { m.gltf()["images"].back()["uri"] = "../texture.png"; },
           "image 6 has the path \"../texture.png\", must lie in the model's own folder"},
          {"an image that is not there", [](DamagedModel& m) { m.gltf()["images"].back()["uri"] = "images/t.png"; },
           "images/t.png: no such file"},
          {"an image that is none", [](DamagedModel& m) { m.replace("images/texture.png", "hello"); },
           "images/texture.png: is no JPEG, PNG, TIFF, WebP, OpenEXR, HEIC, AVIF or raw image, by its first bytes"},
          {"a copy of nothing", [=](DamagedModel& m) { m.poke<std::uint32_t>(copies(m), 2, 49); },
           "vertex 51 is a copy of vertex 49 of 49 that are none"},
          {"a copy elsewhere", [=](DamagedModel& m) { m.poke<std::uint32_t>(copies(m), 2, 48); },
           "vertex 51 is a copy of vertex 48, but lies elsewhere"},
          {"more copies than vertices",
           [=](DamagedModel& m) { m.accessor(m.primitive()["attributes"]["POSITION"])["count"] = 3; },
           "face 0 has the vertex 5 of 3"},
          {"copies of another type", [=](DamagedModel& m) { m.lumigraph()["vertexCopies"] = 0; },
           "vertexCopies: accessor 0 has another type than this program writes"},
          {"copies by name", [=](DamagedModel& m) { m.lumigraph()["vertexCopies"] = "all"; },
           "LUMATLAS_lumigraph: \"vertexCopies\" is not a number"},
      },
      small_snapshot(), true);
}

TEST_CASE("a mesh may be degenerate or huge without harm") {
  DamagedModel model;
  const json positions = model.primitive()["attributes"]["POSITION"];
  model.lumigraph()["cellSize"] = 0;  // no mesh is too small for it
  SECTION("every vertex in one place") {
    for (std::size_t i = 0; i < 3 * 49; ++i) model.poke<float>(positions, i, 1);
  }
  SECTION("coordinates at the end of the range") {
    for (std::size_t i = 0; i < 3 * 49; ++i) model.poke<float>(positions, i, i % 2 == 0 ? 3e38f : -3e38f);
  }
  SECTION("coordinates too small to tell apart") {
    for (std::size_t i = 0; i < 3 * 49; ++i) model.poke<float>(positions, i, static_cast<float>(i % 5) * 1e-45f);
  }
  SECTION("one face many times in each cell") {
    // The first of each cell.
    const auto cell = [](std::size_t face) { return face * 5 / 34; };
    const std::vector<glm::uvec3> faces = read_model(model.file()).snapshot.surface->mesh.faces;
    std::size_t first = 0;
    for (std::size_t face = 0; face < faces.size(); ++face) {
      if (cell(face) != cell(first)) first = face;
      model.poke<glm::uvec3>(model.primitive()["indices"], face, faces[first]);
    }
  }
  CHECK(model.sentence() == "accepted");
}

TEST_CASE("cells of vertices that are no cells or tear a face are refused") {
  const auto cells = [](DamagedModel& m) { return json(m.primitive()["attributes"]["_CELL"]); };
  const auto set = [=](std::size_t vertex, float cell) {
    return [=](DamagedModel& m) { m.poke<float>(cells(m), vertex, cell); };
  };
  check_all({
      {"none", [](DamagedModel& m) { m.primitive()["attributes"].erase("_CELL"); }, "its mesh has no _CELL"},
      {"an accessor too many", [](DamagedModel& m) { m.primitive()["attributes"]["_CELL"] = 99; },
       "_CELL: accessor 99 does not exist"},
      {"positions", [](DamagedModel& m) { m.primitive()["attributes"]["_CELL"] = 0; },
       "_CELL: accessor 0 has another type than this program writes"},
      {"whole numbers", [=](DamagedModel& m) { m.accessor(cells(m))["componentType"] = 5125; },
       "_CELL: accessor 1 has another type than this program writes"},
      {"fewer", [=](DamagedModel& m) { m.accessor(cells(m))["count"] = 48; }, "_CELL has 48 cells for 49 vertices"},
      {"a cell too many", set(12, 5), "vertex 12 is in cell 5 of 5"},
      {"a huge cell", set(12, 1048576), "vertex 12 is in cell 1048576 of 5"},
      {"a negative cell", set(12, -1), "vertex 12 is in cell -1 of 5"},
      {"half a cell", set(12, 0.5f), "vertex 12 is in cell 0.5 of 5"},
      {"NaN", set(12, std::nanf("")), "vertex 12 is in cell nan of 5"},
      {"infinity", set(12, std::numeric_limits<float>::infinity()), "vertex 12 is in cell inf of 5"},
      {"two cells in a face", set(0, 3), "face 0 has vertices in cells 3, 0 and 0, must be in one"},
      {"a cell without faces",
       [=](DamagedModel& m) {
         for (std::size_t vertex = 0; vertex < 49; ++vertex) set(vertex, 3)(m);
       },
       "cell 0 has no faces"},
  });
}

TEST_CASE("cells and references out of range are refused") {
  const Bounds box = bounds(small_snapshot().surface->mesh);
  const std::string most_cell_size = number_text(glm::length(box.max - box.min));
  const auto set = [](const char* name, std::size_t index, std::uint32_t value) {
    return [=](DamagedModel& m) { m.poke<std::uint32_t>(m.lumigraph()[name], index, value); };
  };
  const auto count = [](const char* name, std::size_t elements) {
    return [=](DamagedModel& m) { m.accessor(m.lumigraph()[name])["count"] = elements; };
  };
  check_all({
      {"fewer cells", count("cellSeen", 4), "vertex 23 is in cell 4 of 4"},
      {"no cells", count("cellSeen", 0), "vertex 0 is in cell 0 of 0"},
      {"fewer deviations", count("cellDeviation", 4), "cellDeviation has 4 entries for 5 cells"},
      {"a negative deviation", [](DamagedModel& m) { m.poke(m.lumigraph()["cellDeviation"], 1, -1.0f); },
       "cellDeviation says of cell 1 -1, must be finite and not negative"},
      {"fewer coverages", count("cellCoverage", 4), "cellCoverage has 4 entries for 5 cells"},
      {"a negative coverage", [](DamagedModel& m) { m.poke(m.lumigraph()["cellCoverage"], 2, -0.5f); },
       "cellCoverage says of cell 2 -0.5, must be finite and not negative"},
      {"an infinite coverage",
       [](DamagedModel& m) { m.poke(m.lumigraph()["cellCoverage"], 0, std::numeric_limits<float>::infinity()); },
       "cellCoverage says of cell 0 inf, must be finite and not negative"},
      {"fewer offsets", count("referenceOffsets", 5), "referenceOffsets has 5 entries, must have 6 for 5 cells"},
      {"no offsets", count("referenceOffsets", 0), "referenceOffsets has 0 entries, must have 6 for 5 cells"},
      {"offsets from 1", set("referenceOffsets", 0, 1),
       "referenceOffsets do not rise from 0 to the number of references, 7"},
      {"offsets that fall", set("referenceOffsets", 3, 1),
       "referenceOffsets do not rise from 0 to the number of references, 7"},
      {"offsets too far", set("referenceOffsets", 5, 8),
       "referenceOffsets do not rise from 0 to the number of references, 7"},
      {"offsets beyond in the middle", set("referenceOffsets", 2, 0xffffffffu),
       "referenceOffsets do not rise from 0 to the number of references, 7"},
      {"fewer references", count("references", 6),
       "referenceOffsets do not rise from 0 to the number of references, 6"},
      {"no references", [](DamagedModel& m) { m.lumigraph().erase("references"); },
       "referenceOffsets do not rise from 0 to the number of references, 0"},
      {"a reference to a view too many", set("references", 4, 3), "reference 4 is to view 3 of 3"},
      {"references to views that are not there", [](DamagedModel& m) { m.lumigraph().erase("views"); },
       "reference 0 is to view 0 of 0"},
      {"no cellSeen", [](DamagedModel& m) { m.lumigraph().erase("cellSeen"); },
       "LUMATLAS_lumigraph has no \"cellSeen\""},
      {"an accessor too many", [](DamagedModel& m) { m.lumigraph()["cellSeen"] = 99; },
       "cellSeen: accessor 99 does not exist"},
      {"a negative accessor", [](DamagedModel& m) { m.lumigraph()["references"] = -1; },
       "LUMATLAS_lumigraph: \"references\" is -1, must be in [0, 1000000000]"},
      {"the accessor of something else", [](DamagedModel& m) { m.lumigraph()["references"] = 0; },
       "references: accessor 0 has another type than this program writes"},
      {"a negative size", [](DamagedModel& m) { m.lumigraph()["cellSize"] = -1; },
       "LUMATLAS_lumigraph: \"cellSize\" is -1, must be in [0, " + most_cell_size + "]"},
      {"an infinite size", [](DamagedModel& m) { m.lumigraph()["cellSize"] = json::parse("1.7e308"); },
       "LUMATLAS_lumigraph: \"cellSize\" is 1.7e+308, must be in [0, " + most_cell_size + "]"},
      {"a cell larger than the mesh", [](DamagedModel& m) { m.lumigraph()["cellSize"] = 1000; },
       "LUMATLAS_lumigraph: \"cellSize\" is 1000, must be in [0, " + most_cell_size + "]"},
      {"a reference twice in a cell", set("references", 1, 0),
       "cell 0 refers to view 0 twice, must refer to each view once at most"},
      {"an offset beyond any float",
       [](DamagedModel& m) {
         m.lumigraph()["offset"] = {1.0, -1e39, 0.0};
       },
       "LUMATLAS_lumigraph: \"offset\"[1] is -1e+39, must be in [-3.4e+38, 3.4e+38]"},
      {"an offset in the plane",
       [](DamagedModel& m) {
         m.lumigraph()["offset"] = {1.0, 2.0};
       },
       "LUMATLAS_lumigraph: \"offset\" is not an array of 3 numbers"},
      {"an offset of nothing",
       [](DamagedModel& m) {
         m.lumigraph()["offset"] = {1.0, nullptr, 2.0};
       },
       "LUMATLAS_lumigraph: \"offset\" is not an array of 3 numbers"},
  });
}

TEST_CASE("tiles that do not fit their views are refused") {
  const auto set = [](const char* name, const json& value) {
    return [=](DamagedModel& m) { m.lumigraph()["tiles"][name] = value; };
  };
  check_all(
      {
          {"a number", [](DamagedModel& m) { m.lumigraph()["tiles"] = 3; }, "tiles is not an object"},
          {"no size", [](DamagedModel& m) { m.lumigraph()["tiles"].erase("size"); }, "tiles has no \"size\""},
          {"no gutter", [](DamagedModel& m) { m.lumigraph()["tiles"].erase("gutter"); }, "tiles has no \"gutter\""},
          {"of no pixels", set("size", 0), "tiles: \"size\" is 0, must be in [8, 1024]"},
          {"huge", set("size", 2'000'000'000), "tiles: \"size\" is 2000000000, must be in [8, 1024]"},
          {"half a pixel", set("size", 8.5), "tiles: \"size\" is 8.5, must be a whole number"},
          {"not a multiple of 8", set("size", 12),
           "tiles: tile_px is 12, must be a multiple of 8 from 8 to 1024, or 0 for whole views"},
          {"a wide gutter", set("gutter", 9), "tiles: \"gutter\" is 9, must be in [1, 8]"},
          {"a gutter of no level", set("gutter", 3), "tiles: gutter_px is 3, must be 1, 2, 4 or 8"},
          {"unknown texels", [](DamagedModel& m) { m.lumigraph()["texels"] = "bc1"; },
           "\"texels\" is \"bc1\", must be \"rgb8\" or \"bc7\""},
          {"blocks with a gutter of 1",
           [](DamagedModel& m) {
             m.lumigraph()["texels"] = "bc7";
             m.lumigraph()["tiles"]["gutter"] = 1;
           },
           "tiles: gutter_px is 1, must be 2, 4 or 8 for texels in blocks"},
          {"larger tiles", set("size", 16), "\"resident\" says of 31 tiles whether they are there, its views have 10"},
          {"none of them", [](DamagedModel& m) { m.lumigraph().erase("resident"); },
           "\"resident\" says of 0 tiles whether they are there, its views have 31"},
          {"one less", [](DamagedModel& m) { m.accessor(m.lumigraph()["resident"])["count"] = 30; },
           "\"resident\" says of 30 tiles whether they are there, its views have 31"},
          {"an accessor too many", [](DamagedModel& m) { m.lumigraph()["resident"] = 99; },
           "resident: accessor 99 does not exist"},
          {"whole numbers", [](DamagedModel& m) { m.accessor(m.lumigraph()["resident"])["componentType"] = 5125; },
           "resident: accessor 9 has another type than this program writes"},
      },
      small_snapshot({}, {8, 2, 0}));
}

TEST_CASE("validity options out of range are refused") {
  const auto set = [](const char* name, const json& value) {
    return [=](DamagedModel& m) { m.lumigraph()["validity"][name] = value; };
  };
  check_all({
      {"none", [](DamagedModel& m) { m.lumigraph().erase("validity"); }, "LUMATLAS_lumigraph has no \"validity\""},
      {"a number", [](DamagedModel& m) { m.lumigraph()["validity"] = 3; }, "validity is not an object"},
      {"no fade", [](DamagedModel& m) { m.lumigraph()["validity"].erase("fade"); }, "validity has no \"fade\""},
      {"every step an edge", set("depthEdge", 0.0), "validity: depth_edge is 0, must be above 0 and at most 1000000"},
      {"a negative edge", set("depthEdge", -1), "validity: \"depthEdge\" is -1, must be in [0, 1000000]"},
      {"no step an edge", set("depthEdge", 1e7), "validity: \"depthEdge\" is 10000000, must be in [0, 1000000]"},
      {"a wide radius", set("edgeRadius", 17), "validity: \"edgeRadius\" is 17, must be in [0, 16]"},
      {"a huge radius", set("edgeRadius", 2'000'000'000), "validity: \"edgeRadius\" is 2000000000, must be in [0, 16]"},
      {"half a pixel", set("fade", 0.5), "validity: \"fade\" is 0.5, must be a whole number"},
      {"a long fade", set("fade", 17), "validity: \"fade\" is 17, must be in [0, 16]"},
      {"a third side", set("edges", "near"), "validity: \"edges\" is \"near\", must be \"far\" or \"both\""},
  });
}

TEST_CASE("views with a field missing or out of range are refused") {
  const auto set = [](const char* name, const json& value) {
    return [=](DamagedModel& m) { m.view(1)[name] = value; };
  };
  std::vector<Case> cases{
      {"no array", [](DamagedModel& m) { m.lumigraph()["views"] = 3; }, "\"views\" is not an array"},
      {"a view is a number", [](DamagedModel& m) { m.view(1) = 3; }, "view 1 is not an object"},
      {"a name of numbers", set("name", 3), "view 1: \"name\" is not a string"},
      {"a name on two lines", set("name", "a\nb"), "view 1: \"name\" is \"a b\", with a control character in it"},
      {"no width", set("width", 0), "view 1: \"width\" is 0, must be in [1, 65536]"},
      {"too high", set("height", 65537), "view 1: \"height\" is 65537, must be in [1, 65536]"},
      {"a fraction of a pixel", set("width", 19.5), "view 1: \"width\" is 19.5, must be a whole number"},
      {"flat", set("focalLength", {0.0, 20.0}), "view 1: camera: fx is 0, must be finite and positive"},
      {"turned inside out", set("focalLength", {20.0, -20.0}),
       "view 1: camera: fy is -20, must be finite and positive"},
      {"everything in one point", set("focalLength", {20.0, 1e-300}),
       "view 1: camera: fy is 1e-300, must be in [2e-05, 20000000000]"},
      {"everything far away", set("focalLength", {1e300, 20.0}),
       "view 1: camera: fx is 1e+300, must be in [2e-05, 20000000000]"},
      {"far from the scene", set("translation", {0.0, 1.0, -1e14}),
       "view 1: camera: translation[2] is -100000000000000, must be in [-10000000000000, 10000000000000]"},
      {"looking past the image", set("principalPoint", {-1e300, 9.0}),
       "view 1: camera: cx is -1e+300, must be in [-20000000000, 20000000000]"},
      {"one focal length", set("focalLength", {20.0}), "view 1: \"focalLength\" is not an array of 2 numbers"},
      {"a focal length in words", set("focalLength", {20.0, "20"}),
       "view 1: \"focalLength\"[1] is not a finite number"},
      {"a principal point of one number", set("principalPoint", 3.0),
       "view 1: \"principalPoint\" is not an array of 2 numbers"},
      {"half a rotation", set("rotation", {1.0, 0.0, 0.0}), "view 1: \"rotation\" is not an array of 9 numbers"},
      {"a rotation of zeros", set("rotation", {0, 0, 0, 0, 0, 0, 0, 0, 0}),
       "view 1: camera: rotation is 0, must be orthonormal"},
      {"a mirror", set("rotation", {-1, 0, 0, 0, 1, 0, 0, 0, 1}),
       "view 1: camera: rotation's determinant is -1, must be positive"},
      {"a huge rotation", set("rotation", {kHuge, 0, 0, 0, 1, 0, 0, 0, 1}),
       "view 1: camera: rotation is inf, must be orthonormal"},
      {"a flat translation", set("translation", {1.0, 2.0}), "view 1: \"translation\" is not an array of 3 numbers"},
      {"black", set("gain", {0.0, 1.0, 1.0}), "view 1: \"gain\"[0] is 0, must be in [1e-06, 1000000]"},
      {"negative light", set("gain", {1.0, -1.0, 1.0}), "view 1: \"gain\"[1] is -1, must be in [1e-06, 1000000]"},
      {"a flash", set("gain", {1.0, 1.0, 1.1e6}), "view 1: \"gain\"[2] is 1100000, must be in [1e-06, 1000000]"},
      {"a gain in words", set("gain", {1.0, "1", 1.0}), "view 1: \"gain\"[1] is not a finite number"},
      {"one gain for all channels", set("gain", 1.0), "view 1: \"gain\" is not an array of 3 numbers"},
      {"a gain for alpha", set("gain", {1.0, 1.0, 1.0, 1.0}), "view 1: \"gain\" is not an array of 3 numbers"},
      {"an image too many", set("image", 6), "image 6 does not exist"},
      {"a negative image", set("image", -1), "view 1: \"image\" is -1, must be in [0, 1000000000]"},
      {"a lens mask too many", set("lensMask", 99), "image 99 does not exist"},
      {"a trust mask too many", set("trustMask", 99), "image 99 does not exist"},
      {"a trust mask by name", set("trustMask", "b-trust.png"), "view 1: \"trustMask\" is not a number"},
  };
  for (const char* name :
       {"name", "image", "width", "height", "focalLength", "principalPoint", "rotation", "translation", "gain"}) {
    cases.push_back(
        {name, [=](DamagedModel& m) { m.view(1).erase(name); }, std::string("view 1 has no \"") + name + "\""});
  }
  check_all(cases);
}

TEST_CASE("cameras at the ends of their range do no harm") {
  DamagedModel model;
  json& view = model.view(0);
  SECTION("everything in one point") {
    view["focalLength"] = {2.4e-5, 2.4e-5};
  }
  SECTION("everything far away") {
    view["focalLength"] = {2.4e10, 2.4e10};
  }
  SECTION("far from the scene") {
    view["translation"] = {1e13, -1e13, 1e13};
  }
  SECTION("looking past the image") {
    view["principalPoint"] = {-2.4e10, 2.4e10};
  }
  CHECK(model.sentence() == "accepted");
}

TEST_CASE("what a reader would refuse is not written, or written so that it is read") {
  const TemporaryFolder folder;
  Snapshot snapshot = small_snapshot();
  const Bounds box = bounds(snapshot.surface->mesh);
  SECTION("a cell size above the mesh's diagonal") {
    auto surface = std::make_shared<Surface>(*snapshot.surface);
    surface->cells.size = 1e6;
    snapshot.surface = surface;
    write_model(folder.path(), snapshot, {});
    CHECK(read_model(folder.path()).snapshot.surface->cells.size == glm::length(box.max - box.min));
  }
  SECTION("a camera that sees nothing but one point") {
    auto view = std::make_shared<StoredView>(*snapshot.views[0]);
    view->camera.fx = 1e300;
    snapshot.views[0] = view;
    CHECK_THROWS_WITH(write_model(folder.path(), snapshot, {}),
                      "view a.jpg does not fit into a model file: camera: fx is 1e+300, must be in [2.4e-05, "
                      "24000000000]");
  }
  SECTION("an offset that no float holds") {
    auto surface = std::make_shared<Surface>(*snapshot.surface);
    surface->offset.y = -1e39;
    snapshot.surface = surface;
    CHECK_THROWS_WITH(
        write_model(folder.path(), snapshot, {}),
        "the surface's offset[1] is -1e+39, a model file holds at most 3.4e+38: move the scene nearer to 0");
  }
}

TEST_CASE("images that do not fit are refused") {
  DamagedModel model;
  const fs::path image = model.folder() / "images/00001.png";
  SECTION("missing") {
    fs::remove(image);
    CHECK(model.sentence() == "images/00001.png: no such file");
    CHECK_THROWS_WITH(read_model_facts(model.file()), image.string() + ": no such file");
  }
  SECTION("cut off") {
    const std::string bytes = bytes_of(image);
    model.replace("images/00001.png", bytes.substr(0, bytes.size() / 2));
    CHECK(model.sentence() ==
          "images/00001.png: the file is cut off after " + std::to_string(bytes.size() / 2) + " bytes; copy it again");
  }
  SECTION("another size") {
    write_image(image, position_photograph(20, 17));
    CHECK(model.sentence() == "images/00001.png: is 20x17, its view in " + model.file().string() + " says 20x18");
  }
  SECTION("another size of the lens mask") {
    write_image(model.folder() / "images/00001-lens.png", position_photograph(1, 1));
    CHECK(model.sentence() == "images/00001-lens.png: is 1x1, its view in " + model.file().string() + " says 20x18");
  }
  SECTION("another size of the trust mask") {
    write_image(model.folder() / "images/00002-trust.png", position_photograph(30, 29));
    CHECK(model.sentence() == "images/00002-trust.png: is 30x29, its view in " + model.file().string() + " says 30x30");
  }
  SECTION("a missing lens mask") {
    fs::remove(model.folder() / "images/00001-lens.png");
    CHECK(model.sentence() == "images/00001-lens.png: no such file");
  }
  SECTION("a missing trust mask") {
    fs::remove(model.folder() / "images/00002-trust.png");
    CHECK(model.sentence() == "images/00002-trust.png: no such file");
  }
  SECTION("a trust mask cut off") {
    const std::string bytes = bytes_of(model.folder() / "images/00001-trust.png");
    model.replace("images/00001-trust.png", bytes.substr(0, bytes.size() / 2));
    CHECK(model.sentence() == "images/00001-trust.png: the file is cut off after " + std::to_string(bytes.size() / 2) +
                                  " bytes; copy it again");
  }
  SECTION("another size in the file") {
    model.view(2)["width"] = 65536;
    model.view(2)["height"] = 65536;
    CHECK(model.sentence() == "images/00002.png: is 30x30, its view in " + model.file().string() + " says 65536x65536");
  }
  SECTION("in a data URI") {
    model.gltf()["images"][1]["uri"] = "data:image/png;base64,iVBORw0KGgo=";
    CHECK(model.sentence() == "image 1 is a data URI, must be a file or in a buffer");
  }
  SECTION("in a buffer view that does not exist") {
    model.gltf()["images"][1] = {{"bufferView", 99}, {"mimeType", "image/png"}};
    CHECK(model.sentence() == "image 1: buffer view 99 does not exist");
  }
  SECTION("in a buffer view") {
    model.gltf()["images"][1] = {{"bufferView", 0}, {"mimeType", "image/png"}};
    CHECK(model.sentence() == "image 1: not a PNG or JPEG image");
  }
  SECTION("in a buffer view that lies beyond its buffer") {
    model.gltf()["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 1'000'000'000'000}, {"byteLength", 9}});
    model.gltf()["images"][1] = {{"bufferView", model.gltf()["bufferViews"].size() - 1}, {"mimeType", "image/png"}};
    CHECK(model.sentence() == "image 1: buffer view 9 reaches beyond its buffer of 1684 bytes");
  }
  SECTION("in an empty buffer view") {
    model.gltf()["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 0}});
    model.gltf()["images"][1] = {{"bufferView", model.gltf()["bufferViews"].size() - 1}, {"mimeType", "image/png"}};
    CHECK_THAT(model.sentence(), Catch::Contains("image 1 is empty") || Catch::Contains("byteLength"));
  }
  SECTION("nowhere") {
    model.gltf()["images"][1] = {{"mimeType", "image/png"}};
    CHECK(model.sentence() == "image 1 must have a \"uri\" or a \"bufferView\"");
  }
  SECTION("in two places") {
    model.gltf()["images"][1]["bufferView"] = 0;
    CHECK(model.sentence() == "image 1 must have a \"uri\" or a \"bufferView\"");
  }
  SECTION("at a number") {
    model.gltf()["images"][1]["uri"] = 3;
    CHECK(model.sentence() == "image 1: \"uri\" is not a string");
  }
  SECTION("in a negative buffer view") {
    model.gltf()["images"][1] = {{"bufferView", -1}};
    CHECK(model.sentence() == "image 1: \"bufferView\" is -1");
  }
  SECTION("in no list") {
    model.gltf()["images"] = 3;
    CHECK(model.sentence() == "\"images\" is not an array");
  }
  SECTION("one photograph for two views") {
    model.view(1)["image"] = 0;
    CHECK(model.sentence() == "two views have the photograph " + (model.folder() / "images/00000.png").string() +
                                  ", each must have its own");
  }
  SECTION("one photograph for two views, by two names") {
    model.gltf()["images"][1]["uri"] = "images/./00000.png";
    CHECK_THAT(model.sentence(), Catch::StartsWith("two views have the photograph "));
  }
  SECTION("none at all") {
    model.gltf().erase("images");
    CHECK(model.sentence() == "image 0 does not exist");
  }
}

// A good model in one file, to be damaged. Its JSON is as long as it likes.
class DamagedGlb {
 public:
  DamagedGlb() {
    std::ostringstream file;
    write_glb(file, small_snapshot(), {});
    good_ = file.str();
    const std::size_t json_bytes = word_at(12);
    gltf_ = json::parse(good_.substr(20, json_bytes));
    binary_ = good_.substr(20 + json_bytes + 8);
  }

  [[nodiscard]] const std::string& bytes() const { return good_; }
  [[nodiscard]] json& gltf() { return gltf_; }
  [[nodiscard]] std::uint32_t word_at(std::size_t at) const {
    std::uint32_t word = 0;
    std::memcpy(&word, &good_[at], 4);
    return word;
  }
  [[nodiscard]] std::string with_word(std::size_t at, std::uint32_t word) const {
    std::string bytes = good_;
    std::memcpy(&bytes[at], &word, 4);
    return bytes;
  }
  [[nodiscard]] std::string with_json() const {
    std::ostringstream file;
    write_glb_frame(file, gltf_.dump(),
                    std::span(reinterpret_cast<const unsigned char*>(binary_.data()), binary_.size()));
    return file.str();
  }
  // Returns the reader's message, without the path.
  [[nodiscard]] std::string sentence(const std::string& bytes) const {
    const fs::path file = folder_.with_file("model.glb", bytes);
    try {
      (void)read_model(file);
    } catch (const InputError& error) {
      const std::string text = error.what();
      CHECK(text.find('\n') == std::string::npos);
      return text.starts_with(file.string() + ": ") ? text.substr(file.string().size() + 2) : text;
    }
    return "accepted";
  }

 private:
  TemporaryFolder folder_;
  std::string good_, binary_;
  json gltf_;
};

TEST_CASE("the frame of a .glb must fit the file") {
  const DamagedGlb model;
  const std::string all = std::to_string(model.bytes().size());
  const std::size_t json_bytes = model.word_at(12), binary_at = 20 + json_bytes;
  const std::string after_json = std::to_string(model.bytes().size() - 20);
  const std::string binary_bytes = std::to_string(model.bytes().size() - binary_at - 8);
  const std::string damaged = ": it is damaged or cut off";
  CHECK(model.sentence(model.bytes()) == "accepted");
  CHECK(model.sentence(model.with_json()) == "accepted");
  CHECK(model.sentence(model.with_word(4, 1)) == "is of glTF version 1, this program reads 2.0");
  CHECK(model.sentence(model.with_word(8, 100)) == "has " + all + " bytes, its header says 100" + damaged);
  CHECK(model.sentence(model.with_word(8, 0xffffffff)) ==
        "has " + all + " bytes, its header says 4294967295" + damaged);
  CHECK(model.sentence(model.bytes() + "x") ==
        "has " + std::to_string(model.bytes().size() + 1) + " bytes, its header says " + all + damaged);
  CHECK(model.sentence("glTF") == "its header has 12 bytes, but only 4 of the file are left" + damaged);
  CHECK(model.sentence(model.with_word(16, 3)) == "its first chunk is not JSON: it is no glTF 2.0 file");
  CHECK(model.sentence(model.with_word(12, 0xfffffffe)) ==
        "its JSON has 4294967294 bytes, but only " + after_json + " of the file are left" + damaged);
  CHECK(model.sentence(model.with_word(12, 0)) == "is no glTF 2.0 file that can be read: JSON string too short.");
  CHECK_THAT(model.sentence(model.with_word(12, 100)), Catch::StartsWith("is no glTF 2.0 file that can be read: "));
  CHECK(model.sentence(model.with_word(binary_at, 0xfffffffc)) ==
        "its binary chunk has 4294967292 bytes, but only " + binary_bytes + " of the file are left" + damaged);
  const std::string no_buffer = "its buffer has the path \"\", must lie in the model's own folder";
  CHECK(model.sentence(model.with_word(binary_at, 0)) == no_buffer);
  CHECK(model.sentence(model.with_word(binary_at + 4, 77)) == no_buffer);  // a chunk that nobody knows
  CHECK_THAT(model.sentence(model.with_word(binary_at, 100)), Catch::Contains("File size mismatch : binary chunk"));
}

TEST_CASE("a .glb that is cut off is refused at any length") {
  const DamagedGlb model;
  for (std::size_t length = 0; length < model.bytes().size(); length += 101) {
    CAPTURE(length);
    CHECK(model.sentence(model.bytes().substr(0, length)) != "accepted");
  }
}

TEST_CASE("a .glb with any of its first bytes or of its JSON changed is read or refused") {
  const DamagedGlb model;
  const std::size_t end = 20 + model.word_at(12) + 8;
  for (std::size_t at = 0; at < end; ++at) {
    std::string changed = model.bytes();
    changed[at] = static_cast<char>(~changed[at]);
    CAPTURE(at);
    const std::string sentence = model.sentence(changed);
    if (at < 20) CHECK(sentence != "accepted");
  }
}

TEST_CASE("images in the buffer of a .glb must be there, each its own") {
  DamagedGlb model;
  json& images = model.gltf()["images"];
  const auto view_of = [&](std::size_t image) -> json& {
    return model.gltf()["bufferViews"][images[image]["bufferView"].get<std::size_t>()];
  };
  REQUIRE(images.size() == 13);
  SECTION("one photograph for two views") {
    images[3] = images[0];  // after the first one's mask and thumbnail
    CHECK_THAT(model.sentence(model.with_json()),
               Catch::StartsWith("two views have the photograph ") && Catch::EndsWith("each must have its own"));
  }
  SECTION("photographs that overlap") {
    view_of(0)["byteLength"] =
        view_of(3)["byteOffset"].get<std::size_t>() + 9 - view_of(0)["byteOffset"].get<std::size_t>();
    CHECK_THAT(model.sentence(model.with_json()), Catch::StartsWith("two views have the photograph "));
  }
  SECTION("a photograph in the other's middle") {
    view_of(0)["byteLength"] =
        view_of(8)["byteOffset"].get<std::size_t>() - view_of(0)["byteOffset"].get<std::size_t>();
    CHECK_THAT(model.sentence(model.with_json()), Catch::StartsWith("two views have the photograph "));
  }
  SECTION("cut off") {
    view_of(0)["byteLength"] = view_of(0)["byteLength"].get<std::size_t>() / 2;
    CHECK_THAT(model.sentence(model.with_json()), Catch::StartsWith("image 0: the file is cut off after "));
  }
  SECTION("no image") {
    view_of(0)["byteOffset"] = view_of(0)["byteOffset"].get<std::size_t>() + 4;
    view_of(0)["byteLength"] = 60;
    CHECK(model.sentence(model.with_json()) == "image 0: not a PNG or JPEG image");
  }
  SECTION("a photograph of another size") {
    model.gltf()["extensions"]["LUMATLAS_lumigraph"]["views"][0]["width"] = 25;
    CHECK_THAT(model.sentence(model.with_json()), Catch::StartsWith("image 0: is 24x16, its view in "));
  }
  SECTION("beside the file") {  // allowed: it is in the folder
    images[0] = {{"uri", "missing.png"}};
    CHECK_THAT(model.sentence(model.with_json()), Catch::EndsWith("missing.png: no such file"));
  }
  SECTION("a buffer twice") {
    model.gltf()["buffers"].push_back({{"uri", "binary chunk"}, {"byteLength", 10}});
    CHECK(model.sentence(model.with_json()) == "has two buffers with the path \"binary chunk\"");
  }
}

TEST_CASE("of several damaged photographs the first is reported, by any number of threads") {
  DamagedModel model;
  for (const char* name : {"images/00000.png", "images/00001.png", "images/00002.png"}) model.replace(name, "x");
  const std::size_t threads = GENERATE(1u, 4u);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  for (int attempt = 0; attempt < 10; ++attempt) CHECK_THAT(model.sentence(), Catch::StartsWith("images/00000.png: "));
}

TEST_CASE("a model file with any byte changed is read or refused") {
  DamagedModel model;
  const std::string bytes = model.gltf().dump();
  std::size_t refused = 0;
  const std::string replacements = "0-\"]x";
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = replacements[at % replacements.size()];
    model.replace("scene.gltf", changed);
    if (model.sentence_as_it_is() != "accepted") ++refused;
  }
  CHECK(refused > bytes.size() / 4);
}

TEST_CASE("a buffer with any byte changed is read or refused") {
  const DamagedModel model;
  const std::string bytes = bytes_of(model.folder() / "scene.bin");
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    model.replace("scene.bin", changed);
    (void)model.sentence_as_it_is();
  }
}

TEST_CASE("a model file that is cut off is refused at any length") {
  const DamagedModel model;
  const std::string bytes = bytes_of(model.file());
  for (std::size_t length = 0; length + 2 < bytes.size(); length += 13) {
    model.replace("scene.gltf", bytes.substr(0, length));
    CAPTURE(length);
    CHECK(model.sentence_as_it_is() != "accepted");
  }
}

}  // namespace
}  // namespace lumatlas
