// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces are continued past their outlines as far as they are off, and photographs then show the outline.
#include "blend/outlines.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/soft_edges.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/panel_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kOutlineSide = 96;  // of pictures, pixels
constexpr std::uint8_t kFrontGrey = 40, kBackGrey = 200;

// The deviation of a surface at depth z that S of soft_edges.h is `shift` pixels of.
double deviation_of(double shift, double z) {
  return shift * z / (kOutlineSide * std::sin(glm::radians(kSoftEdgeDegrees)));
}

// The near surface fills the left half of a picture from the origin; the far one is behind both halves.
Snapshot half_covered(double shift) {
  return panel_snapshot({facing(-9, 0, 2, kFrontGrey, deviation_of(shift, 2)), facing(-9, 9, 4, kBackGrey, 0)});
}

BlendOptions without_blur() {
  BlendOptions options;
  options.soft_edges = false;
  return options;
}

BlendOptions as_it_ends() {
  BlendOptions options = without_blur();
  options.outlines = false;
  return options;
}

// Pixels of the middle row that show the near surface.
std::size_t covered(const Rendering& picture) {
  std::size_t count = 0;
  for (std::size_t x = 0; x < kOutlineSide; ++x) {
    count += picture.picture.rgb[3 * (kOutlineSide / 2 * kOutlineSide + x)] == kFrontGrey ? 1 : 0;
  }
  return count;
}

TEST_CASE("an outline moves by twice the shift of its surface, by 4 pixels at most, and none that is exact") {
  const std::optional<EglContext> context = context_or_skip();
  const Camera camera = forward_camera(kOutlineSide, kOutlineSide);
  const struct {
    double shift;
    std::size_t moved;
  } cases[] = {{0, 0}, {0.99, 0}, {1.01, 2}, {1.4, 2}, {1.55, 3}, {1.9, 3}, {2.1, 4}, {30, 4}};
  for (const auto& [shift, moved] : cases) {
    CAPTURE(shift);
    const Snapshot snapshot = half_covered(shift);
    const auto visibility = make_ray_visibility(snapshot.surface->mesh);
    CHECK(covered(render_reference(snapshot, camera, *visibility, as_it_ends())) == kOutlineSide / 2);
    CHECK(covered(render_reference(snapshot, camera, *visibility, without_blur())) == kOutlineSide / 2 + moved);
    if (!context) continue;
    Renderer renderer;
    renderer.load(snapshot);
    CHECK(covered(renderer.render(camera, without_blur())) == kOutlineSide / 2 + moved);
    CHECK(renderer.render(camera, without_blur()).state == renderer.render(camera, as_it_ends()).state);
  }
}

TEST_CASE("a corner is continued as a disc, the nearest surface counts, and no surface grows into nothing") {
  VisibilityBuffer visible{16, 16, std::vector<float>(256, 4), std::vector<FaceId>(256, FaceId{0})};
  const auto at = [](std::size_t x, std::size_t y) { return 16 * y + x; };
  visible.depth[at(8, 8)] = 2;
  visible.depth[at(11, 8)] = 1;
  for (std::size_t x = 0; x < 16; ++x) visible.face[at(x, 6)] = FaceId::none;
  const std::vector<float> deviation(256, 1);
  const auto from = continued_outlines(forward_camera(16, 16), visible, deviation, 1);
  const double of_two = kOutlineOfShift * std::sin(glm::radians(kSoftEdgeDegrees)) * 16 / 2;
  REQUIRE(of_two > 2);
  for (std::size_t y = 0; y < 16; ++y) {
    for (std::size_t x = 0; x < 16; ++x) {
      CAPTURE(x, y);
      const auto distance = [&](double column) {
        return std::hypot(static_cast<double>(x) - column, static_cast<double>(y) - 8);
      };
      const bool is_far = visible.face[at(x, y)] != FaceId::none && visible.depth[at(x, y)] == 4;
      const bool of_first = is_far && distance(8) <= of_two, of_second = is_far && distance(11) <= kOutlineReach;
      std::size_t expected = of_first ? at(8, 8) : at(x, y);
      if (of_second && !(of_first && distance(8) < distance(11))) expected = at(11, 8);
      if (at(x, y) == at(8, 8)) expected = at(11, 8);  // which is nearer still
      CHECK(from[at(x, y)] == expected);
    }
  }
}

TEST_CASE("the shader continues outlines as the CPU reference does, also in parts and with samples") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto off = static_cast<float>(deviation_of(1.5, 2));
  const Snapshot snapshot = panel_snapshot(
      {{{glm::vec3(-9, -9, 4), {9, -9, 4}, {-9, 9, 4}, {9, 9, 4}}, 10, off, 60},
       {{glm::vec3(-0.9, -0.7, 2), {-0.2, -0.6, 2.3}, {-0.8, 0.5, 2.2}, {-0.1, 0.6, 2.5}}, 60, off, 50},
       {{glm::vec3(0.1, -0.3, 1.7), {0.8, -0.8, 2}, {0.2, 0.6, 2.1}, {0.9, 0.1, 2.4}}, 250, off / 2, 185},
       {{glm::vec3(-0.4, 0.2, 3), {0.6, 0.1, 3}, {-0.5, 0.4, 3}, {0.7, 0.4, 3}}, 0, 2 * off, 80}});
  Renderer renderer, in_parts({.part_px = 64});
  renderer.load(snapshot);
  in_parts.load(snapshot);
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  for (std::size_t number = 0; number < 4; ++number) {
    const Camera camera = forward_camera(160, 120, {0.13 * static_cast<double>(number) - 0.2, 0.07, 0.1});
    for (const std::uint32_t supersample : {1U, 2U}) {
      BlendOptions options = without_blur();
      options.supersample = supersample;
      const Rendering picture = renderer.render(camera, options);
      CHECK(share_different(in_parts.render(camera, options), picture, 1) <= 0.001);
      // Where the rasteriser sees another surface than the ray, pixels around differ too.
      CHECK(share_different(picture, render_reference(snapshot, camera, *visibility, options), 2) <= 0.005);
      CHECK(share_different(picture, renderer.render(camera, as_it_ends()), 2) > 0.02);
    }
  }
}

TEST_CASE("outlines of what does not fit the picture are refused") {
  const Camera camera = forward_camera(8, 6);
  const VisibilityBuffer visible{8, 6, std::vector<float>(48, 1), std::vector<FaceId>(48, FaceId{0})};
  CHECK_NOTHROW(continued_outlines(camera, visible, std::vector<float>(48), 1));
  CHECK_THROWS_WITH(continued_outlines(camera, visible, std::vector<float>(47), 1),
                    Catch::Contains("the deviation has 47 values"));
  CHECK_THROWS_AS(continued_outlines(forward_camera(8, 7), visible, std::vector<float>(56), 1), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
