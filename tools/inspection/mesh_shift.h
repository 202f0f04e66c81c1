// SPDX-License-Identifier: GPL-3.0-or-later
// By how much a mesh is shifted against the points of its scene.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "mesh/mesh.h"

namespace lumatlas {

// Moves the mesh, without turning it, until `points`, which have its frame, lie on its faces: from several beginnings
// around the one where the middles of both fall together, by distances to planes (Chen and Medioni 1991), of which the
// largest tenth does not count. The shift is rounded to whole thousands, hundreds and so on, as offsets usually are,
// where that moves the mesh by less than points and mesh disagree anyway. None if there are fewer than 50 points, or
// fewer than half of them come to lie within a fiftieth of the mesh's diameter of it. A shift that is returned need not
// be right: the caller compares photographs under it. Takes about a second. Throws Interrupted soon after a signal.
[[nodiscard]] std::optional<glm::dvec3> estimated_mesh_shift(const Mesh& mesh, std::span<const glm::dvec3> points);

}  // namespace lumatlas
