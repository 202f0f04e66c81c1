// SPDX-License-Identifier: GPL-3.0-or-later
// The photograph of a stored view: all of its pixels, or the parts alone that are resident.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/images/pixel_list.h"

namespace lumatlas {

// Never changes. Pixels are counted row by row from the top left.
class StoredPhotograph {
 public:
  using Color = std::array<std::uint8_t, 3>;  // sRGB

  // Takes the whole photograph, whose lists must have one entry per pixel (std::invalid_argument); never null.
  explicit StoredPhotograph(std::shared_ptr<const Photograph> whole);
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
    if (!whole_) return colors_[pixel];
    const std::uint8_t* const rgb = &whole_->rgb[3 * pixel];
    return {rgb[0], rgb[1], rgb[2]};
  }
  // Returns whether the lens shows something there, and it is in memory.
  [[nodiscard]] bool is_inside_lens(std::size_t pixel) const {
    if (!whole_) return inside_[pixel] != 0;
    return whole_->valid.empty() || whole_->valid[pixel] != 0;
  }
  // Returns whether there are pixels of which the lens shows nothing.
  [[nodiscard]] bool has_lens_mask() const { return has_lens_mask_; }

  // Returns all pixels. Those that are not in memory are black, and valid like those that are outside the lens. Copies
  // nothing where the photograph is whole.
  [[nodiscard]] std::shared_ptr<const Photograph> whole() const;
  // Returns whole()->valid alone.
  [[nodiscard]] std::vector<std::uint8_t> valid() const;

  // Returns the bytes of its pixels in memory.
  [[nodiscard]] std::size_t bytes() const;

  // Compares colours and validity of all pixels.
  friend bool operator==(const StoredPhotograph& a, const StoredPhotograph& b);

 private:
  void take_rows(std::span<const PixelRect> parts, std::uint32_t first_row, std::span<const std::uint8_t> rgb);

  std::uint32_t width_ = 0, height_ = 0;
  bool has_lens_mask_ = false;
  std::shared_ptr<const Photograph> whole_;  // null where parts are kept
  PixelList<Color> colors_;                  // of parts
  PixelList<std::uint8_t> inside_;           // of parts: as Photograph::valid
};

}  // namespace lumatlas
