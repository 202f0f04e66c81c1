// SPDX-License-Identifier: GPL-3.0-or-later
// A pinhole camera. The home of the project's frames:
//
//   World: right-handed, arbitrary units, the scene's offset already subtracted.
//   Camera: x right, y down, z forward. Depth is z in this frame, everywhere.
//   Image: pixel (0,0) is the top left *corner*; the centre of the first pixel is at (0.5, 0.5).
//   Transforms name their target first: cam_from_world.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace lumatlas {

struct Camera {
  std::uint32_t width = 0;   // pixels
  std::uint32_t height = 0;  // pixels
  double fx = 0, fy = 0;     // focal lengths, pixels, > 0
  double cx = 0, cy = 0;     // principal point, pixels from the top left corner

  glm::dmat3 cam_from_world_rotation{1.0};     // orthonormal, determinant 1
  glm::dvec3 cam_from_world_translation{0.0};  // scene units

  [[nodiscard]] glm::dvec3 center() const;             // in the world
  [[nodiscard]] glm::dvec3 viewing_direction() const;  // unit, in the world: the camera's z axis
  [[nodiscard]] glm::dvec3 cam_from_world(const glm::dvec3& world) const;

  // Image position of a point in the camera frame; meaningful for z > 0 only.
  [[nodiscard]] glm::dvec2 image_from_cam(const glm::dvec3& cam) const {
    return {fx * cam.x / cam.z + cx, fy * cam.y / cam.z + cy};
  }
  // Direction in the world, with z = 1 in the camera frame (not unit), of the ray through an image position:
  // center() + depth * ray(p) has that depth.
  [[nodiscard]] glm::dvec3 ray(const glm::dvec2& image) const;

  // Returns the same view at another resolution; a pixel keeps its position relative to the image. Both functions throw
  // std::invalid_argument if one of the sizes, the camera's own among them, is 0.
  [[nodiscard]] Camera scaled_to(std::uint32_t new_width, std::uint32_t new_height) const;
  // Returns the same view with its longer side `pixels` long, its shape kept to the nearest pixel; never enlarged.
  [[nodiscard]] Camera shrunk_to(std::uint32_t pixels) const;
};

// Returns a camera at the origin that looks along +z, with square pixels and its principal point in the middle of the
// image. Sizes and focal length are in pixels; nothing is checked.
[[nodiscard]] Camera centered_camera(std::uint32_t width, std::uint32_t height, double focal_length);

// Throws std::invalid_argument naming the field, its value and the rule: sizes in [1, 65536], focal lengths finite and
// positive, everything finite, the rotation orthonormal within 1e-6.
void check(const Camera& camera);

}  // namespace lumatlas
