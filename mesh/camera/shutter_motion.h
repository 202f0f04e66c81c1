// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of a camera while a rolling shutter reads its picture, line by line, from one end to the other.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "mesh/camera/camera.h"

namespace lumatlas {

// At the time t in [-0.5, 0.5], from the first line that is read to the last, a point X of the camera frame at t = 0 is
// at
//
//   X + t (turn x X + shift)
//
// in the camera frame. Lines are read along the shorter side of the picture: from the top where it is at least as wide
// as high, and from the left where it is higher, which is a sensor held upright.
struct ShutterMotion {
  glm::dvec3 turn{0.0};   // rotation vector, radians
  glm::dvec3 shift{0.0};  // units of the points

  friend bool operator==(const ShutterMotion&, const ShutterMotion&) = default;
};

// Throws std::invalid_argument naming the field, its value and the rule unless all fields are finite.
void check(const ShutterMotion& motion);

// Returns when the line of a pixel is read, [-0.5, 0.5] within the picture.
[[nodiscard]] inline double readout_time(const Camera& camera, const glm::dvec2& image) {
  return (camera.width >= camera.height ? image.y / camera.height : image.x / camera.width) - 0.5;
}

// Returns where a point of the camera frame, z > 0, is in that frame when the line that shows it is read.
[[nodiscard]] glm::dvec3 when_read(const ShutterMotion& motion, const Camera& camera, const glm::dvec3& cam);

// Returns the pixel that shows, in the picture that was read, what a camera at rest would show at `image`, of points at
// the depth 1; pixels. Points that the motion takes behind the camera stay where they are.
[[nodiscard]] glm::dvec2 when_read(const ShutterMotion& motion, const Camera& camera, const glm::dvec2& image);

// Returns the largest distance by which the motion moves the middle of an edge or a corner, pixels, of points at
// the depth 1.
[[nodiscard]] double edge_move_px(const ShutterMotion& motion, const Camera& camera);

}  // namespace lumatlas
