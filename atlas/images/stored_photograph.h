// SPDX-License-Identifier: GPL-3.0-or-later
// The photograph of a stored view: all of its pixels, or the parts alone that are resident.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/images/pixel_buffer.h"
#include "atlas/images/pixel_list.h"

namespace lumatlas {

// Never changes. Pixels are counted row by row from the top left.
class StoredPhotograph {
 public:
  using Color = std::array<std::uint8_t, 3>;  // sRGB

  // Takes the whole photograph, whose lists must have one entry per pixel (std::invalid_argument). Its pixels are in
  // memory as far as PixelMemoryBound allows, else in a scratch file. Throws InputError if that cannot be written.
  explicit StoredPhotograph(Photograph whole);
  // Keeps these parts of a photograph, each within it (std::invalid_argument), and nothing of the rest. The lens shows
  // nothing elsewhere. `valid` is as Photograph::valid of the whole; `read` hands all rows to what it is called with.
  StoredPhotograph(const ImageSize& size, std::span<const std::uint8_t> valid, std::span<const PixelRect> parts,
                   const std::function<void(const PixelRows&)>& read);

  [[nodiscard]] std::uint32_t width() const { return width_; }    // pixels
  [[nodiscard]] std::uint32_t height() const { return height_; }  // pixels
  [[nodiscard]] std::size_t pixels() const { return std::size_t{width_} * height_; }

  // Black where the pixel is not in memory.
  [[nodiscard]] Color color(std::size_t pixel) const {
    if (!is_whole_) return colors_[pixel];
    const std::uint8_t* const rgb = rgb_.data() + 3 * pixel;
    return {rgb[0], rgb[1], rgb[2]};
  }
  // Returns whether the lens shows something there, and it is in memory.
  [[nodiscard]] bool is_inside_lens(std::size_t pixel) const {
    if (!is_whole_) return inside_[pixel] != 0;
    return valid_.empty() || valid_[pixel] != 0;
  }
  // Returns whether there are pixels of which the lens shows nothing.
  [[nodiscard]] bool has_lens_mask() const { return has_lens_mask_; }

  // Returns all pixels where the photograph is whole, and copies nothing: they are there as long as this is. Throws
  // std::logic_error where parts are kept.
  [[nodiscard]] PhotographSpan span() const;
  // Returns a copy of all pixels. Those that are not in memory are black, and valid like those that are outside the
  // lens.
  [[nodiscard]] Photograph whole() const;
  // Returns whole().valid alone.
  [[nodiscard]] std::vector<std::uint8_t> valid() const;

  // Returns the bytes of memory that its pixels take.
  [[nodiscard]] std::size_t bytes() const;

  // Compares colours and validity of all pixels.
  friend bool operator==(const StoredPhotograph& a, const StoredPhotograph& b);

 private:
  void take_rows(std::span<const PixelRect> parts, std::uint32_t first_row, std::span<const std::uint8_t> rgb);

  std::uint32_t width_ = 0, height_ = 0;
  bool has_lens_mask_ = false;
  bool is_whole_ = false;
  PixelBuffer<std::uint8_t> rgb_, valid_;  // of a whole photograph: as Photograph's
  PixelList<Color> colors_;                // of parts
  PixelList<std::uint8_t> inside_;         // of parts: as Photograph::valid
};

}  // namespace lumatlas
