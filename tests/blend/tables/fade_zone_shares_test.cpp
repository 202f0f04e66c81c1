// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/fade_zone_shares.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

// A wall of 40 x 40 squares of side 0.25 in `columns` x `rows` cells of equal size.
Surface wall_in_cells(std::uint32_t columns, std::uint32_t rows) {
  Surface surface;
  add_wall(surface.mesh, 40, 40, 0.25F, 4);
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const std::uint32_t square = face / 2;
    cell_of_face.emplace_back(square / 40 * rows / 40 * columns + square % 40 * columns / 40);
  }
  surface.cells = measure_cells(surface.mesh, std::move(cell_of_face), 10.0 / columns);
  return surface;
}

// Returns shares by vertex and cell. Checks that every face has the same shares at a vertex, which makes them
// continuous over the mesh.
std::vector<std::map<std::uint32_t, float>> shares_by_vertex(const Surface& surface, const CellShares& shares) {
  std::vector<std::map<std::uint32_t, float>> by_vertex(surface.mesh.positions.size());
  std::vector<bool> known(by_vertex.size(), false);
  REQUIRE(shares.zone_of_face.size() == surface.mesh.faces.size());
  REQUIRE(shares.corners.size() == surface.mesh.faces.size());
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const CellShares::Zone& zone = shares.zones[shares.zone_of_face[face]];
    REQUIRE(std::is_sorted(zone.begin(), zone.end()));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::map<std::uint32_t, float> here;
      for (std::size_t i = 0; i < kCellsPerZone; ++i) {
        const float share = shares.corners[face][corner][static_cast<int>(i)];
        REQUIRE(share >= 0);
        if (share > 0) here[zone[i]] = share;
      }
      const std::uint32_t vertex = surface.mesh.faces[face][static_cast<int>(corner)];
      if (known[vertex]) REQUIRE(by_vertex[vertex] == here);
      by_vertex[vertex] = here;
      known[vertex] = true;
    }
  }
  return by_vertex;
}

void check_sums(const std::vector<std::map<std::uint32_t, float>>& by_vertex) {
  for (const auto& cells : by_vertex) {
    float sum = 0;
    for (const auto& [cell, share] : cells) {
      REQUIRE(cell != CellId::none);
      sum += share;
    }
    REQUIRE(sum == Approx(1).margin(1e-6));
  }
}

TEST_CASE("without a width every face is its own cell's alone") {
  const Surface surface = wall_in_cells(4, 3);
  const CellShares shares = share_cells(surface, 0);
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const CellShares::Zone& zone = shares.zones[shares.zone_of_face[face]];
    REQUIRE(zone ==
            CellShares::Zone{CellId{surface.cells.cell_of_face[face]}, CellId::none, CellId::none, CellId::none});
    for (const glm::vec4& corner : shares.corners[face]) REQUIRE(corner == glm::vec4(1, 0, 0, 0));
  }
}

TEST_CASE("shares fall linearly with the distance from a straight border, and are halves on it") {
  const Surface surface = wall_in_cells(2, 1);
  const double width = 2;
  const auto by_vertex = shares_by_vertex(surface, share_cells(surface, width));
  check_sums(by_vertex);
  for (std::size_t vertex = 0; vertex < by_vertex.size(); ++vertex) {
    const double distance = surface.mesh.positions[vertex].x;  // right of the border; along a row of edges
    const double other = std::max(0.0, 1 - std::abs(distance) / width);
    const auto left = by_vertex[vertex].find(0);
    const double share = left == by_vertex[vertex].end() ? 0 : left->second;
    REQUIRE(share == Approx((distance > 0 ? other : 1.0) / (1 + other)).margin(1e-6));
  }
}

TEST_CASE("shares are continuous over the mesh and add up to 1, for clusters, too") {
  for (const double width : {0.05, 0.3, 1.0, 5.0}) {
    check_sums(shares_by_vertex(*room_surface(), share_cells(*room_surface(), width)));
    // Cells of four squares: at the wider ones dozens would share a face.
    const Surface tiny = wall_in_cells(20, 20);
    check_sums(shares_by_vertex(tiny, share_cells(tiny, width)));
  }
}

// A wall of squares of side 1, each of whose faces is a cell.
Surface wall_of_single_faces(std::uint32_t squares_a_side) {
  Surface surface;
  add_wall(surface.mesh, squares_a_side, squares_a_side, 1, 4);
  std::vector<CellId> cell_of_face(surface.mesh.faces.size());
  std::iota(cell_of_face.begin(), cell_of_face.end(), CellId{0});
  surface.cells = measure_cells(surface.mesh, std::move(cell_of_face), 1);
  return surface;
}

TEST_CASE("where cells of one face each meet, nothing is left without a cell") {
  const Surface surface = wall_of_single_faces(12);
  for (const double width : {1e-9, 0.5, 3.0}) check_sums(shares_by_vertex(surface, share_cells(surface, width)));
}

// A fan of faces around one vertex, each its own cell: every cell is at distance 0 of that vertex.
Surface fan_of_cells(std::uint32_t faces) {
  Surface surface;
  surface.mesh.positions.emplace_back(0, 0, 1);
  std::vector<CellId> cell_of_face(faces);
  for (std::uint32_t face = 0; face < faces; ++face) {
    const double angle = 2 * std::acos(-1.0) * face / faces;
    surface.mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    surface.mesh.faces.emplace_back(0, 1 + face, 1 + (face + 1) % faces);
    cell_of_face[face] = CellId(face);
  }
  surface.cells = measure_cells(surface.mesh, std::move(cell_of_face), 1);
  return surface;
}

TEST_CASE("work grows with the faces, whatever the width is and however many cells meet") {
  // Every cell against every vertex would be 4 * 10^8 steps on the wall and on the fan.
  const Surface wall = wall_of_single_faces(120), fan = fan_of_cells(20'000);
  for (const double width : {100.0, 1e300}) {
    check_sums(shares_by_vertex(wall, share_cells(wall, width)));
    check_sums(shares_by_vertex(fan, share_cells(fan, width)));
  }
}

TEST_CASE("of more cells than may share a vertex the nearest ones share it") {
  const Surface surface = wall_in_cells(40, 40);  // cells of one square, 0.25 wide
  const auto by_vertex = shares_by_vertex(surface, share_cells(surface, 1e6));
  for (std::size_t vertex = 0; vertex < by_vertex.size(); ++vertex) {
    for (const auto& [cell, share] : by_vertex[vertex]) {
      const glm::dvec3 apart = surface.cells.cells[cell].centroid - glm::dvec3(surface.mesh.positions[vertex]);
      REQUIRE(glm::length(apart) < 1.0);
    }
  }
}

TEST_CASE("surfaces that only touch share nothing") {
  const auto surface = wall_and_panel(1);
  Surface apart = *surface;
  std::vector<CellId> cell_of_face(apart.mesh.faces.size(), 0);
  cell_of_face.back() = cell_of_face[cell_of_face.size() - 2] = 1;  // the panel
  apart.cells = measure_cells(apart.mesh, std::move(cell_of_face), 1);
  const CellShares shares = share_cells(apart, 100);
  for (std::size_t face = 0; face < apart.mesh.faces.size(); ++face) {
    CHECK(shares.zones[shares.zone_of_face[face]][1] == CellId::none);
  }
}

TEST_CASE("a bad width is refused") {
  const Surface surface = wall_in_cells(2, 1);
  CHECK_THROWS_WITH(share_cells(surface, -1), Catch::Contains("width is -1"));
  CHECK_THROWS_AS(share_cells(surface, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST_CASE("the share of a cell that stands for others is the sum of theirs") {
  const Surface surface = wall_in_cells(5, 4);
  const CellShares separate = share_cells(surface, 1.5);
  std::vector<std::uint32_t> stands_for(20);
  for (CellId cell{0}; cell < 20; ++cell) stands_for[cell] = cell % 3;     // others than its neighbours'
  for (const std::uint32_t cell : {1u, 2u, 6u, 7u}) stands_for[cell] = 1;  // a block
  const CellShares fewer = joined(separate, stands_for);
  const auto before = shares_by_vertex(surface, separate), after = shares_by_vertex(surface, fewer);
  check_sums(after);
  for (std::size_t vertex = 0; vertex < before.size(); ++vertex) {
    std::map<std::uint32_t, float> sums;
    for (const auto& [cell, share] : before[vertex]) sums[stands_for[cell]] += share;
    REQUIRE(after[vertex].size() == sums.size());
    for (const auto& [cell, share] : after[vertex]) REQUIRE(share == Approx(sums.at(cell)).margin(1e-6));
  }
  CHECK(fewer.zones.size() < separate.zones.size());
  CHECK(std::set<CellShares::Zone>(fewer.zones.begin(), fewer.zones.end()).size() == fewer.zones.size());
}

TEST_CASE("cells that stand for themselves keep their shares") {
  const Surface surface = wall_in_cells(3, 3);
  const CellShares separate = share_cells(surface, 1);
  std::vector<std::uint32_t> own(9);
  for (CellId cell{0}; cell < 9; ++cell) own[cell] = cell;
  const CellShares same = joined(separate, own);
  CHECK(same.zones == separate.zones);
  CHECK(same.zone_of_face == separate.zone_of_face);
  CHECK(same.corners == separate.corners);
  CHECK_THROWS_WITH(joined(separate, std::span(own).first(8)), "cell shares: no cell stands for 8");
}

TEST_CASE("cells have the same references whatever the order of these, and without any too") {
  ReferenceTable references;
  for (const std::vector<ViewSlot>& views :
       std::vector<std::vector<ViewSlot>>{{3, 1}, {}, {1}, {1, 3}, {}, {1, 3, 4}, {1}}) {
    references.views.insert(references.views.end(), views.begin(), views.end());
    references.offsets.push_back(static_cast<std::uint32_t>(references.views.size()));
  }
  CHECK(first_of_same_references(references) == std::vector<std::uint32_t>{0, 1, 2, 0, 1, 5, 2});
  CHECK(first_of_same_references({}).empty());
}

}  // namespace
}  // namespace lumatlas
