// SPDX-License-Identifier: GPL-3.0-or-later
// The diagnosis of pixels: the shader against the CPU reference, and both against the picture.
#include "blend/diagnosis.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <optional>

#include "atlas/images/srgb.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"

namespace lumatlas {
namespace {

// Its pixels' middles fall on the edges of no pixels of the stored view at its place, where rounding would decide.
Camera wide_camera(std::size_t number) {
  return room_camera(number).scaled_to(239, 179);
}

Diagnosis by_reference(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  return diagnose_reference(snapshot, camera, visibility->trace(camera), options);
}

Rendering picture_by_reference(const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
  const auto visibility = make_ray_visibility(snapshot.surface->mesh);
  return render_reference(snapshot, camera, visibility->trace(camera), options);
}

bool agree(const PixelDiagnosis& a, const PixelDiagnosis& b) {
  bool same = a.valid_views == b.valid_views && a.winner == b.winner;
  for (std::size_t rank = 0; rank < 3; ++rank) same = same && std::abs(a.shares[rank] - b.shares[rank]) < 0.01f;
  return same;
}

// Fades, borders and ties are decided by rounding: as for pictures.
constexpr double kDiagnosisAgreement = 0.001;

TEST_CASE("the shader's diagnosis agrees with the CPU reference for every option that it depends on") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(14, {});
  Renderer renderer;
  renderer.load(snapshot);
  std::vector<BlendOptions> variants(7);
  variants[1].views = 1;
  variants[2].views = 8;
  variants[3].fade_last = false;
  variants[4].lambda = 0;
  variants[5] = BlendOptions::printed();
  variants[5].occlusion_tolerance = 0.02;  // with none, rounding decides at every pixel
  variants[6].consistent = false;
  for (std::size_t variant = 0; variant < variants.size(); ++variant) {
    CAPTURE(variant);
    std::size_t different = 0;
    std::size_t pixels = 0;
    for (std::size_t number = 1; number < 14; number += 3) {
      const Camera camera = wide_camera(number);
      const Diagnosis cpu = by_reference(snapshot, camera, variants[variant]);
      const Diagnosis gpu = renderer.diagnose(camera, variants[variant]);
      REQUIRE(gpu.pixels.size() == cpu.pixels.size());
      for (std::size_t pixel = 0; pixel < cpu.pixels.size(); ++pixel) {
        different += !agree(cpu.pixels[pixel], gpu.pixels[pixel]) || cpu.state[pixel] != gpu.state[pixel];
      }
      pixels += cpu.pixels.size();
    }
    CHECK(static_cast<double>(different) <= kDiagnosisAgreement * static_cast<double>(pixels));
  }
}

// Three views of one colour each, so that a picture's colours are the views' shares.
Snapshot red_green_and_blue() {
  Snapshot snapshot = room_snapshot(3, {});
  for (std::size_t slot = 0; slot < 3; ++slot) {
    StoredView view = *snapshot.views[slot];
    view.camera = snapshot.views[0]->camera;
    view.mask = snapshot.views[0]->mask;
    // Apart, but so little that all see the same.
    view.camera.cam_from_world_translation += 0.003 * static_cast<double>(slot * slot) * glm::dvec3(1, 0.5, 0);
    change_photograph(view, [&](Photograph& photograph) {
      for (std::size_t value = 0; value < photograph.rgb.size(); ++value) {
        photograph.rgb[value] = value % 3 == slot ? 255 : 0;
      }
    });
    snapshot.views[slot] = std::make_shared<const StoredView>(view);
  }
  for (std::size_t cell = 0; cell + 1 < snapshot.references.offsets.size(); ++cell) {
    snapshot.references.offsets[cell + 1] = 3 * static_cast<std::uint32_t>(cell + 1);
  }
  snapshot.references.views.clear();
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    snapshot.references.views.insert(snapshot.references.views.end(), {2, 0, 1});
  }
  return snapshot;
}

// The picture's own colours, brightest first, are the shares, and the brightest channel is the winner's.
std::size_t check_explains(const Diagnosis& diagnosis, const Rendering& rendering) {
  std::size_t blended = 0;
  for (std::size_t pixel = 0; pixel < diagnosis.pixels.size(); ++pixel) {
    if (rendering.state[pixel] != PixelState::textured) continue;
    const PixelDiagnosis& told = diagnosis.pixels[pixel];
    const std::uint8_t* rgb = &rendering.picture.rgb[3 * pixel];
    REQUIRE(told.winner < 3);
    CHECK(rgb[told.winner] == *std::max_element(rgb, rgb + 3));
    std::array<double, 3> light{};
    for (std::size_t channel = 0; channel < 3; ++channel) light[channel] = linear_from_srgb(rgb[channel] / 255.0);
    std::sort(light.begin(), light.end(), std::greater<>());
    for (std::size_t rank = 0; rank < 3; ++rank) {
      // A level of sRGB is up to 0.0089 of linear light.
      REQUIRE(static_cast<double>(told.shares[rank]) == Approx(light[rank]).margin(0.01));
    }
    blended += told.shares[1] > 0.1f;
  }
  return blended;
}

TEST_CASE("the shares and the winner explain the picture's colours") {
  const Snapshot snapshot = red_green_and_blue();
  const std::optional<EglContext> context = context_or_skip();
  for (const bool fade : {true, false}) {
    for (const std::uint32_t views : {1u, 2u, 3u}) {
      BlendOptions options;
      options.fade_last = fade;
      options.views = views;
      // Beside all three, for at the place of one it is shown alone.
      Camera camera = snapshot.views[0]->camera;
      camera.cam_from_world_translation += glm::dvec3(-0.05, -0.025, 0);
      const std::size_t blended =
          check_explains(by_reference(snapshot, camera, options), picture_by_reference(snapshot, camera, options));
      if (views == 3) CHECK(blended > 1000);
      if (views == 1) CHECK(blended == 0);
      if (!context) continue;
      Renderer renderer;
      renderer.load(snapshot);
      check_explains(renderer.diagnose(camera, options), renderer.render(camera, options));
    }
  }
}

// The same, with no references but those to one view.
Snapshot with_view_alone(Snapshot snapshot, ViewSlot slot) {
  ReferenceTable alone;
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    const auto slots = snapshot.references.of_cell(cell);
    if (std::find(slots.begin(), slots.end(), slot) != slots.end()) alone.views.push_back(slot);
    alone.offsets.push_back(static_cast<std::uint32_t>(alone.views.size()));
  }
  snapshot.references = alone;
  return snapshot;
}

TEST_CASE("as many views are valid at a pixel as texture it when each is alone") {
  const Snapshot snapshot = room_snapshot(9, {});
  const Camera camera = wide_camera(4);
  BlendOptions options;
  // A diagnosis is of a pixel's middle and its own cell.
  options.supersample = 1;
  options.border_width = 0;
  const Diagnosis diagnosis = by_reference(snapshot, camera, options);
  std::vector<std::uint32_t> textured(diagnosis.pixels.size(), 0);
  for (ViewSlot slot{0}; slot < 9; ++slot) {
    const Rendering alone = picture_by_reference(with_view_alone(snapshot, slot), camera, options);
    for (std::size_t pixel = 0; pixel < textured.size(); ++pixel) {
      textured[pixel] += alone.state[pixel] == PixelState::textured;
    }
  }
  std::size_t several = 0;
  for (std::size_t pixel = 0; pixel < textured.size(); ++pixel) {
    const PixelDiagnosis& told = diagnosis.pixels[pixel];
    REQUIRE(told.valid_views == textured[pixel]);
    REQUIRE((told.winner == ViewSlot::none) == (textured[pixel] == 0));
    REQUIRE((diagnosis.state[pixel] == PixelState::textured) == (textured[pixel] > 0));
    several += told.valid_views > 1;
  }
  CHECK(several > 100);
}

TEST_CASE("a linear picture is the picture before it is rounded and cut off at white") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(6, {});
  for (glm::dvec3& gain : snapshot.gains) gain = {3, 1, 0.5};
  BlendOptions options;
  options.exposure = BlendOptions::Exposure::model;
  Renderer renderer;
  renderer.load(snapshot);
  const Camera camera = wide_camera(2);
  const Rendering rounded = renderer.render(camera, options);
  const LinearRendering linear = renderer.render_linear(camera, options);
  REQUIRE(linear.rgb.size() == rounded.picture.rgb.size());
  CHECK(linear.state == rounded.state);
  for (std::size_t value = 0; value < linear.rgb.size(); ++value) {
    REQUIRE(std::abs(srgb8_from_linear(static_cast<double>(linear.rgb[value])) - rounded.picture.rgb[value]) <= 1);
  }
  CHECK(*std::max_element(linear.rgb.begin(), linear.rgb.end()) > 1.5f);
  CHECK(*std::min_element(linear.rgb.begin(), linear.rgb.end()) >= 0);
}

}  // namespace
}  // namespace lumatlas
