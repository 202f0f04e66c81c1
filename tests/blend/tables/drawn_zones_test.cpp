// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh that is drawn: which faces a camera may see, and that what stays of a surface that changes is what would be
// made of it anew.
#include "blend/tables/drawn_zones.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "mesh/cells/cell_growth.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

// Faces at the points of a grid in the plane z = 1, a square of 32 x 32 points after another, each square a cell.
std::shared_ptr<const Surface> squares_of_faces(std::uint32_t across) {
  const auto surface = std::make_shared<Surface>();
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < across * across; ++face) {
    const std::uint32_t square = face / 1024, squares = across / 32;
    const glm::vec3 at(square % squares * 32 + face % 32, square / squares * 32 + face % 1024 / 32, 1);
    const auto first = static_cast<std::uint32_t>(surface->mesh.positions.size());
    for (const glm::vec3& corner : {glm::vec3(0), glm::vec3(0.25, 0, 0), glm::vec3(0, 0.25, 0)}) {
      surface->mesh.positions.push_back(at + corner);
    }
    surface->mesh.faces.emplace_back(first, first + 1, first + 2);
    cell_of_face.emplace_back(square);
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 8);
  return surface;
}

TEST_CASE("all faces in view are in the runs that are drawn, and few others") {
  const auto surface = squares_of_faces(128);
  const MadeZones made = make_zones(surface, {}, nullptr);
  REQUIRE(made.mesh);
  const ZoneMesh& mesh = *made.mesh;
  REQUIRE(mesh.faces.size() == surface->mesh.faces.size());
  Camera camera = centered_camera(100, 100, 50);
  camera.cam_from_world_translation = {-40, -20, 5};  // sees a square of 12 around (40, 20)
  const RunsOfShaders seen = made.zones->in_view(camera);
  CHECK(seen[1].empty());
  CHECK(seen[2].empty());
  std::vector<int> drawn(mesh.faces.size(), 0);
  std::size_t count = 0;
  for (const auto& [batch, run] : seen[0]) {
    CHECK(batch == 0);
    for (std::uint32_t face = run.first; face < run.first + run.count; ++face) ++drawn.at(face);
    count += run.count;
  }
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(mesh.positions[mesh.faces[face].x]));
    const bool in_image = at.x >= 0 && at.y >= 0 && at.x < 100 && at.y < 100;
    if (in_image) CHECK(drawn[face] == 1);
    CHECK(drawn[face] <= 1);
  }
  CHECK(count > 0);
  CHECK(count < mesh.faces.size() / 2);
  camera.cam_from_world_translation.z = -50;  // all is behind
  for (const auto& of_shader : made.zones->in_view(camera)) CHECK(of_shader.empty());
}

// The options for a surface that follows another.
ZoneOptions options_of_change(double border_width) {
  ZoneOptions options;
  options.border_width = border_width;
  options.will_change = true;
  return options;
}

// A bumpy wall of 2 x 96 x 96 faces in about 24 x 24 cells, cut apart along a line, where vertices are at one place.
Surface bumpy_wall() {
  Surface surface;
  add_wall(surface.mesh, 96, 96, 0.25F, 4);
  std::mt19937 random(5);
  for (glm::vec3& position : surface.mesh.positions) {
    position.z += 0.1F * static_cast<float>(random()) / 4294967296.0F;
  }
  std::map<std::uint32_t, std::uint32_t> copies;
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3 && face / 2 % 96 >= 48; ++corner) {
      std::uint32_t& vertex = surface.mesh.faces[face][corner];
      if (std::abs(surface.mesh.positions[vertex].x - surface.mesh.positions[48].x) > 0.01F) continue;
      const auto [copy, is_new] = copies.emplace(vertex, static_cast<std::uint32_t>(surface.mesh.positions.size()));
      if (is_new) {
        const glm::vec3 position = surface.mesh.positions[vertex];
        surface.mesh.positions.push_back(position);
      }
      vertex = copy->second;
    }
  }
  REQUIRE(copies.size() > 90);
  surface.cells = make_cells(surface.mesh, {Partition::clusters, 1, 2});
  return surface;
}

std::shared_ptr<const Surface> regrown(const Surface& before, Mesh mesh) {
  CellGrowth growth = grow_cells(before.mesh, before.cells, mesh, match_faces(before.mesh, mesh), {});
  const auto surface = std::make_shared<Surface>();
  surface->mesh = std::move(mesh);
  surface->cells = std::move(growth.cells);
  return surface;
}

// Moves the vertices in a disk, takes the faces in another one away, and renumbers all vertices.
Mesh changed_somewhere(Mesh mesh, std::mt19937& random) {
  const auto place = [&] { return mesh.positions[random() % mesh.positions.size()]; };
  const glm::vec3 moved = place(), cut = place();
  for (glm::vec3& position : mesh.positions) {
    if (glm::distance(position, moved) < 1.2F) position.z += 0.05F;
  }
  std::erase_if(mesh.faces, [&](const glm::uvec3& face) { return glm::distance(mesh.positions[face.x], cut) < 0.8F; });
  std::vector<std::uint32_t> number(mesh.positions.size(), ~0u);
  Mesh next;
  for (glm::uvec3 face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& known = number[face[corner]];
      if (known == ~0u) {
        known = static_cast<std::uint32_t>(next.positions.size());
        next.positions.push_back(mesh.positions[face[corner]]);
      }
      face[corner] = known;
    }
    next.faces.push_back(face);
  }
  return next;
}

using Batches = std::map<std::uint64_t, ZoneMesh>;  // by number

void take(MadeZones& made, Batches& batches) {
  if (made.mesh) batches[made.zones->batches.back().number] = std::move(*made.mesh);
}

struct DrawnCorner {
  glm::vec3 position;
  glm::u16vec4 shares;
  std::uint32_t source, cell;
  CellShares::Zone cells;
  bool operator==(const DrawnCorner&) const = default;
};

// Returns the corners of all faces in the order that they are drawn in, for each shader.
std::vector<DrawnCorner> corners_drawn(const DrawnZones& zones, const Batches& batches) {
  std::vector<DrawnCorner> corners;
  for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
    for (const DrawnChunk& chunk : zones.chunks) {
      const DrawnBatch& batch = zones.batches.at(chunk.batch);
      const ZoneMesh& mesh = batches.at(batch.number);
      for (const auto& [run, ball] : chunk.layout->runs.at(shader)) {
        for (std::uint32_t face = run.first; face < run.first + run.count; ++face) {
          for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = mesh.faces.at(face)[corner];
            const std::uint32_t zone = batch.first_zone + mesh.zones.at(vertex);
            corners.push_back({mesh.positions[vertex], mesh.shares[vertex], batch.sources.at(vertex),
                               zones.cells.cell.at(zone),
                               zones.cells.combinations.at(zones.cells.combination.at(zone))});
          }
        }
      }
    }
  }
  return corners;
}

TEST_CASE("a surface that changes is laid out in places, as if it were laid out whole") {
  const ZoneOptions options = options_of_change(GENERATE(0.0, 0.1, 0.5, 1.0));
  CAPTURE(options.border_width);
  auto surface = std::make_shared<const Surface>(bumpy_wall());
  Batches followed;
  MadeZones made = make_zones(surface, options, nullptr);
  REQUIRE(made.zones->can_follow);
  REQUIRE(made.zones->chunks.size() > 30);
  take(made, followed);
  std::shared_ptr<const DrawnZones> former = made.zones;
  std::mt19937 random(11);
  std::size_t faces = 0, laid_out = 0, most_batches = 0;
  for (int step = 0; step < 40; ++step) {
    CAPTURE(step);
    surface = regrown(*surface, changed_somewhere(surface->mesh, random));
    MadeZones next = make_zones(surface, options, former.get());
    faces += surface->mesh.faces.size();
    if (next.mesh) laid_out += next.mesh->faces.size();
    take(next, followed);
    Batches alone;
    MadeZones whole = make_zones(surface, options, nullptr);
    take(whole, alone);
    REQUIRE(corners_drawn(*next.zones, followed).size() == 3 * surface->mesh.faces.size());
    REQUIRE(corners_drawn(*next.zones, followed) == corners_drawn(*whole.zones, alone));
    std::size_t vertices = 0, drawn = 0;
    for (const DrawnBatch& batch : next.zones->batches) vertices += batch.sources.size();
    for (const DrawnChunk& chunk : next.zones->chunks) drawn += chunk.layout->sources.size();
    CHECK(vertices <= 2 * drawn);
    most_batches = std::max(most_batches, next.zones->batches.size());
    former = next.zones;
  }
  CHECK(laid_out < faces / 4 * 3);  // a change touches some of 40 chunks
  CHECK(most_batches > 2);
  CHECK(most_batches <= 33);
}

TEST_CASE("a surface that takes its own place keeps all that is laid out") {
  const ZoneOptions options = options_of_change(0.1);
  const auto surface = std::make_shared<const Surface>(bumpy_wall());
  MadeZones made = make_zones(surface, options, nullptr);
  const auto same = std::make_shared<const Surface>(*surface);
  const MadeZones again = make_zones(same, options, made.zones.get());
  CHECK_FALSE(again.mesh);
  REQUIRE(again.zones->batches.size() == 1);
  CHECK(again.zones->batches[0].number == made.zones->batches[0].number);
  CHECK(again.zones->batches[0].sources == made.zones->batches[0].sources);
  // Another width, and a surface with cells that were joined, are laid out whole.
  ZoneOptions wide = options;
  wide.border_width = 0.2;
  CHECK(make_zones(same, wide, made.zones.get()).mesh->faces.size() == surface->mesh.faces.size());
  ZoneOptions joining = options;
  for (std::uint32_t cell = 0; cell < surface->cells.cells.size(); ++cell) joining.stands_for.push_back(cell / 2 * 2);
  const MadeZones joined_cells = make_zones(same, joining, made.zones.get());
  CHECK(joined_cells.mesh->faces.size() == surface->mesh.faces.size());
  CHECK(make_zones(same, options, joined_cells.zones.get()).mesh->faces.size() == surface->mesh.faces.size());
}

// Turns and shifts the wall a little, and bends it by a part of a unit.
Surface bent_wall(Surface surface) {
  for (glm::vec3& position : surface.mesh.positions) {
    const float bend = 0.3F * std::sin(0.4F * position.x);
    position = {position.x - 0.1F * position.y + 7, position.y + 0.1F * position.x - 3, position.z + 11 + bend};
  }
  surface.cells = measure_cells(surface.mesh, surface.cells.cell_of_face, surface.cells.size);
  return surface;
}

TEST_CASE("a surface that differs in the places of its vertices alone is drawn by the batches that are there") {
  const ZoneOptions options = options_of_change(0.1);
  const auto wall = std::make_shared<const Surface>(bumpy_wall());
  const MadeZones made = make_zones(wall, options, nullptr);
  REQUIRE(made.mesh);
  const auto bent = std::make_shared<const Surface>(bent_wall(*wall));
  const std::shared_ptr<const DrawnZones> moved = moved_zones(bent, 0.1, *made.zones);
  REQUIRE(moved);
  CHECK(moved->surface == bent);
  REQUIRE(moved->batches.size() == 1);
  CHECK(moved->batches[0].number == made.zones->batches[0].number);
  CHECK(moved->cells.cell == made.zones->cells.cell);
  const std::vector<glm::vec3> positions = copied_positions(bent->mesh, moved->batches[0]);
  REQUIRE(positions.size() == made.mesh->positions.size());
  for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
    CHECK(positions[vertex] == bent->mesh.positions[moved->batches[0].sources[vertex]]);
    CHECK(made.mesh->positions[vertex] == wall->mesh.positions[moved->batches[0].sources[vertex]]);
  }
  // All faces in view are drawn, and few others.
  const std::vector<glm::uvec3>& faces = made.mesh->faces;
  std::mt19937 random(17);
  std::size_t drawn = 0;
  for (int picture = 0; picture < 20; ++picture) {
    Camera camera = centered_camera(100, 100, 100);
    camera.cam_from_world_translation = -glm::dvec3(positions[random() % positions.size()]) + glm::dvec3(0, 0, 4);
    std::vector<int> is_drawn(faces.size(), 0);
    for (const auto& of_shader : moved->in_view(camera)) {
      for (const auto& [batch, run] : of_shader) {
        for (std::uint32_t face = run.first; face < run.first + run.count; ++face) is_drawn.at(face) = 1;
        drawn += run.count;
      }
    }
    std::size_t missing = 0;
    for (std::size_t face = 0; face < faces.size(); ++face) {
      const glm::dvec3 cam = camera.cam_from_world(glm::dvec3(positions[faces[face].x]));
      const glm::dvec2 at = camera.image_from_cam(cam);
      const bool in_image = cam.z > 0 && at.x >= 0 && at.y >= 0 && at.x < 100 && at.y < 100;
      missing += in_image && is_drawn[face] == 0 ? 1 : 0;
    }
    CHECK(missing == 0);
  }
  CHECK(drawn > 0);
  CHECK(drawn < 20 * faces.size() / 2);
  for (const Ball& ball : moved->balls) CHECK(ball.radius < 3);
  // The next surface is laid out whole: its shares do not rest on those of this one.
  const auto next = std::make_shared<const Surface>(*bent);
  const MadeZones whole = make_zones(next, options, moved.get());
  REQUIRE(whole.mesh);
  CHECK(whole.mesh->faces.size() == next->mesh.faces.size());
}

TEST_CASE("batches are not moved to a surface of other faces, cells or width, or under joined cells") {
  const ZoneOptions options = options_of_change(0.1);
  const auto wall = std::make_shared<const Surface>(bumpy_wall());
  const MadeZones made = make_zones(wall, options, nullptr);
  Surface bent = bent_wall(*wall);
  CHECK_FALSE(moved_zones(std::make_shared<const Surface>(bent), 0.2, *made.zones));
  Surface turned = bent;
  std::swap(turned.mesh.faces[5].x, turned.mesh.faces[5].y);
  CHECK_FALSE(moved_zones(std::make_shared<const Surface>(turned), 0.1, *made.zones));
  Surface other_cells = bent;
  other_cells.cells.cell_of_face[7] = CellId((other_cells.cells.cell_of_face[7] + 1) % 100);
  CHECK_FALSE(moved_zones(std::make_shared<const Surface>(other_cells), 0.1, *made.zones));
  ZoneOptions joining = options;
  joining.stands_for.assign(wall->cells.cells.size(), 0);
  const MadeZones joined_cells = make_zones(wall, joining, nullptr);
  CHECK_FALSE(moved_zones(std::make_shared<const Surface>(bent), 0.1, *joined_cells.zones));
}

// Returns the references of a zone's cells, each view once, in the order in which cells refer to them.
std::vector<std::uint32_t> merged_in_order(const CellShares::Zone& cells, const ReferenceTable& references) {
  std::vector<std::uint32_t> merged;
  for (std::size_t i = 0; i < cells.size() && cells.at(i) != CellId::none; ++i) {
    for (const ViewSlot slot : references.of_cell(cells.at(i))) {
      const auto same = std::find_if(merged.begin(), merged.end(), [&](auto entry) { return slot_of(entry) == slot; });
      if (same == merged.end()) {
        merged.push_back(slot | 1U << (28 + i));
      } else {
        *same |= 1U << (28 + i);
      }
    }
  }
  return merged;
}

TEST_CASE("a zone lists each view once that its cells refer to, with the cells that do") {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
    const std::uint32_t cells = 1 + below(20), slots = 1 + below(30);
    ReferenceTable references;
    for (std::uint32_t cell = 0; cell < cells; ++cell) {
      for (std::uint32_t slot = 0; slot < slots; ++slot) {
        if (below(3) == 0) references.views.emplace_back(slots - 1 - slot);
      }
      references.offsets.push_back(static_cast<std::uint32_t>(references.views.size()));
    }
    ZoneCells zones;
    for (int i = 0; i < 50; ++i) {
      std::vector<CellId> of_zone;
      for (std::uint32_t cell = 0; cell < cells && of_zone.size() < kCellsPerZone; ++cell) {
        if (below(cells) < 4) of_zone.emplace_back(cell);
      }
      if (of_zone.empty()) of_zone.emplace_back(below(cells));
      CellShares::Zone& zone = zones.combinations.emplace_back();
      std::copy(of_zone.begin(), of_zone.end(), zone.begin());
      zones.cell.push_back(of_zone.front());
      zones.combination.push_back(static_cast<std::uint32_t>(i));
    }
    const ZoneReferences lists = zone_references(zones, references, std::vector<std::uint8_t>(cells, 1), {});
    for (std::size_t i = 0; i < zones.combinations.size(); ++i) {
      const std::vector<std::uint32_t> listed(lists.references.begin() + lists.ranges[i].x,
                                              lists.references.begin() + lists.ranges[i].y);
      CHECK(listed == merged_in_order(zones.combinations[i], references));
    }
  }
  ReferenceTable nothing;
  nothing.offsets.push_back(0);
  const ZoneReferences lists = zone_references({{0}, {0}, {{0}}}, nothing, {1}, {});
  CHECK(lists.references.empty());
}

TEST_CASE("each combination of cells ranks a list of its own, also where one cell stands for those of several chunks") {
  const auto surface = std::make_shared<const Surface>(bumpy_wall());
  const std::size_t cells = surface->cells.cells.size();
  ZoneOptions joining;
  joining.border_width = 0.1;
  joining.stands_for.assign(cells, 0);
  const MadeZones made = make_zones(surface, joining, nullptr);
  REQUIRE(made.zones->chunks.size() > 1);
  ReferenceTable references;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    references.views.insert(references.views.end(), {ViewSlot(2), ViewSlot(5)});
    references.offsets.push_back(static_cast<std::uint32_t>(references.views.size()));
  }
  const ZoneReferences lists = zone_references(made.zones->cells, references, std::vector<std::uint8_t>(cells, 1), {});
  REQUIRE(lists.ranges.size() == made.zones->balls.size());
  REQUIRE(lists.ranges.size() > 1);
  std::vector<bool> is_taken(lists.references.size(), false);
  for (const glm::uvec2& range : lists.ranges) {
    REQUIRE(range.y == range.x + 2);
    CHECK(slot_of(lists.references[range.x]) == 2);
    CHECK(slot_of(lists.references[range.x + 1]) == 5);
    for (std::uint32_t i = range.x; i < range.y; ++i) {
      CHECK_FALSE(is_taken[i]);
      is_taken[i] = true;
    }
  }
}

}  // namespace
}  // namespace lumatlas
