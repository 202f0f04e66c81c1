// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/mesh_completion.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mesh/base/errors.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

// A flat wall of 60 x 60 squares, ten a unit, at depth z before the arc's cameras, without what `leaves_out` says.
template <typename LeavesOut>
TriangleSoup wall(double z, const LeavesOut& leaves_out) {
  constexpr std::uint32_t kSide = 61;
  TriangleSoup soup;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) soup.positions.emplace_back(0.1 * x - 3, 0.1 * y - 3, z);
  }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t a = kSide * y + x;
      if (leaves_out(soup.positions[a])) continue;
      soup.faces.emplace_back(a, a + kSide, a + 1);
      soup.faces.emplace_back(a + 1, a + kSide, a + kSide + 1);
    }
  }
  return soup;
}

const auto kWhole = [](const glm::dvec3&) { return false; };
const auto kHole = [](const glm::dvec3& at) { return std::max(std::abs(at.x), std::abs(at.y)) < 0.8; };

std::vector<Camera> cameras() {
  return {camera_on_arc(-8), camera_on_arc(0), camera_on_arc(8)};
}

CompletedMesh complete(const TriangleSoup& given, const TriangleSoup& other) {
  std::size_t looked = 0;
  CompletedMesh result = completed(given, other, cameras(), glm::dvec3(0), [&] { ++looked; });
  CHECK(looked == 3);
  return result;
}

TEST_CASE("what another mesh shows in a hole is added, and nothing over what is there") {
  const TriangleSoup given = wall(4, kHole);
  const CompletedMesh result = complete(given, wall(4.01, kWhole));
  // The hole is 16 squares of two faces a side.
  CHECK(result.added_faces > 450);
  CHECK(result.added_faces < 600);
  CHECK(result.covered_before < 0.9);
  CHECK(result.covered > 0.99);
  REQUIRE(result.surface.faces.size() == given.faces.size() + result.added_faces);
  CHECK(std::equal(given.faces.begin(), given.faces.end(), result.surface.faces.begin()));
  CHECK(std::equal(given.positions.begin(), given.positions.end(), result.surface.positions.begin()));
  for (std::size_t i = given.positions.size(); i < result.surface.positions.size(); ++i) {
    CHECK(std::max(std::abs(result.surface.positions[i].x), std::abs(result.surface.positions[i].y)) < 1);
  }
}

TEST_CASE("what stands before or behind a surface is not added, nor are scraps") {
  const TriangleSoup given = wall(4, kWhole);
  CHECK(complete(given, wall(3.5, kWhole)).added_faces < 200);  // what sees past the ends of the given one
  CHECK(complete(given, wall(4.5, kHole)).added_faces == 0);
  const auto scrap = [](const glm::dvec3& at) { return std::max(std::abs(at.x), std::abs(at.y)) > 0.3; };
  CHECK(complete(wall(4, kHole), wall(4, scrap)).added_faces == 0);
}

TEST_CASE("what is added has the mean of the given colours") {
  TriangleSoup given = wall(4, kHole);
  given.colors.assign(given.positions.size(), {10, 20, 30});
  const CompletedMesh result = complete(given, wall(4, kWhole));
  REQUIRE(result.surface.colors.size() == result.surface.positions.size());
  CHECK(result.surface.colors.back() == glm::u8vec3(10, 20, 30));
}

TEST_CASE("a mesh without faces cannot be completed") {
  CHECK_THROWS_AS(completed(TriangleSoup{}, wall(4, kWhole), cameras(), glm::dvec3(0), [] {}), InputError);
}

}  // namespace
}  // namespace lumatlas
