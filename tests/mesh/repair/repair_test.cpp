// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/repair.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const glm::dvec3 kNoOffset(0);

RepairedMesh repaired(const TriangleSoup& soup) {
  return repair(soup, kNoOffset);
}

TriangleSoup one_triangle() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {{0, 1, 2}}};
}

// Each vertex's colour encodes its number, so that a colour that lost its vertex shows.
void number_colors(TriangleSoup& soup) {
  soup.colors.clear();
  for (std::size_t i = 0; i < soup.positions.size(); ++i) soup.colors.emplace_back(10 * i, 0, 0);
}

// `fins` triangles on the edge from (0,0,0) to (0,0,1).
TriangleSoup fins_on_one_edge(std::uint32_t fins) {
  TriangleSoup soup{{{0, 0, 0}, {0, 0, 1}}, {}, {}};
  for (std::uint32_t fin = 0; fin < fins; ++fin) {
    soup.positions.emplace_back(std::cos(fin), std::sin(fin), 0.5);
    soup.faces.emplace_back(0, 1, 2 + fin);
  }
  number_colors(soup);
  return soup;
}

TriangleSoup moebius_strip(std::uint32_t segments) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double angle = 2 * 3.14159265358979 * i / segments;
    const glm::dvec3 out(std::cos(angle), std::sin(angle), 0);
    const glm::dvec3 across = std::cos(angle / 2) * out + glm::dvec3(0, 0, std::sin(angle / 2));
    soup.positions.push_back(out - 0.3 * across);
    soup.positions.push_back(out + 0.3 * across);
  }
  for (std::uint32_t i = 0; i < segments; ++i) {
    const bool is_last = i + 1 == segments;
    const std::uint32_t low = is_last ? 1 : 2 * i + 2;  // the last joins the first upside down
    const std::uint32_t high = is_last ? 0 : 2 * i + 3;
    soup.faces.insert(soup.faces.end(), {{2 * i, low, 2 * i + 1}, {low, high, 2 * i + 1}});
  }
  return soup;
}

// Turns round the first face, whose orientation CGAL alone would keep, and about this share of the others.
std::size_t flip_some(TriangleSoup& soup, double share, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution flips(share);
  std::size_t flipped = 0;
  for (glm::uvec3& face : soup.faces) {
    if (!flips(random) && flipped > 0) continue;
    std::swap(face.x, face.y);
    ++flipped;
  }
  return flipped;
}

// Few positions, many faces: every defect at once.
TriangleSoup random_soup(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> coordinate(0, 2);
  std::uniform_int_distribution<std::uint32_t> vertex(0, 39);
  TriangleSoup soup;
  for (int i = 0; i < 40; ++i) soup.positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  soup.positions[seed % 40].y = kNan;
  for (unsigned i = 0; i < 5 + seed % 60; ++i) soup.faces.emplace_back(vertex(random), vertex(random), vertex(random));
  number_colors(soup);
  return soup;
}

TEST_CASE("a clean mesh passes through repair unchanged, in order and with its colours") {
  const Mesh clean = plane(7, 1);
  const auto [mesh, report] = repaired(to_soup(clean));
  CHECK(report == RepairReport{});
  CHECK(report == RepairReport{});
  CHECK(mesh.positions == clean.positions);
  CHECK(mesh.colors == clean.colors);
  CHECK(mesh.faces == clean.faces);
}

TEST_CASE("one triangle is a mesh") {
  const auto [mesh, report] = repaired(one_triangle());
  CHECK(report == RepairReport{});
  CHECK(mesh.faces == std::vector<glm::uvec3>{{0, 1, 2}});
  CHECK(mesh.colors.empty());
}

TEST_CASE("the offset is subtracted before positions become floats") {
  TriangleSoup soup = one_triangle();
  const glm::dvec3 offset(5e6, -4e6, 3e6);
  for (glm::dvec3& p : soup.positions) p = p * 0.001 + offset;
  const Mesh mesh = repair(soup, offset).mesh;
  CHECK(glm::distance(mesh.positions[1], glm::vec3(0.001f, 0, 0)) < 1e-8f);
  CHECK(glm::distance(mesh.positions[2], glm::vec3(0, 0.001f, 0)) < 1e-8f);
}

TEST_CASE("vertices that are not finite are dropped with their faces") {
  TriangleSoup soup = to_soup(plane(2, 1));
  soup.positions[0].x = kNan;                                                 // a corner with two faces
  soup.positions.push_back({0, std::numeric_limits<double>::infinity(), 0});  // used by none
  soup.positions.push_back({0, 0, 1e300});                                    // infinite as a float
  soup.colors.resize(soup.positions.size());
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.non_finite_vertices = 3;
  expected.non_finite_faces = 2;
  CHECK(report == expected);
  CHECK(mesh.faces.size() == 6);
  CHECK(mesh.positions.size() == 8);
  CHECK(is_manifold_and_oriented(mesh));
}

TEST_CASE("vertices at one position are merged and take the colour of the first") {
  TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0, 1, 0}}, {}, {{0, 1, 2}, {3, 4, 5}}};
  number_colors(soup);
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.merged_vertices = 2;
  CHECK(report == expected);
  CHECK(report != RepairReport{});
  CHECK(mesh.positions == std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  CHECK(mesh.colors == std::vector<glm::u8vec3>{{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {40, 0, 0}});
  CHECK(mesh.faces == std::vector<glm::uvec3>{{0, 1, 2}, {1, 3, 2}});
}

TEST_CASE("vertices that differ only beyond a float's precision are merged") {
  TriangleSoup soup = one_triangle();
  soup.positions.push_back({1 + 1e-12, 0, 0});
  soup.positions.push_back({1, 1, 0});
  soup.faces.emplace_back(3, 4, 2);
  const auto [mesh, report] = repaired(soup);
  CHECK(report.merged_vertices == 1);
  CHECK(mesh.positions.size() == 4);
}

TEST_CASE("isolated vertices are dropped and the others keep their colours") {
  TriangleSoup soup{{{9, 9, 9}, {0, 0, 0}, {8, 8, 8}, {1, 0, 0}, {0, 1, 0}}, {}, {{1, 3, 4}}};
  number_colors(soup);
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.isolated_vertices = 2;
  CHECK(report == expected);
  REQUIRE(mesh.positions.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t source = mesh.colors[i].r / 10;
    CHECK(glm::dvec3(mesh.positions[i]) == soup.positions[source]);
  }
}

TEST_CASE("faces with equal corners or in one line are dropped") {
  TriangleSoup soup = one_triangle();
  soup.positions.push_back({2, 0, 0});
  soup.positions.push_back({1, 0, 0});
  soup.faces.insert(soup.faces.end(), {{0, 0, 1}, {0, 1, 3}, {2, 1, 4}, {1, 1, 1}});
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.merged_vertices = 1;
  expected.degenerate_faces = 4;
  expected.isolated_vertices = 1;
  CHECK(report == expected);
  CHECK(mesh.faces.size() == 1);
}

TEST_CASE("a needle with some area is no degenerate face") {
  const float least = std::nextafter(1.0f, 2.0f) - 1;
  const TriangleSoup soup{{{0, 0, 0}, {1, 1, 0}, {0.5, 0.5 + least, 0}}, {}, {{0, 1, 2}}};
  CHECK(repaired(soup).report == RepairReport{});
}

TEST_CASE("faces with the same three vertices are merged whatever their order") {
  TriangleSoup soup = to_soup(plane(3, 1));
  const glm::uvec3 first = soup.faces[0];
  const glm::uvec3 second = soup.faces[5];
  soup.faces.insert(soup.faces.end(), {{first.y, first.z, first.x}, {first.x, first.z, first.y}, second});
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.duplicate_faces = 3;
  CHECK(report == expected);
  CHECK(mesh.faces.size() == 18);
  CHECK(area_of(mesh) == Approx(1));
  CHECK(is_manifold_and_oriented(mesh));
}

TEST_CASE("a triangle and its back are one face") {
  TriangleSoup soup = one_triangle();
  soup.faces.emplace_back(0, 2, 1);
  const auto [mesh, report] = repaired(soup);
  CHECK(report.duplicate_faces == 1);
  CHECK(mesh.faces == std::vector<glm::uvec3>{{0, 1, 2}});
}

TEST_CASE("an edge with three faces is split and the copies keep the colours of its ends") {
  const auto [mesh, report] = repaired(fins_on_one_edge(3));
  RepairReport expected;
  expected.non_manifold_edges = 1;
  expected.non_manifold_vertices = 2;
  CHECK(report == expected);
  CHECK(mesh.faces.size() == 3);
  REQUIRE(mesh.positions.size() == 9);
  CHECK(is_manifold_and_oriented(mesh));
  for (const glm::uvec3& face : mesh.faces) {
    CHECK(mesh.colors[face.x].r == 0);
    CHECK(mesh.colors[face.y].r == 10);
    CHECK(mesh.colors[face.z].r >= 20);
  }
}

TEST_CASE("each non-manifold edge is counted once however many faces it has") {
  CHECK(repaired(fins_on_one_edge(7)).report.non_manifold_edges == 1);
  TriangleSoup two = fins_on_one_edge(4);
  const TriangleSoup other = fins_on_one_edge(5);
  for (const glm::dvec3& p : other.positions) two.positions.push_back(p + glm::dvec3(10, 0, 0));
  for (const glm::uvec3& face : other.faces) two.faces.push_back(face + 6u);
  two.colors.clear();
  CHECK(repaired(two).report.non_manifold_edges == 2);
  CHECK(repaired(two).report.non_manifold_vertices == 4);
}

TEST_CASE("a bow-tie vertex is split") {
  TriangleSoup soup{{{0, 0, 0}, {1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}}, {}, {{0, 2, 1}, {0, 3, 4}}};
  number_colors(soup);
  const auto [mesh, report] = repaired(soup);
  RepairReport expected;
  expected.non_manifold_vertices = 1;
  CHECK(report == expected);
  CHECK(mesh.positions.size() == 6);
  CHECK(mesh.colors.back() == soup.colors[0]);
  CHECK(is_manifold_and_oriented(mesh));
}

TEST_CASE("a closed sphere with some faces turned comes back facing outwards") {
  for (const double share : {0.001, 0.1, 0.4}) {
    TriangleSoup soup = to_soup(sphere(4));
    const std::size_t flipped = flip_some(soup, share, 7);
    const auto [mesh, report] = repaired(soup);
    RepairReport expected;
    expected.reversed_faces = flipped;
    CHECK(report == expected);
    CHECK(is_manifold_and_oriented(mesh));
    CHECK(volume_of(mesh) == Approx(volume_of(sphere(4))));
  }
}

TEST_CASE("each component keeps the orientation that most of its faces had") {
  const Mesh outwards = sphere(3);
  const Mesh inwards = moved(turned_inside_out(sphere(2)), {5, 0, 0});
  TriangleSoup soup = to_soup(joined(outwards, inwards));
  const std::size_t flipped = flip_some(soup, 0.3, 3);
  const auto [mesh, report] = repaired(soup);
  CHECK(report.reversed_faces == flipped);
  CHECK(volume_of(mesh) == Approx(volume_of(outwards) + volume_of(inwards)));
  CHECK(is_manifold_and_oriented(mesh));
}

TEST_CASE("a one-sided strip is cut where it cannot be oriented") {
  const auto [mesh, report] = repaired(moebius_strip(12));
  CHECK(report.non_manifold_edges == 0);
  CHECK(report.non_manifold_vertices == 2);
  CHECK(mesh.faces.size() == 24);
  CHECK(mesh.positions.size() == 26);
  CHECK(is_manifold_and_oriented(mesh));
}

TEST_CASE("any soup becomes a manifold mesh, and repairing that again changes nothing") {
  int usable = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const TriangleSoup soup = random_soup(seed);
    RepairedMesh once;
    try {
      once = repaired(soup);
    } catch (const InputError&) {
      continue;
    }
    ++usable;
    const RepairReport& report = once.report;
    INFO("seed " << seed);
    CHECK(is_manifold_and_oriented(once.mesh));
    CHECK(once.mesh.colors.size() == once.mesh.positions.size());
    CHECK(once.mesh.faces.size() + report.non_finite_faces + report.degenerate_faces + report.duplicate_faces ==
          soup.faces.size());
    // Copies of split vertices would be merged again; apart from them nothing is left to do.
    const RepairReport again = repaired(to_soup(once.mesh)).report;
    CHECK(again.non_finite_vertices + again.degenerate_faces + again.duplicate_faces + again.isolated_vertices == 0);
    if (report.non_manifold_vertices == 0) CHECK(again == RepairReport{});
  }
  CHECK(usable > 200);
}

TEST_CASE("repair gives the same mesh with one thread and with four") {
  TriangleSoup soup = to_soup(joined(sphere(5), moved(sphere(4), {0, 0, 3})));
  flip_some(soup, 0.2, 1);
  soup.faces.push_back({soup.faces[9].x, soup.faces[9].y, 500});
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return repaired(soup);
  };
  const RepairedMesh one = with_threads(1);
  const RepairedMesh four = with_threads(4);
  CHECK(one.report == four.report);
  CHECK(one.mesh.positions == four.mesh.positions);
  CHECK(one.mesh.faces == four.mesh.faces);
}

TEST_CASE("a soup without a usable face is refused in one sentence") {
  CHECK_THROWS_MATCHES(repaired({}), InputError, Catch::Message("the mesh has no faces"));
  TriangleSoup soup = one_triangle();
  soup.faces = {{0, 0, 1}, {0, 1, 1}, {0, 1, 2}};
  soup.positions[2].z = kNan;
  CHECK_THROWS_MATCHES(repaired(soup), InputError,
                       Catch::Message("the mesh has no usable face: of its 3 faces, 2 are degenerate and 1 have a "
                                      "corner that is not finite"));
}

TEST_CASE("a soup that breaks its own rules is refused by name") {
  TriangleSoup soup = one_triangle();
  soup.faces.push_back({0, 1, 3});
  CHECK_THROWS_MATCHES(repaired(soup), std::invalid_argument,
                       Catch::Message("soup: face 1 refers to position 3, must be below 3"));
  soup = one_triangle();
  soup.colors.resize(2);
  CHECK_THROWS_MATCHES(repaired(soup), std::invalid_argument,
                       Catch::Message("soup: has 2 colors, must be none or one for each of its 3 positions"));
  CHECK_THROWS_MATCHES(repair(one_triangle(), {0, kNan, 0}), std::invalid_argument,
                       Catch::Message("offset: coordinate 1 is nan, must be finite"));
}

TEST_CASE("repair ends at whichever cancel_check throws") {
  TriangleSoup soup = one_triangle();
  soup.faces.push_back(soup.faces.front());
  int checks = 0;
  CHECK(repair(soup, kNoOffset, [&] { ++checks; }).report.duplicate_faces == 1);
  CHECK(checks == 6);
  for (int last = 1; last <= checks; ++last) {
    int calls = 0;
    const CancelCheck cancel_check = [&] {
      if (++calls == last) throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(repair(soup, kNoOffset, cancel_check), "enough");
    CHECK(calls == last);
  }
}

}  // namespace
}  // namespace lumatlas
