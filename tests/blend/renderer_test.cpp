// SPDX-License-Identifier: GPL-3.0-or-later
// The shader against its CPU reference, and the laws of the formula that both implement.
#include "blend/renderer.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <set>

#include "atlas/images/srgb.h"
#include "blend/exposure.h"
#include "blend/geometric_weight.h"
#include "blend/gl/gl_objects.h"
#include "blend/reference.h"
#include "blend/sampling/supersampling.h"
#include "blend/tables/fade_zone_shares.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

Rendering reference(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
  return render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), options);
}

constexpr int kLevels = 2;  // of 255, that shader and reference may differ by

std::size_t count(const Rendering& rendering, PixelState state) {
  return static_cast<std::size_t>(std::count(rendering.state.begin(), rendering.state.end(), state));
}

// Between two cameras of the walk, larger and with another field of view than the stored ones.
Camera novel_camera(std::size_t number) {
  Camera camera = room_camera(number);
  const Camera next = room_camera(number + 1);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * ((camera.center() + next.center()) / 2.0));
  camera.width = 320;
  camera.height = 200;
  camera.fx = 190;
  camera.fy = 200;
  camera.cx = 150;
  camera.cy = 105;
  return camera;
}

// DESIGN: at most this share of pixels may differ by more than 2 of 255.
constexpr double kAgreement = 0.001;

TEST_CASE("the shader agrees with the CPU reference for every option") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(14, {});
  Renderer renderer;
  renderer.load(snapshot);
  std::vector<BlendOptions> variants(12);
  variants[1] = BlendOptions::printed();
  variants[1].occlusion_tolerance = 0.02;  // with none, rounding decides at every pixel
  variants[2].views = 1;
  variants[3].views = 8;
  variants[4].lambda = 0;
  variants[5].fade_last = false;
  variants[6].exposure = BlendOptions::Exposure::model;
  variants[7].border_width = 0;
  variants[8].border_width = 0.6;
  variants[9].sampling = BlendOptions::Sampling::linear;
  variants[10].prefilter = false;
  variants[11].consistent = false;
  for (std::size_t variant = 0; variant < variants.size(); ++variant) {
    double different = 0;
    constexpr std::size_t kCameras = 6;
    for (std::size_t number = 0; number < kCameras; ++number) {
      const Camera camera = novel_camera(3 * number);
      const Rendering cpu = reference(snapshot, camera, variants[variant]);
      REQUIRE(count(cpu, PixelState::textured) > 0);
      different += share_different(renderer.render(camera, variants[variant]), cpu, kLevels) / kCameras;
    }
    INFO("variant " << variant);
    CHECK(different <= kAgreement);
  }
}

// Views whose gains differ, also from channel to channel.
Snapshot room_with_gains(std::size_t views) {
  Snapshot snapshot = room_snapshot(views, {});
  for (std::size_t slot = 0; slot < views; ++slot) {
    snapshot.gains[slot] = glm::dvec3(0.5, 1.9, 0.8) + static_cast<double>(slot) * glm::dvec3(0.2, -0.2, 0.1);
  }
  return snapshot;
}

TEST_CASE(
    "the shader agrees with the CPU reference on gains that differ by channel, lens masks and mixed photograph sizes") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_with_gains(8);
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    StoredView view = *snapshot.views[slot];
    if (slot % 2 == 0) {
      const Camera camera = view.camera.scaled_to(61, 90);
      Photograph photograph = pattern_photograph(camera, slot);
      photograph.valid.assign(61 * 90, 255);
      std::fill_n(photograph.valid.begin(), 61 * 20, std::uint8_t{0});
      const auto visibility = make_ray_visibility(snapshot.surface->mesh);
      view = make_stored_view(view.name, camera, photograph, visibility->trace(camera), {});
    }
    snapshot.views[slot] = std::make_shared<const StoredView>(view);
  }
  Renderer renderer;
  renderer.load(snapshot);
  for (const auto exposure : {BlendOptions::Exposure::nearby, BlendOptions::Exposure::model}) {
    BlendOptions options;
    options.exposure = exposure;
    double different = 0;
    for (std::size_t number = 0; number < 6; ++number) {
      const Camera camera = novel_camera(number);
      different += share_different(renderer.render(camera, options), reference(snapshot, camera, options), kLevels) / 6;
    }
    CHECK(different <= kAgreement);
  }
}

TEST_CASE("where all gains are 1, the exposure of nearby photographs and the model's give the same bytes") {
  const Snapshot snapshot = room_snapshot(6, {});
  BlendOptions model;
  model.exposure = BlendOptions::Exposure::model;
  const Camera camera = novel_camera(2);
  CHECK(reference(snapshot, camera, {}).picture.rgb == reference(snapshot, camera, model).picture.rgb);
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  CHECK(renderer.render(camera, {}).picture.rgb == renderer.render(camera, model).picture.rgb);
}

Snapshot without_references(Snapshot snapshot) {
  snapshot.references.views.clear();
  snapshot.references.offsets.assign(snapshot.references.offsets.size(), 0);
  return snapshot;
}

// That a picture in the exposure of nearby photographs is the model's picture, times one factor in linear light.
void check_exposed(const Snapshot& snapshot, const Camera& camera) {
  const glm::dvec3 exposure = NearbyExposure(snapshot).at(camera);
  REQUIRE(glm::all(glm::greaterThan(glm::abs(exposure - 1.0), glm::dvec3(0.05))));
  BlendOptions model;
  model.exposure = BlendOptions::Exposure::model;
  const std::vector<std::uint8_t> common = reference(snapshot, camera, model).picture.rgb;
  const Rendering shown = reference(snapshot, camera, {});
  for (std::size_t value = 0; value < common.size(); ++value) {
    if (common[value] == 255) continue;  // clipped
    const double linear = linear_from_srgb(common[value] / 255.0);
    const int expected = srgb8_from_linear(exposure[static_cast<int>(value % 3)] * linear);
    REQUIRE(std::abs(shown.picture.rgb[value] - expected) <= 3);  // both rounded, the second after the factor
  }
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  CHECK(share_different(renderer.render(camera, {}), shown, kLevels) <= kAgreement);
}

TEST_CASE("blended colours and vertex colours are both shown in the exposure of the photographs nearby") {
  const Camera camera = novel_camera(1);
  const Snapshot textured = room_with_gains(4);
  REQUIRE(count(reference(textured, camera, {}), PixelState::textured) > 1000);
  check_exposed(textured, camera);
  const Snapshot fallback = without_references(textured);
  REQUIRE(count(reference(fallback, camera, {}), PixelState::untextured) > 1000);
  check_exposed(fallback, camera);
}

TEST_CASE("a stored view rendered from its own camera alone is its photograph, wherever it is valid") {
  Snapshot snapshot = room_snapshot(1, ValidityOptions::printed());
  snapshot.gains[0] = {3.1, 0.4, 0.9};  // the picture has its exposure
  const StoredView& view = *snapshot.views[0];
  const auto check_picture = [&](const Rendering& rendering) {
    std::size_t compared = 0;
    for (std::size_t pixel = 0; pixel < rendering.state.size(); ++pixel) {
      if (view.mask->validity[pixel] != 255) continue;
      ++compared;
      REQUIRE(rendering.state[pixel] == PixelState::textured);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        // Sampled at the pixel's centre: no interpolation, only rounding there and back.
        REQUIRE(std::abs(rendering.picture.rgb[3 * pixel + channel] - view.photograph->color(pixel).at(channel)) <= 1);
      }
    }
    CHECK(compared > rendering.state.size() / 2);
  };
  check_picture(reference(snapshot, view.camera, {}));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  check_picture(renderer.render(view.camera, {}));
}

// How many of a stored view's valid pixels away from silhouettes, and from the border where the view fades, are another
// colour than its photograph's in a picture from its own place, as a share of those.
double share_not_shown(const StoredView& view, const Snapshot& snapshot, const Rendering& rendering,
                       const BlendOptions& options) {
  const glm::dvec2 size(view.camera.width, view.camera.height);
  const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(view.camera);
  const std::vector<std::uint8_t> at_silhouette = silhouettes(view.camera, visible);
  std::size_t compared = 0;
  std::size_t different = 0;
  for (std::size_t pixel = 0; pixel < rendering.state.size(); ++pixel) {
    if (view.mask->validity[pixel] != 255 || at_silhouette[pixel]) continue;
    const std::size_t column = pixel % view.camera.width, row = pixel / view.camera.width;
    const glm::dvec2 image(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
    if (frame_share(image, size, options.frame_fade) < 1) continue;
    ++compared;
    bool differs = false;
    for (std::size_t value = 3 * pixel; value < 3 * pixel + 3; ++value) {
      differs |= std::abs(rendering.picture.rgb[value] - view.photograph->color(value / 3).at(value % 3)) > 1;
    }
    different += differs;
  }
  REQUIRE(compared > rendering.state.size() / 3);
  return static_cast<double>(different) / static_cast<double>(compared);
}

TEST_CASE("at a stored view's place the picture is its photograph, however many others see the same") {
  const Snapshot snapshot = room_snapshot(14, {});
  const std::optional<EglContext> context = context_or_skip();
  std::optional<Renderer> renderer;
  if (context) renderer.emplace().load(snapshot);
  BlendOptions to_the_border;  // with the fade a photograph is shown alone only inside of its band
  to_the_border.frame_fade = 0;
  BlendOptions inconsistent = to_the_border;
  inconsistent.consistent = false;
  double without = 0;
  const auto share_by_reference = [&](const StoredView& view, const BlendOptions& options) {
    return share_not_shown(view, snapshot, reference(snapshot, view.camera, options), options);
  };
  for (const auto& view : snapshot.views) {
    for (const BlendOptions& options : {BlendOptions{}, to_the_border}) {
      CHECK(share_by_reference(*view, options) <= 0.001);
      if (!renderer) continue;
      CHECK(share_not_shown(*view, snapshot, renderer->render(view->camera, options), options) <= 0.001);
    }
    without += share_by_reference(*view, inconsistent) / 14;
  }
  CHECK(without > 0.1);  // else these scenes say nothing
}

TEST_CASE("the nearer a picture is to a stored view's place, the less it differs from the photograph") {
  const Snapshot snapshot = room_snapshot(14, {});
  const StoredView& view = *snapshot.views[5];
  double before = 256;
  for (const double away : {0.1, 0.03, 0.01, 0.003, 0.0}) {
    Camera camera = view.camera;
    camera.cam_from_world_translation += away * glm::dvec3(0.6, -0.2, 0.4);
    const Rendering rendering = reference(snapshot, camera, {});
    double sum = 0;
    for (std::size_t value = 0; value < rendering.picture.rgb.size(); ++value) {
      if (view.mask->validity[value / 3] == 255)
        sum += std::abs(rendering.picture.rgb[value] - view.photograph->color(value / 3).at(value % 3));
    }
    const double mean = sum / static_cast<double>(rendering.picture.rgb.size());
    CHECK(mean < before);
    before = mean;
  }
}

TEST_CASE("the GPU sees the same faces as the rays, away from silhouettes") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(3, {});
  Renderer renderer;
  renderer.load(snapshot);
  const Camera camera = novel_camera(5);
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  const VisibilityBuffer visible = visibility->trace(camera);
  const Rendering rendering = renderer.render(camera, {});
  for (std::size_t pixel = 0; pixel < rendering.state.size(); ++pixel) {
    REQUIRE((rendering.state[pixel] == PixelState::empty) == (visible.face[pixel] == FaceId::none));
  }
}

TEST_CASE("cells that no view saw are told apart from cells that were seen but have no valid view") {
  const Snapshot snapshot = without_references(room_snapshot(3, {}));
  const Camera camera = novel_camera(9);
  const auto check_states = [&](const Rendering& rendering) {
    CHECK(count(rendering, PixelState::textured) == 0);
    CHECK(count(rendering, PixelState::untextured) > 0);
    CHECK(count(rendering, PixelState::unseen) > 0);
  };
  check_states(reference(snapshot, camera, {}));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  const Rendering rendering = renderer.render(camera, {});
  check_states(rendering);
  CHECK(share_different(rendering, reference(snapshot, camera, {}), kLevels) <= kAgreement);
}

// Two views of one wall, one of them wholly red, the other wholly green.
Snapshot red_and_green() {
  Snapshot snapshot = room_snapshot(2, ValidityOptions::printed());
  for (std::size_t slot = 0; slot < 2; ++slot) {
    StoredView view = *snapshot.views[0];  // the same camera twice, moved apart below
    view.camera.cam_from_world_translation += glm::dvec3(slot == 0 ? 0.05 : -0.15, 0, 0);
    change_photograph(view, [&](Photograph& photograph) {
      for (std::size_t pixel = 0; pixel < view.mask->validity.size(); ++pixel) {
        photograph.rgb[3 * pixel] = slot == 0 ? 255 : 0;
        photograph.rgb[3 * pixel + 1] = slot == 0 ? 0 : 255;
        photograph.rgb[3 * pixel + 2] = 0;
      }
    });
    snapshot.views[slot] = std::make_shared<const StoredView>(view);
  }
  snapshot.references.views.clear();
  snapshot.references.offsets = {0};
  for (std::size_t cell = 0; cell < snapshot.surface->cells.cells.size(); ++cell) {
    snapshot.references.views.insert(snapshot.references.views.end(), {0, 1});
    snapshot.references.offsets.push_back(static_cast<std::uint32_t>(snapshot.references.views.size()));
  }
  return snapshot;
}

TEST_CASE("with fewer views than K all of them are blended by their weights, in linear light") {
  const Snapshot snapshot = red_and_green();
  const Camera camera = room_camera(0);
  const Rendering rendering = reference(snapshot, camera, {});
  const std::size_t middle = 36 * 96 + 48;
  REQUIRE(rendering.state[middle] == PixelState::textured);
  const double red = linear_from_srgb(rendering.picture.rgb[3 * middle] / 255.0);
  const double green = linear_from_srgb(rendering.picture.rgb[3 * middle + 1] / 255.0);
  CHECK(red + green == Approx(1).margin(0.02));  // 8 bits of sRGB each
  CHECK(red > green);                            // the red camera is nearer to the novel one
  CHECK(green > 0.2);
}

// The largest difference between neighbours in a row or a column that both show a surface, levels.
int largest_step(const Rendering& rendering, std::size_t width) {
  int largest = 0;
  for (std::size_t pixel = width; pixel < rendering.state.size(); ++pixel) {
    for (const std::size_t other : {pixel - 1, pixel - width}) {
      if (pixel % width == 0 && other == pixel - 1) continue;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const auto& rgb = rendering.picture.rgb;
        largest = std::max(largest, std::abs(rgb[3 * pixel + channel] - rgb[3 * other + channel]));
      }
    }
  }
  return largest;
}

TEST_CASE("two cells that refer to one view each meet in a line as printed, and fade into each other by default") {
  Snapshot snapshot = red_and_green();
  auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 40, 30, 0.125F, 2);  // fine enough to fade on
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < surface->mesh.faces.size(); ++face) cell_of_face.emplace_back(face / 2 % 40 / 20);
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 2.5);
  const Camera camera = forward_camera(96, 72);
  for (std::size_t slot = 0; slot < 2; ++slot) {
    Photograph photograph = snapshot.views[slot]->photograph->whole();
    photograph.valid.clear();
    snapshot.views[slot] = std::make_shared<const StoredView>(traced_view(*surface, "", camera, photograph));
  }
  snapshot.vertex_colors = FallbackColors::Colors(surface->mesh.positions.size(), glm::u8vec3(0));
  snapshot.references = {{0, 1, 2}, {0, 1}};
  snapshot.cell_seen = {1, 1};
  snapshot.surface = surface;
  BlendOptions hard;
  hard.border_width = 0;
  BlendOptions soft;
  soft.border_width = 0.4;  // 1 of the scene's units, 48 pixels
  CHECK(largest_step(reference(snapshot, camera, hard), camera.width) == 255);
  CHECK(largest_step(reference(snapshot, camera, soft), camera.width) < 80);  // sRGB rises steeply from black
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  for (const BlendOptions& options : {hard, soft, hard}) {  // one renderer, changing its mind
    CHECK(share_different(renderer.render(camera, options), reference(snapshot, camera, options), kLevels) <=
          kAgreement);
  }
}

// Says of one view that the other views contradict all of it.
void distrust(Snapshot& snapshot, std::size_t slot) {
  StoredView view = *snapshot.views[slot];
  const std::vector<std::uint8_t> contradicted(view.mask->validity.size(), 0);
  own_mask(view).validity =
      validity_mask(view.photograph->whole(), view.mask->depth.all(), contradicted, ValidityOptions::printed());
  snapshot.views[slot] = std::make_shared<const StoredView>(view);
}

TEST_CASE("a contradicted view hardly shows beside another one, and is shown rather than a hole") {
  const Camera camera = room_camera(0);
  const std::size_t middle = 36 * 96 + 48;
  Snapshot snapshot = red_and_green();
  const Rendering both_trusted = reference(snapshot, camera, {});
  distrust(snapshot, 0);
  Snapshot alone = snapshot;
  std::fill(alone.references.views.begin(), alone.references.views.end(), ViewSlot{0});
  const auto check_pictures = [&](const Rendering& beside, const Rendering& only) {
    // The red view is the better one by its place: up to twice the green one's weight, times 1/255.
    CHECK(linear_from_srgb(beside.picture.rgb[3 * middle] / 255.0) < 2.5 / 255);
    CHECK(beside.state == both_trusted.state);
    REQUIRE(only.state[middle] == PixelState::textured);
    CHECK(only.picture.rgb[3 * middle] == 255);
    CHECK(only.picture.rgb[3 * middle + 1] == 0);
  };
  check_pictures(reference(snapshot, camera, {}), reference(alone, camera, {}));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  const Rendering beside = renderer.render(camera, {});
  renderer.load(alone);
  check_pictures(beside, renderer.render(camera, {}));
}

TEST_CASE("with K = 1 and the fade of the last view, the best view alone is shown") {
  BlendOptions best_only;
  best_only.views = 1;
  const Rendering rendering = reference(red_and_green(), room_camera(0), best_only);
  const std::size_t middle = 36 * 96 + 48;
  CHECK(rendering.picture.rgb[3 * middle] == 255);
  CHECK(rendering.picture.rgb[3 * middle + 1] == 0);
}

TEST_CASE("a camera with nothing in view gives an empty picture") {
  const std::optional<EglContext> context = context_or_skip();
  const Snapshot snapshot = room_snapshot(2, {});
  Camera away = room_camera(0);
  away.cam_from_world_rotation = glm::dmat3(1);
  away.cam_from_world_translation = {500, 500, 500};
  CHECK(count(reference(snapshot, away, {}), PixelState::empty) == 96 * 72);
  if (!context) return;
  Renderer renderer;
  renderer.load(snapshot);
  const Rendering rendering = renderer.render(away, {});
  CHECK(count(rendering, PixelState::empty) == 96 * 72);
  CHECK(rendering.picture.rgb == std::vector<std::uint8_t>(3 * 96 * 72, 0));
}

TEST_CASE("a renderer can load another snapshot, and render at one size after another") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  for (const std::size_t views : {std::size_t{5}, std::size_t{1}, std::size_t{9}}) {
    const Snapshot snapshot = room_snapshot(views, {});
    renderer.load(snapshot);
    for (const std::uint32_t width : {64u, 250u}) {
      const Camera camera = room_camera(4).scaled_to(width, 3 * width / 4);
      CHECK(share_different(renderer.render(camera, {}), reference(snapshot, camera, {}), kLevels) <= kAgreement);
    }
  }
}

TEST_CASE("a renderer without a snapshot, and bad options, are refused by name") {
  BlendOptions options;
  options.views = 9;
  CHECK_THROWS_WITH(check(options), Catch::Contains("views is 9"));
  options = {};
  options.border_width = 1.5;
  CHECK_THROWS_WITH(check(options), Catch::Contains("border_width"));
  options = {};
  options.lambda = -0.1;
  CHECK_THROWS_WITH(check(options), Catch::Contains("lambda"));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  CHECK_THROWS_WITH(renderer.render(room_camera(0), {}), Catch::Contains("no snapshot is loaded"));
}

// Names of every kind that are in use in the current context.
std::size_t gl_objects() {
  std::size_t objects = 0;
  for (GLuint name = 1; name < 4000; ++name) {
    objects += glIsBuffer(name) + glIsTexture(name) + glIsFramebuffer(name) + glIsVertexArray(name) + glIsShader(name) +
               glIsProgram(name);
  }
  return objects;
}

TEST_CASE("a renderer gives back every GL object, whatever it loaded, drew and was refused") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const std::size_t before = gl_objects();
  std::size_t with_one = 0;
  for (int round = 0; round < 3; ++round) {
    Renderer renderer;
    for (const std::size_t views : {std::size_t{4}, std::size_t{2}}) {
      renderer.load(room_snapshot(views, {}));
      for (const double width : {0.0, 0.3}) {
        BlendOptions options;
        options.border_width = width;
        CHECK(count(renderer.render(room_camera(1), options), PixelState::textured) > 0);
        CHECK(count(renderer.render(room_camera(2).scaled_to(40, 30), options), PixelState::textured) > 0);
      }
    }
    Snapshot many = room_snapshot(1, {});
    many.views.resize(1u << 20, many.views[0]);
    many.gains.resize(many.views.size(), glm::dvec3(1));
    CHECK_THROWS_AS(renderer.load(many), GlError);
    renderer.load(room_snapshot(1, {}));
    CHECK(count(renderer.render(room_camera(0), {}), PixelState::textured) > 0);
    if (round == 0) with_one = gl_objects();
    CHECK(gl_objects() == with_one);
  }
  CHECK(with_one > before + 10);
  CHECK(gl_objects() == before);
}

TEST_CASE("a model that does not fit the memory that is free is refused with both numbers and what to do") {
  CHECK_NOTHROW(require_gl_memory(1u << 20, 1u << 20, "its photographs", "use fewer"));
  CHECK_NOTHROW(require_gl_memory(std::uint64_t{1} << 50, std::nullopt, "its photographs", "use fewer"));
  CHECK_THROWS_WITH(
      require_gl_memory((std::uint64_t{5} << 30) + 1, std::uint64_t{2} << 30, "its photographs", "use fewer"),
      "the model needs 5121 MiB of GPU memory for its photographs, of which 2048 MiB are free: use fewer");
}

TEST_CASE("the steps for speed change no picture") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(14, {});
  Renderer renderer;
  renderer.load(snapshot);
  const auto picture = [&](const RendererOptions& steps) {
    renderer.set_options(steps);
    return renderer.render(novel_camera(4), {}).picture.rgb;
  };
  const std::vector<std::uint8_t> plain = picture({false, false});
  CHECK(picture({.skip_losers = true, .join_cells = false}) == plain);
  CHECK(picture({false, false}) == plain);  // and back again
}

TEST_CASE("neighbours of the same references that are drawn as one cell change no picture beyond rounding") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(14, {});
  const std::vector<std::uint32_t> first = first_of_same_references(snapshot.references);
  const std::set<std::uint32_t> kinds(first.begin(), first.end());
  REQUIRE(kinds.size() > 10);
  REQUIRE(kinds.size() < first.size());
  Renderer joining, separate({.skip_losers = true, .join_cells = false});
  joining.load(snapshot);
  separate.load(snapshot);
  BlendOptions options;
  for (const double width : {0.0, 0.1, 0.6}) {
    options.border_width = width;
    CAPTURE(width);
    for (const std::size_t number : {1u, 5u, 9u}) {
      const Rendering one = joining.render(novel_camera(number), options);
      const Rendering other = separate.render(novel_camera(number), options);
      CHECK(one.state == other.state);
      CHECK(share_different(one, other, 1) == 0);
    }
  }
  joining.set_options({.skip_losers = true, .join_cells = false});
  CHECK(joining.render(novel_camera(1), options).picture.rgb == separate.render(novel_camera(1), options).picture.rgb);
}

TEST_CASE("more photographs than the driver has layers are refused with what to do") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(1, {});
  snapshot.views.resize(1u << 20, snapshot.views[0]);
  Renderer renderer;
  snapshot.gains.resize(snapshot.views.size(), glm::dvec3(1));
  CHECK_THROWS_WITH(renderer.load(snapshot), Catch::Contains("1048576 views") && Catch::Contains("--max-views"));
  CHECK_THROWS_WITH(renderer.render(room_camera(0), {}), Catch::Contains("no snapshot is loaded"));
}

}  // namespace
}  // namespace lumatlas
