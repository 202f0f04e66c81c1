// SPDX-License-Identifier: GPL-3.0-or-later
// Files in a scene's folder that are not used: masks under other names, photographs without a pose.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/growing_scene.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::write_file;

void write_grey(const fs::path& path) {
  fs::create_directories(path.parent_path());
  write_image(path, Photograph{4, 3, std::vector<std::uint8_t>(36, 90), {}});
}

// A COLMAP scene of three photographs, two of them in a folder.
struct Three {
  TemporaryFolder folder;
  fs::path path = folder.path();
  std::vector<std::string> names{"a.png", "left/b.png", "left/c.png"};

  Three() {
    Bytes images;
    images.u64(3);
    for (std::uint32_t i = 0; i < 3; ++i) {
      images.image(i + 1, {1, 0, 0, 0}, {0, 0, 0}, 1, names[i]);
      write_grey(path / "images" / names[i]);
    }
    write_file(path / "sparse/images.bin", images.string());
    write_file(path / "sparse/cameras.bin", Bytes().u64(1).camera(1, 1, 4, 3, {5, 5, 2, 1.5}).string());
  }
  [[nodiscard]] SceneViews read() const { return read_scene_views(path, glm::dvec3(0)); }
};

TEST_CASE("masks are found under the names that programs give them") {
  for (const std::string ending : {".png.png", ".png", "_mask.png", ".mask.png", ".png.mask.png", ".png_mask.png"}) {
    CAPTURE(ending);
    const Three scene;
    for (const std::string& name : scene.names) {
      write_grey(scene.path / "masks" / (name.substr(0, name.size() - 4) + ending));
    }
    const SceneViews read = scene.read();
    CHECK(masked_views(read) == 3);
    CHECK(read.notes.empty());
  }
}

TEST_CASE("masks that fit no photograph are told with both names") {
  const Three scene;
  write_grey(scene.path / "masks/left/m-b.png");
  write_grey(scene.path / "masks/left/m-c.png");
  const SceneViews read = scene.read();
  CHECK(masked_views(read) == 0);
  REQUIRE(read.notes.size() == 1);
  CHECK(read.notes[0] ==
        (scene.path / "masks").string() +
            ": has a mask of none of the 3 photographs: that of a.png would be a.png.png or a_mask.png, "
            "but there is left/m-b.png");
}

TEST_CASE("a scene that fills up tells the same of masks and photographs without a pose") {
  const Three scene;
  write_grey(scene.path / "masks/left/b.png");
  write_grey(scene.path / "masks/x.png");
  write_grey(scene.path / "images/left/d.png");
  const SceneViews read = scene.read();
  REQUIRE(read.notes.size() == 3);
  GrowingScene growing(scene.path, glm::dvec3(0), {});
  std::vector<SceneView> came;
  for (int look = 0; look < 4; ++look) {
    for (SceneView& view : growing.look().ready) came.push_back(std::move(view));
  }
  REQUIRE(came.size() == 3);
  CHECK(growing.notes(came) == read.notes);
  CHECK(growing.notes({}) == std::vector(1, read.notes.back()));
}

TEST_CASE("masks of some photographs, and some that fit none, are told with counts") {
  const Three scene;
  write_grey(scene.path / "masks/left/b.png");
  SceneViews read = scene.read();
  REQUIRE(read.notes.size() == 1);
  CHECK(read.notes[0] == "1 of 3 photographs have a mask, the others are used whole, the first of them a.png");
  write_grey(scene.path / "masks/x.png");
  write_grey(scene.path / "masks/y.png");
  read = scene.read();
  REQUIRE(read.notes.size() == 2);
  CHECK(read.notes[1] == "2 of 3 masks in " + (scene.path / "masks").string() +
                             " fit no photograph and are not used, the first of them x.png");
  write_grey(scene.path / "masks/a.png.png");
  write_grey(scene.path / "masks/left/c_mask.png");
  CHECK(scene.read().notes.size() == 1);
}

TEST_CASE("a folder of masks that was asked for and fits nothing is refused with both names") {
  const Three scene;
  write_grey(scene.path / "other/m.png");
  PictureFolders folders;
  folders.masks = scene.path / "other";
  CHECK_THROWS_WITH(
      read_scene_views(scene.path, glm::dvec3(0), folders),
      (scene.path / "other").string() +
          ": has a mask of none of the 3 photographs: that of a.png would be a.png.png or a_mask.png, but "
          "there is m.png");
}

TEST_CASE("photographs that have no pose are told, and files of forms that are not read") {
  const Three scene;
  CHECK(scene.read().notes.empty());
  write_grey(scene.path / "images/left/d.png");
  write_grey(scene.path / "images/e.png");
  write_file(scene.path / "images/IMG_1.JXL", "jxl");
  write_file(scene.path / "images/IMG_2.jxl", "jxl");
  write_file(scene.path / "images/IMG_2.mov", "video");
  const SceneViews read = scene.read();
  REQUIRE(read.notes.size() == 2);
  CHECK(read.notes[0] == "2 of 5 photographs in " + (scene.path / "images").string() +
                             " have no pose and are not used, the first of them e.png");
  CHECK(read.notes[1] ==
        "2 files in " + (scene.path / "images").string() +
            " are of a form that is not read, the first of them IMG_1.JXL: convert them to JPEG before "
            "the poses are made");
}

TEST_CASE("photographs that a form leaves out are told once") {
  const TemporaryFolder folder;
  for (const char* const name : {"a.png", "b.png", "c.png", "d.png"})
    write_grey(folder / ("color/" + std::string(name)));
  for (const char* const stem : {"a", "b"}) {
    write_file(folder / ("pose/" + std::string(stem) + ".txt"), "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
  }
  write_file(folder / "intrinsic/intrinsic_color.txt", "5 0 2 0 0 5 1 0 0 0 1 0 0 0 0 1");
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(read.notes.size() == 1);
  CHECK_THAT(read.notes[0], Catch::Contains("2 of 4 photographs have no file in pose/"));
}

TEST_CASE("a photograph of a form that is not read is refused by the form's name") {
  const Three scene;
  const auto refused = [&](const std::string& bytes) -> std::string {
    write_file(scene.path / "images/a.png", bytes);
    try {
      (void)scene.read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  };
  const std::string start = (scene.path / "images/a.png").string() + ": ";
  const std::string size("\0\0\0\x18", 4);
  for (const char* const brand : {"heic", "heix", "mif1", "hevc", "avif"}) {
    CHECK_THAT(refused(size + "ftyp" + brand + "xxxxxxxx"),
               Catch::StartsWith(start + "is damaged, cut off or no HEIC or AVIF image that libheif reads"));
  }
  CHECK(refused(std::string("\xff\x0a and more bytes")) ==
        start + "is a JPEG XL image, which this program does not read: convert it to JPEG");
  CHECK(refused("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 1\n") ==
        start + "is a pointer of Git LFS instead of the picture: fetch it with `git lfs pull`");
  CHECK(refused("GIF89a, and more") ==
        start + "is no JPEG, PNG, TIFF, WebP, OpenEXR, HEIC, AVIF or raw image, by its first bytes");
}

}  // namespace
}  // namespace lumatlas
