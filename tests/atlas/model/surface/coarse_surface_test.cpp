// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/coarse_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

namespace lumatlas {
namespace {

// A square of side 1 with waves, of 2 n^2 faces.
Mesh waves(std::uint32_t n) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(n), v = static_cast<float>(y) / static_cast<float>(n);
      mesh.positions.emplace_back(u, v, 0.02f * std::sin(20 * u) * std::cos(20 * v));
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t corner = y * (n + 1) + x;
      mesh.faces.emplace_back(corner, corner + 1, corner + n + 1);
      mesh.faces.emplace_back(corner + 1, corner + n + 2, corner + n + 1);
    }
  }
  return mesh;
}

CoarseSurface coarse_waves(std::uint32_t n, std::size_t faces) {
  Mesh mesh = waves(n);
  mesh.colors.assign(mesh.positions.size(), glm::u8vec3(90, 120, 60));
  return coarse_surface(mesh, faces);
}

TEST_CASE("a mesh of few faces needs no coarse surface, which has no geometric error") {
  CHECK(!needs_coarse_surface(200, 100));
  CHECK(needs_coarse_surface(201, 100));
  CHECK(!needs_coarse_surface(1'000'000, 0));
  CHECK(geometric_error({}) == 0);
}

TEST_CASE("the geometric error of a coarse surface is 16 times the distance of its colours") {
  for (const std::size_t faces : {500u, 2000u}) {
    const CoarseSurface coarse = coarse_waves(100, faces);
    REQUIRE(coarse.mesh.faces.size() <= 2 * faces);
    REQUIRE(coarse.mesh.colors.size() == coarse.mesh.positions.size());
    // Vertices of a flat square are about sqrt(2 / faces) apart: two faces share a square of that side.
    const double spacing = std::sqrt(2.0 / static_cast<double>(coarse.mesh.faces.size()));
    CHECK(geometric_error(coarse) > 0.6 * 16 * spacing);
    CHECK(geometric_error(coarse) < 1.8 * 16 * spacing);
    CHECK(geometric_error(coarse) >= coarse.error);
  }
}

TEST_CASE("the geometric error is what the surface moved, where that is more") {
  CoarseSurface coarse = coarse_waves(100, 2000);
  coarse.error = 50;
  CHECK(geometric_error(coarse) == 50);
}

}  // namespace
}  // namespace lumatlas
