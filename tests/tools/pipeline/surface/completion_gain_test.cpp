// SPDX-License-Identifier: GPL-3.0-or-later
// Tests the predicted gain of surface that is added to a wall with a gap. The photographs' depth is known.
#include "tools/pipeline/surface/completion_gain.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr double kWall = 3;  // depth of the wall

double wall_level(double x, double y) {
  return 120 + 50 * std::sin(9 * x + 1) * std::cos(7 * y) + 30 * std::sin(23 * x + 13 * y);
}

// A part of a plane from `left` to `right`, at `depth`.
void add_strip(float left, float right, float depth, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {left, right}) {
    for (const float y : {-9.0F, 9.0F}) mesh.positions.emplace_back(x, y, depth);
  }
  mesh.faces.emplace_back(first, first + 1, first + 2);
  mesh.faces.emplace_back(first + 2, first + 1, first + 3);
}

// The wall with a gap, and what fills it at a depth.
Mesh wall_with_gap() {
  Mesh mesh;
  add_strip(-9, -0.3F, kWall, mesh);
  add_strip(0.3F, 9, kWall, mesh);
  return mesh;
}
Mesh wall_filled_at(float depth) {
  Mesh mesh = wall_with_gap();
  add_strip(-0.3F, 0.3F, depth, mesh);
  return mesh;
}

// Five photographs of the wall; every second one is brighter by `brighter`, of 1. `contrast` multiplies the texture.
std::vector<SmallPhotograph> wall_photographs(double contrast = 1, double brighter = 0) {
  std::vector<SmallPhotograph> photographs;
  for (int i = 0; i < 5; ++i) {
    SmallPhotograph photograph;
    photograph.camera = forward_camera(160, 120, {0.3 * i - 0.6, 0, 0});
    for (std::uint32_t y = 0; y < 120; ++y) {
      for (std::uint32_t x = 0; x < 160; ++x) {
        const glm::dvec3 point = photograph.camera.center() + kWall * photograph.camera.ray({x + 0.5, y + 0.5});
        const double level = 120 + contrast * (wall_level(point.x, point.y) - 120);
        photograph.color.emplace_back(static_cast<float>(level * (i % 2 == 0 ? 1 : 1 + brighter)));
        photograph.valid.push_back(1);
      }
    }
    photographs.push_back(std::move(photograph));
  }
  return photographs;
}

double largest_gain(const std::vector<SmallPhotograph>& photographs) {
  const std::optional<double> gain = largest_gain_db(photographs, *make_ray_visibility(wall_with_gap()), nullptr);
  REQUIRE(gain);
  return *gain;
}

TEST_CASE("a gap can cost much only where pictures are good beside it") {
  const double exact = largest_gain(wall_photographs());
  const double uneven = largest_gain(wall_photographs(1, 0.5));
  CHECK(exact > 3);
  CHECK(uneven > 0);
  CHECK(uneven < 0.25 * exact);
}

TEST_CASE("a gap costs nothing where its fill is right, nor where there is none") {
  CHECK(largest_gain(wall_photographs(0)) < 0.01);
  const std::unique_ptr<Visibility> whole = make_ray_visibility(wall_filled_at(kWall));
  CHECK(largest_gain_db(wall_photographs(), *whole, nullptr) == 0.0);
}

TEST_CASE("a gap that shows what is far lacks nothing") {
  Mesh behind;
  add_strip(-90, 90, 20, behind);
  const std::unique_ptr<Visibility> given = make_ray_visibility(wall_with_gap()), far = make_ray_visibility(behind);
  CHECK(largest_gain_db(wall_photographs(), *given, far.get()) == 0.0);
}

TEST_CASE("nothing is known of a gap that one photograph shows") {
  std::vector<SmallPhotograph> one = wall_photographs();
  one.resize(1);
  CHECK_FALSE(largest_gain_db(one, *make_ray_visibility(wall_with_gap()), nullptr));
}

TEST_CASE("the right surface in a gap brings nearly all that can be had, a wrong one makes pictures worse") {
  for (const double brighter : {0.0, 0.3}) {
    const std::vector<SmallPhotograph> photographs = wall_photographs(1, brighter);
    const std::unique_ptr<Visibility> given = make_ray_visibility(wall_with_gap());
    const auto gain = [&](float depth) {
      return completion_gain_db(photographs, *given, nullptr, *make_ray_visibility(wall_filled_at(depth))).value();
    };
    CHECK(gain(kWall) > 0.8 * largest_gain(photographs));
    CHECK(gain(1.7F) < 0);
  }
}

}  // namespace
}  // namespace lumatlas
