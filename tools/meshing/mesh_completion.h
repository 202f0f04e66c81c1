// SPDX-License-Identifier: GPL-3.0-or-later
// Adds what a mesh lacks from another mesh of the same scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

inline constexpr std::uint32_t kCompletionPx = 512;  // longer side of the views that faces are counted in

struct CompletedMesh {
  TriangleSoup surface;  // the given mesh, unchanged, followed by the added vertices and faces
  std::size_t added_faces = 0;
  // Shares of the views' pixels that see the given mesh, and the completed one, [0, 1].
  double covered_before = 0, covered = 0;
};

// Adds to `given` the faces of `other` that fill its holes and go on beyond its ends. A face is added if most of the
// pixels that see it, in all views together, see nothing of `given`. A face before or behind a surface of `given` is
// not added, because either of the two may be inexact. Pieces of fewer than 100 faces are not added. If `given` has
// colours, the added vertices get their mean. The meshes share one frame; `views` are in that frame less `offset`.
// `progress` is called after each view; what it throws ends the work. Throws InputError if one of the meshes has no
// usable face.
[[nodiscard]] CompletedMesh completed(const TriangleSoup& given, const TriangleSoup& other,
                                      std::span<const Camera> views, const glm::dvec3& offset,
                                      const std::function<void()>& progress);

// Adds the faces of `part`, with the vertices that they use, to `surface`. If `surface` has colours, the added vertices
// get their mean.
void append_faces(const TriangleSoup& part, TriangleSoup& surface);

}  // namespace lumatlas
