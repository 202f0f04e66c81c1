// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photographs/measured_size.h"

#include <algorithm>
#include <cmath>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

void MeasuredExtent::add(double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y)) return;
  least_x = std::min(least_x, x);
  most_x = std::max(most_x, x);
  least_y = std::min(least_y, y);
  most_y = std::max(most_y, y);
}

std::uint32_t measured_scale(const std::vector<MeasuredExtent>& extents, const std::vector<ImageSize>& sizes,
                             const std::filesystem::path& path) {
  constexpr double kRim = 2;  // pixels that a measurement may lie outside of its photograph
  constexpr double kMostScale = 8, kLeastFilled = 0.96;
  const bool from_corner = std::all_of(extents.begin(), extents.end(), [](const MeasuredExtent& extent) {
    return extent.empty() || (extent.least_x >= 0 && extent.least_y >= 0);
  });
  double needed = 0, needed_width = 0;
  std::size_t widest = 0;  // the photograph that needs the most
  for (std::size_t i = 0; i < extents.size(); ++i) {
    if (extents[i].empty()) continue;
    const auto side = [&](double least, double most) {
      return (from_corner ? most : 2 * std::max(std::abs(least), std::abs(most))) - kRim;
    };
    const double width = side(extents[i].least_x, extents[i].most_x);
    const double height = side(extents[i].least_y, extents[i].most_y);
    const double scale = std::max(width / sizes[i].width, height / sizes[i].height);
    if (scale <= needed) continue;
    needed = scale;
    needed_width = width;
    widest = i;
  }
  if (needed <= 1) return 1;
  const double scale = std::ceil(needed);
  if (scale <= kMostScale && needed >= kLeastFilled * scale) return static_cast<std::uint32_t>(scale);
  throw InputError(path.string() + ": its points were measured in larger photographs: those in one of " +
                   size_text(sizes[widest].width, sizes[widest].height) + " pixels reach over " +
                   number_text(std::max(needed_width, 0.0), 0) + " pixels of its width, " + number_text(needed, 2) +
                   " times its size: give the photographs at the size that they had");
}

std::string measured_scale_note(std::uint32_t scale, const std::filesystem::path& path) {
  const std::string start = path.filename().string() + " does not state the size of the photographs: ";
  if (scale == 1) return start + "they are taken to have the size that its focal lengths are for";
  return start + "by where its points were measured, they are taken to be kept at 1/" + std::to_string(scale) +
         " of the size that its focal lengths are for";
}

}  // namespace lumatlas
