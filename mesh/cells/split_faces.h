// SPDX-License-Identifier: GPL-3.0-or-later
// Splits faces that are larger than a cell.
#pragma once

#include "mesh/cancel_check.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Returns the same surface with every edge at most `max_edge` long: longer edges are halved, longest first, and colours
// are interpolated. A manifold mesh stays manifold; where the mesh is not, no crack opens. Faces without a long
// edge keep their first corner and their order; new faces come last.
//
// An edge between needles (faces more than twenty times as long as high) is not split if it is longer than a thousand
// times `max_edge`, like those at a stray vertex, or once one million such edges have been halved. Otherwise a large
// polygon that was cut into a fan would become more faces than memory holds, for no area.
//
// Throws std::invalid_argument if the mesh breaks a rule of mesh.h; unless max_edge is finite, above 0 and at least
// four times the float resolution of the positions to be split; and if the result would have more faces than half of
// the machine's memory holds, at 400 bytes a face.
[[nodiscard]] Mesh split_large_faces(const Mesh& mesh, double max_edge, const CancelCheck& cancel_check = {});

// Returns how many faces split_large_faces() makes of a mesh at least, by the areas of its faces; it may make up to
// four times as many. Throws std::invalid_argument if the mesh breaks a rule of mesh.h, or if max_edge is not finite or
// not above 0.
[[nodiscard]] double fewest_split_faces(const Mesh& mesh, double max_edge);

}  // namespace lumatlas
