// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/displacement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lumatlas {

LatticeShares lattice_shares(std::uint32_t columns, std::uint32_t rows, const Camera& camera, const glm::dvec2& image) {
  const double x = std::clamp(image.x / camera.width, 0.0, 1.0) * (columns - 1);
  const double y = std::clamp(image.y / camera.height, 0.0, 1.0) * (rows - 1);
  const std::size_t left = std::min<std::size_t>(static_cast<std::size_t>(x), columns - 2);
  const std::size_t top = std::min<std::size_t>(static_cast<std::size_t>(y), rows - 2);
  const double fx = x - static_cast<double>(left);
  const double fy = y - static_cast<double>(top);
  const std::size_t first = top * columns + left;
  return {{first, first + 1, first + columns, first + columns + 1},
          {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

glm::dvec2 Displacement::at(const Camera& camera, const glm::dvec2& image) const {
  if (empty()) return glm::dvec2(0);
  const LatticeShares shares = lattice_shares(columns, rows, camera, image);
  glm::dvec2 sum(0);
  for (std::size_t i = 0; i < 4; ++i) sum += shares.share[i] * nodes[shares.node[i]];
  return sum;
}

void check(const Displacement& displacement) {
  if (displacement.empty() && displacement.columns == 0 && displacement.rows == 0) return;
  const auto refuse = [](const std::string& field, const std::string& value, const std::string& rule) {
    throw std::invalid_argument("displacement: " + field + " is " + value + ", must be " + rule);
  };
  if (displacement.columns < 2) refuse("columns", std::to_string(displacement.columns), "at least 2");
  if (displacement.rows < 2) refuse("rows", std::to_string(displacement.rows), "at least 2");
  const std::size_t nodes = std::size_t{displacement.columns} * displacement.rows;
  if (displacement.nodes.size() != nodes) {
    refuse("the number of nodes", std::to_string(displacement.nodes.size()), std::to_string(nodes));
  }
  for (const glm::dvec2& node : displacement.nodes) {
    if (!std::isfinite(node.x)) refuse("a node's x", std::to_string(node.x), "finite");
    if (!std::isfinite(node.y)) refuse("a node's y", std::to_string(node.y), "finite");
  }
}

}  // namespace lumatlas
