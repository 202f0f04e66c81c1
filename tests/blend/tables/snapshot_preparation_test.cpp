// SPDX-License-Identifier: GPL-3.0-or-later
// A snapshot is whole once all its tiles were taken and given back, and never once it was given up. Needs no OpenGL.
#include "blend/tables/snapshot_preparation.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

// Prepares the first snapshot of a renderer whose tiles may all wait.
std::unique_ptr<SnapshotPreparation> prepared_room() {
  FormerSnapshot nothing;
  nothing.array = std::make_shared<ArrayContents>();
  PreparationOptions options;
  options.blocks = false;
  options.limits = {256, 4096, false, true};
  options.waiting_bytes = ~std::uint64_t{0};
  auto preparation =
      std::make_unique<SnapshotPreparation>(room_snapshot(4, {}, {16, 2, 0}), std::move(nothing), options);
  preparation->run();
  return preparation;
}

TEST_CASE("a snapshot is whole once the last of its tiles is given back") {
  const auto preparation = prepared_room();
  CHECK(preparation->is_planned());
  std::size_t tiles = 0;
  while (const std::optional<TileUpload> tile = preparation->next_tile()) {
    CHECK(!preparation->is_whole());
    preparation->give_back(tile->bytes());
    ++tiles;
  }
  CHECK(tiles > 2);
  CHECK(preparation->waiting_bytes() == 0);
  CHECK(preparation->is_whole());
}

TEST_CASE("a snapshot that is given up between two tiles never becomes whole, though none of its tiles waits") {
  const auto preparation = prepared_room();
  const std::optional<TileUpload> tile = preparation->next_tile();
  REQUIRE(tile.has_value());
  preparation->cancel();
  CHECK(preparation->waiting_bytes() == tile->bytes());
  preparation->give_back(tile->bytes());
  CHECK(preparation->waiting_bytes() == 0);
  CHECK(!preparation->next_tile());
  CHECK(!preparation->is_whole());
  preparation->cancel();  // again
  CHECK(!preparation->is_whole());
}

}  // namespace
}  // namespace lumatlas
