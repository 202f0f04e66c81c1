// SPDX-License-Identifier: GPL-3.0-or-later
// A white and a black photograph of a wall from nearly the same direction: the picture tells what each counts.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/trigonometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "atlas/images/srgb.h"
#include "blend/blend_options.h"
#include "blend/reference.h"
#include "tests/support/scenes/painted_wall.h"

namespace lumatlas {
namespace {

// Returns the share of the white photograph in the middle of a picture, where the two are taken from these angles
// beside the picture's camera, degrees.
double share_of_white(double white_degrees, double black_degrees, const BlendOptions& options = {}) {
  const std::shared_ptr<const Surface> wall = wall_before(0);
  Atlas atlas(wall, 2);
  const std::vector<Camera> cameras{beside(white_degrees), beside(black_degrees)};
  std::vector<ViewSlot> slots;
  for (const Camera& camera : cameras) {
    const std::uint8_t level = slots.empty() ? 255 : 0;
    Photograph photograph{kSide, kSide, std::vector<std::uint8_t>(3 * kSide * kSide, level), {}};
    slots.push_back(atlas.insert(traced_view(*wall, "", camera, std::move(photograph))));
  }
  for (CellId cell{0}; cell < wall->cells.cells.size(); ++cell) atlas.set_references(cell, slots);
  const VisibilityBuffer visible = make_ray_visibility(wall->mesh)->trace(beside(0));
  const Rendering rendering = render_reference(atlas.snapshot(), beside(0), visible, options);
  return linear_from_srgb8()[rendering.picture.rgb[3 * (kSide / 2 * kSide + kSide / 2)]];
}

double lack(double degrees) {
  return BlendOptions{}.lambda * (1 - std::cos(glm::radians(degrees)));
}

// What a view from that angle counts, where no third one is left out.
double count_of(double degrees, double even) {
  return (1 - lack(degrees)) / (lack(degrees) + even);
}

TEST_CASE("photographs from nearly the same direction share a picture more evenly than their directions say") {
  const double white = count_of(1, kEvenSlope * lack(1)), black = count_of(2, kEvenSlope * lack(1));
  CHECK(share_of_white(1, -2) == Approx(white / (white + black)).margin(0.01));
  CHECK(share_of_white(1, -2) < 0.65);  // their directions alone say 0.8
  CHECK(share_of_white(2, -2) == Approx(0.5).margin(0.01));
}

TEST_CASE("from farther away the evening is the same for all, and at a photograph's own camera there is none") {
  const double white = count_of(10, kEven), black = count_of(20, kEven);
  CHECK(share_of_white(10, -20) == Approx(white / (white + black)).margin(0.01));
  CHECK(share_of_white(0, 1) > 0.99);
  CHECK(share_of_white(0.1, 1) > 0.9);
}

TEST_CASE("the printed formula evens nothing out") {
  CHECK(share_of_white(1, -2, BlendOptions::printed()) == Approx(0.5).margin(0.01));
}

}  // namespace
}  // namespace lumatlas
