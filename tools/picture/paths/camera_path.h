// SPDX-License-Identifier: GPL-3.0-or-later
// A camera that moves smoothly through key frames.
#pragma once

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "mesh/camera/camera.h"

namespace lumatlas {

// The position, orientation and field of view of a camera.
struct Vantage {
  glm::dvec3 position{0.0};                       // scene units, the scene's offset subtracted
  glm::dquat cam_from_world{1.0, 0.0, 0.0, 0.0};  // unit; camera frame as in mesh/camera/camera.h
  double fov_deg = 70;                            // horizontal field of view, in (0, 180)
};

// Looks from `position` at `target`, with `up` upwards in the picture. Where up says nothing, for it is zero or the
// view goes along it, the picture is turned anyhow. Throws std::invalid_argument if both points are the same.
[[nodiscard]] glm::dquat look_at(const glm::dvec3& position, const glm::dvec3& target, const glm::dvec3& up);

// Throws std::invalid_argument for a size outside of [1, 65536] or a field of view outside of (0, 180).
[[nodiscard]] Camera camera_at(const Vantage& vantage, std::uint32_t width, std::uint32_t height);

struct KeyFrame {
  double time = 0;
  Vantage vantage;
};

// Goes through every key frame at its time; position, turn and field of view have no jumps, and neither have their
// speeds. At a key frame the speed is that of the parabola through it and its neighbours; turns are shortest ones.
// Two key frames are joined by constant speed. Turned, moved or scaled key frames give the turned, moved or scaled
// path.
class CameraPath {
 public:
  // Throws std::invalid_argument, naming the key frame, if there are none, times do not ascend, or a number is not
  // finite or not in its range.
  explicit CameraPath(std::vector<KeyFrame> keys);

  [[nodiscard]] double begin() const { return keys_.front().time; }
  [[nodiscard]] double end() const { return keys_.back().time; }
  [[nodiscard]] Vantage at(double time) const;  // before begin() and after end() as there

  // The places at equal times from begin() to end(), both included; a single one is at begin().
  [[nodiscard]] std::vector<Vantage> evenly(std::size_t count) const;

 private:
  // Per unit of time.
  struct Speed {
    glm::dvec3 position{0.0};
    glm::dvec3 turn{0.0};  // rotation vector in the camera's frame, radians
    double log_focal = 0;
  };
  [[nodiscard]] Speed between(std::size_t first) const;

  std::vector<KeyFrame> keys_;
  std::vector<Speed> speeds_;  // at each
};

}  // namespace lumatlas
