// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/sampling/supersampling.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "atlas/images/srgb.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/tables/tiles.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

BlendOptions supersampled(std::uint32_t across, BlendOptions options = {}) {
  options.supersample = across;
  options.antialias = BlendOptions::Antialias::all;
  return options;
}

Rendering rendered_by_rays(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
  return render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), options);
}

Camera camera_between(std::size_t number) {
  const Camera next = room_camera(number + 1);
  Camera camera = room_camera(number).scaled_to(160, 120);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * ((camera.center() + next.center()) / 2.0));
  return camera;
}

TEST_CASE("the samples of a pixel are at the middles of its equal parts, row by row") {
  const Camera camera = room_camera(3);
  for (const std::uint32_t across : {1u, 2u, 3u, 4u}) {
    const std::vector<Camera> samples = sample_cameras(camera, across);
    REQUIRE(samples.size() == across * across);
    const Camera finer = camera.scaled_to(across * camera.width, across * camera.height);
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      CHECK_NOTHROW(check(samples[i]));
      const std::uint32_t column = i % across, row = i / across;
      const glm::dvec2 part(column + 0.5, row + 0.5);
      const glm::dvec2 pixel(17, 29);
      CHECK(glm::length(samples[i].ray(pixel + 0.5) - finer.ray(pixel * double(across) + part)) < 1e-12);
    }
  }
  CHECK(sample_cameras(camera, 1)[0].cx == camera.cx);
}

TEST_CASE("the shader agrees with the CPU reference for every number of samples") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = exposed_room_snapshot(10);  // some colours are above white before the mean
  Renderer renderer;
  renderer.load(snapshot);
  for (const std::uint32_t across : {1u, 2u, 3u, 4u}) {
    CAPTURE(across);
    double different = 0;
    for (std::size_t number = 0; number < 4; ++number) {
      const Camera camera = camera_between(number);
      const BlendOptions options = supersampled(across);
      different +=
          share_different(renderer.render(camera, options), rendered_by_rays(snapshot, camera, options), 2) / 4;
    }
    CHECK(different <= 0.001);
  }
}

constexpr int kSquares = 12;              // a side of the checkerboard
constexpr glm::u8vec3 kDark{40, 10, 90};  // sRGB
constexpr glm::u8vec3 kLight{250, 130, 200};

const glm::u8vec3& square_color(int column, int row) {
  return (column + row) % 2 == 0 ? kDark : kLight;
}

// In pictures of forward_camera(32, 32), pixels.
struct Checkerboard {
  double first;  // where it begins, in rows as in columns
  double side;   // of a square
};

// It has no view: all that there is are its vertices' colours.
Snapshot snapshot_of(const Checkerboard& board) {
  const auto surface = std::make_shared<Surface>();
  Snapshot snapshot;
  FallbackColors::Colors colors;
  constexpr double kDepth = 2;
  for (int row = 0; row < kSquares; ++row) {
    for (int column = 0; column < kSquares; ++column) {
      const auto first = static_cast<std::uint32_t>(surface->mesh.positions.size());
      for (const auto [x, y] : {std::array{0, 0}, std::array{1, 0}, std::array{0, 1}, std::array{1, 1}}) {
        const glm::dvec2 image = board.first + board.side * glm::dvec2(column + x, row + y);
        surface->mesh.positions.emplace_back(kDepth * (image.x - 16) / 32, kDepth * (image.y - 16) / 32, kDepth);
        colors.push_back(square_color(column, row));
      }
      surface->mesh.faces.emplace_back(first, first + 2, first + 1);
      surface->mesh.faces.emplace_back(first + 1, first + 2, first + 3);
    }
  }
  surface->cells = measure_cells(surface->mesh, std::vector<CellId>(surface->mesh.faces.size(), 0), 1);
  snapshot.surface = surface;
  snapshot.vertex_colors = std::move(colors);
  snapshot.cell_seen = {0};
  snapshot.references.offsets = {0, 0};
  return snapshot;
}

double overlap(double a, double b, double c, double d) {
  return std::max(0.0, std::min(b, d) - std::max(a, c));
}

// The mean colour in linear light of what the checkerboard shows of a pixel; in w how much of it that is.
glm::dvec4 area_mean(int x, int y, const Checkerboard& board) {
  glm::dvec4 sum(0);
  for (int row = 0; row < kSquares; ++row) {
    for (int column = 0; column < kSquares; ++column) {
      const glm::dvec2 low = board.first + board.side * glm::dvec2(column, row);
      const glm::dvec2 high = low + board.side;
      const double area = overlap(x, x + 1, low.x, high.x) * overlap(y, y + 1, low.y, high.y);
      const glm::u8vec3& color = square_color(column, row);
      sum.w += area;
      for (int channel = 0; channel < 3; ++channel) sum[channel] += area * linear_from_srgb(color[channel] / 255.0);
    }
  }
  return {glm::dvec3(sum) / std::max(sum.w, 1e-12), sum.w};
}

// How many values are off by more than rounding. Where less than half of a pixel's width is covered, its middle sees
// nothing: it is black.
std::size_t off_area_mean(const Rendering& rendering, const Checkerboard& board) {
  const double last = board.first + board.side * kSquares;
  const auto covers = [&](double middle) { return middle > board.first && middle < last; };
  std::size_t off = 0;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const auto pixel = std::size_t{32} * static_cast<std::size_t>(y) + static_cast<std::size_t>(x);
      const bool seen = covers(x + 0.5) && covers(y + 0.5);
      off += (rendering.state[pixel] == PixelState::unseen) != seen;
      const glm::dvec4 expected = seen ? area_mean(x, y, board) : glm::dvec4(0);
      for (int channel = 0; channel < 3; ++channel) {
        const int level = srgb8_from_linear(expected[channel]);
        off += std::abs(level - rendering.picture.rgb[3 * pixel + static_cast<std::size_t>(channel)]) > 1;
      }
    }
  }
  return off;
}

// Edges at N-ths of a pixel: N x N samples know the area of each square in a pixel exactly.
TEST_CASE("of a checkerboard whose edges lie between samples, every pixel is the mean over its area") {
  const std::optional<EglContext> context = context_or_skip();
  const Camera camera = forward_camera(32, 32);
  for (const std::uint32_t across : {2u, 3u, 4u}) {
    const double unit = 1.0 / across;
    const Checkerboard board{across == 2 ? 2 : 2 + unit, across == 4 ? 1 + 3 * unit : 1 + unit};
    CAPTURE(across);
    const Snapshot snapshot = snapshot_of(board);
    CHECK(off_area_mean(rendered_by_rays(snapshot, camera, supersampled(across)), board) == 0);
    CHECK(off_area_mean(rendered_by_rays(snapshot, camera, supersampled(1)), board) > 300);  // the check can fail
    if (!context) continue;
    Renderer renderer;
    renderer.load(snapshot);
    CHECK(off_area_mean(renderer.render(camera, supersampled(across)), board) == 0);
  }
}

TEST_CASE("a linear picture is the mean of the linear pictures of its samples, before it is cut off at white") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(6, {});
  for (std::size_t slot = 0; slot < 6; ++slot) snapshot.gains[slot] = glm::dvec3(slot % 2 == 0 ? 0.3 : 2.0);
  Renderer renderer;
  renderer.load(snapshot);
  BlendOptions options = supersampled(1);
  options.prefilter = false;  // a sample is smaller than a pixel, nothing else about it differs
  const Camera camera = camera_between(2);
  std::vector<double> mean(std::size_t{3} * camera.width * camera.height, 0.0);
  for (const Camera& sample : sample_cameras(camera, 2)) {
    const LinearRendering part = renderer.render_linear(sample, options);
    REQUIRE(std::count(part.state.begin(), part.state.end(), PixelState::empty) == 0);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += part.rgb[i] / 4.0;
  }
  const LinearRendering whole = renderer.render_linear(camera, supersampled(2, options));
  REQUIRE(*std::max_element(mean.begin(), mean.end()) > 1.05);
  // The samples are drawn in one grid, which is twice as fine and rounds the triangles' corners to other places. Where
  // depth is taken from these, 1 value in 60 differs a little.
  std::size_t different = 0;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    REQUIRE(std::abs(whole.rgb[i] - mean[i]) < 0.01);
    different += std::abs(whole.rgb[i] - mean[i]) > 1e-4;
  }
  CHECK(different < mean.size() / (takes_depth_from_exact_corners(*context) ? 1000 : 25));
}

TEST_CASE("states and diagnoses are those of the middles of the pixels, for every number of samples") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(room_snapshot(3, {}));
  const Camera camera = camera_between(1);
  const Rendering once = renderer.render(camera, supersampled(1));
  const Diagnosis diagnosis = renderer.diagnose(camera, supersampled(1));
  for (const std::uint32_t across : {2u, 3u}) {
    CHECK(renderer.render(camera, supersampled(across)).state == once.state);
    CHECK(renderer.render_linear(camera, supersampled(across)).state == once.state);
    const Diagnosis again = renderer.diagnose(camera, supersampled(across));
    CHECK(again.state == diagnosis.state);
    for (std::size_t pixel = 0; pixel < again.pixels.size(); ++pixel) {
      REQUIRE(again.pixels[pixel].winner == diagnosis.pixels[pixel].winner);
      REQUIRE(again.pixels[pixel].valid_views == diagnosis.pixels[pixel].valid_views);
    }
  }
  CHECK(renderer.render(camera, supersampled(1)).picture.rgb == once.picture.rgb);  // the samples leave nothing behind
}

TEST_CASE("a supersampled picture in tiles is the picture in one piece") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(room_snapshot(10, {}));
  const Camera camera = room_camera(5).scaled_to(197, 149);
  const BlendOptions options = supersampled(2);
  const Rendering whole = renderer.render(camera, options);
  const LinearRendering linear = renderer.render_linear(camera, options);
  for (const std::uint32_t side : {64u, 101u}) {
    CHECK(share_different(render_tiled(renderer, camera, options, side), whole, 1) <= 0.0005);
    const LinearRendering tiled = render_linear_tiled(renderer, camera, options, side);
    std::size_t different = 0;
    for (std::size_t i = 0; i < linear.rgb.size(); ++i) different += std::abs(tiled.rgb[i] - linear.rgb[i]) > 0.01f;
    CHECK(different <= linear.rgb.size() / 2000);
  }
}

TEST_CASE("other numbers of samples are refused by name") {
  CHECK_THROWS_WITH(check(supersampled(0)), Catch::Contains("supersample is 0") && Catch::Contains("[1, 4]"));
  CHECK_THROWS_WITH(check(supersampled(5)), Catch::Contains("supersample is 5"));
}

}  // namespace
}  // namespace lumatlas
