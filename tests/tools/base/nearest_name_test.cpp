// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/nearest_name.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("the nearest name is the one with the fewest slips, and none that is far") {
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("biuld", "build") == 1);
  CHECK(edit_distance("build", "build") == 0);
  const std::vector<std::string> names{"build", "render", "mesh"};
  CHECK(nearest_name("bulid", names) == "build");
  CHECK(nearest_name("rendr", names) == "render");
  CHECK(nearest_name("msh", names) == "mesh");
  CHECK(nearest_name("chart", names).empty());
  CHECK(nearest_name("", names).empty());
  CHECK(nearest_name(std::string(1000, 'b'), names).empty());
}

}  // namespace
}  // namespace lumatlas
