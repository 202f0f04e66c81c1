// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/flicker.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>

#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

constexpr int kFrames = 7;

// Colour of a point of the wall in a frame, levels.
using Look = std::function<double(const glm::dvec3& world, int frame, int channel)>;

// A camera that slides along a wall by a bit more than a pixel a frame.
struct Slide {
  Mesh mesh;
  std::unique_ptr<Visibility> visibility;

  Slide() {
    add_wall(mesh, 10, 10, 1, 4);
    visibility = make_ray_visibility(mesh);
  }

  [[nodiscard]] static Camera camera(int frame) {
    return forward_camera(80, 60, {0.07 * frame, 0.031 * frame, 0.01 * frame});
  }

  [[nodiscard]] Photograph picture(int frame, const Look& look) const {
    const Camera at = camera(frame);
    const VisibilityBuffer visible = visibility->trace(at);
    Photograph image{at.width, at.height, {}, {}};
    for (std::size_t pixel = 0; pixel < visible.depth.size(); ++pixel) {
      const glm::dvec2 middle(static_cast<double>(pixel % at.width) + 0.5, static_cast<double>(pixel / at.width) + 0.5);
      const glm::dvec3 world = at.center() + double{visible.depth[pixel]} * at.ray(middle);
      for (int channel = 0; channel < 3; ++channel) {
        image.rgb.push_back(static_cast<std::uint8_t>(std::lround(look(world, frame, channel))));
      }
    }
    return image;
  }

  [[nodiscard]] Flicker flicker(const Look& rendering, const Look& truth) const {
    FlickerMeter meter;
    for (int frame = 0; frame < kFrames; ++frame) {
      meter.add(camera(frame), visibility->trace(camera(frame)), picture(frame, rendering), picture(frame, truth));
    }
    return meter.flicker();
  }
};

// Waves of about six pixels: detail that interpolation hurts.
double waves(const glm::dvec3& world, int /*frame*/, int channel) {
  return 120 + 20 * channel + 60 * std::sin(20 * world.x) * std::cos(17 * world.y);
}

TEST_CASE("a rendering that is right, or wrong by the same everywhere and always, does not flicker") {
  const Slide slide;
  CHECK(slide.flicker(waves, waves).rms == 0);
  const Flicker offset =
      slide.flicker([](const auto& world, int frame, int channel) { return waves(world, frame, channel) + 15; }, waves);
  CHECK(offset.rms < 0.01);
  CHECK(offset.followed > std::size_t{kFrames - 1} * 70 * 50);
}

TEST_CASE("flicker is the height of the pops, over all points that were followed") {
  const Slide slide;
  const auto popping = [&](double share) {
    return slide.flicker(
        [share](const auto& world, int frame, int channel) {
          const bool part = world.y < share;
          return waves(world, frame, channel) + (part && frame % 2 == 1 ? 10 : 0);
        },
        waves);
  };
  CHECK(popping(100).rms == Approx(10).margin(0.01));
  CHECK(popping(100).worst == Approx(10).margin(0.01));
  CHECK(popping(0.08).rms == Approx(10 / std::sqrt(2.0)).margin(0.5));  // about half of the picture
}

TEST_CASE("a single pop shows in the worst frame") {
  const Slide slide;
  const Flicker once = slide.flicker(
      [](const auto& world, int frame, int channel) { return waves(world, frame, channel) + (frame >= 4 ? 12 : 0); },
      waves);
  CHECK(once.worst == Approx(12).margin(0.01));
  CHECK(once.rms == Approx(12 / std::sqrt(kFrames - 1.0)).margin(0.1));
}

TEST_CASE("a true change that the rendering follows is no flicker, and one that it does not follow is") {
  const Slide slide;
  const Look gloss = [](const auto& world, int frame, int channel) { return waves(world, frame, channel) + 5 * frame; };
  CHECK(slide.flicker(gloss, gloss).rms == 0);
  CHECK(slide.flicker(waves, gloss).rms == Approx(5).margin(0.05));
}

TEST_CASE("blur that stays on the surface is hardly flicker, and does not help against pops") {
  const Slide slide;
  const auto blurred = [&](double pop) {
    return slide.flicker(
        [pop](const auto& world, int frame, int channel) {
          return 120 + 20 * channel + 0.3 * (waves(world, frame, channel) - 120 - 20 * channel) +
                 (frame % 2 == 1 ? pop : 0);
        },
        waves);
  };
  // Seven tenths of the waves are missing, 21 levels rms; interpolation between pixels takes some of that error's
  // detail away in one frame and not in the other.
  CHECK(blurred(0).rms < 2);
  CHECK(blurred(10).rms > 10);
}

TEST_CASE("points that are hidden or out of the picture in the next frame are not followed") {
  Mesh mesh;
  add_wall(mesh, 10, 10, 1, 4);
  const auto visibility = make_ray_visibility(mesh);
  FlickerMeter meter;
  const auto add = [&](const Camera& camera) {
    const Photograph grey{
        camera.width, camera.height, std::vector<std::uint8_t>(std::size_t{3} * camera.width * camera.height, 90), {}};
    meter.add(camera, visibility->trace(camera), grey, grey);
  };
  add(forward_camera(40, 30));
  CHECK(std::isnan(meter.flicker().rms));
  add(forward_camera(40, 30, {20, 0, 0}));  // beside the wall
  add(oblique_camera(40, 30, 3.1, {0, 0, 0}));
  CHECK(meter.flicker().followed == 0);
  const Camera camera = forward_camera(40, 30);
  CHECK_THROWS_WITH(meter.add(camera, {}, {}, {}), Catch::Contains("as large as"));
}

TEST_CASE("what is black outside the lens's image does not flicker") {
  const Slide slide;
  FlickerMeter meter;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Photograph rendering = slide.picture(frame, waves);
    Photograph truth = rendering;
    truth.valid.assign(std::size_t{truth.width} * truth.height, 255);
    for (std::size_t y = 0; y < truth.height; ++y) {
      const std::size_t rim = y * truth.width + 20 + static_cast<std::size_t>(frame);  // it does not move with the wall
      std::fill_n(truth.valid.begin() + static_cast<std::ptrdiff_t>(rim), 8, std::uint8_t{0});
      std::fill_n(truth.rgb.begin() + static_cast<std::ptrdiff_t>(3 * rim), 24, std::uint8_t{0});
    }
    meter.add(Slide::camera(frame), slide.visibility->trace(Slide::camera(frame)), rendering, truth);
  }
  CHECK(meter.flicker().rms == 0);
  CHECK(meter.flicker().followed > std::size_t{kFrames - 1} * 50 * 50);
}

}  // namespace
}  // namespace lumatlas
