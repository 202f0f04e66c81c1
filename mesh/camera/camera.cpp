// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "mesh/base/requirement.h"

namespace lumatlas {

glm::dvec3 Camera::center() const {
  return -(glm::transpose(cam_from_world_rotation) * cam_from_world_translation);
}

glm::dvec3 Camera::viewing_direction() const {
  return glm::transpose(cam_from_world_rotation) * glm::dvec3(0, 0, 1);
}

glm::dvec3 Camera::cam_from_world(const glm::dvec3& world) const {
  return cam_from_world_rotation * world + cam_from_world_translation;
}

glm::dvec3 Camera::ray(const glm::dvec2& image) const {
  return glm::transpose(cam_from_world_rotation) * glm::dvec3((image.x - cx) / fx, (image.y - cy) / fy, 1.0);
}

Camera centered_camera(std::uint32_t width, std::uint32_t height, double focal_length) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_length;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

namespace {

constexpr Requirement camera_requires{"camera"};

void require_some(const char* field, std::uint32_t pixels) {
  camera_requires(pixels > 0, field, pixels, "above 0");
}

}  // namespace

Camera Camera::scaled_to(std::uint32_t new_width, std::uint32_t new_height) const {
  require_some("width", width);
  require_some("height", height);
  require_some("the new width", new_width);
  require_some("the new height", new_height);
  const double sx = static_cast<double>(new_width) / width;
  const double sy = static_cast<double>(new_height) / height;
  Camera scaled = *this;
  scaled.width = new_width;
  scaled.height = new_height;
  scaled.fx *= sx;
  scaled.cx *= sx;
  scaled.fy *= sy;
  scaled.cy *= sy;
  return scaled;
}

Camera Camera::shrunk_to(std::uint32_t pixels) const {
  require_some("width", width);
  require_some("height", height);
  require_some("the new longer side", pixels);
  const double scale = std::min(1.0, static_cast<double>(pixels) / std::max(width, height));
  const auto shrunk = [scale](std::uint32_t size) {
    return std::max(1u, static_cast<std::uint32_t>(std::lround(size * scale)));
  };
  return scaled_to(shrunk(width), shrunk(height));
}

void check(const Camera& camera) {
  constexpr std::uint32_t kMaxSize = 65536;
  camera_requires(camera.width >= 1 && camera.width <= kMaxSize, "width", camera.width, "in [1, 65536]");
  camera_requires(camera.height >= 1 && camera.height <= kMaxSize, "height", camera.height, "in [1, 65536]");
  camera_requires(std::isfinite(camera.fx) && camera.fx > 0, "fx", camera.fx, "finite and positive");
  camera_requires(std::isfinite(camera.fy) && camera.fy > 0, "fy", camera.fy, "finite and positive");
  camera_requires(std::isfinite(camera.cx), "cx", camera.cx, "finite");
  camera_requires(std::isfinite(camera.cy), "cy", camera.cy, "finite");
  const glm::dmat3 product = glm::transpose(camera.cam_from_world_rotation) * camera.cam_from_world_rotation;
  for (int column = 0; column < 3; ++column) {
    const double t = camera.cam_from_world_translation[column];
    camera_requires(std::isfinite(t), "translation", t, "finite");
    for (int row = 0; row < 3; ++row) {
      const double expected = row == column ? 1.0 : 0.0;
      camera_requires(std::abs(product[column][row] - expected) < 1e-6, "rotation", product[column][row],
                      "orthonormal");
    }
  }
  const double determinant = glm::determinant(camera.cam_from_world_rotation);
  camera_requires(determinant > 0, "rotation's determinant", determinant, "positive");
}

}  // namespace lumatlas
