// SPDX-License-Identifier: GPL-3.0-or-later
// Which pixels are at a silhouette, and that these alone are means of samples.
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <vector>

#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/sampling/supersampling.h"
#include "blend/tables/tiles.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

std::vector<std::uint8_t> silhouettes(const Mesh& mesh, const Camera& camera) {
  return silhouettes(camera, make_ray_visibility(mesh)->trace(camera));
}

// Returns for each pixel whether it sees a surface and one of its neighbours sees something that `differs`.
template <typename Differs>
std::vector<std::uint8_t> beside(const VisibilityBuffer& visible, const Differs& differs) {
  const auto width = std::ptrdiff_t{visible.width}, height = std::ptrdiff_t{visible.height};
  std::vector<std::uint8_t> flags;
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * width + x);
      bool found = false;
      for (std::ptrdiff_t row = std::max<std::ptrdiff_t>(y - 1, 0); row <= std::min(y + 1, height - 1); ++row) {
        for (std::ptrdiff_t column = std::max<std::ptrdiff_t>(x - 1, 0); column <= std::min(x + 1, width - 1);
             ++column) {
          found |= differs(pixel, static_cast<std::size_t>(row * width + column));
        }
      }
      flags.push_back(visible.face[pixel] != FaceId::none && found ? 1 : 0);
    }
  }
  return flags;
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 8) / 0x1p24;
}

// Looks at `target` from so far, from all directions down to `lowest` above the plane z = 0, which is its sine.
Camera camera_around(std::mt19937& random, const glm::dvec3& target, double lowest) {
  const double sine = lowest * std::pow(1 / lowest, uniform(random, 0, 1));
  const double angle = uniform(random, 0, 6.283);
  const double cosine = std::sqrt(1 - sine * sine);
  const glm::dvec3 towards(cosine * std::cos(angle), cosine * std::sin(angle), -sine);
  const glm::dvec3 right =
      glm::normalize(glm::cross(towards, {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 2, 3)}));
  Camera camera = forward_camera(80, 60);
  camera.fx *= uniform(random, 0.5, 2);
  camera.fy *= uniform(random, 0.5, 2);
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::cross(towards, right), towards));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * (target - uniform(random, 1, 9) * towards));
  return camera;
}

TEST_CASE("of a flat wall the rim is at a silhouette and nothing else, from any direction") {
  Mesh mesh;
  add_wall(mesh, 5, 7, 1, 0);
  const auto visibility = make_ray_visibility(mesh);
  std::mt19937 random(5);
  std::size_t rim = 0, inner = 0;
  for (int picture = 0; picture < 200; ++picture) {
    CAPTURE(picture);
    const Camera camera = camera_around(random, {1.3, -0.4, 0}, 1e-3);
    const VisibilityBuffer visible = visibility->trace(camera);
    const std::vector<std::uint8_t> expected =
        beside(visible, [&](std::size_t, std::size_t neighbour) { return visible.face[neighbour] == FaceId::none; });
    CHECK(silhouettes(camera, visible) == expected);
    for (std::size_t pixel = 0; pixel < expected.size(); ++pixel) {
      rim += expected[pixel];
      inner += visible.face[pixel] != FaceId::none && !expected[pixel];
    }
  }
  CHECK(rim > 5000);
  CHECK(inner > 100000);
}

TEST_CASE("where a panel stands before a wall, the pixels on both sides of its edges are at a silhouette") {
  Mesh mesh;
  add_wall(mesh, 4, 4, 2, 4);
  add_wall(mesh, 1, 1, 0.5f, 2);
  const Camera camera = forward_camera(64, 48);
  const VisibilityBuffer visible = make_ray_visibility(mesh)->trace(camera);
  const std::vector<std::uint8_t> expected = beside(visible, [&](std::size_t pixel, std::size_t neighbour) {
    return std::abs(visible.depth[pixel] - visible.depth[neighbour]) > 1;
  });
  CHECK(std::count(expected.begin(), expected.end(), 1) == 4 * 16 - 4 + 4 * 16 + 4);  // a square of 16 pixels a side
  CHECK(silhouettes(camera, visible) == expected);
}

// A quadrilateral from the top of the picture of forward_camera() to below its bottom, between (x, z) and (x, z).
void add_strip(Mesh& mesh, const glm::vec2& left, const glm::vec2& right) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec2& side : {left, right}) {
    mesh.positions.emplace_back(side.x, -50, side.y);
    mesh.positions.emplace_back(side.x, 50, side.y);
  }
  mesh.faces.emplace_back(first, first + 1, first + 2);
  mesh.faces.emplace_back(first + 2, first + 1, first + 3);
}

TEST_CASE("a step in depth counts from as many pixels' widths on as the definition says, whatever the resolution") {
  for (const std::uint32_t side : {40u, 200u}) {
    const Camera camera = forward_camera(side, side);
    for (const double steps : {0.9, 1.1}) {
      CAPTURE(side, steps);
      const double width = 10.0 / camera.fx;  // of a pixel, at z = 10
      Mesh mesh;
      add_strip(mesh, {-30, 10}, {0, 10});
      // Seen from its farther side a step is larger, by z / z': the smaller one is to be above or below.
      const double share = steps * kSilhouetteBend / camera.fx;
      const auto behind = static_cast<float>(steps > 1 ? 10 / (1 - share) : 10 * (1 + share));
      CHECK(std::abs(behind - 10) > 0.85 * kSilhouetteBend * width);
      add_strip(mesh, {-3, behind}, {30, behind});
      const std::vector<std::uint8_t> flags = silhouettes(mesh, camera);
      for (std::size_t pixel = 0; pixel < flags.size(); ++pixel) {
        const std::size_t column = pixel % side;
        const bool beside_step = column + 1 == side / 2 || column == side / 2;
        REQUIRE(flags[pixel] == (steps > 1 && beside_step ? 1 : 0));
      }
    }
  }
}

TEST_CASE("a right-angled corner is no silhouette, a corner with one side all but edge-on is") {
  const Camera camera = forward_camera(64, 64);
  Mesh corner;
  add_strip(corner, {-3, 2}, {0, 5});
  add_strip(corner, {0, 5}, {3, 2});
  const std::vector<std::uint8_t> none = silhouettes(corner, camera);
  CHECK(std::count(none.begin(), none.end(), 1) == 0);
  Mesh steep;  // its right side goes back twelve times as far as it goes to the right
  add_strip(steep, {-5, 5}, {0, 5});
  add_strip(steep, {0, 5}, {4, 53});
  const std::vector<std::uint8_t> some = silhouettes(steep, camera);
  CHECK(std::count(some.begin(), some.end(), 1) >= 64);
}

TEST_CASE("silhouettes are asked of what the camera itself sees") {
  const Camera camera = forward_camera(20, 10);
  CHECK_THROWS_WITH(silhouettes(camera, VisibilityBuffer{}), Catch::Contains("as large as the camera's image"));
}

// A wall and forty panels before it, turned at random, with a cell for each surface and six views of them all.
Snapshot panels() {
  const auto surface = std::make_shared<Surface>();
  Mesh& mesh = surface->mesh;
  add_wall(mesh, 4, 4, 1.5f, 0);
  std::vector<CellId> cell_of_face(mesh.faces.size(), 0);
  std::mt19937 random(3);
  for (std::uint32_t panel = 0; panel < 40; ++panel) {
    const glm::dvec3 middle{uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, 0.1, 0.9)};
    const glm::dvec3 across{uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3), uniform(random, -0.1, 0.1)};
    const glm::dvec3 down = glm::cross(across, glm::dvec3(0, 0, 1));
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& corner : {-across - down, across - down, -across + down, across + down}) {
      mesh.positions.emplace_back(middle + corner);
    }
    mesh.faces.emplace_back(first, first + 2, first + 1);
    mesh.faces.emplace_back(first + 1, first + 2, first + 3);
    cell_of_face.insert(cell_of_face.end(), 2, CellId(panel + 1));
  }
  surface->cells = measure_cells(mesh, std::move(cell_of_face), 0.5);
  Atlas atlas(surface, 6);
  std::vector<ViewSlot> slots;
  for (std::uint32_t view = 0; view < 6; ++view) {
    const Camera camera = camera_around(random, {0, 0, 0.5}, 0.5);
    slots.push_back(atlas.insert(traced_view(*surface, "", camera, pattern_photograph(camera, view))));
  }
  for (CellId cell{0}; cell <= 40; ++cell) atlas.set_references(cell, slots);
  return atlas.snapshot();
}

BlendOptions sampled(std::uint32_t across, BlendOptions::Antialias antialias) {
  BlendOptions options;
  options.supersample = across;
  options.antialias = antialias;
  return options;
}

struct EdgeComparison {
  std::size_t pixels = 0;
  std::size_t smoothed = 0;              // other than with one sample
  std::size_t kept = 0;                  // other than with samples everywhere
  std::size_t other = 0;                 // not as the flags have it
  double flagged = 0;                    // values of pixels at silhouettes
  double from_once = 0, from_means = 0;  // sums of their differences from those
};

void compare(Renderer& renderer, const Mesh& mesh, const Camera& camera, std::uint32_t across, EdgeComparison& sum) {
  using enum BlendOptions::Antialias;
  const LinearRendering once = renderer.render_linear(camera, sampled(1, all));
  const LinearRendering means = renderer.render_linear(camera, sampled(across, all));
  const LinearRendering mixed = renderer.render_linear(camera, sampled(across, silhouettes));
  CHECK(mixed.state == once.state);
  const std::vector<std::uint8_t> flags = lumatlas::silhouettes(camera, make_ray_visibility(mesh)->trace(camera));
  for (std::size_t pixel = 0; pixel < flags.size(); ++pixel) {
    const auto same = [&](const LinearRendering& picture) {
      return std::equal(&mixed.rgb[3 * pixel], &mixed.rgb[3 * pixel] + 3, &picture.rgb[3 * pixel]);
    };
    ++sum.pixels;
    sum.smoothed += !same(once);
    sum.kept += !same(means);
    sum.other += !flags[pixel] && !same(once);
    for (std::size_t i = 3 * pixel; flags[pixel] && i < 3 * pixel + 3; ++i) {
      sum.flagged += 1;
      sum.from_once += std::abs(mixed.rgb[i] - once.rgb[i]);
      sum.from_means += std::abs(mixed.rgb[i] - means.rgb[i]);
    }
  }
}

TEST_CASE("a pixel at a silhouette is a mean over its surfaces, and any other keeps its middle to the last bit") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  const Snapshot snapshot = panels();
  renderer.load(snapshot);
  EdgeComparison sum;
  std::mt19937 random(9);
  for (int picture = 0; picture < 12; ++picture) {
    compare(renderer, snapshot.surface->mesh, camera_around(random, {0.2, 0.3, 0.4}, 0.1), 2 + picture % 2, sum);
  }
  CHECK(sum.smoothed > sum.pixels / 20);
  CHECK(sum.kept > sum.pixels / 4);
  CHECK(sum.other <= sum.pixels / 5000);  // where the rasteriser sees another surface than the ray at a pixel's middle
  CAPTURE(sum.from_once / sum.flagged, sum.from_means / sum.flagged);
  CHECK(sum.from_means < sum.from_once);  // although photographs' fine pattern is sampled once for each surface
}

// A buffer of one pixel that sees a surface at that depth, or none at 0.
VisibilityBuffer one_pixel(float depth) {
  VisibilityBuffer visible;
  visible.width = visible.height = 1;
  visible.depth = {depth};
  visible.face = {depth > 0 ? FaceId{0} : FaceId::none};
  return visible;
}

TEST_CASE(
    "a colour counts as often as samples see its surface, and the first sample stands for the others of its own") {
  using enum BlendOptions::Antialias;
  Camera camera = forward_camera(1, 1);
  camera.fx = camera.fy = 1000;  // one surface: 0.2 % of the depth
  const std::vector<VisibilityBuffer> samples{one_pixel(5), one_pixel(10.01f), one_pixel(5.005f), one_pixel(0)};
  const SampleCounts mixed = sample_counts(camera, one_pixel(10), samples, {1}, silhouettes);
  CHECK(mixed.middle == std::vector<std::uint8_t>{1});
  CHECK(mixed.samples == std::vector<std::vector<std::uint8_t>>{{2}, {0}, {0}, {0}});
  const SampleCounts each = sample_counts(camera, one_pixel(10), samples, {1}, all);
  CHECK(each.middle == std::vector<std::uint8_t>{0});
  CHECK(each.samples == std::vector<std::vector<std::uint8_t>>{{1}, {1}, {1}, {0}});
  const SampleCounts none = sample_counts(camera, one_pixel(10), samples, {0}, silhouettes);
  CHECK(none.middle == std::vector<std::uint8_t>{0});
  CHECK(none.samples.front() == std::vector<std::uint8_t>{0});
}

TEST_CASE("with samples at silhouettes the shader agrees with the CPU reference") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = panels();
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  Renderer renderer;
  renderer.load(snapshot);
  std::mt19937 random(11);
  double once = 0, twice = 0, smoothed = 0;
  for (int picture = 0; picture < 8; ++picture) {
    const Camera camera = camera_around(random, {-0.2, 0.1, 0.4}, 0.2);
    const auto different = [&](const BlendOptions& options) {
      return share_different(renderer.render(camera, options), render_reference(snapshot, camera, *visibility, options),
                             2) /
             8;
    };
    const BlendOptions options = sampled(2, BlendOptions::Antialias::silhouettes);
    once += different(at_middle(options));
    twice += different(options);
    smoothed += share_different(renderer.render(camera, at_middle(options)), renderer.render(camera, options), 2) / 8;
  }
  CHECK(smoothed > 0.02);
  CHECK(once <= 0.001);  // the rasteriser and rays differ about edges, once for each sample
  CHECK(twice <= 0.002);
}

TEST_CASE("silhouettes at the borders of tiles are those of the picture in one piece") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(panels());
  std::mt19937 random(13);
  const BlendOptions options = sampled(2, BlendOptions::Antialias::silhouettes);
  for (int picture = 0; picture < 3; ++picture) {
    const Camera camera = camera_around(random, {0, 0, 0.4}, 0.4);
    const Rendering whole = renderer.render(camera, options);
    const LinearRendering linear = renderer.render_linear(camera, options);
    for (const std::uint32_t side : {9u, 32u}) {  // with 9, four in ten pixels have a neighbour in another tile
      CHECK(share_different(render_tiled(renderer, camera, options, side), whole, 1) <= 0.001);
      const LinearRendering tiled = render_linear_tiled(renderer, camera, options, side);
      std::size_t different = 0;
      for (std::size_t i = 0; i < linear.rgb.size(); ++i) different += std::abs(tiled.rgb[i] - linear.rgb[i]) > 0.01f;
      CHECK(different <= linear.rgb.size() / 1000);
    }
  }
}

}  // namespace
}  // namespace lumatlas
