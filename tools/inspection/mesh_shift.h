// SPDX-License-Identifier: GPL-3.0-or-later
// Finds by how much a mesh is shifted against the points of its scene.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

// Returns the shift of the mesh under which `points`, which have its frame, lie on its faces; the mesh is not turned.
// The search begins around the shift that brings the middles of both together, and goes by distances to planes (Chen
// and Medioni 1991), of which the largest tenth does not count. The result is rounded to whole thousands, hundreds and
// so on, as offsets usually are, if that moves the mesh by no more than points and mesh disagree anyway. None if there
// are fewer than 50 points or no faces with an area, or fewer than half of the points come to lie within a fiftieth of
// the mesh's diameter of it. The shift need not be right: the caller compares photographs under it. Takes about a
// second. Throws Interrupted soon after a signal.
[[nodiscard]] std::optional<glm::dvec3> estimated_mesh_shift(const Mesh& mesh, std::span<const glm::dvec3> points);

}  // namespace lumatlas
