// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to fusion: what a depth image adds to the voxels of a block.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

#include "tools/meshing/depth/fusion_blocks.h"

namespace lumatlas {

// Voxels behind a surface that are needed to cut it out: a diagonal, and something for noise.
inline constexpr double kVoxelsBehind = 2.5;

// Finds what one image adds to the voxels of blocks.
class BlockUpdate {
 public:
  BlockUpdate(const DepthImage& image, const FusionOptions& options)
      : image_(image), camera_(image.camera), options_(options) {}

  // Calls add(index_in_block, weight, distance) for each voxel that the image says something of: the weight is above 0,
  // and the distance, in units of the truncation, in [-1, 1].
  template <typename Add>
  void visit(const glm::ivec3& block, const Add& add) const {
    const double voxel = options_.voxel;
    const glm::dvec3 corner = camera_.cam_from_world(kBlockSide * voxel * glm::dvec3(block));
    const glm::dmat3 axes = voxel * camera_.cam_from_world_rotation;
    if (is_out_of_view(corner + 0.5 * kBlockSide * (axes * glm::dvec3(1)), 0.5 * std::sqrt(3.0) * kBlockSide * voxel))
      return;
    glm::ivec3 v;
    for (v.z = 0; v.z < kBlockSide; ++v.z) {
      for (v.y = 0; v.y < kBlockSide; ++v.y) {
        for (v.x = 0; v.x < kBlockSide; ++v.x) add_at(corner + axes * glm::dvec3(v), index_in_block(v), add);
      }
    }
  }

 private:
  // Returns whether a ball in the camera frame is out of view. Balls that reach behind the camera are taken to be in
  // view.
  [[nodiscard]] bool is_out_of_view(const glm::dvec3& middle, double radius) const {
    if (middle.z + radius <= 0) return true;
    const double nearest = middle.z - radius;
    if (nearest <= 0) return false;
    const glm::dvec2 at = camera_.image_from_cam(middle);
    // A point of the ball is off its middle by at most this much in the picture: by the radius across, and by as
    // much along a ray whose slope is that of the middle.
    const double slope = 1 + std::hypot(middle.x, middle.y) / middle.z;
    const double margin = std::max(camera_.fx, camera_.fy) * radius / nearest * slope;
    return at.x + margin < 0 || at.y + margin < 0 || at.x - margin > camera_.width || at.y - margin > camera_.height;
  }

  template <typename Add>
  void add_at(const glm::dvec3& cam, std::size_t voxel, const Add& add) const {
    if (cam.z <= 0) return;
    const glm::dvec2 at = camera_.image_from_cam(cam);
    if (!(at.x >= 0 && at.y >= 0 && at.x < camera_.width && at.y < camera_.height)) return;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * camera_.width + static_cast<std::size_t>(at.x);
    double depth = image_.depth[pixel];
    if (depth <= 0) return;
    if (!image_.slope.empty()) depth += glm::dot(glm::dvec2(image_.slope[pixel]), at - (glm::floor(at) + 0.5));
    if (depth <= 0) return;
    const double cosine = image_.cosine.empty() ? 1.0 : double{image_.cosine[pixel]};
    const double distance = cosine * (depth - cam.z) * glm::length(cam) / cam.z;
    // Along the ray no further than the truncation, or than the eight voxels about a slanted surface need. The space
    // further behind it is unknown.
    if (distance <
        -std::min(options_.truncation, std::max(cosine * options_.truncation, kVoxelsBehind * options_.voxel))) {
      return;
    }
    const double weight = cosine / (depth * depth);
    if (weight > 0) add(voxel, weight, std::clamp(distance / options_.truncation, -1.0, 1.0));
  }

  const DepthImage& image_;
  const Camera& camera_;
  const FusionOptions& options_;
};

}  // namespace lumatlas
