// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/luma_image.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/images/lower_resolution.h"

namespace lumatlas {
namespace {

std::vector<std::uint8_t> lumas(const Photograph& photograph) {
  std::vector<std::uint8_t> result(std::size_t{photograph.width} * photograph.height);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::uint8_t* rgb = &photograph.rgb[3 * i];
    result[i] = static_cast<std::uint8_t>(std::lround(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]));
  }
  return result;
}

LumaImage luma_image(const Photograph& photograph, const Camera& camera) {
  LumaImage result{camera, {}, photograph.valid};
  const std::vector<std::uint8_t> luma = lumas(photograph);
  result.quads.resize(luma.size());
  for (std::size_t y = 0; y < camera.height; ++y) {
    const std::size_t row = y * camera.width;
    const std::size_t below = std::min<std::size_t>(y + 1, camera.height - 1) * camera.width;
    for (std::size_t x = 0; x < camera.width; ++x) {
      const std::size_t right = std::min<std::size_t>(x + 1, camera.width - 1);
      const std::uint32_t a = luma[row + x], b = luma[row + right], c = luma[below + x], d = luma[below + right];
      result.quads[row + x] = a | b << 8U | c << 16U | d << 24U;
    }
  }
  return result;
}

Photograph resized(const Photograph& photograph, const Camera& to) {
  if (photograph.width == to.width && photograph.height == to.height) return photograph;
  return at_lower_resolution(photograph, to.width, to.height);
}

}  // namespace

LumaPyramid luma_pyramid(const Photograph& photograph, const Camera& camera, std::uint32_t longest,
                         std::uint32_t shortest) {
  if (shortest == 0 || shortest > longest) {
    throw std::invalid_argument("luma pyramid: the last size is " + std::to_string(shortest) + ", must be in [1, " +
                                std::to_string(longest) + "]");
  }
  if (photograph.width != camera.width || photograph.height != camera.height) {
    throw std::invalid_argument("luma pyramid: the photograph does not have its camera's size");
  }
  Camera size = camera.shrunk_to(longest);
  Photograph level = resized(photograph, size);
  LumaPyramid pyramid{luma_image(level, size)};
  while (std::max(size.width, size.height) > shortest) {
    size = size.scaled_to((size.width + 1) / 2, (size.height + 1) / 2);
    level = resized(level, size);
    pyramid.push_back(luma_image(level, size));
  }
  return pyramid;
}

}  // namespace lumatlas
