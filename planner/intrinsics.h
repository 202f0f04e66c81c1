// SPDX-License-Identifier: GPL-3.0-or-later
// Do the photographs ask for other intrinsics? One correction, shared by all stored views, is estimated by Gauss-Newton
// from how they disagree at surface points: a focal length (a factor), the principal point and a radial coefficient.
//
// All views' poses and exposures are solved for along with it and marginalised, so a focal length that moving the
// cameras explains as well gets a large deviation and is not believed. The colours that a view is compared with are the
// other views' medians; they change with the correction and with those views' poses, and the derivatives say so. Time
// grows with the cube of the number of stored views, memory with its square: 4 MB at 100 views. How many views the
// atlas has room for makes no difference.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "planner/interruption.h"
#include "planner/median_colors.h"
#include "planner/surface_samples.h"

namespace lumatlas {

struct Intrinsics {
  double focal = 1;           // factor on fx and fy
  glm::dvec2 principal{0.0};  // shift of cx and cy, in pixels of the widest image; of others in proportion to width
  double radial = 0;          // k1: a point at distance r from the axis, at unit depth, is seen at r (1 + k1 r^2)
};

struct IntrinsicsEstimate {
  Intrinsics correction;
  // Standard deviations. The larger of two estimates: from the residuals' variance, taking the three channels of a
  // point for one measurement; and from how the views' gradients scatter, which stands correlation within a view.
  // Doubled variance in both, because two views that are compared with each other are counted twice.
  Intrinsics deviation{0, {0, 0}, 0};
  // Root of the mean robust squared difference, sRGB values of [0, 1], with the best poses and exposures for each.
  double residual_before = 0, residual_after = 0;
  double corner_px = 0;  // by which the correction moves a corner of the widest image, at most
  std::size_t views = 0;
  std::size_t points = 0;
  std::size_t unknowns = 0;  // that were solved for together; 0 with no view
  // The residual falls by 1 % or more, and a parameter of more than 5 deviations moves the corner by more than 0.5 px.
  bool significant = false;
  std::vector<Camera> cameras;  // by slot: corrected (but for the radial coefficient), poses refined along
};

struct IntrinsicsOptions {
  bool radial = true;  // estimate k1; else it is 0
  // Of each view, evenly taken, >= 1. Time grows with it, and deviations fall with its square root.
  std::size_t most_points = std::numeric_limits<std::size_t>::max();
  InterruptionPoint interruption_point = {};
};

// `views` and `samples` by slot: the points at which the view there is compared with the views that a sample's cell
// refers to. A view with fewer than kFewestAlignmentPoints points that others show takes no part; with no view that
// does, the correction is none, its deviations are 0 and it is not significant. Throws std::invalid_argument if
// most_points is 0, if there are not as many views and lists of samples as the atlas has slots, or if a sample's face
// is not in the mesh.
[[nodiscard]] IntrinsicsEstimate estimate_intrinsics(const Atlas& atlas,
                                                     std::span<const std::optional<ComparedView>> views,
                                                     std::span<const std::vector<SurfaceSample>> samples,
                                                     const IntrinsicsOptions& options = {});

}  // namespace lumatlas
