// SPDX-License-Identifier: GPL-3.0-or-later
// A list with one value for each pixel of an image. It can keep the values of some parts of the image alone, and then
// takes memory by the size of these parts and not by the size of the image. All values together are a PixelBuffer, as
// those of parts are once they are settled.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/pixel_buffer.h"
#include "mesh/base/number_text.h"
#include "mesh/base/pixel_rect.h"

namespace lumatlas {

// Pixels are counted row by row from the top left. The list reads like a std::vector. A look-up takes constant time:
// one step where each pixel has its own value, two tables where parts are kept. Parts are kept in square blocks of
// kBlockSide pixels a side; a block whose pixels all have the value `elsewhere` takes no memory.
template <typename T>
class PixelList {
 public:
  static constexpr std::uint32_t kBlockSide = 8;
  static constexpr std::uint32_t kPageSide = 8 * kBlockSide;  // pixels of a page of the tables

  PixelList() = default;
  // Takes a value for every pixel. May be converted to, because a list of all pixels is the usual one.
  PixelList(std::vector<T> all) : all_(std::move(all)) {}  // NOLINT(google-explicit-constructor)
  // An image whose pixels have the value `elsewhere` until set_part() gives them others. The width must not be 0.
  PixelList(std::uint32_t width, std::uint32_t height, const T& elsewhere)
      : size_(std::size_t{width} * height),
        width_(width),
        elsewhere_(elsewhere),
        page_columns_((width + kPageSide - 1) / kPageSide),
        pages_(std::size_t{page_columns_} * ((height + kPageSide - 1) / kPageSide), kNone) {
    if (width == 0) throw std::invalid_argument("pixels: an image of parts has a width of 0, must be at least 1");
  }

  [[nodiscard]] std::size_t size() const { return has_all() ? all_.size() : size_; }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] bool has_all() const { return width_ == 0; }  // each pixel has its own value in memory

  [[nodiscard]] T operator[](std::size_t pixel) const {
    if (has_all()) return all_[pixel];
    const auto x = static_cast<std::uint32_t>(pixel % width_), y = static_cast<std::uint32_t>(pixel / width_);
    const std::uint32_t block = block_at(x, y);
    return block == kNone ? elsewhere_ : kept()[block + place_in_block(x, y)];
  }

  // Copies the values of consecutive pixels from `first` on.
  void copy(std::size_t first, std::span<T> to) const {
    if (has_all()) {
      std::copy_n(all_.data() + first, to.size(), to.data());
    } else {
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = (*this)[first + i];
    }
  }

  // Asks the processor to load a pixel's value. Does nothing where parts are kept.
  void prefetch(std::size_t pixel) const {
    if (has_all()) __builtin_prefetch(&all_[pixel]);
  }

  // Gives a part of an image of parts its values, row by row. Throws std::invalid_argument unless the list keeps parts,
  // the rectangle is within the image, and there is one value per pixel.
  void set_part(const PixelRect& part, std::span<const T> values) {
    const std::uint32_t height = has_all() ? 0 : static_cast<std::uint32_t>(size_ / width_);
    if (!part.is_within(width_, height) || values.size() != part.pixels()) {
      throw std::invalid_argument("pixels: a part of " + size_text(part.width, part.height) + " pixels with " +
                                  std::to_string(values.size()) + " values is set in an image of " +
                                  size_text(width_, height));
    }
    if (!settled_.empty()) {
      values_.assign(settled_.begin(), settled_.end());
      settled_ = {};
    }
    for (std::uint32_t row = 0; row < part.height; ++row) {
      for (std::uint32_t column = 0; column < part.width; ++column) {
        const std::uint32_t x = part.x + column, y = part.y + row;
        const T& value = values[std::size_t{row} * part.width + column];
        if (value == elsewhere_ && block_at(x, y) == kNone) continue;
        values_[block_made_at(x, y) + place_in_block(x, y)] = value;
      }
    }
  }

  // Keeps the values of parts within the bound of PixelMemoryBound from now on. Call it after the last set_part(): a
  // later one takes them into memory again. Throws InputError if they must go to a scratch file that cannot be written.
  void settle() {
    if (values_.empty()) return;
    values_.shrink_to_fit();
    settled_ = PixelBuffer<T>(std::move(values_));
    values_ = {};
  }

  // Calls use(pixel, value) for each pixel that has a value in memory, in ascending order. Others have the value
  // `elsewhere`.
  template <typename Use>
  void for_each(const Use& use) const {
    if (has_all()) {
      const std::span<const T> all(all_.data(), all_.size());
      for (std::size_t pixel = 0; pixel < all.size(); ++pixel) use(pixel, all[pixel]);
      return;
    }
    for (std::size_t row = 0; row < size_; row += width_) for_each_in_row(row, use);
  }

  // Returns the values of all pixels.
  [[nodiscard]] std::vector<T> all() const {
    if (has_all()) return {all_.begin(), all_.end()};
    std::vector<T> values(size_, elsewhere_);
    for_each([&](std::size_t pixel, const T& value) { values[pixel] = value; });
    return values;
  }

  // Gives every pixel a value of its own in memory, and returns these values, which may be changed.
  [[nodiscard]] std::vector<T>& values() {
    if (!has_all()) *this = PixelList(all());
    return all_.values();
  }

  // Returns the bytes of memory that the values and their tables take.
  [[nodiscard]] std::size_t bytes() const {
    return all_.bytes() + settled_.bytes() + sizeof(T) * values_.size() +
           sizeof(std::uint32_t) * (pages_.size() + blocks_.size());
  }

  friend bool operator==(const PixelList& a, const PixelList& b) {
    if (a.has_all() && b.has_all()) return std::equal(a.all_.begin(), a.all_.end(), b.all_.begin(), b.all_.end());
    return a.all() == b.all();
  }

 private:
  static constexpr std::uint32_t kNone = ~0u;
  static constexpr std::uint32_t kBlockPixels = kBlockSide * kBlockSide;
  static constexpr std::uint32_t kPageBlocks = (kPageSide / kBlockSide) * (kPageSide / kBlockSide);

  [[nodiscard]] static std::uint32_t place_in_block(std::uint32_t x, std::uint32_t y) {
    return y % kBlockSide * kBlockSide + x % kBlockSide;
  }
  [[nodiscard]] std::size_t page_of(std::uint32_t x, std::uint32_t y) const {
    return std::size_t{y / kPageSide} * page_columns_ + x / kPageSide;
  }
  [[nodiscard]] static std::uint32_t block_in_page(std::uint32_t x, std::uint32_t y) {
    return y % kPageSide / kBlockSide * (kPageSide / kBlockSide) + x % kPageSide / kBlockSide;
  }

  // Returns the number of the first value of the pixel's block, or kNone.
  [[nodiscard]] std::uint32_t block_at(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t page = pages_[page_of(x, y)];
    return page == kNone ? kNone : blocks_[page + block_in_page(x, y)];
  }

  [[nodiscard]] std::uint32_t block_made_at(std::uint32_t x, std::uint32_t y) {
    std::uint32_t& page = pages_[page_of(x, y)];
    if (page == kNone) {
      page = static_cast<std::uint32_t>(blocks_.size());
      blocks_.resize(blocks_.size() + kPageBlocks, kNone);
    }
    std::uint32_t& block = blocks_[page + block_in_page(x, y)];
    if (block == kNone) {
      block = static_cast<std::uint32_t>(values_.size());
      values_.resize(values_.size() + kBlockPixels, elsewhere_);
    }
    return block;
  }

  [[nodiscard]] const T* kept() const { return settled_.empty() ? values_.data() : settled_.data(); }

  template <typename Use>
  void for_each_in_row(std::size_t first_pixel, const Use& use) const {
    const auto y = static_cast<std::uint32_t>(first_pixel / width_);
    for (std::uint32_t x = 0; x < width_; x += kBlockSide) {
      const std::uint32_t block = block_at(x, y);
      if (block == kNone) continue;
      const std::uint32_t end = std::min(x + kBlockSide, width_);
      for (std::uint32_t column = x; column < end; ++column) {
        use(first_pixel + column, kept()[block + place_in_block(column, y)]);
      }
    }
  }

  PixelBuffer<T> all_;       // empty where parts are kept
  std::size_t size_ = 0;     // of an image of parts
  std::uint32_t width_ = 0;  // 0: all pixels have their values in all_
  T elsewhere_{};
  std::uint32_t page_columns_ = 0;
  std::vector<std::uint32_t> pages_;   // for each page the first of its blocks, or kNone
  std::vector<std::uint32_t> blocks_;  // for each block of a page its first value, or kNone
  std::vector<T> values_;              // of the blocks; none once they are settled
  PixelBuffer<T> settled_;
};

}  // namespace lumatlas
