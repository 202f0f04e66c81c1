// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/lower_resolution.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "atlas/images/srgb.h"
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

// Filters an image band by band, so that memory follows from its width and not from its height.
class BandedResize {
 public:
  BandedResize(ImageSize from, ImageSize to, int channels, const char* filter)
      : from_(from), to_(to), channels_(channels), filter_(filter) {}

  // Calls fill(row, values) for each row of the image that is needed, to write its values, and take(row, values) for
  // each row of the result, in order.
  template <typename Fill, typename Take>
  void run(const Fill& fill, const Take& take) const {
    const std::uint32_t rows = rows_at_once();
    for (std::uint32_t first = 0; first < to_.height; first += rows) {
      const Rows target{first, std::min(rows, to_.height - first)};
      const Rows source = needed_for(target);
      std::vector<float> values(source.count * row_values(from_));
      for (std::uint32_t i = 0; i < source.count; ++i) fill(source.first + i, &values[i * row_values(from_)]);
      const std::vector<float> result = resized(source, values, target);
      for (std::uint32_t i = 0; i < target.count; ++i) take(target.first + i, &result[i * row_values(to_)]);
    }
  }

 private:
  struct Rows {
    std::uint32_t first, count;
  };

  [[nodiscard]] std::size_t row_values(ImageSize size) const {
    return std::size_t{size.width} * static_cast<std::size_t>(channels_);
  }
  [[nodiscard]] double scale() const { return static_cast<double>(from_.height) / to_.height; }

  // Returns how many rows of the result are made together, so that their band of the image has some 16 MB.
  [[nodiscard]] std::uint32_t rows_at_once() const {
    constexpr std::size_t kValues = std::size_t{1} << 22;
    const double rows = static_cast<double>(kValues / row_values(from_)) / scale();
    return static_cast<std::uint32_t>(std::clamp(rows, 1.0, static_cast<double>(to_.height)));
  }

  // Returns the rows of the image that some rows of the result depend on. No filter here reaches further than two
  // pixels of the result.
  [[nodiscard]] Rows needed_for(Rows target) const {
    const double reach = 2 * scale() + 2;
    const double first = std::max(0.0, std::floor(target.first * scale() - reach));
    const double last = std::min<double>(from_.height, std::ceil((target.first + target.count) * scale() + reach));
    return {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last - first)};
  }

  [[nodiscard]] OIIO::ImageSpec spec_of(ImageSize whole, Rows rows) const {
    OIIO::ImageSpec spec(static_cast<int>(whole.width), static_cast<int>(rows.count), channels_, OIIO::TypeDesc::FLOAT);
    spec.y = static_cast<int>(rows.first);
    spec.full_y = 0;
    spec.full_height = static_cast<int>(whole.height);
    return spec;
  }

  [[nodiscard]] std::vector<float> resized(Rows source, std::vector<float>& values, Rows target) const {
    std::vector<float> result(target.count * row_values(to_));
    const OIIO::ImageBuf image(spec_of(from_, source), values.data());
    OIIO::ImageBuf lower(spec_of(to_, target), result.data());
    constexpr int kThreads = 1;  // callers with many photographs run one thread for each
    if (!OIIO::ImageBufAlgo::resize(lower, image, filter_, 0, {}, kThreads)) {
      throw std::runtime_error("OpenImageIO cannot resize an image: " + lower.geterror());
    }
    return result;
  }

  ImageSize from_, to_;
  int channels_;
  const char* filter_;
};

void weigh_by_validity(const Photograph& photograph, std::uint32_t row, float* values) {
  const auto& linear = linear_from_srgb8();
  for (std::size_t x = 0; x < photograph.width; ++x) {
    const std::size_t pixel = std::size_t{row} * photograph.width + x;
    const bool valid = photograph.valid.empty() || photograph.valid[pixel] != 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      values[kChannels * x + channel] = valid ? linear[photograph.rgb[3 * pixel + channel]] : 0.0f;
    }
    values[kChannels * x + 3] = valid ? 1.0f : 0.0f;
  }
}

void write_colors(const float* values, std::uint32_t row, Photograph& lower) {
  constexpr float kLeastShare = 0.25f;  // less of a pixel's filter says nothing about its colour
  for (std::size_t x = 0; x < lower.width; ++x) {
    const float* const value = values + kChannels * x;
    const float share = value[3] < kLeastShare ? 1.0f : value[3];
    std::uint8_t* const rgb = &lower.rgb[3 * (std::size_t{row} * lower.width + x)];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      rgb[channel] = srgb8_from_linear(static_cast<double>(value[channel] / share));
    }
  }
}

}  // namespace

Photograph at_lower_resolution(const Photograph& photograph, std::uint32_t width, std::uint32_t height) {
  const ImageSize from{photograph.width, photograph.height}, to{width, height};
  if (photograph.rgb.size() % 3 != 0) throw std::invalid_argument("lower resolution: rgb has not three values a pixel");
  require_sizes(from, to, photograph.rgb.size() / 3, "the photograph");
  if (!photograph.valid.empty()) require_sizes(from, to, photograph.valid.size(), "the lens's image");
  Photograph lower{width, height, std::vector<std::uint8_t>(3 * std::size_t{width} * height), {}};
  BandedResize(from, to, kChannels, kFilter)
      .run([&](std::uint32_t row, float* values) { weigh_by_validity(photograph, row, values); },
           [&](std::uint32_t row, const float* values) { write_colors(values, row, lower); });
  if (photograph.valid.empty()) return lower;
  lower.valid = mask_at_lower_resolution(photograph.valid, from, to);
  for (std::uint8_t& valid : lower.valid) valid = valid == 255 ? 255 : 0;
  return lower;
}

std::vector<std::uint8_t> mask_at_lower_resolution(std::span<const std::uint8_t> mask, ImageSize from, ImageSize to) {
  if (mask.empty()) return {};
  require_sizes(from, to, mask.size(), "the mask");
  std::vector<std::uint8_t> lower(std::size_t{to.width} * to.height);
  const auto rounded = [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f)));
  };
  BandedResize(from, to, 1, kMean)
      .run(
          [&](std::uint32_t row, float* values) {
            const std::uint8_t* const first = mask.data() + std::size_t{row} * from.width;
            std::copy(first, first + from.width, values);
          },
          [&](std::uint32_t row, const float* values) {
            std::transform(values, values + to.width, lower.begin() + std::ptrdiff_t{row} * to.width, rounded);
          });
  return lower;
}

}  // namespace lumatlas
