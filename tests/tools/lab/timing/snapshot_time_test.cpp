// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/snapshot_time.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("the time of a next snapshot is measured at once and in pieces, and both draw the same then") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot first = room_snapshot(3, {}, {16, 2, 0}), second = room_snapshot(6, {}, {16, 2, 0});
  Renderer at_once, in_pieces;
  for (Renderer* renderer : {&at_once, &in_pieces}) {
    renderer->load(first);
    (void)renderer->render(room_camera(1), {});
  }
  const SnapshotTime once = time_at_once(at_once, second, {});
  CHECK(once.frames == 1);
  CHECK(once.wall > 0);
  CHECK(once.processor > 0);
  const SnapshotTime pieces = time_in_pieces(in_pieces, second, room_camera(1), {}, 0);
  CHECK(pieces.frames > 3);
  CHECK(pieces.wall > 0);
  CHECK(at_once.render(room_camera(1), {}).picture.rgb == in_pieces.render(room_camera(1), {}).picture.rgb);
}

TEST_CASE("the times of a next snapshot's steps add up to no more than those of its calls") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer, fresh;
  renderer.load(room_snapshot(3, {}, {16, 2, 0}));
  (void)renderer.render(room_camera(1), {});
  const Snapshot next = room_snapshot(6, {}, {16, 2, 0});
  const std::vector<CallTimes> all = time_steps(renderer, next, room_camera(1), {}, 0);
  const auto of = [&](const std::string& what) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const CallTimes& times) { return times.what == what; });
    REQUIRE(found != all.end());
    return *found;
  };
  CHECK(of("begin()").calls == 1);
  CHECK(of("exchange").calls == 1);
  CHECK(of("last picture").calls == 1);
  CHECK(of("upload()").calls == of("picture").calls + 1);
  CHECK(of("tile").most_bytes > 0);
  double wall = 0, processor = 0;
  int steps = 0;
  for (const CallTimes& times : all) {
    CAPTURE(times.what);
    CHECK(times.longest_wall <= times.wall);
    CHECK(times.longest_processor <= times.processor);
    if (times.what == "begin()" || times.what == "upload()" || times.what.ends_with("picture")) continue;
    wall += times.wall;
    processor += times.processor;
    steps += times.calls;
  }
  CHECK(steps == of("upload()").calls);  // in no time, one a call
  CHECK(wall <= of("upload()").wall);
  CHECK(processor <= of("upload()").processor);
  fresh.load(next);
  CHECK(renderer.render(room_camera(1), {}).picture.rgb == fresh.render(room_camera(1), {}).picture.rgb);
}

TEST_CASE("a snapshot that is refused while its time is measured leaves no thread behind") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot bad = room_snapshot(3, {}, {16, 2, 0});
  Renderer renderer;
  renderer.load(bad);
  bad.gains.front().x = -1;
  CHECK_THROWS_AS(time_in_pieces(renderer, bad, room_camera(1), {}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
