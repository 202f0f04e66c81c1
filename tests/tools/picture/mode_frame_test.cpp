// SPDX-License-Identifier: GPL-3.0-or-later
// The values and colours of each mode at each pixel of a small room.
#include "tools/picture/mode_frame.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "mesh/base/errors.h"
#include "tests/support/scenes/small_scenes.h"
#include "tools/picture/frame_renderer.h"
#include "tools/picture/mode_picture.h"
#include "tools/score/report/error_picture.h"

namespace lumatlas {
namespace {

Rgb8 color_at(const Photograph& picture, std::size_t pixel) {
  return {picture.rgb[3 * pixel], picture.rgb[3 * pixel + 1], picture.rgb[3 * pixel + 2]};
}

// Returns a room whose every third cell was never seen, and whose next one has no references.
Snapshot patchy_room() {
  Snapshot snapshot = room_snapshot(6, {});
  ReferenceTable patchy;
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    const auto slots = snapshot.references.of_cell(cell);
    if (cell % 3 == 2) patchy.views.insert(patchy.views.end(), slots.begin(), slots.end());
    patchy.offsets.push_back(static_cast<std::uint32_t>(patchy.views.size()));
    snapshot.cell_seen[cell] = cell % 3 != 0;
    snapshot.cell_coverage.push_back(0.01f * static_cast<float>(cell));
  }
  snapshot.references = patchy;
  return snapshot;
}

TEST_CASE("a mode of cells tells each pixel's cell, and keeps unseen apart from seen but not referenced") {
  const Snapshot snapshot = patchy_room();
  Camera camera = room_camera(3);
  camera.cam_from_world_translation.z += 2.5;  // partly out of the room, past whose edge nothing is
  const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
  const ModeFrame references = cell_frame(visible, snapshot, reference_counts(snapshot), false);
  const ModeFrame coverage = cell_frame(visible, snapshot, snapshot.cell_coverage, false);
  const ModeFrame always = cell_frame(visible, snapshot, snapshot.cell_coverage, true);
  std::array<std::size_t, 4> found{};
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    PixelMark expected = PixelMark::no_surface;
    std::uint32_t cell = 0;
    if (visible.face[pixel] != FaceId::none) {
      cell = snapshot.surface->cells.cell_of_face[visible.face[pixel]];
      const bool referenced = !snapshot.references.of_cell(cell).empty();
      expected = cell % 3 == 0 ? PixelMark::unseen : referenced ? PixelMark::number : PixelMark::untextured;
      REQUIRE(always.marks[pixel] == PixelMark::number);
      REQUIRE(always.values[pixel] == 0.01f * static_cast<float>(cell));
    }
    REQUIRE(references.marks[pixel] == expected);
    REQUIRE(coverage.marks[pixel] == expected);
    ++found[static_cast<std::size_t>(expected)];
    if (expected != PixelMark::number) continue;
    REQUIRE(references.values[pixel] == static_cast<float>(snapshot.references.of_cell(cell).size()));
    REQUIRE(coverage.values[pixel] == 0.01f * static_cast<float>(cell));
  }
  CHECK(found[0] > 100);
  CHECK(found[2] > 100);
  CHECK(found[3] > 100);
  CHECK_THROWS_WITH(cell_frame(visible, snapshot, std::vector<float>(3), false), Catch::Contains("has 3 entries"));
}

TEST_CASE("mode trust shows the shift by the surface's deviation, and needs a model with deviations") {
  Snapshot snapshot = patchy_room();
  FrameOptions options;
  options.mode = Mode::trust;
  CHECK_THROWS_WITH(FrameRenderer(snapshot, options, nullptr), Catch::Contains("how far its surface is off"));
  for (std::size_t cell = 0; cell < snapshot.cell_seen.size(); ++cell) {
    snapshot.cell_deviation.push_back(0.01f * static_cast<float>(cell % 7));
  }
  const Camera camera = room_camera(3);
  const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
  const FloatImage trust = FrameRenderer(snapshot, options, nullptr).numbers(camera, nullptr);
  REQUIRE(trust.values.size() == visible.face.size());
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    const bool seen = visible.face[pixel] != FaceId::none;
    const CellId cell = seen ? snapshot.surface->cells.cell_of_face[visible.face[pixel]] : CellId(0);
    const bool counts = seen && snapshot.cell_seen[cell] != 0 && !snapshot.references.of_cell(cell).empty();
    REQUIRE(std::isnan(trust.values[pixel]) == !counts);
    if (!counts) continue;
    const double shift = 0.01 * (cell % 7) * std::sin(10 * 3.14159265 / 180) * camera.fx;
    REQUIRE(static_cast<double>(trust.values[pixel]) ==
            Approx(shift / static_cast<double>(visible.depth[pixel])).margin(1e-6));
  }
}

TEST_CASE("each mark has a colour of its own, in each mode, and numbers have the ramp's") {
  const Snapshot snapshot = patchy_room();
  ModeFrame frame{5, 1, 1, {0, 4, 0, 0, 0}, {}};
  frame.marks = {PixelMark::number, PixelMark::number, PixelMark::no_surface, PixelMark::unseen, PixelMark::untextured};
  const ModeColors colors(snapshot, Mode::references, ValueRange{0, 4});
  const Photograph painted = colors.paint(frame);
  CHECK(color_at(painted, 0) == quantity_ramp(0));
  CHECK(color_at(painted, 1) == quantity_ramp(1));
  for (std::size_t a = 0; a < 5; ++a) {
    for (std::size_t b = a + 1; b < 5; ++b) CHECK(color_at(painted, a) != color_at(painted, b));
  }
  for (std::size_t named = 0; named < 3; ++named) {
    const auto& names = colors.bar().names;
    CHECK(std::any_of(names.begin(), names.end(),
                      [&](const NamedColor& entry) { return entry.color == color_at(painted, 2 + named); }));
  }
}

TEST_CASE("without a range, a mode's colours span what the model holds, and a range is taken as it is") {
  Snapshot snapshot = patchy_room();
  const std::vector<float> counts = reference_counts(snapshot);
  const float most = *std::max_element(counts.begin(), counts.end());
  REQUIRE(most > 1);
  CHECK(ModeColors(snapshot, Mode::references, {}).bar().scale->most == static_cast<double>(most));
  CHECK(ModeColors(snapshot, Mode::valid_views, {}).bar().scale->most == static_cast<double>(most));
  CHECK(ModeColors(snapshot, Mode::error, {}).bar().scale->most == kErrorFullScale);
  CHECK(ModeColors(snapshot, Mode::coverage, {}).bar().scale->most ==
        Approx(std::max(1.0, 0.01 * static_cast<double>(snapshot.cell_seen.size() - 1))));
  const double far = ModeColors(snapshot, Mode::depth, {}).bar().scale->most;
  CHECK(far > 1);
  CHECK(far < 6.5);  // the room's diagonal
  CHECK(ModeColors(snapshot, Mode::coverage, ValueRange{0, 0.3}).bar().scale->most == 0.3);
  CHECK_FALSE(ModeColors(snapshot, Mode::cells, {}).bar().scale);
  CHECK_THROWS_WITH(ModeColors(snapshot, Mode::cells, ValueRange{}), Catch::Contains("has no range"));
  CHECK_THROWS_WITH(ModeColors(snapshot, Mode::depth, ValueRange{1, 1}),
                    Catch::Contains("must be finite and ascending"));
  CHECK_THROWS_WITH(ModeColors(snapshot, Mode::picture, {}), Catch::Contains("a picture has none"));
  snapshot.views.clear();
  snapshot.cell_coverage.clear();
  CHECK(ModeColors(snapshot, Mode::depth, {}).bar().scale->most == 1);
  CHECK(ModeColors(snapshot, Mode::coverage, {}).bar().scale->most == 1);
}

TEST_CASE("views are named where they are few") {
  Snapshot snapshot = patchy_room();
  const ColorBar few = ModeColors(snapshot, Mode::winner, {}).bar();
  REQUIRE(few.names.size() == 6 + 3);
  for (ViewSlot slot{0}; slot < 6; ++slot) {
    CHECK(few.names[slot].name == snapshot.views[slot]->name);
    CHECK(few.names[slot].color == distinct_color(slot));
  }
  snapshot.views.resize(13, snapshot.views[0]);
  const ColorBar many = ModeColors(snapshot, Mode::winner, {}).bar();
  CHECK(many.names.size() == 3);
  CHECK_THAT(many.title, Catch::EndsWith("of 13"));
}

TEST_CASE("a diagnosis becomes numbers, with its states as marks") {
  Diagnosis diagnosis{4, 1, {}, {}};
  diagnosis.state = {PixelState::textured, PixelState::untextured, PixelState::unseen, PixelState::empty};
  diagnosis.pixels.resize(4);
  diagnosis.pixels[0] = {7, 5, {0.5f, 0.25f, 0.125f}};
  const std::vector<PixelMark> marks = {PixelMark::number, PixelMark::untextured, PixelMark::unseen,
                                        PixelMark::no_surface};
  const ModeFrame valid = diagnosis_frame(diagnosis, Mode::valid_views);
  CHECK(valid.marks == marks);
  CHECK(valid.values == std::vector<float>{7, 0, 0, 0});
  CHECK(diagnosis_frame(diagnosis, Mode::winner).values == std::vector<float>{5, 0, 0, 0});
  const ModeFrame weights = diagnosis_frame(diagnosis, Mode::weights);
  CHECK(weights.channels == 3);
  CHECK(std::vector<float>(weights.values.begin(), weights.values.begin() + 3) ==
        std::vector<float>{0.5f, 0.25f, 0.125f});
  const Photograph painted = ModeColors(patchy_room(), Mode::weights, {}).paint(weights);
  CHECK(color_at(painted, 0) == Rgb8{128, 64, 32});
  CHECK_THROWS_WITH(diagnosis_frame(diagnosis, Mode::depth), Catch::Contains("mode must be"));
}

TEST_CASE("an error frame is what the error picture shows") {
  Photograph photograph = pattern_photograph(room_camera(0), 1);
  const Photograph rendering = pattern_photograph(room_camera(0), 2);
  photograph.valid.assign(photograph.rgb.size() / 3, 255);
  photograph.valid[17] = 0;
  std::vector<std::uint8_t> mask(photograph.valid.size(), 1);
  mask[40] = 0;
  const ModeFrame frame = error_frame(rendering, photograph, mask);
  const Photograph expected = error_picture(rendering, photograph, mask);
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) {
    const bool scored = pixel != 17 && pixel != 40;
    REQUIRE((frame.marks[pixel] == PixelMark::number) == scored);
    if (scored) REQUIRE(error_color(static_cast<double>(frame.values[pixel])) == color_at(expected, pixel));
  }
  const Photograph painted = ModeColors(patchy_room(), Mode::error, {}).paint(frame);
  CHECK(color_at(painted, 17) == kNotScoredColor);
  for (std::size_t value = 0; value < painted.rgb.size(); ++value) {
    REQUIRE(std::abs(painted.rgb[value] - expected.rgb[value]) <= 2);  // the ramp in 1024 steps
  }
}

TEST_CASE("numbers go into a file as they are, and none is NaN") {
  const ModeFrame frame{2, 1, 3, {0.5f, 0.25f, 0.25f, 0, 0, 0}, {PixelMark::number, PixelMark::unseen}};
  const FloatImage image = float_image(frame, Mode::weights);
  CHECK(image.channels == std::vector<std::string>{"R", "G", "B"});
  CHECK(image.values[1] == 0.25f);
  for (std::size_t value = 3; value < 6; ++value) CHECK(std::isnan(image.values[value]));
  CHECK(float_image({1, 1, 1, {3}, {PixelMark::number}}, Mode::depth).channels == std::vector<std::string>{"Z"});
}

TEST_CASE("what needs no renderer is drawn without OpenGL: depth by rays, and cells") {
  const Snapshot snapshot = patchy_room();
  const Camera camera = room_camera(2);
  const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
  for (const Mode mode : {Mode::depth, Mode::coverage, Mode::references, Mode::cells}) {
    REQUIRE_FALSE(needs_renderer(mode));
    FrameOptions options;
    options.mode = mode;
    FrameRenderer renderer(snapshot, options, nullptr);
    const FloatImage numbers = renderer.numbers(camera, nullptr);
    CHECK(numbers.width == camera.width);
    if (mode == Mode::depth) {
      for (std::size_t pixel = 0; pixel < visible.depth.size(); ++pixel) {
        if (visible.face[pixel] != FaceId::none) REQUIRE(numbers.values[pixel] == visible.depth[pixel]);
      }
    }
    CHECK(renderer.picture(camera, nullptr).picture.height > camera.height);
    options.color_bar = false;
    CHECK(FrameRenderer(snapshot, options, nullptr).picture(camera, nullptr).picture.height == camera.height);
  }
  FrameOptions coverage;
  coverage.mode = Mode::coverage;
  CHECK_THROWS_WITH(FrameRenderer(room_snapshot(1, {}), coverage, nullptr), Catch::Contains("build it again"));
}

}  // namespace
}  // namespace lumatlas
