// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs that are not where, or not as large as, their form of capture says, and those of which it says what
// cannot be.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/find_photographs.h"
#include "tools/scene/forms/photographs/photograph_names.h"
#include "tools/scene/picture_shape.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::write_file;

// A picture whose colours tell its pixels apart.
void write_ramp(const fs::path& file, std::uint32_t width, std::uint32_t height) {
  fs::create_directories(file.parent_path());
  Photograph picture{width, height, {}, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (const std::uint32_t level : {250 * x / width, 250 * y / height, 128u}) {
        picture.rgb.push_back(static_cast<std::uint8_t>(level));
      }
    }
  }
  write_image(file, picture);
}

// A COLMAP workspace of photographs of 80 x 60 by one lens, at x = 0, 1, 2 and so on.
std::string camera_line(const std::string& more = "OPENCV 80 60 70 72 41 31 0.01 0 0 0") {
  return "1 " + more + "\n";
}
void write_model(const fs::path& scene, const std::vector<std::string>& names,
                 const std::string& cameras = camera_line()) {
  write_file(scene / "sparse/cameras.txt", cameras);
  std::string images;
  for (std::size_t i = 0; i < names.size(); ++i) {
    images += std::to_string(i + 1) + " 1 0 0 0 -" + std::to_string(i) + " 0 0 1 " + names[i] + "\n\n";
  }
  write_file(scene / "sparse/images.txt", images);
}

SceneViews found_views(const fs::path& scene, const PictureFolders& folders = {}) {
  return read_scene_views(scene, glm::dvec3(0), folders);
}

std::string scene_refusal(const fs::path& scene) {
  try {
    (void)found_views(scene);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

bool has_note(const SceneViews& scene, const std::string& part) {
  return std::any_of(scene.notes.begin(), scene.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

TEST_CASE("photographs are found by their names where another computer's paths lead elsewhere") {
  const std::vector<std::string> paths{"C:\\Users\\me\\scene\\images\\0.png",
                                       "images\\0.png",
                                       "../images/0.png",
                                       "/home/me/scene/0.png",
                                       "0.PNG",
                                       "0.jpg"};
  for (const std::string& path : paths) {
    CAPTURE(path);
    const TemporaryFolder folder;
    write_model(folder.path(), {path, "1.png"});
    write_ramp(folder / "images/0.png", 80, 60);
    write_ramp(folder / "images/1.png", 80, 60);
    const SceneViews scene = found_views(folder.path());
    REQUIRE(scene.views.size() == 2);
    CHECK(scene.views[0].name == "0.png");
    CHECK(scene.views[0].image == folder / "images/0.png");
    CHECK(scene.views[0].camera.center().x == 0);
    if (path.starts_with("..")) continue;  // this one does lead there
    CHECK(has_note(scene, "1 of 2 photographs are not where " + (folder / "sparse/images.txt").string() +
                              " says, but were found in " + (folder / "images").string() +
                              " by their names, of which the first, '" + path + "' is '0.png'"));
  }
}

TEST_CASE("a name's accents may be composed or not, in any script") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"K\u00fcche \u043a\u0443\u0445\u043d\u044f.png"});
  write_ramp(folder / "images/Ku\u0308che \u041a\u0443\u0445\u043d\u044f.png", 80, 60);
  CHECK(found_views(folder.path()).views.at(0).image ==
        folder / "images/Ku\u0308che \u041a\u0443\u0445\u043d\u044f.png");
  CHECK(folded("K\u00dcCHE") == folded("ku\u0308che"));
  CHECK(folded("\xff"
               "A") ==
        "\xff"
        "a");
}

TEST_CASE("a photograph that the form names elsewhere is taken for no other") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"left/0.png", "right/0.png"});
  write_ramp(folder / "images/right/0.png", 80, 60);
  CHECK(scene_refusal(folder.path()) ==
        (folder / "images/left/0.png").string() + ": no such photograph, but image 1 of " +
            (folder / "sparse/images.txt").string() + " names it: name the folder of the photographs with --images");
}

TEST_CASE("no name leads out of the folder of photographs, found or not") {
  for (const auto& [named, name] : std::vector<std::pair<std::string, std::string>>{
           {"../../masks/0.png", "0.png"}, {"/etc/passwd", "passwd"}, {"./a/../2.png", "2.png"}}) {
    CAPTURE(named);
    Capture capture;
    capture.photographs.push_back({named, "images/" + named});
    find_photographs(capture, "model", "/nonexistent", std::nullopt, BadPhotographs::refuse);
    CHECK(capture.photographs.at(0).name == name);
    CHECK(inner_path(capture.photographs.at(0).file.string()));
  }
  Capture capture;
  capture.photographs.push_back({"a/..", "images/.."});
  CHECK_THROWS_WITH(find_photographs(capture, "model", "/nonexistent", std::nullopt, BadPhotographs::refuse),
                    "model: the photograph 'a/..' is no path to a file");
}

TEST_CASE("a name that may be several photographs is refused with two of them, or left out with bad ones") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"0.jpg", "1.png"});
  for (const char* const file : {"images/a/0.png", "images/b/0.png", "images/1.png"}) write_ramp(folder / file, 80, 60);
  CHECK_THAT(scene_refusal(folder.path()),
             Catch::Contains("the photograph '0.jpg' may be 'a/0.png' or 'b/0.png': keep one of them"));
  const SceneViews scene = found_views(folder.path(), {{}, {}, true});
  REQUIRE(scene.views.size() == 2);
  CHECK_THAT(scene.views[0].bad, Catch::Contains("may be 'a/0.png' or 'b/0.png'"));
  CHECK(scene.views[1].bad.empty());
}

TEST_CASE("without images/, photographs are looked for in the scene's folder and those below") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"0.png", "1.png"});
  write_ramp(folder / "0.png", 80, 60);
  write_ramp(folder / "images_2/1.png", 40, 30);
  const SceneViews scene = found_views(folder.path());
  CHECK(scene.views.at(0).image == folder / "0.png");
  CHECK(scene.views.at(1).image == folder / "images_2/1.png");
  CHECK(scene.views.at(1).lens.width == 40);
}

TEST_CASE("points keep the views that saw them when photographs are found under other names") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"C:\\z\\1.png", "0.png"});
  write_file(folder / "sparse/points3D.txt", "1 0 0 5 9 9 9 0.1 1 0\n");
  write_ramp(folder / "images/0.png", 80, 60);
  write_ramp(folder / "images/1.png", 80, 60);
  CHECK(found_views(folder.path()).views.at(1).name == "1.png");
  CHECK(read_scene_points(folder.path(), std::nullopt).views.at(0) == std::vector<std::uint32_t>{1});
}

TEST_CASE("of a photograph that is kept at another size the lens is scaled, each axis by itself") {
  struct Size {
    std::uint32_t width, height;
  };
  for (const Size& size : {Size{40, 30}, Size{27, 20}, Size{160, 120}}) {
    CAPTURE(size.width);
    const TemporaryFolder folder;
    write_model(folder.path(), {"0.png", "1.png"});
    write_ramp(folder / "images/0.png", size.width, size.height);
    write_ramp(folder / "images/1.png", 80, 60);
    const SceneViews scene = found_views(folder.path());
    const SceneView &scaled_view = scene.views.at(0), &whole = scene.views.at(1);
    // The same direction is at the same share of the picture.
    const glm::dvec3 direction(0.2, -0.3, 1);
    const glm::dvec2 there = image_from_cam(whole.lens, direction).value();
    const glm::dvec2 here = image_from_cam(scaled_view.lens, direction).value();
    CHECK(here.x / size.width == Approx(there.x / 80));
    CHECK(here.y / size.height == Approx(there.y / 60));
    CHECK(scaled_view.camera.width == size.width);
    CHECK(scaled_view.camera.center().x == 0);
    CHECK(load_photograph(scaled_view).width == size.width);
    CHECK(has_note(scene, "1 of 2 photographs have another size than the model says, so their lenses are scaled"));
    CHECK(has_note(scene, ": 0.png"));
  }
}

TEST_CASE("a lens of one focal length gets two where its axes are scaled differently") {
  const CameraModel radial{LensModel::kRadial, 160, 120, {100, 80, 60, 0.1, -0.02}};
  const CameraModel third = scaled(radial, 53, 40);
  CHECK(third.model == LensModel::kOpenCv);
  const glm::dvec3 direction(0.3, 0.4, 1);
  const glm::dvec2 there = image_from_cam(radial, direction).value(), here = image_from_cam(third, direction).value();
  CHECK(here.x == Approx(there.x * 53 / 160));
  CHECK(here.y == Approx(there.y * 40 / 120));
  CHECK(scaled(radial, 80, 60).model == LensModel::kRadial);
}

TEST_CASE("pictures of nearly the same size, of other shapes or of a few pixels were not scaled") {
  CHECK(same_shape({40, 30}, {80, 60}));
  CHECK(same_shape({53, 40}, {160, 120}));
  CHECK_FALSE(same_shape({79, 60}, {80, 60}));
  CHECK_FALSE(same_shape({30, 40}, {80, 60}));
  CHECK_FALSE(same_shape({40, 33}, {80, 60}));
  CHECK_FALSE(same_shape({4, 3}, {80, 60}));
}

TEST_CASE("a mask of another size than its photograph is scaled, and told") {
  const TemporaryFolder folder;
  write_model(folder.path(), {"0.png"}, camera_line("PINHOLE 80 60 70 72 41 31"));
  write_ramp(folder / "images/0.png", 80, 60);
  Photograph mask{40, 30, std::vector<std::uint8_t>(3 * 40 * 30, 255), {}};
  std::fill_n(mask.rgb.begin(), 3 * 40 * 15, 0);  // the upper half
  fs::create_directories(folder / "masks");
  write_image(folder / "masks/0.png", mask);
  const SceneViews scene = found_views(folder.path());
  CHECK(has_note(scene, "1 masks have another size than their photographs, and are scaled"));
  const Photograph loaded = load_photograph(scene.views.at(0));
  REQUIRE(loaded.valid.size() == 80 * 60);
  for (std::size_t i = 0; i < loaded.valid.size(); ++i) {
    if ((loaded.valid[i] != 0) != (i / 80 >= 30)) FAIL("pixel " << i);
  }
}

TEST_CASE("with bad ones skipped, a photograph of which the form says what cannot be is left out by name") {
  const TemporaryFolder folder;
  write_file(folder / "sparse/cameras.txt", camera_line() + "2 PINHOLE 80 60 nan 72 41 31\n");
  write_file(folder / "sparse/images.txt",
             "1 1 0 0 0 0 0 0 1 0.png\n\n2 1 0 0 0 0 0 0 2 1.png\n\n3 1 0 0 0 0 -inf 0 1 2.png\n\n4 1 0 0 0 1 0 0 1 "
             "3.png\n\n5 1 0 0 0 2 0 0 1 3.png\n\n");
  for (const char* const name : {"0.png", "1.png", "2.png", "3.png"}) write_ramp(folder / "images" / name, 80, 60);
  CHECK_THAT(scene_refusal(folder.path()), Catch::Contains("line 2: camera 2 (PINHOLE): fx is nan"));
  const SceneViews scene = found_views(folder.path(), {{}, {}, true});
  REQUIRE(scene.views.size() == 4);
  CHECK(scene.views[0].bad.empty());
  CHECK_THAT(scene.views[1].bad, Catch::Contains("camera 2 (PINHOLE): fx is nan"));
  CHECK_THAT(scene.views[2].bad, Catch::Contains("line 5: its translation holds -inf"));
  CHECK(scene.views[3].bad.empty());
  CHECK(scene.views[3].camera.center().x == -1);  // the first of its name
  CHECK(has_note(scene, "names photographs more than once, of which the first is used: '3.png'"));
}

TEST_CASE("of transforms.json a frame that is no number is left out by name with bad ones") {
  const TemporaryFolder folder;
  const std::string identity = "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]", nan = "[[1,0,0,-nan(ind)],[0,1,0,0],[0,0,1,0]]";
  write_file(folder / "transforms.json",
             R"({"w": 80, "h": 60, "fl_x": 70, "frames": [{"file_path": "images/0.png", "transform_matrix": )" +
                 identity + R"(}, {"file_path": "images\\1.png", "transform_matrix": )" + nan + "}]}");
  write_ramp(folder / "images/0.png", 80, 60);
  write_ramp(folder / "images/1.png", 80, 60);
  CHECK_THAT(scene_refusal(folder.path()),
             Catch::Contains("frames[1].transform_matrix[0][3]: is \"-nan(ind)\", must be a number"));
  const SceneViews scene = found_views(folder.path(), {{}, {}, true});
  REQUIRE(scene.views.size() == 2);
  CHECK(scene.views[1].name == "1.png");
  CHECK_THAT(scene.views[1].bad, Catch::Contains("is \"-nan(ind)\""));
}

std::string frames_text(const std::vector<std::string>& files, const std::string& more = "") {
  std::string text = R"({"camera_angle_x": 0.7)" + more + R"(, "frames": [)";
  for (std::size_t i = 0; i < files.size(); ++i) {
    text += std::string(i == 0 ? "" : ", ") + R"({"file_path": ")" + files[i] +
            R"(", "rotation": 0.1, "transform_matrix": [[1,0,0,)" + std::to_string(i) + "],[0,1,0,0],[0,0,1,0]]}";
  }
  return text + "]}";
}

std::vector<std::string> names_to_score(const SceneViews& scene) {
  std::vector<std::string> names;
  for (const SceneView& view : scene.views) {
    if (view.held_out) names.push_back(view.name);
  }
  return names;
}

TEST_CASE("photographs are found through links: to their folder, to a folder in it, and in a circle") {
  const TemporaryFolder card;
  write_ramp(card / "0.png", 80, 60);
  write_ramp(card / "1.png", 80, 60);
  const auto check_found = [&](const fs::path& scene, const std::string& before) {
    const SceneViews found = found_views(scene);
    REQUIRE(found.views.size() == 2);
    CHECK(found.views[0].name == before + "0.png");
    CHECK(fs::equivalent(found.views[1].image, card / "1.png"));
  };
  const TemporaryFolder colmap;
  write_model(colmap.path(), {"0.png", "1.png"});
  fs::create_directory_symlink(card.path(), colmap / "images");
  check_found(colmap.path(), "");
  // Below it, under names that must be looked for.
  const TemporaryFolder below, transforms;
  write_model(below.path(), {"D:\\shots\\0.PNG", "1.jpg"});
  write_file(transforms / "transforms.json", frames_text({"shots/0.png", "shots/1.png"}, R"(, "w": 80, "h": 60)"));
  for (const TemporaryFolder* const folder : {&below, &transforms}) {
    fs::create_directory(*folder / "images");
    fs::create_directory_symlink(card.path(), *folder / "images/card1");
    fs::create_directory_symlink("..", *folder / "images/up");
    check_found(folder->path(), "card1/");
  }
}

TEST_CASE("nerfstudio's list of files to score holds these out") {
  const TemporaryFolder folder;
  write_file(folder / "transforms.json",
             frames_text({"images/a.png", "images/b.png", "images/c.png"},
                         R"(, "train_filenames": ["images/a.png"], "val_filenames": ["images/a.png"],
                             "test_filenames": ["images\\c.png", "images/none.png"])"));
  for (const char* const name : {"a.png", "b.png", "c.png"}) write_ramp(folder / "images" / name, 80, 60);
  const SceneViews scene = found_views(folder.path());
  CHECK(names_to_score(scene) == std::vector<std::string>{"c.png"});
  CHECK(has_note(scene,
                 "1 of 3 photographs are for scoring alone, as test_filenames of transforms.json says, which "
                 "names 2"));
}

TEST_CASE("of Blender's files the training photographs are used, the test's held out") {
  const TemporaryFolder folder;
  write_file(folder / "transforms_train.json", frames_text({"./train/r_0", "./train/r_1"}));
  write_file(folder / "transforms_test.json", frames_text({"./test/r_0"}));
  write_file(folder / "transforms_val.json", frames_text({"./val/r_0"}));
  for (const char* const file : {"train/r_0.png", "train/r_1.png", "test/r_0.png"}) write_ramp(folder / file, 80, 60);
  const SceneViews scene = found_views(folder.path());
  REQUIRE(scene.views.size() == 3);
  CHECK(scene.views[0].name == "test/r_0.png");
  CHECK(names_to_score(scene) == std::vector<std::string>{"test/r_0.png"});
  CHECK(scene.views[2].camera.center().x == 1);
}

TEST_CASE("a full panorama is six views, which show what it shows and share its mask") {
  const TemporaryFolder folder;
  // The camera stands at (1, 2, 3), unturned.
  write_file(folder / "sparse/cameras.txt", "1 EQUIRECTANGULAR 240 120 240 120\n");
  write_file(folder / "sparse/images.txt", "7 1 0 0 0 -1 -2 -3 1 pano.png\n\n");
  write_file(folder / "sparse/points3D.txt", "1 5 2 3 9 9 9 0.1 7 0\n");  // to the right of it
  write_ramp(folder / "images/pano.png", 240, 120);
  Photograph mask{240, 120, std::vector<std::uint8_t>(3 * 240 * 120, 255), {}};
  std::fill_n(mask.rgb.begin(), 3 * 240 * 5, 0);  // about the zenith
  fs::create_directories(folder / "masks");
  write_image(folder / "masks/pano.png", mask);
  const SceneViews scene = found_views(folder.path());
  REQUIRE(scene.views.size() == 6);
  CHECK(has_note(scene, "1 full panoramas are cut into six views each"));
  CHECK_FALSE(has_note(scene, "have no pose"));
  for (const SceneView& view : scene.views) {
    CAPTURE(view.name);
    CHECK(glm::distance(view.camera.center(), {1, 2, 3}) < 1e-9);
    const Photograph picture = load_photograph(view);
    REQUIRE(picture.width == view.camera.width);
    CHECK(picture.valid.empty() == (view.name != "pano.png/up"));
    const std::size_t middle = 3 * (picture.height / 2 * picture.width + picture.width / 2);
    const glm::dvec3 forward =
        glm::transpose(view.camera.cam_from_world_rotation) * glm::dvec3(0, 0, 1);  // of the world and the panorama
    if (std::abs(forward.y) > 0.5) continue;
    const double share = 0.5 + std::atan2(forward.x, forward.z) / (2 * 3.14159265358979);
    const double shown = picture.rgb[middle] / 250.0;
    CHECK(std::min({std::abs(shown - share), std::abs(shown - share - 1), std::abs(shown - share + 1)}) < 0.02);
    CHECK(picture.rgb[middle + 1] == Approx(125).margin(4));
  }
  CHECK(scene.views[4].name == "pano.png/right");
  CHECK(read_scene_points(folder.path(), std::nullopt).views.at(0) == std::vector<std::uint32_t>{4});
}

}  // namespace
}  // namespace lumatlas
