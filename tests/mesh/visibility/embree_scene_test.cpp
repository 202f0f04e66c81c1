// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/embree_scene.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace lumatlas {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

// Across the axis at z = 4.
Mesh wall() {
  Mesh mesh;
  mesh.positions = {{-9, -9, 4}, {9, -9, 4}, {9, 9, 4}, {-9, 9, 4}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST_CASE("the rays of a packet that are set meet the wall where it is, the others nothing") {
  const EmbreeDevice device = make_embree_device();
  const EmbreeScene scene = make_embree_scene(device.get(), wall(), RTC_BUILD_QUALITY_MEDIUM);
  for (const std::uint32_t count : {0u, 1u, 5u, 8u, 16u}) {
    EmbreePacket met;
    for (std::uint32_t ray = 0; ray < count; ++ray) {
      met.set(ray, glm::vec3(0), glm::vec3(0.01f * static_cast<float>(ray), 0, 1), kFar);
    }
    EmbreePacket blocked = met;
    met.intersect(scene.get());
    blocked.occlude(scene.get());
    for (std::uint32_t ray = 0; ray < EmbreePacket::kRays; ++ray) {
      CAPTURE(count, ray);
      CHECK((met.hits.hit.geomID[ray] != RTC_INVALID_GEOMETRY_ID) == (ray < count));
      CHECK((blocked.hits.ray.tfar[ray] == -kFar) == (ray < count));
      if (ray < count) CHECK(met.hits.ray.tfar[ray] == Approx(4).epsilon(1e-6));
    }
  }
}

TEST_CASE("a ray of a packet that ends before the wall meets nothing") {
  const EmbreeDevice device = make_embree_device();
  const EmbreeScene scene = make_embree_scene(device.get(), wall(), RTC_BUILD_QUALITY_MEDIUM);
  EmbreePacket packet;
  packet.set(0, glm::vec3(0), glm::vec3(0, 0, 1), 3.9f);
  packet.set(15, glm::vec3(0), glm::vec3(0, 0, 1), 4.1f);
  packet.intersect(scene.get());
  CHECK(packet.hits.hit.geomID[0] == RTC_INVALID_GEOMETRY_ID);
  CHECK(packet.hits.hit.geomID[15] != RTC_INVALID_GEOMETRY_ID);
}

TEST_CASE("what Embree would end the program over cannot be traced") {
  CHECK(is_traceable(glm::vec3(-1e18f, 0, 1e18f)));
  CHECK_FALSE(is_traceable(glm::vec3(2e18f, 0, 0)));
  CHECK_FALSE(is_traceable(glm::vec3(0, -kFar, 0)));
  CHECK_FALSE(is_traceable(glm::vec3(0, 0, std::nanf(""))));
}

}  // namespace
}  // namespace lumatlas
