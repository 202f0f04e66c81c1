// SPDX-License-Identifier: GPL-3.0-or-later
// Continues surfaces past their outlines in a picture, as far as they are off.
//
// A mesh ends some pixels within fur and leaves, or beside a rough surface's true outline. A photograph's pixels beyond
// the mesh's outline then show the object, but count as what is behind it: a picture from another place shows them
// there, as a second contour apart from the object, with a strip of another photograph between. So the picture's pixels
// just beyond an outline show photographs as if the nearer surface went on: the object's true outline comes from the
// photographs, in one piece. Beyond that outline they show the background at the nearer depth, which is off by its
// parallax over these few pixels alone. A picture from a photograph's own camera does not depend on depths.
//
// With S the shift of a surface as in soft_edges.h, its outlines reach
//
//   r = min(kOutlineOfShift S, kOutlineReach)    pixels; 0 where S is at most 1: exact surfaces keep their outline
//
// A pixel with depth z shows the surface of the nearest pixel, at most its r away, whose depth is below
// z / (1 + kOutlineStep), at that depth. Of equal distances the smallest depth counts. Pixels that see no surface keep
// none. A pixel that a surface is continued to is no mean of samples.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// All shared with the shaders.
inline constexpr double kOutlineOfShift = 2;
inline constexpr int kOutlineReach = 4;       // pixels
inline constexpr double kOutlineStep = 0.05;  // of the nearer depth

// Returns for each pixel the number of the pixel whose surface it shows, row by row from the top left; its own in most
// cases. `deviation`: of the surface at each pixel, scene units; `most_deviation` as in soft_edges.h. Throws
// std::invalid_argument unless `visible` has a depth and a face, and `deviation` a value, for each pixel of the
// camera's image.
[[nodiscard]] std::vector<std::uint32_t> continued_outlines(const Camera& camera, const VisibilityBuffer& visible,
                                                            const std::vector<float>& deviation, double most_deviation);

}  // namespace lumatlas
