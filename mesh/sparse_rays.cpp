// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sparse_rays.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "mesh/pixel_packets.h"

namespace lumatlas {

namespace {

// By how much the reciprocal of depth, which is linear in the image of a plane, may bend between traced pixels, as a
// share of itself.
constexpr float kMostBend = 1e-3f;

constexpr std::uint32_t kTileSide = 64;  // pixels, of what is traced at once
constexpr std::uint32_t kBlockSide = 8;  // of whose pixels every fourth fill a packet
static_assert(kBlockSide * kBlockSide / 4 == EmbreePacket::kRays);

struct Step {
  std::int64_t x, y;
};
constexpr Step kAcross{1, 0}, kDown{0, 1};

class SparseRays {
 public:
  SparseRays(const Camera& camera, RTCScene scene, VisibilityBuffer& buffer)
      : camera_(camera), scene_(scene), buffer_(buffer), width_(camera.width), height_(camera.height) {}

  // Each step needs what the one before has found in the tiles around.
  void trace() {
    each_tile([](std::uint32_t x, std::uint32_t y) { return x % 2 == 0 && y % 2 == 0; });
    each_tile([this](std::uint32_t x, std::uint32_t y) {
      return x % 2 != y % 2 && !fill(x, y, y % 2 == 0 ? kAcross : kDown);
    });
    each_tile([this](std::uint32_t x, std::uint32_t y) { return x % 2 == 1 && y % 2 == 1 && !fill(x, y, kAcross); });
  }

 private:
  // Traces the pixels for which `wanted` says so, block by block.
  template <typename Wanted>
  void each_tile(const Wanted& wanted) {
    const std::uint32_t columns = (camera_.width + kTileSide - 1) / kTileSide;
    const std::uint32_t rows = (camera_.height + kTileSide - 1) / kTileSide;
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, rows, 1, 0, columns, 1),
                      [&](const tbb::blocked_range2d<std::uint32_t>& tiles) {
                        for (std::uint32_t row = tiles.rows().begin(); row != tiles.rows().end(); ++row) {
                          for (std::uint32_t column = tiles.cols().begin(); column != tiles.cols().end(); ++column) {
                            trace_tile(column * kTileSide, row * kTileSide, wanted);
                          }
                        }
                      });
  }

  template <typename Wanted>
  void trace_tile(std::uint32_t left, std::uint32_t top, const Wanted& wanted) {
    PixelPackets packets(camera_, scene_, buffer_);
    const std::uint32_t right = std::min(left + kTileSide, camera_.width);
    const std::uint32_t bottom = std::min(top + kTileSide, camera_.height);
    for (std::uint32_t block_top = top; block_top < bottom; block_top += kBlockSide) {
      for (std::uint32_t block_left = left; block_left < right; block_left += kBlockSide) {
        for (std::uint32_t y = block_top; y < std::min(block_top + kBlockSide, bottom); ++y) {
          for (std::uint32_t x = block_left; x < std::min(block_left + kBlockSide, right); ++x) {
            if (wanted(x, y)) packets.add(x, y);
          }
        }
      }
    }
    packets.finish();
  }

  [[nodiscard]] std::size_t pixel(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(y * width_ + x);
  }
  [[nodiscard]] bool is_inside(std::int64_t x, std::int64_t y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }

  // From the pixels beside it, if the surface is smooth there, as those beyond them tell; or if none of them sees any.
  bool fill(std::int64_t x, std::int64_t y, const Step& step) {
    if (!is_inside(x + step.x, y + step.y)) return false;
    const std::size_t before = pixel(x - step.x, y - step.y);
    const float a = 1 / buffer_.depth[before];
    const float b = 1 / buffer_.depth[pixel(x + step.x, y + step.y)];
    if (!is_smooth(a, b, x - 3 * step.x, y - 3 * step.y) || !is_smooth(b, a, x + 3 * step.x, y + 3 * step.y)) {
      return false;
    }
    const std::size_t here = pixel(x, y);
    buffer_.depth[here] = a > 0 ? 2 / (a + b) : std::numeric_limits<float>::infinity();
    buffer_.face[here] = buffer_.face[before];
    return true;
  }

  // Of the reciprocals of depth at three pixels in a row, the last one at a place that may be outside of the image. Not
  // where one of them is no number or only one sees a surface.
  [[nodiscard]] bool is_smooth(float middle, float before, std::int64_t x, std::int64_t y) const {
    if ((middle > 0) != (before > 0)) return false;
    if (!is_inside(x, y)) return std::abs(middle - before) <= kMostBend * middle;
    const float beyond = 1 / buffer_.depth[pixel(x, y)];
    return (beyond > 0) == (middle > 0) && std::abs(before - 2 * middle + beyond) <= kMostBend * middle;
  }

  const Camera& camera_;
  RTCScene scene_;
  VisibilityBuffer& buffer_;
  std::int64_t width_, height_;
};

}  // namespace

void trace_sparsely(const Camera& camera, RTCScene scene, VisibilityBuffer& buffer) {
  SparseRays(camera, scene, buffer).trace();
}

}  // namespace lumatlas
