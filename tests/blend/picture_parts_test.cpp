// SPDX-License-Identifier: GPL-3.0-or-later
// A picture that is drawn in parts is the picture in one piece.
#include "blend/gl/picture_parts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("parts cover each pixel once, with what is around it, at one size") {
  for (const std::uint32_t width : {1u, 63u, 64u, 65u, 300u, 1920u}) {
    for (const std::uint32_t height : {1u, 70u, 641u}) {
      CAPTURE(width, height);
      std::vector<int> covered(std::size_t{width} * height, 0);
      const std::vector<PicturePart> parts = parts_of(width, height, 64);
      for (const auto& [drawn, copied] : parts) {
        CHECK(drawn.width == parts.front().drawn.width);
        CHECK(drawn.height == parts.front().drawn.height);
        CHECK(std::max(copied.width, copied.height) <= 64);
        REQUIRE(drawn.left + drawn.width <= width);
        REQUIRE(drawn.top + drawn.height <= height);
        CHECK((drawn.left == 0 || drawn.left + kAroundPart <= copied.left));
        CHECK((drawn.top == 0 || drawn.top + kAroundPart <= copied.top));
        const std::uint32_t right = copied.left + copied.width, bottom = copied.top + copied.height;
        CHECK(drawn.left + drawn.width >= std::min(width, right + kAroundPart));
        CHECK(drawn.top + drawn.height >= std::min(height, bottom + kAroundPart));
        for (std::uint32_t y = copied.top; y < bottom; ++y) {
          for (std::uint32_t x = copied.left; x < right; ++x) ++covered[std::size_t{y} * width + x];
        }
      }
      CHECK(covered == std::vector<int>(covered.size(), 1));
    }
  }
  CHECK(parts_of(640, 640, 640).size() == 1);
  CHECK(parts_of(641, 640, 640).size() == 2);
}

TEST_CASE("the camera of a part sees each pixel where the picture's does") {
  const Camera camera = room_camera(3).scaled_to(300, 200);
  const Camera part = camera_of_part(camera, {70, 30, 100, 90});
  CHECK_NOTHROW(check(part));
  CHECK(glm::length(part.ray({10.5, 20.5}) - camera.ray({80.5, 50.5})) < 1e-12);
}

TEST_CASE("pictures, linear pictures and diagnoses in parts are those in one piece") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = exposed_room_snapshot(10);
  Renderer whole, parts({.part_px = 64});
  whole.load(snapshot);
  parts.load(snapshot);
  for (std::size_t number = 0; number < 4; ++number) {
    Camera camera = room_camera(2 * number + 1).scaled_to(307, 227);
    camera.cam_from_world_translation += glm::dvec3(0.1, 0.05, -0.1);
    CAPTURE(number);
    const Rendering expected = whole.render(camera, {});
    CHECK(share_different(parts.render(camera, {}), expected, 1) <= 0.0005);
    const LinearRendering linear = whole.render_linear(camera, {}), in_parts = parts.render_linear(camera, {});
    const Diagnosis diagnosis = whole.diagnose(camera, {}), diagnosed = parts.diagnose(camera, {});
    std::size_t different = 0;
    for (std::size_t pixel = 0; pixel < expected.state.size(); ++pixel) {
      different += in_parts.state[pixel] != linear.state[pixel] ||
                   std::abs(in_parts.rgb[3 * pixel] - linear.rgb[3 * pixel]) > 0.01f ||
                   diagnosed.pixels[pixel].winner != diagnosis.pixels[pixel].winner;
    }
    CHECK(different <= 30);  // of 69689
  }
}

TEST_CASE("what a large picture is drawn into takes little more than the picture") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(4, {});
  snapshot.cell_deviation.assign(snapshot.surface->cells.cells.size(), 0.05F);
  Renderer renderer;
  renderer.load(snapshot);
  (void)renderer.render(room_camera(1).scaled_to(1920, 1080), {});
  CHECK(renderer.work().targets < 60'000'000);
  renderer.set_options({.part_px = 4000});
  (void)renderer.render(room_camera(1).scaled_to(1920, 1080), {});
  CHECK(renderer.work().targets == 1920 * 1080 * (16 + 8 + 4 + 4 * (16 + 8) + 4 + 4 + 4 + 4));
  CHECK_THROWS_WITH(renderer.set_options({.part_px = 63}), "renderer: part_px is 63, must be in [64, 4000]");
  CHECK_THROWS_WITH(Renderer({.part_px = 4001}), "renderer: part_px is 4001, must be in [64, 4000]");
}

}  // namespace
}  // namespace lumatlas
