// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/image_levels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/images/srgb.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require_levels(std::uint32_t width, std::uint32_t height, std::uint32_t levels) {
  const std::uint32_t unit = levels == 0 ? 0 : 1u << (levels - 1);
  if (unit != 0 && width % unit == 0 && height % unit == 0) return;
  throw std::invalid_argument("image levels: a part of " + size_text(width, height) + " pixels does not have " +
                              std::to_string(levels) + " levels");
}

ImageLevel finest_level(const StoredView& view, const ImageRect& rect) {
  ImageLevel level{rect.width, rect.height, {}};
  level.rgba.resize(4 * std::size_t{rect.width} * rect.height);
  const std::int64_t last_x = std::int64_t{view.camera.width} - 1;
  const std::int64_t last_y = std::int64_t{view.camera.height} - 1;
  std::uint8_t* texel = level.rgba.data();
  const auto put = [&](std::int64_t number) {
    const auto pixel = static_cast<std::size_t>(number);
    const StoredPhotograph::Color color = view.photograph->color(pixel);
    std::copy(color.begin(), color.end(), texel);
    texel[3] = view.mask->validity[pixel];
    texel += 4;
  };
  // Columns from `inside` to `beyond` are the image's.
  const std::int64_t inside = std::clamp<std::int64_t>(-rect.x, 0, rect.width);
  const std::int64_t beyond = std::clamp<std::int64_t>(last_x + 1 - rect.x, inside, rect.width);
  for (std::uint32_t row = 0; row < rect.height; ++row) {
    const std::int64_t first = std::clamp<std::int64_t>(rect.y + row, 0, last_y) * view.camera.width;
    for (std::int64_t column = 0; column < inside; ++column) put(first);
    for (std::int64_t column = inside; column < beyond; ++column) put(first + rect.x + column);
    for (std::int64_t column = beyond; column < rect.width; ++column) put(first + last_x);
  }
  return level;
}

// sRGB of linear light in steps fine enough that every 8-bit value is met at its middle.
constexpr std::size_t kSrgbSteps = 1 << 14;
const std::vector<std::uint8_t>& srgb8_by_step() {
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> values(kSrgbSteps + 1);
    for (std::size_t i = 0; i <= kSrgbSteps; ++i) {
      values[i] = srgb8_from_linear(static_cast<double>(i) / kSrgbSteps);
    }
    return values;
  }();
  return table;
}

// Writes the mean of four texels, in linear light and by their validity.
class TexelMean {
 public:
  void operator()(const std::array<const std::uint8_t*, 4>& texels, std::uint8_t* mean) const {
    std::uint32_t validity = 0;
    for (const std::uint8_t* texel : texels) validity += texel[3];
    std::array<float, 3> sum{};
    for (const std::uint8_t* texel : texels) {
      const float weight = validity > 0 ? texel[3] : 1.0f;
      for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += weight * linear_[texel[channel]];
    }
    const float total = validity > 0 ? static_cast<float>(validity) : 4.0f;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float light = std::clamp(sum[channel] / total, 0.0f, 1.0f);
      mean[channel] = srgb8_[static_cast<std::uint32_t>(light * kSrgbSteps + 0.5f)];
    }
    mean[3] = static_cast<std::uint8_t>((validity + 2) / 4);
  }

 private:
  const float* linear_ = linear_from_srgb8().data();
  const std::uint8_t* srgb8_ = srgb8_by_step().data();
};

ImageLevel coarser(const ImageLevel& fine) {
  ImageLevel level{fine.width / 2, fine.height / 2, {}};
  level.rgba.resize(4 * std::size_t{level.width} * level.height);
  const std::size_t row_bytes = 4 * std::size_t{fine.width};
  const TexelMean mean;
  std::uint8_t* texel = level.rgba.data();
  for (std::uint32_t y = 0; y < level.height; ++y) {
    const std::uint8_t* above = &fine.rgba[2 * y * row_bytes];
    for (std::uint32_t x = 0; x < level.width; ++x, above += 8, texel += 4) {
      mean({above, above + 4, above + row_bytes, above + row_bytes + 4}, texel);
    }
  }
  return level;
}

}  // namespace

std::uint32_t levels_of_gutter(std::uint32_t gutter_px) {
  return gutter_px == 0 ? 1 : static_cast<std::uint32_t>(std::bit_width(gutter_px));
}

std::vector<ImageLevel> image_levels(const StoredView& view, const ImageRect& rect, std::uint32_t levels) {
  require_levels(rect.width, rect.height, levels);
  check(view.camera);
  require_photograph_of(view.name, view.camera, *view.photograph);
  if (view.mask->validity.size() != view.photograph->pixels()) {
    throw std::invalid_argument("image levels: view " + view.name + ": validity has " +
                                std::to_string(view.mask->validity.size()) + " values, must have one per pixel");
  }
  return with_coarser_levels(finest_level(view, rect), levels);
}

std::vector<ImageLevel> with_coarser_levels(ImageLevel finest, std::uint32_t levels) {
  require_levels(finest.width, finest.height, levels);
  std::vector<ImageLevel> result;
  result.reserve(levels);
  result.push_back(std::move(finest));
  while (result.size() < levels) result.push_back(coarser(result.back()));
  return result;
}

}  // namespace lumatlas
