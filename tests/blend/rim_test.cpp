// SPDX-License-Identifier: GPL-3.0-or-later
// Rims of what stands in front: shown from about where the photograph was taken, and not from elsewhere.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <optional>

#include "blend/geometric_weight.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr double kPanelDepth = 4;

// At `degrees` around the panel, looking at its middle.
Camera camera_at(double degrees) {
  Camera camera = forward_camera(40, 40);
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), glm::radians(degrees), glm::dvec3(0, 1, 0)));
  const glm::dvec3 middle(0, 0, kPanelDepth);
  camera.cam_from_world_rotation = turn;
  camera.cam_from_world_translation = middle - turn * middle;
  return camera;
}

// A panel before nothing, 20 x 20 pixels of its one photograph.
Snapshot panel_seen_once(const ValidityOptions& validity) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 1, 1, 2, kPanelDepth);
  surface->cells = measure_cells(surface->mesh, {0, 0}, 2);
  Atlas atlas(surface, 1, kWholeViews);
  const Camera camera = camera_at(0);
  TiledView view =
      make_tiled_view("front.png", camera, position_photograph(40, 40),
                      make_ray_visibility(surface->mesh)->trace(camera), surface->cells, kWholeViews, validity);
  atlas.insert(std::move(view.view), std::move(view.shown));
  atlas.set_references(0, {0});
  return atlas.snapshot();
}

struct Seen {
  std::ptrdiff_t textured = 0, surface = 0;  // pixels
};

Seen seen_in(const Rendering& rendering) {
  const auto count = [&](PixelState state) {
    return std::count(rendering.state.begin(), rendering.state.end(), state);
  };
  return {count(PixelState::textured), std::ssize(rendering.state) - count(PixelState::empty)};
}

void check_rims(const Snapshot& far_side, const Snapshot& both_sides,
                const std::function<Seen(const Snapshot&, double, const BlendOptions&)>& seen_with) {
  BlendOptions options;
  options.sampling = BlendOptions::Sampling::linear;
  const auto seen = [&](const Snapshot& snapshot, double degrees) { return seen_with(snapshot, degrees, options); };
  CHECK(seen(far_side, 0).textured == 20 * 20);
  CHECK(seen(both_sides, 0).textured == 16 * 16);
  for (const double degrees : {5.0, 20.0}) {
    CAPTURE(degrees);
    CHECK(seen(far_side, degrees).textured > seen(both_sides, degrees).textured + 40);
  }
  // The mask of both sides is interpolated, so that it reaches half a pixel into the rim.
  const Seen aside = seen(far_side, 35);
  CHECK(aside.textured > aside.surface / 2);
  CHECK(aside.textured < aside.surface - 40);
  CHECK(aside.textured <= seen(both_sides, 35).textured);
  options.rims = false;
  CHECK(seen(far_side, 0).textured == 16 * 16);
  for (const double degrees : {0.0, 5.0, 20.0, 35.0}) {
    CAPTURE(degrees);
    CHECK(seen(far_side, degrees).textured <= seen(both_sides, degrees).textured);
  }
}

TEST_CASE("a rim counts wholly within 10 degrees and not at all beyond 30") {
  const auto share = [](double degrees, double distance) {
    const glm::dvec3 world(3, -2, 5);
    const double angle = glm::radians(degrees);
    return rim_share(world, world + glm::dvec3(2, 0, 0),
                     world + distance * glm::dvec3(std::cos(angle), std::sin(angle), 0), BlendOptions{});
  };
  CHECK(share(0, 1) == 1);
  CHECK(share(9.9, 7) == 1);
  CHECK(share(30.1, 7) == 0);
  CHECK(share(90, 1) == 0);
  CHECK(share(180, 1) == 0);
  CHECK(share(15, 1) == share(15, 9));
  for (double degrees = 11; degrees < 30; ++degrees) CHECK(share(degrees, 1) < share(degrees - 1, 1));
  CHECK(rim_share({1, 2, 3}, {1, 2, 3}, {0, 0, 0}, BlendOptions{}) == 0);
  CHECK(rim_share({1, 2, 3}, {1, 2, 4}, {1, 2, 5}, BlendOptions::printed()) == 0);
}

TEST_CASE("a rim is shown from about where it was photographed, and from aside it is as if both sides were masked") {
  const ValidityOptions far_side{0.05, 2, 0, ValidityOptions::Edges::far_side};
  const ValidityOptions both_sides{0.05, 2, 0, ValidityOptions::Edges::both_sides};
  const Snapshot far = panel_seen_once(far_side), both = panel_seen_once(both_sides);
  check_rims(far, both, [&](const Snapshot& snapshot, double degrees, const BlendOptions& options) {
    return seen_in(
        render_reference(snapshot, camera_at(degrees), *make_ray_visibility(snapshot.surface->mesh), options));
  });
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  check_rims(far, both, [&](const Snapshot& snapshot, double degrees, const BlendOptions& options) {
    renderer.load(snapshot);
    return seen_in(renderer.render(camera_at(degrees), options));
  });
}

}  // namespace
}  // namespace lumatlas
