// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/views/sharpness.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/pipeline/sharp_scene.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

Photograph one_photograph() {
  return read_photograph(fs::directory_iterator(sharp_scene() / "images")->path());
}

// Looks along z from (x, 0, z).
Camera camera_at(double x, double z) {
  Camera camera = centered_camera(64, 48, 60);
  camera.cam_from_world_translation = {-x, 0, -z};
  return camera;
}

std::vector<std::optional<double>> alike(std::size_t count) {
  return std::vector<std::optional<double>>(count, -0.5);
}

TEST_CASE("a blurred photograph has less fine detail than the same one sharp, and one of one colour has none") {
  const Photograph sharp = one_photograph();
  Photograph blurred = sharp;
  blur(blurred);
  REQUIRE(fine_detail(sharp));
  REQUIRE(fine_detail(blurred));
  CHECK(*fine_detail(blurred) < *fine_detail(sharp) - 0.5);
  Photograph plain = sharp;
  std::fill(plain.rgb.begin(), plain.rgb.end(), std::uint8_t{90});
  CHECK_FALSE(fine_detail(plain));
  CHECK_FALSE(fine_detail({2, 2, std::vector<std::uint8_t>(12, 5), {}}));
}

TEST_CASE("a photograph is as sharp as those that were taken beside it, whatever others show") {
  std::vector<Camera> cameras;
  std::vector<std::optional<double>> details = alike(60);
  for (int i = 0; i < 30; ++i) cameras.push_back(camera_at(0.1 * i, 0));
  for (int i = 0; i < 30; ++i) cameras.push_back(camera_at(0.1 * i, 100));
  for (std::size_t i = 30; i < 60; ++i) details[i] = -1.5;  // of another place
  for (const double sharpness : relative_sharpness(cameras, details)) CHECK(sharpness == 1);

  details[7] = -0.55;   // as other content may have
  details[12] = -1.0;   // blurred
  details[20].reset();  // not known
  const std::vector<double> sharpness = relative_sharpness(cameras, details);
  for (std::size_t i = 0; i < 60; ++i) {
    CAPTURE(i);
    if (i == 12) {
      CHECK(sharpness[i] > 0.1);
      CHECK(sharpness[i] < 0.5);
    } else {
      CHECK(sharpness[i] == 1);
    }
  }
  CHECK(relative_sharpness(std::vector<Camera>(1), alike(1)) == std::vector<double>{1});
  CHECK(relative_sharpness({}, {}).empty());
  CHECK_THROWS_AS(relative_sharpness(cameras, alike(59)), std::invalid_argument);
}

TEST_CASE("of photographs that show the same a build stores the sharp ones") {
  // Each second photograph is blurred, and each has a neighbour from nearly the same place.
  const TemporaryFolder folder;
  const fs::path& scene = folder.path();
  write_apartment(scene, 48);
  std::set<std::string> blurred;
  bool is_blurred = false;
  std::set<fs::path> files;
  for (const auto& file : fs::directory_iterator(scene / "images")) files.insert(file.path());
  for (const fs::path& file : files) {
    is_blurred = !is_blurred;
    if (!is_blurred) continue;
    Photograph photograph = read_photograph(file);
    blur(photograph);
    write_image(file, photograph);
    blurred.insert(file.filename().string());
  }
  const auto stored_blurred = [&](bool sharp_first) {
    BuildOptions options;
    options.max_views = 12;
    options.refine = RefineMode::none;
    options.sharp_first = sharp_first;
    const BuildResult result = build_model(scene, options);
    std::size_t count = 0;
    for (const auto& view : result.snapshot.views) count += view && blurred.contains(view->name);
    return count;
  };
  const std::size_t without = stored_blurred(false), with = stored_blurred(true);
  CAPTURE(without, with);
  CHECK(without >= 4);
  CHECK(with * 2 <= without);
}

}  // namespace
}  // namespace lumatlas
