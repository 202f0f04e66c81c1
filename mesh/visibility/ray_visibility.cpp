// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by ray casting: 4x4 packets of coherent primary rays through pixel centres (Embree 3).
#include "mesh/visibility/ray_visibility.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/number_text.h"
#include "mesh/visibility/embree_scene.h"
#include "mesh/visibility/pixel_packets.h"
#include "mesh/visibility/sparse_rays.h"
#include "mesh/visibility/traced_parts.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kPacketSide = 4;
static_assert(kPacketSide * kPacketSide == EmbreePacket::kRays);

// Smaller images take little time, and what is thinner than two of their pixels may be large.
constexpr std::size_t kSparseFromPixels = 1 << 17;

PixelRect whole(const Camera& camera) {
  return {0, 0, camera.width, camera.height};
}

}  // namespace

class RayVisibility::Tree {
 public:
  explicit Tree(const Mesh& mesh) {
    check(mesh);
    if (mesh.faces.empty()) throw std::invalid_argument("ray casting: the mesh has no faces, must have at least one");
    device_ = make_embree_device();
    scene_ = make_embree_scene(device_.get(), mesh, RTC_BUILD_QUALITY_MEDIUM);
    traced_.scene = scene_.get();
  }
  explicit Tree(TracedParts parts) : parts_(std::move(parts)) {
    traced_ = {parts_.scene.get(), parts_.faces, parts_.first};
  }

  // `wanted` as of trace_part(); empty: everything.
  void trace(const Camera& camera, const PixelRect& window, std::span<const std::uint8_t> wanted,
             VisibilityBuffer& buffer) const {
    resize(camera, window, buffer);
    const std::uint32_t columns = (window.width + kPacketSide - 1) / kPacketSide;
    const std::uint32_t rows = (window.height + kPacketSide - 1) / kPacketSide;
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, rows, 4, 0, columns, 16),
                      [&](const tbb::blocked_range2d<std::uint32_t>& block) {
                        PixelPackets packets(camera, window.x, window.y, traced_, buffer);
                        for (std::uint32_t row = block.rows().begin(); row != block.rows().end(); ++row) {
                          for (std::uint32_t column = block.cols().begin(); column != block.cols().end(); ++column) {
                            trace_packet(wanted, column * kPacketSide, row * kPacketSide, packets, buffer);
                          }
                        }
                      });
  }

  void trace_sparsely(const Camera& camera, const PixelRect& window, std::span<const std::uint8_t> wanted,
                      VisibilityBuffer& buffer) const {
    if (whole(camera).pixels() < kSparseFromPixels) return trace(camera, window, wanted, buffer);
    resize(camera, window, buffer);
    lumatlas::trace_sparsely(camera, window, traced_, wanted, buffer);
  }

 private:
  static void resize(const Camera& camera, const PixelRect& window, VisibilityBuffer& buffer) {
    check(camera);
    buffer.width = window.width;
    buffer.height = window.height;
    buffer.depth.resize(window.pixels());
    buffer.face.resize(buffer.depth.size());
  }

  // All rays of a packet or none, for what one of them hits may depend, by rounding, on the others.
  static void trace_packet(std::span<const std::uint8_t> wanted, std::uint32_t left, std::uint32_t top,
                           PixelPackets& packets, VisibilityBuffer& buffer) {
    const std::uint32_t right = std::min(left + kPacketSide, buffer.width);
    const std::uint32_t bottom = std::min(top + kPacketSide, buffer.height);
    const auto each_pixel = [&](const auto& use) {
      for (std::uint32_t y = top; y < bottom; ++y) {
        for (std::uint32_t x = left; x < right; ++x) use(x, y, std::size_t{y} * buffer.width + x);
      }
    };
    bool any_wanted = wanted.empty();
    each_pixel([&](std::uint32_t, std::uint32_t, std::size_t pixel) { any_wanted = any_wanted || wanted[pixel] != 0; });
    if (any_wanted) {
      each_pixel([&](std::uint32_t x, std::uint32_t y, std::size_t) { packets.add(x, y); });
      packets.finish();
    }
    if (wanted.empty()) return;
    each_pixel([&](std::uint32_t, std::uint32_t, std::size_t pixel) {
      if (wanted[pixel] != 0) return;
      buffer.depth[pixel] = std::numeric_limits<float>::infinity();
      buffer.face[pixel] = FaceId::none;
    });
  }

  EmbreeDevice device_;
  EmbreeScene scene_;
  TracedParts parts_;
  TracedMesh traced_;
};

RayVisibility::RayVisibility(const Mesh& mesh) : tree_(std::make_unique<const Tree>(mesh)) {}

RayVisibility::RayVisibility(TracedParts parts) : tree_(std::make_unique<const Tree>(std::move(parts))) {}

RayVisibility::~RayVisibility() = default;

void RayVisibility::trace(const Camera& camera, VisibilityBuffer& buffer) const {
  tree_->trace(camera, whole(camera), {}, buffer);
}

void RayVisibility::trace_wanted(const Camera& camera, std::span<const std::uint8_t> wanted,
                                 VisibilityBuffer& buffer) const {
  require_one_per_pixel(wanted, camera);
  tree_->trace(camera, whole(camera), wanted, buffer);
}

void RayVisibility::trace_sparsely(const Camera& camera, VisibilityBuffer& buffer) const {
  tree_->trace_sparsely(camera, whole(camera), {}, buffer);
}

PixelRect window_for_part(const Camera& camera, const PixelRect& part) {
  static constexpr std::uint32_t kAround = 2 * kRaySquareSide;
  const auto down = [](std::uint32_t from) {
    return (from - std::min<std::uint32_t>(from, kAround)) / kRaySquareSide * kRaySquareSide;
  };
  const auto up = [](std::uint32_t to, std::uint32_t most) {
    const std::uint64_t squares = (std::uint64_t{to} + kRaySquareSide - 1) / kRaySquareSide;
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(squares * kRaySquareSide + kAround, most));
  };
  const std::uint32_t x = down(part.x), y = down(part.y);
  return {x, y, up(part.right(), camera.width) - x, up(part.bottom(), camera.height) - y};
}

void RayVisibility::trace_part(const Camera& camera, const PixelRect& window, std::span<const std::uint8_t> wanted,
                               VisibilityBuffer& buffer) const {
  if (!window.is_within(camera.width, camera.height) || window.x % kRaySquareSide != 0 ||
      window.y % kRaySquareSide != 0) {
    throw std::invalid_argument("ray casting: the window of " + size_text(window.width, window.height) + " at (" +
                                std::to_string(window.x) + ", " + std::to_string(window.y) +
                                ") is none of window_for_part() for " + size_text(camera.width, camera.height));
  }
  if (wanted.size() != window.pixels()) {
    throw std::invalid_argument("ray casting: wanted has " + std::to_string(wanted.size()) +
                                " values, must have one per pixel of " + size_text(window.width, window.height));
  }
  tree_->trace_sparsely(camera, window, wanted, buffer);
}

std::unique_ptr<Visibility> make_ray_visibility(const Mesh& mesh) {
  return std::make_unique<RayVisibility>(mesh);
}

}  // namespace lumatlas
