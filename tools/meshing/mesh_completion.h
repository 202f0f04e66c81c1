// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh lacks, from another mesh of the same scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera.h"
#include "mesh/mesh.h"

namespace lumatlas {

inline constexpr std::uint32_t kCompletionPx = 512;  // of a photograph's longer side, as it is looked through

struct CompletedMesh {
  TriangleSoup surface;  // all of the given mesh, and what was added, in the coordinates of both
  std::size_t added_faces = 0;
  double covered_before = 0, covered = 0;  // shares of the photographs' pixels that see the given mesh, and this one
};

// Adds the faces of `other` where photographs that see them see nothing of `given`: in its holes and beyond its ends.
// What stands before or behind a surface of `given` is not added, because the two may be inexact. Nor are pieces of
// fewer than a hundred faces. With colours in `given`, what is added has their mean. `views` in the coordinates of both
// meshes less `offset`. `progress` is called after each view, from any thread; what it throws ends the work. Throws
// InputError if one of the meshes has no face.
[[nodiscard]] CompletedMesh completed(const TriangleSoup& given, const TriangleSoup& other,
                                      std::span<const Camera> views, const glm::dvec3& offset,
                                      const std::function<void()>& progress);

}  // namespace lumatlas
