// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "mesh/mesh.h"

namespace lumatlas {

// The triangles of an STL file with these contents, binary or ASCII. Corners at exactly the same position become one
// vertex; normals, names and the colours that some programs put into binary files are skipped. A file is binary if its
// length is what its count of triangles says, whatever it begins with. The words of an ASCII file may be in any case,
// and blanks may stand before the first. Throws InputError that begins with `path`.
[[nodiscard]] TriangleSoup parse_stl(std::string_view contents, const std::string& path);

}  // namespace lumatlas
