// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/halfedge_mesh.h"
#include "tests/tools/live/room_stream.h"

namespace lumatlas {
namespace {

TEST_CASE("a live surface keeps the cells that later frames do not see") {
  LiveSurface surface(room_live_options().surface);
  CHECK_FALSE(surface.grow());
  CHECK(surface.usual_distance() == 0);
  std::shared_ptr<const Surface> before;
  std::size_t kept = 0;
  for (std::size_t number = 0; number < 12; ++number) {
    REQUIRE(surface.add(room_depth(room_camera(number))));
    const std::optional<GrownSurface> grown = surface.grow();
    REQUIRE(grown);
    CHECK_NOTHROW(check(*grown->surface));
    const auto& cells = grown->surface->cells.cells;
    REQUIRE(grown->previous_cell.size() == cells.size());
    for (CellId cell{0}; cell < cells.size(); ++cell) {
      if (grown->changed[cell] != 0) continue;
      ++kept;
      REQUIRE(before);
      const Cell& old = before->cells.cells[grown->previous_cell[cell]];
      CHECK(old.centroid == cells[cell].centroid);
      CHECK(old.faces == cells[cell].faces);
    }
    before = grown->surface;
  }
  CHECK(kept > 20);
  CHECK(surface.usual_distance() > 0.5);
  CHECK(surface.usual_distance() < 5);
}

TEST_CASE("a live surface takes nothing of a frame that measured nothing or for which there is no room") {
  LiveSurfaceOptions options;
  LiveSurface blind(options);
  DepthImage empty = room_depth(room_camera(0));
  std::fill(empty.depth.begin(), empty.depth.end(), 0.0F);
  CHECK_FALSE(blind.add(empty));
  CHECK_FALSE(blind.grow());
  options.max_blocks = 1;
  LiveSurface small(options);
  CHECK_FALSE(small.add(room_depth(room_camera(0))));
  CHECK_FALSE(small.grow());
  options.cell_size = -1;
  CHECK_THROWS_WITH(LiveSurface(options), Catch::Contains("cell_size is -1"));
}

TEST_CASE("a live surface follows frames that move, the farthest first, and back again to the bit") {
  LiveSurface surface(room_live_options().surface);
  const auto name = [](std::size_t number) { return room_view(number); };
  const auto drifted = [](std::size_t number) {
    Camera camera = room_camera(number);
    camera.cam_from_world_translation += 0.02 * static_cast<double>(number) * glm::dvec3(1, 0.5, -1);
    return camera;
  };
  constexpr std::size_t kFrames = 8;
  for (std::size_t number = 0; number < kFrames; ++number) {
    REQUIRE(surface.add(room_depth(room_camera(number)), name(number)));
  }
  const auto shown = [&] {
    const std::optional<GrownSurface> grown = surface.grow(GrowingFusion::Show::everything);
    REQUIRE(grown);
    CHECK_NOTHROW(check(*grown->surface));
    return grown->surface->mesh;
  };
  const Mesh before = shown();
  CHECK_FALSE(surface.follow_move());
  for (std::size_t number = 0; number < kFrames; ++number) surface.move(name(number), drifted(number));
  surface.move("another", drifted(1));
  CHECK(surface.moved() == kFrames);
  std::size_t followed = 0;
  while (surface.follow_move()) ++followed;
  CHECK(followed == kFrames - 1);  // the first frame's pose has not changed
  CHECK(surface.moved() == 0);
  CHECK_FALSE(shown().positions == before.positions);
  for (std::size_t number = 0; number < kFrames; ++number) surface.move(name(number), room_camera(number));
  while (surface.follow_move()) {
  }
  const Mesh after = shown();
  CHECK(after.positions == before.positions);
  CHECK(after.faces == before.faces);
}

TEST_CASE("a live surface bends as its frames have moved, and then becomes what they show at their poses") {
  LiveSurface surface(room_live_options().surface);
  constexpr std::size_t kFrames = 8;
  const auto moved = [](std::size_t number) {  // the whole scene, which no frame tells from a move of its own
    Camera camera = room_camera(number);
    camera.cam_from_world_translation += camera.cam_from_world_rotation * glm::dvec3(-0.5, 0.25, 1);
    return camera;
  };
  CHECK_FALSE(surface.bend());
  for (std::size_t number = 0; number < kFrames; ++number) {
    REQUIRE(surface.add(room_depth(room_camera(number)), room_view(number)));
  }
  CHECK_FALSE(surface.bend());  // there is no version
  const std::optional<GrownSurface> first = surface.grow();
  REQUIRE(first);
  CHECK_FALSE(surface.bend());  // nothing has moved
  for (std::size_t number = 0; number < kFrames; ++number) surface.move(room_view(number), moved(number));
  CHECK(surface.has_doubles());
  const std::optional<GrownSurface> bent = surface.bend();
  REQUIRE(bent);
  CHECK_NOTHROW(check(*bent->surface));
  const Mesh &before = first->surface->mesh, &after = bent->surface->mesh;
  CHECK(after.faces == before.faces);
  CHECK(bent->surface->cells.cell_of_face == first->surface->cells.cell_of_face);
  double farthest = 0;
  for (std::size_t vertex = 0; vertex < after.positions.size(); ++vertex) {
    const glm::vec3 off = after.positions[vertex] - before.positions[vertex] - glm::vec3(0.5F, -0.25F, -1);
    farthest = std::max<double>(farthest, glm::length(off));
  }
  CHECK(farthest < 1e-5);
  CHECK_FALSE(surface.bend());  // it is where its frames are
  while (surface.follow_move()) {
  }
  CHECK_FALSE(surface.has_doubles());
  const std::optional<GrownSurface> followed = surface.grow(GrowingFusion::Show::everything);
  REQUIRE(followed);
  LiveSurface fresh(room_live_options().surface);
  for (std::size_t number = 0; number < kFrames; ++number) {
    REQUIRE(fresh.add({moved(number), room_depth(room_camera(number)).depth}));
  }
  const std::optional<GrownSurface> at_once = fresh.grow(GrowingFusion::Show::everything);
  REQUIRE(at_once);
  CHECK(followed->surface->mesh.positions == at_once->surface->mesh.positions);
  CHECK(followed->surface->mesh.faces == at_once->surface->mesh.faces);
  // Frames that come after a bend, and moves that come before all have followed, count from what is shown.
  for (std::size_t number = 0; number < kFrames; ++number) surface.move(room_view(number), room_camera(number));
  REQUIRE(surface.follow_move());
  const std::optional<GrownSurface> back = surface.bend();
  REQUIRE(back);
  for (std::size_t number = 0; number < kFrames; ++number) surface.move(room_view(number), moved(number));
  const std::optional<GrownSurface> again = surface.bend();
  REQUIRE(again);
  farthest = 0;
  for (std::size_t vertex = 0; vertex < again->surface->mesh.positions.size(); ++vertex) {
    const glm::vec3 off = again->surface->mesh.positions[vertex] - followed->surface->mesh.positions[vertex];
    farthest = std::max<double>(farthest, glm::length(off));
  }
  CHECK(farthest < 1e-5);
}

TEST_CASE("of many frames those that have moved bend a live surface") {
  LiveSurface surface(room_live_options().surface);
  constexpr std::size_t kFrames = 450, kMoved = 3;
  for (std::size_t number = 0; number < kFrames; ++number) {
    REQUIRE(surface.add(room_depth(room_camera(number % 8)), room_view(number)));
  }
  const std::optional<GrownSurface> first = surface.grow();
  REQUIRE(first);
  for (std::size_t number = kFrames - kMoved; number < kFrames; ++number) {
    Camera camera = room_camera(number % 8);
    camera.cam_from_world_translation.x += 2;
    surface.move(room_view(number), camera);
  }
  const std::optional<GrownSurface> bent = surface.bend();
  REQUIRE(bent);
  CHECK_FALSE(bent->surface->mesh.positions == first->surface->mesh.positions);
  // Moves that are too small each to be shown count together.
  const auto nudge = [&](double times) {
    for (std::size_t number = 0; number < kFrames; ++number) {
      Camera camera = room_camera(number % 8);
      camera.cam_from_world_translation.y += times * 0.1 * *room_live_options().surface.voxel;
      if (number >= kFrames - kMoved) camera.cam_from_world_translation.x += 2;
      surface.move(room_view(number), camera);
    }
    return surface.bend();
  };
  CHECK_FALSE(nudge(1));
  CHECK_FALSE(nudge(2));
  CHECK(nudge(3));
}

TEST_CASE("a live surface whose frames move out of all bounds does not bend") {
  LiveSurface surface(room_live_options().surface);
  REQUIRE(surface.add(room_depth(room_camera(0)), "a"));
  REQUIRE(surface.grow());
  Camera far = room_camera(0);
  far.cam_from_world_translation.x = 1e30;
  surface.move("a", far);
  CHECK_FALSE(surface.bend());
}

// Counts the edges of one face alone.
std::size_t rim_edges(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) edges.emplace(face[corner], face[(corner + 1) % 3]);
  }
  return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [&](const auto& edge) {
    return !edges.contains({edge.second, edge.first});
  }));
}

TEST_CASE("a live surface of pieces is their join, and keeps the cells of pieces that stay") {
  LiveSurface surface(room_live_options().surface);
  std::size_t faces = 0;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const TriangleSoup piece = room_piece(octant);
    REQUIRE(!piece.faces.empty());
    faces += piece.faces.size();
    surface.replace_piece(10 * octant, piece);
  }
  REQUIRE(faces == room_surface()->mesh.faces.size());
  CHECK_FALSE(surface.grow());  // nothing says yet how large cells are to be
  Camera outside = room_camera(0);
  outside.cam_from_world_translation.z -= 1000;
  CHECK_FALSE(surface.find_distance({{outside}}));
  REQUIRE(surface.find_distance({{room_camera(0)}}));
  CHECK(surface.usual_distance() > 0.5);
  CHECK(surface.usual_distance() < 5);
  const std::optional<GrownSurface> whole = surface.grow();
  REQUIRE(whole);
  CHECK_NOTHROW(check(*whole->surface));
  // Pieces meet in their vertices, so that the join has no rim where the room has none.
  CHECK(rim_edges(whole->surface->mesh) == rim_edges(room_surface()->mesh));
  const VisibilityBuffer seen = whole->visibility->trace(room_camera(3));
  const VisibilityBuffer room = make_ray_visibility(room_surface()->mesh)->trace(room_camera(3));
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel) {
    if (std::isfinite(room.depth[pixel])) CHECK(std::abs(seen.depth[pixel] - room.depth[pixel]) < 1e-3F);
  }

  surface.replace_piece(70, {});  // goes
  const std::optional<GrownSurface> less = surface.grow();
  REQUIRE(less);
  CHECK(less->surface->mesh.faces.size() < whole->surface->mesh.faces.size());
  const auto stay = std::count(less->changed.begin(), less->changed.end(), 0);
  CHECK(2 * static_cast<std::size_t>(stay) > less->changed.size());
  TriangleSoup moved = room_piece(0);
  for (glm::dvec3& position : moved.positions) position.z -= 0.25;
  surface.replace_piece(0, moved);
  const std::optional<GrownSurface> other = surface.grow();
  REQUIRE(other);
  double lowest = 0;
  for (const glm::vec3& position : other->surface->mesh.positions) lowest = std::min<double>(lowest, position.z);
  CHECK(lowest == -0.25);
  CHECK(std::count(other->changed.begin(), other->changed.end(), 0) > 0);
  for (std::uint32_t octant = 0; octant < 7; ++octant) surface.replace_piece(10 * octant, {});
  CHECK_FALSE(surface.grow());
}

TEST_CASE("versions that follow each other end in the surface that is made at once, to the bit") {
  LiveSurface growing(room_live_options().surface), at_once(room_live_options().surface);
  for (std::size_t number = 0; number < 10; ++number) {
    REQUIRE(growing.add(room_depth(room_camera(number)), room_view(number)));
    REQUIRE(at_once.add(room_depth(room_camera(number))));
    REQUIRE(growing.grow());
    if (number < 5) continue;  // a frame goes away and comes back
    Camera moved = room_camera(number - 3);
    moved.cam_from_world_translation += glm::dvec3(0.05, 0.1, -0.05);
    growing.move(room_view(number - 3), moved);
    REQUIRE(growing.follow_move());
    REQUIRE(growing.grow());
    growing.move(room_view(number - 3), room_camera(number - 3));
    REQUIRE(growing.follow_move());
  }
  const std::optional<GrownSurface> whole = at_once.grow(GrowingFusion::Show::everything);
  const std::optional<GrownSurface> grown = growing.grow(GrowingFusion::Show::everything);
  REQUIRE((whole && grown));
  CHECK(grown->surface->mesh.positions == whole->surface->mesh.positions);
  CHECK(grown->surface->mesh.faces == whole->surface->mesh.faces);
  const std::optional<GrownSurface> same = growing.grow(GrowingFusion::Show::everything);
  REQUIRE(same);
  CHECK(same->surface->mesh.positions == whole->surface->mesh.positions);
  CHECK(std::count(same->changed.begin(), same->changed.end(), 1) == 0);
}

TEST_CASE("pieces that come, change and go end in the surface of those that are left, to the bit") {
  LiveSurface growing(room_live_options().surface), at_once(room_live_options().surface);
  for (std::uint32_t octant = 0; octant < 8; ++octant) growing.replace_piece(octant, room_piece(octant));
  REQUIRE(growing.find_distance({{room_camera(0)}}));
  REQUIRE(growing.grow());
  TriangleSoup dented = room_piece(3);
  dented.positions[dented.faces.front().x].z += 0.02;
  growing.replace_piece(3, dented);
  growing.replace_piece(5, {});
  const std::optional<GrownSurface> other = growing.grow();
  REQUIRE(other);
  CHECK(std::count(other->changed.begin(), other->changed.end(), 0) > 0);
  CHECK(std::count(other->changed.begin(), other->changed.end(), 1) > 0);
  growing.replace_piece(3, room_piece(3));
  growing.replace_piece(5, room_piece(5));
  growing.replace_piece(9, room_piece(1));  // the same faces twice
  const std::optional<GrownSurface> twice = growing.grow();
  REQUIRE(twice);
  growing.replace_piece(9, {});
  growing.replace_piece(2, room_piece(2));
  const std::optional<GrownSurface> grown = growing.grow();
  REQUIRE(grown);
  CHECK(std::count(grown->changed.begin(), grown->changed.end(), 1) == 0);  // nothing is another face than before
  for (std::uint32_t octant = 0; octant < 8; ++octant) at_once.replace_piece(octant, room_piece(octant));
  REQUIRE(at_once.find_distance({{room_camera(0)}}));
  const std::optional<GrownSurface> whole = at_once.grow();
  REQUIRE(whole);
  CHECK(grown->surface->mesh.positions == whole->surface->mesh.positions);
  CHECK(grown->surface->mesh.faces == whole->surface->mesh.faces);
  CHECK(twice->surface->mesh.faces == whole->surface->mesh.faces);
}

// A triangle that looks up, with its right angle in the origin.
TriangleSoup triangle(double width, double depth) {
  return {{{0, 0, 0}, {width, 0, 0}, {0, depth, 0}}, {}, {{0, 1, 2}}};
}

TEST_CASE("pieces that are too large for their cells make no surface, and the one before stays") {
  LiveSurfaceOptions options;
  options.cell_size = 0.125;
  options.max_piece_faces = 20'000;
  LiveSurface surface(options);
  surface.replace_piece(0, triangle(8, 8));
  Camera above = room_camera(0);
  above.cam_from_world_rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  above.cam_from_world_translation = glm::dvec3(-2, 2, 2);  // at (2, 2, 2), and looks down
  REQUIRE(surface.find_distance({{above}}));
  CHECK(surface.usual_distance() == Approx(2));
  const std::optional<GrownSurface> before = surface.grow();
  REQUIRE(before);
  const std::size_t faces = before->surface->mesh.faces.size();
  CHECK(static_cast<double>(faces) > 32 / (std::sqrt(3.0) / 4 * 0.125 * 0.125));
  CHECK(faces < 20'000);
  surface.replace_piece(1, triangle(20'000, 20'000));
  CHECK_THROWS_AS(surface.grow(), InputError);
  CHECK_THROWS_WITH(surface.grow(), Catch::Contains("too large for cells of 0.125 units: they would become 2.95"));
  surface.replace_piece(1, triangle(1e9, 1e9));  // floats there are farther apart than a cell is wide
  CHECK_THROWS_AS(surface.grow(), InputError);
  surface.replace_piece(1, triangle(20'000, 1e-3));  // a needle, which is not split
  const std::optional<GrownSurface> with_needle = surface.grow();
  REQUIRE(with_needle);
  CHECK_NOTHROW(check(*with_needle->surface));
  surface.replace_piece(1, {});
  const std::optional<GrownSurface> after = surface.grow();
  REQUIRE(after);
  CHECK(after->surface->mesh.faces.size() == faces);
  // What failed has not become the version that the next is compared with.
  CHECK(std::count(after->changed.begin(), after->changed.end(), 0) == std::ssize(after->changed));
}

TEST_CASE("a piece whose positions are too coarse for its cells makes no surface") {
  LiveSurfaceOptions options;
  options.cell_size = 0.01;
  LiveSurface surface(options);
  TriangleSoup far = triangle(1, 1);
  for (glm::dvec3& position : far.positions) position.x += 1e6;
  surface.replace_piece(0, far);
  surface.guess_distance();
  CHECK_THROWS_AS(surface.grow(), InputError);
  CHECK_THROWS_WITH(surface.grow(), Catch::Contains("the resolution of the positions"));
}

TEST_CASE("a live surface refuses pieces that are none, and pieces beside depth frames") {
  LiveSurface of_pieces(room_live_options().surface);
  TriangleSoup bad{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {{0, 1, 3}}};
  CHECK_THROWS_WITH(of_pieces.replace_piece(0, bad), Catch::Contains("refers to no vertex"));
  bad.faces = {{0, 1, 2}};
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e30}) {
    bad.positions[1].y = wrong;
    CHECK_THROWS_WITH(of_pieces.replace_piece(0, bad), Catch::Contains("not finite or too far"));
  }
  bad.positions[1].y = 0;
  bad.colors.resize(3);
  CHECK_THROWS_WITH(of_pieces.replace_piece(0, bad), Catch::Contains("has colours"));
  bad.colors.clear();
  of_pieces.replace_piece(0, bad);
  CHECK_THROWS_AS(of_pieces.add(room_depth(room_camera(0))), std::logic_error);
  bad.positions[2] = {2, 0, 0};  // a piece without area is no surface
  of_pieces.replace_piece(0, bad);
  of_pieces.guess_distance();
  CHECK(of_pieces.usual_distance() == 1);
  CHECK_THROWS_AS(of_pieces.grow(), InputError);
  LiveSurface of_depths(room_live_options().surface);
  REQUIRE(of_depths.add(room_depth(room_camera(0))));
  CHECK_THROWS_AS(of_depths.replace_piece(0, room_piece(0)), std::logic_error);
}

}  // namespace
}  // namespace lumatlas
