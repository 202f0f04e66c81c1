// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how much the borders of cells show in a rendering: see tools/score/README.md.
//
// The error of a rendering, rendering less photograph, steps from each pixel to its neighbours. Blur, noise and wrong
// poses make it step everywhere; where two cells show different photographs it steps more at their border than two
// pixels away on either side. A seam of height h adds h^2 to the mean square step there:
//
//   S = sign(b - a) sqrt(|b - a|)      b, a: mean square step across borders, and beside them
#pragma once

#include <cstdint>
#include <unordered_set>

#include "atlas/images/photograph.h"
#include "mesh/cells/cells.h"
#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

class SeamMeter {
 public:
  // Keeps references to both. Throws std::invalid_argument unless each face of the mesh has a cell and corners that are
  // vertices.
  SeamMeter(const Mesh& mesh, const Cells& cells);

  // `visible` is what the camera sees of the mesh at the pictures' size (std::invalid_argument otherwise). Looks at
  // runs of eight pixels along a row or a column, the first four in one cell and the others in another one. A run
  // counts if it shows one smooth surface inside the lens's image: cells that share a vertex of the mesh, depths of
  // neighbours that differ by at most 2 %, normals within 30 degrees of that of the pixel before the border. The step
  // from the fourth to the fifth is across the border; those from the first to the second and from the seventh to the
  // eighth are beside it.
  void add(const VisibilityBuffer& visible, const Photograph& rendering, const Photograph& photograph);

  // S over all pictures, in 8-bit sRGB levels, root mean square over the channels; NaN if no border was looked at.
  // About 0 where no border shows; below 0 where there is less error at borders than beside them.
  [[nodiscard]] double contrast() const;
  [[nodiscard]] std::int64_t borders() const { return borders_; }  // how many were looked at

 private:
  [[nodiscard]] bool neighbours(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool crosses_border(const VisibilityBuffer& visible, std::size_t first, std::size_t stride) const;

  const Mesh& mesh_;
  const Cells& cells_;
  std::unordered_set<std::uint64_t> adjacent_;  // pairs of cells, the smaller one in the upper half
  // Whole numbers, so that the order of pixels and pictures does not matter.
  std::int64_t borders_ = 0;
  std::int64_t across_ = 0;  // square steps, all channels added
  std::int64_t beside_ = 0;  // likewise, two for each border
};

}  // namespace lumatlas
