// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/files/color_profile.h"

#include <lcms2.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <type_traits>

namespace lumatlas {

namespace {

constexpr cmsUInt32Number kRendering = INTENT_RELATIVE_COLORIMETRIC;
// Black stays black. Nothing is remembered from one pixel to the next, so that threads may share what is made.
constexpr cmsUInt32Number kConversion = cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_NOCACHE;

using Context = std::unique_ptr<std::remove_pointer_t<cmsContext>, decltype(&cmsDeleteContext)>;
using Profile = std::unique_ptr<void, decltype(&cmsCloseProfile)>;
using ToneCurve = std::unique_ptr<cmsToneCurve, decltype(&cmsFreeToneCurve)>;
using Transform = std::unique_ptr<void, decltype(&cmsDeleteTransform)>;

Transform to_srgb(cmsContext context, cmsHPROFILE from, cmsUInt32Number format) {
  const Profile srgb(cmsCreate_sRGBProfileTHR(context), cmsCloseProfile);
  cmsHTRANSFORM made =
      srgb ? cmsCreateTransformTHR(context, from, format, srgb.get(), TYPE_RGB_8, kRendering, kConversion) : nullptr;
  return {made, cmsDeleteTransform};
}

// Returns whether the transform moves no colour of a grid by more than two levels, which is what rounding does.
bool changes_nothing(cmsHTRANSFORM transform) {
  constexpr int kSteps = 9, kMostRounding = 2;
  std::vector<std::uint8_t> grid;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    for (const int level : {i % kSteps, i / kSteps % kSteps, i / kSteps / kSteps}) {
      grid.push_back(static_cast<std::uint8_t>(255 * level / (kSteps - 1)));
    }
  }
  std::vector<std::uint8_t> moved(grid.size());
  cmsDoTransform(transform, grid.data(), moved.data(), static_cast<cmsUInt32Number>(grid.size() / 3));
  return std::equal(grid.begin(), grid.end(), moved.begin(),
                    [](int a, int b) { return std::abs(a - b) <= kMostRounding; });
}

void convert_color(cmsContext context, cmsHPROFILE profile, std::vector<std::uint8_t>& rgb) {
  constexpr std::size_t kAtOnce = 3 << 20;  // the library counts in 32 bits
  const Transform transform = to_srgb(context, profile, TYPE_RGB_8);
  if (!transform || changes_nothing(transform.get())) return;
  for (std::size_t at = 0; at < rgb.size(); at += kAtOnce) {
    const std::size_t bytes = std::min(kAtOnce, rgb.size() - at);
    cmsDoTransform(transform.get(), &rgb[at], &rgb[at], static_cast<cmsUInt32Number>(bytes / 3));
  }
}

bool is_grey(const std::vector<std::uint8_t>& rgb) {
  for (std::size_t at = 0; at + 2 < rgb.size(); at += 3) {
    if (rgb[at] != rgb[at + 1] || rgb[at] != rgb[at + 2]) return false;
  }
  return true;
}

void convert_grey(cmsContext context, cmsHPROFILE profile, std::vector<std::uint8_t>& rgb) {
  if (!is_grey(rgb)) return;  // the profile does not belong to this picture
  const Transform transform = to_srgb(context, profile, TYPE_GRAY_8);
  if (!transform) return;
  std::array<std::uint8_t, 256> levels;
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<std::uint8_t>(i);
  std::array<std::uint8_t, 3 * levels.size()> colors;
  cmsDoTransform(transform.get(), levels.data(), colors.data(), static_cast<cmsUInt32Number>(levels.size()));
  for (std::size_t at = 0; at + 2 < rgb.size(); at += 3) std::copy_n(&colors[std::size_t{3} * rgb[at]], 3, &rgb[at]);
}

// The signature of the colours that the profile is for (ICC.1:2010, table 17). cmsGetColorSpace() returns it as an
// enumeration, although a file may hold any number there. 0: the profile is cut off.
std::uint32_t color_space_of(std::span<const std::uint8_t> profile) {
  constexpr std::size_t kAt = 16;
  if (profile.size() < kAt + 4) return 0;
  std::uint32_t signature = 0;
  for (std::size_t i = 0; i < 4; ++i) signature = signature << 8U | profile[kAt + i];
  return signature;
}

}  // namespace

void convert_to_srgb(std::span<const std::uint8_t> profile, std::vector<std::uint8_t>& rgb) {
  const Context context(cmsCreateContext(nullptr, nullptr), cmsDeleteContext);
  if (!context) return;
  const Profile from(
      cmsOpenProfileFromMemTHR(context.get(), profile.data(), static_cast<cmsUInt32Number>(profile.size())),
      cmsCloseProfile);
  if (!from) return;
  const std::uint32_t space = color_space_of(profile);
  if (space == cmsSigRgbData) convert_color(context.get(), from.get(), rgb);
  if (space == cmsSigGrayData) convert_grey(context.get(), from.get(), rgb);
}

std::vector<std::uint8_t> profile_of(const Primaries& primaries) {
  constexpr std::array kSrgbCurve{2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};  // IEC 61966-2-1, type 4 of lcms
  const Context context(cmsCreateContext(nullptr, nullptr), cmsDeleteContext);
  if (!context) return {};
  const ToneCurve curve(cmsBuildParametricToneCurve(context.get(), 4, kSrgbCurve.data()), cmsFreeToneCurve);
  const auto color = [](const Chromaticity& c) { return cmsCIExyY{c.x, c.y, 1}; };
  const cmsCIExyY white = color(primaries.white);
  const cmsCIExyYTRIPLE corners{color(primaries.red), color(primaries.green), color(primaries.blue)};
  const std::array<cmsToneCurve*, 3> curves{curve.get(), curve.get(), curve.get()};
  if (!curve) return {};
  const Profile profile(cmsCreateRGBProfileTHR(context.get(), &white, &corners, curves.data()), cmsCloseProfile);
  cmsUInt32Number size = 0;
  if (!profile || !cmsSaveProfileToMem(profile.get(), nullptr, &size)) return {};
  std::vector<std::uint8_t> bytes(size);
  return cmsSaveProfileToMem(profile.get(), bytes.data(), &size) ? bytes : std::vector<std::uint8_t>();
}

}  // namespace lumatlas
