// SPDX-License-Identifier: GPL-3.0-or-later
// The picture stays continuous at the end of a view of any rank, by the CPU reference and by the shader.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "blend/geometric_weight.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr double kEndsDepth = 4;
constexpr double kFrameFade = 0.02;          // 4 pixels of the photographs
constexpr std::uint32_t kRowColumns = 5000;  // of the picture, whose one row crosses the place where views end

// How far aside of the picture's camera the stored ones are, best first. The fifth is far off, so that the blended
// views' shares change much where the fourth ends.
struct EndPlaces {
  const char* name;
  std::vector<double> aside;
};
const EndPlaces kAside{"beside all views", {0.4, -0.6, 0.7, -0.75, 1.4, -1.6}};
const EndPlaces kAtFirst{"at the place of the first view", {0, -0.6, 0.7, -0.75, 1.4, -1.6}};

// A photograph of one colour: of three channels, any two views have one that is high in one view and low in the other.
Photograph flat_photograph(const Camera& camera, std::uint32_t number) {
  Photograph photograph{camera.width, camera.height, {}, {}};
  const std::uint32_t bits = number + 1;
  for (std::size_t pixel = 0; pixel < std::size_t{camera.width} * camera.height; ++pixel) {
    for (const std::uint32_t channel : {0u, 1u, 2u}) photograph.rgb.push_back((bits >> channel & 1u) != 0u ? 220 : 60);
  }
  return photograph;
}

// Views of a wall. Those of the ranks `ending` have their right border at x = 0 on the wall; the others are wider than
// the picture.
Snapshot wall_with_ends(const EndPlaces& places, const std::vector<std::size_t>& ending,
                        const ValidityOptions& validity = {}) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 1, 1, 80, kEndsDepth);
  surface->cells = measure_cells(surface->mesh, {0, 0}, 80);
  Atlas atlas(surface, static_cast<std::uint32_t>(places.aside.size()));
  std::vector<ViewSlot> slots;
  for (std::size_t rank = 0; rank < places.aside.size(); ++rank) {
    Camera camera = forward_camera(400, 200, {places.aside[rank], 0, 0});
    camera.fx = camera.fy = 100;
    const bool ends = std::find(ending.begin(), ending.end(), rank) != ending.end();
    if (ends) camera.cx = camera.width + camera.fx * places.aside[rank] / kEndsDepth;
    slots.push_back(atlas.insert(
        traced_view(*surface, "", camera, flat_photograph(camera, static_cast<std::uint32_t>(rank)), validity)));
  }
  atlas.set_references(0, slots);
  return atlas.snapshot();
}

// Sees a row of the wall around x = 0, enlarged so that the band in which views fade takes 2400 columns.
Camera row_camera() {
  Camera camera = forward_camera(kRowColumns, 1);
  camera.fx = camera.fy = 60000;
  return camera;
}

// Masks without a fade.
const ValidityOptions kInAStep = [] {
  ValidityOptions options;
  options.fade_px = 0;
  return options;
}();

using DrawRow = std::function<Rendering(const Snapshot&, const BlendOptions&)>;

Rendering row_by_reference(const Snapshot& snapshot, const BlendOptions& options) {
  return render_reference(snapshot, row_camera(), *make_ray_visibility(snapshot.surface->mesh), options);
}

// The largest difference between neighbours in the row, levels.
int step_of_row(const Rendering& rendering) {
  int largest = 0;
  for (std::size_t value = 3; value < rendering.picture.rgb.size(); ++value) {
    largest = std::max(largest, std::abs(rendering.picture.rgb[value] - rendering.picture.rgb[value - 3]));
  }
  return largest;
}

// A fade over 2400 columns changes by less than a level from one to the next where it is even, and by three where it is
// steepest. A view that ends in a line changes by six or more.
constexpr int kLargestStep = 3;
constexpr int kLine = 6;

void check_ends(const EndPlaces& places, const std::vector<std::size_t>& ending, const DrawRow& render) {
  const Snapshot snapshot = wall_with_ends(places, ending);
  BlendOptions options;
  options.frame_fade = kFrameFade;
  for (const bool consistent : {true, false}) {
    CAPTURE(places.name, ending, consistent);
    options.consistent = consistent;
    const Rendering faded = render(snapshot, options);
    CHECK(std::count(faded.state.begin(), faded.state.end(), PixelState::textured) == kRowColumns);
    CHECK(step_of_row(faded) <= kLargestStep);
    BlendOptions in_a_line = options;
    in_a_line.frame_fade = 0;
    const bool counts = ending.front() <= options.views;  // is blended, or the next best one
    const int step = step_of_row(render(wall_with_ends(places, ending, kInAStep), in_a_line));
    // Alone, the first view leaves no part to views that end.
    const bool alone = consistent && places.aside.front() == 0 && ending.front() > 0;
    if (counts && !alone) CHECK(step >= kLine);
    if (!counts || alone) CHECK(step <= 1);
  }
}

void check_all_ends(const DrawRow& render) {
  for (const EndPlaces& places : {kAside, kAtFirst}) {
    for (std::size_t rank = 0; rank < places.aside.size(); ++rank) check_ends(places, {rank}, render);
    check_ends(places, {0, 3}, render);
    check_ends(places, {1, 2}, render);
    check_ends(places, {0, 1, 2, 3}, render);
  }
}

TEST_CASE("where a view of any rank ends, the picture is continuous") {
  check_all_ends(row_by_reference);
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  check_all_ends([&](const Snapshot& snapshot, const BlendOptions& options) {
    renderer.load(snapshot);
    return renderer.render(row_camera(), options);
  });
}

// What ends a view within its photograph: a lens mask, or a pole between its camera and the wall.
enum class InnerEnd { lens_mask, pole };

constexpr double kPoleDepth = 2;
constexpr double kPoleWidth = 0.2;
constexpr std::size_t kEndingView = 0;  // the best one

// A wall on whose part right of x = 0 the best view does not show. The row does not see the pole.
Snapshot wall_with_inner_end(InnerEnd end, const ValidityOptions& validity) {
  const double aside = kAside.aside[kEndingView];
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 1, 1, 80, kEndsDepth);
  if (end == InnerEnd::pole) {
    const double left = aside * (1 - kPoleDepth / kEndsDepth);
    const auto first = static_cast<std::uint32_t>(surface->mesh.positions.size());
    for (const double x : {left, left + kPoleWidth}) {
      for (const double y : {-9.0, 9.0}) surface->mesh.positions.emplace_back(x, y, kPoleDepth);
    }
    surface->mesh.faces.emplace_back(first, first + 1, first + 2);
    surface->mesh.faces.emplace_back(first + 2, first + 1, first + 3);
  }
  surface->cells = measure_cells(surface->mesh, std::vector<CellId>(surface->mesh.faces.size(), 0), 80);
  Atlas atlas(surface, static_cast<std::uint32_t>(kAside.aside.size()));
  std::vector<ViewSlot> slots;
  for (std::size_t rank = 0; rank < kAside.aside.size(); ++rank) {
    Camera camera = forward_camera(400, 200, {kAside.aside[rank], 0, 0});
    camera.fx = camera.fy = 100;
    Photograph photograph = flat_photograph(camera, static_cast<std::uint32_t>(rank));
    if (end == InnerEnd::lens_mask && rank == kEndingView) {
      const double column_of_end = camera.cx - camera.fx * aside / kEndsDepth;
      for (std::uint32_t pixel = 0; pixel < camera.width * camera.height; ++pixel) {
        photograph.valid.push_back(pixel % camera.width < column_of_end ? 255 : 0);
      }
    }
    slots.push_back(atlas.insert(traced_view(*surface, "", camera, std::move(photograph), validity)));
  }
  atlas.set_references(0, slots);
  return atlas.snapshot();
}

// Sees 12 pixels of the stored views on the wall, of which the band of `fade_px` takes four.
Camera wide_row_camera() {
  Camera camera = row_camera();
  camera.fx = camera.fy = kRowColumns * kEndsDepth / (12 * 0.04);
  return camera;
}

using DrawPicture = std::function<Rendering(const Snapshot&, const Camera&)>;

void check_inner_ends(const DrawPicture& render) {
  for (const InnerEnd end : {InnerEnd::lens_mask, InnerEnd::pole}) {
    CAPTURE(static_cast<int>(end));
    const Rendering faded = render(wall_with_inner_end(end, {}), wide_row_camera());
    CHECK(std::count(faded.state.begin(), faded.state.end(), PixelState::textured) == kRowColumns);
    // The best view's colour at the left, at the right one without it.
    REQUIRE(std::abs(faded.picture.rgb[2] - faded.picture.rgb[3 * kRowColumns - 1]) > 20);
    CHECK(step_of_row(faded) <= kLargestStep);
    CHECK(step_of_row(render(wall_with_inner_end(end, kInAStep), wide_row_camera())) >= kLine);
  }
}

TEST_CASE("where a view ends at a lens mask or behind something, the picture is continuous") {
  check_inner_ends([](const Snapshot& snapshot, const Camera& camera) {
    return render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), {});
  });
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  check_inner_ends([&](const Snapshot& snapshot, const Camera& camera) {
    renderer.load(snapshot);
    return renderer.render(camera, {});
  });
}

TEST_CASE("what only the band of one view sees shows that view") {
  const Snapshot snapshot = wall_with_ends({"one view", {1.4}}, {0});
  const auto check_shown = [&](const Rendering& rendering) {
    for (std::size_t column = 0; column < kRowColumns / 2 - 1; ++column) {
      REQUIRE(rendering.state[column] == PixelState::textured);
      REQUIRE(rendering.picture.rgb[3 * column] == 220);
    }
    CHECK(rendering.state[kRowColumns / 2 + 1] != PixelState::textured);
  };
  check_shown(row_by_reference(snapshot, {}));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  check_shown(renderer.render(row_camera(), {}));
}

TEST_CASE("the share of a photograph rises from 0 at its border to 1 at the band's end, from each side") {
  BlendOptions options;
  options.frame_fade = 0.1;
  const glm::dvec2 size(300, 200);
  const auto share = [&](double x, double y) { return frame_share({x, y}, size, options.frame_fade); };
  CHECK(share(0, 100) == 0);
  CHECK(share(10, 100) == Approx(0.5));
  CHECK(share(290, 100) == Approx(0.5));
  CHECK(share(150, 10) == Approx(0.5));
  CHECK(share(150, 190) == Approx(0.5));
  CHECK(share(10, 190) == Approx(0.25));
  CHECK(share(20, 100) == 1);
  CHECK(share(280, 180) == 1);
  for (double x = 1; x <= 20; ++x) CHECK(share(x, 100) > share(x - 1, 100));
  options.frame_fade = 0;
  CHECK(share(0, 0) == 1);
}

TEST_CASE("a view's weight rises with the share that is left of it, from 0 to the weight") {
  for (const double weight : {0.0, 1e-6, 0.3, 0.9, 1.0}) {
    CHECK(faded_weight(weight, 0) == 0);
    CHECK(faded_weight(weight, 1) == weight);
    double before = 0;
    for (int step = 1; step <= 1000; ++step) {
      const double here = faded_weight(weight, step / 1000.0);
      CHECK(here <= weight);
      CHECK((weight == 0 ? here == 0 : here > before));
      CHECK(here - before < 0.12);  // continuous: steepest where the weight is 1, by 1 / kFadePenalty a unit
      before = here;
    }
  }
}

}  // namespace
}  // namespace lumatlas
