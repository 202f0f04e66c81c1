// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: which faces of a triangle list are turned round, so that neighbours turn the same way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/repair/manifold_repair.h"

namespace lumatlas {

// An entry of a triangle list that is no face.
inline constexpr TriangleList::value_type kNoTriangle{~0U, ~0U, ~0U};

// Returns the faces that orient_and_split() turns round, ascending. Entries of `faces` may be kNoTriangle. `suspects`:
// vertices_without_one_fan(). Time: some passes over all faces in parallel, where suspects have an edge at which faces
// turn against each other; one otherwise.
[[nodiscard]] std::vector<std::uint32_t> faces_to_turn(std::size_t vertices, const TriangleList& faces,
                                                       const std::vector<std::uint32_t>& suspects);

}  // namespace lumatlas
