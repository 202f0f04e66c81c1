// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/views/depth_blocks.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <vector>

#include "mesh/base/median.h"

namespace lumatlas {

namespace {

constexpr double kFits = 0.002;  // share of a depth: a tenth of the distance that a point may lie behind it and be seen
constexpr int kRefinements = 2;  // passes that choose a plane for each pixel
constexpr std::uint32_t kPixels = kDepthBlockSide * kDepthBlockSide;
constexpr std::uint16_t kSign = 0x8000;

// From the block's middle, pixels.
glm::dvec2 place_of(std::uint32_t number) {
  const double middle = (kDepthBlockSide - 1) / 2.0;
  return glm::dvec2(number % kDepthBlockSide, number / kDepthBlockSide) - middle;
}

// The bit of a pixel in two words from `first` on.
bool bit_of(const DepthBlock& block, std::uint32_t first, std::uint32_t number) {
  return (block[first + number / 32] >> (number % 32) & 1u) != 0;
}

// The bit of the 2 x 2 pixels that a pixel is one of.
std::uint32_t quad_bit(std::uint32_t number) {
  return number / (2 * kDepthBlockSide) * 4 + number % kDepthBlockSide / 2;
}

struct Pixel {
  double reciprocal = 0;  // 1 / depth as a share of the scale; 0: no surface
  bool kept = false;      // may be asked for
  bool at_rim = false;
  std::uint32_t plane = 0;
};
using Pixels = std::array<Pixel, kPixels>;

// Reciprocal of depth: middle[plane] (1 + slope . place).
struct Planes {
  std::array<double, 2> middle{};
  glm::dvec2 slope{0};
  double error = std::numeric_limits<double>::infinity();  // the largest, of a depth

  [[nodiscard]] double at(std::uint32_t plane, const glm::dvec2& place) const {
    return middle[plane] * (1 + glm::dot(slope, place));
  }
};

bool may_be_asked(const StoredView& view, std::uint32_t x, std::uint32_t y) {
  const std::uint32_t last_x = std::min(x + 1, view.camera.width - 1), last_y = std::min(y + 1, view.camera.height - 1);
  for (std::uint32_t row = y - std::min(y, 1u); row <= last_y; ++row) {
    for (std::uint32_t column = x - std::min(x, 1u); column <= last_x; ++column) {
      if (view.mask->validity[std::size_t{row} * view.camera.width + column] != 0) return true;
    }
  }
  return false;
}

// Returns whether all pixels of the block whose first pixel is (x, y), and those next to it, are wholly valid.
bool is_whole(const StoredView& view, std::uint32_t x, std::uint32_t y) {
  constexpr std::uint8_t kWhollyValid = 255;
  const std::uint32_t end_x = std::min(x + kDepthBlockSide + 1, view.camera.width);
  const std::uint32_t end_y = std::min(y + kDepthBlockSide + 1, view.camera.height);
  for (std::uint32_t row = y - std::min(y, 1u); row < end_y; ++row) {
    for (std::uint32_t column = x - std::min(x, 1u); column < end_x; ++column) {
      if (view.mask->validity[std::size_t{row} * view.camera.width + column] != kWhollyValid) return false;
    }
  }
  return true;
}

Pixels pixels_of(const StoredView& view, std::uint32_t x, std::uint32_t y, double scale) {
  Pixels pixels;
  bool any = false;
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    const std::uint32_t column = x + number % kDepthBlockSide, row = y + number / kDepthBlockSide;
    if (column >= view.camera.width || row >= view.camera.height) continue;
    const std::size_t at = std::size_t{row} * view.camera.width + column;
    const auto depth = static_cast<double>(view.mask->depth[at]);
    if (!(depth > 0) || !std::isfinite(depth)) continue;
    pixels[number] = {scale / depth, may_be_asked(view, column, row), view.mask->at_rim(at), 0};
    any = any || pixels[number].kept;
  }
  if (any) return pixels;
  for (Pixel& pixel : pixels) pixel.kept = pixel.reciprocal > 0;
  return pixels;
}

double error_of(const Planes& planes, const Pixels& pixels) {
  double error = 0;
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    const Pixel& pixel = pixels[number];
    if (!pixel.kept) continue;
    error = std::max(error, std::abs(planes.at(pixel.plane, place_of(number)) / pixel.reciprocal - 1));
  }
  return error;
}

// Means over a plane's pixels, weighted so that errors count by their share of the depth.
struct Means {
  double level = 0;   // mean of the reciprocals
  double weight = 0;  // in all
  double value = 0;   // reciprocal as a share of the level
  glm::dvec2 place{0};
};

// Calls f(plane, weight, value, place) for each pixel that is kept.
template <typename F>
void for_each_kept(const Pixels& pixels, const std::array<Means, 2>& means, const F& f) {
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    const Pixel& pixel = pixels[number];
    if (!pixel.kept) continue;
    const double value = pixel.reciprocal / means[pixel.plane].level;
    f(pixel.plane, 1 / (value * value), value, place_of(number));
  }
}

std::array<Means, 2> means_of(const Pixels& pixels) {
  std::array<Means, 2> means;
  std::array<double, 2> count{};
  for (const Pixel& pixel : pixels) {
    if (!pixel.kept) continue;
    means[pixel.plane].level += pixel.reciprocal;
    ++count[pixel.plane];
  }
  for (std::size_t plane = 0; plane < 2; ++plane) means[plane].level /= std::max(count[plane], 1.0);
  for_each_kept(pixels, means, [&](std::uint32_t plane, double weight, double value, const glm::dvec2& place) {
    means[plane].weight += weight;
    means[plane].value += weight * value;
    means[plane].place += weight * place;
  });
  for (Means& of_plane : means) {
    if (!(of_plane.weight > 0)) continue;
    of_plane.value /= of_plane.weight;
    of_plane.place /= of_plane.weight;
  }
  return means;
}

// That all planes have in common.
glm::dvec2 slope_of(const Pixels& pixels, const std::array<Means, 2>& means) {
  constexpr double kRidge = 1e-6;  // pixels in a line get no slope across it
  glm::dmat2 spread(kRidge);
  glm::dvec2 along(0);
  for_each_kept(pixels, means, [&](std::uint32_t plane, double weight, double value, const glm::dvec2& place) {
    const glm::dvec2 apart = place - means[plane].place;
    spread += weight * glm::outerProduct(apart, apart);
    along += weight * (value - means[plane].value) * apart;
  });
  return glm::inverse(spread) * along;
}

// Least squares. Each plane has a middle of its own; all have their slope in common, as a share of it, which is so
// where surfaces are parallel.
Planes fitted(const Pixels& pixels) {
  const std::array<Means, 2> means = means_of(pixels);
  const glm::dvec2 slope = slope_of(pixels, means);
  Planes planes;
  double sum = 0, weight = 0;  // sums over middles as shares of their levels, which are near 1
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const double share = means[plane].value - glm::dot(slope, means[plane].place);
    planes.middle[plane] = means[plane].level * share;
    sum += means[plane].weight * share;
    weight += means[plane].weight;
  }
  const glm::dvec2 most(kMostDepthSlope);
  if (sum > 0) planes.slope = glm::clamp(slope * weight / sum, -most, most);
  planes.error = error_of(planes, pixels);
  return planes;
}

// Apart at the middle between the nearest and the farthest. False: they are equally near.
bool split_at_middle(Pixels& pixels) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const Pixel& pixel : pixels) {
    if (!pixel.kept) continue;
    least = std::min(least, pixel.reciprocal);
    most = std::max(most, pixel.reciprocal);
  }
  for (Pixel& pixel : pixels) pixel.plane = pixel.reciprocal * pixel.reciprocal < least * most ? 1 : 0;
  return least < most;
}

// Each pixel to the plane that is nearer to it; what no surface is, to the farther. False: one of them has none.
bool assign(const Planes& planes, Pixels& pixels) {
  std::array<std::uint32_t, 2> count{};
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    Pixel& pixel = pixels[number];
    const glm::dvec2 place = place_of(number);
    const double first = std::abs(planes.at(0, place) - pixel.reciprocal);
    pixel.plane = std::abs(planes.at(1, place) - pixel.reciprocal) < first ? 1 : 0;
    if (pixel.kept) ++count[pixel.plane];
  }
  return count[0] > 0 && count[1] > 0;
}

Planes two_planes(Pixels& pixels) {
  if (!split_at_middle(pixels)) return {};
  Planes best = fitted(pixels);
  Pixels of_best = pixels;
  for (int i = 0; i < kRefinements; ++i) {
    Pixels others = of_best;
    if (!assign(best, others)) break;
    const Planes next = fitted(others);
    if (!(next.error < best.error)) break;
    best = next;
    of_best = others;
  }
  pixels = of_best;
  return best;
}

// The half below, so that what the view shows is not found behind itself; of 0 at least.
std::uint32_t half_below(double value) {
  const float wanted = std::clamp(static_cast<float>(value), 0.f, 65504.f);
  const std::uint16_t half = glm::packHalf1x16(wanted);
  return glm::unpackHalf1x16(half) > wanted ? half - 1u : half;
}

// Lower by what the plane exceeds a pixel by, so that no pixel is found behind itself.
std::uint32_t lowered_middle(const Planes& planes, std::uint32_t plane, const Pixels& pixels) {
  constexpr double kRounding = 1 + 1e-6;  // rounding of the shader
  double over = 1;
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    const Pixel& pixel = pixels[number];
    if (!pixel.kept || pixel.plane != plane) continue;
    over = std::max(over, planes.at(plane, place_of(number)) / pixel.reciprocal);
  }
  return half_below(planes.middle[plane] / (over * kRounding));
}

DepthBlock packed(Planes planes, const Pixels& pixels) {
  DepthBlock block{};
  const glm::vec2 share(planes.slope / kMostDepthSlope);
  block[1] = glm::packSnorm2x16(share);
  planes.slope = glm::dvec2(glm::unpackSnorm2x16(block[1])) * kMostDepthSlope;
  block[0] = lowered_middle(planes, 0, pixels);
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    if (pixels[number].at_rim) block[2 + number / 32] |= 1u << number % 32;
  }
  return block;
}

glm::dvec2 squared_with_sign(const glm::dvec2& root) {
  return root * glm::abs(root);
}

DepthBlock packed_pair(Planes planes, const Pixels& pixels) {
  DepthBlock block{};
  const glm::dvec2 share = planes.slope / kMostDepthSlope;
  const glm::vec2 root(glm::sign(share) * glm::sqrt(glm::abs(share)));
  const std::uint32_t slopes = glm::packSnorm4x8({root.x, root.y, 0, 0});
  planes.slope = squared_with_sign(glm::dvec2(glm::unpackSnorm4x8(slopes))) * kMostDepthSlope;
  block[0] = lowered_middle(planes, 0, pixels) | kSign | lowered_middle(planes, 1, pixels) << 16;
  block[1] = slopes & 0xFFFFu;
  for (std::uint32_t number = 0; number < kPixels; ++number) {
    const Pixel& pixel = pixels[number];
    if (pixel.at_rim) block[1] |= 1u << (16 + quad_bit(number));
    if (pixel.plane == 1) block[2 + number / 32] |= 1u << number % 32;
  }
  return block;
}

DepthBlock block_of(const Pixels& pixels) {
  const Planes one = fitted(pixels);
  if (one.error <= kFits) return packed(one, pixels);
  Pixels parted = pixels;
  const Planes two = two_planes(parted);
  if (!(two.error < one.error)) return packed(one, pixels);
  assign(two, parted);
  return packed_pair(two, parted);
}

}  // namespace

float depth_scale(const StoredView& view) {
  // Near the smallest, for the far sphere may be most of what a view sees: halves hold shares from 2^-24 to 2^16.
  constexpr double kShare = 0.05;
  constexpr std::size_t kStride = 16;
  std::vector<double> depths;
  std::size_t finite = 0;
  view.mask->depth.for_each([&](std::size_t, float each) {
    if (std::isfinite(each) && each > 0 && finite++ % kStride == 0) depths.push_back(static_cast<double>(each));
  });
  const float depth = depths.empty() ? 0 : static_cast<float>(percentile(depths, kShare));
  return depth > 0 ? std::exp2(std::floor(std::log2(depth))) : 1;
}

DepthBlock depth_block(const StoredView& view, std::uint32_t x, std::uint32_t y, float scale) {
  const Pixels pixels = pixels_of(view, x, y, static_cast<double>(scale));
  if (std::none_of(pixels.begin(), pixels.end(), [](const Pixel& pixel) { return pixel.kept; })) return {};
  DepthBlock block = block_of(pixels);
  if (is_whole(view, x, y)) block[0] |= kWholeBit;
  return block;
}

BlockPixel decoded(const DepthBlock& block, std::uint32_t number, float scale) {
  const bool pair = (block[0] & kSign) != 0;
  const bool farther = pair && bit_of(block, 2, number);
  const auto half = static_cast<std::uint16_t>((farther ? block[0] >> 16 : block[0]) & 0x7FFFu);
  const glm::dvec2 slope =
      pair ? squared_with_sign(glm::dvec2(glm::unpackSnorm4x8(block[1]))) : glm::dvec2(glm::unpackSnorm2x16(block[1]));
  const auto middle = static_cast<double>(glm::unpackHalf1x16(half));
  BlockPixel pixel;
  pixel.reciprocal = middle * (1 + kMostDepthSlope * glm::dot(slope, place_of(number))) / static_cast<double>(scale);
  pixel.at_rim = pair ? (block[1] >> (16 + quad_bit(number)) & 1u) != 0 : bit_of(block, 2, number);
  return pixel;
}

std::vector<BlockPixel> shown_depths(const StoredView& view) {
  const std::uint32_t width = view.camera.width, height = view.camera.height;
  const float scale = depth_scale(view);
  std::vector<BlockPixel> shown(std::size_t{width} * height);
  for (std::uint32_t top = 0; top < height; top += kDepthBlockSide) {
    for (std::uint32_t left = 0; left < width; left += kDepthBlockSide) {
      const DepthBlock block = depth_block(view, left, top, scale);
      for (std::uint32_t number = 0; number < kPixels; ++number) {
        const std::uint32_t x = left + number % kDepthBlockSide, y = top + number / kDepthBlockSide;
        if (x < width && y < height) shown[std::size_t{y} * width + x] = decoded(block, number, scale);
      }
    }
  }
  return shown;
}

}  // namespace lumatlas
