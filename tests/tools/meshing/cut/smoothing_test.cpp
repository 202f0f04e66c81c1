// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/cut/smoothing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

namespace lumatlas {
namespace {

// A square of 20 x 20 vertices whose heights are off by up to 0.2.
TriangleSoup rough_square() {
  TriangleSoup square;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const double height = 0.2 * std::sin(12.9898 * i * i);
    square.positions.emplace_back(i % 20, i / 20, height);
  }
  for (std::uint32_t y = 0; y < 19; ++y) {
    for (std::uint32_t x = 0; x < 19; ++x) {
      const std::uint32_t a = 20 * y + x;
      square.faces.emplace_back(a, a + 1, a + 20);
      square.faces.emplace_back(a + 1, a + 21, a + 20);
    }
  }
  return square;
}

double roughness(const TriangleSoup& square) {
  double sum = 0;
  for (const glm::dvec3& position : square.positions) sum += position.z * position.z;
  return sum;
}

bool is_at_border(std::size_t i) {
  return i % 20 == 0 || i % 20 == 19 || i < 20 || i >= 380;
}

TEST_CASE("noise goes, as far as deviations allow, and the border stays") {
  const TriangleSoup before = rough_square();
  TriangleSoup free = before, held = before;
  smooth(free, std::vector<float>(400, 10.0F));
  smooth(held, std::vector<float>(400, 0.05F));
  CHECK(roughness(free) < 0.4 * roughness(before));
  CHECK(roughness(held) < roughness(before));
  CHECK(roughness(held) > roughness(free));
  for (std::size_t i = 0; i < 400; ++i) {
    CHECK(glm::distance(held.positions[i], before.positions[i]) < 0.0501);
    if (is_at_border(i)) CHECK(free.positions[i] == before.positions[i]);
  }
}

TEST_CASE("where nothing may be off, nothing moves") {
  const TriangleSoup before = rough_square();
  TriangleSoup after = before;
  smooth(after, std::vector<float>(400, 0.0F));
  CHECK(after.positions == before.positions);
}

TEST_CASE("deviations that are not one a vertex are refused") {
  TriangleSoup square = rough_square();
  CHECK_THROWS_AS(smooth(square, std::vector<float>(399, 1.0F)), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
