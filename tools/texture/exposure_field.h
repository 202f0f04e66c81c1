// SPDX-License-Identifier: GPL-3.0-or-later
// The exposure that each place of a surface is shown in: that of the photographs that see it.
//
// Each view has a gain that brings it to the model's one exposure. A camera's automatic exposure varies by a stop and
// more, so in one exposure bright surfaces clip and dark ones stay dark, and the picture looks like no photograph. So a
// place has the factor
//
//   exp(-sum_i a_i ln g_i / sum_i a_i)       g_i: gain of view i, a_i: how far it is trusted at the place
//
// per channel, then smoothed along the surface, so that it shows no border of a photograph. It is the same idea as in
// blend/exposure.h, for places instead of cameras.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "mesh/mesh.h"
#include "tools/texture/texture_views.h"

namespace lumatlas {

class ExposureField {
 public:
  explicit ExposureField(const Mesh& mesh);  // keeps a reference

  void add(const TextureView& view);

  // Returns the factor of each vertex, positive; vertices at one place have the same. Exactly 1 if every gain is 1. A
  // vertex that no view shows has the factor of those around it, and one that is joined to none of them the mean of
  // all.
  [[nodiscard]] std::vector<glm::vec3> factors() const;

 private:
  const Mesh& mesh_;
  std::vector<glm::vec4> sums_;  // one per vertex: -sum a_i ln g_i, sum a_i
};

}  // namespace lumatlas
