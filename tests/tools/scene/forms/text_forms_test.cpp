// SPDX-License-Identifier: GPL-3.0-or-later
// The text forms of Bundler and VisualSFM, by their published formulas.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/forms/photogrammetry/bundler.h"
#include "tools/scene/forms/photogrammetry/visual_sfm.h"
#include "tools/scene/forms/photographs/measured_size.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {
namespace {

// --- both forms

constexpr double kTextFormsWidth = 400, kTextFormsHeight = 300;

PhotographLookup text_forms_lookup() {
  PhotographLookup lookup;
  lookup.find = [](std::string_view label) { return PosedPhotograph{std::string(label)}; };
  lookup.size_of = [](const PosedPhotograph&) {
    return ImageSize{static_cast<std::uint32_t>(kTextFormsWidth), static_cast<std::uint32_t>(kTextFormsHeight)};
  };
  return lookup;
}

template <typename Read>
std::string text_forms_refusal(const Read& read) {
  try {
    (void)read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

glm::dvec2 imaged_by(const PosedPhotograph& photograph, const glm::dvec3& world) {
  const auto image = image_from_cam(photograph.lens,
                                    photograph.cam_from_world_rotation * world + photograph.cam_from_world_translation);
  REQUIRE(image);
  return *image;
}

TEST_CASE("the size at which photographs were measured is a whole number of times theirs, or is refused") {
  const std::vector<ImageSize> sizes{{400, 300}, {300, 400}};
  const auto scale = [&](double x, double y) {
    std::vector<MeasuredExtent> extents(2);
    extents[0].add(-x, y);
    extents[0].add(std::nan(""), 1e9);
    return measured_scale(extents, sizes, "scene/a.nvm");
  };
  CHECK(measured_scale({{}, {}}, sizes, "a.nvm") == 1);
  CHECK(scale(150, 100) == 1);
  CHECK(scale(200.9, 10) == 1);  // at the rim
  CHECK(scale(396, 280) == 2);
  CHECK(scale(396, -297) == 2);
  CHECK(scale(595, 100) == 3);
  CHECK(text_forms_refusal([&] { return scale(300, 10); }) ==
        "scene/a.nvm: its points were measured in larger photographs: those in one of 400x300 pixels reach over 598 "
        "pixels of its width, 1.50 times its size: give the photographs at the size that they had");
  CHECK_THAT(text_forms_refusal([&] { return scale(1e6, 10); }), Catch::Contains("4999.99 times"));
  std::vector<MeasuredExtent> from_corner(2);
  from_corner[0].add(5, 7);
  from_corner[0].add(795, 500);
  CHECK(measured_scale(from_corner, sizes, "a.nvm") == 2);
  from_corner[1].add(100, 1590);  // the second photograph is upright, and needs four times its height
  CHECK(measured_scale(from_corner, sizes, "a.nvm") == 4);
}

// --- Bundler

const std::string kBundleTwoCameras =
    "# Bundle file v0.3\n2 1\n"
    "500 -0.1 0.02\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n"
    "600 0 0\n0 -1 0\n1 0 0\n0 0 1\n1 -2 3.5\n"
    "0.5 0.25 -2\n255 128 0\n2 0 17 -120.5 80.25 1 3 10 -20\n";
const std::string kBundleList = "images/a.jpg 0 480.5\n./b c.jpg\n";

Capture parsed_bundle(const std::string& bundle = kBundleTwoCameras, const std::string& list = kBundleList) {
  return parse_bundler(bundle, "scene/bundle.out", list, "scene/list.txt", text_forms_lookup());
}

// Bundler's manual: P = R X + t, p = -P / P.z, p' = f (1 + k1 |p|^2 + k2 |p|^4) p, from the middle, y up.
glm::dvec2 bundler_formula(const glm::dvec3& P, double f, double k1, double k2) {
  const double px = -P.x / P.z, py = -P.y / P.z, r2 = px * px + py * py;
  const double ratio = f * (1 + k1 * r2 + k2 * r2 * r2);
  return {kTextFormsWidth / 2 + ratio * px, kTextFormsHeight / 2 - ratio * py};
}

TEST_CASE("Bundler: poses and lenses image points where its manual says") {
  const Capture posed = parsed_bundle();
  REQUIRE(posed.photographs.size() == 2);
  CHECK(posed.photographs[0].name == "./b c.jpg");
  CHECK(posed.photographs[1].name == "images/a.jpg");
  for (const glm::dvec3& X : {glm::dvec3(0.1, 0.2, -4), glm::dvec3(0.5, -0.3, -3), glm::dvec3(-1, 1, -9)}) {
    const glm::dvec2 a = bundler_formula(X, 500, -0.1, 0.02);
    CHECK(glm::distance(imaged_by(posed.photographs[1], X), a) < 1e-9);
    const glm::dvec3 world = X + glm::dvec3(0, 0, -5);  // before the second camera too
    const glm::dvec2 b = bundler_formula({-world.y + 1, world.x - 2, world.z + 3.5}, 600, 0, 0);
    CHECK(glm::distance(imaged_by(posed.photographs[0], world), b) < 1e-9);
  }
  REQUIRE(posed.notes.size() == 1);
  CHECK(posed.notes[0] ==
        "bundle.out does not state the size of the photographs: they are taken to have the size that its focal lengths "
        "are for, and their middles are taken to be the principal points");
}

TEST_CASE("Bundler: a camera without a focal length is left out and counted") {
  std::string bundle = kBundleTwoCameras;
  bundle.replace(bundle.find("500 -0.1 0.02\n1 0 0\n0 1 0\n0 0 1\n"), 32, "0 0 0\n0 0 0\n0 0 0\n0 0 0\n");
  const Capture posed = parsed_bundle(bundle);
  REQUIRE(posed.photographs.size() == 1);
  CHECK(posed.photographs[0].name == "./b c.jpg");
  CHECK(posed.left_out == 1);
  CHECK(posed.notes[0] == "1 of 2 photographs were not placed (their focal length is 0) and are left out");
}

TEST_CASE("Bundler: photographs at half the size keep the lens of the size that points were measured at") {
  std::string bundle = kBundleTwoCameras;
  bundle.replace(bundle.find("-120.5 80.25"), 12, "-397.5 80.25");
  const Capture posed = parsed_bundle(bundle);
  CHECK(posed.photographs[0].lens.width == 800);
  CHECK(posed.photographs[0].lens.principal_point() == glm::dvec2(400, 300));
  CHECK(posed.photographs[0].lens.focal_length() == glm::dvec2(600));
  CHECK_THAT(posed.notes[0], Catch::Contains("kept at 1/2 of the size"));
}

TEST_CASE("Bundler: what is damaged is refused by line") {
  const auto refused = [](const std::string& from, const std::string& to) {
    std::string bundle = kBundleTwoCameras;
    bundle.replace(bundle.find(from), from.size(), to);
    return text_forms_refusal([&] { return parsed_bundle(bundle); });
  };
  CHECK(refused("v0.3", "v0.4") ==
        "scene/bundle.out: begins with '# Bundle file v0.4', must begin with '# Bundle file v0.3'");
  CHECK(refused("2 1\n", "x 1\n") == "scene/bundle.out: line 2: the number of cameras is 'x', which is not a count");
  CHECK(refused("500 -0.1", "nan -0.1") ==
        "scene/bundle.out: line 3: the focal length of camera 0 is 'nan', which is not a finite number");
  CHECK(refused("500 -0.1", "-500 -0.1") ==
        "scene/bundle.out: camera 0 ('images/a.jpg'): an impossible camera: fx is -500, must be positive");
  CHECK_THAT(refused("0 -1 0", "0 -1 1"),
             Catch::Contains("camera 1 ('./b c.jpg'): its pose does not begin with a rotation"));
  CHECK_THAT(refused("2 1\n", "4000000000 1\n"),
             Catch::Contains("the number of cameras is 4000000000, too many for the"));
  CHECK_THAT(refused("2 1\n", "2 4000000000\n"),
             Catch::Contains("the number of points is 4000000000, too many for the"));
  CHECK_THAT(refused("2 0 17", "2000000 0 17"), Catch::Contains("the number of views of point 0 is 2000000, too many"));
  CHECK(refused("2 0 17", "2 2 17") == "scene/bundle.out: line 15: a view of point 0 is of a camera that is not there");
  CHECK(text_forms_refusal([] { return parsed_bundle(kBundleTwoCameras, "a.jpg\n"); }) ==
        "scene/bundle.out: has 2 cameras, but scene/list.txt names 1 photographs");
  CHECK(text_forms_refusal([] { return parsed_bundle("# Bundle file v0.3\n0 0\n", ""); }) ==
        "scene/bundle.out: gives no photograph a pose, so there is nothing to see");
}

TEST_CASE("Bundler: every text that was cut off is refused, none is taken for a shorter scene") {
  for (std::size_t size = 0; size + 4 < kBundleTwoCameras.size(); ++size) {  // the last number may lose digits
    CHECK(text_forms_refusal([&] { return parsed_bundle(kBundleTwoCameras.substr(0, size)); }) != "taken");
  }
  CHECK(text_forms_refusal([] {
          return parsed_bundle(kBundleTwoCameras.substr(0, kBundleTwoCameras.find("1 -2 3.5")));
        }) == "scene/bundle.out: ends before the translation of camera 1: it is damaged or was cut off");
}

TEST_CASE("Bundler: the list lies beside the bundle file or one folder up, and is not guessed") {
  const TemporaryFolder folder;
  CHECK(!find_bundler(folder.path()));
  test::write_file(folder / "bundle/bundle.out", kBundleTwoCameras);
  REQUIRE(find_bundler(folder.path()) == folder / "bundle/bundle.out");
  CHECK(text_forms_refusal([&] { return read_bundler({folder.path()}); }) ==
        (folder / "bundle/bundle.out").string() +
            ": has no list.txt beside it, which names the photographs in the order of the cameras: copy it from where "
            "Bundler was run");
  std::filesystem::create_directories(folder / "images");
  write_image(folder / "images/a.jpg", Photograph{4, 3, std::vector<std::uint8_t>(36, 90), {}});
  write_image(folder / "images/b.jpg", Photograph{4, 3, std::vector<std::uint8_t>(36, 90), {}});
  test::write_file(folder / "list.txt", std::string("./a.jpg 0 500\nimages\\b.jpg\n"));
  std::string without_points = kBundleTwoCameras.substr(0, kBundleTwoCameras.find("0.5 0.25"));
  without_points.replace(without_points.find("2 1"), 3, "2 0");
  test::write_file(folder / "bundle/bundle.out", without_points);
  const Capture posed = read_bundler({folder.path()});
  CHECK(posed.photographs[0].name == "a.jpg");
  CHECK(posed.photographs[0].file == "images/a.jpg");
  CHECK(posed.photographs[1].name == "b.jpg");
}

// --- VisualSFM

const std::string kNvmTwoCameras =
    "NVM_V3 \n\n2\n"
    "images/a.jpg\t500 1 0 0 0 0 0 0 0.2 0\n"
    "images/b\"c.jpg 600 0.707107 0 0 -0.707107 1 -2 5.0e-001 0 0 \n\n"
    "1\n0.5 0.25 4 255 128 0 2 0 17 -120.5 80.25 1 3 10 -20\n\n0\n\n#the last part of an NVM file\n0\n";

Capture parsed_nvm(const std::string& text = kNvmTwoCameras) {
  return parse_visual_sfm(text, "scene/a.nvm", text_forms_lookup());
}

std::string refused_nvm(const std::string& from, const std::string& to) {
  std::string text = kNvmTwoCameras;
  text.replace(text.find(from), from.size(), to);
  return text_forms_refusal([&] { return parsed_nvm(text); });
}

TEST_CASE("VisualSFM: a measurement, undistorted by its formula, is the direction that the lens images there") {
  const Capture posed = parsed_nvm();
  REQUIRE(posed.photographs.size() == 2);
  CHECK(posed.photographs[0].name == "images/a.jpg");
  CHECK(posed.photographs[1].name == "images/b c.jpg");
  for (const glm::dvec2& pixel : {glm::dvec2(0, 0), glm::dvec2(400, 300), glm::dvec2(211, 17), glm::dvec2(200, 150)}) {
    const glm::dvec2 m = (pixel - glm::dvec2(200, 150)) / 500.0;
    const glm::dvec2 u = m * (1 + 0.2 * glm::dot(m, m));
    CHECK(glm::distance(imaged_by(posed.photographs[0], 3.0 * glm::dvec3(u, 1)), pixel) < 1e-3);
  }
  // Camera from world turns by -90 degrees about z: right is -y of the world, down is +x. It stands at (1, -2, 0.5).
  CHECK(glm::distance(imaged_by(posed.photographs[1], glm::dvec3(1.5, -3, 4.5)),
                      glm::dvec2(200 + 600 * (-1.0) / 4, 150 + 600 * (-0.5) / 4)) < 1e-3);
  CHECK(posed.photographs[1].lens.model == LensModel::kPinhole);
  REQUIRE(posed.notes.size() == 1);
  CHECK(posed.notes[0] ==
        "a.nvm does not state the size of the photographs: they are taken to have the size that its focal lengths are "
        "for, and their middles are taken to be the principal points");
}

TEST_CASE("VisualSFM: strong radial terms of both signs are fitted within a tenth of a pixel, or refused") {
  for (const double r : {-0.45, -0.2, -1e-3, -1e-9, 1e-9, 1e-3, 0.5, 1.0, 3.0}) {
    std::string text = kNvmTwoCameras;
    text.replace(text.find("0.2 0\n"), 3, number_text(r));
    const Capture posed = parsed_nvm(text);
    double worst = 0;
    for (int x = 0; x <= 400; x += 5) {
      const glm::dvec2 pixel(x, 0.75 * x), m = (pixel - glm::dvec2(200, 150)) / 500.0;
      const glm::dvec2 u = m * (1 + r * glm::dot(m, m));
      worst = std::max(worst, glm::distance(imaged_by(posed.photographs[0], glm::dvec3(u, 1)), pixel));
    }
    INFO(r);
    CHECK(worst < 0.1);
    const double corner = 0.5 * (1 + r * 0.25);  // undistorted
    CHECK(reach(posed.photographs[0].lens, corner) >= 0.99 * corner);
  }
  CHECK(refused_nvm("0.2 0\n", "-1.5 0\n") ==
        "scene/a.nvm: line 4: an impossible camera: its radial term -1.5 turns back inside the photograph");
  CHECK_THAT(refused_nvm("500 1 0 0 0 0 0 0 0.2", "50 1 0 0 0 0 0 0 900"),
             Catch::Contains("an impossible camera: the inverse of its radial term 900 cannot be fitted within 0.1 "
                             "pixels"));
}

TEST_CASE("VisualSFM: FixedK gives the calibration of all cameras") {
  std::string text = kNvmTwoCameras;
  text.replace(0, 7, "NVM_V3 FixedK 500 190 510 160");
  text.replace(text.find("600"), 3, "500.1");
  const Capture posed = parsed_nvm(text);
  CHECK(posed.photographs[1].lens.focal_length() == glm::dvec2(500, 510));
  CHECK(posed.photographs[1].lens.principal_point() == glm::dvec2(190, 160));
  CHECK_THAT(posed.notes[0], !Catch::Contains("principal"));
  CHECK(refused_nvm("NVM_V3 ", "NVM_V3 FixedK 500 190 510 160") ==
        "scene/a.nvm: line 5: has the focal length 600, but the first line fixes it to 500");
  CHECK_THAT(refused_nvm("NVM_V3 ", "NVM_V3 FixedK 500 190"), Catch::Contains("line 1: has 4 values"));
  CHECK(refused_nvm("NVM_V3 ", "NVM_V3 Free") == "scene/a.nvm: line 1: has 'Free' after NVM_V3, only FixedK is known");
}

TEST_CASE("VisualSFM: of several models the one with the most cameras is read, what has no pose is counted") {
  const std::string camera = ".jpg 500 1 0 0 0 0 0 0 0 0\n", point = "1\n0 0 4 0 0 0 1 0 0 1 1\n";
  const std::string text = "NVM_V3\n1\na" + camera + point + "2\nb" + camera + "c" + camera + point + "3\nd" + camera +
                           "e" + camera + "f" + camera + "0\n0\n";
  const Capture posed = parsed_nvm(text);
  REQUIRE(posed.photographs.size() == 2);
  CHECK(posed.photographs[0].name == "b.jpg");
  CHECK(posed.left_out == 4);
  REQUIRE(posed.notes.size() == 3);
  CHECK(posed.notes[0] == "3 of 5 photographs have no pose and are left out");
  CHECK(posed.notes[1] ==
        "of 2 models, which are not in one coordinate system, the one with the most cameras is read, 2; 1 cameras of "
        "the others are left out");
}

TEST_CASE("VisualSFM: a file without points, or that ends after them, is whole; names may hold blanks") {
  const std::string cameras = "NVM_V3\n1\nmy photo 1.jpg 500 1 0 0 0 0 0 0 0 0\n";
  CHECK(parsed_nvm(cameras + "0").photographs[0].name == "my photo 1.jpg");
  CHECK(parsed_nvm(cameras + "1\n0 0 4 0 0 0 1 0 0 -1.#IND 1").photographs.size() == 1);
  CHECK(parsed_nvm(cameras + "0\n\n#comment\n").photographs.size() == 1);
}

TEST_CASE("VisualSFM: photographs at half the size keep the lens of the size that points were measured at") {
  std::string text = kNvmTwoCameras;
  text.replace(text.find("-120.5 80.25"), 12, "-397.5 80.25");
  const Capture posed = parsed_nvm(text);
  CHECK(posed.photographs[0].lens.width == 800);
  CHECK(posed.photographs[0].lens.principal_point() == glm::dvec2(400, 300));
  CHECK_THAT(posed.notes[0], Catch::Contains("kept at 1/2 of the size"));
}

TEST_CASE("VisualSFM: what is damaged is refused by line") {
  CHECK(refused_nvm("NVM_V3", "NVM_V3_R9T") == "scene/a.nvm: begins with 'NVM_V3_R9T', must be of version NVM_V3");
  CHECK(refused_nvm("2\nimages", "-2\nimages") ==
        "scene/a.nvm: line 3: the number of cameras is '-2', which is not a count");
  CHECK_THAT(refused_nvm("2\nimages", "3000000000\nimages"),
             Catch::Contains("the number of cameras is 3000000000, too many for the"));
  CHECK(refused_nvm("2\nimages", "3\nimages") ==
        "scene/a.nvm: line 7: has 1 values, but a camera has a file and 10 numbers");
  CHECK_THAT(refused_nvm("1\n0.5 0.25", "3000000000\n0.5 0.25"),
             Catch::Contains("the number of points is 3000000000, too many for the"));
  CHECK_THAT(refused_nvm("2 0 17", "99999 0 17"),
             Catch::Contains("the number of measurements of point 0 is 99999, too many"));
  CHECK(refused_nvm("2 0 17", "2 -1 17") ==
        "scene/a.nvm: line 8: point 0 was measured by camera -1, which is not there");
  CHECK(refused_nvm("500 1 0", "nan 1 0") == "scene/a.nvm: line 4: has the value 'nan', which is not a finite number");
  CHECK_THAT(refused_nvm("500 1 0", "-500 1 0"),
             Catch::Contains("line 4: an impossible camera: fx is -500, must be positive"));
  CHECK(refused_nvm("500 1 0", "500 2 0") == "scene/a.nvm: line 4: its quaternion has the length 2, must be 1");
  CHECK(refused_nvm("1 -2 5.0e-001", "1 -2 5.0e+013") ==
        "scene/a.nvm: line 5: its pose puts the camera at 50000000000000, which is not within 1e12 of 0");
  CHECK(text_forms_refusal([] { return parsed_nvm("NVM_V3\n\n0\n"); }) ==
        "scene/a.nvm: has no model with cameras, so there is nothing to see");
}

TEST_CASE("Bundler and VisualSFM: photographs with a lens that cannot be are kept where that is asked for") {
  PhotographLookup keeping = text_forms_lookup();
  keeping.bad = BadPhotographs::keep;
  std::string bundle = kBundleTwoCameras, nvm = kNvmTwoCameras;
  bundle.replace(bundle.find("500 -0.1"), 3, "-50");
  nvm.replace(nvm.find("500 1 0"), 3, "-50");
  const Capture of_bundler = parse_bundler(bundle, "bundle.out", kBundleList, "list.txt", keeping);
  CHECK(of_bundler.photographs[0].bad.empty());
  CHECK_THAT(of_bundler.photographs[1].bad, Catch::Contains("fx is -50, must be positive"));
  const Capture of_nvm = parse_visual_sfm(nvm, "a.nvm", keeping);
  CHECK_THAT(of_nvm.photographs[0].bad, Catch::Contains("fx is -50, must be positive"));
  CHECK(of_nvm.photographs[1].bad.empty());
}

TEST_CASE("VisualSFM: every text that was cut off inside its model is refused") {
  const std::size_t end = kNvmTwoCameras.find("-20\n");
  for (std::size_t size = 0; size < end; ++size) {
    CHECK(text_forms_refusal([&] { return parsed_nvm(kNvmTwoCameras.substr(0, size)); }) != "taken");
  }
  CHECK(text_forms_refusal([&] { return parsed_nvm(kNvmTwoCameras.substr(0, end)); }) ==
        "scene/a.nvm: ends before point 0: it is damaged or was cut off");
}

TEST_CASE("VisualSFM: a file is found by its first word") {
  const TemporaryFolder folder;
  test::write_file(folder / "a.nvm", std::string("something else"));
  CHECK(!find_visual_sfm(folder.path()));
  test::write_file(folder / "b.NVM", kNvmTwoCameras);
  CHECK(find_visual_sfm(folder.path()) == folder / "b.NVM");
}

}  // namespace
}  // namespace lumatlas
