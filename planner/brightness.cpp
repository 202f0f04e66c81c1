// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Zhou and Koltun 2014, "Color map optimization for 3D reconstruction with consumer depth cameras", for what
// is compared; Chirikjian 2011, "Stochastic models, information theory, and Lie groups" 2, section 10.6.1, for the
// derivative of a rotation by its vector.
#include "planner/brightness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "mesh/base/median.h"
#include "planner/alignment.h"
#include "planner/photometry.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kFinestPx = 1000;  // longer side: beyond, noise and compression rule the gradients
constexpr std::size_t kHeldOut = 5;        // each such point is not fitted to
constexpr double kBlack = 0.002;           // linear light, added so that the curve is not too steep near 0
constexpr glm::dvec3 kLuma(0.2126, 0.7152, 0.0722);
constexpr int kMeanRounds = 5;

std::uint32_t finest_level(const Pyramid& pyramid) {
  std::uint32_t level = 0;
  while (level + 1 < pyramid.levels() &&
         std::max(pyramid.level(level).width, pyramid.level(level).height) > kFinestPx) {
    ++level;
  }
  return level;
}

struct PointOfView {
  glm::dvec3 position;
  double depth;
  std::vector<Sight> sights;
};

// The points that a view's samples give.
std::vector<PointOfView> points_of(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                                   std::uint32_t slot, const std::vector<SurfaceSample>& samples,
                                   std::size_t most_points) {
  std::vector<PointOfView> points;
  const ComparedView& view = *views[slot];
  const auto finest = static_cast<double>(finest_level(view.pyramid));
  const std::size_t stride = samples.empty() ? 1 : (samples.size() - 1) / most_points + 1;
  for (std::size_t index = 0; index < samples.size(); index += stride) {
    const SurfaceSample& sample = samples[index];
    if (!seen_at(*view.view, sample.position)) continue;
    const double z = view.view->camera.cam_from_world(sample.position).z;
    PointOfView point{sample.position, z, {{slot, static_cast<float>(finest)}}};
    for (const std::uint32_t other : atlas.references(atlas.surface().cells.cell_of_face[sample.face])) {
      if (other == slot || !views[other]) continue;
      const std::optional<glm::dvec3> seen = seen_at(*views[other]->view, sample.position);
      if (!seen || !is_informative(views[other]->pyramid.color(0, glm::dvec2(*seen)))) continue;
      const double ratio = z / view.view->camera.fx * views[other]->view->camera.fx / seen->z;
      point.sights.push_back({other, static_cast<float>(finest + std::log2(ratio))});
    }
    if (point.sights.size() > 1) points.push_back(std::move(point));
  }
  if (points.size() < kFewestAlignmentPoints) points.clear();
  return points;
}

void append(const PointOfView& point, SeenPoints& to) {
  to.positions.push_back(point.position);
  to.sights.insert(to.sights.end(), point.sights.begin(), point.sights.end());
  to.first.push_back(to.sights.size());
}

// d (R(v) x) / d v, transposed, times what the result's derivative is: by the left Jacobian of SO(3).
glm::dvec3 by_rotation_vector(const glm::dvec3& v, const glm::dvec3& rotated, const glm::dvec3& by_result) {
  const glm::dvec3 by_turn = glm::cross(rotated, by_result);
  const double angle = glm::length(v);
  if (angle < 1e-8) return by_turn - 0.5 * glm::cross(v, by_turn);
  const glm::dvec3 axis = v / angle;
  const double along = std::sin(angle) / angle;
  return along * by_turn + (1 - along) * glm::dot(axis, by_turn) * axis -
         (1 - std::cos(angle)) / angle * glm::cross(axis, by_turn);
}

}  // namespace

Camera camera_at(const PoseFrame& frame, const PoseOffset& offset) {
  return moved(frame.camera, glm::dvec3(offset[0], offset[1], offset[2]),
               frame.depth * glm::dvec3(offset[3], offset[4], offset[5]));
}

PoseOffset offset_of(const PoseFrame& frame, const Camera& camera) {
  const auto [turn, shift] = motion_between(frame.camera, camera);
  return {turn.x, turn.y, turn.z, shift.x / frame.depth, shift.y / frame.depth, shift.z / frame.depth};
}

PointSplit split_points(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                        std::span<const std::vector<SurfaceSample>> samples, std::size_t most_points) {
  std::vector<std::vector<PointOfView>> points(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t slot) {
    if (!views[slot]) return;
    points[slot] = points_of(atlas, views, static_cast<std::uint32_t>(slot), samples[slot], most_points);
  });
  PointSplit split;
  split.depth.assign(views.size(), 0);
  split.per_view.assign(views.size(), 0);
  for (std::size_t slot = 0; slot < views.size(); ++slot) {
    if (points[slot].empty()) continue;
    std::vector<double> depths;
    for (const PointOfView& point : points[slot]) {
      depths.push_back(point.depth);
      append(point, depths.size() % kHeldOut == 0 ? split.held_out : split.fitted);
    }
    split.depth[slot] = upper_median(depths);
  }
  for (const Sight& sight : split.fitted.sights) ++split.per_view[sight.slot];
  return split;
}

Brightness brightness_in(const ComparedView& view, double level, const glm::dvec2& image) {
  Brightness result;
  const Photograph& photograph = view.view->photograph;
  result.image = image;
  result.inside = image.x >= 0 && image.y >= 0 && image.x < photograph.width && image.y < photograph.height;
  if (!result.inside) return result;
  const double nearest = std::clamp(std::round(level), 0.0, view.pyramid.levels() - 1.0);
  const ColorSample sample = view.pyramid.sample(static_cast<std::uint32_t>(nearest), image);
  const glm::dvec3 weight = kLuma * view.gain;
  const double light = glm::dot(weight, sample.color) + kBlack;
  result.value = 1.055 * std::pow(light, kBrightnessPower);
  const double slope = kBrightnessPower * result.value / light;
  result.by_image = slope * glm::dvec2(glm::dot(weight, sample.d_x), glm::dot(weight, sample.d_y));
  return result;
}

Brightness brightness_at(const ComparedView& view, const PoseFrame& frame, const PoseOffset& offset,
                         const Camera& camera, double level, const glm::dvec3& position) {
  const glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return {};
  Brightness result = brightness_in(view, level, camera.image_from_cam(cam));
  if (!result.inside) return result;
  const double gx = result.by_image.x * camera.fx / cam.z;
  const double gy = result.by_image.y * camera.fy / cam.z;
  const glm::dvec3 by_cam(gx, gy, -(gx * cam.x + gy * cam.y) / cam.z);
  const glm::dvec3 rotated = cam - frame.depth * glm::dvec3(offset[3], offset[4], offset[5]);
  const glm::dvec3 by_vector = by_rotation_vector(glm::dvec3(offset[0], offset[1], offset[2]), rotated, by_cam);
  result.by_pose = {by_vector.x,           by_vector.y, by_vector.z, frame.depth * by_cam.x, frame.depth * by_cam.y,
                    frame.depth * by_cam.z};
  return result;
}

double robust_mean(std::vector<double>& values, double noise) {
  double mean = median(values);
  for (int round = 0; round < kMeanRounds; ++round) {
    double sum = 0, weights = 0;
    for (const double value : values) {
      const double u = (value - mean) / (noise * kTukeyCutoff);
      if (u * u >= 1) continue;
      const double weight = (1 - u * u) * (1 - u * u);
      sum += weight * value;
      weights += weight;
    }
    if (!(weights > 0)) break;
    mean = sum / weights;
  }
  return mean;
}

}  // namespace lumatlas
