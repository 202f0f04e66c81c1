// SPDX-License-Identifier: GPL-3.0-or-later
// The shader against its CPU reference on random scenes, degenerate ones included.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <random>

#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

class Chance {
 public:
  explicit Chance(std::uint32_t seed) : random_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_() >> 8) / 0x1p24; }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  glm::dvec3 point(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

 private:
  std::mt19937 random_;
};

// Triangles anywhere, some of no area, some joined at a corner, and a wall behind them all.
Mesh random_mesh(Chance& chance) {
  Mesh mesh;
  add_wall(mesh, 6, 6, 1.5F, 5);
  for (std::uint32_t triangle = 0; triangle < 12; ++triangle) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const glm::dvec3 middle = glm::dvec3(0, 0, 2.5) + chance.point(2);
    for (int corner = 0; corner < 3; ++corner) mesh.positions.emplace_back(middle + chance.point(1));
    if (triangle % 6 == 0) mesh.positions.back() = mesh.positions[first];  // an edge, no area
    mesh.faces.emplace_back(triangle % 4 == 3 ? first - 1 : first, first + 1, first + 2);
  }
  return mesh;
}

Camera random_camera(Chance& chance, std::uint32_t width, std::uint32_t height) {
  Camera camera = forward_camera(width, height);
  camera.fx = width * chance.uniform(0.5, 2);
  camera.fy = height * chance.uniform(0.5, 2);
  camera.cx = width * chance.uniform(0.3, 0.7);
  camera.cy = height * chance.uniform(0.3, 0.7);
  camera.cam_from_world_rotation = glm::mat3_cast(glm::normalize(glm::dquat(1, 0.25 * chance.point(1))));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * (glm::dvec3(0, 0, -1) + chance.point(1)));
  return camera;
}

// Cells of random faces, whose references are anything from none to every view, twice the same one not among them.
Snapshot random_snapshot(std::uint32_t seed) {
  Chance chance(seed);
  auto surface = std::make_shared<Surface>();
  surface->mesh = random_mesh(chance);
  const std::uint32_t cells = 1 + chance.below(20);
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < surface->mesh.faces.size(); ++face) {
    cell_of_face.emplace_back(face < cells ? face : chance.below(cells));
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), chance.uniform(0.1, 4));
  const std::uint32_t views = 1 + chance.below(10);
  Atlas atlas(surface, views + 2);
  for (std::uint32_t view = 0; view < views; ++view) {
    const Camera camera = random_camera(chance, 40 + chance.below(60), 40 + chance.below(60));
    const ViewSlot slot = atlas.insert(traced_view(*surface, "", camera, pattern_photograph(camera, view)));
    atlas.set_gain(slot, {chance.uniform(0.5, 2), chance.uniform(0.5, 2), chance.uniform(0.5, 2)});
  }
  for (CellId cell{0}; cell < cells; ++cell) {
    std::vector<ViewSlot> slots;
    const double share = chance.uniform(-0.2, 1.2);
    for (ViewSlot view{0}; view < views; ++view) {
      if (chance.uniform(0, 1) < share) slots.push_back(view);
    }
    atlas.set_references(cell, std::move(slots));
    const std::vector<CellPixels> seen{{CellId{cell}, 1}};
    if (chance.below(3) > 0) atlas.mark_seen(seen);
  }
  Snapshot snapshot = atlas.snapshot();
  if (chance.below(2) == 0) {
    for (CellId cell{0}; cell < cells; ++cell) {
      snapshot.cell_deviation.push_back(static_cast<float>(chance.uniform(-0.1, 0.3)));
      snapshot.cell_deviation.back() = std::max(snapshot.cell_deviation.back(), 0.0f);
    }
  }
  return snapshot;
}

BlendOptions random_options(Chance& chance) {
  BlendOptions options = chance.below(4) == 0 ? BlendOptions::printed() : BlendOptions{};
  options.views = 1 + chance.below(kMaxBlendedViews);
  options.lambda = chance.below(4) == 0 ? chance.below(2) : chance.uniform(0, 1);
  options.rims = chance.below(4) > 0;
  options.soften = chance.below(4) > 0;
  options.soft_edges = options.soften;
  options.fade_last = chance.below(2) == 0;
  options.consistent = options.views % 3 != 0;
  options.border_width = chance.below(3) == 0 ? 0 : chance.uniform(0, 1);
  options.occlusion_tolerance = chance.uniform(0.005, 0.1);  // with none, rounding decides at every pixel
  options.sampling = chance.below(3) == 0 ? BlendOptions::Sampling::linear : BlendOptions::Sampling::cubic;
  options.exposure = chance.below(2) == 0 ? BlendOptions::Exposure::nearby : BlendOptions::Exposure::model;
  options.supersample = 1 + chance.below(2);
  options.antialias = chance.below(2) == 0 ? BlendOptions::Antialias::all : BlendOptions::Antialias::silhouettes;
  options.frame_fade = chance.below(4) == 0 ? 0 : chance.uniform(0, 0.5);
  return options;
}

struct Comparison {
  std::size_t pixels = 0, textured = 0, different = 0;
};

// Pixels whose face is another one, at silhouettes and where triangles cut through each other, are the rasteriser's
// business: see gl_visibility_test. They are told by the neighbourhood, in which the rays see several surfaces.
bool on_one_face(const VisibilityBuffer& visible, std::size_t x, std::size_t y) {
  if (x == 0 || y == 0 || x + 1 == visible.width || y + 1 == visible.height) return false;
  const std::uint32_t face = visible.face[y * visible.width + x];
  for (std::size_t j = y - 1; j <= y + 1; ++j) {
    for (std::size_t i = x - 1; i <= x + 1; ++i) {
      if (visible.face[j * visible.width + i] != face) return false;
    }
  }
  return true;
}

Comparison compare(Renderer& renderer, const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  const VisibilityBuffer visible = visibility->trace(camera);
  const Rendering cpu = render_reference(snapshot, camera, *visibility, options);
  const Rendering gpu = renderer.render(camera, options);
  Comparison result;
  for (std::size_t pixel = 0; pixel < cpu.state.size(); ++pixel) {
    if (!on_one_face(visible, pixel % camera.width, pixel / camera.width)) continue;
    ++result.pixels;
    result.textured += cpu.state[pixel] == PixelState::textured;
    bool differs = cpu.state[pixel] != gpu.state[pixel];
    for (std::size_t value = 3 * pixel; value < 3 * pixel + 3; ++value) {
      differs |= std::abs(cpu.picture.rgb[value] - gpu.picture.rgb[value]) > 2;
    }
    result.different += differs;
  }
  return result;
}

TEST_CASE("the shader agrees with the CPU reference on random scenes, cameras, references and options") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  Comparison sum;
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    const Snapshot snapshot = random_snapshot(seed);
    renderer.load(snapshot);
    Chance chance(1000 + seed);
    for (int picture = 0; picture < 3; ++picture) {
      const Camera camera = random_camera(chance, 50 + chance.below(60), 50 + chance.below(60));
      const Comparison one = compare(renderer, snapshot, camera, random_options(chance));
      INFO("seed " << seed << ", picture " << picture << ": " << one.different << " of " << one.pixels);
      CHECK(static_cast<double>(one.different) <= 0.01 * static_cast<double>(one.pixels) + 2);
      sum.pixels += one.pixels;
      sum.textured += one.textured;
      sum.different += one.different;
    }
  }
  INFO(sum.different << " of " << sum.pixels << ", " << sum.textured << " textured");
  CHECK(sum.textured > sum.pixels / 4);
  CHECK(static_cast<double>(sum.different) <= 0.001 * static_cast<double>(sum.pixels));
}

TEST_CASE("a camera all but on the surface, and one beside a stored view, show the same by shader and CPU") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = random_snapshot(3);
  Renderer renderer;
  renderer.load(snapshot);
  const Camera inside = forward_camera(60, 40, {0.1, 0.1, 5 - 1e-4});  // all but in the wall
  // At its very place, pixels would fall on pixels, and rounding decide whether a mask that begins there is above 0.
  Camera beside = snapshot.views[0]->camera;
  beside.cx += 0.3;
  beside.cy -= 0.2;
  for (const Camera& camera : {inside, beside}) {
    const Comparison one = compare(renderer, snapshot, camera, {});
    CHECK(one.pixels > 1000);
    CHECK(static_cast<double>(one.different) <= 0.001 * static_cast<double>(one.pixels));
  }
}

}  // namespace
}  // namespace lumatlas
