// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/pass_time.h"

#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

std::vector<std::string> passes_of(const std::vector<PassTime>& times) {
  std::vector<std::string> names;
  names.reserve(times.size());
  for (const PassTime& time : times) names.push_back(time.pass);
  return names;
}

TEST_CASE("each pass of a picture is timed, in the order in which it is drawn") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(6, {});
  snapshot.cell_deviation.assign(snapshot.surface->cells.cells.size(), 0.5F);
  Renderer renderer;
  renderer.load(snapshot);
  const std::vector<Camera> cameras{room_camera(2).scaled_to(160, 120), room_camera(4).scaled_to(160, 120)};
  const std::vector<PassTime> times = pass_times(renderer, cameras, {});
  CHECK(passes_of(times) == std::vector<std::string>{"ranking", "surface", "outlines", "blend", "silhouettes",
                                                     "surface of samples", "samples", "soft edges"});
  for (const PassTime& time : times) {
    CAPTURE(time.pass);
    CHECK(time.wall > 0);
    CHECK(time.processor >= 0);
    CHECK(time.gpu.value_or(0) >= 0);
  }
  BlendOptions draft = BlendOptions::draft();
  draft.soft_edges = false;
  CHECK(passes_of(pass_times(renderer, cameras, draft)) == std::vector<std::string>{"ranking", "surface", "blend"});
  CHECK_THROWS_WITH(pass_times(renderer, {}, {}), Catch::Contains("there are no cameras"));
}

}  // namespace
}  // namespace lumatlas
