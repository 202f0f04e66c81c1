// SPDX-License-Identifier: GPL-3.0-or-later
#include <catch2/catch.hpp>
#include <memory>
#include <stdexcept>

#include "tests/support/wall_scenes.h"
#include "tools/base/progress.h"
#include "tools/score/frame_time.h"
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
  surface->cells = measure_cells(surface->mesh, std::vector<std::uint32_t>(surface->mesh.faces.size(), 0), 5);
  CHECK_THROWS_WITH(unbounded_lumigraph(surface, {}, {0}, options, progress), Catch::Contains("a rank is 0"));
}

TEST_CASE("a picture that is timed has pixels") {
  CHECK_THROWS_WITH(cameras_between_views(Snapshot(), 3, {0, 1080}), Catch::Contains("it is 0x1080 pixels"));
  CHECK_THROWS_WITH(cameras_between_views(Snapshot(), 3, {1920, 0}), Catch::Contains("it is 1920x0 pixels"));
  CHECK(cameras_between_views(Snapshot(), 3, {1920, 1080}).empty());
}

}  // namespace
}  // namespace lumatlas
