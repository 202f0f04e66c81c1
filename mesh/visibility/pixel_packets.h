// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: collects pixels, and traces the rays through their centres 16 at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

#include "mesh/camera/camera.h"
#include "mesh/visibility/embree_scene.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// Writes what they see to the buffer, whose first pixel is the camera's pixel at (left, top). What the last ones see is
// written by finish(), which must be called at the end.
class PixelPackets {
 public:
  PixelPackets(const Camera& camera, std::uint32_t left, std::uint32_t top, const TracedMesh& mesh,
               VisibilityBuffer& buffer)
      : camera_(camera),
        left_(left),
        top_(top),
        origin_(camera.center()),
        sees_(is_traceable(origin_)),
        mesh_(mesh),
        buffer_(buffer) {}

  // Takes a pixel of the buffer.
  void add(std::uint32_t x, std::uint32_t y) {
    const std::size_t pixel = std::size_t{y} * buffer_.width + x;
    buffer_.depth[pixel] = std::numeric_limits<float>::infinity();
    buffer_.face[pixel] = FaceId::none;
    // Not unit but one deep, so that the hit's distance along it is its depth.
    const glm::vec3 direction(camera_.ray({left_ + x + 0.5, top_ + y + 0.5}));
    // A ray of a camera at the end of the universe, or with a vanishing focal length, sees nothing.
    if (!sees_ || !is_traceable(direction)) return;
    packet_.set(rays_, origin_, direction, std::numeric_limits<float>::infinity());
    pixels_[rays_] = pixel;
    if (++rays_ == EmbreePacket::kRays) finish();
  }

  void finish() {
    if (rays_ == 0) return;
    packet_.intersect(mesh_.scene);
    for (std::uint32_t i = 0; i < rays_; ++i) {
      if (packet_.hits.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      buffer_.depth[pixels_[i]] = packet_.hits.ray.tfar[i];
      buffer_.face[pixels_[i]] = mesh_.face(packet_.hits.hit.instID[0][i], packet_.hits.hit.primID[i]);
    }
    packet_ = {};
    rays_ = 0;
  }

 private:
  const Camera& camera_;
  std::uint32_t left_, top_;
  glm::vec3 origin_;
  bool sees_;
  TracedMesh mesh_;
  VisibilityBuffer& buffer_;
  EmbreePacket packet_;
  std::size_t pixels_[EmbreePacket::kRays] = {};
  std::uint32_t rays_ = 0;
};

}  // namespace lumatlas
