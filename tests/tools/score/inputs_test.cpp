// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <stdexcept>

#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tools/base/progress.h"
#include "tools/score/unbounded.h"

namespace lumatlas {
namespace {

TEST_CASE("a baseline of all views needs a surface that is whole, and ranks of views that there are") {
  Progress progress("drawing", 0);
  const ValidityOptions options;
  CHECK_THROWS_WITH(unbounded_lumigraph(nullptr, {}, {}, options, progress), Catch::Contains("surface is null"));
  auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 2, 2, 1, 4);
  CHECK_THROWS_WITH(unbounded_lumigraph(surface, {}, {}, options, progress), Catch::Contains("cell_of_face"));
  surface->cells = measure_cells(surface->mesh, std::vector<CellId>(surface->mesh.faces.size(), 0), 5);
  CHECK_THROWS_WITH(unbounded_lumigraph(surface, {}, {0}, options, progress), Catch::Contains("a rank is 0"));
}

TEST_CASE("views back at their given poses are trusted as they were, so that masks count as no moved pose") {
  const ValidityOptions options;
  Snapshot model = room_snapshot(3, options);
  const auto visibility = make_ray_visibility(model.surface->mesh);
  std::vector<SceneView> given(3);
  for (std::size_t slot = 0; slot < 3; ++slot) {
    given[slot].name = model.views[slot]->name;
    given[slot].camera = model.views[slot]->camera;
  }
  CHECK_FALSE(with_given_poses(model, given, *visibility, options));
  const StoredView& stored = *model.views[1];
  std::vector<std::uint8_t> trust(stored.mask->depth.size(), 255);
  std::fill_n(trust.begin(), trust.size() / 2, std::uint8_t{0});
  Camera refined = stored.camera;
  refined.cam_from_world_translation.x += 0.01;
  model.views[1] = std::make_shared<const StoredView>(
      make_stored_view(stored.name, refined, stored.photograph, visibility->trace(refined), options, trust));
  const std::optional<Snapshot> unmoved = with_given_poses(model, given, *visibility, options);
  REQUIRE(unmoved);
  const StoredView& back = *unmoved->views[1];
  CHECK(same_pose(back.camera, given[1].camera));
  CHECK(back.mask->trust == trust);
  const StoredView expected = make_stored_view(stored.name, given[1].camera, back.photograph,
                                               visibility->trace(given[1].camera), options, trust);
  CHECK(back.mask->validity == expected.mask->validity);
  CHECK(unmoved->views[0] == model.views[0]);  // was not moved
}

}  // namespace
}  // namespace lumatlas
