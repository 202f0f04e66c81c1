// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/plane_file.h"

#include <catch2/catch.hpp>

#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

PlaneMap some_map() {
  PlaneMap map{3, 2, {}, {}};
  for (int i = 0; i < 6; ++i) {
    const auto value = static_cast<float>(i);
    map.planes.push_back({value, value + 0.5F, -value});
    map.costs.push_back(value / 4);
  }
  return map;
}

TEST_CASE("a plane map comes back as it was written, for the same inputs alone") {
  const TemporaryFolder folder;
  write_planes(folder / "a.planes", 7, some_map());
  const std::optional<PlaneMap> read = read_planes(folder / "a.planes", 7);
  REQUIRE(read);
  CHECK(read->width == 3);
  CHECK(read->height == 2);
  CHECK(read->costs == some_map().costs);
  CHECK(read->planes[4].w_u == 4.5F);
  CHECK_FALSE(read_planes(folder / "a.planes", 8));
  CHECK_FALSE(read_planes(folder / "b.planes", 7));
}

TEST_CASE("a plane map that was cut off or changed counts as none") {
  const TemporaryFolder folder;
  write_planes(folder / "whole", 7, some_map());
  const std::string bytes = bytes_of(folder / "whole");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    CHECK_FALSE(read_planes(folder.with_file("part", bytes.substr(0, length)), 7));
  }
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x40);
    CHECK_FALSE(read_planes(folder.with_file("changed", changed), 7));
  }
}

}  // namespace
}  // namespace lumatlas
