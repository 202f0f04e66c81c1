// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/tiles.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <glm/glm.hpp>
#include <optional>

#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("tiles cover every pixel once, and see it where the whole image does") {
  const Camera camera = room_camera(3).scaled_to(97, 41);
  for (const std::uint32_t side : {1u, 10u, 41u, 96u, 97u, 4096u}) {
    CAPTURE(side);
    std::vector<int> covered(97 * 41, 0);
    for (const Tile& tile : tiles_of(camera, side)) {
      CHECK_NOTHROW(check(tile.camera));
      CHECK(tile.camera.width <= side);
      CHECK(tile.camera.height <= side);
      const glm::dvec2 corner(tile.left, tile.top);
      for (const glm::dvec2 at : {glm::dvec2(0.5, 0.5), glm::dvec2(tile.camera.width, tile.camera.height)}) {
        CHECK(glm::length(tile.camera.ray(at) - camera.ray(corner + at)) < 1e-12);
      }
      for (std::uint32_t y = 0; y < tile.camera.height; ++y) {
        for (std::uint32_t x = 0; x < tile.camera.width; ++x) ++covered[(tile.top + y) * 97 + tile.left + x];
      }
    }
    CHECK(covered == std::vector<int>(97 * 41, 1));
  }
  CHECK(tiles_of(camera, 97).size() == 1);
  CHECK_THROWS_WITH(tiles_of(camera, 0), "tiles: side is 0, must be at least 1");
}

TEST_CASE("a picture in tiles is the picture in one piece") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = exposed_room_snapshot(10);
  Renderer renderer;
  renderer.load(snapshot);
  for (std::size_t number = 0; number < 5; ++number) {
    // No middle of a pixel falls on the edge of one of the stored view at its place, where rounding would decide.
    const Camera camera = room_camera(2 * number + 1).scaled_to(307, 227);
    const Rendering whole = renderer.render(camera, {});
    const LinearRendering linear = renderer.render_linear(camera, {});
    const Diagnosis diagnosis = renderer.diagnose(camera, {});
    for (const std::uint32_t side : {64u, 101u, 299u}) {
      CAPTURE(number, side);
      CHECK(share_different(render_tiled(renderer, camera, {}, side), whole, 1) <= 0.0005);
      const LinearRendering linear_tiles = render_linear_tiled(renderer, camera, {}, side);
      const Diagnosis diagnosed = diagnose_tiled(renderer, camera, {}, side);
      std::size_t different = 0;
      for (std::size_t pixel = 0; pixel < whole.state.size(); ++pixel) {
        different += linear_tiles.state[pixel] != linear.state[pixel] ||
                     std::abs(linear_tiles.rgb[3 * pixel] - linear.rgb[3 * pixel]) > 0.01f ||
                     diagnosed.pixels[pixel].valid_views != diagnosis.pixels[pixel].valid_views ||
                     diagnosed.pixels[pixel].winner != diagnosis.pixels[pixel].winner;
      }
      CHECK(different <= 30);  // of 69689
    }
    CHECK(render_tiled(renderer, camera, {}).picture.rgb == whole.picture.rgb);
  }
}

TEST_CASE("options that cannot be are refused before anything is divided by them") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(room_snapshot(3, {}));
  const Camera camera = room_camera(1);
  BlendOptions options;
  options.supersample = 0;
  const char* const sentence = "blend: supersample is 0, must be in [1, 4]";
  CHECK_THROWS_WITH(render_tiled(renderer, camera, options), sentence);
  CHECK_THROWS_WITH(render_linear_tiled(renderer, camera, options), sentence);
  CHECK_THROWS_WITH(diagnose_tiled(renderer, camera, options), sentence);
  options = {};
  options.sampling = static_cast<BlendOptions::Sampling>(7);
  CHECK_THROWS_WITH(render_tiled(renderer, camera, options), Catch::Contains("sampling is 7"));
  options = {};
  options.position = static_cast<BlendOptions::Position>(2);
  CHECK_THROWS_WITH(check(options), Catch::Contains("position is 2"));
  options = {};
  options.exposure = static_cast<BlendOptions::Exposure>(2);
  CHECK_THROWS_WITH(check(options), Catch::Contains("exposure is 2"));
  options = {};
  options.antialias = static_cast<BlendOptions::Antialias>(2);
  CHECK_THROWS_WITH(check(options), Catch::Contains("antialias is 2"));
}

// A tile's border would show here: the columns on both of its sides differ no more than they do in one piece.
TEST_CASE(
    "where the shifts of the tiles are exact, a picture in tiles is the same but for silhouettes, at borders too") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(room_snapshot(10, {}));
  Camera camera = room_camera(4).scaled_to(256, 192);
  camera.cx = 128;
  camera.cy = 96;
  const Rendering whole = renderer.render(camera, {});
  const Rendering tiled = render_tiled(renderer, camera, {}, 64);
  CHECK(share_different(tiled, whole, 0) <= 0.01);
  CHECK(share_different(tiled, whole, 1) <= 0.0005);
}

}  // namespace
}  // namespace lumatlas
