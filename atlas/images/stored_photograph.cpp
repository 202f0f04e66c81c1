// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/stored_photograph.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require_count(const char* list, std::size_t count, std::size_t expected, const ImageSize& size) {
  if (count == expected) return;
  throw std::invalid_argument(std::string("photograph: ") + list + " has " + std::to_string(count) +
                              " values, must have " + std::to_string(expected) + " for its " +
                              size_text(size.width, size.height) + " pixels");
}

void require_lists(const Photograph& photograph) {
  const ImageSize size{photograph.width, photograph.height};
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  require_count("rgb", photograph.rgb.size(), 3 * pixels, size);
  if (!photograph.valid.empty()) require_count("valid", photograph.valid.size(), pixels, size);
}

}  // namespace

StoredPhotograph::StoredPhotograph(Photograph whole)
    : width_(whole.width), height_(whole.height), has_lens_mask_(!whole.valid.empty()), is_whole_(true) {
  require_lists(whole);
  rgb_ = PixelBuffer(std::move(whole.rgb));
  valid_ = PixelBuffer(std::move(whole.valid));
}

StoredPhotograph::StoredPhotograph(const ImageSize& size, std::span<const std::uint8_t> valid,
                                   std::span<const PixelRect> parts, const std::function<void(const PixelRows&)>& read)
    : width_(size.width),
      height_(size.height),
      has_lens_mask_(!valid.empty()),
      colors_(size.width, size.height, Color{}),
      inside_(size.width, size.height, 0) {
  if (has_lens_mask_) require_count("valid", valid.size(), pixels(), size);
  std::vector<std::uint8_t> inside;
  for (const PixelRect& part : parts) {
    inside.assign(part.pixels(), 255);
    for (std::uint32_t row = 0; has_lens_mask_ && row < part.height && part.bottom() <= height_; ++row) {
      const auto first = valid.subspan(std::size_t{part.y + row} * width_ + part.x, part.width);
      std::copy(first.begin(), first.end(), inside.begin() + std::ptrdiff_t{row} * part.width);
    }
    inside_.set_part(part, inside);
  }
  read([&](std::uint32_t first_row, std::span<const std::uint8_t> rgb) { take_rows(parts, first_row, rgb); });
  colors_.settle();
  inside_.settle();
}

void StoredPhotograph::take_rows(std::span<const PixelRect> parts, std::uint32_t first_row,
                                 std::span<const std::uint8_t> rgb) {
  const auto end = static_cast<std::uint32_t>(first_row + rgb.size() / 3 / width_);
  std::vector<Color> colors;
  for (const PixelRect& part : parts) {
    const std::uint32_t top = std::max(part.y, first_row), bottom = std::min(part.bottom(), end);
    if (top >= bottom) continue;
    colors.clear();
    for (std::uint32_t y = top; y < bottom; ++y) {
      const std::uint8_t* from = &rgb[3 * (std::size_t{y - first_row} * width_ + part.x)];
      for (std::uint32_t x = 0; x < part.width; ++x, from += 3) colors.push_back({from[0], from[1], from[2]});
    }
    colors_.set_part({part.x, top, part.width, bottom - top}, colors);
  }
}

PhotographSpan StoredPhotograph::span() const {
  if (!is_whole_) throw std::logic_error("photograph: all of its pixels are asked for, but only parts are kept");
  PhotographSpan all;
  all.width = width_;
  all.height = height_;
  all.rgb = {rgb_.data(), rgb_.size()};
  all.valid = {valid_.data(), valid_.size()};
  return all;
}

Photograph StoredPhotograph::whole() const {
  if (is_whole_) return {width_, height_, {rgb_.begin(), rgb_.end()}, {valid_.begin(), valid_.end()}};
  Photograph photograph{width_, height_, std::vector<std::uint8_t>(3 * pixels(), 0), inside_.all()};
  colors_.for_each([&](std::size_t pixel, const Color& color) {
    for (std::size_t channel = 0; channel < color.size(); ++channel)
      photograph.rgb[3 * pixel + channel] = color[channel];
  });
  return photograph;
}

std::vector<std::uint8_t> StoredPhotograph::valid() const {
  return is_whole_ ? std::vector<std::uint8_t>(valid_.begin(), valid_.end()) : inside_.all();
}

std::size_t StoredPhotograph::bytes() const {
  return rgb_.bytes() + valid_.bytes() + colors_.bytes() + inside_.bytes();
}

bool operator==(const StoredPhotograph& a, const StoredPhotograph& b) {
  if (a.width() != b.width() || a.height() != b.height() || a.has_lens_mask() != b.has_lens_mask()) return false;
  if (a.is_whole_ && b.is_whole_) {
    return std::equal(a.rgb_.begin(), a.rgb_.end(), b.rgb_.begin(), b.rgb_.end()) &&
           std::equal(a.valid_.begin(), a.valid_.end(), b.valid_.begin(), b.valid_.end());
  }
  const Photograph first = a.whole(), second = b.whole();
  return first.rgb == second.rgb && first.valid == second.valid;
}

}  // namespace lumatlas
