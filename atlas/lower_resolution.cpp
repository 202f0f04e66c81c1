// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/lower_resolution.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "atlas/srgb.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Neither aliases nor rings; wider filters keep little more detail and take ten times as long.
constexpr const char* kFilter = "triangle";
constexpr const char* kMean = "box";

// Colour times validity, and validity: what the lens did not see has no part in any mean.
constexpr int kChannels = 4;

void require_sizes(ImageSize from, ImageSize to, std::size_t values, const char* what) {
  const auto refuse = [](const std::string& why) { throw std::invalid_argument("lower resolution: " + why); };
  const auto text = [](ImageSize size) { return size_text(size.width, size.height); };
  if (to.width < 1 || to.height < 1 || to.width > from.width || to.height > from.height) {
    refuse("the new size is " + text(to) + ", each side must be from 1 to that of " + text(from));
  }
  if (values != std::size_t{from.width} * from.height) {
    refuse(std::string(what) + " has " + std::to_string(values) + " values, must have one per pixel of " + text(from));
  }
}

std::vector<float> resized(std::vector<float>& values, int channels, ImageSize from, ImageSize to, const char* filter) {
  using OIIO::ImageBuf, OIIO::ImageSpec, OIIO::TypeDesc;
  const auto spec = [channels](ImageSize size) {
    return ImageSpec(static_cast<int>(size.width), static_cast<int>(size.height), channels, TypeDesc::FLOAT);
  };
  std::vector<float> result(std::size_t{to.width} * to.height * static_cast<std::size_t>(channels));
  const ImageBuf source(spec(from), values.data());
  ImageBuf target(spec(to), result.data());
  constexpr int kThreads = 1;  // whoever has many photographs has a thread for each
  if (!OIIO::ImageBufAlgo::resize(target, source, filter, 0, {}, kThreads)) {
    throw std::runtime_error("OpenImageIO cannot resize an image: " + target.geterror());
  }
  return result;
}

std::vector<float> weighted_by_validity(const Photograph& photograph) {
  const auto& linear = linear_from_srgb8();
  const std::size_t pixels = photograph.rgb.size() / 3;
  std::vector<float> values(kChannels * pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const bool valid = photograph.valid.empty() || photograph.valid[pixel] != 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      values[kChannels * pixel + channel] = valid ? linear[photograph.rgb[3 * pixel + channel]] : 0.0f;
    }
    values[kChannels * pixel + 3] = valid ? 1.0f : 0.0f;
  }
  return values;
}

}  // namespace

Photograph at_lower_resolution(const Photograph& photograph, std::uint32_t width, std::uint32_t height) {
  const ImageSize from{photograph.width, photograph.height}, to{width, height};
  if (photograph.rgb.size() % 3 != 0) throw std::invalid_argument("lower resolution: rgb has not three values a pixel");
  require_sizes(from, to, photograph.rgb.size() / 3, "the photograph");
  if (!photograph.valid.empty()) require_sizes(from, to, photograph.valid.size(), "the lens's image");
  std::vector<float> values = weighted_by_validity(photograph);
  values = resized(values, kChannels, from, to, kFilter);
  Photograph lower{width, height, std::vector<std::uint8_t>(3 * std::size_t{width} * height), {}};
  for (std::size_t pixel = 0; pixel < values.size() / kChannels; ++pixel) {
    const float* const value = &values[kChannels * pixel];
    constexpr float kLeastShare = 0.25f;  // less of a pixel's filter says nothing about its colour
    const float share = value[3] < kLeastShare ? 1.0f : value[3];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      lower.rgb[3 * pixel + channel] = srgb8_from_linear(static_cast<double>(value[channel] / share));
    }
  }
  if (photograph.valid.empty()) return lower;
  lower.valid = mask_at_lower_resolution(photograph.valid, from, to);
  for (std::uint8_t& valid : lower.valid) valid = valid == 255 ? 255 : 0;
  return lower;
}

std::vector<std::uint8_t> mask_at_lower_resolution(std::span<const std::uint8_t> mask, ImageSize from, ImageSize to) {
  if (mask.empty()) return {};
  require_sizes(from, to, mask.size(), "the mask");
  std::vector<float> values(mask.begin(), mask.end());
  values = resized(values, 1, from, to, kMean);
  std::vector<std::uint8_t> lower(values.size());
  std::transform(values.begin(), values.end(), lower.begin(),
                 [](float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f))); });
  return lower;
}

}  // namespace lumatlas
