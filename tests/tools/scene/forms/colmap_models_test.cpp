// SPDX-License-Identifier: GPL-3.0-or-later
// Several models of COLMAP beside one another, as its mapper leaves them where it cannot join all photographs.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::write_file;

// Writes a model of `images` images, binary or text.
void write_model(const fs::path& folder, std::size_t images, bool binary = true) {
  Bytes records;
  std::string lines;
  records.u64(images);
  for (std::size_t i = 0; i < images; ++i) {
    const std::string name = std::to_string(i) + ".png";
    records.image(static_cast<std::uint32_t>(i + 1), {1, 0, 0, 0}, {0, 0, 0}, 1, name);
    lines += std::to_string(i + 1) + " 1 0 0 0 0 0 0 1 " + name + "\n\n";
  }
  write_file(folder / (binary ? "images.bin" : "images.txt"), binary ? records.string() : lines);
  write_file(folder / (binary ? "cameras.bin" : "cameras.txt"),
             binary ? Bytes().u64(1).camera(1, 1, 4, 3, {5, 5, 2, 1.5}).string() : "1 PINHOLE 4 3 5 5 2 1.5\n");
}

TEST_CASE("of several models in sparse/ the largest is read, and told which of which") {
  const TemporaryFolder scene;
  const fs::path sparse = scene / "sparse";
  write_model(sparse / "0", 3);
  CHECK(read_colmap_model(scene.path()).images.size() == 3);
  CHECK(read_colmap_model(scene.path()).note.empty());
  write_model(sparse / "1", 16);
  write_model(sparse / "10", 2, false);
  write_model(sparse / "2", 15, false);
  const ColmapModel model = read_colmap_model(scene.path());
  CHECK(model.images.size() == 16);
  CHECK(model.images_path == sparse / "1/images.bin");
  CHECK(model.note == "of 4 models the one in " + (sparse / "1").string() +
                          " is read, which has 16 photographs; not that in " + (sparse / "0").string() + " with 3, " +
                          (sparse / "2").string() + " with 15, " + (sparse / "10").string() +
                          " with 2: to read another one, copy its files to " + sparse.string());
  REQUIRE(forms_in(scene.path()).size() == 1);
  CHECK(forms_in(scene.path()).front().file == sparse / "1/images.bin");
}

TEST_CASE("models of the same size: the first is read; one that lies in sparse/ itself comes before all") {
  const TemporaryFolder scene;
  const fs::path sparse = scene / "sparse";
  write_model(sparse / "1", 5);
  write_model(sparse / "0", 5);
  CHECK(read_colmap_model(scene.path()).images_path == sparse / "0/images.bin");
  write_model(sparse, 2);
  const ColmapModel model = read_colmap_model(scene.path());
  CHECK(model.images_path == sparse / "images.bin");
  CHECK_THAT(model.note, Catch::StartsWith("of 3 models the one in " + sparse.string() + " is read, which has 2"));
}

TEST_CASE("a model that lacks a file or is damaged is not taken where another one is whole") {
  const TemporaryFolder scene;
  const fs::path sparse = scene / "sparse";
  write_model(sparse / "0", 9);
  fs::remove(sparse / "0/cameras.bin");
  write_model(sparse / "1", 2);
  CHECK(read_colmap_model(scene.path()).images_path == sparse / "1/images.bin");
  CHECK(read_colmap_model(scene.path()).note.empty());
  write_model(sparse / "2", 7, false);
  write_file(sparse / "2/images.txt", "1 1 0 0\n");
  const ColmapModel model = read_colmap_model(scene.path());
  CHECK(model.images_path == sparse / "1/images.bin");
  CHECK_THAT(model.note, Catch::Contains((sparse / "2").string() + ", which cannot be read"));
}

TEST_CASE("the note on several models is one of the scene's") {
  const TemporaryFolder scene;
  write_model(scene / "sparse/0", 1);
  write_model(scene / "sparse/1", 2);
  for (const char* const name : {"0.png", "1.png"}) {
    fs::create_directories(scene / "images");
    write_image(scene / "images" / name, Photograph{4, 3, std::vector<std::uint8_t>(36, 90), {}});
  }
  const SceneViews views = read_scene_views(scene.path(), glm::dvec3(0));
  CHECK(views.views.size() == 2);
  REQUIRE(views.notes.size() == 1);
  CHECK_THAT(views.notes[0], Catch::StartsWith("of 2 models the one in ") && Catch::Contains("sparse/1 is read"));
}

}  // namespace
}  // namespace lumatlas
