// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of any glTF 2.0 file, .gltf or .glb: what its scene shows, in the scene's coordinates.
#pragma once

#include <filesystem>

#include "mesh/mesh.h"

namespace lumatlas {

// All triangles (lists, strips and fans) of the meshes that the nodes of the default scene show, each where its nodes
// put it, but of a model of lumatlas where its photographs see it: not turned upright, and with its offset. One that
// nodes mirror is turned round, so that it keeps its outside. Colours are COLOR_0, from linear light to
// sRGB, if every primitive has it. Points, lines, materials and textures are skipped. A buffer must lie in the file's
// own folder, also behind symbolic links. Throws InputError that begins with `path` for anything damaged, and for what
// would change the shape but is not read: compression by Draco, sparse accessors, skins, morphs, instances on the GPU.
// What EXT_meshopt_compression compressed is read.
[[nodiscard]] TriangleSoup read_gltf_mesh(const std::filesystem::path& path);

}  // namespace lumatlas
