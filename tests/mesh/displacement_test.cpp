// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/displacement.h"

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <string>

namespace lumatlas {
namespace {

// 300x200 pixels, nodes every 100.
Displacement ramp() {
  Displacement displacement{4, 3, {}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) displacement.nodes.emplace_back(2 * column, 10 - 3 * row);
  }
  return displacement;
}

Camera camera() {
  Camera result;
  result.width = 300;
  result.height = 200;
  result.fx = result.fy = 100;
  return result;
}

TEST_CASE("a displacement is bilinear between nodes, and beyond the picture that of its border") {
  const auto check_at = [](const glm::dvec2& image, const glm::dvec2& expected) {
    CAPTURE(image.x, image.y);
    CHECK(glm::distance(ramp().at(camera(), image), expected) < 1e-12);
  };
  check_at({0, 0}, {0, 10});
  check_at({300, 200}, {6, 4});
  check_at({150, 50}, {3, 8.5});
  check_at({110, 170}, {2.2, 4.9});
  check_at({-20, 260}, {0, 4});
  CHECK(Displacement{}.at(camera(), {150, 50}) == glm::dvec2(0));
}

TEST_CASE("displacements that break a rule are refused by name") {
  CHECK_NOTHROW(check(Displacement{}));
  CHECK_NOTHROW(check(ramp()));
  const auto complaint_of = [](const auto& change) -> std::string {
    Displacement broken = ramp();
    change(broken);
    try {
      check(broken);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(complaint_of([](Displacement& d) { d.columns = 1; }) == "displacement: columns is 1, must be at least 2");
  CHECK(complaint_of([](Displacement& d) { d.rows = 0; }) == "displacement: rows is 0, must be at least 2");
  CHECK(complaint_of([](Displacement& d) { d.nodes.pop_back(); }) ==
        "displacement: the number of nodes is 11, must be 12");
  CHECK(complaint_of([](Displacement& d) { d.nodes[3].y = std::numeric_limits<double>::quiet_NaN(); }) ==
        "displacement: a node's y is nan, must be finite");
}

}  // namespace
}  // namespace lumatlas
