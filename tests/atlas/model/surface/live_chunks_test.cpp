// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/live_chunks.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "blend/tables/fade_zone_shares.h"
#include "tests/support/scenes/far_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr LiveChunkOptions kCut{.least_faces = 1, .cells_across = 2, .width = 0.3};

CellShares shares_of(const Surface& surface) {
  return share_cells(surface, kCut.width);
}

Surface wall() {
  Surface surface;
  add_wall(surface.mesh, 48, 20, 0.3f, 4);
  surface.cells = make_cells(surface.mesh, {.size = 0.5});
  surface.offset = {12, 0, -3};
  return surface;
}

using Place = std::array<float, 3>;
Place place_of(const glm::dvec3& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

// The place of a corner of a face, and the shares of the cells around by these cells' middles.
using DrawnCorner = std::pair<Place, std::map<Place, int>>;
using DrawnFace = std::array<DrawnCorner, 3>;

glm::u8vec4 rounded(const glm::vec4& shares) {
  return glm::u8vec4(glm::round(shares * 255.0F));
}

std::multiset<DrawnFace> faces_of(const Surface& surface) {
  const CellShares shares = shares_of(surface);
  std::multiset<DrawnFace> drawn;
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    DrawnFace one;
    for (int corner = 0; corner < 3; ++corner) {
      const auto at = static_cast<std::size_t>(corner);
      one.at(at).first = place_of(surface.mesh.positions[surface.mesh.faces[face][corner]]);
      const glm::u8vec4 of_corner = rounded(shares.corners[face].at(at));
      const CellShares::Zone& zone = shares.zones[shares.zone_of_face[face]];
      for (int i = 0; i < 4; ++i) {
        const CellId cell = zone.at(static_cast<std::size_t>(i));
        if (cell != CellId::none) one.at(at).second[place_of(surface.cells.cells[cell].centroid)] = of_corner[i];
      }
    }
    drawn.insert(one);
  }
  return drawn;
}

// The same of the chunks, as their files have them.
std::multiset<DrawnFace> faces_of(const Surface& surface, const LiveChunks& chunks) {
  std::multiset<DrawnFace> drawn;
  for (const LiveChunk& chunk : chunks.chunks) {
    std::vector<CellId> cells = chunk.cells;
    for (const std::uint32_t guest : chunk.form->guests) cells.push_back(chunk.around[guest]);
    const WrittenMesh& mesh = chunk.form->mesh.near;
    const std::vector<std::uint32_t>& zone_cells = chunk.form->mesh.zone_cells;
    const std::size_t zones = zone_cells.size() / 5;
    for (const glm::uvec3& face : mesh.faces) {
      DrawnFace one;
      const auto zone = static_cast<std::size_t>(mesh.zones[face.x]);
      for (int corner = 0; corner < 3; ++corner) {
        DrawnCorner& of_corner = one.at(static_cast<std::size_t>(corner));
        of_corner.first = place_of(glm::dvec3(mesh.positions[face[corner]]) + chunk.form->origin);
        for (std::size_t i = 0; i < 4; ++i) {
          const std::uint32_t cell = zone_cells[(1 + i) * zones + zone];
          if (cell == CellId::none) continue;
          of_corner.second[place_of(surface.cells.cells[cells[cell]].centroid)] =
              mesh.shares[face[corner]][static_cast<int>(i)];
        }
      }
      drawn.insert(one);
    }
  }
  return drawn;
}

bool are_same(const LiveChunkForm& a, const LiveChunkForm& b) {
  return a.mesh.near.positions == b.mesh.near.positions && a.mesh.near.faces == b.mesh.near.faces &&
         a.mesh.near.cells == b.mesh.near.cells && a.mesh.near.zones == b.mesh.near.zones &&
         a.mesh.near.shares == b.mesh.near.shares && a.mesh.zone_cells == b.mesh.zone_cells && a.origin == b.origin &&
         a.guests == b.guests;
}

// The wall with a dent, whose cells come in another order than the wall's.
Surface dented_wall() {
  Surface surface = wall();
  const glm::vec3 middle = surface.mesh.positions.front();
  for (glm::vec3& position : surface.mesh.positions) {
    if (glm::distance(position, middle) < 0.4f) position.z += 0.05f;
  }
  surface.cells = make_cells(surface.mesh, {.size = 0.5});
  return surface;
}

TEST_CASE("chunks of a live surface have each face once, with the shares of the whole surface") {
  const Surface surface = wall();
  const LiveChunks chunks = live_chunks(surface, kCut, shares_of, nullptr);
  REQUIRE(chunks.chunks.size() > 10);
  std::set<std::uint32_t> cells;
  for (const LiveChunk& chunk : chunks.chunks) cells.insert(chunk.cells.begin(), chunk.cells.end());
  CHECK(cells.size() == surface.cells.cells.size());
  CHECK(faces_of(surface, chunks) == faces_of(surface));
}

TEST_CASE("chunks far from a change of a live surface are not made again, and all are as made at once") {
  const Surface surface = wall();
  const LiveChunks before = live_chunks(surface, kCut, shares_of, nullptr);
  const Surface changed = dented_wall();
  const LiveChunks now = live_chunks(changed, kCut, shares_of, &before);
  const LiveChunks at_once = live_chunks(changed, kCut, shares_of, nullptr);
  REQUIRE(now.chunks.size() == at_once.chunks.size());
  std::set<const LiveChunkForm*> known;
  for (const LiveChunk& chunk : before.chunks) known.insert(chunk.form.get());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < now.chunks.size(); ++i) {
    CHECK(are_same(*now.chunks[i].form, *at_once.chunks[i].form));
    kept += known.count(now.chunks[i].form.get());
  }
  CHECK(kept > now.chunks.size() / 4);
  CHECK(kept < now.chunks.size());
  CHECK(faces_of(changed, now) == faces_of(changed));
}

TEST_CASE("tables of a live chunk are those of its cells, also of cells with new numbers") {
  const Surface surface = wall();
  const LiveChunks before = live_chunks(surface, kCut, shares_of, nullptr);
  Snapshot snapshot;
  snapshot.surface = std::make_shared<const Surface>(dented_wall());
  const LiveChunks now = live_chunks(*snapshot.surface, kCut, shares_of, &before);
  std::vector<glm::u8vec3> colors;
  std::map<Place, glm::u8vec3> color_at;
  std::mt19937 random(3);
  for (const glm::vec3& position : snapshot.surface->mesh.positions) {
    const glm::u8vec3 color(random() % 256, random() % 256, random() % 256);
    colors.push_back(color_at.emplace(place_of(position), color).first->second);
  }
  snapshot.vertex_colors = std::move(colors);
  for (std::uint32_t cell = 0; cell < snapshot.surface->cells.cells.size(); ++cell) {
    snapshot.cell_seen.push_back(cell % 2);
    snapshot.cell_deviation.push_back(static_cast<float>(cell));
    for (std::uint32_t i = 0; i < cell % 4; ++i) snapshot.references.views.emplace_back(cell % 8);
    snapshot.references.offsets.push_back(static_cast<std::uint32_t>(snapshot.references.views.size()));
  }
  for (const LiveChunk& chunk : now.chunks) {
    const Snapshot part = chunk_snapshot(snapshot, now.faces, chunk);
    std::vector<CellId> cells = chunk.cells;
    REQUIRE(part.cell_seen.size() == cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      CHECK(part.cell_seen[i] == snapshot.cell_seen[cells[i]]);
      CHECK(part.cell_deviation[i] == snapshot.cell_deviation[cells[i]]);
    }
    for (const std::uint32_t guest : chunk.form->guests) cells.push_back(chunk.around[guest]);
    REQUIRE(part.references.offsets.size() == cells.size() + 1);
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      const auto views = part.references.of_cell(CellId(i)), whole = snapshot.references.of_cell(cells[i]);
      CHECK(std::equal(views.begin(), views.end(), whole.begin(), whole.end()));
    }
    const Mesh& mesh = part.surface->mesh;
    REQUIRE(part.vertex_colors.size() == mesh.positions.size());
    for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
      const Place place = place_of(glm::dvec3(mesh.positions[vertex]) + chunk.form->origin);
      CHECK(part.vertex_colors.get()[vertex] == color_at.at(place));
    }
  }
}

TEST_CASE("a live surface of few faces, or with a far sphere, is not cut into chunks") {
  const Surface surface = wall();
  LiveChunkOptions few = kCut;
  few.least_faces = surface.mesh.faces.size() + 1;
  CHECK(live_chunks(surface, few, shares_of, nullptr).chunks.empty());
  CHECK(live_chunks(*with_sphere_behind(surface), kCut, shares_of, nullptr).chunks.empty());
}

}  // namespace
}  // namespace lumatlas
