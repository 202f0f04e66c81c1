// SPDX-License-Identifier: GPL-3.0-or-later
// Oklab: B. Ottosson, "A perceptual color space for image processing", 2020.
#include "tools/error_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "atlas/srgb.h"
#include "tools/counted_pixels.h"

namespace lumatlas {

namespace {

// Lightness is k / 4 of the way from the first to the last; hue and chroma were chosen within sRGB.
constexpr std::size_t kColors = 5;
struct OklabAnchor {
  double chroma;
  double hue_deg;
};
constexpr double kDarkest = 0.12;
constexpr double kBrightest = 0.97;
constexpr std::array<OklabAnchor, kColors> kAnchors = {
    {{0.03, 285}, {0.15, 300}, {0.19, 360}, {0.155, 410}, {0.06, 465}}};

glm::dvec3 linear_from_oklab(double lightness, double a, double b) {
  const double l = lightness + 0.3963377774 * a + 0.2158037573 * b;
  const double m = lightness - 0.1055613458 * a - 0.0638541728 * b;
  const double s = lightness - 0.0894841775 * a - 1.2914855480 * b;
  const glm::dvec3 lms(l * l * l, m * m * m, s * s * s);
  return {4.0767416621 * lms.x - 3.3077115913 * lms.y + 0.2309699292 * lms.z,
          -1.2684380046 * lms.x + 2.6097574011 * lms.y - 0.3413193965 * lms.z,
          -0.0041960863 * lms.x - 0.7034186147 * lms.y + 1.7076147010 * lms.z};
}

// The sum over the channels of the squared differences: a whole number, so the colours of all of them are a table.
constexpr int kFullScaleSquares = static_cast<int>(3 * kErrorFullScale * kErrorFullScale);

std::vector<std::array<std::uint8_t, 3>> color_of_squares() {
  std::vector<std::array<std::uint8_t, 3>> table;
  for (int squares = 0; squares <= kFullScaleSquares; ++squares) {
    table.push_back(error_color(std::sqrt(squares / 3.0)));
  }
  return table;
}

int difference_squares(const std::uint8_t* a, const std::uint8_t* b) {
  int squares = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const int difference = int{a[channel]} - int{b[channel]};
    squares += difference * difference;
  }
  return squares;
}

}  // namespace

std::array<std::uint8_t, 3> error_color(double levels) {
  const double part = std::clamp(levels / kErrorFullScale, 0.0, 1.0);
  const double place = part * (kColors - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kColors - 2);
  const double rest = place - static_cast<double>(below);
  const double chroma = std::lerp(kAnchors[below].chroma, kAnchors[below + 1].chroma, rest);
  const double hue = glm::radians(std::lerp(kAnchors[below].hue_deg, kAnchors[below + 1].hue_deg, rest));
  const double lightness = std::lerp(kDarkest, kBrightest, part);
  const glm::dvec3 linear = linear_from_oklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
  return {srgb8_from_linear(linear.r), srgb8_from_linear(linear.g), srgb8_from_linear(linear.b)};
}

Photograph error_picture(const Photograph& rendering, const Photograph& photograph,
                         std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  static const std::vector<std::array<std::uint8_t, 3>> colors = color_of_squares();
  Photograph picture;
  picture.width = photograph.width;
  picture.height = photograph.height;
  picture.rgb.resize(photograph.rgb.size());
  for (std::size_t i = 0; i < counted.size(); ++i) {
    std::array<std::uint8_t, 3> color = kNotScoredColor;
    if (counted[i] != 0) {
      const int squares = difference_squares(&rendering.rgb[3 * i], &photograph.rgb[3 * i]);
      color = colors[static_cast<std::size_t>(std::min(squares, kFullScaleSquares))];
    }
    std::copy(color.begin(), color.end(), picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return picture;
}

}  // namespace lumatlas
