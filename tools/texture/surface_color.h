// SPDX-License-Identifier: GPL-3.0-or-later
// The colour of a place of the surface: one for all directions, from every stored view that sees it.
//
// Each view i gives its colour c_i and the mean of its surroundings s_i. With base weights b_i and detail weights d_i:
//
//   b_i    = trust_i (cos_i rho_i)^2                       cos_i: of the angle to the normal; rho_i: the view's pixels
//   d_i    = b_i (cos_i rho_i)^sharpness                   per texel, at most 1
//   m      = mean of s_i by b_i r_i,   r_i = (1 + |s_i - m|^2 / t^2)^-2,   t^2 = tolerance^2 + (2 spread)^2
//   colour = m + (mean of c_i - s_i by d_i r_i)
//
// found in a few rounds, for the spread (root mean square distance from m) is by b_i r_i too. So what is broad comes
// from all views that agree, and detail from the frontal and near ones, for a mean of many would blur it. A highlight
// or a passer-by is in few of the directions and loses its weight r_i, while views that differ in two halves count
// alike. The weight is that of S. Geman and D. McClure, "Bayesian image analysis", 1985. Differences are of square
// roots of linear light, which is near what the eye sees. All of it is a continuous function of the place, and knows
// nothing of charts: no seam can come from them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "atlas/snapshot.h"
#include "tools/texture/consensus.h"
#include "tools/texture/surface_place.h"
#include "tools/texture/texture_views.h"

namespace lumatlas {

struct ColorOptions {
  // Exponent by which frontal and near views are preferred for detail; 0: not at all. [0, 16]
  double sharpness = 3;
  // Differences between views above this count as disagreement; of square roots of linear light. > 0
  double tolerance = 0.3;
  enum class Exposure {
    nearby,  // exposure of the photographs that see the place, see exposure_field.h
    model,   // the common exposure of all views
  };
  Exposure exposure = Exposure::nearby;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ColorOptions& options);

struct SurfaceColor {
  glm::vec3 color{0.0f};  // linear light in the model's exposure, >= 0
  bool seen = false;      // false: no view shows the place, the colour is that of the mesh's vertices
};

// A view that is trusted less than this counts less than the colours of the mesh's vertices, which stand in where no
// view is left.
inline constexpr float kLeastWeight = 1e-4f;

class SurfaceColors {
 public:
  // Keeps references to both.
  SurfaceColors(const SurfacePlaces& places, const TextureViews& views, const ColorOptions& options);

  // At shares b and c of a face's second and third corner; `density`: texels per scene unit. These are safe from any
  // thread.
  [[nodiscard]] SurfaceColor at(FaceId face, float b, float c, double density) const;
  [[nodiscard]] Consensus consensus(FaceId face, float b, float c, double density) const;

 private:
  // Collects the views' colours of the point in `shown`.
  void find_shown(FaceId face, const SurfacePlace& place, double density, std::vector<ShownPlace>& shown) const;
  // The same, until the next call on the same thread, and what they agree on.
  const std::vector<ShownPlace>& look(FaceId face, const SurfacePlace& place, double density,
                                      Consensus& consensus) const;

  const SurfacePlaces& places_;
  const TextureViews& views_;
  float sharpness_, tolerance_;
};

}  // namespace lumatlas
