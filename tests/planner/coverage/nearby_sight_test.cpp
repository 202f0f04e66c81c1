// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/nearby_sight.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

// Shares of the pixels at which rays of the camera hit the surface.
struct Agreement {
  double found = 0;       // that have a depth,
  double same_depth = 0;  // within a thousandth,
  double same_cell = 0;   // and that show the same cell
};

Agreement with_rays(const VisibilityBuffer& seen, const VisibilityBuffer& traced, const Cells& cells) {
  Agreement agreement;
  double hits = 0;
  for (std::size_t pixel = 0; pixel < traced.depth.size(); ++pixel) {
    if (!std::isfinite(traced.depth[pixel])) continue;
    ++hits;
    if (!std::isfinite(seen.depth[pixel])) continue;
    agreement.found += 1;
    agreement.same_depth += std::abs(seen.depth[pixel] - traced.depth[pixel]) < 1e-3f * traced.depth[pixel];
    agreement.same_cell += cells.cell_of_face[seen.face[pixel]] == cells.cell_of_face[traced.face[pixel]];
  }
  return {agreement.found / hits, agreement.same_depth / hits, agreement.same_cell / hits};
}

StoredView flat_view(const Camera& camera, const VisibilityBuffer& visible) {
  Photograph photograph{camera.width, camera.height, {}, {}};
  photograph.rgb.assign(3 * visible.depth.size(), 128);
  return make_stored_view("view", camera, std::move(photograph), visible, {});
}

VisibilityBuffer seen_from(const Camera& stored, const VisibilityBuffer& visible, const Cells& cells,
                           const Camera& camera) {
  const std::vector<SeenFaces> runs = seen_faces(visible.face, cells.cell_of_face);
  return seen_nearby(flat_view(stored, visible), FaceLookup(runs, stored.width, stored.height), camera);
}

TEST_CASE("what a stored view sees in another size is what rays find", "[nearby sight]") {
  const Relief relief;
  const Camera camera = camera_on_arc(12);
  const VisibilityBuffer visible = relief.visibility->trace(camera);
  for (const std::uint32_t side : {240u, 171u, 90u, 7u}) {
    CAPTURE(side);
    const Camera small = camera.shrunk_to(side);
    const VisibilityBuffer seen = seen_from(camera, visible, relief.surface->cells, small);
    CHECK(seen.width == small.width);
    CHECK(seen.height == small.height);
    const Agreement agreement = with_rays(seen, relief.visibility->trace(small), relief.surface->cells);
    CHECK(agreement.found > 0.99);
    CHECK(agreement.same_depth > 0.99);
    CHECK(agreement.same_cell > 0.93);  // a cell's border is within a pixel of many
  }
}

TEST_CASE("what a camera some pixels away sees is what rays find, except at the image's border", "[nearby sight]") {
  const Relief relief;
  const Camera camera = camera_on_arc(-8);
  const VisibilityBuffer visible = relief.visibility->trace(camera);
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    CAPTURE(seed);
    const Camera near = disturbed(camera, 4, seed, relief.points(camera, 8, 6)).shrunk_to(171);
    const VisibilityBuffer seen = seen_from(camera, visible, relief.surface->cells, near);
    const Agreement agreement = with_rays(seen, relief.visibility->trace(near), relief.surface->cells);
    CHECK(agreement.found > 0.92);  // up to 3 of 128 rows and of 171 columns are beyond the view's picture
    CHECK(agreement.same_depth > 0.985 * agreement.found);
    CHECK(agreement.same_cell > 0.93 * agreement.found);
  }
}

TEST_CASE("between two surfaces there is none", "[nearby sight]") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(120, 120);
  const VisibilityBuffer visible = make_ray_visibility(surface->mesh)->trace(camera);
  std::size_t on_panel = 0, on_wall = 0, beside = 0, between = 0;
  const VisibilityBuffer seen = seen_from(camera, visible, surface->cells, forward_camera(97, 97, {0.05, -0.03, 0}));
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel) {
    const float z = seen.depth[pixel];
    if (!std::isfinite(z)) {
      CHECK(seen.face[pixel] == FaceId::none);
      ++beside;
    } else if (std::abs(z - 2) < 1e-4f) {
      ++on_panel;
    } else if (std::abs(z - 4) < 1e-4f) {
      ++on_wall;
    } else {
      ++between;
    }
  }
  // The panel is a quarter of the picture's width; the wall fills it.
  CHECK(on_panel > 500);
  CHECK(on_panel < 680);
  CHECK(on_wall > 8000);
  CHECK(beside < 300);  // a column and a row or two at the border
  CHECK(between == 0);
}

TEST_CASE("a view's faces by runs are those of its pixels, or others of the same cell", "[nearby sight]") {
  const std::vector<CellId> cell_of_face = {0, 0, 1, 1, 2};
  const std::vector<FaceId> face = {0, 1, 2, FaceId::none, FaceId::none, FaceId::none, FaceId::none, FaceId::none, 4,
                                    4, 3, 0};
  const std::vector<FaceId> of_cells = {
      0, 0, 2, FaceId::none, FaceId::none, FaceId::none, FaceId::none, FaceId::none, 4, 4, 3, 0};
  const std::vector<SeenFaces> runs = seen_faces(face, cell_of_face);
  CHECK(runs.size() == 6);
  CHECK(faces_of(runs) == of_cells);
  for (const std::uint32_t width : {1u, 2u, 3u, 4u, 12u}) {
    CAPTURE(width);
    const FaceLookup lookup(runs, width, 12 / width);
    for (std::size_t pixel = 0; pixel < face.size(); ++pixel) CHECK(lookup.at(pixel) == of_cells[pixel]);
  }
  CHECK_THROWS_WITH(FaceLookup(runs, 11, 1),
                    "seen faces: the size of runs is 12, must be the number of the image's pixels, 11");
}

}  // namespace
}  // namespace lumatlas
