// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: positions of a soup that are at one place, and so are one point.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesh/base/id.h"

namespace lumatlas {

// For each position the one at the same place that stands for all of these; VertexId::none: it is not finite.
using PointOfPosition = std::vector<VertexId>;

struct JoinedPositions {
  PointOfPosition point;
  // For each position before that stood for all at its place and is gone: the one that stands for them now.
  std::unordered_map<std::uint32_t, VertexId> heirs;
};

// Returns the points of a version, whose `places` are its positions as floats. `previous_position` says for each which
// one it was before, at the same place (empty: none), and `position_now` is the inverse of it. `before` has the points
// of that version.
[[nodiscard]] JoinedPositions joined_positions(std::span<const glm::vec3> places,
                                               std::span<const VertexId> previous_position,
                                               std::span<const VertexId> position_now, const PointOfPosition& before);

}  // namespace lumatlas
