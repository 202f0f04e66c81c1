// SPDX-License-Identifier: GPL-3.0-or-later
// What no rigid camera explains of where a photograph shows the scene: wrong geometry, a rolling shutter, things that
// moved. A displacement for each node of a lattice over the picture, bilinear between them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "mesh/camera.h"

namespace lumatlas {

// The nodes that a place in the picture lies between, and their shares, which sum to 1.
struct LatticeShares {
  std::array<std::size_t, 4> node{};
  std::array<double, 4> share{};
};

struct Displacement {
  std::uint32_t columns = 0, rows = 0;  // of nodes, 2 or more of each; 0 with no node: nothing is displaced
  // Pixels; row by row, the outermost on the picture's border. The camera sees at an image position p what the picture
  // shows at p + the displacement there.
  std::vector<glm::dvec2> nodes;

  [[nodiscard]] bool empty() const { return nodes.empty(); }
  // `image` is in pixels of the camera; beyond the picture the displacement is that of its border.
  [[nodiscard]] glm::dvec2 at(const Camera& camera, const glm::dvec2& image) const;

  friend bool operator==(const Displacement&, const Displacement&) = default;
};

[[nodiscard]] LatticeShares lattice_shares(std::uint32_t columns, std::uint32_t rows, const Camera& camera,
                                           const glm::dvec2& image);

// Throws std::invalid_argument naming the field, its value and the rule: no node, or as many as columns and rows say,
// all finite.
void check(const Displacement& displacement);

}  // namespace lumatlas
