// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of NumPy arrays.
#pragma once

#include <pybind11/pybind11.h>

#include "tools/python/bindings/bindings.h"

namespace lumatlas::python {

// Writes the arrays as a scene into a temporary folder, which goes with the last scene that holds it: photographs and
// masks as PNG, cameras as a COLMAP model, mesh.ply and fused.ply with double positions. Nothing is lost but the last
// bits of the rotations, which COLMAP keeps as quaternions. `photographs` and `cameras` are mappings with the same
// names; `masks`, if not None, has some of these. `vertices` and `faces` are both None for a scene without a mesh;
// `points`, if not None, are dense points of the surface. Throws std::invalid_argument naming the array, InputError.
// Needs Python's lock.
[[nodiscard]] Scene scene_of_arrays(const pybind11::object& photographs, const pybind11::object& cameras,
                                    const pybind11::object& vertices, const pybind11::object& faces,
                                    const pybind11::object& masks, const pybind11::object& points);

}  // namespace lumatlas::python
