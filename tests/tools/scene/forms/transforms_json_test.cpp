// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/transforms_json.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <sstream>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::write_file;

const std::string kIdentity = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
const std::string kSize = R"("w": 40, "h": 30, "fl_x": 50)";

Capture parsed(const std::string& text) {
  return parse_transforms(text, "transforms.json",
                          {[](const fs::path& file) { return file; },
                           [](const PosedPhotograph&) {
                             return ImageSize{64, 48};
                           }});
}

std::string frame(const std::string& file, const std::string& matrix, const std::string& more = "") {
  std::ostringstream text;
  text << R"({"file_path": ")" << file << R"(", "transform_matrix": )" << matrix << (more.empty() ? "" : ", ") << more
       << '}';
  return text.str();
}

Capture one_frame(const std::string& matrix, const std::string& more = kSize) {
  return parsed("{\"frames\": [" + frame("images/a.png", matrix, more) + "]}");
}

glm::dvec3 in_camera(const Capture& transforms, const glm::dvec3& world) {
  const PosedPhotograph& f = transforms.photographs.at(0);
  return f.cam_from_world_rotation * world + f.cam_from_world_translation;
}

std::string complaint(const std::string& text) {
  try {
    (void)parsed(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST_CASE("OpenGL's camera looks along -z with y up, lumatlas's along z with y down") {
  const Capture t = one_frame(kIdentity);
  CHECK(in_camera(t, {0, 0, -7}) == glm::dvec3(0, 0, 7));
  CHECK(in_camera(t, {2, 3, -7}) == glm::dvec3(2, -3, 7));
  // At (10, 20, 30), looking along the world's x, with its z up: right is -y, up is z, backward is -x.
  const Capture turned = one_frame("[[0,0,-1,10],[-1,0,0,20],[0,1,0,30]]");
  CHECK(glm::distance(in_camera(turned, {15, 20, 30}), {0, 0, 5}) < 1e-12);
  CHECK(glm::distance(in_camera(turned, {15, 19, 32}), {1, -2, 5}) < 1e-12);
}

TEST_CASE("a lens is the frame's or the file's, and what is not said is as usual") {
  const Capture t = parsed(R"({"w": 100, "h": 80.0, "fl_x": 90, "k1": 0.1, "frames": [)" +
                           frame("images/b.png", kIdentity, R"("fl_x": 95, "fl_y": 96, "cx": 51.5, "cy": 39)") + "," +
                           frame("./images/a.png", kIdentity) + "]}");
  REQUIRE(t.photographs.size() == 2);
  CHECK(t.photographs[0].name == "a.png");
  CHECK(t.photographs[0].file == "images/a.png");
  const CameraModel& a = t.photographs[0].lens;
  CHECK(a.model == LensModel::kOpenCv);
  CHECK(a.width == 100);
  CHECK(a.height == 80);
  CHECK(a.focal_length() == glm::dvec2(90, 90));
  CHECK(a.principal_point() == glm::dvec2(50, 40));  // the middle, counted from the corner
  CHECK(a.parameters[4] == 0.1);
  CHECK(t.photographs[1].lens.focal_length() == glm::dvec2(95, 96));
  CHECK(t.photographs[1].lens.principal_point() == glm::dvec2(51.5, 39));
}

TEST_CASE("a field of view is turned into a focal length, and a size that is missing is the photograph's") {
  const CameraModel lens = one_frame(kIdentity, R"("camera_angle_x": 1.5707963267948966)").photographs[0].lens;
  CHECK(lens.width == 64);
  CHECK(lens.height == 48);
  CHECK(lens.focal_length().x == Approx(32));
  CHECK(lens.focal_length().y == Approx(32));
  CHECK(lens.model == LensModel::kPinhole);
}

TEST_CASE("coefficients go to the model of COLMAP that has them") {
  const auto lens = [](const std::string& more) {
    return one_frame(kIdentity, kSize + ", " + more).photographs[0].lens;
  };
  const CameraModel tangential = lens(R"("k1": 1e-2, "k2": 2e-2, "p1": 3e-3, "p2": 4e-3)");
  CHECK(tangential.model == LensModel::kOpenCv);
  CHECK(tangential.parameters[5] == 0.02);
  CHECK(tangential.parameters[6] == 0.003);
  CHECK(tangential.parameters[7] == 0.004);
  const CameraModel third = lens(R"("k1": 1e-2, "k3": 5e-3, "p2": 4e-3)");
  CHECK(third.model == LensModel::kFullOpenCv);
  CHECK(third.parameters[7] == 0.004);
  CHECK(third.parameters[8] == 0.005);
  const CameraModel full = lens(R"("camera_model": "FULL_OPENCV", "k1": 1e-2, "k3": 5e-3, "k4": 6e-3, "k6": 7e-3)");
  CHECK(full.model == LensModel::kFullOpenCv);
  CHECK(full.parameters[8] == 0.005);
  CHECK(full.parameters[9] == 0.006);
  CHECK(full.parameters[11] == 0.007);
  for (const char* const fisheye : {R"("is_fisheye": true)", R"("camera_model": "OPENCV_FISHEYE")"}) {
    const CameraModel fish = lens(std::string(fisheye) + R"(, "k1": 1e-2, "k2": 2e-2, "k3": 5e-3, "k4": 6e-3)");
    CHECK(fish.model == LensModel::kOpenCvFisheye);
    CHECK(fish.parameters[5] == 0.02);
    CHECK(fish.parameters[7] == 0.006);
  }
  CHECK(lens(R"("camera_model": "OPENCV", "k1": 0)").model == LensModel::kPinhole);
}

TEST_CASE("k4 stands before r^8, as in nerfstudio, unless the model is OpenCV's full one") {
  const CameraModel lens = one_frame(kIdentity, kSize + R"(, "k1": 0.1, "k4": 0.2)").photographs[0].lens;
  const std::optional<glm::dvec2> image = image_from_cam(lens, {0.5, 0, 1});
  REQUIRE(image);
  CHECK(image->x == Approx(20 + 50 * 0.5 * (1 + 0.1 * 0.25 + 0.2 * std::pow(0.25, 4))));
  CHECK(image->y == Approx(15));
}

TEST_CASE("a camera model that is not known is refused by its name, of the file and of a frame") {
  const auto of_frame = [](const std::string& model, const std::string& more = "") {
    return complaint("{\"frames\": [" +
                     frame("a.png", kIdentity, kSize + R"(, "camera_model": ")" + model + "\"" + more) + "]}");
  };
  for (const char* const model :
       {"SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV", "OPENCV_FISHEYE"}) {
    CHECK(of_frame(model) == "taken");
  }
  for (const char* const model :
       {"FISHEYE624", "ORTHOPHOTO", "OMNIDIRECTIONALSTEREO_L", "VR180_L", "SIMPLE_DIVISION", "opencv", "PINHOLE2"}) {
    CAPTURE(model);
    CHECK_THAT(of_frame(model), Catch::StartsWith("transforms.json: frames[0].camera_model: is '" + std::string(model) +
                                                  "', which this program does not read"));
    CHECK_THAT(complaint(R"({"camera_model": ")" + std::string(model) + R"(", )" + kSize + ", \"frames\": [" +
                         frame("a.png", kIdentity) + "]}"),
               Catch::StartsWith("transforms.json: camera_model: is '" + std::string(model) + "'"));
  }
  CHECK(of_frame("EQUIRECTANGULAR") == "taken");
  CHECK_THAT(of_frame("PINHOLE", R"(, "is_fisheye": true)"),
             Catch::Contains("camera_model: is 'PINHOLE', but is_fisheye is true: keep one of them"));
  CHECK(of_frame("OPENCV_FISHEYE", R"(, "is_fisheye": true)") == "taken");
}

TEST_CASE("a coefficient that the lens has no place for is refused unless it is 0") {
  const auto of_frame = [](const std::string& more) {
    return complaint("{\"frames\": [" + frame("a.png", kIdentity, kSize + ", " + more) + "]}");
  };
  for (const char* const key : {"k5", "k6", "p3", "s1", "b2", "skew", "omega"}) {
    CAPTURE(key);
    CHECK(of_frame("\"" + std::string(key) + "\": 0.0") == "taken");
    CHECK_THAT(of_frame("\"" + std::string(key) + "\": 0.01"),
               Catch::StartsWith("transforms.json: frames[0]." + std::string(key) +
                                 ": is a coefficient that this program does not read"));
  }
  CHECK_THAT(of_frame(R"("distortion_params": [0.1, 0])"), Catch::Contains("frames[0].distortion_params: is a"));
  CHECK(of_frame(R"("distortion_params": [0, 0.0])") == "taken");
  CHECK_THAT(of_frame(R"("camera_model": "OPENCV_FISHEYE", "p1": 0.1)"), Catch::Contains("frames[0].p1: is a"));
  CHECK_THAT(complaint(R"({"k6": 0.5, "frames": [)" + frame("a.png", kIdentity, kSize) + "]}"),
             Catch::StartsWith("transforms.json: k6: is a coefficient"));
}

TEST_CASE("a matrix whose last row is not 0 0 0 1 is refused: written by columns it would put all cameras at 0") {
  const std::string by_columns = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[5,6,7,1]]";
  CHECK_THAT(complaint("{\"frames\": [" + frame("a.png", by_columns, kSize) + "]}"),
             Catch::Contains("frames[0].transform_matrix: its last row is 5 6 7 1, must be 0 0 0 1: it is written by "
                             "columns"));
  CHECK_THAT(complaint("{\"frames\": [" + frame("a.png", "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]", kSize) + "]}"),
             Catch::Contains("its last row is 0 0 0 2, must be 0 0 0 1"));
}

TEST_CASE("keys that are not known are told in one line, those that change nothing are not") {
  const std::string known = R"("aabb_scale": 16, "colmap_im_id": 3, "sharpness": 4.5, "applied_transform": [1])";
  CHECK(one_frame(kIdentity, kSize + ", " + known).notes.empty());
  const std::vector<std::string> notes =
      parsed(R"({"pose_convention": "opencv", "up_axis": "z", "frames": [)" +
             frame("a.png", kIdentity, kSize + R"(, "rolling_shutter": [0, 0, 1, 0])") + "," +
             frame("b.png", kIdentity, kSize + R"(, "rolling_shutter": [0, 0, 1, 0])") + "]}")
          .notes;
  REQUIRE(notes.size() == 1);
  CHECK(notes[0] ==
        "transforms.json has keys that are not known and not used: pose_convention, rolling_shutter, up_axis");
}

TEST_CASE("what cannot be gets a sentence with its place") {
  const auto frames = [](const std::string& inner) { return "{\"frames\": [" + inner + "]}"; };
  CHECK(complaint("[]") == "transforms.json: has no list of frames");
  CHECK(complaint(frames("")) == "transforms.json: gives no photograph a pose, so there is nothing to see");
  CHECK_THAT(complaint("{\"frames\": 3}"), Catch::StartsWith("transforms.json: frames"));
  CHECK_THAT(complaint(frames("7")), Catch::Contains("frames[0]") && Catch::Contains("file_path and transform_matrix"));
  CHECK_THAT(complaint(frames(frame("a.png", kIdentity, kSize + R"(, "mask_path": "/etc/m.png")"))),
             Catch::Contains("frames[0].mask_path: is '/etc/m.png', and no end of this path is a file"));
  CHECK_THAT(complaint(frames(frame("a.png", "[[1,0,0,NaN],[0,1,0,0],[0,0,1,0]]", kSize))),
             Catch::Contains("frames[0].transform_matrix[0][3]: is \"NaN\", must be a number"));
  CHECK_THAT(complaint(frames(frame("a.png", kIdentity))), Catch::Contains("has no focal length"));
  CHECK_THAT(complaint(frames(frame("a.png", kIdentity, R"("w": 0, "h": 3, "fl_x": 1)"))),
             Catch::Contains("frames[0]") && Catch::Contains("is 0, must be a whole number in [1, 65536]"));
  CHECK_THAT(complaint(frames(frame("a.png", kIdentity, R"("w": 4, "h": 3, "fl_x": -1)"))),
             Catch::Contains("an impossible camera"));
  CHECK_THAT(complaint(frames(frame("a.png", "[[2,0,0,0],[0,2,0,0],[0,0,2,0]]", kSize))),
             Catch::Contains("does not begin with a rotation"));
  CHECK_THAT(complaint(frames(frame("a.png", "[[1,0,0,0],[0,1,0,0],[0,0,-1,0]]", kSize))),
             Catch::Contains("mirrors the camera"));
  CHECK_THAT(complaint(frames(frame("a.png", "[[1,0,0,2e12],[0,1,0,0],[0,0,1,0]]", kSize))),
             Catch::Contains("within 1e12"));
  CHECK_THAT(complaint(frames(frame("a.png", "[[1,0,0],[0,1,0],[0,0,1]]", kSize))), Catch::Contains("4 numbers"));
  CHECK_THAT(complaint(frames(frame("a.png", "[]", kSize))), Catch::Contains("has 0 rows"));
  CHECK(complaint(frames(frame("images/a.png", kIdentity, kSize) + "," + frame("a.png", kIdentity, kSize))) ==
        "transforms.json: two frames have the photograph 'a.png'");
}

// The same two photographs as a COLMAP workspace and as transforms.json.
void write_both(const fs::path& colmap, const fs::path& transforms) {
  for (const fs::path& folder : {colmap, transforms}) {
    fs::create_directories(folder / "images");
    for (const char* const name : {"a.png", "b.png"}) {
      Photograph picture{40, 30, {}, {}};
      for (std::uint32_t i = 0; i < 3 * 40 * 30; ++i) picture.rgb.push_back(static_cast<std::uint8_t>(i * 7 % 251));
      write_image(folder / "images" / name, picture);
    }
  }
  // b: turned by 90 degrees about the camera's y (down), at (1, 2, 3).
  const double s = std::sqrt(0.5);
  const glm::dmat3 turned = glm::mat3_cast(glm::dquat(s, 0, s, 0));
  const glm::dvec3 t = -(turned * glm::dvec3(1, 2, 3));
  write_file(colmap / "sparse/cameras.bin",
             Bytes().u64(1).camera(1, 4, 40, 30, {50, 52, 21, 14, -0.1, 0.01, 0.001, 0.002}).string());
  write_file(colmap / "sparse/images.bin", Bytes()
                                               .u64(2)
                                               .image(1, {1, 0, 0, 0}, {0, 0, 0}, 1, "a.png")
                                               .image(2, {s, 0, s, 0}, {t.x, t.y, t.z}, 1, "b.png")
                                               .string());
  const glm::dmat3 world = glm::transpose(turned);  // columns: right, down, forward in the world
  std::ostringstream rows;
  rows << '[';
  for (int row = 0; row < 3; ++row) {
    rows << '[' << world[0][row] << ',' << -world[1][row] << ',' << -world[2][row] << ',' << row + 1 << "],";
  }
  rows << "[0,0,0,1]]";
  std::ostringstream json;
  json << R"({"camera_model": "OPENCV", "w": 40, "h": 30, "fl_x": 50, "fl_y": 52, "cx": 21, "cy": 14, "k1": -0.1,
             "k2": 0.01, "p1": 0.001, "p2": 0.002, "ply_file_path": "points.ply", "frames": [)"
       << frame("images/b", rows.str(), R"("mask_path": "masks/b.png")") << ','
       << frame("images/a.png", "[[1,0,0,0],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]") << "]}";
  write_file(transforms / "transforms.json", json.str());
  write_file(transforms / "points.ply",
             "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
             "end_header\n1 2 3\n");
}

TEST_CASE("a scene from transforms.json is the one from COLMAP's files: views, poses and photographs") {
  const TemporaryFolder colmap, folder;
  write_both(colmap.path(), folder.path());
  const glm::dvec3 offset(0.5, 0, -1);
  const SceneViews expected = read_scene_views(colmap.path(), offset), read = read_scene_views(folder.path(), offset);
  REQUIRE(read.views.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const SceneView& a = expected.views[i];
    const SceneView& b = read.views[i];
    CHECK(a.name == b.name);
    CHECK(a.lens == b.lens);
    CHECK(glm::distance(a.camera.center(), b.camera.center()) < 1e-6);
    for (int column = 0; column < 3; ++column) {
      CHECK(glm::distance(a.camera.cam_from_world_rotation[column], b.camera.cam_from_world_rotation[column]) < 1e-6);
    }
    CHECK(load_photograph(a).rgb == load_photograph({b.name, b.image, b.lens, b.orientation, b.camera}).rgb);
  }
  CHECK(read.views[1].image == folder / "images/b.png");  // whose ending was left out
  CHECK(read.views[1].mask == folder / "masks/b.png");
  CHECK(read_scene_points(folder.path(), {}).positions.at(0) == glm::dvec3(1, 2, 3));
}

TEST_CASE("COLMAP's model goes before transforms.json beside it") {
  const TemporaryFolder folder;
  write_both(folder.path(), folder.path());
  CHECK_FALSE(read_scene_views(folder.path(), glm::dvec3(0)).views[1].mask.has_value());
}

}  // namespace
}  // namespace lumatlas
