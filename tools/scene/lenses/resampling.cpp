// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/lenses/resampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lumatlas {

namespace {

// The four pixels round a place of the photograph, and their weights in 1/65536.
struct Footprint {
  std::array<std::ptrdiff_t, 4> corners;
  std::array<std::uint32_t, 4> weights;
};

Footprint footprint(std::int32_t width, std::int32_t height, const glm::dvec2& place, AtEdges columns) {
  const bool wraps = columns == AtEdges::wrap;
  const double x = std::clamp(place.x - 0.5, wraps ? -0.5 : 0.0, wraps ? width - 0.5 : width - 1.0);
  const double y = std::clamp(place.y - 0.5, 0.0, height - 1.0);
  const auto left = static_cast<std::int32_t>(std::floor(x));
  const auto y0 = static_cast<std::int32_t>(y);
  const std::int32_t x0 = left < 0 ? width - 1 : left;
  const std::ptrdiff_t past_the_last = wraps ? 1 - width : 0;
  const std::ptrdiff_t right = x0 + 1 < width ? 1 : past_the_last;
  const std::ptrdiff_t below = y0 + 1 < height ? width : 0;
  const std::ptrdiff_t corner = std::ptrdiff_t{y0} * width + x0;
  const auto u = static_cast<std::uint32_t>(static_cast<std::int32_t>((x - left) * 256 + 0.5));
  const auto v = static_cast<std::uint32_t>(static_cast<std::int32_t>((y - y0) * 256 + 0.5));
  return {{corner, corner + right, corner + below, corner + below + right},
          {(256 - u) * (256 - v), u * (256 - v), (256 - u) * v, u * v}};
}

bool is_masked(const Photograph& photograph, const Footprint& f) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (f.weights[i] > 0 && photograph.valid[static_cast<std::size_t>(f.corners[i])] == 0) return true;
  }
  return false;
}

}  // namespace

bool resample(const Photograph& photograph, const glm::dvec2& place, AtEdges columns, std::uint8_t* rgb) {
  const Footprint f = footprint(static_cast<std::int32_t>(photograph.width),
                                static_cast<std::int32_t>(photograph.height), place, columns);
  if (!photograph.valid.empty() && is_masked(photograph, f)) return false;
  const std::uint8_t* const pixels = photograph.rgb.data();
  for (std::ptrdiff_t channel = 0; channel < 3; ++channel) {
    std::uint32_t sum = 1u << 15;  // rounds
    for (std::size_t i = 0; i < 4; ++i) sum += f.weights[i] * pixels[3 * f.corners[i] + channel];
    rgb[channel] = static_cast<std::uint8_t>(sum >> 16);
  }
  return true;
}

}  // namespace lumatlas
