// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "mesh/mesh.h"

namespace lumatlas {

// The triangles of a Wavefront OBJ file with these contents. Throws InputError that begins with `path` and names the
// line.
//
// Read are "f", whose indices may be negative, and "v" with 3, 4, 6, 7 or 8 numbers, as many at every vertex:
//
//   x y z, x y z w              w must be 1, and may be missing at some vertices
//   x y z r g b                 r, g, b in [0, 1]
//   x y z w r g b, x y z r g b a  the first if the fourth number is 1 everywhere, refused if the last one is too and
//                               the colours would differ
//   x y z w r g b a             the opacity a is left out
//
// Polygons are cut into triangles, concave ones too; one or two corners give a degenerate triangle, which repair()
// counts. Texture, normals, groups, materials, points and lines are skipped. Free-form surfaces, other files and words
// that OBJ does not have are refused.
[[nodiscard]] TriangleSoup parse_obj(std::string_view contents, const std::string& path);

}  // namespace lumatlas
