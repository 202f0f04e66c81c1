// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/joined_faces.h"

#include <catch2/catch.hpp>

#include "tests/support/scenes/surfaces.h"

namespace lumatlas {
namespace {

TEST_CASE("faces that were cut apart meet again, others stay as they are") {
  const Mesh whole = plane(6, 2);
  CHECK(joined_faces(whole) == whole.faces);
  Mesh soup;  // each face with vertices of its own, the last face's first
  for (const glm::uvec3& face : whole.faces) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (int corner = 0; corner < 3; ++corner) soup.positions.push_back(whole.positions[face[corner]]);
    soup.faces.emplace_back(first, first + 1, first + 2);
  }
  const std::vector<glm::uvec3> joined = joined_faces(soup);
  REQUIRE(joined.size() == whole.faces.size());
  for (std::size_t a = 0; a < joined.size(); ++a) {
    for (std::size_t b = 0; b < joined.size(); ++b) {
      for (int i = 0; i < 9; ++i) {
        REQUIRE((joined[a][i / 3] == joined[b][i % 3]) == (whole.faces[a][i / 3] == whole.faces[b][i % 3]));
      }
    }
  }
  soup.positions[0].x += 1e-6f;  // another place
  CHECK(joined_faces(soup)[0].x == 0);
}

}  // namespace
}  // namespace lumatlas
