// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <stdexcept>

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

}  // namespace
}  // namespace lumatlas
