// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: a mesh in parts, which several versions of it share.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/mesh.h"
#include "mesh/visibility/embree_scene.h"

namespace lumatlas {

// Faces of a cube of space. The vertices are numbered as the faces name them first.
struct TracedPart {
  Mesh mesh;
  EmbreeScene scene;
};

// Members are released from the last to the first: a scene before what it is of.
struct TracedParts {
  std::shared_ptr<const EmbreeDevice> device;
  std::vector<std::shared_ptr<const TracedPart>> parts;
  EmbreeScene scene;                 // of the parts' scenes, in their order
  std::vector<FaceId> faces;         // of the whole mesh, part by part
  std::vector<std::uint32_t> first;  // by part: where its faces begin
};

}  // namespace lumatlas
