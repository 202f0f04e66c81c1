// SPDX-License-Identifier: GPL-3.0-or-later
// These are not OpenImageIO's colour maps, because their lightness is not in proportion to the value: inferno, magma
// and plasma are off by 13 to 14 % of their range, viridis by 18 %, and turbo falls again; the ramps here by 1 %.
//
// Oklab: B. Ottosson, "A perceptual color space for image processing", 2020. The ramps are cylinder segments in it, of
// our own choice; that of quantities runs through the hues of Matplotlib's viridis.
#include "tools/score/report/color_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

#include "atlas/images/srgb.h"

namespace lumatlas {

namespace {

// Lightness is k / 4 of the way from the first to the last; hue and chroma were chosen within sRGB.
constexpr std::size_t kAnchors = 5;
struct Ramp {
  struct Anchor {
    double chroma;
    double hue_deg;
  };
  double darkest, brightest;  // L of Oklab
  std::array<Anchor, kAnchors> anchors;
};
constexpr Ramp kErrorRamp{0.12, 0.97, {{{0.03, 285}, {0.15, 300}, {0.19, 360}, {0.155, 410}, {0.06, 465}}}};
constexpr Ramp kQuantityRamp{0.26, 0.93, {{{0.115, 315}, {0.115, 265}, {0.09, 205}, {0.13, 155}, {0.16, 105}}}};

glm::dvec3 linear_from_oklab(double lightness, double a, double b) {
  const double l = lightness + 0.3963377774 * a + 0.2158037573 * b;
  const double m = lightness - 0.1055613458 * a - 0.0638541728 * b;
  const double s = lightness - 0.0894841775 * a - 1.2914855480 * b;
  const glm::dvec3 lms(l * l * l, m * m * m, s * s * s);
  return {4.0767416621 * lms.x - 3.3077115913 * lms.y + 0.2309699292 * lms.z,
          -1.2684380046 * lms.x + 2.6097574011 * lms.y - 0.3413193965 * lms.z,
          -0.0041960863 * lms.x - 0.7034186147 * lms.y + 1.7076147010 * lms.z};
}

Rgb8 rgb8_from_oklab(double lightness, double chroma, double hue_deg) {
  const double hue = glm::radians(hue_deg);
  const glm::dvec3 linear = linear_from_oklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
  return {srgb8_from_linear(linear.r), srgb8_from_linear(linear.g), srgb8_from_linear(linear.b)};
}

Rgb8 color_on(const Ramp& ramp, double part) {
  const double place = (part > 0 ? std::min(part, 1.0) : 0.0) * (kAnchors - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kAnchors - 2);
  const double rest = place - static_cast<double>(below);
  const Ramp::Anchor& from = ramp.anchors[below];
  const Ramp::Anchor& to = ramp.anchors[below + 1];
  return rgb8_from_oklab(std::lerp(ramp.darkest, ramp.brightest, place / (kAnchors - 1)),
                         std::lerp(from.chroma, to.chroma, rest), std::lerp(from.hue_deg, to.hue_deg, rest));
}

}  // namespace

Rgb8 error_ramp(double part) {
  return color_on(kErrorRamp, part);
}

Rgb8 quantity_ramp(double part) {
  return color_on(kQuantityRamp, part);
}

// Each hue is a golden section of the circle beyond the last, so that any run of them is spread out; three lightnesses
// by turns keep apart what hue alone does not.
Rgb8 distinct_color(std::uint32_t number) {
  constexpr double kGoldenAngle = 137.50776405003785;  // degrees
  constexpr std::array<double, 3> kLightness = {0.72, 0.55, 0.86};
  return rgb8_from_oklab(kLightness[number % kLightness.size()], 0.085, std::fmod(kGoldenAngle * number + 30, 360.0));
}

}  // namespace lumatlas
