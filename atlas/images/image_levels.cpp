// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/image_levels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>
#include <string>

#include "atlas/images/srgb.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

ImageLevel finest(const StoredView& view, const ImageRect& rect) {
  ImageLevel level{rect.width, rect.height, {}};
  level.rgba.resize(4 * std::size_t{rect.width} * rect.height);
  const std::int64_t last_x = std::int64_t{view.camera.width} - 1;
  const std::int64_t last_y = std::int64_t{view.camera.height} - 1;
  std::uint8_t* texel = level.rgba.data();
  for (std::uint32_t row = 0; row < rect.height; ++row) {
    const std::int64_t y = std::clamp<std::int64_t>(rect.y + row, 0, last_y);
    for (std::uint32_t column = 0; column < rect.width; ++column, texel += 4) {
      const std::int64_t x = std::clamp<std::int64_t>(rect.x + column, 0, last_x);
      const auto pixel = static_cast<std::size_t>(y * view.camera.width + x);
      std::copy_n(&view.photograph->rgb[3 * pixel], 3, texel);
      texel[3] = view.mask->validity[pixel];
    }
  }
  return level;
}

// sRGB of linear light in steps fine enough that every 8-bit value is met at its middle.
std::uint8_t srgb8(float linear) {
  constexpr std::size_t kSteps = 1 << 14;
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> values(kSteps + 1);
    for (std::size_t i = 0; i <= kSteps; ++i) values[i] = srgb8_from_linear(static_cast<double>(i) / kSteps);
    return values;
  }();
  return table[static_cast<std::size_t>(std::clamp(linear, 0.0f, 1.0f) * kSteps + 0.5f)];
}

std::array<std::uint8_t, 4> mean(const std::array<const std::uint8_t*, 4>& texels) {
  const auto& linear = linear_from_srgb8();
  std::uint32_t validity = 0;
  for (const std::uint8_t* texel : texels) validity += texel[3];
  std::array<float, 3> sum{};
  for (const std::uint8_t* texel : texels) {
    const float weight = validity > 0 ? texel[3] : 1.0f;
    for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += weight * linear[texel[channel]];
  }
  const float total = validity > 0 ? static_cast<float>(validity) : 4.0f;
  return {srgb8(sum[0] / total), srgb8(sum[1] / total), srgb8(sum[2] / total),
          static_cast<std::uint8_t>((validity + 2) / 4)};
}

ImageLevel coarser(const ImageLevel& fine) {
  ImageLevel level{fine.width / 2, fine.height / 2, {}};
  level.rgba.resize(4 * std::size_t{level.width} * level.height);
  const std::size_t row_bytes = 4 * std::size_t{fine.width};
  std::uint8_t* texel = level.rgba.data();
  for (std::uint32_t y = 0; y < level.height; ++y) {
    const std::uint8_t* above = &fine.rgba[2 * y * row_bytes];
    for (std::uint32_t x = 0; x < level.width; ++x, above += 8, texel += 4) {
      const auto value = mean({above, above + 4, above + row_bytes, above + row_bytes + 4});
      std::copy(value.begin(), value.end(), texel);
    }
  }
  return level;
}

}  // namespace

std::uint32_t levels_of_gutter(std::uint32_t gutter_px) {
  return gutter_px == 0 ? 1 : static_cast<std::uint32_t>(std::bit_width(gutter_px));
}

std::vector<ImageLevel> image_levels(const StoredView& view, const ImageRect& rect, std::uint32_t levels) {
  const std::uint32_t unit = levels == 0 ? 0 : 1u << (levels - 1);
  if (unit == 0 || rect.width % unit != 0 || rect.height % unit != 0) {
    throw std::invalid_argument("image levels: a part of " + size_text(rect.width, rect.height) +
                                " pixels does not have " + std::to_string(levels) + " levels");
  }
  check(view.camera);
  require_photograph_of(view.name, view.camera, *view.photograph);
  if (view.mask->validity.size() != view.photograph->rgb.size() / 3) {
    throw std::invalid_argument("image levels: view " + view.name + ": validity has " +
                                std::to_string(view.mask->validity.size()) + " values, must have one per pixel");
  }
  std::vector<ImageLevel> result{finest(view, rect)};
  while (result.size() < levels) result.push_back(coarser(result.back()));
  return result;
}

}  // namespace lumatlas
