// SPDX-License-Identifier: GPL-3.0-or-later
// Averaged vertex colours: what is shown where no view is valid, and the baseline of view-independent colouring (what
// RGB-D fusion gives).
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "mesh/mesh.h"

namespace lumatlas {

struct StoredView;

// The mean over views, in linear light, of the colours that they show at each vertex, weighted by validity, and by a
// thousandth of it where the vertex is at the rim of what the view sees; a view that does not see the vertex (its depth
// there is nearer by over 2%) does not count.
class VertexColorMean {
 public:
  explicit VertexColorMean(const Mesh& mesh);  // keeps a reference to it

  // `gain` as in Snapshot::gains.
  void add(const StoredView& view, const glm::dvec3& gain);

  // sRGB, one per vertex. A vertex that no view showed has the mesh's own colour; where the mesh has none, the mean of
  // its neighbours' colours, spread from the nearest coloured vertices; mid-grey in a component without any.
  [[nodiscard]] std::vector<glm::u8vec3> colors() const;

 private:
  const Mesh& mesh_;
  std::vector<glm::vec4> sums_;  // weighted linear colour, weight
};

}  // namespace lumatlas
