// SPDX-License-Identifier: GPL-3.0-or-later
// The colours of surface points in the stored views: the medians that a photograph is aligned to (Erat et al. 2019,
// section 3.3). Medians are robust against highlights and anything else that only few views see.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "planner/refinement/alignment.h"
#include "planner/refinement/pyramid.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

// One view that others are compared with.
struct ComparedView {
  std::shared_ptr<const StoredView> view;
  Camera camera;    // its pose as last refined; depth was made at that of view->camera: see kDepthStandsPx
  Pyramid pyramid;  // of the view's photograph
  glm::dvec3 gain{1.0};
};

// Returns the pixel of the view that shows the point by its refined pose, and its z. Nothing if the view does not see
// the point well: occluded or beside an edge of depth, by the pose that its depth was made with, or masked.
[[nodiscard]] std::optional<glm::dvec3> seen_at(const ComparedView& view, const glm::dvec3& position);

// Linear colour, without the gain, that a view shows at a point; nothing where it does not see the point well
// (occluded, masked). `pixel_size`: of what it is compared with, scene units per pixel at the point.
[[nodiscard]] std::optional<glm::dvec3> color_in_view(const ComparedView& other, const glm::dvec3& position,
                                                      double pixel_size);

// The ratio of the light that view `slot` recorded to that of the photograph at the same points: medians over them.
struct ExposureRatio {
  ViewSlot slot;
  glm::dvec3 log_ratio;      // ln of the view's linear light over the photograph's, per channel
  glm::dvec3 log_luminance;  // the same of their sums over channels, three times
  std::uint32_t points;
};

struct MedianColors {
  AlignmentTargets targets;  // the samples that at least one view shows
  std::vector<ExposureRatio> ratios;
  double views_per_point = 0;  // mean
};

// Compares each sample with the views that its cell refers to. `views` by slot of the atlas, as many as it has, each
// with the photograph's depth and validity. `except`: a slot that does not count. `alignment`: what the targets
// are for; levels that it does not need are left empty. Throws std::invalid_argument if the
// number of views is another, if the photograph's size is not the camera's, or if a sample's face is not in the mesh.
[[nodiscard]] MedianColors median_colors(const Camera& camera, const Pyramid& photograph,
                                         std::span<const SurfaceSample> samples, const Atlas& atlas,
                                         std::span<const std::optional<ComparedView>> views,
                                         std::optional<ViewSlot> except, const AlignmentOptions& alignment = {});

}  // namespace lumatlas
