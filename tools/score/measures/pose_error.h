// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the errors of cameras against the true ones, in pixels of what they see.
//
// If only the given poses tie the cameras to the mesh, refinement may move them all together, which no picture shows.
// So errors are also measured after the one rigid motion of the world that brings the whole set closest to the truth.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Points of the surface that the camera sees, spread evenly over its picture: 32 along its longer side.
[[nodiscard]] std::vector<glm::dvec3> points_seen(const Camera& camera, const Visibility& visibility);

// x -> rotation x + translation.
struct RigidMotion {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
};

// The camera that sees at x what `camera` sees at motion(x).
[[nodiscard]] Camera before_motion(const Camera& camera, const RigidMotion& motion);

struct PosePair {
  Camera truth;
  Camera measured;                 // with the same size and intrinsics
  std::vector<glm::dvec3> points;  // that `truth` sees
};

// Returns the motion whose before_motion() brings the measured cameras closest to the true ones: with the least sum of
// the distances, in pixels, between the points' images in both. Distances, not their squares, so that a few lost
// cameras do not drag the others along. No motion without points, or where the points leave it open.
[[nodiscard]] RigidMotion common_motion(std::span<const PosePair> pairs);

}  // namespace lumatlas
