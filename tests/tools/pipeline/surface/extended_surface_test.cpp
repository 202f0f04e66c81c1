// SPDX-License-Identifier: GPL-3.0-or-later
// Tests that a surface is extended where this makes pictures better, and nowhere else.
#include "tools/pipeline/surface/extended_surface.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/tools/pipeline/surface/gap_scenes.h"
#include "tools/pipeline/surface/completion_gain.h"

namespace lumatlas {
namespace {

Mesh extension_of(const std::vector<SmallPhotograph>& photographs, const Mesh& mesh, const Visibility* far = nullptr) {
  return surface_extension(photographs, mesh, *make_ray_visibility(mesh), far);
}

Mesh with(Mesh mesh, const Mesh& extension) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), extension.positions.begin(), extension.positions.end());
  for (const glm::uvec3& face : extension.faces) mesh.faces.push_back(face + first);
  return mesh;
}

// Returns the share of the gap's pixels of the middle photograph that see a mesh.
double closed_share(const Mesh& mesh) {
  const Camera camera = wall_photographs()[2].camera;
  const VisibilityBuffer open = make_ray_visibility(wall_with_gap())->trace(camera);
  const VisibilityBuffer seen = make_ray_visibility(mesh)->trace(camera);
  double gap = 0, closed = 0;
  for (std::size_t pixel = 0; pixel < open.face.size(); ++pixel) {
    if (open.face[pixel] != FaceId::none) continue;
    ++gap;
    if (seen.face[pixel] != FaceId::none) ++closed;
  }
  return closed / gap;
}

TEST_CASE("a gap is closed by the wall's continuation, whose pictures are nearly exact") {
  for (const double brighter : {0.0, 0.2}) {
    const std::vector<SmallPhotograph> photographs = wall_photographs({.brighter = brighter});
    const Mesh extension = extension_of(photographs, wall_with_gap());
    for (const glm::vec3& position : extension.positions) CHECK(std::abs(position.z - kWall) < 0.1);
    const Mesh whole = with(wall_with_gap(), extension);
    CHECK(closed_share(whole) > 0.95);
    const std::unique_ptr<Visibility> given = make_ray_visibility(wall_with_gap());
    CHECK(completion_gain_db(photographs, *given, nullptr, *make_ray_visibility(whole)).value() >
          0.7 * largest_gain_db(photographs, *given, nullptr).value());
  }
}

TEST_CASE("a surface that ends goes on") {
  Mesh half;
  add_strip(-9, 0.5F, kWall, half);
  const Mesh extension = extension_of(wall_photographs(), half);
  const auto right = std::max_element(extension.positions.begin(), extension.positions.end(),
                                      [](auto a, auto b) { return a.x < b.x; });
  REQUIRE(right != extension.positions.end());
  CHECK(right->x > 1.5F);  // the rightmost photograph shows the wall up to 2.1
  for (const glm::vec3& position : extension.positions) CHECK(std::abs(position.z - kWall) < 0.1);
}

TEST_CASE("nothing is added where photographs show a niche, the far sphere or no gap") {
  const Mesh niche = extension_of(wall_photographs({.gap_depth = 9}), wall_with_gap());
  CHECK(closed_share(with(wall_with_gap(), niche)) < 0.1);

  Mesh behind;
  add_strip(-90, 90, 20, behind);
  const std::unique_ptr<Visibility> far = make_ray_visibility(behind);
  CHECK(extension_of(wall_photographs(), wall_with_gap(), far.get()).faces.empty());
  CHECK(extension_of(wall_photographs(), wall_filled_at(kWall)).faces.empty());
}

TEST_CASE("nothing is added where no two photographs show the same") {
  std::vector<SmallPhotograph> one = wall_photographs();
  one.resize(1);
  CHECK(extension_of(one, wall_with_gap()).faces.empty());
}

TEST_CASE("pixels that a mask takes out are not extended into") {
  std::vector<SmallPhotograph> photographs = wall_photographs();
  for (SmallPhotograph& photograph : photographs) std::fill(photograph.valid.begin(), photograph.valid.end(), 0);
  CHECK(extension_of(photographs, wall_with_gap()).faces.empty());
}

TEST_CASE("the extension does not depend on the number of threads") {
  const Mesh many = extension_of(wall_photographs(), wall_with_gap());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Mesh single = extension_of(wall_photographs(), wall_with_gap());
  CHECK(many.positions == single.positions);
  CHECK(many.faces == single.faces);
}

}  // namespace
}  // namespace lumatlas
