// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust/trust.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "tests/support/refusal.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

struct Rectangle {
  std::uint32_t left, top, right, bottom;

  [[nodiscard]] bool contains(std::uint32_t x, std::uint32_t y) const {
    return x >= left && x < right && y >= top && y < bottom;
  }
  [[nodiscard]] Rectangle grown(std::uint32_t by) const { return {left - by, top - by, right + by, bottom + by}; }
};

constexpr Rectangle kBox{90, 60, 140, 110};

Photograph with_box(Photograph photograph, const glm::u8vec3& color, const Rectangle& box = kBox) {
  for (std::uint32_t y = box.top; y < box.bottom; ++y) {
    for (std::uint32_t x = box.left; x < box.right; ++x) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        photograph.rgb[3 * (std::size_t{y} * photograph.width + x) + channel] = color[static_cast<int>(channel)];
      }
    }
  }
  return photograph;
}

// A gallery of plain views of the relief, on an arc before it.
Gallery& with_views(Gallery& gallery, const std::vector<double>& degrees, const Shading& shading = plain_shading()) {
  for (const double angle : degrees) {
    const Camera camera = camera_on_arc(angle);
    gallery.add(camera, gallery.relief.photograph(camera, glm::dvec3(1.0), shading));
  }
  return gallery;
}

std::vector<std::uint8_t> mask_of(const Gallery& gallery, const Camera& camera, const Photograph& photograph,
                                  const TrustOptions& options = {}, double gain = 1, std::optional<ViewSlot> self = {},
                                  TrustExtent extent = TrustExtent::regions) {
  const Pyramid pyramid(photograph);
  return trust_mask(camera, pyramid, glm::dvec3(gain),
                    gallery.relief.visibility->trace(camera.shrunk_to(options.grid_px)), gallery.atlas, gallery.views,
                    self, options, extent);
}

// Share of the pixels inside the rectangle, or outside it, with little trust.
double masked_share(const std::vector<std::uint8_t>& mask, const Rectangle& box, bool inside) {
  std::size_t masked = 0, all = 0;
  for (std::uint32_t y = 0; y < 180; ++y) {
    for (std::uint32_t x = 0; x < 240; ++x) {
      if (box.contains(x, y) != inside) continue;
      ++all;
      masked += !mask.empty() && mask[std::size_t{y} * 240 + x] < 128;
    }
  }
  return static_cast<double>(masked) / static_cast<double>(all);
}

// A Gaussian lobe of light, `sliding` scene units to the side per unit that the camera stands to the side.
Shading highlight(double sliding) {
  return [sliding](const glm::dvec3& point, const glm::dvec3& center) {
    const double x = point.x - sliding * center.x, y = point.y - 0.1;
    return relief_color(point) + glm::dvec3(0.45 * std::exp(-(x * x + y * y) / (2 * 0.25 * 0.25)));
  };
}

// A square of the wall, one unit wide, in another colour.
Shading with_patch(const glm::dvec3& color) {
  return [color](const glm::dvec3& point, const glm::dvec3&) {
    return std::abs(point.x) < 0.5 && std::abs(point.y) < 0.5 ? color : relief_color(point);
  };
}

TEST_CASE("a box of another colour in one photograph loses its trust, and little else does") {
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12});
  const Camera camera = camera_on_arc(0);
  for (const glm::u8vec3& color : {glm::u8vec3(20, 30, 25), glm::u8vec3(210, 20, 30), glm::u8vec3(15, 60, 200)}) {
    const std::vector<std::uint8_t> mask = mask_of(gallery, camera, with_box(gallery.relief.photograph(camera), color));
    REQUIRE(mask.size() == std::size_t{240} * 180);
    CHECK(masked_share(mask, kBox, true) > 0.9);
    CHECK(masked_share(mask, kBox.grown(5), false) == 0);
  }
}

TEST_CASE("a mask is 0 deep inside what is contradicted, 255 far from it and in between at its edge") {
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12});
  const Camera camera = camera_on_arc(0);
  const std::vector<std::uint8_t> mask =
      mask_of(gallery, camera, with_box(gallery.relief.photograph(camera), {210, 20, 30}));
  CHECK(static_cast<int>(mask[85 * 240 + 115]) == 0);
  CHECK(static_cast<int>(mask[20 * 240 + 20]) == 255);
  CHECK(std::any_of(mask.begin(), mask.end(), [](std::uint8_t value) { return value > 0 && value < 255; }));
}

TEST_CASE("the same box on the wall itself, seen in all photographs, is trusted") {
  Gallery gallery(4);
  const Shading patch = with_patch({0.5, 0.02, 0.03});
  with_views(gallery, {-12, -6, 6, 12}, patch);
  const Camera camera = camera_on_arc(0);
  CHECK(mask_of(gallery, camera, gallery.relief.photograph(camera, glm::dvec3(1.0), patch)).empty());
}

TEST_CASE("a photograph that agrees with the others is trusted everywhere, whatever its exposure, by its gain") {
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12});
  const Camera camera = camera_on_arc(0);
  CHECK(mask_of(gallery, camera, gallery.relief.photograph(camera)).empty());
  CHECK(mask_of(gallery, camera, gallery.relief.photograph(camera, glm::dvec3(0.25)), {}, 4).empty());
  CHECK_FALSE(mask_of(gallery, camera, gallery.relief.photograph(camera, glm::dvec3(0.1))).empty());
}

TEST_CASE("a highlight that moves with the viewpoint survives in views twenty degrees apart") {
  Gallery gallery(4);
  const Shading shiny = highlight(0.5);
  with_views(gallery, {-40, -20, 20, 40}, shiny);
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = gallery.relief.photograph(camera, glm::dvec3(1.0), shiny);
  CHECK(mask_of(gallery, camera, photograph).empty());
  TrustOptions all_comparable;
  all_comparable.comparable_deg = 180;
  CHECK(mask_of(gallery, camera, photograph, all_comparable).empty());
}

TEST_CASE("a bright blob that views five degrees away do not show loses its trust") {
  Gallery gallery(4);
  with_views(gallery, {-5, -4, 4, 5});
  const Camera camera = camera_on_arc(0);
  const std::vector<std::uint8_t> mask =
      mask_of(gallery, camera, gallery.relief.photograph(camera, glm::dvec3(1.0), highlight(0)));
  REQUIRE_FALSE(mask.empty());
  const auto middle_of_blob = camera.image_from_cam(camera.cam_from_world({0, 0.1, 4.1}));
  CHECK(static_cast<int>(
            mask[static_cast<std::size_t>(middle_of_blob.y) * 240 + static_cast<std::size_t>(middle_of_blob.x)]) == 0);
  TrustOptions narrow;
  narrow.highlight_deg = 3;
  CHECK(mask_of(gallery, camera, gallery.relief.photograph(camera, glm::dvec3(1.0), highlight(0)), narrow).empty());
}

TEST_CASE("the place that a highlight has left is trusted by as many views without it") {
  Gallery gallery(4);
  with_views(gallery, {-20, -10, 10}, highlight(0.5));
  const Camera bright = camera_on_arc(20);
  gallery.add(bright, gallery.relief.photograph(bright, glm::dvec3(1.0), highlight(0.5)));
  const Camera camera = camera_on_arc(0);
  CHECK(mask_of(gallery, camera, gallery.relief.photograph(camera)).empty());
}

TEST_CASE("views from too far to the side are no evidence") {
  Gallery gallery(4);
  with_views(gallery, {-45, -40, 40, 45});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = with_box(gallery.relief.photograph(camera), {210, 20, 30});
  CHECK(mask_of(gallery, camera, photograph).empty());
  TrustOptions wide;
  wide.comparable_deg = 60;
  CHECK_FALSE(mask_of(gallery, camera, photograph, wide).empty());
}

TEST_CASE("one other view contradicts nothing, two do") {
  Gallery gallery(2);
  with_views(gallery, {6});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = with_box(gallery.relief.photograph(camera), {210, 20, 30});
  CHECK(mask_of(gallery, camera, photograph).empty());
  with_views(gallery, {-6});
  CHECK_FALSE(mask_of(gallery, camera, photograph).empty());
}

TEST_CASE("a view is no evidence about itself, and no views contradict nothing") {
  Gallery gallery(3);
  with_views(gallery, {6});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = with_box(gallery.relief.photograph(camera), {210, 20, 30});
  const std::uint32_t self = gallery.add(camera, gallery.relief.photograph(camera));
  CHECK_FALSE(mask_of(gallery, camera, photograph).empty());
  ViewSlot(CHECK)(mask_of(gallery, camera, photograph, {}, 1, ViewSlot(self)).empty());
  const Gallery nobody(2);
  CHECK(mask_of(nobody, camera, photograph).empty());
}

TEST_CASE("views that disagree among themselves contradict nothing") {
  Gallery gallery(6);
  std::uint8_t grey = 20;
  for (const double angle : {-10.0, -6.0, -3.0, 3.0, 6.0, 10.0}) {
    const Camera camera = camera_on_arc(angle);
    gallery.add(camera, with_box(gallery.relief.photograph(camera), glm::u8vec3(grey), {40, 30, 200, 150}));
    grey = static_cast<std::uint8_t>(grey + 40);
  }
  const Camera camera = camera_on_arc(0);
  CHECK(mask_of(gallery, camera, with_box(gallery.relief.photograph(camera), {230, 20, 30})).empty());
}

TEST_CASE("a patch that is clipped far below what it is loses its trust where other views show it unclipped") {
  const Shading patch = with_patch(glm::dvec3(0.55));
  const Camera camera = camera_on_arc(0);
  for (const bool shown_elsewhere : {true, false}) {
    CAPTURE(shown_elsewhere);
    Gallery gallery(2);
    for (const double angle : {-6.0, 6.0}) {
      const Camera other = camera_on_arc(angle);
      const double exposure = shown_elsewhere ? 1 : 4;
      gallery.add(other, gallery.relief.photograph(other, glm::dvec3(exposure), patch), glm::dvec3(1 / exposure));
    }
    // 4 times 0.55 is clipped, and seems to be 0.25.
    const Photograph photograph = gallery.relief.photograph(camera, glm::dvec3(4.0), patch);
    const std::vector<std::uint8_t> mask = mask_of(gallery, camera, photograph, {}, 0.25);
    CHECK(mask.empty() != shown_elsewhere);
    if (shown_elsewhere) CHECK(static_cast<int>(mask[89 * 240 + 121]) == 0);
  }
}

TEST_CASE("a patch that is clipped in one channel keeps its trust where other views show it unclipped") {
  const Shading patch = with_patch({0.55, 0.2, 0.15});
  const Camera camera = camera_on_arc(0);
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12}, patch);
  // 4 times 0.55 is clipped, and seems to be 0.25.
  const Photograph photograph = gallery.relief.photograph(camera, glm::dvec3(4.0), patch);
  CHECK(mask_of(gallery, camera, photograph, {}, 0.25).empty());
  // Green tells that something else is there.
  const Photograph other = gallery.relief.photograph(camera, glm::dvec3(4.0), with_patch({0.55, 0.02, 0.15}));
  CHECK_FALSE(mask_of(gallery, camera, other, {}, 0.25).empty());
}

TEST_CASE("what is darker than others show it overexposed loses its trust, what is brighter keeps it") {
  const Camera camera = camera_on_arc(0);
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12}, with_patch(glm::dvec3(2.0)));
  // A leaf before the sky.
  const Photograph leaf = gallery.relief.photograph(camera, glm::dvec3(1.0), with_patch({0.2, 0.4, 0.1}));
  const std::vector<std::uint8_t> mask = mask_of(gallery, camera, leaf);
  REQUIRE_FALSE(mask.empty());
  CHECK(static_cast<int>(mask[89 * 240 + 121]) == 0);
  // While poses are refined, it is no evidence.
  const std::vector<std::uint8_t> refining = mask_of(gallery, camera, leaf, {}, 1, {}, TrustExtent::blocks);
  CHECK((refining.empty() || refining[89 * 240 + 121] == 255));
  // The same sky, two stops darker: it is twice as bright as the others can show.
  const Photograph sky = gallery.relief.photograph(camera, glm::dvec3(0.25), with_patch(glm::dvec3(2.0)));
  CHECK(mask_of(gallery, camera, sky, {}, 4).empty());
}

TEST_CASE("a highlight that is clipped keeps its trust where the others show nothing as bright") {
  Gallery gallery(4);
  with_views(gallery, {-20, -12, 12, 20});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = gallery.relief.photograph(camera, glm::dvec3(3.0), highlight(0));
  CHECK(mask_of(gallery, camera, photograph, {}, 1 / 3.0).empty());
}

TEST_CASE("a misalignment of a pixel or two contradicts nothing") {
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = gallery.relief.photograph(camera);
  const std::vector<glm::dvec3> points = gallery.relief.points(camera, 20, 15);
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    CHECK(mask_of(gallery, disturbed(camera, 1.5, seed, points), photograph).empty());
  }
}

TEST_CASE("a sharp edge that is a pixel off contradicts nothing") {
  Gallery gallery(4);
  const Shading patch = with_patch({0.6, 0.55, 0.5});
  with_views(gallery, {-12, -6, 6, 12}, patch);
  const Camera camera = camera_on_arc(0);
  const std::vector<glm::dvec3> points = gallery.relief.points(camera, 20, 15);
  const Photograph photograph = gallery.relief.photograph(camera, glm::dvec3(1.0), patch);
  CHECK(mask_of(gallery, disturbed(camera, 1, 4, points), photograph).empty());
}

TEST_CASE("a mask has the same bytes on one thread as on four") {
  Gallery gallery(4);
  with_views(gallery, {-12, -6, 6, 12});
  const Camera camera = camera_on_arc(0);
  const Photograph photograph = with_box(gallery.relief.photograph(camera), {210, 20, 30});
  const auto mask = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return mask_of(gallery, camera, photograph);
  };
  CHECK(mask(1) == mask(4));
}

TEST_CASE("trust options that break a rule are refused by name") {
  const auto refusal_of = [](const auto& change) { return refusal<TrustOptions>(change); };
  CHECK(refusal_of([](TrustOptions& o) { o.grid_px = 7; }) == "trust: grid_px is 7, must be at least 8");
  CHECK(refusal_of([](TrustOptions& o) { o.least_difference = 0; }) ==
        "trust: least_difference is 0, must be in (0, 1]");
  CHECK(refusal_of([](TrustOptions& o) { o.least_to_spread = -1; }) ==
        "trust: least_to_spread is -1, must be finite and not negative");
  CHECK(refusal_of([](TrustOptions& o) { o.least_views = 0; }) == "trust: least_views is 0, must be at least 1");
  CHECK(refusal_of([](TrustOptions& o) { o.highlight_deg = 181; }) ==
        "trust: highlight_deg is 181, must be in [0, 180]");
  CHECK(refusal_of([](TrustOptions& o) { o.comparable_deg = -1; }) ==
        "trust: comparable_deg is -1, must be in [0, 180]");
  CHECK(refusal_of([](TrustOptions&) {}) == "accepted");
}

}  // namespace
}  // namespace lumatlas
