// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/surface_deviation.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/trigonometric.hpp>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/far_sphere.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/painted_wall.h"

namespace lumatlas {
namespace {

TEST_CASE("a surface that stands before what photographs show deviates by that distance, and an exact one by little") {
  constexpr double kDeviationOfDistance = 1.4826;  // what a median absolute deviation is multiplied by
  for (const double before : {0.0, 0.05, 0.1, 0.2}) {
    CAPTURE(before);
    const SurfaceDeviation deviation = surface_deviation(photographed(wall_before(before), speckled));
    REQUIRE(deviation.of_cell.size() == 16);
    for (std::size_t cell = 0; cell < 16; ++cell) {
      CAPTURE(cell);
      CHECK(static_cast<int>(deviation.measured[cell]) == 1);
      const double expected = kDeviationOfDistance * before;
      // A tenth of a pixel at this angle is 0.014 scene units.
      CHECK(std::abs(static_cast<double>(deviation.of_cell[cell]) - expected) < 0.02 + 0.15 * expected);
    }
  }
}

TEST_CASE("where each photograph shows something else, the surface is off by all that was searched") {
  std::vector<WallPaint> paints;
  for (const double shift : {0.0, 31.3, 77.7}) {
    paints.emplace_back([shift](double x, double y) { return speckled(x + shift, y - 2 * shift); });
  }
  const SurfaceDeviation exact = surface_deviation(photographed(wall_before(0), speckled));
  const SurfaceDeviation other = surface_deviation(photographed(wall_before(0), paints));
  for (std::size_t cell = 0; cell < 16; ++cell) {
    CHECK(static_cast<int>(other.measured[cell]) == 1);
    CHECK(other.of_cell[cell] > 10 * exact.of_cell[cell]);
    CHECK(other.of_cell[cell] > 0.5f);  // six pixels are 0.86 scene units at eight degrees
  }
}

TEST_CASE("what repeats is taken to be where the surface is") {
  const WallPaint stripes = [](double x, double /*y*/) { return 128 + 100 * std::sin(2 * 3.14159265 * x / 0.12); };
  const SurfaceDeviation deviation = surface_deviation(photographed(wall_before(0), stripes));
  for (const float of_cell : deviation.of_cell) CHECK(of_cell < 0.05f);
}

TEST_CASE("where nothing can be compared nothing is measured, and the surface counts as exact") {
  const std::shared_ptr<const Surface> wall = wall_before(0.1);
  for (const Snapshot& snapshot :
       {photographed(wall, grey), photographed(wall, std::vector<WallPaint>{speckled}), Atlas(wall, 1).snapshot()}) {
    const SurfaceDeviation deviation = surface_deviation(snapshot);
    CHECK(deviation.measured == std::vector<std::uint8_t>(16, 0));
    CHECK(deviation.of_cell == std::vector<float>(16, 0.0f));
  }
}

TEST_CASE("a part without texture has the deviation of the parts beside it") {
  // Texture left of the middle alone.
  const WallPaint half = [](double x, double y) { return x < -0.05 ? speckled(x, y) : 128; };
  const SurfaceDeviation deviation = surface_deviation(photographed(wall_before(0.1), half));
  for (std::size_t row = 0; row < 4; ++row) {
    CHECK(static_cast<int>(deviation.measured[4 * row]) == 1);
    CHECK(static_cast<int>(deviation.measured[4 * row + 3]) == 0);
    const float nearest = deviation.of_cell[4 * row + (deviation.measured[4 * row + 2] ? 2 : 1)];
    CHECK(deviation.of_cell[4 * row + 3] == Approx(nearest).epsilon(0.5));
  }
}

// Bars before the wall, one for each place of a left side, close enough together for most patches of the wall to reach
// over the edge of one.
constexpr float kBarDepth = 3, kBarWidth = 0.04f, kBarStep = 0.2f;

void add_bar(Mesh& mesh, float left) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {left, left + kBarWidth}) {
    for (const float y : {-1.0f, 1.0f}) mesh.positions.emplace_back(x, y, kBarDepth);
  }
  mesh.faces.emplace_back(first, first + 1, first + 2);
  mesh.faces.emplace_back(first + 2, first + 1, first + 3);
}

std::shared_ptr<const Surface> exact_wall_behind(const std::vector<float>& bars) {
  const auto surface = std::make_shared<Surface>(*wall_before(0));
  std::vector<CellId> cell_of_face = surface->cells.cell_of_face;
  for (const float left : bars) add_bar(surface->mesh, left);
  cell_of_face.resize(surface->mesh.faces.size(), CellId{16});
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 0.5);
  return surface;
}

// What a camera sees of a place of the wall, which has little contrast: white where a bar is before it.
WallPaint behind_white(const std::vector<float>& bars, const Camera& camera) {
  return [bars, center = camera.center()](double x, double y) {
    const double share = (static_cast<double>(kBarDepth) - center.z) / (kWallDepth - center.z);
    const auto at_bars = static_cast<float>(center.x + share * (x - center.x));
    const auto is_in = [&](float left) { return at_bars > left && at_bars < left + kBarWidth; };
    return std::any_of(bars.begin(), bars.end(), is_in) ? 255 : 113 + 0.12 * speckled(x, y);
  };
}

TEST_CASE("what stands before a surface does not count as its error") {
  std::vector<float> bars;
  for (int bar = -5; bar <= 5; ++bar) bars.push_back(static_cast<float>(bar) * kBarStep);
  std::vector<WallPaint> paints;
  for (const Camera& camera : cameras_before_wall()) paints.push_back(behind_white(bars, camera));
  const SurfaceDeviation deviation =
      surface_deviation(photographed(exact_wall_behind(bars), paints), {.points = 32, .cancel_check = {}});
  CHECK(std::count(deviation.measured.begin(), deviation.measured.begin() + 16, 1) >= 4);
  for (std::size_t cell = 0; cell < 16; ++cell) CHECK(deviation.of_cell[cell] < 0.05f);
}

TEST_CASE("the far sphere does not deviate, and the cells before it do as without it") {
  const std::shared_ptr<const Surface> wall = wall_before(0.1);
  FarSphere far{far_sphere({glm::dvec3(0), 1000}, 0.8), {}};
  far.cells = make_cells(far.mesh, {.size = 1000});
  const auto with_far = std::make_shared<const Surface>(with_far_sphere(*wall, far));
  const SurfaceDeviation near = surface_deviation(photographed(wall, speckled));
  const SurfaceDeviation both = surface_deviation(photographed(with_far, speckled));
  REQUIRE(both.of_cell.size() == 16 + far.cells.cells.size());
  CHECK(std::equal(near.of_cell.begin(), near.of_cell.end(), both.of_cell.begin()));
  CHECK(std::all_of(both.of_cell.begin() + 16, both.of_cell.end(), [](float of_cell) { return of_cell == 0; }));
  CHECK(std::count(both.measured.begin() + 16, both.measured.end(), 1) == 0);
}

TEST_CASE("one thread measures the same as several, and a cancel check ends it") {
  const Snapshot snapshot = photographed(wall_before(0.1), speckled);
  const SurfaceDeviation several = surface_deviation(snapshot);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    CHECK(surface_deviation(snapshot).of_cell == several.of_cell);
  }
  DeviationOptions options;
  options.cancel_check = [] { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(surface_deviation(snapshot, options), "enough");
}

TEST_CASE("a deviation shifts a picture by its sine's share of it in pixels") {
  CHECK(shift_px(0.1, 1000, 5) == Approx(100 * std::sin(glm::radians(10.0)) / 5));
}

TEST_CASE("options that measure nothing are refused by name") {
  const auto refused = [](const auto& change) { return refusal<DeviationOptions>(change); };
  CHECK_THAT(refused([](auto& o) { o.points = 0; }), Catch::Contains("points is 0"));
  CHECK_THAT(refused([](auto& o) { o.patch_radius = 33; }), Catch::Contains("patch_radius is 33"));
  CHECK_THAT(refused([](auto& o) { o.most_shift_px = 0.5; }), Catch::Contains("most_shift_px is 0.5"));
  CHECK_THAT(refused([](auto& o) { o.least_angle_deg = 0; }), Catch::Contains("least_angle_deg is 0"));
  CHECK_THAT(refused([](auto& o) { o.most_angle_deg = 1; }), Catch::Contains("most_angle_deg is 1"));
  CHECK_THAT(refused([](auto& o) { o.least_correlation = 0; }), Catch::Contains("least_correlation is 0"));
  CHECK_THAT(refused([](auto& o) { o.least_contrast = -1; }), Catch::Contains("least_contrast is -1"));
}

}  // namespace
}  // namespace lumatlas
