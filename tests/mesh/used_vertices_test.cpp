// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/used_vertices.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

TEST_CASE("used vertices get numbers in the order in which they are asked for") {
  UsedVertices used(5, 10);
  std::vector<std::uint32_t> added;
  const auto number_of = [&](std::uint32_t vertex) { return used.number_of(vertex, [&] { added.push_back(vertex); }); };
  CHECK(number_of(3) == 10);
  CHECK(number_of(0) == 11);
  CHECK(number_of(3) == 10);
  CHECK(number_of(4) == 12);
  CHECK(added == std::vector<std::uint32_t>{3, 0, 4});
}

TEST_CASE("some faces of a mesh are added to another one, with the vertices that they use") {
  const Mesh from{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}}, {}, {{0, 1, 2}, {2, 1, 3}, {3, 1, 4}}};
  Mesh to{{{9, 9, 9}}, {}, {}};
  add_faces(
      from, [](std::size_t face) { return face != 0; }, to);
  CHECK(to.positions == std::vector<glm::vec3>{{9, 9, 9}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 1, 0}});
  CHECK(to.faces == std::vector<glm::uvec3>{{1, 2, 3}, {3, 2, 4}});
}

}  // namespace
}  // namespace lumatlas
