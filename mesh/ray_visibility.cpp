// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by ray casting: 4x4 packets of coherent primary rays through pixel centres (Embree 3).
#include "mesh/ray_visibility.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"
#include "mesh/embree_scene.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kPacketSide = 4;
static_assert(kPacketSide * kPacketSide == EmbreePacket::kRays);

}  // namespace

class RayVisibility::Tree {
 public:
  explicit Tree(const Mesh& mesh) {
    check(mesh);
    if (mesh.faces.empty()) throw std::invalid_argument("ray casting: the mesh has no faces, must have at least one");
    device_ = make_embree_device();
    scene_ = make_embree_scene(device_.get(), mesh, RTC_BUILD_QUALITY_MEDIUM);
  }

  // `wanted` as of trace_part(); empty: everything.
  void trace(const Camera& camera, std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer) const {
    check(camera);
    buffer.width = camera.width;
    buffer.height = camera.height;
    const std::size_t pixels = std::size_t{camera.width} * camera.height;
    buffer.depth.resize(pixels);
    buffer.face.resize(pixels);
    const std::uint32_t columns = (camera.width + kPacketSide - 1) / kPacketSide;
    const std::uint32_t rows = (camera.height + kPacketSide - 1) / kPacketSide;
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, rows, 4, 0, columns, 16),
                      [&](const tbb::blocked_range2d<std::uint32_t>& block) {
                        for (std::uint32_t row = block.rows().begin(); row != block.rows().end(); ++row) {
                          for (std::uint32_t column = block.cols().begin(); column != block.cols().end(); ++column) {
                            trace_packet(camera, wanted, column * kPacketSide, row * kPacketSide, buffer);
                          }
                        }
                      });
  }

 private:
  void trace_packet(const Camera& camera, std::span<const std::uint8_t> wanted, std::uint32_t left, std::uint32_t top,
                    VisibilityBuffer& buffer) const {
    EmbreePacket packet;
    const glm::vec3 origin(camera.center());
    bool any_wanted = false;
    for (std::uint32_t i = 0; i < EmbreePacket::kRays; ++i) {
      const std::uint32_t x = left + i % kPacketSide;
      const std::uint32_t y = top + i / kPacketSide;
      if (x >= camera.width || y >= camera.height) continue;
      any_wanted = any_wanted || wanted.empty() || wanted[std::size_t{y} * camera.width + x] != 0;
      // Not unit but one deep, so that the hit's distance along it is its depth.
      const glm::vec3 direction(camera.ray({x + 0.5, y + 0.5}));
      // A ray of a camera at the end of the universe, or with a vanishing focal length, sees nothing.
      if (!is_traceable(origin) || !is_traceable(direction)) continue;
      packet.set(i, origin, direction, std::numeric_limits<float>::infinity());
    }
    // All rays of a packet or none, for what one of them hits may depend, by rounding, on the others.
    if (any_wanted) packet.intersect(scene_.get());
    for (std::uint32_t i = 0; i < EmbreePacket::kRays; ++i) {
      const std::uint32_t x = left + i % kPacketSide;
      const std::uint32_t y = top + i / kPacketSide;
      if (x >= camera.width || y >= camera.height) continue;
      const std::size_t pixel = std::size_t{y} * camera.width + x;
      const bool hit = packet.hits.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID && (wanted.empty() || wanted[pixel] != 0);
      buffer.depth[pixel] = hit ? packet.hits.ray.tfar[i] : std::numeric_limits<float>::infinity();
      buffer.face[pixel] = hit ? packet.hits.hit.primID[i] : kNoFace;
    }
  }

  EmbreeDevice device_;
  EmbreeScene scene_;
};

RayVisibility::RayVisibility(const Mesh& mesh) : tree_(std::make_unique<const Tree>(mesh)) {}

RayVisibility::~RayVisibility() = default;

void RayVisibility::trace(const Camera& camera, VisibilityBuffer& buffer) const {
  tree_->trace(camera, {}, buffer);
}

void RayVisibility::trace_part(const Camera& camera, std::span<const std::uint8_t> wanted,
                               VisibilityBuffer& buffer) const {
  if (wanted.size() != std::size_t{camera.width} * camera.height) {
    throw std::invalid_argument("ray casting: wanted has " + std::to_string(wanted.size()) +
                                " values, must have one per pixel of " + size_text(camera.width, camera.height));
  }
  tree_->trace(camera, wanted, buffer);
}

std::unique_ptr<Visibility> make_ray_visibility(const Mesh& mesh) {
  return std::make_unique<RayVisibility>(mesh);
}

}  // namespace lumatlas
