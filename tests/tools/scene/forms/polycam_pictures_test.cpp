// SPDX-License-Identifier: GPL-3.0-or-later
// Polycam's pictures: the black rims of those that it has corrected, and what its depth images are not sure of.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/scene/lenses/black_rim.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using test::write_file;

constexpr std::uint32_t kAcross = 200, kDown = 150;

// How far a pixel is inside the picture that an undistorted barrel lens leaves; below 0: in the rim.
double inside(std::uint32_t x, std::uint32_t y) {
  const double u = (x + 0.5) / kAcross * 2 - 1, v = (y + 0.5) / kDown * 2 - 1;
  const double side = kAcross / 2.0 * (0.96 + 0.04 * v * v - std::abs(u));
  const double end = kDown / 2.0 * (0.96 + 0.04 * u * u - std::abs(v));
  return std::min(side, end);
}

// Bright, with a rim as JPEG leaves it, not quite black.
Photograph rimmed() {
  Photograph photograph{kAcross, kDown, {}, {}};
  for (std::uint32_t y = 0; y < kDown; ++y) {
    for (std::uint32_t x = 0; x < kAcross; ++x) {
      const bool rim = inside(x, y) < 0;
      for (int c = 0; c < 3; ++c)
        photograph.rgb.push_back(static_cast<std::uint8_t>(rim ? (x + y + c) % 9 : 90 + x % 50));
    }
  }
  return photograph;
}

void paint(Photograph& photograph, std::uint32_t left, std::uint32_t top, std::uint32_t right, std::uint32_t bottom,
           std::uint8_t level) {
  for (std::uint32_t y = top; y < bottom; ++y) {
    for (std::uint32_t x = left; x < right; ++x) {
      for (int c = 0; c < 3; ++c) photograph.rgb[3 * (std::size_t{y} * kAcross + x) + c] = level;
    }
  }
}

bool is_rim(const std::vector<bool>& rim, std::uint32_t x, std::uint32_t y) {
  return rim[std::size_t{y} * kAcross + x];
}

TEST_CASE("a black rim is found with the pixels that it darkens, and nothing further inside") {
  const std::vector<bool> rim = black_rim(rimmed());
  std::size_t found = 0;
  for (std::uint32_t y = 0; y < kDown; ++y) {
    for (std::uint32_t x = 0; x < kAcross; ++x) {
      const double depth = inside(x, y);
      CAPTURE(x, y, depth);
      if (depth < 0) REQUIRE(is_rim(rim, x, y));
      if (depth > 4) REQUIRE_FALSE(is_rim(rim, x, y));  // two pixels along each axis, and the rim's slope
      found += is_rim(rim, x, y) ? 1 : 0;
    }
  }
  CHECK(found > 500);
}

TEST_CASE("what is black inside the picture, or dark at its border, is no rim") {
  Photograph photograph{kAcross, kDown, std::vector<std::uint8_t>(std::size_t{3} * kAcross * kDown, 120), {}};
  paint(photograph, 80, 60, 120, 90, 0);
  const std::vector<bool> none = black_rim(photograph);
  CHECK(std::find(none.begin(), none.end(), true) == none.end());
  paint(photograph, 0, 0, kAcross, 20, 25);  // dark, as a shadow is
  const std::vector<bool> dark = black_rim(photograph);
  CHECK(std::find(dark.begin(), dark.end(), true) == dark.end());
  paint(photograph, 0, 40, 100, 110, 0);  // a black thing that reaches the border is taken for a rim to a tenth
  const std::vector<bool> deep = black_rim(photograph);
  CHECK(is_rim(deep, 5, 75));
  CHECK(is_rim(deep, 14, 75));
  CHECK_FALSE(is_rim(deep, 18, 75));
}

std::string camera_json() {
  std::string text = R"({"fx": 150, "fy": 150, "cx": 100, "cy": 75, "width": 200, "height": 150)";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      text += ", \"t_" + std::to_string(row) + std::to_string(column) + "\": " + (row == column ? "1" : "0");
    }
  }
  return text + "}";
}

TEST_CASE("Polycam: rims of corrected photographs are not valid, those of others are what was photographed") {
  for (const bool corrected : {true, false}) {
    const TemporaryFolder folder;
    const std::string start = corrected ? "keyframes/corrected_" : "keyframes/";
    write_file(folder / (start + "cameras/7.json"), camera_json());
    fs::create_directories(folder / (start + "images"));
    write_image(folder / (start + "images/7.png"), rimmed());
    const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0));
    const Photograph loaded = load_photograph(scene.views.at(0));
    if (!corrected) {
      CHECK(loaded.valid.empty());
      continue;
    }
    REQUIRE(loaded.valid.size() == kAcross * kDown);
    CHECK(loaded.valid[kDown / 2 * kAcross + 1] == 0);
    CHECK(loaded.valid[kDown / 2 * kAcross + kAcross / 2] == 255);
  }
}

TEST_CASE("Polycam: confidence goes with the depth image that it is of, and is told") {
  const TemporaryFolder folder;
  for (const char* const id : {"7", "8"}) {
    write_file(folder / ("keyframes/corrected_cameras/" + std::string(id) + ".json"), camera_json());
    fs::create_directories(folder / "keyframes/corrected_images");
    write_image(folder / ("keyframes/corrected_images/" + std::string(id) + ".png"), rimmed());
    write_file(folder / ("keyframes/depth/" + std::string(id) + ".png"), "is looked at later");
  }
  write_file(folder / "keyframes/confidence/8.png", "is looked at later");
  const SceneViews scene = read_scene_views(folder.path(), glm::dvec3(0));
  REQUIRE(scene.depths.size() == 2);
  CHECK_FALSE(scene.depths[0].confidence);
  CHECK(scene.depths[1].confidence == folder / "keyframes/confidence/8.png");
  REQUIRE(scene.notes.size() == 1);
  CHECK_THAT(scene.notes[0], Catch::EndsWith("; pixels of low confidence are left out of 1 of them"));
}

}  // namespace
}  // namespace lumatlas
