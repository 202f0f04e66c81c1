// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the trust in a surface made of points: how well it fits them, how much of it is a guess between them, and
// how much of the photographs it accounts for.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

// Distances are in pixels of the view nearest to the point.
inline constexpr double kOnSurfacePx = 2;       // a point this near lies on the surface
inline constexpr double kFarFromPointsPx = 30;  // a pixel's surface this far from every point is a guess

inline constexpr std::size_t kMostTrustViews = 200;  // that are looked through

struct SurfaceTrust {
  double points_on_surface = 0;    // share of the points within kOnSurfacePx of the surface, [0, 1]
  double pixels_covered = 0;       // share of the photographs' pixels that see the surface, [0, 1]
  double frames_mostly_empty = 0;  // share of the photographs that see the surface on less than half of their pixels
  double emptiest_covered = 0;     // share of the pixels of the photograph that sees least of it
  std::size_t emptiest_view = 0;   // that photograph, by its place in `views`
  double pixels_guessed = 0;  // share of those whose surface is farther than kFarFromPointsPx from every point, [0, 1]
};

// `points` with their views, in the frame of `views` and of the mesh. At most kMostTrustViews are looked through,
// evenly over all. `progress` is called after each of them; what it throws ends the work. Throws std::invalid_argument
// if the mesh breaks a rule of mesh.h or has no face.
[[nodiscard]] SurfaceTrust surface_trust(const Mesh& mesh, const ScenePoints& points, std::span<const Camera> views,
                                         const std::function<void()>& progress);

}  // namespace lumatlas
