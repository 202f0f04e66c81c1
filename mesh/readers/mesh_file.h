// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle soups from files: PLY (ASCII, binary little and big endian), OBJ (with per-vertex colours as most scanners
// write them) and STL. Polygons and PLY's triangle strips are cut into triangles; normals, texture coordinates and
// unknown properties are skipped.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "mesh/mesh.h"

namespace lumatlas {

// Picks the reader by the file's ending, .ply, .obj or .stl, in any case. Never allocates more than the file's own size
// justifies, whatever its header claims. Throws InputError: path, element and its index, value, what is wrong with it.
[[nodiscard]] TriangleSoup read_triangle_soup(const std::filesystem::path& path);

// Binary little-endian PLY with float positions, and colours if the mesh has them. Writes beside `path`, then renames.
// Throws InputError if the file cannot be written, std::invalid_argument if the mesh breaks a rule of mesh.h.
void write_ply(const std::filesystem::path& path, const Mesh& mesh);
// A soup in the same form, but with double positions, which may be far from the origin. Whether every byte was taken is
// the stream's to say. Throws std::invalid_argument if a face refers to no position, or colours are neither none nor
// one per position.
void write_ply(std::ostream& file, const TriangleSoup& soup);

}  // namespace lumatlas
