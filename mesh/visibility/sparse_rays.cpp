// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/sparse_rays.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mesh/visibility/pixel_packets.h"

namespace lumatlas {

namespace {

// The most that the reciprocal of depth, linear in the image of a plane, may bend between traced pixels, as a share
// of itself.
constexpr float kMostBend = 1e-3f;

constexpr std::uint32_t kSquareSide = kRaySquareSide;
constexpr std::uint32_t kBlockSide = 8;  // every fourth of its pixels fill a packet
static_assert(kBlockSide * kBlockSide / 4 == EmbreePacket::kRays);

struct Step {
  std::int64_t x, y;
};
constexpr Step kAcross{1, 0}, kDown{0, 1};

// Squares of a window that are traced at once, row by row.
struct Squares {
  std::uint32_t columns, rows;

  explicit Squares(const PixelRect& window)
      : columns((window.width + kSquareSide - 1) / kSquareSide),
        rows((window.height + kSquareSide - 1) / kSquareSide) {}
  [[nodiscard]] std::size_t number(std::uint32_t column, std::uint32_t row) const {
    return std::size_t{row} * columns + column;
  }
};

// Returns for each square the distance in squares to the nearest one that has a wanted pixel; 3 for all that are
// farther.
std::vector<std::uint8_t> squares_away(const Squares& squares, std::uint32_t width,
                                       std::span<const std::uint8_t> wanted) {
  std::vector<std::uint8_t> has_wanted(std::size_t{squares.columns} * squares.rows, wanted.empty() ? 1 : 0);
  for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) {
    if (wanted[pixel] == 0) continue;
    const auto x = static_cast<std::uint32_t>(pixel % width);
    const auto y = static_cast<std::uint32_t>(pixel / width);
    has_wanted[squares.number(x / kSquareSide, y / kSquareSide)] = 1;
  }
  const auto distance = [](std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; };
  std::vector<std::uint8_t> away(has_wanted.size(), 3);
  for (std::uint32_t row = 0; row < squares.rows; ++row) {
    for (std::uint32_t column = 0; column < squares.columns; ++column) {
      std::uint8_t& nearest = away[squares.number(column, row)];
      for (std::uint32_t y = row - std::min(row, 2u); y <= row + 2 && y < squares.rows; ++y) {
        for (std::uint32_t x = column - std::min(column, 2u); x <= column + 2 && x < squares.columns; ++x) {
          if (has_wanted[squares.number(x, y)] == 0) continue;
          nearest = std::min(nearest, static_cast<std::uint8_t>(std::max(distance(x, column), distance(y, row))));
        }
      }
    }
  }
  return away;
}

class SparseRays {
 public:
  SparseRays(const Camera& camera, const PixelRect& window, const TracedMesh& mesh,
             std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer)
      : camera_(camera),
        window_(window),
        mesh_(mesh),
        buffer_(buffer),
        width_(window.width),
        height_(window.height),
        squares_(window),
        away_(squares_away(squares_, window.width, wanted)) {}

  // Each step needs what the one before has found up to three pixels away, so in the squares around.
  void trace() {
    each_square(2, [](std::uint32_t x, std::uint32_t y) { return x % 2 == 0 && y % 2 == 0; });
    each_square(1, [this](std::uint32_t x, std::uint32_t y) {
      return x % 2 != y % 2 && !fill(x, y, y % 2 == 0 ? kAcross : kDown);
    });
    each_square(0,
                [this](std::uint32_t x, std::uint32_t y) { return x % 2 == 1 && y % 2 == 1 && !fill(x, y, kAcross); });
  }

 private:
  // Traces the pixels for which `takes` says so, of the squares that are at most so far away from one with a wanted
  // pixel.
  template <typename Takes>
  void each_square(std::uint8_t most_away, const Takes& takes) {
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, squares_.rows, 1, 0, squares_.columns, 1),
                      [&](const tbb::blocked_range2d<std::uint32_t>& block) {
                        for (std::uint32_t row = block.rows().begin(); row != block.rows().end(); ++row) {
                          for (std::uint32_t column = block.cols().begin(); column != block.cols().end(); ++column) {
                            if (away_[squares_.number(column, row)] > most_away) continue;
                            trace_square(column * kSquareSide, row * kSquareSide, takes);
                          }
                        }
                      });
  }

  // Block by block, so that rays of a packet are near each other.
  template <typename Takes>
  void trace_square(std::uint32_t left, std::uint32_t top, const Takes& takes) {
    PixelPackets packets(camera_, window_.x, window_.y, mesh_, buffer_);
    const std::uint32_t right = std::min(left + kSquareSide, window_.width);
    const std::uint32_t bottom = std::min(top + kSquareSide, window_.height);
    for (std::uint32_t block_top = top; block_top < bottom; block_top += kBlockSide) {
      for (std::uint32_t block_left = left; block_left < right; block_left += kBlockSide) {
        for (std::uint32_t y = block_top; y < std::min(block_top + kBlockSide, bottom); ++y) {
          for (std::uint32_t x = block_left; x < std::min(block_left + kBlockSide, right); ++x) {
            if (takes(x, y)) packets.add(x, y);
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

  // Returns whether the reciprocals of depth at three pixels in a row lie on a line. The last pixel is at a place that
  // may be outside the image. False if one of them is no number or only one sees a surface.
  [[nodiscard]] bool is_smooth(float middle, float before, std::int64_t x, std::int64_t y) const {
    if ((middle > 0) != (before > 0)) return false;
    if (!is_inside(x, y)) return std::abs(middle - before) <= kMostBend * middle;
    const float beyond = 1 / buffer_.depth[pixel(x, y)];
    return (beyond > 0) == (middle > 0) && std::abs(before - 2 * middle + beyond) <= kMostBend * middle;
  }

  const Camera& camera_;
  PixelRect window_;
  TracedMesh mesh_;
  VisibilityBuffer& buffer_;
  std::int64_t width_, height_;
  Squares squares_;
  std::vector<std::uint8_t> away_;  // one per square
};

}  // namespace

void trace_sparsely(const Camera& camera, const PixelRect& window, const TracedMesh& mesh,
                    std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  if (!wanted.empty()) {
    std::fill(buffer.depth.begin(), buffer.depth.end(), kNothing);
    std::fill(buffer.face.begin(), buffer.face.end(), FaceId::none);
  }
  SparseRays(camera, window, mesh, wanted, buffer).trace();
  for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) {
    if (wanted[pixel] != 0) continue;
    buffer.depth[pixel] = kNothing;
    buffer.face[pixel] = FaceId::none;
  }
}

}  // namespace lumatlas
