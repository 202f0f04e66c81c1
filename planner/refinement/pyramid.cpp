// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/pyramid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

#include "atlas/images/srgb.h"
#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

// sRGB of linear light in fine steps: the power function is too slow for every pixel.
class SrgbTable {
 public:
  SrgbTable() {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      values_[i] = srgb8_from_linear(static_cast<double>(i) / static_cast<double>(values_.size() - 1));
    }
  }
  [[nodiscard]] std::uint8_t operator()(float linear) const {
    return values_[static_cast<std::size_t>(linear * static_cast<float>(values_.size() - 1) + 0.5f)];
  }

 private:
  std::array<std::uint8_t, 16385> values_{};
};

std::uint8_t srgb(float linear) {
  static const SrgbTable table;
  return table(linear);
}

void halve_row(const PhotographSpan& full, Photograph& half, std::size_t y) {
  const auto& linear = linear_from_srgb8();
  const std::size_t stride = 3 * std::size_t{full.width};
  const std::uint8_t* above = &full.rgb[2 * y * stride];
  const std::uint8_t* below = above + stride;
  std::uint8_t* out = &half.rgb[3 * y * half.width];
  for (std::size_t x = 0; x < half.width; ++x) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::size_t at = 6 * x + channel;
      *out++ = srgb(0.25f * (linear[above[at]] + linear[above[at + 3]] + linear[below[at]] + linear[below[at + 3]]));
    }
  }
}

// The mean linear light of some pixels.
struct Mean {
  std::array<float, 3> sum{};
  float count = 0;

  void add(const std::uint8_t* rgb) {
    for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += linear_from_srgb8()[rgb[channel]];
    ++count;
  }
  // There is at least one pixel.
  void write(std::uint8_t* rgb) const {
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[channel] = srgb(std::min(sum[channel] / count, 1.0f));
  }
};

// The same of a photograph with invalid pixels, which count for nothing.
void halve_masked_row(const PhotographSpan& full, Photograph& half, std::size_t y) {
  for (std::size_t x = 0; x < half.width; ++x) {
    const std::size_t first = 2 * y * full.width + 2 * x;
    Mean mean;
    for (const std::size_t pixel : {first, first + 1, first + full.width, first + full.width + 1}) {
      if (full.valid[pixel] != 0) mean.add(&full.rgb[3 * pixel]);
    }
    if (mean.count == 0) continue;
    const std::size_t pixel = y * half.width + x;
    half.valid[pixel] = 255;
    mean.write(&half.rgb[3 * pixel]);
  }
}

// Gives each invalid pixel of a row the mean of the valid ones around it, if there are any. It stays invalid.
void extend_into_row(Photograph& image, std::size_t y) {
  const std::size_t last_row = std::min<std::size_t>(y + 1, image.height - 1);
  for (std::size_t x = 0; x < image.width; ++x) {
    if (image.valid[y * image.width + x] != 0) continue;
    const std::size_t last_column = std::min<std::size_t>(x + 1, image.width - 1);
    Mean mean;
    for (std::size_t row = y - (y > 0); row <= last_row; ++row) {
      for (std::size_t column = x - (x > 0); column <= last_column; ++column) {
        const std::size_t pixel = row * image.width + column;
        if (image.valid[pixel] != 0) mean.add(&image.rgb[3 * pixel]);
      }
    }
    if (mean.count > 0) mean.write(&image.rgb[3 * (y * image.width + x)]);
  }
}

template <typename Function>
void for_each_row(std::size_t rows, const Function& function) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows, 32), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t y = range.begin(); y != range.end(); ++y) function(y);
  });
}

// An odd last row or column is left out, so that a level's pixels are exactly twice as large as the last one's.
Photograph halved(const PhotographSpan& full) {
  Photograph half;
  half.width = full.width / 2;
  half.height = full.height / 2;
  const std::size_t pixels = std::size_t{half.width} * half.height;
  half.rgb.resize(3 * pixels);
  if (full.valid.empty()) {
    for_each_row(half.height, [&](std::size_t y) { halve_row(full, half, y); });
    return half;
  }
  half.valid.resize(pixels, 0);
  for_each_row(half.height, [&](std::size_t y) { halve_masked_row(full, half, y); });
  // Valid pixels are read and others are written, so that rows do not meet.
  for_each_row(half.height, [&](std::size_t y) { extend_into_row(half, y); });
  return half;
}

// The four pixels around an image position, and where it lies between them. Beyond the outermost pixel centres, where
// the colour is held, two of them are the same pixel, so that the derivative across the border is 0 on every side.
struct Footprint {
  const std::uint8_t *top_left, *top_right, *bottom_left, *bottom_right;
  double fx, fy;
};

Footprint footprint(const PhotographSpan& photograph, const glm::dvec2& image) {
  const double x = std::clamp(image.x - 0.5, 0.0, photograph.width - 1.0);
  const double y = std::clamp(image.y - 0.5, 0.0, photograph.height - 1.0);
  const auto left = static_cast<std::size_t>(x);
  const auto top = static_cast<std::size_t>(y);
  const std::size_t right = image.x < 0.5 ? left : std::min<std::size_t>(left + 1, photograph.width - 1);
  const std::size_t bottom = image.y < 0.5 ? top : std::min<std::size_t>(top + 1, photograph.height - 1);
  const auto at = [&](std::size_t column, std::size_t row) {
    return &photograph.rgb[3 * (row * photograph.width + column)];
  };
  return {at(left, top),
          at(right, top),
          at(left, bottom),
          at(right, bottom),
          x - static_cast<double>(left),
          y - static_cast<double>(top)};
}

glm::dvec3 linear_at(const std::array<float, 256>& linear, const std::uint8_t* rgb) {
  return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]};
}

double scale_of(std::uint32_t level) {
  return 1.0 / static_cast<double>(1u << level);
}

constexpr Requirement pyramid_requires{"pyramid"};

void check_pixels(const PhotographSpan& photograph) {
  pyramid_requires(photograph.width >= 1, "photograph.width", photograph.width, "at least 1");
  pyramid_requires(photograph.height >= 1, "photograph.height", photograph.height, "at least 1");
  pyramid_requires.has_size(photograph.rgb.size(), 3 * std::size_t{photograph.width} * photograph.height,
                            "photograph.rgb", "three times the number of pixels");
  if (photograph.valid.empty()) return;
  pyramid_requires.has_size(photograph.valid.size(), std::size_t{photograph.width} * photograph.height,
                            "photograph.valid", "the number of pixels, or empty");
}

}  // namespace

Pyramid::Pyramid(const PhotographSpan& photograph, std::uint32_t coarsest_px) : levels_{photograph} {
  pyramid_requires(coarsest_px >= 1, "coarsest_px", coarsest_px, "at least 1");
  check_pixels(photograph);
  while (std::max(levels_.back().width, levels_.back().height) / 2 >= coarsest_px &&
         std::min(levels_.back().width, levels_.back().height) >= 4) {
    reduced_.push_back(std::make_shared<const StoredPhotograph>(halved(levels_.back())));
    levels_.push_back(reduced_.back()->span());
  }
}

bool Pyramid::is_valid(const glm::dvec2& image) const {
  const PhotographSpan& photograph = levels_.front();
  if (photograph.valid.empty()) return true;
  const Footprint f = footprint(photograph, image);
  const std::array corners{f.top_left, f.top_right, f.bottom_left, f.bottom_right};
  return std::all_of(corners.begin(), corners.end(), [&](const std::uint8_t* rgb) {
    return photograph.valid[static_cast<std::size_t>(rgb - photograph.rgb.data()) / 3] != 0;
  });
}

void Pyramid::refer_to(const PhotographSpan& copy) {
  check_pixels(copy);
  pyramid_requires(copy.width == levels_.front().width, "the copy's width", copy.width, "the photograph's");
  pyramid_requires(copy.height == levels_.front().height, "the copy's height", copy.height, "the photograph's");
  levels_.front() = copy;
}

std::uint32_t Pyramid::level_near(std::uint32_t longer_side) const {
  std::uint32_t index = 0;
  while (index + 1 < levels() && std::max(level(index).width, level(index).height) > longer_side + longer_side / 2) {
    ++index;
  }
  return index;
}

glm::dvec3 Pyramid::color(std::uint32_t level_index, const glm::dvec2& image) const {
  const Footprint f = footprint(level(level_index), image * scale_of(level_index));
  const std::array<float, 256>& linear = linear_from_srgb8();
  return glm::mix(glm::mix(linear_at(linear, f.top_left), linear_at(linear, f.top_right), f.fx),
                  glm::mix(linear_at(linear, f.bottom_left), linear_at(linear, f.bottom_right), f.fx), f.fy);
}

void Pyramid::prefetch(std::uint32_t level_index, const glm::dvec2& image) const {
  const Footprint f = footprint(level(level_index), image * scale_of(level_index));
  __builtin_prefetch(f.top_left);
  __builtin_prefetch(f.bottom_left);
}

ColorSample Pyramid::sample(std::uint32_t level_index, const glm::dvec2& image) const {
  const double scale = scale_of(level_index);
  const Footprint f = footprint(level(level_index), image * scale);
  const std::array<float, 256>& linear = linear_from_srgb8();
  const glm::dvec3 a = linear_at(linear, f.top_left);
  const glm::dvec3 b = linear_at(linear, f.top_right);
  const glm::dvec3 c = linear_at(linear, f.bottom_left);
  const glm::dvec3 d = linear_at(linear, f.bottom_right);
  const glm::dvec3 top = glm::mix(a, b, f.fx);
  const glm::dvec3 bottom = glm::mix(c, d, f.fx);
  return {glm::mix(top, bottom, f.fy), scale * glm::mix(b - a, d - c, f.fy), scale * (bottom - top)};
}

}  // namespace lumatlas
