// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: at which vertices is a triangle list no oriented manifold? Cheaper than repairing it to find out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/vertex_faces.h"

namespace lumatlas {

// The vertices, ascending, whose faces do not form one fan, open or closed, of faces that all turn the same way and are
// at least three where it is closed. Where there is none, no edge has three faces, no two faces have the same three
// vertices, and orienting would change nothing. Both ends of an edge that has three faces, or two that turn against
// each other, are among them, and so are all corners of a face whose vertices another has too. Each face must have
// three different vertices. `around` holds the faces around each vertex.
[[nodiscard]] std::vector<std::uint32_t> vertices_without_one_fan(
    std::size_t vertices, const std::vector<std::array<std::uint32_t, 3>>& faces, const VertexFaces& around);

}  // namespace lumatlas
