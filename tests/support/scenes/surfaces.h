// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces with known areas for the tests, and slow, plain checks of what a mesh must be.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "mesh/mesh.h"

namespace lumatlas {

// [0, side]^2 at z = 0, facing +z, of 2 * quads^2 faces. Red is 255 * x / side, green 255 * y / side.
[[nodiscard]] Mesh plane(std::uint32_t quads, float side);

// Unit sphere around the origin, facing outwards: an octahedron whose faces are split in four `levels` times.
[[nodiscard]] Mesh sphere(int levels);

// A closed box from the origin to `extent`, facing outwards, each side of quads x quads quads.
[[nodiscard]] Mesh box(std::uint32_t quads, const glm::vec3& extent);

// All faces of both, as separate components; with colours if both have them.
[[nodiscard]] Mesh joined(const Mesh& a, const Mesh& b);
[[nodiscard]] Mesh moved(Mesh mesh, const glm::vec3& by);
[[nodiscard]] Mesh turned_inside_out(Mesh mesh);

[[nodiscard]] TriangleSoup to_soup(const Mesh& mesh);

[[nodiscard]] double area_of(const Mesh& mesh);
// Signed; of a closed mesh that faces outwards, positive.
[[nodiscard]] double volume_of(const Mesh& mesh);
[[nodiscard]] double longest_edge_of(const Mesh& mesh);

// No edge is used twice in one direction, and the faces around each vertex hang together over shared edges.
[[nodiscard]] bool is_manifold_and_oriented(const Mesh& mesh);
[[nodiscard]] std::size_t boundary_edges(const Mesh& mesh);

}  // namespace lumatlas
