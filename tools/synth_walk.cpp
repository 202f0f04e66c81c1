// SPDX-License-Identifier: GPL-3.0-or-later
// The photographer's walk: where the cameras of a synthetic scene stand and look.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

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

// The closed curve through a scene's points, by its length.
class Loop {
 public:
  explicit Loop(const std::vector<dvec3>& control) : curve_(control, Spline::Ends::closed) {
    const auto pieces = static_cast<std::size_t>(kFine * curve_.length());
    for (std::size_t i = 1; i <= pieces; ++i) {
      distances_.push_back(distances_.back() + glm::distance(position(static_cast<double>(i - 1)),
                                                             position(static_cast<double>(i % pieces))));
    }
  }

  [[nodiscard]] double length() const { return distances_.back(); }

  // `distance` is in [0, length()).
  [[nodiscard]] dvec3 at(double distance) const {
    const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, distance);
    const auto piece = static_cast<std::size_t>(after - distances_.begin()) - 1;
    return position(static_cast<double>(piece) +
                    (distance - distances_[piece]) / (distances_[piece + 1] - distances_[piece]));
  }

 private:
  static constexpr double kFine = 256;  // pieces per segment: chords within 1e-5 of the arc

  [[nodiscard]] dvec3 position(double piece) const { return curve_.at(piece / kFine); }

  Spline curve_;
  std::vector<double> distances_{0};  // at each piece's beginning, and the whole length
};

Loop checked_loop(const Scene& scene, const SynthOptions& options) {
  check(options);
  if (scene.walk.size() < 4) {
    throw std::invalid_argument("scene: walk has " + std::to_string(scene.walk.size()) +
                                " points, must have at least 4");
  }
  return Loop(scene.walk);
}

Camera camera_without_pose(const SynthOptions& options) {
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = 0.5 * options.width / std::tan(options.fov_deg * kTurn / 720);
  camera.cx = 0.5 * options.width;
  camera.cy = 0.5 * options.height;
  return camera;
}

// Chosen so that with 40 views 97% of a held-out photograph is seen by another view, 79% by three.
constexpr double kTurns = 4;      // of the heading in one loop
constexpr double kNods = 5;       // of the pitch in one loop
constexpr double kLevel = -0.16;  // mean pitch, radians: floors and tables matter more than ceilings
constexpr double kNod = 0.2;      // radians

}  // namespace

std::vector<Camera> cameras_on_walk(const Scene& scene, const SynthOptions& options) {
  const Loop loop = checked_loop(scene, options);
  Camera camera = camera_without_pose(options);
  std::vector<Camera> cameras;
  for (std::uint32_t view = 0; view < options.views; ++view) {
    const double share = static_cast<double>(view) / options.views;
    look(camera, loop.at(loop.length() * share), kTurn * kTurns * share,
         kLevel + kNod * std::sin(kTurn * kNods * share));
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<Camera> cameras_on_path(const Scene& scene, const SynthOptions& options) {
  constexpr double kAbove = 0.12;  // scene units: free of the furniture, for the walk is above all that it passes
  constexpr double kAside = 0.35;  // radians, of the heading
  const Loop loop = checked_loop(scene, options);
  Camera camera = camera_without_pose(options);
  std::vector<Camera> cameras;
  for (std::uint32_t frame = 0; frame < options.path_frames; ++frame) {
    const double distance = std::fmod(options.path_step * frame, loop.length());
    const double share = distance / loop.length();
    look(camera, loop.at(distance) + dvec3(0, 0, kAbove), kAside + kTurn * kTurns * share,
         kLevel - kNod * std::sin(kTurn * kNods * share));
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace lumatlas::synth
