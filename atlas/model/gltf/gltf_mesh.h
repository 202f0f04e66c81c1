// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of any glTF 2.0 file, .gltf or .glb: what its scene shows, in the scene's coordinates.
#pragma once

#include <filesystem>

#include "mesh/mesh.h"

namespace lumatlas {

// Returns all triangles (lists, strips and fans) of the meshes that the nodes of the default scene show, transformed by
// the nodes. The mesh of a lumatlas model is in the frame of its photographs instead: not turned upright, and with its
// offset. Faces that nodes mirror are reversed, so that they keep their outside. Colours are COLOR_0, from linear light
// to sRGB, if every primitive has it. Points, lines, materials and textures are skipped. A buffer must lie in the
// file's own folder, also behind symbolic links. Throws InputError that begins with `path` for damage, and for features
// that would change the shape but are not read: compression by Draco, sparse accessors, skins, morphs, instances on the
// GPU. EXT_meshopt_compression is read.
[[nodiscard]] TriangleSoup read_gltf_mesh(const std::filesystem::path& path);

}  // namespace lumatlas
