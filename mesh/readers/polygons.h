// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: what the readers of mesh files have in common: polygons that become triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/mesh.h"

namespace lumatlas {

// The polygons of a soup with more than three corners, each of which begins as the fan of triangles that joins its
// first corner with each of its other edges.
class Polygons {
 public:
  // Appends the fan of a polygon to the soup's faces. One or two corners give one degenerate triangle, so that repair()
  // can count it; none give nothing.
  void append(std::span<const std::uint32_t> corners, std::vector<glm::uvec3>& faces);

  // Call it once all positions are known. Replaces some fans, in place, by constrained Delaunay triangulations: those
  // that do not cover their polygons, because these are concave or have corners in a line, and those of polygons with
  // more than eight corners, which may be needles. A polygon keeps its corners and the direction in which it turns; it
  // is looked at along the axis in which its normal is longest. Where corners repeat, so that it has fewer triangles
  // than its fan, degenerate ones make up the number. A polygon that crosses itself, has no area or a corner that is
  // not finite keeps its fan.
  void triangulate(TriangleSoup& soup) const;

 private:
  struct Fan {
    std::size_t first;      // its first face
    std::uint32_t corners;  // two more than it has faces
  };
  static void triangulate(const Fan& fan, TriangleSoup& soup);
  std::vector<Fan> fans_;
};

// The triangles that cover a polygon, by constrained Delaunay triangulation along the axis in which its normal is
// longest; they turn as it does. Nothing if it crosses or touches itself as seen along that axis, or has no area.
// `corners` are indices into `positions`.
[[nodiscard]] std::optional<std::vector<glm::uvec3>> triangulated(std::vector<std::uint32_t> corners,
                                                                  const std::vector<glm::dvec3>& positions);

[[nodiscard]] inline InputError no_faces(const std::string& path) {
  return InputError(path +
                    ": has no faces; a point cloud must be meshed first, for instance by Poisson reconstruction");
}

}  // namespace lumatlas
