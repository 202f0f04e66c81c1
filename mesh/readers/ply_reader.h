// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

// The triangles of a PLY file with these contents. Throws InputError that begins with `path`.
//
// Positions: x, y, z of the element "vertex". Colours: red, green, blue (or diffuse_...); unsigned 16-bit ones run to
// 65535, other integers to 255, floating-point ones to 1. Faces: the list vertex_indices or vertex_index of the element
// "face", cut into triangles, also where it is concave; one or two corners give a degenerate triangle, which repair()
// counts. Strips: the same list of the element "tristrips", in which -1 ends a strip; each index makes a triangle with
// the two before it, unless a vertex repeats in it. All else that the header declares is skipped; bytes that it does
// not declare are refused.
[[nodiscard]] TriangleSoup parse_ply(std::string_view contents, const std::string& path);

// Points without faces, in the file's own coordinates.
struct PointSoup {
  std::vector<glm::dvec3> positions;
  std::vector<glm::u8vec3> colors;  // sRGB, one per position, or empty
  std::vector<glm::vec3> normals;   // the file's, one per position, or empty
};

// The vertices of a PLY file with these contents, normals by nx, ny and nz; faces and all else are skipped. Throws
// InputError that begins with `path`.
[[nodiscard]] PointSoup parse_ply_points(std::string_view contents, const std::string& path);

}  // namespace lumatlas
