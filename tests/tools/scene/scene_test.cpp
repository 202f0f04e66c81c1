// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <set>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::write_file;

const glm::dquat kTurn = glm::normalize(glm::dquat(0.8, 0.1, -0.5, 0.2));

std::array<double, 4> wxyz(const glm::dquat& q) {
  return {q.w, q.x, q.y, q.z};
}
std::array<double, 3> xyz(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

// Colours that encode the position.
Photograph picture(std::uint32_t width, std::uint32_t height) {
  Photograph photograph{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::array<std::uint32_t, 3> color{40 + 3 * x, 20 + 4 * y, 100};
      for (const std::uint32_t c : color) photograph.rgb.push_back(static_cast<std::uint8_t>(c));
    }
  }
  return photograph;
}

void write_photograph(const fs::path& path, std::uint32_t width, std::uint32_t height) {
  fs::create_directories(path.parent_path());
  write_image(path, picture(width, height));
}

Bytes two_camera_records() {
  return Bytes().u64(2).camera(1, 1, 40, 30, {50, 52, 20, 15}).camera(2, 2, 32, 24, {30, 16, 12, -0.1});
}

Bytes two_images() {
  return Bytes()
      .u64(2)
      .image(10, wxyz(kTurn), {1, 2, 3}, 2, "right/0001.png", 5)
      .image(11, wxyz(kTurn * glm::dquat(2, 0, 0, 1)), {-4, 5, -6}, 1, "left/0001.png");
}

void write_both_photographs(const fs::path& scene) {
  write_photograph(scene / "images/left/0001.png", 40, 30);
  write_photograph(scene / "images/right/0001.png", 32, 24);
}

void write_scene(const fs::path& scene, const fs::path& model) {
  write_file(scene / model / "cameras.bin", two_camera_records().string());
  write_file(scene / model / "images.bin", two_images().string());
  write_both_photographs(scene);
}

std::string complaint_of(const fs::path& scene) {
  try {
    (void)read_scene_views(scene, glm::dvec3(0.0));
  } catch (const InputError& error) {
    return error.what();
  }
  FAIL("the scene was taken");
  return {};
}

bool same_pose(const Camera& a, const Camera& b) {
  return a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

TEST_CASE("a scene's views come by name with their files, lenses and poses") {
  const TemporaryFolder folder;
  write_scene(folder.path(), "sparse");
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0.0));
  CHECK(scene.root == folder.path());
  REQUIRE(scene.views.size() == 2);
  const SceneView& left = scene.views[0];
  const SceneView& right = scene.views[1];
  CHECK(left.name == "left/0001.png");
  CHECK(left.image == folder.path() / "images/left/0001.png");
  CHECK(left.lens.model == LensModel::kPinhole);
  CHECK(left.camera.width == 40);
  CHECK(left.camera.height == 30);
  CHECK(left.camera.fy == 52);
  CHECK(right.name == "right/0001.png");
  CHECK(right.lens.model == LensModel::kSimpleRadial);
  CHECK(right.camera.fx == 30);
  CHECK(glm::length(right.camera.cam_from_world({7, 8, 9}) - (kTurn * glm::dvec3(7, 8, 9) + glm::dvec3(1, 2, 3))) <
        1e-12);
  for (const SceneView& view : scene.views) CHECK_NOTHROW(check(view.camera));
}

TEST_CASE("binary and text models give the same views, in sparse, sparse/0 and the folder itself") {
  const TemporaryFolder reference;
  write_scene(reference.path(), "sparse");
  const SceneViews expected = read_scene_views(reference.path(), glm::dvec3(0.5, 0, 0));
  const std::string cameras = "1 PINHOLE 40 30 50 52 20 15\n2 SIMPLE_RADIAL 32 24 30 16 12 -0.1\n";
  const auto line = [](int id, const glm::dquat& q, const char* rest) {
    std::array<char, 300> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%d %.17g %.17g %.17g %.17g %s\n\n", id, q.w, q.x, q.y, q.z, rest);
    return std::string(buffer.data());
  };
  const std::string images =
      line(10, kTurn, "1 2 3 2 right/0001.png") + line(11, kTurn * glm::dquat(2, 0, 0, 1), "-4 5 -6 1 left/0001.png");
  for (const char* const place : {"sparse", "sparse/0", "."}) {
    for (const bool binary : {true, false}) {
      const TemporaryFolder folder;
      write_file(folder.path() / place / (binary ? "cameras.bin" : "cameras.txt"),
                 binary ? two_camera_records().string() : cameras);
      write_file(folder.path() / place / (binary ? "images.bin" : "images.txt"),
                 binary ? two_images().string() : images);
      write_both_photographs(folder.path());
      const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0.5, 0, 0));
      REQUIRE(scene.views.size() == expected.views.size());
      for (std::size_t i = 0; i < scene.views.size(); ++i) {
        CHECK(scene.views[i].name == expected.views[i].name);
        CHECK(scene.views[i].lens == expected.views[i].lens);
        CHECK(scene.views[i].camera.fx == expected.views[i].camera.fx);
        CHECK(same_pose(scene.views[i].camera, expected.views[i].camera));
      }
    }
  }
}

// A rig of two cameras, the second beside the first, and one frame of it: what COLMAP 3.12 writes.
TEST_CASE("a model with rigs and frames gives each image its own pose") {
  const glm::dvec3 frame_translation(1, 2, 3);
  const glm::dvec3 second_from_rig(-0.2, 0, 0);
  const TemporaryFolder folder;
  const fs::path model = folder.path() / "sparse/0";
  write_file(model / "rigs.bin", Bytes()
                                     .u64(1)
                                     .u32(1)
                                     .u32(2)
                                     .i32(0)
                                     .u32(1)
                                     .i32(0)
                                     .u32(2)
                                     .text("\1")
                                     .f64({1, 0, 0, 0, second_from_rig.x, second_from_rig.y, second_from_rig.z})
                                     .string());
  write_file(model / "frames.bin", Bytes()
                                       .u64(1)
                                       .u32(1)
                                       .u32(1)
                                       .f64({kTurn.w, kTurn.x, kTurn.y, kTurn.z, 1, 2, 3})
                                       .u32(2)
                                       .i32(0)
                                       .u32(1)
                                       .u64(11)
                                       .i32(0)
                                       .u32(2)
                                       .u64(10)
                                       .string());
  write_file(model / "cameras.bin", two_camera_records().string());
  write_file(model / "images.bin",
             Bytes()
                 .u64(2)
                 .image(11, wxyz(kTurn), xyz(frame_translation), 1, "left/0001.png", 3)
                 .image(10, wxyz(kTurn), xyz(second_from_rig + frame_translation), 2, "right/0001.png", 2)
                 .string());
  write_both_photographs(folder.path());
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0.0));
  REQUIRE(scene.views.size() == 2);
  const glm::dvec3 world(3, -1, 8);
  const glm::dvec3 rig = kTurn * world + frame_translation;
  CHECK(glm::length(scene.views[0].camera.cam_from_world(world) - rig) < 1e-12);
  CHECK(glm::length(scene.views[1].camera.cam_from_world(world) - (rig + second_from_rig)) < 1e-12);
}

TEST_CASE("a camera far from the origin keeps its place to a millionth once the offset is subtracted") {
  const glm::dvec3 offset(432100, 5400321, 87);
  const glm::dvec3 near(0.125, -0.25, 0.5);  // the camera's centre, relative to the offset
  const glm::dvec3 translation = -(kTurn * (offset + near));
  const TemporaryFolder folder;
  write_file(folder.path() / "cameras.bin", two_camera_records().string());
  write_file(folder.path() / "images.bin",
             Bytes().u64(1).image(1, wxyz(kTurn), xyz(translation), 1, "left/0001.png").string());
  write_both_photographs(folder.path());
  const SceneViews scene = read_scene_views(folder.path(), offset);
  CHECK(glm::length(scene.views.at(0).camera.center() - near) < 1e-6 * glm::length(near));
}

TEST_CASE("a scene whose photographs do not fit gets an exact sentence") {
  const TemporaryFolder folder;
  const std::string scene = folder.path().string();
  write_file(folder.path() / "sparse/cameras.bin", two_camera_records().string());
  write_file(folder.path() / "sparse/images.bin", two_images().string());
  CHECK(complaint_of(scene) == scene + "/images/left/0001.png: no such photograph, but image 11 of " + scene +
                                   "/sparse/images.bin names it: name the folder of the photographs with --images");
  fs::create_directories(folder.path() / "images/left");
  write_photograph(folder.path() / "images/right/0001.png", 32, 24);
  CHECK(complaint_of(scene) ==
        scene + "/images/left/0001.png: no such photograph, but image 11 of " + scene + "/sparse/images.bin names it");
  write_photograph(folder.path() / "images/left/0001.png", 41, 30);
  CHECK(complaint_of(scene) == scene + "/images/left/0001.png: is 41x30 pixels, but camera 1 of " + scene +
                                   "/sparse/cameras.bin is 40x30: put the photographs that the model was made from "
                                   "there");
  write_photograph(folder.path() / "images/left/0001.png", 30, 40);
  CHECK(complaint_of(scene) == scene + "/images/left/0001.png: is 30x40 pixels, but camera 1 of " + scene +
                                   "/sparse/cameras.bin is 40x30: it was turned by a quarter after its pose was found; "
                                   "turn it back");
  write_file(folder.path() / "images/left/0001.png", "no picture");
  CHECK_THAT(complaint_of(scene), Catch::StartsWith(scene + "/images/left/0001.png: "));
}

// An uncompressed file with an EXIF orientation.
void write_turned(const fs::path& path, const Photograph& stored, int orientation) {
  fs::create_directories(path.parent_path());
  const auto output = OIIO::ImageOutput::create(path.string());
  OIIO::ImageSpec spec(static_cast<int>(stored.width), static_cast<int>(stored.height), 3, OIIO::TypeDesc::UINT8);
  spec.attribute("Orientation", orientation);
  REQUIRE(output->open(path.string(), spec));
  REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, stored.rgb.data()));
  REQUIRE(output->close());
}

TEST_CASE("an EXIF orientation is ignored as COLMAP does, unless only the upright photograph fits its camera") {
  const TemporaryFolder folder;
  write_file(folder.path() / "sparse/cameras.bin", Bytes().u64(1).camera(1, 1, 40, 30, {50, 52, 20, 15}).string());
  write_file(folder.path() / "sparse/images.bin",
             Bytes().u64(1).image(1, wxyz(kTurn), {1, 2, 3}, 1, "turned.tif").string());
  write_turned(folder.path() / "images/turned.tif", picture(40, 30), 3);
  CHECK(load_photograph(read_scene_views(folder.path(), glm::dvec3(0.0)).views.at(0)).rgb == picture(40, 30).rgb);
  write_turned(folder.path() / "images/turned.tif", picture(30, 40), 6);
  const Photograph upright = load_photograph(read_scene_views(folder.path(), glm::dvec3(0.0)).views.at(0));
  REQUIRE(upright.width == 40);
  // Orientation 6: the stored first row is the right-hand column.
  const Photograph stored = picture(30, 40);
  CHECK(std::equal(stored.rgb.begin(), stored.rgb.begin() + 3, upright.rgb.begin() + 3 * 39));
}

TEST_CASE("a camera whose picture folds over is refused only if an image has it") {
  const TemporaryFolder folder;
  const std::string scene = folder.path().string();
  write_scene(folder.path(), "sparse");
  const Bytes cameras = Bytes()
                            .u64(3)
                            .camera(1, 1, 40, 30, {50, 52, 20, 15})
                            .camera(2, 2, 32, 24, {30, 16, 12, -0.1})
                            .camera(3, 2, 40, 30, {50, 20, 15, -1e9});
  write_file(folder.path() / "sparse/cameras.bin", cameras.string());
  CHECK(read_scene_views(folder.path(), glm::dvec3(0.0)).views.size() == 2);
  write_file(folder.path() / "sparse/images.bin",
             Bytes().u64(1).image(1, {1, 0, 0, 0}, {0, 0, 0}, 3, "left/0001.png").string());
  CHECK_THAT(complaint_of(scene), Catch::StartsWith("camera 3 of " + scene + "/sparse/cameras.bin: its distortion"));
}

TEST_CASE("a pinhole's photograph is loaded to the byte, a distorted one undistorted") {
  const TemporaryFolder folder;
  write_scene(folder.path(), "sparse");
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0.0));
  const Photograph left = load_photograph(scene.views[0]);
  CHECK(left.rgb == picture(40, 30).rgb);
  CHECK(left.valid.empty());
  const Photograph right = load_photograph(scene.views[1]);
  CHECK(right.width == 32);
  CHECK(right.height == 24);
  CHECK(right.rgb != picture(32, 24).rgb);
  write_photograph(scene.views[0].image, 41, 30);
  CHECK_THROWS_WITH(load_photograph(scene.views[0]),
                    scene.views[0].image.string() + ": is 41x30 pixels, but its camera is 40x30");
  fs::remove(scene.views[0].image);
  CHECK_THROWS_AS(load_photograph(scene.views[0]), InputError);
}

// Black at the pixels that `is_black` says, white elsewhere.
template <typename IsBlack>
void write_mask(const fs::path& path, std::uint32_t width, std::uint32_t height, const IsBlack& is_black) {
  fs::create_directories(path.parent_path());
  Photograph mask{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) mask.rgb.insert(mask.rgb.end(), 3, is_black(x, y) ? 0 : 1);
  }
  write_image(path, mask);
}

TEST_CASE("what a mask has black is not valid, of the pinhole exactly and of the distorted photograph where it lies") {
  const TemporaryFolder folder;
  write_scene(folder.path(), "sparse");
  const auto is_black = [](std::uint32_t x, std::uint32_t y) { return x < 10 && y >= 5; };
  write_mask(folder / "masks/left/0001.png", 40, 30, is_black);
  write_mask(folder / "masks/right/0001.png.png", 32, 24, is_black);
  write_mask(folder / "masks/right/0001.png", 32, 24, [](auto, auto) { return true; });  // the other name comes first
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(masked_views(scene) == 2);
  const Photograph pinhole = load_photograph(scene.views.at(0));
  CHECK(pinhole.rgb == picture(40, 30).rgb);
  REQUIRE(pinhole.valid.size() == 40 * 30);
  for (std::uint32_t i = 0; i < 40 * 30; ++i) CHECK((pinhole.valid[i] == 0) == is_black(i % 40, i / 40));
  const Photograph distorted = load_photograph(scene.views.at(1));
  REQUIRE(distorted.valid.size() == 32 * 24);
  CHECK(distorted.valid[12 * 32 + 4] == 0);
  CHECK(distorted.valid[12 * 32 + 16] == 255);
  CHECK(distorted.valid[2 * 32 + 16] == 255);
}

TEST_CASE("masks and photographs may be in other folders, and a mask that does not fit gets an exact sentence") {
  const TemporaryFolder folder, elsewhere;
  write_scene(folder.path(), "sparse");
  fs::rename(folder / "images", elsewhere / "pictures");
  PictureFolders folders{elsewhere / "pictures", std::nullopt};
  CHECK(masked_views(read_scene_views(folder.path(), glm::dvec3(0), folders)) == 0);
  folders.masks = elsewhere / "masks";
  CHECK_THROWS_WITH(
      read_scene_views(folder.path(), glm::dvec3(0), folders),
      (elsewhere / "masks").string() +
          ": has a mask of none of the 2 photographs: that of left/0001.png would be left/0001.png.png or "
          "left/0001_mask.png, but there is no picture");
  const fs::path mask = elsewhere / "masks/left/0001.png";
  write_mask(mask, 30, 40, [](auto, auto) { return false; });
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0), folders);
  CHECK(masked_views(scene) == 1);
  CHECK_THROWS_WITH(load_photograph(scene.views.at(0)), mask.string() + ": is 30x40 pixels, but its camera is 40x30");
  write_mask(mask, 40, 30, [](auto, auto) { return false; });
  CHECK(load_photograph(scene.views.at(0)).valid.empty());
}

TEST_CASE("what is more than half transparent is not valid") {
  const TemporaryFolder folder;
  write_scene(folder.path(), "sparse");
  OIIO::ImageSpec spec(40, 30, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 40 * 30; ++i) rgba.insert(rgba.end(), {10, 20, 30, static_cast<std::uint8_t>(i % 256)});
  const auto out = OIIO::ImageOutput::create("a.png");
  REQUIRE(out->open((folder / "images/left/0001.png").string(), spec));
  REQUIRE(out->write_image(OIIO::TypeDesc::UINT8, rgba.data()));
  REQUIRE(out->close());
  const Photograph photograph = load_photograph(read_scene_views(folder.path(), glm::dvec3(0)).views.at(0));
  REQUIRE(photograph.valid.size() == 40 * 30);
  for (int i = 0; i < 40 * 30; ++i) CHECK(photograph.valid[static_cast<std::size_t>(i)] == (i % 256 < 128 ? 0 : 255));
}

TEST_CASE("the mesh that is given is taken, and one that is not there refused") {
  const TemporaryFolder folder;
  write_file(folder.path() / "mesh.ply", "");
  write_file(folder.path() / "other.obj", "");
  CHECK(find_mesh(folder.path(), folder.path() / "other.obj") == folder.path() / "other.obj");
  CHECK_THROWS_WITH(find_mesh(folder.path(), folder.path() / "none.ply"),
                    (folder.path() / "none.ply").string() + ": no such file, but it was given as the mesh");
}

TEST_CASE("a mesh is found under each of the names that are in use, the more finished one first") {
  const TemporaryFolder folder;
  fs::path last;
  for (const char* const name :
       {"dense/0/scene_mesh.ply", "dense/0/meshed-poisson.ply", "dense/meshed-delaunay.ply", "scene_mesh_texture.obj",
        "scene_mesh.ply", "scene_dense_mesh.ply", "scene_dense_mesh_refine.obj", "scene_dense_mesh_refine.ply",
        "meshed-delaunay.ply", "meshed-poisson.ply", "mesh.obj", "mesh.ply"}) {
    write_file(folder.path() / name, "");
    CHECK(find_mesh(folder.path(), {}) == folder.path() / name);
  }
}

TEST_CASE("a scene without a mesh gets a sentence with all the places") {
  const TemporaryFolder folder;
  write_file(folder.path() / "fused.ply", "");  // points without faces
  fs::create_directories(folder.path() / "mesh.ply");
  CHECK_THROWS_WITH(
      find_mesh(folder.path(), {}),
      folder.path().string() +
          ": no mesh in it, in dense/, dense/0/ or odm_meshing/ (looked for .ply, .obj, .stl, .glb and .gltf of "
          "mesh, meshed-poisson, meshed-delaunay, scene_dense_mesh_refine, scene_dense_mesh, scene_mesh_refine, "
          "scene_mesh, "
          "scene_dense_mesh_refine_texture, scene_dense_mesh_texture, scene_mesh_texture, raw, odm_mesh, "
          "odm_25dmesh, texturedMesh): name one with "
          "--mesh, or make one with `lumatlas mesh " +
          folder.path().string() + " -o " + folder.path().string() + "/mesh.ply`");
}

TEST_CASE("every hold-th view is held out and scored") {
  const Split s = split(20, {8, 1});
  CHECK(s.scored == std::vector<std::size_t>{0, 8, 16});
  CHECK(s.input.size() == 17);
  CHECK(std::find(s.input.begin(), s.input.end(), 8) == s.input.end());
}

TEST_CASE("whole blocks are held out and three views of each scored") {
  const Split s = split(400, {5, 40});
  CHECK(s.scored == std::vector<std::size_t>{10, 20, 30, 210, 220, 230});
  CHECK(s.input.size() == 320);
  CHECK(s.input.front() == 40);
}

TEST_CASE("held-out and input views never meet, and for blocks of every size the formula holds") {
  for (std::size_t hold = 2; hold < 6; ++hold) {
    for (std::size_t block = 1; block < 14; ++block) {
      const Split s = split(97, {hold, block});
      const std::set<std::size_t> input(s.input.begin(), s.input.end());
      const std::set<std::size_t> scored(s.scored.begin(), s.scored.end());
      for (std::size_t rank = 0; rank < 97; ++rank) {
        const bool held = (rank / block) % hold == 0;
        const std::size_t m = rank % block;
        CHECK(input.count(rank) == (held ? 0 : 1));
        CHECK(scored.count(rank) == (held && (m == block / 4 || m == block / 2 || m == 3 * block / 4) ? 1 : 0));
      }
    }
  }
  CHECK(split(0, {8, 1}).input.empty());
}

TEST_CASE("a protocol that leaves nothing to learn from, or has no blocks, is refused") {
  CHECK_THROWS_WITH(split(10, {1, 1}), "hold is 1, must be at least 2");
  CHECK_THROWS_WITH(split(10, {0, 1}), "hold is 0, must be at least 2");
  CHECK_THROWS_WITH(check(HoldOut{8, 0}), "block is 0, must be at least 1");
  CHECK(split(10, {2, ~std::size_t{0}}).input.empty());
}

TEST_CASE("the real scenes have their views, poses and meshes") {
  struct Expected {
    const char* name;
    std::size_t views;
    std::uint32_t width, height;
  };
  for (const Expected& expected :
       {Expected{"office", 1000, 640, 480}, Expected{"fox", 50, 1067, 1899}, Expected{"sceaux", 11, 1668, 1234}}) {
    const std::optional<fs::path> path = real_scene_or_skip(expected.name);
    if (!path) return;
    const SceneViews scene = read_scene_views(*path, glm::dvec3(0.0));
    REQUIRE(scene.views.size() == expected.views);
    CHECK(scene.views.front().camera.width == expected.width);
    CHECK(scene.views.front().camera.height == expected.height);
    for (const SceneView& view : scene.views) CHECK_NOTHROW(check(view.camera));
    CHECK(find_mesh(*path, {}) == *path / "mesh.ply");
    CHECK(load_photograph(scene.views.front()).valid.empty());
  }
}

TEST_CASE("a protocol that scores none of a scene's views is refused") {
  SceneViews scene;
  scene.root = "office";
  CHECK_THROWS_WITH(split_to_score(scene, HoldOut{8, 1}),
                    "office: the protocol scores none of its 0 views: check --hold and --block");
  scene.views.resize(9);
  CHECK(split_to_score(scene, HoldOut{8, 1}).scored == std::vector<std::size_t>{0, 8});
}

}  // namespace
}  // namespace lumatlas
