// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/cells.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "mesh/cells/split_faces.h"
#include "mesh/repair/repair.h"
#include "mesh/scene_extent.h"
#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

CellOptions clusters_of(double size) {
  return {Partition::clusters, size, 2};
}
CellOptions grid_of(double size) {
  return {Partition::grid, size, 2};
}

glm::dvec3 normal_of(const Mesh& mesh, std::size_t face) {
  const glm::uvec3& f = mesh.faces[face];
  const glm::dvec3 a(mesh.positions[f.x]);
  return glm::normalize(glm::cross(glm::dvec3(mesh.positions[f.y]) - a, glm::dvec3(mesh.positions[f.z]) - a));
}

glm::dvec3 centroid_of(const Mesh& mesh, std::size_t face) {
  const glm::uvec3& f = mesh.faces[face];
  return (glm::dvec3(mesh.positions[f.x]) + glm::dvec3(mesh.positions[f.y]) + glm::dvec3(mesh.positions[f.z])) / 3.0;
}

// Checks the laws of any mesh with either partition.
void check_sound(const Mesh& mesh, const Cells& cells) {
  REQUIRE(cells.cell_of_face.size() == mesh.faces.size());
  std::vector<std::uint32_t> faces(cells.cells.size(), 0);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    REQUIRE(cells.cell_of_face[i] < cells.cells.size());
    const Cell& cell = cells.cells[cells.cell_of_face[i]];
    ++faces[cells.cell_of_face[i]];
    const double cosine = cell.normal == glm::dvec3(0) ? -1 : glm::dot(normal_of(mesh, i), cell.normal);
    if (cosine < cell.normal_cone_cos - 1e-12) ++outside;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(mesh.positions[mesh.faces[i][corner]]);
      if (glm::distance(position, cell.centroid) > cell.radius + 1e-12) ++outside;
    }
  }
  CHECK(outside == 0);
  double area = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Cell& cell = cells.cells[i];
    CHECK(cell.faces >= 1);
    CHECK(cell.faces == faces[i]);
    const double length = glm::length(cell.normal);
    CHECK((length == 0 || length == Approx(1)));
    CHECK((length > 0 || cell.normal_cone_cos == -1));
    area += cell.area;
  }
  CHECK(area == Approx(area_of(mesh)));
}

// The faces in as few sets as shared edges within one cell allow: as many as cells if each cell is connected.
std::size_t connected_parts(const Mesh& mesh, const Cells& cells) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> face_at_edge;
  std::vector<std::uint32_t> part(mesh.faces.size());
  std::iota(part.begin(), part.end(), 0u);
  const auto root = [&](std::uint32_t face) {
    while (part[face] != face) face = part[face];
    return face;
  };
  std::size_t parts = mesh.faces.size();
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto edge = std::minmax(mesh.faces[face][corner], mesh.faces[face][(corner + 1) % 3]);
      const auto [at, is_first] = face_at_edge.try_emplace(edge, face);
      if (is_first || cells.cell_of_face[at->second] != cells.cell_of_face[face]) continue;
      const std::uint32_t a = root(at->second);
      const std::uint32_t b = root(face);
      if (a != b) --parts;
      part[std::max(a, b)] = std::min(a, b);
    }
  }
  return parts;
}

void check_clusters(const Mesh& mesh, const Cells& cells) {
  check_sound(mesh, cells);
  CHECK(connected_parts(mesh, cells) == cells.cells.size());
}

double median_area(const Cells& cells) {
  std::vector<double> areas;
  for (const Cell& cell : cells.cells) areas.push_back(cell.area);
  std::nth_element(areas.begin(), areas.begin() + areas.size() / 2, areas.end());
  return areas[areas.size() / 2];
}

double largest_radius(const Cells& cells) {
  return std::max_element(cells.cells.begin(), cells.cells.end(),
                          [](const Cell& a, const Cell& b) { return a.radius < b.radius; })
      ->radius;
}

bool same_cells(const Cells& a, const Cells& b) {
  const auto same_cell = [](const Cell& x, const Cell& y) {
    return x.centroid == y.centroid && x.normal == y.normal && x.normal_cone_cos == y.normal_cone_cos &&
           x.area == y.area && x.radius == y.radius && x.faces == y.faces;
  };
  return a.size == b.size && a.cell_of_face == b.cell_of_face &&
         std::equal(a.cells.begin(), a.cells.end(), b.cells.begin(), b.cells.end(), same_cell);
}

// Returns a plane as a depth camera measures it.
Mesh rough_plane(std::uint32_t quads, float side, float noise) {
  Mesh mesh = plane(quads, side);
  std::mt19937 random(5);
  std::normal_distribution<float> height(0, noise);
  for (glm::vec3& p : mesh.positions) p.z = height(random);
  return mesh;
}

TEST_CASE("faces without area add nothing to their cell") {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 1, 3}, {2, 2, 1}};
  const Cells cells = measure_cells(mesh, {0, 0, 0}, 1);
  REQUIRE(cells.cells.size() == 1);
  CHECK(cells.cells[0].area == Approx(0.5));
}

TEST_CASE("clusters of a plane are compact and have about the target area") {
  for (const double size : {0.05, 0.1, 0.2}) {
    const Mesh mesh = plane(150, 1);
    const Cells cells = make_cells(mesh, clusters_of(size));
    check_clusters(mesh, cells);
    CHECK(cells.size == size);
    CHECK(median_area(cells) == Approx(size * size).epsilon(0.3));
    CHECK(largest_radius(cells) < 1.5 * size);
    for (const Cell& cell : cells.cells) {
      CHECK(glm::distance(cell.normal, glm::dvec3(0, 0, 1)) < 1e-6);
      CHECK(cell.normal_cone_cos == Approx(1));
      CHECK(cell.area > 0.3 * size * size);
    }
  }
}

TEST_CASE("clusters of a sphere are compact and have about the target area, of many faces or of few") {
  const Mesh mesh = sphere(6);
  for (const double size : {0.05, 0.15, 0.3}) {
    const Cells cells = make_cells(mesh, clusters_of(size));
    check_clusters(mesh, cells);
    CHECK(median_area(cells) == Approx(size * size).epsilon(0.3));
    CHECK(largest_radius(cells) < 1.5 * size);
    for (const Cell& cell : cells.cells) {
      CHECK(glm::distance(cell.normal, glm::normalize(cell.centroid)) < 0.05);
      CHECK(cell.normal_cone_cos > std::cos(1.5 * size));
    }
  }
}

TEST_CASE("noise in the normals does not break clusters up") {
  const double size = 0.1;
  const Mesh mesh = rough_plane(150, 1, 0.002f);  // faces tilted by some 25 degrees
  const Cells cells = make_cells(mesh, clusters_of(size));
  check_clusters(mesh, cells);
  CHECK(static_cast<double>(cells.cells.size()) < 1.4 * area_of(mesh) / (size * size));
  CHECK(largest_radius(cells) < 1.5 * size);
}

TEST_CASE("clusters do not reach round an edge") {
  const Mesh mesh = box(40, {1, 1, 1});
  const Cells cells = make_cells(mesh, clusters_of(0.1));
  check_clusters(mesh, cells);
  for (const Cell& cell : cells.cells) CHECK(cell.normal_cone_cos > 0.7);
}

TEST_CASE("a stronger normal weight makes clusters flatter and a weight of zero ignores normals") {
  const Mesh mesh = sphere(6);
  const auto mean_cone = [&](double normal_weight) {
    const Cells cells = make_cells(mesh, {Partition::clusters, 0.5, normal_weight});
    double sum = 0;
    for (const Cell& cell : cells.cells) sum += cell.normal_cone_cos * cell.area;
    return sum / area_of(mesh);
  };
  CHECK(mean_cone(0) < mean_cone(2));
  CHECK(mean_cone(2) < mean_cone(8));
}

TEST_CASE("a thin wall's two sides lie in different clusters but in one grid cell") {
  const Mesh wall = moved(box(60, {1, 0.01f, 1}), {0, 0.02f, 0});
  const Cells clusters = make_cells(wall, clusters_of(0.1));
  const Cells grid = make_cells(wall, grid_of(0.1));
  check_clusters(wall, clusters);
  check_sound(wall, grid);
  const auto cells_facing = [&](const Cells& cells, double y) {
    std::set<std::uint32_t> facing;
    for (std::size_t i = 0; i < wall.faces.size(); ++i) {
      if (normal_of(wall, i).y * y > 0.5) facing.insert(cells.cell_of_face[i]);
    }
    return facing;
  };
  const auto shared = [&](const Cells& cells) {
    const auto front = cells_facing(cells, 1);
    const auto back = cells_facing(cells, -1);
    return std::count_if(front.begin(), front.end(), [&](std::uint32_t cell) { return back.contains(cell); });
  };
  CHECK(shared(clusters) == 0);
  CHECK(shared(grid) == 100);
}

TEST_CASE("a grid cell holds the faces whose centroids are in one cube") {
  const Mesh mesh = moved(sphere(4), {0.3f, -2, 5});
  const double size = 0.37;
  const Cells cells = make_cells(mesh, grid_of(size));
  check_sound(mesh, cells);
  std::map<std::tuple<double, double, double>, std::set<std::uint32_t>> cells_of_cube;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const glm::dvec3 cube = glm::floor(centroid_of(mesh, i) / size);
    cells_of_cube[{cube.x, cube.y, cube.z}].insert(cells.cell_of_face[i]);
  }
  CHECK(cells_of_cube.size() == cells.cells.size());
  for (const auto& [cube, ids] : cells_of_cube) CHECK(ids.size() == 1);
}

TEST_CASE("a wall of two triangles is split and gets a cell for about each size squared") {
  for (const double size : {1.0, 0.5}) {
    const Mesh wall = split_large_faces(plane(1, 10), size);
    const Cells cells = make_cells(wall, clusters_of(size));
    check_clusters(wall, cells);
    CHECK(static_cast<double>(cells.cells.size()) == Approx(100 / (size * size)).epsilon(0.15));
    CHECK(largest_radius(cells) < 1.5 * size);
  }
}

TEST_CASE("one face is one cell that says what the face is") {
  const Mesh mesh{{{0, 0, 1}, {3, 0, 1}, {0, 3, 1}}, {}, {{0, 1, 2}}};
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const Cells cells = make_cells(mesh, {partition, 1, 2});
    check_sound(mesh, cells);
    REQUIRE(cells.cells.size() == 1);
    const Cell& cell = cells.cells[0];
    CHECK(cell.area == Approx(4.5));
    CHECK(glm::distance(cell.centroid, glm::dvec3(1, 1, 1)) < 1e-12);
    CHECK(cell.normal == glm::dvec3(0, 0, 1));
    CHECK(cell.normal_cone_cos == 1);
    CHECK(cell.radius == Approx(std::sqrt(5)));
    CHECK(cell.faces == 1);
  }
}

TEST_CASE("components never share a cluster, however small and close") {
  Mesh mesh;
  for (int i = 0; i < 50; ++i) mesh = joined(mesh, moved(sphere(1), {0, 0, static_cast<float>(i) * 0.001f}));
  const Cells cells = make_cells(mesh, clusters_of(100));
  check_clusters(mesh, cells);
  CHECK(cells.cells.size() >= 50);
}

TEST_CASE("cells much smaller than the target are left only where nothing fits them") {
  const Mesh mesh = joined(plane(100, 1), moved(plane(2, 0.02f), {0, 0, 5}));
  const Cells cells = make_cells(mesh, clusters_of(0.1));
  check_clusters(mesh, cells);
  const auto small = std::count_if(cells.cells.begin(), cells.cells.end(),
                                   [](const Cell& cell) { return cell.area < 0.2 * 0.1 * 0.1; });
  CHECK(small == 1);  // the far patch
}

TEST_CASE("where normals cancel the normal is zero and the cone is everything") {
  const Mesh sheet = plane(1, 1);
  const Mesh mesh = joined(sheet, turned_inside_out(sheet));
  const Cells cells = make_cells(mesh, grid_of(10));
  REQUIRE(cells.cells.size() == 1);
  CHECK(cells.cells[0].normal == glm::dvec3(0));
  CHECK(cells.cells[0].normal_cone_cos == -1);
}

TEST_CASE("cells are numbered by their first face") {
  const Mesh mesh = sphere(4);
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    std::uint32_t next = 0;
    for (const CellId cell : make_cells(mesh, {partition, 0.4, 2}).cell_of_face) {
      REQUIRE(cell <= next);
      if (cell == next) ++next;
    }
  }
}

TEST_CASE("cells are the same with one thread and with four") {
  const Mesh mesh = joined(sphere(6), rough_plane(80, 2, 0.01f));
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const auto with_threads = [&](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      return make_cells(mesh, {partition, 0, 2});
    };
    CHECK(same_cells(with_threads(1), with_threads(4)));
  }
}

TEST_CASE("cells grow with the scene") {
  const Mesh mesh = sphere(5);
  Mesh large = mesh;
  for (glm::vec3& p : large.positions) p *= 1024.0f;  // exact in floats
  const Cells cells = make_cells(mesh, {});
  const Cells large_cells = make_cells(large, {});
  CHECK(large_cells.size == Approx(1024 * cells.size));
  CHECK(static_cast<double>(large_cells.cells.size()) == Approx(cells.cells.size()).epsilon(0.02));
}

TEST_CASE("the automatic cell size is a sixtieth of the scene's diameter") {
  const Mesh mesh = sphere(4);
  CHECK(automatic_cell_size(mesh) == Approx(scene_diameter(mesh) / 60));
  CHECK(make_cells(mesh, {}).size == automatic_cell_size(mesh));
}

TEST_CASE("cells far smaller than the faces are single faces and far larger ones are whole components") {
  const Mesh mesh = joined(plane(5, 1), moved(plane(3, 1), {0, 0, 2}));
  CHECK(make_cells(mesh, clusters_of(1e-4)).cells.size() == mesh.faces.size());
  CHECK(make_cells(mesh, clusters_of(1e6)).cells.size() == 2);
  CHECK_FALSE(make_cells(mesh, grid_of(1e-300)).cells.empty());
}

TEST_CASE("a mesh without faces has no cells") {
  CHECK(make_cells({}, {}).cells.empty());
  CHECK(make_cells({}, grid_of(1)).cell_of_face.empty());
}

TEST_CASE("bad cell options are refused by name") {
  CHECK_NOTHROW(check(CellOptions{}));
  const Mesh mesh = plane(1, 1);
  CHECK_THROWS_MATCHES(make_cells(mesh, clusters_of(-1)), std::invalid_argument,
                       Catch::Message("cells: size is -1, must be finite and not negative"));
  CHECK_THROWS_MATCHES(make_cells(mesh, {Partition::clusters, 1, -0.5}), std::invalid_argument,
                       Catch::Message("cells: normal_weight is -0.5, must be finite and not negative"));
  CHECK_THROWS_AS(check(clusters_of(std::numeric_limits<double>::infinity())), std::invalid_argument);
  const Mesh flat{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}, {{0, 1, 2}}};
  CHECK_THROWS_MATCHES(make_cells(flat, {}), std::invalid_argument,
                       Catch::Message("mesh: its faces have no area, must have some for an automatic cell size"));
}

TEST_CASE("the diameter of a square is that of its central 98%, however coarse it is") {
  const double expected = 0.98 * std::sqrt(2);
  CHECK(scene_diameter(plane(1, 1)) == Approx(expected));
  CHECK(scene_diameter(plane(50, 1)) == Approx(expected));
  CHECK(scene_diameter(moved(plane(10, 1), {1000, -50, 3})) == Approx(expected).epsilon(1e-3));
}

TEST_CASE("the diameter of a sphere follows from its bands' areas") {
  // The area between two parallel planes is proportional to their distance (Archimedes).
  CHECK(scene_diameter(sphere(6)) == Approx(2 * 0.98 * std::sqrt(3)).epsilon(0.005));
}

TEST_CASE("stray triangles do not change the diameter") {
  const Mesh scene = sphere(5);
  Mesh strayed = scene;
  for (const float away : {50.0f, -3000.0f, 1e6f}) {
    strayed = joined(strayed, moved(plane(1, 0.1f), {away, away, -away}));
  }
  CHECK(scene_diameter(strayed) == Approx(scene_diameter(scene)).epsilon(0.02));
}

TEST_CASE("a stray vertex does not change the diameter, however far and whichever one") {
  const Mesh scene = rough_plane(100, 2, 0.01f);
  for (const float away : {100.0f, 1e4f, 1e8f, 1e10f}) {
    for (const std::size_t vertex : {std::size_t{0}, std::size_t{5000}}) {
      Mesh strayed = scene;
      strayed.positions[vertex] = {away, -away, away / 2};
      CHECK(scene_diameter(strayed) == Approx(scene_diameter(scene)).epsilon(0.05));
      CHECK(make_cells(strayed, {}).size == Approx(make_cells(scene, {}).size).epsilon(0.05));
    }
  }
}

TEST_CASE("stray vertices that are neighbours do not change the diameter") {
  const Mesh scene = rough_plane(100, 2, 0.01f);
  const glm::uvec3 face = scene.faces[9100];  // not at the plane's border
  for (const float away : {100.0f, 1e4f, 1e8f, 1e10f}) {
    Mesh strayed = scene;
    strayed.positions[face.x] = {away, -away, away / 2};
    strayed.positions[face.y] = {-away, away / 3, away};
    CHECK(scene_diameter(strayed) == Approx(scene_diameter(scene)).epsilon(0.05));
    strayed.positions[face.z] = {away, away, -away};
    CHECK(scene_diameter(strayed) == Approx(scene_diameter(scene)).epsilon(0.05));
  }
}

TEST_CASE("a scene of long thin faces alone has the extent of its area") {
  Mesh slats;
  for (int i = 0; i < 20; ++i) {
    slats = joined(slats, {{{0, 0, 0.1f * static_cast<float>(i)}, {50, 0, 0}, {0, 0.02f, 0}}, {}, {{0, 1, 2}}});
  }
  CHECK(scene_diameter(slats) > 25);
}

TEST_CASE("cells end at edges that are not manifold") {
  Mesh mesh = plane(1, 1);
  mesh.colors.clear();
  mesh.positions.emplace_back(0.5f, 0.5f, 1.0f);
  mesh.faces.emplace_back(mesh.faces[0].x, mesh.faces[0].z, 4);  // a third face at the diagonal
  const Cells cells = make_cells(mesh, {Partition::clusters, 100, 0});
  CHECK(cells.cells.size() == 3);
}

TEST_CASE("a single triangle has a diameter and an empty mesh has none") {
  CHECK(scene_diameter({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {{0, 1, 2}}}) > 0.5);
  CHECK(scene_diameter({}) == 0);
}

TEST_CASE("clustering ends where its cancel check throws, in each of its stages") {
  const Mesh mesh = rough_plane(400, 2, 0.001f);  // 320,000 faces
  CellOptions options;
  options.size = 0.02;
  int checks = 0;
  const Cells cells = make_cells(mesh, options, [&] { ++checks; });
  // Five for each passage over all faces: one that seeds, four that grow; and those between the stages.
  CHECK(checks > 20);
  CHECK(make_cells(mesh, options).cell_of_face == cells.cell_of_face);
  for (int last = 1; last <= checks; last += 3) {
    int calls = 0;
    const CancelCheck cancel_check = [&] {
      if (++calls == last) throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(make_cells(mesh, options, cancel_check), "enough");
    CHECK(calls == last);
  }
}

}  // namespace
}  // namespace lumatlas
