// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/seam_contrast.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 48;

// A wall that fills the picture, its left half in one cell, its right half in the other.
struct Wall {
  Mesh mesh;
  Cells cells;
  Camera camera = forward_camera(kWidth, kHeight);
  VisibilityBuffer visible;

  explicit Wall(std::uint32_t columns_of_first = 10) {
    add_wall(mesh, 20, 20, 0.5F, 4);
    std::vector<CellId> cell_of_face;
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
      cell_of_face.emplace_back(face / 2 % 20 < columns_of_first ? 0u : 1u);
    }
    cells = measure_cells(mesh, std::move(cell_of_face), 5);
    visible = make_ray_visibility(mesh)->trace(camera);
  }

  [[nodiscard]] double contrast(const Photograph& rendering, const Photograph& photograph) const {
    SeamMeter meter(mesh, cells);
    meter.add(visible, rendering, photograph);
    CHECK(meter.borders() == kHeight);
    return meter.contrast();
  }
};

Photograph picture(const std::function<double(int x, int y, int channel)>& value) {
  Photograph image{kWidth, kHeight, {}, {}};
  for (int y = 0; y < static_cast<int>(kHeight); ++y) {
    for (int x = 0; x < static_cast<int>(kWidth); ++x) {
      for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<std::uint8_t>(std::lround(value(x, y, c))));
    }
  }
  return image;
}

// Checks of 3 x 3 pixels, with much contrast everywhere.
double checks(int x, int y, int c) {
  return 80 + 20 * c + 60 * ((x / 3 + y / 3) % 2);
}

TEST_CASE("a step of known height at the border of two cells is the seam contrast") {
  const Wall wall;
  const Photograph photograph = picture(checks);
  CHECK(wall.contrast(photograph, photograph) == 0);
  const Photograph stepped =
      picture([](int x, int y, int c) { return checks(x, y, c) + (x < static_cast<int>(kWidth) / 2 ? 0 : 10); });
  CHECK(wall.contrast(stepped, photograph) == Approx(10));
}

TEST_CASE("an error that steps everywhere alike is no seam, and does not hide one") {
  const Wall wall;
  const Photograph photograph = picture(checks);
  const auto noisy = [&](double step) {
    std::mt19937 random(1);
    return picture([&](int x, int y, int c) {
      return checks(x, y, c) + static_cast<int>(random() % 13) + (x < static_cast<int>(kWidth) / 2 ? 0 : step);
    });
  };
  // 48 borders of 3 values: the mean square steps, 28 levels squared, differ by about 10 % on the two sides.
  CHECK(std::abs(wall.contrast(noisy(0), photograph)) < 3);
  CHECK(wall.contrast(noisy(20), photograph) == Approx(20).margin(1.5));
}

TEST_CASE("a blurred picture has no seam, and one with a seam does not lose it for being blurred") {
  const Wall wall;
  const Photograph photograph = picture(checks);
  const auto blurred = [&](double step) {
    return picture([&](int x, int y, int c) {
      double sum = 0;
      for (int i = -4; i <= 4; ++i) sum += checks(x + 9 + i, y, c) / 9;
      return sum + (x < static_cast<int>(kWidth) / 2 ? 0 : step);
    });
  };
  const double blur_alone = wall.contrast(blurred(0), photograph);
  const double both = wall.contrast(blurred(12), photograph);
  // The checks' own edges fall on the border or beside it, row by row; what is left of them is the same in both.
  CHECK(both * both - std::copysign(blur_alone * blur_alone, blur_alone) == Approx(144).margin(30));
}

TEST_CASE("an edge of the photograph that the rendering reproduces is no seam") {
  const Wall wall;
  const Photograph edge = picture([](int x, int, int) { return x < static_cast<int>(kWidth) / 2 ? 40 : 200; });
  CHECK(wall.contrast(edge, edge) == 0);
  // The smeared edge of the rendering is an error at the border: half the edge is missing there.
  const Photograph flat = picture([](int, int, int) { return 120; });
  CHECK(wall.contrast(flat, edge) == Approx(160));
}

TEST_CASE("borders of surfaces that only look connected are not looked at") {
  Mesh mesh;
  add_wall(mesh, 10, 20, 0.5F, 4);
  add_wall(mesh, 10, 20, 0.5F, 4);
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    mesh.positions[vertex].x += vertex < mesh.positions.size() / 2 ? -2.5F : 2.50001F;  // side by side, no place shared
  }
  std::vector<CellId> cell_of_face(mesh.faces.size(), 0);
  std::fill(cell_of_face.begin() + static_cast<std::ptrdiff_t>(cell_of_face.size() / 2), cell_of_face.end(), CellId{1});
  const Cells cells = measure_cells(mesh, std::move(cell_of_face), 5);
  SeamMeter meter(mesh, cells);
  const Photograph photograph = picture(checks);
  meter.add(make_ray_visibility(mesh)->trace(forward_camera(kWidth, kHeight)), photograph, photograph);
  CHECK(meter.borders() == 0);
  CHECK(std::isnan(meter.contrast()));
}

TEST_CASE("seams are refused of cells, faces and buffers that are not the mesh's") {
  const Wall wall;
  Cells fewer = wall.cells;
  fewer.cell_of_face.pop_back();
  CHECK_THROWS_WITH(SeamMeter(wall.mesh, fewer), Catch::Contains("must have one per face, 800"));
  Mesh torn = wall.mesh;
  torn.faces[3].y = 4000000;
  CHECK_THROWS_AS(SeamMeter(torn, wall.cells), std::invalid_argument);
  SeamMeter meter(wall.mesh, wall.cells);
  const Photograph photograph = picture(checks);
  VisibilityBuffer other = wall.visible;
  other.face[77] = 800;
  CHECK_THROWS_WITH(meter.add(other, photograph, photograph), Catch::Contains("shows face 800"));
  other = wall.visible;
  other.face.pop_back();
  CHECK_THROWS_WITH(meter.add(other, photograph, photograph), Catch::Contains("visible.face"));
  other = wall.visible;
  other.depth.clear();
  CHECK_THROWS_WITH(meter.add(other, photograph, photograph), Catch::Contains("visible.depth"));
  CHECK(meter.borders() == 0);
}

TEST_CASE("pixels outside the lens's image and pictures of another size do not enter seams") {
  const Wall wall;
  Photograph photograph = picture(checks);
  SeamMeter meter(wall.mesh, wall.cells);
  const Photograph small{8, 8, std::vector<std::uint8_t>(192), {}};
  CHECK_THROWS_WITH(meter.add(wall.visible, small, small), Catch::Contains("as large as"));
  const Photograph rendering = photograph;
  photograph.valid.assign(std::size_t{kWidth} * kHeight, 255);
  std::fill_n(photograph.valid.begin(), kWidth * 10, std::uint8_t{0});
  meter.add(wall.visible, rendering, photograph);
  CHECK(meter.borders() == kHeight - 10);
}

}  // namespace
}  // namespace lumatlas
