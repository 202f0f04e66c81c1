// SPDX-License-Identifier: GPL-3.0-or-later
// The JSON forms of OpenSfM, OpenMVG and Meshroom on cameras that are written here, and their lenses by the formulas
// that these programs publish.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/fields/json_poses.h"
#include "tools/scene/forms/photogrammetry/meshroom.h"
#include "tools/scene/forms/photogrammetry/openmvg.h"
#include "tools/scene/forms/photogrammetry/opensfm.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr double kJsonRounding = 1e-12;  // double algebra on numbers near 100

std::string json_digits(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

// "[1,2,3]", with numbers as texts if the form has them so.
std::string json_list(const std::vector<double>& values, const char* quote = "") {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ",") + (quote + json_digits(value)) + quote;
  return "[" + text + "]";
}

// One camera: cam = rotation (X - center).
struct JsonCamera {
  glm::dquat rotation;
  glm::dvec3 center;
};

JsonCamera turned_camera() {
  return {glm::normalize(glm::dquat(0.8, -0.3, 0.4, 0.2)), {1, -2, 3.5}};
}

std::vector<double> columns_of(const glm::dmat3& m) {
  return {m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]};
}

std::vector<double> list_of(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

void check_pose(const PosedPhotograph& photograph, const JsonCamera& camera) {
  const glm::dvec3 point(0.3, -0.7, 5);
  const glm::dvec3 expected = camera.rotation * (point - camera.center);
  const glm::dvec3 read = photograph.cam_from_world_rotation * point + photograph.cam_from_world_translation;
  CHECK(glm::distance(read, expected) < kJsonRounding);
}

PhotographLookup by_last_part() {
  return {[](std::string_view label) { return PosedPhotograph{fs::path(label).filename().string()}; },
          [](const PosedPhotograph&) {
            return ImageSize{200, 100};
          }};
}

template <typename Read>
std::string json_refusal(const Read& read) {
  try {
    (void)read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

const glm::dvec3 kSeen(0.3, -0.2, 1.0);  // a direction within all of these lenses
const double kSeenX = 0.3, kSeenY = -0.2, kSeenR2 = 0.13;

void check_image(const CameraModel& lens, const glm::dvec2& expected) {
  const std::optional<glm::dvec2> image = image_from_cam(lens, kSeen);
  REQUIRE(image);
  CHECK(glm::distance(*image, expected) < 1e-10);
}

// OpenCV's tangential terms of the seen point, scaled by `q` from the middle.
glm::dvec2 seen_tangential(double p1, double p2, double q = 1) {
  const double x = q * kSeenX, y = q * kSeenY, r2 = q * q * kSeenR2;
  return {2 * p1 * x * y + p2 * (r2 + 2 * x * x), 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

// The angle of the seen point from the axis over its tangent.
double seen_angle_ratio() {
  return std::atan(std::sqrt(kSeenR2)) / std::sqrt(kSeenR2);
}

// --- OpenSfM

std::string opensfm_pose_keys(const JsonCamera& camera) {
  const glm::dvec3 turn = glm::angle(camera.rotation) * glm::axis(camera.rotation);
  return R"("rotation":)" + json_list(list_of(turn)) + R"(,"translation":)" +
         json_list(list_of(-(camera.rotation * camera.center)));
}

std::string opensfm_shot(const std::string& name,
                         const std::string& more = R"("rotation":[0,0,0],"translation":[0,0,0])") {
  return "\"" + name + R"(":{"camera":"c",)" + more + "}";
}

const std::string kOpenSfmCamera = R"("projection_type":"perspective","width":200,"height":100,"focal":0.5)";

std::string opensfm_text(const std::string& camera = kOpenSfmCamera, const std::string& shots = opensfm_shot("a.jpg"),
                         const std::string& more = "") {
  return R"({"cameras":{"c":{)" + camera + R"(}},"shots":{)" + shots + "}" + more + "}";
}

Capture opensfm_of(const std::string& reconstructions) {
  return parse_opensfm("[" + reconstructions + "]", "r.json", by_last_part());
}

CameraModel opensfm_lens_of(const std::string& camera) {
  return opensfm_of(opensfm_text(camera)).photographs.at(0).lens;
}

std::string opensfm_refusal(const std::string& reconstructions) {
  return json_refusal([&] { return opensfm_of(reconstructions); });
}

TEST_CASE("OpenSfM: a shot turns by its axis and its angle, then moves") {
  const JsonCamera camera = turned_camera();
  const Capture capture = opensfm_of(opensfm_text(kOpenSfmCamera, opensfm_shot("a.jpg", opensfm_pose_keys(camera))));
  REQUIRE(capture.photographs.size() == 1);
  check_pose(capture.photographs[0], camera);
  CHECK(capture.notes.empty());
  check_pose(opensfm_of(opensfm_text()).photographs.at(0), {glm::dquat(1, 0, 0, 0), {0, 0, 0}});
  CHECK(capture.photographs[0].lens == CameraModel{LensModel::kPinhole, 200, 100, {100, 100, 100, 50}});
}

TEST_CASE("OpenSfM: a shot of a rig without a pose of its own has its camera's times its instance's") {
  const JsonCamera rig = turned_camera();
  const JsonCamera in_rig{glm::normalize(glm::dquat(0.5, 0.1, -0.7, 0.2)), {0.2, 0.1, -0.3}};
  const std::string rigs = R"(,"rig_cameras":{"left":{)" + opensfm_pose_keys(in_rig) + R"(}},"rig_instances":{"7":{)" +
                           opensfm_pose_keys(rig) + R"(,"rig_camera_ids":{"a.jpg":"left","b.jpg":"right"}}})";
  const auto shots = [](const std::string& name) { return "\"" + name + R"(":{"camera":"c"})"; };
  const Capture capture = opensfm_of(opensfm_text(kOpenSfmCamera, shots("a.jpg") + "," + shots("c.jpg"), rigs));
  REQUIRE(capture.photographs.size() == 1);
  // cam = R_in (R_rig (X - C_rig) - C_in)
  const glm::dvec3 center = rig.center + glm::inverse(rig.rotation) * in_rig.center;
  check_pose(capture.photographs[0], {in_rig.rotation * rig.rotation, center});
  REQUIRE(capture.notes.size() == 1);
  CHECK(capture.notes[0] == "1 of 2 photographs have no pose and are left out");
  CHECK(capture.left_out == 1);
  CHECK(opensfm_refusal(opensfm_text(kOpenSfmCamera, shots("b.jpg"), rigs)) ==
        "r.json: [0].rig_instances.7.rig_camera_ids.b.jpg: is 'right', which is not in rig_cameras");
}

TEST_CASE("OpenSfM: the reconstruction with the most shots is read, and the others are told") {
  const std::string two = opensfm_shot("a.jpg") + "," + opensfm_shot("b.jpg");
  const Capture capture = opensfm_of(opensfm_text() + "," + opensfm_text(kOpenSfmCamera, two) + "," + opensfm_text());
  CHECK(capture.photographs.size() == 2);
  REQUIRE(capture.notes.size() == 1);
  CHECK(capture.notes[0] ==
        "the largest of its 3 reconstructions is read, with 2 shots; the shots of the others are left out: 1, 1");
  CHECK(capture.left_out == 2);
}

TEST_CASE("OpenSfM: lengths are in units of the longer side, from the middle") {
  const double bend = 1 + 0.1 * kSeenR2 - 0.02 * kSeenR2 * kSeenR2;
  const glm::dvec2 seen(kSeenX, kSeenY);
  check_image(
      opensfm_lens_of(R"("projection_type":"perspective","width":100,"height":200,"focal":0.5,"k1":0.1,"k2":-0.02)"),
      glm::dvec2(50, 100) + 200 * 0.5 * bend * seen);
  const std::string affine = R"("width":200,"height":100,"focal_x":0.5,"focal_y":0.6,"c_x":0.01,"c_y":-0.02)";
  const glm::dvec2 focal(100, 120), middle(102, 46);
  check_image(opensfm_lens_of(affine + R"(,"projection_type":"radial","k1":0.1,"k2":-0.02)"),
              middle + focal * bend * seen);
  check_image(opensfm_lens_of(affine + R"(,"projection_type":"simple_radial","k1":0.1)"),
              middle + focal * (1 + 0.1 * kSeenR2) * seen);
  const double brown = bend + 0.3 * std::pow(kSeenR2, 3);
  check_image(
      opensfm_lens_of(affine + R"(,"projection_type":"brown","k1":0.1,"k2":-0.02,"k3":0.3,"p1":0.01,"p2":-0.03)"),
      middle + focal * (brown * seen + seen_tangential(0.01, -0.03)));
}

TEST_CASE("OpenSfM: fisheyes bend the angle, with tangential and prism terms of the point before that") {
  const double q = seen_angle_ratio(), a2 = q * q * kSeenR2;
  const glm::dvec2 seen = q * glm::dvec2(kSeenX, kSeenY), middle(100, 50);
  const std::string one = R"("width":200,"height":100,"focal":0.5,"k1":0.1,"k2":-0.02)";
  const double bend = 1 + 0.1 * a2 - 0.02 * a2 * a2;
  check_image(opensfm_lens_of(one + R"(,"projection_type":"fisheye")"), middle + 100.0 * bend * seen);
  check_image(opensfm_lens_of(one + R"(,"projection_type":"dual","transition":0)"), middle + 100.0 * bend * seen);
  const glm::dvec2 flat(kSeenX, kSeenY);
  check_image(opensfm_lens_of(one + R"(,"projection_type":"dual","transition":1)"),
              middle + 100.0 * (1 + 0.1 * kSeenR2 - 0.02 * kSeenR2 * kSeenR2) * flat);
  const std::string two =
      R"("width":200,"height":100,"focal_x":0.5,"focal_y":0.5,"k1":0.1,"k2":-0.02,"k3":0.3,"k4":0.4)";
  const double bend4 = bend + 0.3 * std::pow(a2, 3) + 0.4 * std::pow(a2, 4);
  check_image(opensfm_lens_of(two + R"(,"projection_type":"fisheye_opencv")"), middle + 100.0 * bend4 * seen);
  check_image(opensfm_lens_of(two + R"(,"projection_type":"fisheye62","p1":0.01,"p2":-0.03)"),
              middle + 100.0 * (bend4 * seen + seen_tangential(0.01, -0.03, q)));
  check_image(opensfm_lens_of(two + R"(,"projection_type":"fisheye624","p1":0.01,"p2":-0.03,"s0":0.05,"s2":-0.06)"),
              middle + 100.0 * (bend4 * seen + seen_tangential(0.01, -0.03, q) + glm::dvec2(0.05, -0.06) * a2));
  check_image(opensfm_lens_of(two + R"(,"projection_type":"fisheye62","k5":0.5,"k6":-0.6)"),
              middle + 100.0 * (bend4 + 0.5 * std::pow(a2, 5) - 0.6 * std::pow(a2, 6)) * seen);
}

TEST_CASE("OpenSfM: a spherical camera is a panorama of the whole sphere, of the photograph's size if it says none") {
  for (const char* const type : {"spherical", "equirectangular"}) {
    const std::string camera = R"("projection_type":")" + std::string(type) + "\"";
    CHECK(opensfm_lens_of(camera) == CameraModel{LensModel::kEquirectangular, 200, 100, {200, 100}});
    CHECK_THAT(opensfm_refusal(opensfm_text(camera + R"(,"width":200,"height":90)")),
               Catch::Contains("is a panorama of 200x90 pixels, must be twice as wide as high"));
  }
}

TEST_CASE("OpenSfM: a reference on the earth is told, one at 0 degrees is none; unknown keys are told") {
  const auto notes = [](const std::string& more) {
    return opensfm_of(opensfm_text(kOpenSfmCamera, opensfm_shot("a.jpg"), more)).notes;
  };
  CHECK(notes(R"(,"reference_lla":{"latitude":0,"longitude":0,"altitude":0},"points":{})").empty());
  const std::vector<std::string> local = notes(R"(,"reference_lla":{"latitude":52.5,"longitude":-13})");
  REQUIRE(local.size() == 1);
  CHECK_THAT(local[0], Catch::Contains("metres east, north and up of latitude 52.5, longitude -13 and altitude 0"));
  const auto reference = [](const std::string& text) {
    return opensfm_of(opensfm_text(kOpenSfmCamera, opensfm_shot("a.jpg"), R"(,"reference_lla":)" + text)).georeference;
  };
  const GeoReference place{GeoReference::Frame::east_north_up, 52.5, -13, 34.5};
  CHECK(reference(R"({"latitude":52.5,"longitude":-13,"altitude":34.5})") == place);
  CHECK(geo_reference_of(json_of(place)) == place);
  CHECK_FALSE(reference(R"({"latitude":0,"longitude":0,"altitude":0})"));
  CHECK_FALSE(reference(R"({"latitude":91,"longitude":0,"altitude":0})"));
  const std::vector<std::string> unknown = notes(R"(,"warp":[1])");
  REQUIRE(unknown.size() == 1);
  CHECK(unknown[0] == "r.json has keys that are not known and not used: warp");
  const std::vector<std::string> panoramas = notes(R"(,"pano_shots":{"p":{}})");
  REQUIRE(panoramas.size() == 1);
  CHECK_THAT(panoramas[0], Catch::Contains("1 panoramas that OpenSfM made"));
}

TEST_CASE("OpenSfM: what is not read or damaged is refused by file, place and value") {
  const auto lens = [](const std::string& camera) { return opensfm_refusal(opensfm_text(camera)); };
  const auto shot = [](const std::string& pose) {
    return opensfm_refusal(opensfm_text(kOpenSfmCamera, opensfm_shot("a.jpg", pose)));
  };
  CHECK(opensfm_refusal(opensfm_text()) == "taken");
  CHECK(opensfm_refusal("") == "r.json: is no list of reconstructions, as OpenSfM writes them");
  CHECK(opensfm_refusal("1") == "r.json: [0]: must be an object");
  CHECK_THAT(opensfm_refusal("{},{}"), Catch::Contains("[1]: has no \"shots\""));
  CHECK_THAT(opensfm_refusal(opensfm_text(kOpenSfmCamera, "")), Catch::Contains("gives no photograph a pose"));
  CHECK(lens(R"("projection_type":"cylinder")") ==
        "r.json: [0].cameras.c.projection_type: is 'cylinder', which is not read: undistort the photographs (`opensfm "
        "undistort`) and read undistorted/");
  const std::string dual = R"("projection_type":"dual","width":200,"height":100,"focal":0.5)";
  CHECK_THAT(lens(dual + R"(,"transition":0.25)"),
             Catch::Contains("cameras.c: is a dual lens whose transition is 0.25"));
  CHECK_THAT(lens(dual), Catch::Contains("is a dual lens whose transition is 0.5"));
  const std::string fisheye = R"("projection_type":"fisheye624","width":200,"height":100,"focal_x":0.5,"focal_y":0.5)";
  CHECK_THAT(lens(fisheye + R"(,"k5":1,"p1":0.01)"),
             Catch::Contains("c.p1: is 0.01 of a fisheye624, which is not read"));
  CHECK_THAT(lens(fisheye + R"(,"s1":0.5)"), Catch::Contains("c.s1: is 0.5 of a fisheye624, which is not read"));
  CHECK_THAT(lens(kOpenSfmCamera + R"(,"k3":0.5)"), Catch::Contains("c.k3: is not read of a lens of this kind"));
  CHECK(lens(kOpenSfmCamera + R"(,"k3":0)") == "taken");
  CHECK_THAT(lens(R"("width":200,"height":100)"), Catch::Contains("cameras.c: has no \"focal\""));
  CHECK_THAT(lens(R"("width":200,"height":100,"focal":0)"), Catch::Contains("c: has an impossible camera: fx is 0"));
  CHECK_THAT(lens(R"("width":200,"height":100,"focal":NaN)"),
             Catch::Contains("c.focal: is 'NaN', must be a finite number"));
  CHECK_THAT(lens(R"("width":200.5,"height":100,"focal":1)"),
             Catch::Contains("c.width: is 200.5, must be a whole number"));
  CHECK_THAT(shot(R"("rotation":[0,0],"translation":[0,0,0])"),
             Catch::Contains("[0].shots.a.jpg.rotation: has 2 values, must have 3"));
  CHECK_THAT(shot(R"("rotation":[0,0,0])"), Catch::Contains("shots.a.jpg: has no \"translation\""));
  CHECK_THAT(shot(R"("rotation":[0,0,0],"translation":[0,0,1e13])"),
             Catch::Contains("shots.a.jpg: puts the camera at"));
  CHECK(opensfm_refusal(
            opensfm_text(kOpenSfmCamera, R"("a.jpg":{"camera":"d","rotation":[0,0,0],"translation":[0,0,0]})")) ==
        "r.json: [0].shots.a.jpg.camera: is 'd', which is not in cameras");
}

TEST_CASE("OpenSfM: where bad photographs are kept, one with a pose that cannot be says why") {
  PhotographLookup lookup = by_last_part();
  lookup.bad = BadPhotographs::keep;
  const std::string shots =
      opensfm_shot("a.jpg") + "," + opensfm_shot("b.jpg", R"("rotation":[0,0,NaN],"translation":[0,0,0])");
  const Capture capture = parse_opensfm("[" + opensfm_text(kOpenSfmCamera, shots) + "]", "r.json", lookup);
  REQUIRE(capture.photographs.size() == 2);
  CHECK(capture.photographs[0].bad.empty());
  CHECK_THAT(capture.photographs[1].bad, Catch::Contains("b.jpg.rotation[2]: is 'NaN'"));
}

TEST_CASE("OpenSfM: the file is found in the folder or in opensfm/, with the photographs of the folder") {
  const TemporaryFolder folder;
  CHECK(!find_opensfm(folder.path()));
  test::write_file(folder / "opensfm/reconstruction.json", "[" + opensfm_text() + "]");
  test::write_file(folder / "images/sub/a.jpg", "not looked at");
  CHECK(find_opensfm(folder.path()) == folder / "opensfm/reconstruction.json");
  const Capture capture = read_opensfm({folder.path()});
  CHECK(capture.photographs.at(0).name == "sub/a.jpg");
  CHECK(capture.photographs.at(0).file == "images/sub/a.jpg");
}

// --- OpenMVG

std::string openmvg_view(int id, const std::string& file, const std::string& pose, const std::string& intrinsic = "0") {
  return R"({"key":)" + std::to_string(id) + R"(,"value":{"polymorphic_id":1073741824,"ptr_wrapper":{"id":)" +
         std::to_string(2147483649U + static_cast<unsigned>(id)) + R"(,"data":{"local_path":"in","filename":")" + file +
         R"(","width":200,"height":100,"id_view":0,"id_intrinsic":)" + intrinsic + R"(,"id_pose":)" + pose + "}}}}";
}

std::string openmvg_intrinsic(const std::string& name, const std::string& more,
                              const std::string& type = R"("polymorphic_id":2147483649)") {
  const std::string named = name.empty() ? "" : R"(,"polymorphic_name":")" + name + "\"";
  return R"({"key":0,"value":{)" + type + named + R"(,"ptr_wrapper":{"id":2147483700,"data":{)" + more + "}}}}";
}

const std::string kOpenMvgPinhole = R"("width":200,"height":100,"focal_length":90,"principal_point":[101,48])";

std::string openmvg_pose_text(const JsonCamera& camera) {
  const glm::dmat3 rows = glm::transpose(glm::mat3_cast(camera.rotation));
  return R"({"key":0,"value":{"rotation":[)" + json_list(list_of(rows[0])) + "," + json_list(list_of(rows[1])) + "," +
         json_list(list_of(rows[2])) + R"(],"center":)" + json_list(list_of(camera.center)) + "}}";
}

std::string openmvg_text(const std::string& intrinsic = openmvg_intrinsic("pinhole", kOpenMvgPinhole),
                         const std::string& views = openmvg_view(0, "a.jpg", "0"),
                         const std::string& extrinsics = openmvg_pose_text(turned_camera())) {
  return R"({"sfm_data_version":"0.3","root_path":"/set","views":[)" + views + R"(],"intrinsics":[)" + intrinsic +
         R"(],"extrinsics":[)" + extrinsics + R"(],"structure":[],"control_points":[]})";
}

Capture openmvg_of(const std::string& text) {
  return parse_openmvg(text, "s.json", by_last_part());
}

std::string openmvg_refusal(const std::string& text) {
  return json_refusal([&] { return openmvg_of(text); });
}

TEST_CASE("OpenMVG: a pose is a rotation by rows and where the camera stands; views without one are counted") {
  const std::string views = openmvg_view(0, "a.jpg", "0") + "," + openmvg_view(1, "b.jpg", "4294967295") + "," +
                            openmvg_view(2, "c.jpg", "0", "4294967295");
  const Capture capture = openmvg_of(openmvg_text(openmvg_intrinsic("pinhole", kOpenMvgPinhole), views));
  REQUIRE(capture.photographs.size() == 1);
  CHECK(capture.photographs[0].name == "a.jpg");
  check_pose(capture.photographs[0], turned_camera());
  CHECK(capture.photographs[0].lens == CameraModel{LensModel::kPinhole, 200, 100, {90, 90, 101, 48}});
  REQUIRE(capture.notes.size() == 1);
  CHECK(capture.notes[0] == "2 of 3 photographs have no pose or no lens and are left out");
}

TEST_CASE("OpenMVG: a photograph is asked for by root_path, local_path and filename") {
  std::vector<std::string> asked;
  PhotographLookup lookup = by_last_part();
  lookup.find = [&](std::string_view label) {
    asked.emplace_back(label);
    return PosedPhotograph{"a.jpg"};
  };
  (void)parse_openmvg(openmvg_text(), "s.json", lookup);
  CHECK(asked == std::vector<std::string>{"/set/in/a.jpg"});
}

TEST_CASE("OpenMVG: each lens images a point as its formula says") {
  const auto lens = [](const std::string& name, const std::string& more) {
    return openmvg_of(openmvg_text(openmvg_intrinsic(name, kOpenMvgPinhole + more))).photographs.at(0).lens;
  };
  const glm::dvec2 seen(kSeenX, kSeenY), middle(101, 48);
  check_image(lens("pinhole", ""), middle + 90.0 * seen);
  check_image(lens("pinhole_radial_k1", R"(,"disto_k1":[0.1])"), middle + 90.0 * (1 + 0.1 * kSeenR2) * seen);
  const double bend = 1 + 0.1 * kSeenR2 - 0.02 * kSeenR2 * kSeenR2 + 0.3 * std::pow(kSeenR2, 3);
  check_image(lens("pinhole_radial_k3", R"(,"disto_k3":[0.1,-0.02,0.3])"), middle + 90.0 * bend * seen);
  check_image(lens("pinhole_brown_t2", R"(,"disto_t2":[0.1,-0.02,0.3,0.01,-0.03])"),
              middle + 90.0 * (bend * seen + seen_tangential(0.01, -0.03)));
  const double q = seen_angle_ratio(), a2 = q * q * kSeenR2;
  const double angle = q * (1 + 0.1 * a2 - 0.02 * a2 * a2 + 0.3 * std::pow(a2, 3) + 0.4 * std::pow(a2, 4));
  check_image(lens("fisheye", R"(,"fisheye":[0.1,-0.02,0.3,0.4])"), middle + 90.0 * angle * seen);
}

TEST_CASE("OpenMVG: a spherical lens is a panorama, and what was assumed of it is told") {
  for (const char* const size : {R"("width":200,"height":100)", R"("value0":{"width":200,"height":100})"}) {
    const Capture capture = openmvg_of(openmvg_text(openmvg_intrinsic("spherical", size)));
    CHECK(capture.photographs.at(0).lens == CameraModel{LensModel::kEquirectangular, 200, 100, {200, 100}});
    REQUIRE(capture.notes.size() == 1);
    CHECK_THAT(capture.notes[0], Catch::Contains("+y of its spherical cameras is taken to point down"));
  }
}

TEST_CASE("OpenMVG: what cereal wrote once is found again by its number") {
  const std::string first = openmvg_intrinsic("pinhole", kOpenMvgPinhole);
  const std::string second = R"({"key":5,"value":{"polymorphic_id":1,"ptr_wrapper":{"id":52}}})";
  const std::string view = openmvg_view(0, "a.jpg", "0", "5");
  const Capture capture = openmvg_of(openmvg_text(first + "," + second, view));
  CHECK(capture.photographs.at(0).lens.focal_length() == glm::dvec2(90, 90));
  CHECK_THAT(
      openmvg_refusal(openmvg_text(first + "," + R"({"key":5,"value":{"polymorphic_id":2,"ptr_wrapper":{"id":52}}})")),
      Catch::Contains("intrinsics[1].value: has no \"polymorphic_name\", and its polymorphic_id is that of nothing"));
  CHECK_THAT(
      openmvg_refusal(openmvg_text(first + "," + R"({"key":5,"value":{"polymorphic_id":1,"ptr_wrapper":{"id":9}}})")),
      Catch::Contains("value.ptr_wrapper: has no \"data\", and its id is that of nothing before it"));
}

TEST_CASE("OpenMVG: what is not read or damaged is refused by file, place and value") {
  const auto lens = [](const std::string& name, const std::string& data) {
    return openmvg_refusal(openmvg_text(openmvg_intrinsic(name, data)));
  };
  const std::string view = openmvg_view(0, "a.jpg", "0"), pinhole = openmvg_intrinsic("pinhole", kOpenMvgPinhole);
  CHECK(openmvg_refusal("{}") == "s.json: has no sfm_data_version and views, as OpenMVG writes them");
  CHECK_THAT(openmvg_refusal(R"({"sfm_data_version":"1.0","views":[]})"),
             Catch::Contains("sfm_data_version: is \"1.0\", must be one of 0.1, 0.2, 0.3"));
  CHECK_THAT(openmvg_refusal(openmvg_text(pinhole, view, "")), Catch::Contains("gives no photograph a pose"));
  CHECK_THAT(
      lens("pinhole_radial_k1_pba", kOpenMvgPinhole),
      Catch::Contains("ptr_wrapper.data: is a lens of the kind 'pinhole_radial_k1_pba', which is not read: undistort"));
  CHECK_THAT(lens("pinhole", kOpenMvgPinhole + R"(,"disto_k1":[0.1])"),
             Catch::Contains("data.disto_k1: is not read of a lens of this kind"));
  CHECK(lens("pinhole", kOpenMvgPinhole + R"(,"disto_k1":[0])") == "taken");
  CHECK_THAT(lens("pinhole_radial_k3", kOpenMvgPinhole + R"(,"disto_k3":[0.1])"),
             Catch::Contains("data.disto_k3: has 1 values, must have 3"));
  CHECK_THAT(lens("pinhole", R"("width":200,"height":100,"focal_length":-1,"principal_point":[1,1])"),
             Catch::Contains("data: has an impossible camera: fx is -1"));
  CHECK_THAT(lens("spherical", R"("width":200,"height":110)"), Catch::Contains("must be twice as wide as high"));
  const std::string twice = R"({"key":0,"value":{"rotation":[[2,0,0],[0,1,0],[0,0,1]],"center":[0,0,0]}})";
  CHECK_THAT(openmvg_refusal(openmvg_text(pinhole, view, twice)),
             Catch::Contains("s.json: extrinsics[0].value.rotation: does not begin with a rotation"));
  CHECK_THAT(
      openmvg_refusal(openmvg_text(pinhole, view, R"({"key":0,"value":{"rotation":[[1,0,0]],"center":[0,0,0]}})")),
      Catch::Contains("rotation: must have 3 rows"));
}

TEST_CASE("OpenMVG: the file is found by its name, else by what it begins with") {
  const TemporaryFolder folder;
  test::write_file(folder / "a.json", "[]");
  CHECK(!find_openmvg(folder.path()));
  test::write_file(folder / "b.json", openmvg_text());
  CHECK(find_openmvg(folder.path()) == folder / "b.json");
  test::write_file(folder / "sfm_data.json", openmvg_text());
  CHECK(find_openmvg(folder.path()) == folder / "sfm_data.json");
  CHECK(read_openmvg({folder.path()}).photographs.size() == 1);
}

// --- Meshroom

std::string meshroom_view(const std::string& file, const std::string& pose, const std::string& more = "") {
  return R"({"viewId":"1","poseId":")" + pose + R"(","intrinsicId":"7","path":"/set/)" + file +
         R"(","width":"200","height":"100","metadata":"")" + more + "}";
}

std::string meshroom_transform(const JsonCamera& camera, const char* quote = "\"") {
  return R"({"rotation":)" + json_list(columns_of(glm::mat3_cast(camera.rotation)), quote) + R"(,"center":)" +
         json_list(list_of(camera.center), quote) + "}";
}

std::string meshroom_pose_entry(const std::string& id, const std::string& more = "", const char* quote = "\"") {
  return R"({"poseId":")" + id + R"(","pose":{"transform":)" + meshroom_transform(turned_camera(), quote) + more + "}}";
}

const std::string kMeshroomFocal = R"("focalLength":"9","sensorWidth":"18","principalPoint":["1","-2"])";

struct MeshroomText {
  std::string version = R"(["1","2","8"])";
  std::string lens = R"("type":"pinhole",)" + kMeshroomFocal + R"(,"distortionParams":"")";
  std::string views = meshroom_view("a.jpg", "3");
  std::string poses = meshroom_pose_entry("3");
  std::string more = {};

  [[nodiscard]] std::string text() const {
    return R"({"version":)" + version + R"(,"views":[)" + views +
           R"(],"intrinsics":[{"intrinsicId":"7","width":"200","height":"100",)" + lens + R"(}],"poses":[)" + poses +
           "]" + more + "}";
  }
};

Capture meshroom_of(const MeshroomText& text) {
  return parse_meshroom(text.text(), "c.sfm", by_last_part());
}

std::string meshroom_refusal(const MeshroomText& text) {
  return json_refusal([&] { return meshroom_of(text); });
}

CameraModel meshroom_lens_of(const std::string& version, const std::string& lens) {
  return meshroom_of({version, lens}).photographs.at(0).lens;
}

TEST_CASE("Meshroom: a pose is a rotation by columns and where the camera stands, in numbers or in texts") {
  for (const char* const quote : {"\"", ""}) {
    MeshroomText text;
    text.poses = meshroom_pose_entry("3", "", quote);
    const Capture capture = meshroom_of(text);
    REQUIRE(capture.photographs.size() == 1);
    CHECK(capture.photographs[0].name == "a.jpg");
    check_pose(capture.photographs[0], turned_camera());
    CHECK(capture.notes.empty());
    // 9 mm of 18 on 200 pixels, and the principal point from the middle
    CHECK(capture.photographs[0].lens == CameraModel{LensModel::kPinhole, 200, 100, {100, 100, 101, 48}});
  }
}

TEST_CASE("Meshroom: views without a pose, or with a pose that is none or only a rotation, are counted") {
  MeshroomText text;
  text.views = meshroom_view("a.jpg", "3") + "," + meshroom_view("b.jpg", "4") + "," + meshroom_view("c.jpg", "5") +
               "," + meshroom_view("d.jpg", "6");
  text.poses = meshroom_pose_entry("3", R"(,"locked":"0","valid":"1","rotationOnly":"false")") + "," +
               meshroom_pose_entry("5", R"(,"valid":"0")") + "," +
               meshroom_pose_entry("6", R"(,"rotationOnly":"true")");
  const Capture capture = meshroom_of(text);
  CHECK(capture.photographs.size() == 1);
  REQUIRE(capture.notes.size() == 1);
  CHECK(capture.notes[0] == "3 of 4 photographs have no pose or no lens and are left out");
}

// AliceVision keeps such a file of each version to test against: fx 1000, fy 2000, principal point (2020, 1040).
TEST_CASE("Meshroom: focal lengths and principal point are those of the file's version") {
  const auto lens = [](const std::string& version, const std::string& numbers) {
    MeshroomText text{version, R"("type":"pinhole",)" + numbers};
    std::string content = text.text();
    content.replace(content.find(R"("width":"200","height":"100",)" + text.lens), 29,
                    R"("width":"4092","height":"2048",)");
    return parse_meshroom(content, "c.sfm", by_last_part()).photographs.at(0).lens;
  };
  const auto check_lens = [&](const std::string& version, const std::string& numbers, double fx = 1000,
                              double fy = 2000) {
    INFO(version);
    const CameraModel read = lens(version, numbers);
    CHECK(read.width == 4092);
    CHECK(glm::distance(read.focal_length(), glm::dvec2(fx, fy)) < 1e-9);
    CHECK(glm::distance(read.principal_point(), glm::dvec2(2020, 1040)) < 1e-9);
  };
  const std::string corner = R"(,"principalPoint":["2020","1040"])", middle = R"(,"principalPoint":["-26","16"])";
  const std::string x =
      R"("focalLength":")" + json_digits(1000 * 36.0 / 4092) + R"(","sensorWidth":"36","pixelRatio":)";
  const std::string y =
      R"("focalLength":")" + json_digits(2000 * 36.0 / 4092) + R"(","sensorWidth":"36","pixelRatio":)";
  check_lens(R"(["1","0","0"])", R"("pxFocalLength":"1000")" + corner, 1000, 1000);
  check_lens(R"(["1","2","0"])", R"("pxFocalLength":["1000","2000"])" + corner);
  check_lens(R"(["1","2","1"])", R"("pxFocalLength":["1000","2000"])" + middle);
  check_lens("[1,2,3]", x + R"("0.5")" + middle);
  check_lens(R"(["1","2","5"])", x + R"("2")" + middle);
  check_lens(R"(["1","2","8"])", x + R"("2")" + middle);
  check_lens(R"(["1","2","11"])", y + R"("2")" + middle);
  check_lens(R"(["1","2","14"])", y + R"("2")" + middle);
  check_lens(R"(["1","2","10"])", x + R"("1")" + middle, 1000, 1000);
  check_lens(R"(["1","2","8"])", R"("focalLength":")" + json_digits(1000 * 36.0 / 4092) + "\"" + middle, 1000, 1000);
  CHECK_THAT(json_refusal([&] { return lens(R"(["1","2","10"])", x + R"("2")" + middle); }),
             Catch::Contains("pixelRatio: is 2, which versions 1.2.9 and 1.2.10 are read without"));
}

TEST_CASE("Meshroom: each lens images a point as its formula says, by its older name and by its newer one") {
  const auto check_lens = [](const std::string& older, const std::string& newer, const std::string& k,
                             const glm::dvec2& expected) {
    const std::string params = kMeshroomFocal + R"(,"distortionParams":)" + k;
    check_image(meshroom_lens_of(R"(["1","2","5"])", R"("type":")" + older + "\"," + params), expected);
    check_image(
        meshroom_lens_of(R"(["1","2","8"])", R"("type":"pinhole","distortionType":")" + newer +
                                                 R"(","undistortionType":"none","undistortionParams":"",)" + params),
        expected);
  };
  const glm::dvec2 seen(kSeenX, kSeenY), middle(101, 48);
  check_lens("pinhole", "none", R"("")", middle + 100.0 * seen);
  check_lens("radial1", "radialk1", R"(["0.1"])", middle + 100.0 * (1 + 0.1 * kSeenR2) * seen);
  const double bend = 1 + 0.1 * kSeenR2 - 0.02 * kSeenR2 * kSeenR2 + 0.3 * std::pow(kSeenR2, 3);
  check_lens("radial3", "radialk3", R"(["0.1","-0.02","0.3"])", middle + 100.0 * bend * seen);
  check_lens("radial3", "radialk3", R"("")", middle + 100.0 * seen);
  check_lens("brown", "brown", R"(["0.1","-0.02","0.3","0.01","-0.03"])",
             middle + 100.0 * (bend * seen + seen_tangential(0.01, -0.03)));
  const double q = seen_angle_ratio(), a2 = q * q * kSeenR2;
  const double angle = q * (1 + 0.1 * a2 - 0.02 * a2 * a2 + 0.3 * std::pow(a2, 3) + 0.4 * std::pow(a2, 4));
  check_lens("fisheye4", "fisheye", R"(["0.1","-0.02","0.3","0.4"])", middle + 100.0 * angle * seen);
  const double r = std::sqrt(kSeenR2), omega = 0.9;
  check_lens("fisheye1", "fisheye1", R"(["0.9"])",
             middle + 100.0 * (std::atan(2 * r * std::tan(omega / 2)) / omega / r) * seen);
}

TEST_CASE("Meshroom: a panorama of the whole sphere is one, and another is refused") {
  const auto lens = [](double focal_pixels, const char* point) {
    return R"("type":"equirectangular","sensorWidth":"36","focalLength":")" + json_digits(focal_pixels * 36 / 200) +
           R"(","principalPoint":)" + point;
  };
  const std::string version = R"(["1","2","11"])";
  const double whole = 200 / (2 * std::numbers::pi);
  CHECK(meshroom_lens_of(version, lens(whole, R"(["0","0"])")) ==
        CameraModel{LensModel::kEquirectangular, 200, 100, {200, 100}});
  for (const std::string& other : {lens(1.2 * whole, R"(["0","0"])"), lens(whole, R"(["9","0"])")}) {
    CHECK_THAT(meshroom_refusal({version, other}),
               Catch::Contains("c.sfm: intrinsics[0]: is a panorama whose sphere is") &&
                   Catch::Contains("must be the whole picture"));
  }
}

TEST_CASE("Meshroom: a view of a rig has its pose times its rig's, unless it has one of its own") {
  const JsonCamera rig = turned_camera();
  const JsonCamera in_rig{glm::normalize(glm::dquat(0.5, 0.1, -0.7, 0.2)), {0.2, 0.1, -0.3}};
  const std::string other = R"({"status":"uninitialized","pose":)" + meshroom_transform(rig) + "}";
  MeshroomText text;
  text.more = R"(,"rigs":[{"rigId":"9","subPoses":[)" + other + R"(,{"status":"estimated","pose":)" +
              meshroom_transform(in_rig) + "}]}]";
  text.views = meshroom_view("a.jpg", "3", R"(,"rigId":"9","subPoseId":"1","isPoseIndependant":"false")") + "," +
               meshroom_view("b.jpg", "3", R"(,"rigId":"9","subPoseId":"1")");
  const Capture capture = meshroom_of(text);
  REQUIRE(capture.photographs.size() == 2);
  const glm::dvec3 center = rig.center + glm::inverse(rig.rotation) * in_rig.center;
  check_pose(capture.photographs[0], {in_rig.rotation * rig.rotation, center});
  check_pose(capture.photographs[1], rig);
  const auto refused = [&](const std::string& keys) {
    text.views = meshroom_view("a.jpg", "3", keys + R"(,"isPoseIndependant":"0")");
    return meshroom_refusal(text);
  };
  CHECK_THAT(refused(R"(,"rigId":"8","subPoseId":"1")"),
             Catch::Contains("views[0].rigId: is '8', which is not in rigs"));
  CHECK_THAT(refused(R"(,"rigId":"9","subPoseId":"2")"),
             Catch::Contains("subPoseId: is 2, but its rig has 2 subPoses"));
  CHECK_THAT(refused(R"(,"rigId":"9","subPoseId":"0")"), Catch::Contains("subPoses[0]: is uninitialized, but"));
}

TEST_CASE("Meshroom: what is not read or damaged is refused by file, place and value") {
  const auto lens = [](const std::string& text) { return meshroom_refusal({R"(["1","2","8"])", text}); };
  const auto version = [](const std::string& text) { return meshroom_refusal({text}); };
  CHECK(lens(R"("type":"pinhole",)" + kMeshroomFocal) == "taken");
  CHECK(json_refusal([] { return parse_meshroom("{}", "c.sfm", by_last_part()); }) ==
        "c.sfm: has no version and views, as AliceVision writes them");
  CHECK_THAT(version("[2,0,0]"), Catch::Contains("version: begins with 2, but only version 1 is known"));
  CHECK_THAT(version("[1,2]"), Catch::Contains("version: has 2 values, must have 3"));
  CHECK_THAT(version(R"(["1","x","0"])"), Catch::Contains("version[1]: is 'x', must be a finite number"));
  for (const char* const type : {"equidistant", "equidistant_r3", "3deradial4", "3deanamorphic4", "3declassicld"}) {
    CHECK_THAT(
        lens(R"("type":")" + std::string(type) + "\"," + kMeshroomFocal),
        Catch::Contains("c.sfm: intrinsics[0]: is a lens of the kind '" + std::string(type) + "', which is not read"));
  }
  CHECK_THAT(lens(R"("type":"pinhole","distortionType":"radialk3pt",)" + kMeshroomFocal),
             Catch::Contains("is a lens of the kind 'radialk3pt', which is not read: undistort"));
  CHECK_THAT(lens(R"("type":"pinhole","undistortionParams":["0","0.1"],)" + kMeshroomFocal),
             Catch::Contains("undistortionParams: is not read: undistort"));
  CHECK_THAT(lens(R"("type":"radial3","distortionParams":["0.1"],)" + kMeshroomFocal),
             Catch::Contains("distortionParams: has 1 values, must have 3"));
  CHECK_THAT(lens(R"("type":"fisheye1","distortionParams":["-0.1"],)" + kMeshroomFocal),
             Catch::Contains("distortionParams: begins with -0.1, must not be negative"));
  CHECK_THAT(lens(R"("type":"pinhole","squeeze":"2",)" + kMeshroomFocal),
             Catch::Contains("intrinsics[0].squeeze: is not read of a lens of this kind"));
  CHECK_THAT(lens(R"("type":"pinhole","focalLength":"9","sensorWidth":"0","principalPoint":["0","0"])"),
             Catch::Contains("sensorWidth: is 0, must be positive"));
  CHECK_THAT(lens(R"("type":"pinhole","focalLength":"-1","principalPoint":["0","0"])"),
             Catch::Contains("intrinsics[0]: has an impossible camera: fx is -5.5"));
  MeshroomText none;
  none.poses = "";
  CHECK_THAT(meshroom_refusal(none), Catch::Contains("gives no photograph a pose"));
}

TEST_CASE("Meshroom: a newer version and unknown words are told") {
  const Capture capture = meshroom_of({R"(["1","3","0"])", R"("type":"pinhole","mood":"good",)" + kMeshroomFocal});
  REQUIRE(capture.notes.size() == 2);
  CHECK(capture.notes[0] == "it is of version 1.3.0, and is read as version 1.2.14, the newest that is known");
  CHECK(capture.notes[1] == "c.sfm has keys that are not known and not used: mood");
}

TEST_CASE("Meshroom: cameras.sfm is found first, then another .sfm, then a .json that begins so") {
  const TemporaryFolder folder;
  test::write_file(folder / "a.json", R"({"version":1})");
  CHECK(!find_meshroom(folder.path()));
  for (const char* const file : {"b.json", "z.sfm", "cameras.sfm"}) {
    test::write_file(folder / file, MeshroomText{}.text());
    CHECK(find_meshroom(folder.path()) == folder / file);
  }
  CHECK(read_meshroom({folder.path()}).photographs.size() == 1);
}

TEST_CASE("numbers of JSON may be texts, and ids may be numbers") {
  const nlohmann::json value = parse_json(R"([1.5, "1.5", "x", "inf", 7, "7", -1, true, "false", "1", 2])", "f");
  const std::vector<JsonPlace> places = JsonPlace("f", "", value).elements();
  CHECK(number_in(places[0]) == 1.5);
  CHECK(number_in(places[1]) == 1.5);
  CHECK(json_refusal([&] { return number_in(places[2]); }) == "f: [2]: is 'x', must be a finite number");
  CHECK(json_refusal([&] { return number_in(places[3]); }) == "f: [3]: is 'inf', must be a finite number");
  CHECK(id_in(places[4]) == "7");
  CHECK(id_in(places[5]) == "7");
  CHECK(json_refusal([&] { return id_in(places[6]); }) == "f: [6]: is -1, must be a whole number from 0 on");
  CHECK(flag_in(places[7]));
  CHECK(!flag_in(places[8]));
  CHECK(flag_in(places[9]));
  CHECK(json_refusal([&] { return flag_in(places[10]); }) == "f: [10]: is 2, must be 0 or 1");
  CHECK(json_refusal([&] { return pixels_in(places[0]); }) == "f: [0]: is 1.5, must be a whole number in [1, 65536]");
}

}  // namespace
}  // namespace lumatlas
