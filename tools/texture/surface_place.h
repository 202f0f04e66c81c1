// SPDX-License-Identifier: GPL-3.0-or-later
// Places of a surface, and what one view shows of them: the terms of the formula in surface_color.h.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "atlas/snapshot.h"
#include "tools/texture/texture_views.h"

namespace lumatlas {

struct SurfacePlace {
  glm::vec3 point{0.0f};     // in the world
  glm::vec3 normal{0.0f};    // smoothed, of any length
  glm::vec3 stand_in{0.0f};  // the vertices' colours, linear light, for a place that no view shows
};

class SurfacePlaces {
 public:
  // Keeps a reference.
  explicit SurfacePlaces(const Snapshot& snapshot);

  // At shares b and c of a face's second and third corner.
  [[nodiscard]] SurfacePlace at(FaceId face, float b, float c) const;

  // Returns the factor from the model's exposure to the one in which the place is shown; 1 unless there are factors.
  [[nodiscard]] glm::vec3 exposure(FaceId face, float b, float c) const;
  // Sets the factor of each vertex, positive.
  void set_exposures(std::vector<glm::vec3> factors) { exposures_ = std::move(factors); }

  [[nodiscard]] const Surface& surface() const { return *snapshot_.surface; }

 private:
  const Snapshot& snapshot_;
  std::vector<glm::vec3> normals_;    // one per vertex, smoothed
  std::vector<glm::vec3> exposures_;  // one per vertex, or empty
};

// c_i, s_i, the square root of s_i, b_i and d_i of surface_color.h.
struct ShownPlace {
  glm::vec3 color, smooth, root;
  float base, detail;  // base > 0
};

// `density`: texels per scene unit. None: the view does not show the place, or may not be used there. The second
// takes the place that view.sees() gave.
[[nodiscard]] std::optional<ShownPlace> shown_in(const TextureView& view, const SurfacePlace& place, double density,
                                                 float sharpness);
[[nodiscard]] std::optional<ShownPlace> shown_in(const TextureView& view, const SurfacePlace& place,
                                                 const TextureView::ImagePoint& seen, double density, float sharpness);

}  // namespace lumatlas
