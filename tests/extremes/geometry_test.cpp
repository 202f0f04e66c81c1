// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes at the edges: where in the world and how large, in which order, broken, tiny, thin. What is the same scene
// must give the same model.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>
#include <utility>

#include "mesh/repair/repair.h"
#include "tests/extremes/extreme_scenes.h"
#include "tests/support/rendering_difference.h"

namespace lumatlas {
namespace {

using Catch::Contains;

std::vector<Decision> decisions(const BuildResult& result) {
  std::vector<Decision> all;
  for (const PlannedView& view : result.planned) all.push_back(view.verdict.decision);
  return all;
}

// The same decisions, and a picture in which at most this share of the pixels differs by more than two levels.
void check_equivalent(const BuildOptions& options, double scale, const glm::dmat3& rotation,
                      const glm::dvec3& translation, double share) {
  const BuildResult here = built(six_views(), options);
  const BuildResult there = built(transformed(six_views(), scale, rotation, translation), options);
  CHECK(decisions(there) == decisions(here));
  CHECK(stored_names(there) == stored_names(here));
  // Which of two cells as near has a face is for rounding to say, and then what is small enough to be merged.
  CHECK(there.snapshot.surface->cells.cells.size() ==
        Approx(here.snapshot.surface->cells.cells.size()).epsilon(share > 0 ? 0.03 : 0));
  const Rendering a = pictured(here, novel_camera());
  const Rendering b = pictured(there, transformed(novel_camera(), scale, rotation, translation));
  CHECK(textured_share(a) > 0.6);
  CHECK(share_different(a, b, 2) <= share);
}

const glm::dmat3 kUpright(1.0);
const glm::dvec3 kHere(0.0);

TEST_CASE("all lengths times a power of two give the same model, to the byte of its picture") {
  for (const double scale : {0x1p-13, 0x1p20}) {
    CAPTURE(scale);
    check_equivalent(plain_build(), scale, kUpright, kHere, 0);
  }
}

TEST_CASE("all lengths times 1e-4 or 1e6 give the same decisions and picture, refined or not") {
  for (const double scale : {1e-4, 1e6}) {
    CAPTURE(scale);
    check_equivalent(plain_build(), scale, kUpright, kHere, 0.01);
    check_equivalent(default_build(), scale, kUpright, kHere, 0.02);
  }
}

TEST_CASE("a georeferenced scene gives the decisions and the picture that it gives at the origin") {
  check_equivalent(plain_build(), 1, kUpright, {1e7, -2e7, 1234567}, 0.005);
  check_equivalent(default_build(), 1, kUpright, {1e7, -2e7, 1234567}, 0.02);
}

TEST_CASE("a scene that lies on its side gives the same decisions and picture") {
  BuildOptions options = plain_build();
  options.cells.size = 0.25;  // the automatic one is measured along the axes
  check_equivalent(options, 1, glm::dmat3({0, 1, 0}, {0, 0, 1}, {1, 0, 0}), kHere, 0.005);
  check_equivalent(options, 1, glm::dmat3(glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, -2, 0.5))), {3, -1, 8}, 0.03);
}

TEST_CASE("the order of the mesh's faces and vertices does not show in the picture") {
  BuildOptions options = plain_build();
  options.cells.size = 0.5;
  EdgeScene shuffled = six_views();
  std::mt19937 random(5);
  std::shuffle(shuffled.soup.faces.begin(), shuffled.soup.faces.end(), random);
  for (glm::uvec3& face : shuffled.soup.faces) face = {face.y, face.z, face.x};
  const Rendering a = pictured(built(six_views(), options), novel_camera());
  const BuildResult other = built(shuffled, options);
  CHECK(stored_names(other).size() == 6);
  CHECK(share_different(a, pictured(other, novel_camera()), 12) < 0.02);  // cells grow otherwise, so borders move
}

TEST_CASE("what is wrong with a mesh is repaired, and its picture is that of the whole one") {
  EdgeScene broken = six_views();
  TriangleSoup& soup = broken.soup;
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  const std::vector<glm::uvec3> faces = soup.faces;
  soup.faces.push_back(faces[3]);                                  // a duplicate,
  soup.faces.emplace_back(faces[5].y, faces[5].x, faces[5].z);     // one that is flipped,
  soup.faces.emplace_back(faces[0].x, faces[0].x, faces[0].y);     // one without area,
  soup.positions.insert(soup.positions.end(), 3, glm::dvec3(99));  // a point of three vertices, two of them isolated,
  soup.faces.emplace_back(first, first, first);
  for (std::size_t face = 0; face < soup.faces.size(); face += 3) std::swap(soup.faces[face].x, soup.faces[face].y);
  const BuildResult whole = built(six_views(), plain_build());
  const BuildResult repaired = built(broken, plain_build());
  CHECK(stored_names(repaired) == stored_names(whole));
  CHECK(share_different(pictured(whole, novel_camera()), pictured(repaired, novel_camera()), 12) < 0.02);
}

TEST_CASE("a bow tie, fins and a face that cuts through others are planned on and shown") {
  EdgeScene scene{court(), {}};
  TriangleSoup& soup = scene.soup;
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {{1, 1, 1}, {1.5, 1, 1}, {1, 1.5, 1}, {0.5, 1, 1.2}, {1, 0.5, 1.2}});
  soup.faces.insert(soup.faces.end(), {{first, first + 1, first + 2}, {first, first + 3, first + 4}});  // a bow tie
  soup.faces.emplace_back(0, 1, first);                                                                 // fins
  soup.faces.emplace_back(0, 1, first + 3);
  for (int view = 0; view < 4; ++view) add_view(scene, court_camera(0.25 * view + 0.1));
  const BuildResult result = built(scene, default_build());
  CHECK(count_of(result, Decision::outlier) == 0);
  const Rendering picture = pictured(result, novel_camera());
  CHECK(textured_share(picture) > 0.5);
  CHECK(textured_error(picture, photographed(scene.soup, novel_camera())) < 20);
}

TEST_CASE("vertices that are no numbers are dropped with their faces, and a mesh of nothing else is refused") {
  EdgeScene scene = six_views();
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto first = static_cast<std::uint32_t>(scene.soup.positions.size());
  scene.soup.positions.insert(scene.soup.positions.end(), {{nan, 0, 0}, {1, inf, 0}, {1e300, -1e300, 0}});
  scene.soup.faces.insert(scene.soup.faces.begin(), {{first, 0, 1}, {first + 1, 1, 2}, {first + 2, 2, 3}});
  const BuildResult whole = built(six_views(), plain_build());
  const BuildResult rest = built(scene, plain_build());
  CHECK(share_different(pictured(whole, novel_camera()), pictured(rest, novel_camera()), 2) < 0.002);
  for (glm::dvec3& point : scene.soup.positions) point = glm::dvec3(nan);
  CHECK_THAT(refused(scene, default_build()), Contains("mesh.ply"));
  EdgeScene flat = six_views();
  for (glm::dvec3& point : flat.soup.positions) point = {point.x, 0, 0};
  CHECK_THAT(refused(flat, default_build()), Contains("mesh.ply"));
  flat.soup.faces.clear();
  CHECK_THAT(refused(flat, default_build()), Contains("mesh.ply"));
}

TEST_CASE("a mesh of one face, and cells that each hold the whole scene, are modelled") {
  EdgeScene one_face{{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {}, {{0, 1, 2}}}, {}};
  const Camera above = camera_towards({1, 1, 5}, {1.2, 1.3, 0}, 80, 60, 70);
  add_view(one_face, above);
  add_view(one_face, camera_towards({2, 2, 4}, {1, 1, 0}, 80, 60, 70));
  for (const double size : {0.0, 1.0, 1e300}) {
    CAPTURE(size);
    BuildOptions options = default_build();
    options.cells.size = size;
    for (const EdgeScene* scene : {&std::as_const(one_face), &six_views()}) {
      const BuildResult result = built(*scene, options);
      const Camera& camera = scene->views[0].camera;
      CHECK_FALSE(stored_names(result).empty());
      CHECK(textured_share(pictured(result, camera)) > 0.2);
      CHECK(textured_error(pictured(result, camera), scene->views[0].photograph) < 10);
      if (size == 1e300) CHECK(result.snapshot.surface->near_cells() == 1);
    }
  }
}

TEST_CASE("more than 2^16 cells of a few faces each and two views are modelled") {
  const EdgeScene scene = court_scene(2);
  BuildOptions options = plain_build();
  options.cells.partition = Partition::grid;  // which is made sooner
  options.cells.size = 0.025;
  const BuildResult result = built(scene, options);
  CHECK(result.snapshot.surface->cells.cells.size() > 1 << 16);
  const Rendering picture = pictured(result, scene.views[0].camera);
  CHECK(textured_share(picture) > 0.6);
  CHECK(textured_error(picture, scene.views[0].photograph) < 6);
}

TEST_CASE("one cell for each face is a model") {
  BuildOptions options = plain_build();
  options.cells.size = 0.7;  // as long as the longest edge: no face is split, and none has room for a neighbour
  options.cells.normal_weight = 1e9;
  const BuildResult result = built(six_views(), options);
  CHECK(result.snapshot.surface->cells.cells.size() > 100);
  CHECK(textured_error(pictured(result, novel_camera()), photographed(court(), novel_camera())) < 14);
}

// A square pole from the floor up.
void add_pole(TriangleSoup& soup, const glm::dvec2& foot, double width) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const double z : {0.0, 3.0}) {
    for (const glm::dvec2& corner : {glm::dvec2(0), glm::dvec2(width, 0), glm::dvec2(width), glm::dvec2(0, width)}) {
      soup.positions.emplace_back(foot + corner, z);
    }
  }
  for (std::uint32_t side = 0; side < 4; ++side) {
    const std::uint32_t a = first + side, b = first + (side + 1) % 4;
    soup.faces.insert(soup.faces.end(), {{a, b, b + 4}, {a, b + 4, a + 4}});
  }
}

TEST_CASE("wires half a pixel wide and poles do not spoil the picture of what is behind them") {
  // At 80 pixels a focal length and a distance of 5, a pixel is 1/16 wide.
  for (const double width : {1.0 / 1024, 1.0 / 32, 0.125}) {
    CAPTURE(width);
    EdgeScene scene{court(), {}};
    for (int i = 0; i < 4; ++i) add_pole(scene.soup, {0.7 + 0.6 * i, 1.9 - 0.3 * i}, width);
    for (int view = 0; view < 6; ++view) add_view(scene, court_camera((view + 0.5) / 6));
    const BuildResult result = built(scene, default_build());
    CHECK(count_of(result, Decision::outlier) == 0);
    CHECK(stored_names(result).size() >= 3);
    const Rendering picture = pictured(result, novel_camera());
    CHECK(textured_share(picture) > 0.4);
    CHECK(textured_error(picture, photographed(scene.soup, novel_camera())) < 22);  // a wire is missed by most rays
  }
}

TEST_CASE("a small face far from all that is seen costs the picture nothing, however far") {
  const Rendering without = pictured(built(six_views(), plain_build()), novel_camera());
  for (const double far : {1e3, 1e7, 1e15}) {
    CAPTURE(far);
    EdgeScene scene = six_views();
    const auto first = static_cast<std::uint32_t>(scene.soup.positions.size());
    scene.soup.positions.insert(scene.soup.positions.end(), {{far, 0, 0}, {far, 0.05, 0}, {far, 0, 0.05}});
    scene.soup.faces.emplace_back(first, first + 1, first + 2);
    const BuildResult result = built(scene, plain_build());
    CHECK(result.snapshot.surface->cells.size < 1);  // its distance is not the scene's size
    CHECK(share_different(pictured(result, novel_camera()), without, 12) < 0.05);
  }
}

TEST_CASE("one stray vertex costs the picture no more than its own faces, and the build says so") {
  const BuildResult whole = built(six_views(), plain_build());
  const Rendering without = pictured(whole, novel_camera());
  CHECK(whole.warnings.empty());
  for (const double far : {1e3, 1e8, 1e10}) {
    CAPTURE(far);
    EdgeScene scene = six_views();
    scene.soup.positions[0] = {-far, -far, -far};  // away from the cameras, so that its faces hide nothing
    const BuildResult result = built(scene, plain_build());
    CHECK(result.snapshot.surface->cells.size == Approx(whole.snapshot.surface->cells.size).epsilon(0.1));
    CHECK(share_different(pictured(result, novel_camera()), without, 12) < 0.05);
    REQUIRE(result.warnings.size() == 1);
    CHECK_THAT(result.warnings[0], Contains("mesh.ply") && Contains("faces reach further than 4 times"));
  }
}

}  // namespace
}  // namespace lumatlas
