// SPDX-License-Identifier: GPL-3.0-or-later
// The picture is blurred across depth edges as wide as stated, and nothing else changes.
#include "blend/soft_edges.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "atlas/images/srgb.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/panel_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kSide = 96;    // of pictures, pixels
constexpr int kEdge = 48;              // the column where the near surface ends in a picture from the origin
constexpr double kNear = 2, kFar = 4;  // depths
constexpr std::uint8_t kNearGrey = 40, kFarGrey = 200;

// The near surface fills the left half of a picture from the origin; the far one is behind both halves.
Snapshot step_scene(double near_deviation, double far_deviation) {
  return panel_snapshot(
      {facing(-9, 0, kNear, kNearGrey, near_deviation), facing(-9, 9, kFar, kFarGrey, far_deviation)});
}

// The deviation by which edges of the near surface are blurred with this standard deviation, pixels.
double deviation_for(double blur) {
  return std::sqrt(blur * blur + 1) * kNear / (kSide * std::sin(glm::radians(kSoftEdgeDegrees)));
}

BlendOptions soft() {
  BlendOptions options;
  options.outlines = false;  // edges stay where the surface ends
  return options;
}

BlendOptions sharp() {
  BlendOptions options = soft();
  options.soft_edges = false;
  return options;
}

Rendering by_rays(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options = soft()) {
  return render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), options);
}

// The share of the far surface's light in each pixel of the middle row.
std::vector<double> step_response(const Rendering& rendering) {
  const auto& linear = linear_from_srgb8();
  std::vector<double> shares;
  for (std::size_t x = 0; x < kSide; ++x) {
    const double light = linear[rendering.picture.rgb[3 * (kSide / 2 * kSide + x)]];
    shares.push_back((light - linear[kNearGrey]) / (linear[kFarGrey] - linear[kNearGrey]));
  }
  return shares;
}

// Returns the value of a step at kEdge that a Gaussian has blurred.
double smooth_step(int x, double blur) {
  return 0.5 + 0.5 * std::erf((x + 0.5 - kEdge) / (std::sqrt(2.0) * blur));
}

TEST_CASE("an edge is as soft as the nearer surface is off, whatever the farther one is") {
  const std::optional<EglContext> context = context_or_skip();
  const Camera camera = forward_camera(kSide, kSide);
  for (const double far_deviation : {0.0, 3.0}) {
    for (const double blur : {0.7, 1.0, 1.5, 2.0}) {
      CAPTURE(far_deviation, blur);
      const Snapshot snapshot = step_scene(deviation_for(blur), far_deviation);
      std::vector<Rendering> pictures{by_rays(snapshot, camera)};
      if (context) {
        Renderer renderer;
        renderer.load(snapshot);
        pictures.push_back(renderer.render(camera, soft()));
        CHECK(share_different(pictures[0], pictures[1], 1) == 0);
      }
      for (const Rendering& picture : pictures) {
        const std::vector<double> shares = step_response(picture);
        for (int x = 0; x < static_cast<int>(kSide); ++x) {
          CAPTURE(x);
          // The variance falls away from the edge, so the tails of the Gaussian are cut.
          CHECK(std::abs(shares[static_cast<std::size_t>(x)] - smooth_step(x, blur)) < 0.035);
          if (std::abs(x + 0.5 - kEdge) > 0.5 + 2.5 * blur) {
            CHECK(picture.picture.rgb[3 * (kSide / 2 * kSide + static_cast<std::size_t>(x))] ==
                  (x < kEdge ? kNearGrey : kFarGrey));
          }
        }
      }
    }
  }
}

TEST_CASE(
    "a surface that is off by a pixel or less keeps sharp edges, one that is off by much is blurred by 2 pixels") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Camera camera = forward_camera(kSide, kSide);
  const auto rendered = [&](double deviation, const BlendOptions& options) {
    Renderer renderer;
    renderer.load(step_scene(deviation, 0));
    return renderer.render(camera, options);
  };
  const Rendering hard = rendered(deviation_for(0) * 0.99, sharp());
  CHECK(share_different(rendered(deviation_for(0) * 0.99, soft()), hard, 0) == 0);
  CHECK(share_different(rendered(0, soft()), hard, 0) == 0);
  CHECK(share_different(rendered(deviation_for(2), soft()), hard, 0) > 0.05);
  CHECK(share_different(rendered(deviation_for(100), soft()), rendered(deviation_for(2), soft()), 1) == 0);
}

TEST_CASE("of one cell's deviation counts at most twice the median of all") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Camera camera = forward_camera(kSide, kSide);
  std::vector<Panel> scene{facing(-9, 0, kNear, kNearGrey, deviation_for(2)), facing(-9, 9, kFar, kFarGrey, 0)};
  const auto differs = [&] {
    const Snapshot snapshot = panel_snapshot(scene);
    Renderer renderer;
    renderer.load(snapshot);
    const Rendering softened = renderer.render(camera, soft());
    CHECK(share_different(softened, by_rays(snapshot, camera), 1) == 0);
    return share_different(softened, renderer.render(camera, sharp()), 0);
  };
  CHECK(differs() > 0.05);
  // Two surfaces out of sight that are exact to a thousandth of that.
  for (int i = 0; i < 2; ++i) scene.push_back(facing(-9, 9, -5, kFarGrey, deviation_for(2) / 1000));
  CHECK(median_deviation(panel_snapshot(scene).cell_deviation) == static_cast<float>(deviation_for(2) / 1000));
  CHECK(differs() == 0);
}

TEST_CASE("creases, surfaces seen edge-on and the end of the surface are no edges") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto off = static_cast<float>(deviation_for(100));
  const Panel floor{{glm::vec3(-50, 1, 4), {50, 1, 4}, {-50, 1, 1}, {50, 1, 1}}, kNearGrey, off};
  const Panel wall{{glm::vec3(-50, -90, 4), {50, -90, 4}, {-50, 1, 4}, {50, 1, 4}}, kFarGrey, off};
  const Panel plain{{glm::vec3(-50, 1, 200), {50, 1, 200}, {-50, 1, 1}, {50, 1, 1}}, kNearGrey, off};
  const Panel island{{glm::vec3(-0.5, -0.5, 2), {0.5, -0.5, 2}, {-0.5, 0.5, 2}, {0.5, 0.5, 2}}, kFarGrey, off};
  for (const std::vector<Panel>& scene : {std::vector{floor, wall}, std::vector{plain}, std::vector{island}}) {
    Renderer renderer;
    renderer.load(panel_snapshot(scene));
    const Camera camera = forward_camera(kSide, kSide);
    CHECK(share_different(renderer.render(camera, soft()), renderer.render(camera, sharp()), 0) == 0);
  }
}

// Pixels at most kEdgeReach + 1 away, in row and column, from one that is beside another depth.
std::vector<std::uint8_t> around_steps(const VisibilityBuffer& visible) {
  const auto width = static_cast<int>(visible.width);
  const auto height = static_cast<int>(visible.height);
  std::vector<std::uint8_t> around(visible.depth.size(), 0);
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * visible.width + static_cast<std::size_t>(x);
  };
  const auto mark = [&](int x, int y) {
    for (int row = std::max(y - kEdgeReach - 1, 0); row <= std::min(y + kEdgeReach + 1, height - 1); ++row) {
      for (int column = std::max(x - kEdgeReach - 1, 0); column <= std::min(x + kEdgeReach + 1, width - 1); ++column) {
        around[at(column, row)] = 1;
      }
    }
  };
  const auto depth = [&](int x, int y) { return visible.depth[at(x, y)]; };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool right = x + 1 < width && std::abs(depth(x, y) / depth(x + 1, y) - 1) > kEdgeBend / 3;
      const bool down = y + 1 < height && std::abs(depth(x, y) / depth(x, y + 1) - 1) > kEdgeBend / 3;
      if (right || down) mark(x, y);
    }
  }
  return around;
}

TEST_CASE("pixels away from depth edges stay the same to the last bit, and the shader agrees with the CPU reference") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto off = static_cast<float>(deviation_for(1.5));
  const Snapshot snapshot = panel_snapshot(
      {{{glm::vec3(-9, -9, 4), {9, -9, 4}, {-9, 9, 4}, {9, 9, 4}}, 10, off, 60},
       {{glm::vec3(-0.9, -0.7, 2), {-0.2, -0.6, 2.3}, {-0.8, 0.5, 2.2}, {-0.1, 0.6, 2.5}}, 60, off, 50},
       {{glm::vec3(0.1, -0.3, 1.7), {0.8, -0.8, 2}, {0.2, 0.6, 2.1}, {0.9, 0.1, 2.4}}, 250, off / 2, 255 - 70},
       {{glm::vec3(-0.4, 0.2, 3), {0.6, 0.1, 3}, {-0.5, 0.4, 3}, {0.7, 0.4, 3}}, 0, 2 * off, 80}});
  Renderer renderer, in_parts({.part_px = 64});
  renderer.load(snapshot);
  in_parts.load(snapshot);
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  double changed = 0, different = 0, levels = 0;
  for (std::size_t number = 0; number < 4; ++number) {
    const Camera camera = forward_camera(160, 120, {0.13 * static_cast<double>(number) - 0.2, 0.07, 0.1});
    const Rendering softened = renderer.render(camera, soft()), hard = renderer.render(camera, sharp());
    CHECK(softened.state == hard.state);
    CHECK(share_different(in_parts.render(camera, soft()), softened, 1) <= 0.001);
    const std::vector<std::uint8_t> around = around_steps(visibility->trace(camera));
    for (std::size_t pixel = 0; pixel < around.size(); ++pixel) {
      const bool same = std::equal(&softened.picture.rgb[3 * pixel], &softened.picture.rgb[3 * pixel] + 3,
                                   &hard.picture.rgb[3 * pixel]);
      changed += same ? 0 : 1;
      if (!around[pixel]) CHECK(same);
    }
    different += share_different(softened, render_reference(snapshot, camera, *visibility, soft()), 2) / 4;
    const LinearRendering linear = renderer.render_linear(camera, soft());
    for (std::size_t value = 0; value < linear.rgb.size(); ++value) {
      levels = std::max(
          levels, std::abs(static_cast<double>(srgb8_from_linear(linear.rgb[value])) - softened.picture.rgb[value]));
    }
  }
  CHECK(changed > 4 * 160 * 120 * 0.02);
  CHECK(different <= 0.005);  // where the rasteriser sees another surface than the ray, pixels around differ too
  CHECK(levels <= 1);         // of rounding before the blur and after it
}

TEST_CASE("a soft edge that moves flickers less than a hard one") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(step_scene(deviation_for(1.5), 0));
  const auto flicker = [&](const BlendOptions& options) {
    double sum = 0;
    std::optional<Rendering> before;
    for (int frame = 0; frame < 24; ++frame) {
      const Camera camera = forward_camera(kSide, kSide, {0.3 * kNear / kSide * frame, 0, 0});
      Rendering now = renderer.render(camera, options);
      for (std::size_t i = 0; before && i < now.picture.rgb.size(); ++i) {
        sum += std::pow(now.picture.rgb[i] - before->picture.rgb[i], 2);
      }
      before = std::move(now);
    }
    return sum;
  };
  const double hard = flicker(sharp());
  CHECK(hard > 0);
  CHECK(flicker(soft()) < 0.7 * hard);
}

TEST_CASE("what does not fit the picture is refused") {
  const Camera camera = forward_camera(8, 6);
  const VisibilityBuffer visible{8, 6, std::vector<float>(48, 1), std::vector<FaceId>(48, FaceId{0})};
  CHECK_NOTHROW(edge_blur(camera, visible, std::vector<float>(48), 1));
  CHECK_THROWS_WITH(edge_blur(camera, visible, std::vector<float>(47), 1),
                    Catch::Contains("the deviation has 47 values"));
  CHECK_THROWS_AS(edge_blur(forward_camera(8, 7), visible, std::vector<float>(56), 1), std::invalid_argument);
  const Photograph picture{8, 6, std::vector<std::uint8_t>(144, 9), {}};
  CHECK(with_soft_edges(picture, std::vector<std::uint8_t>(48, 1), std::vector<float>(48, 1)).rgb == picture.rgb);
  CHECK_THROWS_AS(with_soft_edges(picture, std::vector<std::uint8_t>(47), std::vector<float>(48)),
                  std::invalid_argument);
  CHECK_THROWS_AS(with_soft_edges(picture, std::vector<std::uint8_t>(48), std::vector<float>(49)),
                  std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
