// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/counted_pixels.h"

#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void check_pictures(const Photograph& rendering, const Photograph& photograph) {
  if (rendering.width != photograph.width || rendering.height != photograph.height) {
    throw std::invalid_argument("scores: the rendering is " + size_text(rendering.width, rendering.height) +
                                ", must be " + size_text(photograph.width, photograph.height) + " as the photograph");
  }
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  if (pixels == 0) {
    throw std::invalid_argument("scores: the pictures have no pixels, must have at least one");
  }
  check_entries("the rendering's rgb", rendering.rgb.size(), 3 * pixels);
  check_entries("the photograph's rgb", photograph.rgb.size(), 3 * pixels);
  if (!photograph.valid.empty()) {
    check_entries("the photograph's valid", photograph.valid.size(), pixels);
  }
}

}  // namespace

void check_entries(const char* what, std::size_t size, std::size_t expected) {
  if (size != expected) {
    throw std::invalid_argument(std::string("scores: ") + what + " has " + std::to_string(size) +
                                " entries, must have " + std::to_string(expected));
  }
}

CountedPixels counted_pixels(const Photograph& rendering, const Photograph& photograph,
                             std::span<const std::uint8_t> mask) {
  check_pictures(rendering, photograph);
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  if (!mask.empty()) {
    check_entries("the mask", mask.size(), pixels);
  }
  CountedPixels counted(pixels, 1);
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool masked = mask.empty() || mask[i] != 0;
    const bool inside = photograph.valid.empty() || photograph.valid[i] != 0;
    counted[i] = masked && inside ? 1 : 0;
  }
  return counted;
}

}  // namespace lumatlas
