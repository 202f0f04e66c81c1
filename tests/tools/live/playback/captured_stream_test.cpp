// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/captured_stream.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <glm/glm.hpp>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas {
namespace {

SynthOptions stream_options() {
  SynthOptions options;
  options.views = 6;
  options.width = 48;
  options.height = 36;
  options.samples = 1;
  options.triangles = 3000;
  options.stream_rate = 4;
  return options;
}

TEST_CASE("a captured stream has its frames by their times, photograph and depth together") {
  const TemporaryFolder folder;
  write_synthetic_scene(stream_options(), folder.path());
  const CapturedStream stream = read_captured_stream(folder / "stream", {}, std::nullopt, 10);
  REQUIRE(stream.frames.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(stream.frames[i].time == Approx(0.25 * static_cast<double>(i)));
    REQUIRE(stream.frames[i].view);
    CHECK(*stream.frames[i].view == i);
    REQUIRE(stream.frames[i].depth);
    CHECK(stream.scene.depths[*stream.frames[i].depth].camera.center() == stream.scene.views[i].camera.center());
  }
  // Coordinates are relative to a place near the first camera.
  CHECK(glm::length(stream.scene.views[0].camera.center()) < 1);
  const SceneViews given = read_scene_views(folder / "stream", stream.offset);
  CHECK(glm::distance(given.views[5].camera.center(), stream.scene.views[5].camera.center()) < 1e-9);
}

TEST_CASE("held-out photographs of a captured stream are in no frame, but their depths are") {
  const TemporaryFolder folder;
  write_synthetic_scene(stream_options(), folder.path());
  const CapturedStream stream = read_captured_stream(folder / "stream", {}, HoldOut{3, 1}, 10);
  CHECK(stream.held_out == std::vector<std::size_t>{0, 3});
  std::size_t views = 0, depths = 0;
  for (const CapturedFrame& frame : stream.frames) {
    views += frame.view.has_value();
    depths += frame.depth.has_value();
    if (frame.view) CHECK(*frame.view % 3 != 0);
  }
  CHECK(views == 4);
  CHECK(depths == 6);
  CHECK(std::is_sorted(stream.frames.begin(), stream.frames.end(),
                       [](const auto& a, const auto& b) { return a.time < b.time; }));
}

TEST_CASE("a capture without depth images is no stream") {
  const TemporaryFolder folder;
  write_synthetic_scene(stream_options(), folder.path());
  CHECK_THROWS_WITH(read_captured_stream(folder.path(), {}, std::nullopt, 10), Catch::Contains("has no depth images"));
}

}  // namespace
}  // namespace lumatlas
