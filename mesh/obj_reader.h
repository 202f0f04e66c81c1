// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "mesh/mesh.h"

namespace lumatlas {

// The triangles of a Wavefront OBJ file with these contents. Throws InputError that begins with `path` and names the
// line.
//
// Read are "v x y z", "v x y z w" (w is ignored), "v x y z r g b" (r, g, b in [0, 1], for all vertices or for none) and
// "f", whose indices may be negative. Polygons are cut into triangles, concave ones too; one or two corners give a
// degenerate triangle, which repair() counts. All else is skipped.
[[nodiscard]] TriangleSoup parse_obj(std::string_view contents, const std::string& path);

}  // namespace lumatlas
