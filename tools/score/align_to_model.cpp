// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/align_to_model.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "mesh/base/median.h"
#include "planner/alignment.h"
#include "planner/photometry.h"
#include "planner/surface_samples.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

constexpr std::size_t kPoints = 4000;
constexpr std::uint32_t kSketchPx = 480;  // longer side of a sketch, about
constexpr std::uint32_t kSketches = 3;
constexpr double kRestingPx = 0.05;

AlignmentOptions search_options() {
  AlignmentOptions options;
  options.max_iterations = 20;
  options.least_improvement = 0;  // whatever pose agrees best, however little
  return options;
}

AlignmentTargets targets_from(const Camera& camera, const Pyramid& picture, const VisibilityBuffer& visible) {
  AlignmentTargets targets;
  targets.colors.resize(picture.levels());
  for (const SurfaceSample& sample : choose_surface_samples(camera, picture, visible, kPoints)) {
    targets.positions.push_back(sample.position);
    for (std::uint32_t level = 0; level < picture.levels(); ++level) {
      targets.colors[level].push_back(glm::vec3(picture.color(level, sample.image)));
    }
  }
  return targets;
}

// The camera whose photograph a level of a pyramid is.
Camera camera_of_level(Camera camera, const Pyramid& photograph, std::uint32_t level) {
  const double scale = 1.0 / static_cast<double>(1u << level);
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx *= scale;
  camera.cy *= scale;
  camera.width = photograph.level(level).width;
  camera.height = photograph.level(level).height;
  return camera;
}

Camera with_pose_of(Camera camera, const Camera& placed) {
  camera.cam_from_world_rotation = placed.cam_from_world_rotation;
  camera.cam_from_world_translation = placed.cam_from_world_translation;
  return camera;
}

// How far the pose that agrees best with a sketch is away from `given`.
class Sketches {
 public:
  Sketches(const ModelPictures& model, const Camera& given, const Pyramid& photograph)
      : model_(model),
        level_(photograph.level_near(kSketchPx)),
        photograph_(photograph.level(level_)),
        given_(camera_of_level(given, photograph, level_)) {}

  // Away from `given`, and how far the photograph is from the sketch itself, whose camera is not moved.
  struct Best {
    CameraMotion motion;
    double residual;
  };
  [[nodiscard]] Best best_from(const Camera& from) const {
    throw_if_interrupted();
    const Camera camera = with_pose_of(given_, from);
    const Photograph picture = model_.sketch(camera);
    const AlignmentTargets targets = targets_from(camera, Pyramid(picture), model_.visibility.trace(camera));
    const Alignment aligned = align(camera, camera, glm::dvec3(1.0), photograph_, targets, search_options());
    return {motion_between(given_, aligned.camera), aligned.residual_exposed};
  }

 private:
  const ModelPictures& model_;
  std::uint32_t level_;
  Pyramid photograph_;  // of the sketches' size
  Camera given_;
};

double median_move_px(const Camera& from, const Camera& to, const std::vector<glm::dvec3>& points) {
  std::vector<double> moves;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 a = from.cam_from_world(point);
    const glm::dvec3 b = to.cam_from_world(point);
    if (a.z > 0 && b.z > 0) moves.push_back(glm::length(to.image_from_cam(b) - from.image_from_cam(a)));
  }
  return moves.empty() ? 0 : upper_median(moves);
}

// Where a search from a picture at `found` would end, again and again until it rests. The sketches tell how the
// search's end changes with the pose that its picture is drawn from; where it ends, finer pictures than theirs have
// said. None if the photograph agrees less with the last sketch than with the one from `given`.
std::optional<Camera> at_rest(const Sketches& sketches, const Camera& given, const Camera& found,
                              const std::vector<glm::dvec3>& points) {
  const CameraMotion first = motion_between(given, found);
  const auto [reference, residual_given] = sketches.best_from(given);
  Camera current = found;
  double residual_last = residual_given;
  for (std::uint32_t i = 0; i < kSketches; ++i) {
    const auto [here, residual_here] = sketches.best_from(current);
    residual_last = residual_here;
    const Camera next =
        moved(given, first.turn + here.turn - reference.turn, first.shift + here.shift - reference.shift);
    const double step_px = median_move_px(current, next, points);
    current = next;
    if (step_px < kRestingPx) break;
  }
  if (!(residual_last < residual_given)) return std::nullopt;
  return current;
}

// How far the photograph at this pose is from the picture, after the exposure that fits best.
double residual(const Camera& camera, const Pyramid& photograph, const AlignmentTargets& targets) {
  AlignmentOptions exposure_only = search_options();
  exposure_only.pose = false;
  return align(camera, camera, glm::dvec3(1.0), photograph, targets, exposure_only).residual;
}

}  // namespace

std::optional<AlignedView> align_to_model(const ModelPictures& model, const Camera& given, const Seen& at_given,
                                          const Pyramid& photograph) {
  throw_if_interrupted();
  const AlignmentTargets targets = targets_from(given, Pyramid(at_given.picture), at_given.visible);
  const Alignment found = align(given, given, glm::dvec3(1.0), photograph, targets, search_options());
  if (!found.moved || found.moved_px < search_options().least_move_px) return std::nullopt;
  const std::optional<Camera> camera =
      at_rest(Sketches(model, given, photograph), given, found.camera, targets.positions);
  if (!camera) return std::nullopt;
  throw_if_interrupted();
  AlignedView aligned{*camera, {model.draw(*camera), model.visibility.trace(*camera)}};
  const AlignmentTargets seen = targets_from(*camera, Pyramid(aligned.seen.picture), aligned.seen.visible);
  if (!(residual(*camera, photograph, seen) < residual(given, photograph, targets))) return std::nullopt;
  return aligned;
}

}  // namespace lumatlas
