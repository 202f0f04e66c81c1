// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/cell_growth.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

using Faces = std::vector<FaceId>;

// The first `count` faces, in order.
Faces first_faces(std::size_t count) {
  Faces faces;
  for (std::uint32_t face = 0; face < count; ++face) faces.emplace_back(face);
  return faces;
}

constexpr double kSize = 0.2;

CellOptions options_of(Partition partition) {
  return {partition, kSize, 2};
}

bool same(const Cell& x, const Cell& y) {
  return x.centroid == y.centroid && x.normal == y.normal && x.normal_cone_cos == y.normal_cone_cos &&
         x.area == y.area && x.radius == y.radius && x.faces == y.faces;
}

bool same(const Cells& a, const Cells& b) {
  return a.size == b.size && a.cell_of_face == b.cell_of_face &&
         std::equal(a.cells.begin(), a.cells.end(), b.cells.begin(), b.cells.end(),
                    [](const Cell& x, const Cell& y) { return same(x, y); });
}

// To rounding, which the order of a cell's faces decides.
bool nearly_same(const Cell& x, const Cell& y) {
  return glm::distance(x.centroid, y.centroid) < 1e-12 && glm::distance(x.normal, y.normal) < 1e-12 &&
         std::abs(x.normal_cone_cos - y.normal_cone_cos) < 1e-12 && std::abs(x.area - y.area) < 1e-12 &&
         std::abs(x.radius - y.radius) < 1e-12 && x.faces == y.faces;
}

// A bumpy floor, a sphere above it and a box beside: smooth parts, edges and several components.
Mesh scene(unsigned seed) {
  Mesh floor = plane(30, 2);
  floor.colors.clear();
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> height(-0.01f, 0.01f);
  for (glm::vec3& p : floor.positions) p.z = height(random);
  return joined(joined(floor, moved(sphere(4), {1, 1, 2})), moved(box(8, {0.7f, 0.5f, 0.6f}), {3, 0, 0}));
}

// A mesh, and which face each one was.
struct Change {
  Mesh mesh;
  Faces previous_face;
};

glm::vec3 middle_of(const Mesh& mesh, const glm::uvec3& face) {
  return (mesh.positions[face.x] + mesh.positions[face.y] + mesh.positions[face.z]) / 3.0f;
}

// Without the faces whose middles are in a ball; all vertices stay in the list.
Change without_ball(const Mesh& mesh, const glm::vec3& center, float radius) {
  Change change{{mesh.positions, mesh.colors, {}}, {}};
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    if (glm::distance(middle_of(mesh, mesh.faces[face]), center) < radius) continue;
    change.mesh.faces.push_back(mesh.faces[face]);
    change.previous_face.emplace_back(face);
  }
  return change;
}

// The same surface with its faces and vertices in another order and each face's corners turned.
Change shuffled(const Mesh& mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> place(mesh.positions.size());
  std::iota(place.begin(), place.end(), 0u);
  std::shuffle(place.begin(), place.end(), random);
  Change change;
  change.mesh.positions.resize(mesh.positions.size());
  for (std::size_t i = 0; i < place.size(); ++i) change.mesh.positions[place[i]] = mesh.positions[i];
  change.previous_face = first_faces(mesh.faces.size());
  std::shuffle(change.previous_face.begin(), change.previous_face.end(), random);
  for (const std::uint32_t previous : change.previous_face) {
    const glm::uvec3& face = mesh.faces[previous];
    const auto turn = static_cast<glm::uint>(random() % 3);
    change.mesh.faces.emplace_back(place[face[turn]], place[face[(turn + 1) % 3]], place[face[(turn + 2) % 3]]);
  }
  return change;
}

CellGrowth grow(const Mesh& before, const Cells& cells, const Change& change, Partition partition) {
  return grow_cells(before, cells, change.mesh, change.previous_face, options_of(partition));
}

std::map<std::uint32_t, std::set<std::uint32_t>> faces_by_cell(const Cells& cells) {
  std::map<std::uint32_t, std::set<std::uint32_t>> faces;
  for (std::uint32_t face = 0; face < cells.cell_of_face.size(); ++face) faces[cells.cell_of_face[face]].insert(face);
  return faces;
}

bool is_at_place(const Mesh& a, std::uint32_t face_a, const Mesh& b, std::uint32_t face_b) {
  const auto corner = [](const Mesh& mesh, std::uint32_t face, glm::uint i) {
    return mesh.positions[mesh.faces[face][i % 3]];
  };
  for (glm::uint turn = 0; turn < 3; ++turn) {
    bool equal = true;
    for (glm::uint i = 0; i < 3; ++i) equal &= corner(a, face_a, i) == corner(b, face_b, i + turn);
    if (equal) return true;
  }
  return false;
}

// Checks the header's statements about every growth the slow way.
void check_growth(const Mesh& mesh_before, const Cells& before, const Change& change, const CellGrowth& growth) {
  const Cells& cells = growth.cells;
  REQUIRE(cells.size == before.size);
  REQUIRE(growth.previous_cell.size() == cells.cells.size());
  REQUIRE(growth.changed.size() == cells.cells.size());
  const Cells measured = measure_cells(change.mesh, cells.cell_of_face, cells.size);  // refuses gaps
  REQUIRE(measured.cells.size() == cells.cells.size());
  const auto old_faces = faces_by_cell(before);
  const auto new_faces = faces_by_cell(cells);
  for (CellId cell{0}; cell < cells.cells.size(); ++cell) {
    REQUIRE(nearly_same(cells.cells[cell], measured.cells[cell]));
    std::set<std::uint32_t> were;
    bool same_place = true;
    for (const std::uint32_t face : new_faces.at(cell)) {
      const std::uint32_t previous = change.previous_face[face];
      were.insert(previous);
      same_place = same_place && previous != FaceId::none && is_at_place(mesh_before, previous, change.mesh, face);
    }
    const std::uint32_t previous = growth.previous_cell[cell];
    const bool unchanged = previous != CellId::none && same_place && were == old_faces.at(previous);
    REQUIRE(growth.changed[cell] == (unchanged ? 0 : 1));
    if (unchanged) REQUIRE(same(cells.cells[cell], before.cells[previous]));
  }
  const auto first_new = std::find(growth.previous_cell.begin(), growth.previous_cell.end(), CellId::none);
  CHECK(std::is_sorted(growth.previous_cell.begin(), growth.previous_cell.end()));
  CHECK(std::adjacent_find(growth.previous_cell.begin(), first_new) == first_new);
  auto next = static_cast<std::uint32_t>(first_new - growth.previous_cell.begin());
  for (const CellId cell : cells.cell_of_face) {
    REQUIRE(cell <= std::max(next, static_cast<std::uint32_t>(first_new - growth.previous_cell.begin())));
    if (cell == next) ++next;
  }
}

// And of clusters.
void check_faces_stay(const Cells& before, const Change& change, const CellGrowth& growth) {
  std::size_t strayed = 0;
  for (std::size_t face = 0; face < change.previous_face.size(); ++face) {
    if (change.previous_face[face] == FaceId::none) continue;
    const CellId cell = before.cell_of_face[change.previous_face[face]];
    strayed += growth.previous_cell[growth.cells.cell_of_face[face]] != cell;
  }
  CHECK(strayed == 0);
}

std::size_t count_new(const CellGrowth& growth) {
  return static_cast<std::size_t>(std::count(growth.previous_cell.begin(), growth.previous_cell.end(), CellId::none));
}

std::size_t count_changed(const CellGrowth& growth) {
  return static_cast<std::size_t>(std::count(growth.changed.begin(), growth.changed.end(), 1));
}

// The same sets of faces, whatever their numbers.
bool same_partition(const Cells& a, const Cells& b) {
  std::map<std::uint32_t, std::uint32_t> b_of_a, a_of_b;
  if (a.cell_of_face.size() != b.cell_of_face.size()) return false;
  for (std::size_t face = 0; face < a.cell_of_face.size(); ++face) {
    const CellId x = a.cell_of_face[face], y = b.cell_of_face[face];
    if (b_of_a.try_emplace(x, y).first->second != y || a_of_b.try_emplace(y, x).first->second != x) return false;
  }
  return true;
}

TEST_CASE("a mesh that did not change keeps its cells to the bit") {
  const Mesh mesh = scene(1);
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const Cells before = make_cells(mesh, options_of(partition));
    const Change change{mesh, match_faces(mesh, mesh)};
    const CellGrowth growth = grow(mesh, before, change, partition);
    check_growth(mesh, before, change, growth);
    CHECK(same(growth.cells, before));
    CHECK(count_changed(growth) == 0);
  }
}

TEST_CASE("faces, vertices and corners in another order change no cell, its number or its statistics") {
  const Mesh mesh = scene(2);
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const Cells before = make_cells(mesh, options_of(partition));
    const Change change = shuffled(mesh, 3);
    CHECK(match_faces(mesh, change.mesh) == change.previous_face);
    const CellGrowth growth = grow(mesh, before, change, partition);
    check_growth(mesh, before, change, growth);
    CHECK(count_changed(growth) == 0);
    REQUIRE(growth.cells.cells.size() == before.cells.size());
    for (std::size_t face = 0; face < change.previous_face.size(); ++face) {
      REQUIRE(growth.cells.cell_of_face[face] == before.cell_of_face[change.previous_face[face]]);
    }
  }
}

TEST_CASE("where faces are removed, only the cells that had them change, and those without any are gone") {
  const Mesh mesh = scene(3);
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const Cells before = make_cells(mesh, options_of(partition));
    const Change change = without_ball(mesh, {0.8f, 0.9f, 0}, 0.5f);
    const CellGrowth growth = grow(mesh, before, change, partition);
    check_growth(mesh, before, change, growth);
    check_faces_stay(before, change, growth);
    CHECK(count_new(growth) == 0);
    CHECK(count_changed(growth) > 0);
    std::set<CellId> left;
    for (const FaceId face : change.previous_face) left.emplace(before.cell_of_face[face]);
    CHECK(std::vector<CellId>(left.begin(), left.end()) == growth.previous_cell);
    CHECK(left.size() < before.cells.size());
  }
}

TEST_CASE("an added component gets the cells that it would have alone, and no other cell changes") {
  const Mesh mesh = scene(4);
  const Mesh addition = moved(sphere(5), {-3, 0, 0});
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const Cells before = make_cells(mesh, options_of(partition));
    Change change{joined(mesh, addition), {}};
    change.previous_face = match_faces(mesh, change.mesh);
    const CellGrowth growth = grow(mesh, before, change, partition);
    check_growth(mesh, before, change, growth);
    const Cells alone = make_cells(addition, options_of(partition));
    CHECK(count_changed(growth) == alone.cells.size());
    REQUIRE(growth.cells.cells.size() == before.cells.size() + alone.cells.size());
    for (std::size_t face = 0; face < addition.faces.size(); ++face) {
      REQUIRE(growth.cells.cell_of_face[mesh.faces.size() + face] == before.cells.size() + alone.cell_of_face[face]);
    }
    for (std::size_t cell = 0; cell < alone.cells.size(); ++cell) {
      REQUIRE(nearly_same(growth.cells.cells[before.cells.size() + cell], alone.cells[cell]));
    }
  }
}

TEST_CASE("a cell with a moved vertex keeps its faces and is measured anew") {
  const Mesh mesh = scene(5);
  const Cells before = make_cells(mesh, options_of(Partition::clusters));
  Change change{mesh, first_faces(mesh.faces.size())};
  constexpr std::uint32_t kVertex = 15 * 31 + 15;
  change.mesh.positions[kVertex].z += 0.1f;
  const CellGrowth growth = grow(mesh, before, change, Partition::clusters);
  check_growth(mesh, before, change, growth);
  CHECK(growth.cells.cell_of_face == before.cell_of_face);
  std::set<std::uint32_t> touched;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const glm::uvec3& corners = mesh.faces[face];
    if (corners.x == kVertex || corners.y == kVertex || corners.z == kVertex) touched.insert(before.cell_of_face[face]);
  }
  CHECK(count_changed(growth) == touched.size());
  for (const std::uint32_t cell : touched) CHECK(growth.cells.cells[cell].area > before.cells[cell].area);
}

TEST_CASE("a face that was turned round has moved") {
  const Mesh mesh = plane(1, 1);
  const Cells before = make_cells(mesh, options_of(Partition::clusters));
  const Change change{turned_inside_out(mesh), {0, 1}};
  const CellGrowth growth = grow(mesh, before, change, Partition::clusters);
  check_growth(mesh, before, change, growth);
  CHECK(count_changed(growth) == growth.cells.cells.size());
  CHECK(growth.cells.cells[0].normal == glm::dvec3(0, 0, -1));
  CHECK(match_faces(mesh, change.mesh) == Faces{FaceId::none, FaceId::none});
}

TEST_CASE("a mesh replaced as a whole gets new cells, those of a mesh that begins") {
  const Mesh mesh = scene(6);
  const Mesh replacement = moved(scene(7), {0.03f, 0.01f, -0.02f});
  const Cells before = make_cells(mesh, options_of(Partition::clusters));
  const Change change{replacement, match_faces(mesh, replacement)};
  const CellGrowth growth = grow(mesh, before, change, Partition::clusters);
  check_growth(mesh, before, change, growth);
  CHECK(count_new(growth) == growth.cells.cells.size());
  CHECK(same(growth.cells, make_cells(replacement, options_of(Partition::clusters))));
}

TEST_CASE("cells of a mesh that begins are those of make_cells") {
  const Mesh mesh = scene(8);
  for (const CellOptions& options : {CellOptions{}, options_of(Partition::grid)}) {
    const CellGrowth growth = grow_cells({}, {}, mesh, Faces(mesh.faces.size(), FaceId::none), options);
    CHECK(same(growth.cells, make_cells(mesh, options)));
    CHECK(count_new(growth) == growth.cells.cells.size());
    CHECK(count_changed(growth) == growth.cells.cells.size());
  }
}

TEST_CASE("few new faces beside a cell join it, and many form cells of their own") {
  const Mesh whole = plane(40, 2);  // faces of 0.05, cells of 0.2
  const auto up_to = [&](float x) {
    Change change{{whole.positions, {}, {}}, {}};
    for (const glm::uvec3& face : whole.faces) {
      if (middle_of(whole, face).x < x) change.mesh.faces.push_back(face);
    }
    return change;
  };
  const Mesh mesh = up_to(1).mesh;
  const Cells before = make_cells(mesh, options_of(Partition::clusters));
  Change strip = up_to(1.05f);
  strip.previous_face = match_faces(mesh, strip.mesh);
  const CellGrowth little = grow(mesh, before, strip, Partition::clusters);
  check_growth(mesh, before, strip, little);
  check_faces_stay(before, strip, little);
  CHECK(count_new(little) <= 2);  // a strip of a quarter of the size does not fit the largest
  Change half = up_to(2);
  half.previous_face = match_faces(mesh, half.mesh);
  const CellGrowth much = grow(mesh, before, half, Partition::clusters);
  check_growth(mesh, before, half, much);
  check_faces_stay(before, half, much);
  CHECK(static_cast<double>(count_new(much)) == Approx(2 / (kSize * kSize)).epsilon(0.3));
}

TEST_CASE("a small cell takes in what is added around it, and keeps its own faces") {
  const Mesh whole = plane(41, 2);
  const glm::vec3 center(1, 1, 0);
  const Mesh hole = without_ball(whole, center, 0.045f).mesh;
  Mesh island{whole.positions, {}, {}};
  for (const glm::uvec3& face : whole.faces) {
    if (glm::distance(middle_of(whole, face), center) < 0.045f) island.faces.push_back(face);
  }
  const Cells before = make_cells(island, options_of(Partition::clusters));
  REQUIRE(before.cells.size() == 1);
  REQUIRE(before.cells[0].area < 0.35 * kSize * kSize);
  Change change{{whole.positions, {}, island.faces}, {}};
  change.mesh.faces.insert(change.mesh.faces.end(), hole.faces.begin(), hole.faces.end());
  change.previous_face = match_faces(island, change.mesh);
  const CellGrowth growth = grow(island, before, change, Partition::clusters);
  check_growth(island, before, change, growth);
  check_faces_stay(before, change, growth);
  CHECK(growth.previous_cell[0] == 0);
  CHECK(growth.cells.cells[0].area > 0.35 * kSize * kSize);
}

TEST_CASE("a new face far from every cell is a cell, however small") {
  const Mesh mesh = plane(10, 1);
  const Cells before = make_cells(mesh, options_of(Partition::clusters));
  Change change{joined(mesh, moved(plane(1, 0.01f), {0, 0, 5})), {}};
  change.previous_face = match_faces(mesh, change.mesh);
  const CellGrowth growth = grow(mesh, before, change, Partition::clusters);
  check_growth(mesh, before, change, growth);
  CHECK(count_new(growth) == 1);
  CHECK(count_changed(growth) == 1);
}

// One step of a stream: a ball of the surface goes, or what was taken comes back, or vertices move.
Change random_change(const Mesh& whole, const Mesh& mesh, std::mt19937& random) {
  const auto pick = [&](std::size_t count) { return random() % count; };
  const glm::vec3 center = whole.positions[pick(whole.positions.size())];
  const float radius = 0.1f + 0.1f * static_cast<float>(pick(6));
  switch (pick(3)) {
    case 0: {
      Change change = without_ball(mesh, center, radius);
      if (!change.mesh.faces.empty()) return change;
      [[fallthrough]];
    }
    case 1: {  // the ball as it was at first
      Change change = without_ball(mesh, center, radius);
      Mesh ball{whole.positions, {}, {}};
      for (const glm::uvec3& face : whole.faces) {
        if (glm::distance(middle_of(whole, face), center) < radius) ball.faces.push_back(face);
      }
      change.mesh = shuffled(joined(change.mesh, ball), static_cast<unsigned>(random())).mesh;
      change.previous_face = match_faces(mesh, change.mesh);
      return change;
    }
    default: {
      Change change{mesh, first_faces(mesh.faces.size())};
      for (glm::vec3& p : change.mesh.positions) {
        if (glm::distance(p, center) < radius) p += glm::vec3(0, 0, 0.003f);
      }
      return change;
    }
  }
}

TEST_CASE("what holds of one change holds of any sequence of them") {
  const Mesh whole = scene(9);
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    std::mt19937 random(11);
    Mesh mesh = whole;
    Cells cells = make_cells(mesh, options_of(partition));
    for (int step = 0; step < 60; ++step) {
      INFO("step " << step);
      Change change = random_change(whole, mesh, random);
      CellGrowth growth = grow(mesh, cells, change, partition);
      check_growth(mesh, cells, change, growth);
      if (partition == Partition::clusters) check_faces_stay(cells, change, growth);
      mesh = std::move(change.mesh);
      cells = std::move(growth.cells);
    }
    if (partition == Partition::grid) CHECK(same_partition(cells, make_cells(mesh, options_of(partition))));
  }
}

TEST_CASE("a surface that grows strip by strip has not many more cells than one that is there at once") {
  const Mesh whole = plane(80, 2);
  Mesh mesh;
  Cells cells;
  for (std::uint32_t columns = 1; columns <= 80; ++columns) {
    Change change{{whole.positions, {}, {}}, {}};
    for (const glm::uvec3& face : whole.faces) {
      if (middle_of(whole, face).x < 0.025f * static_cast<float>(columns)) change.mesh.faces.push_back(face);
    }
    change.previous_face = match_faces(mesh, change.mesh);
    cells = grow(mesh, cells, change, Partition::clusters).cells;
    mesh = std::move(change.mesh);
  }
  const Cells at_once = make_cells(whole, options_of(Partition::clusters));
  const auto ratio = static_cast<double>(cells.cells.size()) / static_cast<double>(at_once.cells.size());
  CHECK(ratio < 1.2);
  CHECK(ratio > 0.5);  // a cell may take strips until it is nearly twice the target
}

TEST_CASE("a surface whose parts are replaced again and again does not fall to pieces") {
  const Mesh whole = plane(60, 2);
  const Cells at_first = make_cells(whole, options_of(Partition::clusters));
  std::mt19937 random(5);
  Mesh mesh = whole;
  Cells cells = at_first;
  std::size_t most = 0;
  for (int step = 0; step < 150; ++step) {
    const glm::vec3 center = whole.positions[random() % whole.positions.size()];
    Change change = without_ball(mesh, center, 0.35f);
    for (const glm::uvec3& face : whole.faces) {
      if (glm::distance(middle_of(whole, face), center) < 0.35f) change.mesh.faces.push_back(face);
    }
    change.previous_face.resize(change.mesh.faces.size(), FaceId::none);
    cells = grow(mesh, cells, change, Partition::clusters).cells;
    mesh = std::move(change.mesh);
    most = std::max(most, cells.cells.size());
  }
  CHECK(mesh.faces.size() == whole.faces.size());
  CHECK(static_cast<double>(most) < 1.8 * static_cast<double>(at_first.cells.size()));  // measured: 1.44
}

TEST_CASE("growth is the same with one thread and with four") {
  const Mesh mesh = scene(12);
  const Mesh addition = joined(without_ball(mesh, {0.8f, 0.9f, 0}, 0.5f).mesh, moved(sphere(5), {-3, 0, 0}));
  for (const Partition partition : {Partition::clusters, Partition::grid}) {
    const auto with_threads = [&](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      return grow(mesh, make_cells(mesh, options_of(partition)), {addition, match_faces(mesh, addition)}, partition);
    };
    const CellGrowth one = with_threads(1);
    const CellGrowth four = with_threads(4);
    CHECK(same(one.cells, four.cells));
    CHECK(one.previous_cell == four.previous_cell);
    CHECK(one.changed == four.changed);
  }
}

TEST_CASE("faces at one place are matched one to one, in their order") {
  const Mesh mesh = plane(1, 1);
  const Mesh twice = joined(mesh, mesh);
  CHECK(match_faces(twice, twice) == Faces{0, 1, 2, 3});
  CHECK(match_faces(mesh, twice) == Faces{0, 1, FaceId::none, FaceId::none});
  CHECK(match_faces(twice, mesh) == Faces{0, 1});
  CHECK(match_faces(mesh, {}) == Faces{});
  CHECK(match_faces({}, mesh) == Faces{FaceId::none, FaceId::none});
}

TEST_CASE("faces match to the bit, and a zero is a zero") {
  const Mesh mesh = plane(1, 1);
  Mesh other = mesh;
  for (glm::vec3& p : other.positions) p.z = -0.0f;
  CHECK(match_faces(mesh, other) == Faces{0, 1});
  other.positions[1].x = std::nextafter(other.positions[1].x, 2.0f);  // a corner of the first alone
  CHECK(match_faces(mesh, other) == Faces{FaceId::none, 1});
  other.positions[1].x = std::nanf("");
  CHECK(match_faces(mesh, other) == Faces{FaceId::none, 1});
  CHECK(match_faces(other, other) == Faces{0, 1});
}

TEST_CASE("a growth that makes no sense is refused") {
  const Mesh mesh = plane(2, 1);
  const Cells cells = make_cells(mesh, options_of(Partition::clusters));
  const Faces previous = match_faces(mesh, mesh);
  const auto refused = [&](const Cells& before, const Mesh& after, const Faces& previous_face,
                           const CellOptions& options, const std::string& sentence) {
    CHECK_THROWS_MATCHES(grow_cells(mesh, before, after, previous_face, options), std::invalid_argument,
                         Catch::Message(sentence));
  };
  const CellOptions clusters = options_of(Partition::clusters);
  refused(cells, {}, {}, clusters, "cells: the changed mesh has no face, must have at least one");
  refused(cells, mesh, {0, 1}, clusters, "cells: previous_face has 2 entries, must have one per face, 8");
  refused(cells, mesh, {0, 1, 2, 3, 4, 5, 6, 8}, clusters,
          "cells: previous_face[7] is 8, must be below the number of faces before, 8");
  refused(cells, mesh, {0, 1, 2, 3, 4, 5, 6, 3}, clusters,
          "cells: previous_face[7] is 3, must not name a face that an earlier entry names");
  refused(cells, mesh, previous, {Partition::clusters, 0.5, 2},
          "cells: size is 0.5, must be that of the cells before, 0.2, or 0");
  refused(cells, mesh, previous, {Partition::clusters, kSize, -1},
          "cells: normal_weight is -1, must be finite and not negative");
  Cells wrong = cells;
  wrong.cell_of_face.pop_back();
  refused(wrong, mesh, previous, clusters, "cells: those before have 7 faces, must have as many as the mesh before, 8");
  wrong = cells;
  wrong.cell_of_face[0] = 100;
  refused(wrong, mesh, previous, clusters,
          "cells: a face before is in cell 100 of " + std::to_string(cells.cells.size()) + ", must be in one of them");
  wrong = cells;
  wrong.cells[0].faces = 7;
  refused(wrong, mesh, previous, clusters, "cells: cell 0 before has 1 faces, must have the 7 that were measured");
  wrong = cells;
  wrong.size = 0;
  refused(wrong, mesh, previous, {}, "cells: the size before is 0, must be finite and above 0");
  const Cells one = measure_cells(mesh, std::vector<CellId>(8, 0), kSize);
  refused(one, mesh, previous, options_of(Partition::grid),
          "cells: cell 0 before is not the faces in one cube of size 0.2, must be for a grid");
  CHECK_NOTHROW(grow_cells(mesh, cells, mesh, previous, {}));
}

}  // namespace
}  // namespace lumatlas
