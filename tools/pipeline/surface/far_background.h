// SPDX-License-Identifier: GPL-3.0-or-later
// Finds what photographs show past the mesh and agree to be far: the far sphere of mesh/far_sphere.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "atlas/surface.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// A photograph in a small size.
struct SmallPhotograph {
  Camera camera;
  std::vector<glm::vec3> color;     // one per pixel, sRGB in [0, 255]: the mean of what it covers
  std::vector<std::uint8_t> valid;  // one per pixel, 1 or 0: all that it covers is the photograph's
};

// Returns a view's photograph in the size of `small`. All pixels of one that cannot be read are invalid.
[[nodiscard]] SmallPhotograph small_photograph(const SceneView& view, const Camera& small);

// Photographs of the views of these ranks, 60 of them at most, at even distances. All pixels of one that cannot be read
// are invalid. Throws Interrupted soon after a signal.
[[nodiscard]] std::vector<SmallPhotograph> small_photographs(const std::vector<SceneView>& views,
                                                             const std::vector<std::size_t>& ranks);

// Returns the faces of the far sphere around `cameras` and a mesh that photographs see past the mesh and on which their
// colours agree; empty where nothing is far. A near surface that the mesh lacks projects to another point of the sphere
// from each camera: its faces are left out, unless it is smooth. A region that one photograph alone shows is left out
// too; a gap of a face or two between far faces is closed. `visibility` is that of the mesh. The result is the same for
// any number of threads. Throws Interrupted soon after a signal.
[[nodiscard]] FarSphere find_far_sphere(const std::vector<SmallPhotograph>& photographs,
                                        std::span<const Camera> cameras, const Mesh& mesh,
                                        const Visibility& visibility);

// The part of a scene that each pixel of a camera sees, at kGlancePx.
struct FrameShare {
  double surface = 0;      // share of the pixels that see the mesh, [0, 1]
  double far = 0;          // share of those that see the far sphere past it, [0, 1]
  std::size_t pixels = 0;  // number of pixels that were counted
};

// `far`: the far sphere; null if there is none. `valid`: 1 for each pixel that counts; empty: all do.
[[nodiscard]] FrameShare frame_share(const Camera& camera, const Visibility& visibility, const Visibility* far,
                                     std::span<const std::uint8_t> valid = {});

}  // namespace lumatlas
