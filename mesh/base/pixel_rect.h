// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

namespace lumatlas {

// A rectangle of pixels within an image.
struct PixelRect {
  std::uint32_t x = 0, y = 0;           // its top left pixel
  std::uint32_t width = 0, height = 0;  // pixels

  [[nodiscard]] std::uint32_t right() const { return x + width; }    // the first column beyond it
  [[nodiscard]] std::uint32_t bottom() const { return y + height; }  // the first row beyond it
  [[nodiscard]] std::size_t pixels() const { return std::size_t{width} * height; }
  [[nodiscard]] bool is_within(std::uint32_t image_width, std::uint32_t image_height) const {
    return std::uint64_t{x} + width <= image_width && std::uint64_t{y} + height <= image_height;
  }
  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

}  // namespace lumatlas
