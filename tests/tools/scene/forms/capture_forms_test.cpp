// SPDX-License-Identifier: GPL-3.0-or-later
// Each form of capture against COLMAP's form of the same scene, and its conventions on cases that are worked by hand.
#include "tools/scene/forms/capture_forms.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/photogrammetry/metashape.h"
#include "tools/scene/forms/photogrammetry/openmvs.h"
#include "tools/scene/forms/photogrammetry/reality_capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"
#include "tools/scene/forms/polycam.h"
#include "tools/scene/forms/scannet.h"
#include "tools/scene/forms/tum_rgbd.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::Bytes;
using test::write_file;

// One camera of the scene that every form is written of, as a program knows it: axes in the world and its place.
struct Posed {
  std::string name;
  glm::dmat3 world_from_cam;  // columns: right, down, forward
  glm::dvec3 center;
};

// The first is as the world is; the second looks elsewhere by angles that are not round.
std::vector<Posed> two_cameras() {
  const glm::dquat turn = glm::normalize(glm::dquat(0.8, -0.3, 0.4, 0.2));
  return {{"a.png", glm::dmat3(1), {0, 0, 0}}, {"b.png", glm::mat3_cast(turn), {1, -2, 3.5}}};
}

constexpr std::uint32_t kWidth = 40, kHeight = 30;
const std::vector<double> kPinhole{50, 52, 21, 14};
const std::vector<double> kDistorted{50, 52, 21, 14, -0.1, 0.01, 0.001, 0.002};

void write_picture(const fs::path& path) {
  fs::create_directories(path.parent_path());
  write_image(path, Photograph{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t{3} * kWidth * kHeight, 90), {}});
}

void write_photographs(const fs::path& folder) {
  for (const Posed& posed : two_cameras()) write_picture(folder / posed.name);
}

void write_colmap(const fs::path& scene, const std::vector<double>& lens) {
  write_photographs(scene / "images");
  Bytes cameras;
  cameras.u64(1).u32(1).i32(lens.size() == 4 ? 1 : lens.size() == 8 ? 4 : 6).u64(kWidth).u64(kHeight);
  for (const double value : lens) cameras.f64({value});
  write_file(scene / "sparse/cameras.bin", cameras.string());
  Bytes images;
  images.u64(2);
  for (const Posed& posed : two_cameras()) {
    const glm::dmat3 cam_from_world = glm::transpose(posed.world_from_cam);
    const glm::dquat q = glm::quat_cast(cam_from_world);
    const glm::dvec3 t = -(cam_from_world * posed.center);
    images.image(posed.name == "a.png" ? 1 : 2, {q.w, q.x, q.y, q.z}, {t.x, t.y, t.z}, 1, posed.name);
  }
  write_file(scene / "sparse/images.bin", images.string());
}

// The rounding of a form's digits.
constexpr double kRounding = 1e-9;

void check_same_cameras(const SceneViews& read, const SceneViews& expected, double rounding = kRounding) {
  REQUIRE(read.views.size() == expected.views.size());
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const SceneView& a = read.views[i];
    const SceneView& b = expected.views[i];
    CHECK(a.name == b.name);
    CHECK(a.lens.model == b.lens.model);
    CHECK(a.lens.width == b.lens.width);
    CHECK(a.lens.height == b.lens.height);
    for (std::size_t p = 0; p < a.lens.parameters.size(); ++p) {
      CHECK(std::abs(a.lens.parameters[p] - b.lens.parameters[p]) < rounding);
    }
    CHECK(glm::distance(a.camera.center(), b.camera.center()) < rounding);
    for (int column = 0; column < 3; ++column) {
      CHECK(glm::distance(a.camera.cam_from_world_rotation[column], b.camera.cam_from_world_rotation[column]) <
            rounding);
    }
  }
}

SceneViews colmap_scene(const std::vector<double>& lens) {
  const TemporaryFolder folder;
  write_colmap(folder.path(), lens);
  return read_scene_views(folder.path(), glm::dvec3(0));
}

// How a reader refuses, or "taken".
template <typename Read>
std::string refusal(const Read& read) {
  try {
    (void)read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

std::string digits(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

void append(std::string& text, char separator, double value) {
  text += separator;
  text += digits(value);
}

std::string matrix_rows(const glm::dmat3& axes, const glm::dvec3& center) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) text += digits(axes[column][row]) + " ";
    text += digits(center[row]) + "\n";
  }
  return text + "0 0 0 1\n";
}

ImageSize small(const PosedPhotograph&) {
  return {kWidth, kHeight};
}

// --- TUM RGB-D

void write_tum(const fs::path& scene) {
  write_photographs(scene / "rgb");
  std::string list = "# timestamp filename\n", trajectory = "# timestamp tx ty tz qx qy qz qw\n";
  double time = 1305031102.175304;
  for (const Posed& posed : two_cameras()) {
    const glm::dquat q = glm::quat_cast(posed.world_from_cam);
    list += digits(time) + " rgb/" + posed.name + "\n";
    // The pose before it is further away in time, and would be wrong.
    trajectory += digits(time - 0.019) + " 9 9 9 0 0 0 1\n" + digits(time + 0.011);
    for (const double value : {posed.center.x, posed.center.y, posed.center.z, q.x, q.y, q.z, q.w}) {
      append(trajectory, ' ', value);
    }
    trajectory += "\n";
    time += 1;
  }
  write_file(scene / "rgb.txt", list);
  write_file(scene / "groundtruth.txt", trajectory);
  // The middle of the first pixel is at (0, 0).
  write_file(scene / "camera.txt", "50 52 20.5 13.5 -0.1 0.01 0.001 0.002\n");
}

TEST_CASE("a TUM RGB-D folder gives the cameras of COLMAP's form") {
  const TemporaryFolder folder;
  write_tum(folder.path());
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(read.form == "TUM RGB-D");
  CHECK(read.notes.empty());
  CHECK(read.views[1].image == folder / "rgb/b.png");
  check_same_cameras(read, colmap_scene(kDistorted));
}

TEST_CASE("TUM: a photograph without a pose within 20 ms is left out and counted, none is interpolated") {
  TumFiles files{"scene", "1.0 rgb/a.png\n1.1 rgb/b.png\n1.2 rgb/c.png\n",
                 "1.0 0 0 0 0 0 0 1\n1.019 1 0 0 0 0 0 1\n1.121 2 0 0 0 0 0 1\n1.1801 3 0 0 0 0 0 1\n", "1 1 1 1"};
  const Capture posed = parse_tum(files, small);
  REQUIRE(posed.photographs.size() == 2);
  CHECK(posed.photographs[1].name == "c.png");
  CHECK(posed.photographs[1].cam_from_world_translation == glm::dvec3(-3, 0, 0));
  REQUIRE(posed.notes.size() == 1);
  CHECK(posed.notes[0] == "1 of 3 photographs have no pose within 20 ms in groundtruth.txt and are left out");
}

TEST_CASE("TUM: the published lens is taken by the folder's name, said, and for no other folder") {
  TumFiles files{"/data/rgbd_dataset_freiburg2_desk/", "1 rgb/a.png\n", "1 0 0 0 0 0 0 1\n"};
  const auto kinect = [](const PosedPhotograph&) { return ImageSize{640, 480}; };
  const Capture posed = parse_tum(files, kinect);
  CHECK(posed.photographs[0].lens.principal_point() == glm::dvec2(325.6, 250.2));
  CHECK(posed.photographs[0].lens.model == LensModel::kFullOpenCv);
  REQUIRE(posed.notes.size() == 1);
  CHECK_THAT(posed.notes[0], Catch::Contains("published for freiburg2"));
  CHECK_THAT(refusal([&] { return parse_tum(files, small); }), Catch::Contains("camera.txt: no such file"));
  files.folder = "mine";
  CHECK_THAT(refusal([&] { return parse_tum(files, kinect); }), Catch::Contains("write fx fy cx cy"));
}

TEST_CASE("TUM: what is damaged is refused by file and line") {
  const auto refused = [](const std::string& rgb, const std::string& truth, const std::string& camera = "1 1 1 1") {
    return refusal([&] { return parse_tum({"s", rgb, truth, camera}, small); });
  };
  const std::string one = "1 a.png\n", pose = "1 0 0 0 0 0 0 1\n";
  CHECK(refused(one, pose) == "taken");
  CHECK(refused(one, "1 0 0 0 0 0 0\n") == "s/groundtruth.txt: line 1: has 7 values, must have 8 or more");
  CHECK_THAT(refused(one, "1 0 0 0 0 0 0 2\n"), Catch::Contains("line 1: has a quaternion that is not of length 1"));
  CHECK_THAT(refused(one, "1 0 2e12 0 0 0 0 1\n"),
             Catch::Contains("s/groundtruth.txt: line 1") && Catch::Contains("1e12"));
  CHECK_THAT(refused("1 ../a.png\n", pose), Catch::Contains("s/rgb.txt: line 1: names '../a.png'"));
  CHECK_THAT(refused("x a.png\n", pose), Catch::Contains("s/rgb.txt: line 1"));
  CHECK_THAT(refused("9 a.png\n", pose), Catch::Contains("gives no photograph a pose"));
  CHECK_THAT(refused(one + one, pose), Catch::Contains("two frames have the photograph 'a.png'"));
  CHECK_THAT(refused(one, "1 0 0 0 0 0 0 1 9\n"),
             Catch::Contains("groundtruth.txt: line 1: has 9 values, must have 8"));
  CHECK_THAT(refused(one, pose, "1 1 1 1\n0.1 0 0 0\n"), Catch::Contains("s/camera.txt: line 2: is one line too many"));
  CHECK_THAT(refused(one, pose, "1 1 1"), Catch::Contains("s/camera.txt: line 1: has 3 values"));
  CHECK_THAT(refused(one, pose, "0 1 1 1"), Catch::Contains("s/camera.txt: an impossible camera"));
}

// --- ScanNet

void write_scannet(const fs::path& scene) {
  write_photographs(scene / "color");
  for (const Posed& posed : two_cameras()) {
    write_file(scene / "pose" / (posed.name.substr(0, 1) + ".txt"), matrix_rows(posed.world_from_cam, posed.center));
  }
  write_file(scene / "intrinsic/intrinsic_color.txt", "50 0 20.5 0\n0 52 13.5 0\n0 0 1 0\n0 0 0 1\n");
}

TEST_CASE("a ScanNet folder gives the cameras of COLMAP's form, and lost poses are left out and counted") {
  const TemporaryFolder folder;
  write_scannet(folder.path());
  write_picture(folder / "color/lost.png");
  std::string lost;
  for (int i = 0; i < 16; ++i) lost += "-inf ";
  write_file(folder / "pose/lost.txt", lost);
  write_picture(folder / "color/unknown.png");
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(read.form == "ScanNet");
  REQUIRE(read.notes.size() == 2);
  CHECK(read.notes[0] == "1 of 3 photographs have a pose that is not finite and are left out");
  CHECK_THAT(read.notes[1], Catch::Contains("1 of 3 photographs have no file in pose/"));
  check_same_cameras(read, colmap_scene(kPinhole));
}

TEST_CASE("ScanNet: what is damaged is refused by file") {
  const std::string lens = "50 0 20 0 0 50 15 0 0 0 1 0 0 0 0 1", pose = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  const auto refused = [](const std::string& intrinsic, const std::string& text) {
    return refusal([&] { return parse_scannet({"s", intrinsic, {{"7.jpg", text}}}, small); });
  };
  CHECK(refused(lens, pose) == "taken");
  CHECK(refused(lens, "1 0 0") == "s/pose/7.txt: value 3 of 16 is '', must be a number");
  CHECK(refused(lens, pose + " 1") == "s/pose/7.txt: has more than 16 values");
  CHECK_THAT(refused(lens, std::string("2").append(pose, 1)),
             Catch::Contains("s/pose/7.txt: does not begin with a rotation"));
  CHECK_THAT(refused(lens, std::string("-").append(pose)), Catch::Contains("s/pose/7.txt: mirrors the camera"));
  CHECK_THAT(refused(lens, std::string("nan").append(pose, 1)), Catch::Contains("gives no photograph a pose"));
  CHECK(refused(lens, "1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1") ==
        "s/pose/7.txt: its last row is 5 6 7 1, must be 0 0 0 1: it is written by columns, must be by rows");
  CHECK_THAT(refused("50 0 0 0 0 50 0 0 20 15 1 0 0 0 0 1", pose),
             Catch::Contains("intrinsic_color.txt: value 8 of 16 is 20, must be 0: rows are fx skew cx 0"));
  const Capture skewed = parse_scannet({"s", std::string("50 3").append(lens, 4), {{"7.jpg", pose}}}, small);
  CHECK(name(skewed.photographs.at(0).lens.model) == "BROWN");
  CHECK(image_from_cam(skewed.photographs[0].lens, {0, 1, 1})->x == Approx(20.5 + 3));
  CHECK_THAT(refused(std::string("0").append(lens, 2), pose),
             Catch::Contains("intrinsic_color.txt: an impossible camera"));
}

// --- RealityCapture

const std::string kColumns = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n";

PhotographLookup as_labelled() {
  return {[](std::string_view label) { return PosedPhotograph{std::string(label)}; }, small};
}

glm::dmat3 axes_of(const PosedPhotograph& photograph) {  // right, down, forward in the world
  return glm::transpose(glm::mat3_cast(photograph.cam_from_world_rotation));
}

TEST_CASE("RealityCapture: at no angle the camera looks down with +y up; heading turns it clockwise, pitch raises it") {
  const auto axes = [](const std::string& angles) {
    return axes_of(
        parse_reality_capture(kColumns + "a,1,2,3," + angles + ",36,0,0,0,0,0,0,0,0\n", "c.csv", as_labelled())
            .photographs.at(0));
  };
  const auto is = [](const glm::dmat3& a, const glm::dmat3& b) {
    return glm::distance(a[0], b[0]) + glm::distance(a[1], b[1]) + glm::distance(a[2], b[2]) < 1e-12;
  };
  const glm::dvec3 east(1, 0, 0), north(0, 1, 0), up(0, 0, 1);
  CHECK(is(axes("0,0,0"), {east, -north, -up}));
  CHECK(is(axes("90,0,0"), {-north, -east, -up}));  // the picture's top is east
  CHECK(is(axes("0,90,0"), {east, -up, north}));    // level, to the north
  CHECK(is(axes("90,90,0"), {-north, -up, east}));  // level, to the east
  CHECK(is(axes("0,0,90"), {-up, -north, -east}));
}

void write_reality_capture(const fs::path& scene) {
  write_photographs(scene / "images");
  std::string text = "\xef\xbb\xbf" + kColumns;
  for (const Posed& posed : two_cameras()) {
    // world from OpenGL's camera is turn(-heading, z) * turn(pitch, x) * turn(roll, y), whose last row is
    // (-cos p sin r, sin p, cos p cos r) and whose middle column is (sin h cos p, cos h cos p, sin p).
    const glm::dmat3 m(posed.world_from_cam[0], -posed.world_from_cam[1], -posed.world_from_cam[2]);
    const double heading = std::atan2(m[1][0], m[1][1]), pitch = std::asin(m[1][2]),
                 roll = std::atan2(-m[0][2], m[2][2]);
    text += posed.name;
    for (const double value : {posed.center.x, posed.center.y, posed.center.z}) append(text, ',', value);
    for (const double angle : {heading, pitch, roll}) append(text, ',', glm::degrees(angle));
    // 40 pixels are 36 mm.
    for (const double value : {50 * 0.9, 1 * 0.9, -1 * 0.9}) append(text, ',', value);
    text += ",-0.1,0.01,0,0,0.001,0.002\r\n";
  }
  write_file(scene / "cameras.csv", text);
}

TEST_CASE("a RealityCapture CSV gives the cameras of COLMAP's form") {
  const TemporaryFolder folder;
  write_reality_capture(folder.path());
  write_file(folder / "another.csv", "a,b\n1,2\n");
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(read.form == "RealityCapture");
  CHECK(read.notes.size() == 1);
  check_same_cameras(read, colmap_scene({50, 50, 21, 14, -0.1, 0.01, 0.001, 0.002}));
}

TEST_CASE("RealityCapture: k4 is read, columns that are not known are told") {
  const auto posed = [](const std::string& text) { return parse_reality_capture(text, "c.csv", as_labelled()); };
  const Capture brown = posed(kColumns + "a,0,0,0,0,0,0,36,0,0,0.1,0,0,0.5,0,0\n");
  CHECK(brown.notes.size() == 1);
  const CameraModel& lens = brown.photographs.at(0).lens;  // f is 40 pixels
  CHECK(image_from_cam(lens, {0.5, 0, 1})->x == Approx(20 + 40 * 0.5 * (1 + 0.1 / 4 + 0.5 / 256)));
  const Capture more = posed("#name,x,y,alt,heading,pitch,roll,f,px,py,k1,rolling,k5\na,0,0,0,0,0,0,36,0,0,0,1,2\n");
  REQUIRE(more.notes.size() == 2);
  CHECK(more.notes[0] == "c.csv has columns that are not known and not used: 'rolling', 'k5'");
}

TEST_CASE("RealityCapture: longitude and latitude in degrees are refused, metres anywhere are not") {
  const auto refused = [](const std::string& first, const std::string& second, const std::string& third) {
    const std::string rest = ",0,0,0,36,0,0,0,0,0,0,0,0\n";
    return refusal([&] {
      return parse_reality_capture(kColumns + "a," + first + rest + "b," + second + rest + "c," + third + rest, "c.csv",
                                   as_labelled());
    });
  };
  CHECK_THAT(refused("-34.82875641,-7.163227346,87.2", "-34.82875134,-7.163238529,86.9", "-34.8287484,-7.1632649,87.6"),
             Catch::StartsWith("c.csv: x and y look like degrees of longitude and latitude"));
  CHECK_THAT(refused("-34.82875641,-7.163227346,87", "-34.82875134,-7.163238529,87", "-34.8287484,-7.1632649,87"),
             Catch::Contains("degrees"));
  CHECK(refused("-34.8,-7.1,87.2", "-33.8,-6.1,87.3", "-32.8,-9.1,86.9") == "taken");
  CHECK(refused("0,0.001,1", "0.002,0,2", "0.001,0,3") == "taken");  // a pole at the origin
  CHECK(refused("565123.1,5932456.2,12", "565125.1,5932451.2,15", "565129,5932450,11") == "taken");
}

TEST_CASE("RealityCapture: columns may have other programs' names, and comments may precede them") {
  const std::string values = "a.jpg,1,2,3,10,20,30,36.5,0,0\n";
  const Capture usual =
      parse_reality_capture("#name,x,y,alt,heading,pitch,roll,f,px,py\n" + values, "c.csv", as_labelled());
  for (const char* const head : {"#cameras 1\n#name,x,y,alt,heading,pitch,roll,f,px,py\n",
                                 "name, x, y, z, yaw, pitch, roll, f_35mm, px_norm, py_norm\n",
                                 "\n# made by a script\nname,x,y,alt,heading,pitch,roll,f,px,py\n"}) {
    CAPTURE(head);
    const Capture read = parse_reality_capture(head + values, "c.csv", as_labelled());
    REQUIRE(read.photographs.size() == 1);
    CHECK(read.photographs[0].lens == usual.photographs[0].lens);
    CHECK(read.photographs[0].cam_from_world_rotation == usual.photographs[0].cam_from_world_rotation);
    CHECK(read.photographs[0].cam_from_world_translation == usual.photographs[0].cam_from_world_translation);
  }
  CHECK_THAT(refusal([&] {
               return parse_reality_capture("name,x,y,alt,yaw,pitch,roll,f,px_norm\na,0,0,0,0,0,0,36,0.01\n", "c.csv",
                                            as_labelled());
             }),
             Catch::Contains("line 2: px_norm is 0.01, in a unit that is not known"));
}

TEST_CASE("RealityCapture: what is damaged is refused by line") {
  const auto refused = [](const std::string& text) {
    return refusal([&] { return parse_reality_capture(text, "c.csv", as_labelled()); });
  };
  const std::string one = "a.jpg,0,0,0,0,0,0,36,0,0,0,0,0,0,0,0\n";
  CHECK(refused(kColumns + one) == "taken");
  CHECK(refused("#name,x,y,alt,heading,pitch,roll,f,px\na,0,0,0,0,0,0,36,0\n") == "taken");
  CHECK_THAT(refused("name,x\n"), Catch::Contains("has no line with the columns name, x, y, alt, heading"));
  CHECK_THAT(refused(kColumns), Catch::Contains("gives no photograph a pose"));
  CHECK_THAT(refused(kColumns + "a,1,2\n"), Catch::StartsWith("c.csv: line 2: has 3 values, but line 1 names 16"));
  CHECK_THAT(refused(kColumns + one + "b,x,0,0,0,0,0,36,0,0,0,0,0,0,0,0\n"),
             Catch::Contains("line 3: has the value 'x'"));
  CHECK_THAT(refused(kColumns + "a,0,0,0,0,0,0,-1,0,0,0,0,0,0,0,0\n"), Catch::Contains("line 2: an impossible camera"));
  CHECK_THAT(refused(kColumns + one + one), Catch::Contains("two frames have the photograph 'a.jpg'"));
}

// --- Metashape

std::string metashape(const std::string& cameras, const std::string& calibration, const std::string& rest = "") {
  return R"(<?xml version="1.0" encoding="UTF-8"?><document version="2.0.0"><chunk label="Chunk 1" enabled="true">
    <sensors>
    <sensor id="0" label="unknown" type="frame"><resolution width="40" height="30"/>
    <calibration type="frame" class="initial"><resolution width="40" height="30"/><f>1</f></calibration>
    <calibration type="frame" class="adjusted"><resolution width="40" height="30"/>)" +
         calibration + "</calibration></sensor></sensors>" + rest + "<cameras>" + cameras +
         "</cameras></chunk></document>";
}

std::string metashape_camera(const std::string& label, const std::string& transform, const std::string& more = "") {
  return "<camera id=\"0\" sensor_id=\"0\" label=\"" + label + "\" " + more + "><transform>" + transform +
         "</transform></camera>";
}

// u = 20 + 1 + x' (52 - 2), v = 15 - 1 + y' 52; p1 and p2 stand the other way round than OpenCV's.
const std::string kCalibration =
    "<f>52</f><b1>-2</b1><cx>1</cx><cy>-1</cy><k1>-0.1</k1><k2>0.01</k2><p1>0.002</p1><p2>0.001</p2>";
const std::string kIdentityPose = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

TEST_CASE("a Metashape XML gives the cameras of COLMAP's form, through the chunk's and the component's transform") {
  // world = 2 R chunk + t, R a quarter turn about z: what the cameras are in the chunk follows.
  const glm::dmat3 R(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  const glm::dvec3 t(10, 20, 30);
  const std::string transform =
      "<transform><rotation>0 -1 0 1 0 0 0 0 1</rotation><translation>10 20 "
      "30</translation><scale>2</scale></transform>";
  for (const std::string& where :
       {transform, "<components><component id=\"3\">" + transform + "</component></components>"}) {
    std::string cameras;
    for (const Posed& posed : two_cameras()) {
      const std::string pose =
          matrix_rows(glm::transpose(R) * posed.world_from_cam, glm::transpose(R) * (posed.center - t) / 2.0);
      cameras += metashape_camera(posed.name.substr(0, 1), pose, "component_id=\"3\"");  // without its ending
    }
    cameras = "<group id=\"0\">" + cameras + "</group><camera id=\"8\" sensor_id=\"0\" label=\"lost\"/>" +
              metashape_camera("off", kIdentityPose, "enabled=\"false\"");
    const TemporaryFolder folder;
    write_photographs(folder / "images");
    write_file(folder / "cameras.xml", metashape(cameras, kCalibration, where));
    const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
    CHECK(read.form == "Metashape");
    REQUIRE(read.notes.size() == 1);
    CHECK(read.notes[0] == "2 of 4 photographs are disabled or were not aligned and are left out");
    check_same_cameras(read, colmap_scene(kDistorted));
  }
}

TEST_CASE("Metashape: a fisheye's coefficients go to the lens of COLMAP that has them") {
  std::string text = metashape(metashape_camera("a", kIdentityPose),
                               "<f>52</f><k1>1</k1><k2>2</k2><k3>3</k3><k4>4</k4>"
                               "<p1>5</p1><p2>6</p2>");
  text.replace(text.find("type=\"frame\" class=\"adjusted\""), 12, "type=\"fisheye\"");
  const CameraModel lens = parse_metashape(text, "c.xml", as_labelled()).photographs.at(0).lens;
  CHECK(lens.model == LensModel::kThinPrismFisheye);  // fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1
  CHECK(lens.parameters == std::array<double, 16>{52, 52, 20, 15, 1, 2, 6, 5, 3, 4});
}

TEST_CASE("Metashape: k4, a skew and growing tangential terms are in the lens that is read") {
  const auto lens = [](const std::string& calibration, const std::string& type = "frame") {
    std::string text = metashape(metashape_camera("a", kIdentityPose), calibration);
    text.replace(text.find("type=\"frame\" class=\"adjusted\""), 12, "type=\"" + type + "\"");
    return parse_metashape(text, "c.xml", as_labelled()).photographs.at(0).lens;
  };
  const std::string all =
      "<f>50</f><cx>1</cx><cy>-2</cy><b1>3</b1><b2>4</b2><k1>0.1</k1><k2>0.2</k2><k3>0.3</k3><k4>0.4</k4><p1>0.01</p1>"
      "<p2>0.02</p2><p3>0.5</p3><p4>0.6</p4>";
  // The manual's example: at (x, y) = (0.3, -0.4), r^2 is 1/4. For a fisheye the angle takes the tangent's place.
  for (const bool fisheye : {false, true}) {
    const double shrunk = fisheye ? std::atan(0.5) / 0.5 : 1;
    const double x = 0.3 * shrunk, y = -0.4 * shrunk, r2 = x * x + y * y;
    const double radial = 1 + 0.1 * r2 + 0.2 * r2 * r2 + 0.3 * std::pow(r2, 3) + 0.4 * std::pow(r2, 4);
    const double grown = 1 + 0.5 * r2 + 0.6 * r2 * r2;
    const double bent_x = x * radial + (0.01 * (r2 + 2 * x * x) + 2 * 0.02 * x * y) * grown;
    const double bent_y = y * radial + (0.02 * (r2 + 2 * y * y) + 2 * 0.01 * x * y) * grown;
    const std::optional<glm::dvec2> image = image_from_cam(lens(all, fisheye ? "fisheye" : "frame"), {0.3, -0.4, 1});
    REQUIRE(image);
    CHECK(image->x == Approx(20 + 1 + bent_x * (50 + 3) + bent_y * 4));
    CHECK(image->y == Approx(15 - 2 + bent_y * 50));
  }
  CHECK(name(lens("<f>50</f><k4>0.1</k4>").model) == "BROWN");
  CHECK(name(lens("<f>50</f><b2>0</b2><p3>0</p3>").model) == "PINHOLE");
}

TEST_CASE("Metashape: labels may be paths of another computer") {
  const TemporaryFolder folder;
  for (const char* const file : {"front/1.png", "back/1.png", "front/2.png"})
    write_picture(folder / ("images/" + std::string(file)));
  const std::string cameras = metashape_camera("/home/user/shots/front/1.png", kIdentityPose) +
                              metashape_camera("D:\\shots\\back\\1.PNG", kIdentityPose) +
                              metashape_camera("../elsewhere/2.png", kIdentityPose);
  write_file(folder / "cameras.xml", metashape(cameras, kCalibration));
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(read.views.size() == 3);
  CHECK(read.views[0].name == "back/1.png");
  CHECK(read.views[1].name == "front/1.png");
  CHECK(read.views[2].name == "front/2.png");
  write_file(folder / "cameras.xml", metashape(metashape_camera("/home/user/1.png", kIdentityPose), kCalibration));
  CHECK_THAT(refusal([&] { return read_scene_views(folder.path(), glm::dvec3(0)); }),
             Catch::Contains("may be 'back/1.png' or 'front/1.png'"));
}

TEST_CASE("Metashape: photographs in linked folders are found by their labels") {
  const TemporaryFolder folder, card;
  write_photographs(card.path());
  fs::create_directory(folder / "images");
  fs::create_directory_symlink(card.path(), folder / "images" / "card1");
  std::string cameras;
  for (const Posed& posed : two_cameras()) cameras += metashape_camera(posed.name.substr(0, 1), kIdentityPose);
  write_file(folder / "cameras.xml", metashape(cameras, kCalibration));
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(read.views.size() == 2);
  CHECK(read.views[0].name == "card1/" + two_cameras()[0].name);
}

TEST_CASE("Metashape: a chunk's reference system is kept, local ones are none") {
  const auto place = [](const std::string& reference) {
    const std::string text =
        metashape(metashape_camera("a", kIdentityPose), kCalibration, "<reference>" + reference + "</reference>");
    return parse_metashape(text, "c.xml", as_labelled()).georeference;
  };
  CHECK_FALSE(place("LOCAL_CS[&quot;Local&quot;]"));
  const GeoReference geocentric{GeoReference::Frame::geocentric, 0, 0, 0, "GEOGCS[\"WGS 84\"]"};
  CHECK(place("GEOGCS[&quot;WGS 84&quot;]") == geocentric);
  CHECK(geo_reference_of(json_of(geocentric)) == geocentric);
}

TEST_CASE("Metashape: of several photographs with a label, the group says which one it is") {
  const TemporaryFolder folder;
  for (const char* const file : {"front/1.png", "back/1.png"}) write_picture(folder / ("images/" + std::string(file)));
  const auto group = [](const std::string& name) {
    return "<group id=\"0\" label=\"" + name + "\" type=\"folder\">" + metashape_camera("1", kIdentityPose) +
           "</group>";
  };
  write_file(folder / "cameras.xml", metashape(group("front") + group("back"), kCalibration));
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(read.views.size() == 2);
  CHECK(read.views[0].name == "back/1.png");
  CHECK(read.views[1].name == "front/1.png");
  write_file(folder / "cameras.xml", metashape(group("side"), kCalibration));
  CHECK_THAT(refusal([&] { return read_scene_views(folder.path(), glm::dvec3(0)); }),
             Catch::Contains("may be 'back/1.png' or 'front/1.png'"));
}

TEST_CASE("Metashape: a spherical sensor gives full panoramas") {
  std::string text = metashape(metashape_camera("a", kIdentityPose), kCalibration);
  text.replace(text.find("type=\"frame\""), 12, "type=\"spherical\"");
  const CameraModel lens = parse_metashape(text, "c.xml", as_labelled()).photographs.at(0).lens;
  CHECK(name(lens.model) == "EQUIRECTANGULAR");
  CHECK(lens.width == 40);
  CHECK(lens.parameters[1] == 30);
}

TEST_CASE("Metashape: cameras of a rig are placed by their master's pose and their own sensor's offset") {
  // The second camera stands at (0.5, 0, 0.25) of the master's and is turned about its z.
  const glm::dmat3 Rc(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  const glm::dvec3 Cc(0.5, 0, 0.25);
  const Posed b = two_cameras()[1];
  const glm::dmat3 master = b.world_from_cam * glm::transpose(Rc);
  std::string text = metashape(metashape_camera("a", kIdentityPose) +
                                   "<camera id=\"5\" sensor_id=\"1\" master_id=\"7\" label=\"b\"/>" +
                                   "<camera id=\"7\" sensor_id=\"0\" label=\"master\"><transform>" +
                                   matrix_rows(master, b.center - master * Cc) + "</transform></camera>" +
                                   "<camera id=\"8\" sensor_id=\"1\" master_id=\"9\" label=\"lost\"/><camera id=\"9\" "
                                   "sensor_id=\"0\" label=\"c\"/>",
                               kCalibration);
  text.replace(
      text.find("</sensors>"), 10,
      "<sensor id=\"1\" type=\"frame\" master_id=\"0\"><calibration class=\"adjusted\"><resolution width=\"40\" "
      "height=\"30\"/>" +
          kCalibration +
          "</calibration><rotation>0 -1 0 1 0 0 0 0 1</rotation>"
          "<location>0.5 0 0.25</location></sensor></sensors>");
  const TemporaryFolder folder;
  write_photographs(folder / "images");
  write_picture(folder / "images/master.png");
  write_file(folder / "cameras.xml", text);
  SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(read.notes.size() == 2);
  CHECK(read.notes[0] == "1 cameras of rigs are placed by their masters' poses and their sensors' offsets");
  CHECK(read.notes[1] == "2 of 5 photographs are disabled or were not aligned and are left out");
  REQUIRE(read.views.size() == 3);
  read.views.pop_back();
  check_same_cameras(read, colmap_scene(kDistorted));
}

TEST_CASE("Metashape: what is damaged or cannot be is refused by its place") {
  const auto refused = [](const std::string& cameras, const std::string& calibration = kCalibration,
                          const std::string& rest = "") {
    return refusal([&] { return parse_metashape(metashape(cameras, calibration, rest), "c.xml", as_labelled()); });
  };
  const std::string one = metashape_camera("a", kIdentityPose);
  CHECK(refused(one) == "taken");
  CHECK_THAT(refused("<b"), Catch::StartsWith("c.xml: is no XML from byte "));
  CHECK_THAT(refused(""), Catch::Contains("gives no photograph a pose"));
  CHECK(refused(metashape_camera("a", "1 0")) == "c.xml: camera 'a': its transform has 2 values, must have 16");
  CHECK_THAT(refused(metashape_camera("a", "x")), Catch::Contains("its transform has the value 'x'"));
  CHECK_THAT(refused(metashape_camera("a", std::string("2").append(kIdentityPose, 1))),
             Catch::Contains("camera 'a': its transform does not"));
  CHECK_THAT(refused(one, "<k1>1</k1>"), Catch::Contains("sensor '0': an impossible camera"));
  CHECK(refused(one, "<f>50</f><k9>0.0</k9><date>2024</date>") == "taken");
  CHECK_THAT(refused(one, "<f>50</f><k5>0.1</k5>"),
             Catch::Contains("sensor '0': its calibration has 'k5', which this program does not read"));
  CHECK_THAT(refused(metashape_camera("a", "1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1")),
             Catch::Contains("camera 'a': its transform: its last row is 5 6 7 1, must be 0 0 0 1"));
  CHECK_THAT(refused(one, "<fx>50</fx>"), Catch::Contains("PhotoScan before 1.2"));
  CHECK_THAT(refused(one, kCalibration, "<transform><scale>-1</scale></transform>"),
             Catch::Contains("its chunk: its scale is -1"));
  CHECK_THAT(refused("<camera sensor_id=\"7\" label=\"a\"><transform>" + kIdentityPose + "</transform></camera>"),
             Catch::Contains("is of sensor '7', which is not in the file"));
  CHECK_THAT(refusal([] { return parse_metashape("<document/>", "c.xml", as_labelled()); }),
             Catch::Contains("no chunk with cameras"));
}

// --- Polycam

// world from ARKit's camera, whose axes are right, up and backward; by rows t_00 ... t_23.
std::string polycam_json(const glm::dmat3& world_from_cam, const glm::dvec3& center) {
  std::string text = R"({"fx": 50, "fy": 52, "cx": 21, "cy": 14, "width": 40, "height": 30, "blur_score": 9)";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double value = column == 3 ? center[row] : (column == 0 ? 1 : -1) * world_from_cam[column][row];
      text += ", \"t_" + std::to_string(row) + std::to_string(column) + "\":";
      append(text, ' ', value);
    }
  }
  return text + "}";
}

TEST_CASE("a Polycam folder gives the cameras of COLMAP's form, in the mesh's coordinates") {
  // mesh from world: a quarter turn about y and a step, by columns. What the cameras are in the world follows.
  const glm::dmat3 R(glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0));
  const glm::dvec3 t(1, 2, 3);
  const TemporaryFolder folder;
  for (const Posed& posed : two_cameras()) {
    const std::string id = posed.name.substr(0, 1);
    write_picture(folder / ("keyframes/corrected_images/" + posed.name));
    write_file(folder / ("keyframes/corrected_cameras/" + id + ".json"),
               polycam_json(glm::transpose(R) * posed.world_from_cam, glm::transpose(R) * (posed.center - t)));
    write_file(folder / ("keyframes/cameras/" + id + ".json"), "{}");  // as they were before the correction
  }
  write_file(folder / "mesh_info.json", R"({"alignmentTransform": [0,0,-1,0, 0,1,0,0, 1,0,0,0, 1,2,3,1]})");
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(read.form == "Polycam");
  REQUIRE(read.notes.size() == 1);
  CHECK_THAT(read.notes[0], Catch::Contains("alignmentTransform"));
  check_same_cameras(read, colmap_scene(kPinhole));
}

TEST_CASE("Polycam: coefficients are refused, poses of the tracking alone are told") {
  std::string text = polycam_json(glm::dmat3(1), glm::dvec3(0));
  const auto parsed = [&](const std::string& cameras) {
    return parse_polycam({cameras, {{"7", text}}, "mesh_info.json", std::nullopt},
                         [](const std::string& id) { return PosedPhotograph{id}; });
  };
  CHECK(parsed("keyframes/corrected_cameras").notes.empty());
  REQUIRE(parsed("keyframes/cameras").notes.size() == 1);
  CHECK(
      parsed("keyframes/cameras").notes[0] ==
      "keyframes/corrected_cameras/ is not there: the poses are those of the tracking, which Polycam has not refined");
  text.insert(1, "\"k1\": 0, ");
  CHECK(refusal([&] { return parsed("k"); }) == "taken");
  text.replace(text.find("\"k1\": 0"), 7, "\"k1\": 0.1");
  CHECK(refusal([&] { return parsed("k"); }) ==
        "k/7.json: k1: is a coefficient that this program does not read: undistort the photographs first");
}

TEST_CASE("Polycam: what is damaged is refused by file and place") {
  const std::string one = polycam_json(glm::dmat3(1), glm::dvec3(0));
  const auto refused = [](const std::string& frame, const std::optional<std::string>& mesh_info = std::nullopt) {
    return refusal([&] {
      return parse_polycam({"k", {{"7", frame}}, "mesh_info.json", mesh_info},
                           [](const std::string& id) { return PosedPhotograph{id}; });
    });
  };
  CHECK(refused(one) == "taken");
  CHECK(refused(one, "{}") == "taken");
  CHECK_THAT(refused("{"), Catch::StartsWith("k/7.json: "));
  CHECK_THAT(refused("{}"), Catch::StartsWith("k/7.json: ") && Catch::Contains("has no t_00"));
  CHECK_THAT(refused("[]"), Catch::Contains("has no t_00"));
  std::string negative = one;
  negative[negative.find("50")] = '-';
  CHECK_THAT(refused(negative), Catch::Contains("an impossible camera"));
  CHECK_THAT(refused(polycam_json(glm::dmat3(2), glm::dvec3(0))),
             Catch::Contains("its pose does not begin with a rotation"));
  CHECK_THAT(refused(one, R"({"alignmentTransform": [1]})"), Catch::Contains("has 1 values, must have 16"));
  CHECK_THAT(refused(one, R"({"alignmentTransform": [1,0,0,5,0,1,0,6,0,0,1,7,0,0,0,1]})"),
             Catch::Contains("alignmentTransform: its last row is 5 6 7 1, must be 0 0 0 1"));
  CHECK_THAT(refused(one, R"({"alignmentTransform": [2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]})"),
             Catch::Contains("its pose with alignmentTransform does not begin with a rotation"));
}

// --- OpenMVS

struct MvsOptions {
  std::uint32_t version = 7;
  bool has_size = true;
  std::uint32_t platform_of_b = 0;
  double skew = 0;
  std::string mask = {};  // of each image
};

Bytes& mvs_text(Bytes& bytes, const std::string& text) {
  return bytes.u64(text.size()).text(text);
}

Bytes& mvs_pose(Bytes& bytes, const glm::dmat3& R, const glm::dvec3& C) {
  for (int i = 0; i < 9; ++i) bytes.f64({R[i % 3][i / 3]});
  return bytes.f64({C.x, C.y, C.z});
}

// One platform whose camera is turned and moved in it, three images, the last of them without a pose.
std::string openmvs(const MvsOptions& options) {
  const std::uint32_t version = options.version;
  const glm::dmat3 Rc(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
  const glm::dvec3 Cc(0.5, 0, 0.25);
  Bytes bytes;
  mvs_text(bytes.text("MVSI").u32(version).u32(0).u64(1), "platform").u64(1);
  mvs_text(bytes, "camera");
  if (version > 3) mvs_text(bytes, "RGB");
  if (version > 0) bytes.u32(options.has_size ? kWidth : 0).u32(options.has_size ? kHeight : 0);
  // The middle of the first pixel is at (0, 0).
  const double scale = options.has_size ? 1 : 1.0 / kWidth;
  bytes.f64({50 * scale, options.skew * scale, 20.5 * scale, 0, 52 * scale, 13.5 * scale, 0, 0, 1});
  mvs_pose(bytes, Rc, Cc).u64(2);
  for (const Posed& posed : two_cameras()) {
    // camera = Rc (R (X - C) - Cc): R and C of the platform follow from those of the camera.
    const glm::dmat3 R = glm::transpose(Rc) * glm::transpose(posed.world_from_cam);
    mvs_pose(bytes, R, posed.center - glm::transpose(R) * Cc);
  }
  bytes.u64(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    mvs_text(bytes, i == 0 ? "images/a.png" : i == 1 ? "/home/somebody/images/b.png" : "c.png");
    if (version > 4) mvs_text(bytes, options.mask);
    bytes.u32(i == 1 ? options.platform_of_b : 0).u32(0).u32(i == 2 ? 0xffffffff : i);
    if (version > 2) bytes.u32(i);
    if (version > 6) bytes.u32(0).u32(0).u32(0).u64(1).u32(1).u32(2).u32(3).u32(4).u32(5).u32(6);
  }
  return bytes.u64(0).u64(0).u64(0).string();  // points, which are not read
}

TEST_CASE("an OpenMVS scene of every version gives the cameras of COLMAP's form") {
  for (const MvsOptions& options : {MvsOptions{7}, MvsOptions{5}, MvsOptions{3}, MvsOptions{1}, MvsOptions{7, false}}) {
    const TemporaryFolder folder;
    write_photographs(folder / "images");
    write_file(folder / "scene.mvs", openmvs(options));
    const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0));
    CHECK(read.form == "OpenMVS");
    REQUIRE(read.notes.size() == 1);
    CHECK(read.notes[0] == "1 of 3 photographs have no pose and are left out");
    check_same_cameras(read, colmap_scene(kPinhole));
  }
}

TEST_CASE("OpenMVS: a skew is read, masks that it names are told") {
  const std::string file = openmvs({7, true, 0, 2, "masks/a.png"});
  const Capture posed = parse_openmvs(std::as_bytes(std::span(file)), "s.mvs", as_labelled());
  CHECK(image_from_cam(posed.photographs.at(0).lens, {0, 1, 1})->x == Approx(21 + 2));
  REQUIRE(posed.notes.size() == 2);
  CHECK(posed.notes[1] == "3 of its images name a mask, which is not read: masks are taken from masks/ or --masks");
}

TEST_CASE("OpenMVS: what is damaged or cut off is refused, also at every byte") {
  const auto refused = [](std::string_view file) {
    return refusal([&] { return parse_openmvs(std::as_bytes(std::span(file)), "s.mvs", as_labelled()); });
  };
  CHECK(refused("MVS") == "s.mvs: ends before its platforms and images do: it is damaged or was cut off");
  CHECK(refused("MVST0000") == "s.mvs: does not begin with MVSI");
  CHECK_THAT(refused(openmvs({8})), Catch::Contains("is of version 8, but versions up to 7 are known"));
  CHECK_THAT(refused(openmvs({7, true, 1})),
             Catch::Contains("image 1 (") && Catch::Contains("has platform 1, which is not there"));
  const std::string whole = openmvs({});
  std::size_t taken = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (refused(std::string_view(whole).substr(0, size)) == "taken") ++taken;
  }
  CHECK(taken == 24);  // the points at the end may be missing
}

// --- Several forms, and photographs by their labels

TEST_CASE("forms that leave sizes to the photographs are listed whole if one of these is bad, first or last") {
  const SceneViews expected = colmap_scene(kDistorted);
  PictureFolders skipping;
  skipping.skip_bad = true;
  for (const std::size_t bad : {0, 1}) {
    const std::string name = expected.views[bad].name;
    CAPTURE(name);
    const TemporaryFolder tum;
    write_tum(tum.path());
    fs::remove(tum / ("rgb/" + name));
    const SceneViews read = read_scene_views(tum.path(), glm::dvec3(0), skipping);
    check_same_cameras(read, expected);
    CHECK_THAT(read.views[bad].bad, Catch::Contains(name + ": no such photograph, but "));
    CHECK(read.views[1 - bad].bad.empty());
    CHECK_THAT(refusal([&] { return read_scene_views(tum.path(), glm::dvec3(0)); }),
               Catch::Contains(name + ": no such photograph"));
  }
  const TemporaryFolder folder;
  write_reality_capture(folder.path());
  fs::resize_file(folder / "images/a.png", 20);
  const SceneViews read = read_scene_views(folder.path(), glm::dvec3(0), skipping);
  check_same_cameras(read, colmap_scene({50, 50, 21, 14, -0.1, 0.01, 0.001, 0.002}));
  CHECK_FALSE(read.views[0].bad.empty());
  fs::resize_file(folder / "images/b.png", 20);
  CHECK_THAT(refusal([&] { return read_scene_views(folder.path(), glm::dvec3(0), skipping); }),
             Catch::Contains("a.png"));
}

TEST_CASE("of several forms in a folder the first is read, COLMAP before all, and the others are named") {
  const TemporaryFolder folder;
  write_tum(folder.path());
  write_scannet(folder.path());
  const SceneViews scannet = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(scannet.form == "ScanNet");
  REQUIRE(scannet.notes.size() == 1);
  CHECK_THAT(scannet.notes[0], Catch::Contains("intrinsic_color.txt, and not from what lies beside it: ") &&
                                   Catch::EndsWith("groundtruth.txt"));
  write_colmap(folder.path(), kPinhole);
  const SceneViews colmap = read_scene_views(folder.path(), glm::dvec3(0));
  CHECK(colmap.form == "COLMAP");
  REQUIRE(colmap.notes.size() == 1);
}

TEST_CASE("a label is a photograph's name, the end of it, or that without its ending") {
  const PhotographNames names({"left/1.jpg", "right/1.jpg", "right/2.JPG", "3.png", "3x.png", "a.b.jpg"});
  CHECK(names.find("right/1.jpg") == "right/1.jpg");
  CHECK(names.find("2.JPG") == "right/2.JPG");
  CHECK(names.find("2.jpg") == "right/2.JPG");
  CHECK(names.find("right/2") == "right/2.JPG");
  CHECK(names.find("3") == "3.png");
  CHECK(names.find("3.tif") == "3.png");
  CHECK(names.find("a.b") == "a.b.jpg");
  CHECK(names.find("left/1") == "left/1.jpg");
  CHECK(names.find("4") == "4");
  CHECK(names.find("ight/2") == "ight/2");
  CHECK_THROWS_WITH(names.find("1.jpg"),
                    "the photograph '1.jpg' may be 'left/1.jpg' or 'right/1.jpg': keep one of them");
}

}  // namespace
}  // namespace lumatlas
