// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/align_to_model.h"

#include <limits>

#include "planner/surface_samples.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kRounds = 8;
constexpr double kRestingPx = 0.02;
constexpr std::size_t kPoints = 4000;

AlignmentTargets targets_from(const Camera& camera, const Photograph& picture, const VisibilityBuffer& visible) {
  const Pyramid pyramid(picture);
  AlignmentTargets targets;
  targets.colors.resize(pyramid.levels());
  for (const SurfaceSample& sample : choose_surface_samples(camera, pyramid, visible, kPoints)) {
    targets.positions.push_back(sample.position);
    for (std::uint32_t level = 0; level < pyramid.levels(); ++level) {
      targets.colors[level].push_back(glm::vec3(pyramid.color(level, sample.image)));
    }
  }
  return targets;
}

}  // namespace

Camera align_to_model(const std::function<Photograph(const Camera&)>& render, const Visibility& visibility,
                      const Camera& camera, const Photograph& photograph) {
  const Pyramid pyramid(photograph);
  AlignmentOptions options;
  options.max_iterations = 20;
  options.least_improvement = 0;  // whatever pose scores best, however little
  Camera current = camera;
  Camera best = camera;
  double least_residual = std::numeric_limits<double>::infinity();
  for (std::uint32_t round = 0; round < kRounds; ++round) {
    const Photograph picture = render(current);
    const Alignment aligned = align(current, current, glm::dvec3(1.0), pyramid,
                                    targets_from(current, picture, visibility.trace(current)), options);
    if (aligned.residual_exposed < least_residual) {
      least_residual = aligned.residual_exposed;
      best = current;
    }
    if (!aligned.moved || aligned.moved_px < kRestingPx) break;
    current = aligned.camera;
  }
  return best;
}

}  // namespace lumatlas
