// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/align_to_model.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "mesh/base/median.h"
#include "planner/refinement/alignment.h"
#include "planner/refinement/photometry.h"
#include "planner/refinement/surface_samples.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

constexpr std::size_t kPoints = 8000;
constexpr std::uint32_t kSearches = 8;
constexpr double kRestingPx = 0.05;
constexpr double kLeastMovePx = 0.1;
constexpr double kMostGrowth = 0.5;  // ratio of the second move to the first up to which the moves still come to an end

AlignmentOptions search_options() {
  AlignmentOptions options;
  options.max_iterations = 20;
  options.least_improvement = 0;  // whatever pose agrees best, however little
  options.correlation = false;
  return options;
}

// Points of the surface with their colours in the picture, where the photograph has a colour too.
AlignmentTargets targets_from(const Camera& camera, const Pyramid& picture, const VisibilityBuffer& visible,
                              const Pyramid& photograph) {
  AlignmentTargets targets;
  targets.colors.resize(picture.levels());
  for (const SurfaceSample& sample : choose_surface_samples(camera, picture, visible, kPoints)) {
    if (!photograph.is_valid(sample.image)) continue;
    targets.positions.push_back(sample.position);
    for (std::uint32_t level = 0; level < picture.levels(); ++level) {
      targets.colors[level].push_back(glm::vec3(picture.color(level, sample.image)));
    }
  }
  return targets;
}

double median_move_px(const Camera& from, const Camera& to, const std::vector<glm::dvec3>& points) {
  std::vector<double> moves;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 a = from.cam_from_world(point);
    const glm::dvec3 b = to.cam_from_world(point);
    if (a.z > 0 && b.z > 0) moves.push_back(glm::length(to.image_from_cam(b) - from.image_from_cam(a)));
  }
  return moves.empty() ? 0 : upper_median(moves);
}

double longer_side(const Camera& camera) {
  return std::max(camera.width, camera.height);
}

// Returns the pose at which repeated searches from one picture end, each starting from, and pulled to, the end of the
// last. The pull of a single search leaves a part of the way, which along a plain wall is most of it.
Camera at_rest(const Camera& from, const AlignmentTargets& targets, const Pyramid& photograph) {
  const AlignmentOptions options = search_options();
  Camera current = from;
  for (std::uint32_t i = 0; i < kSearches; ++i) {
    throw_if_interrupted();
    const Camera next = align(current, current, glm::dvec3(1.0), photograph, targets, options).camera;
    if (median_move_px(from, next, targets.positions) > options.max_move * longer_side(from)) break;
    const double step_px = median_move_px(current, next, targets.positions);
    current = next;
    if (step_px < kRestingPx) break;
  }
  return current;
}

// Returns the factor between the points' first and second move in the image, where they move from a to b and to c.
double growth(const Camera& a, const Camera& b, const Camera& c, const std::vector<glm::dvec3>& points) {
  double along = 0;
  double first = 0;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 at_a = a.cam_from_world(point);
    const glm::dvec3 at_b = b.cam_from_world(point);
    const glm::dvec3 at_c = c.cam_from_world(point);
    if (!(at_a.z > 0 && at_b.z > 0 && at_c.z > 0)) continue;
    const glm::dvec2 middle = b.image_from_cam(at_b);
    const glm::dvec2 move = middle - a.image_from_cam(at_a);
    along += glm::dot(move, c.image_from_cam(at_c) - middle);
    first += glm::dot(move, move);
  }
  return first > 0 ? std::clamp(along / first, -kMostGrowth, kMostGrowth) : 0;
}

// Returns the pose at which the search would end if it were repeated from pictures at its end. A second search, from
// `found`, says how the end changes with the pose that its picture is drawn from, and each further move would be the
// same share of the one before.
Camera searched_again(const ModelPictures& model, const Camera& given, const Camera& found, const Pyramid& photograph,
                      const std::vector<glm::dvec3>& points) {
  throw_if_interrupted();
  const Photograph sketch = model.sketch(found);
  const AlignmentTargets targets = targets_from(found, Pyramid(sketch), model.visibility.trace(found), photograph);
  const Camera again = at_rest(found, targets, photograph);
  const auto [turn, shift] = motion_between(found, again);
  const double all_moves = 1 / (1 - growth(given, found, again, points));
  return moved(found, all_moves * turn, all_moves * shift);
}

// The difference of the photograph at this pose from the picture, after the exposure that fits best.
double residual(const Camera& camera, const Pyramid& photograph, const AlignmentTargets& targets) {
  AlignmentOptions exposure_only = search_options();
  exposure_only.pose = false;
  return align(camera, camera, glm::dvec3(1.0), photograph, targets, exposure_only).residual;
}

}  // namespace

std::optional<AlignedView> align_to_model(const ModelPictures& model, const Camera& given, const Seen& at_given,
                                          const Pyramid& photograph) {
  throw_if_interrupted();
  const AlignmentTargets targets = targets_from(given, Pyramid(at_given.picture), at_given.visible, photograph);
  const Camera found = at_rest(given, targets, photograph);
  const double moved_px = median_move_px(given, found, targets.positions);
  if (moved_px < kLeastMovePx) return std::nullopt;
  const bool far = moved_px > kFarAlignment * longer_side(given);
  const Camera camera = far ? searched_again(model, given, found, photograph, targets.positions) : found;
  throw_if_interrupted();
  AlignedView aligned{camera, {model.draw(camera), model.visibility.trace(camera)}};
  const AlignmentTargets seen = targets_from(camera, Pyramid(aligned.seen.picture), aligned.seen.visible, photograph);
  if (!(residual(camera, photograph, seen) < residual(given, photograph, targets))) return std::nullopt;
  return aligned;
}

}  // namespace lumatlas
