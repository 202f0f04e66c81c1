// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/snapshot_time.h"

#include <catch2/catch.hpp>
#include <optional>

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
