// SPDX-License-Identifier: GPL-3.0-or-later
// The size at which a program measured photographs, for forms that do not state it.
//
// Focal lengths are in pixels of the photographs as the program saw them. People keep photographs at a smaller size
// beside such a file; only the measurements of points in them, in the same pixels, then tell that these were larger.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// The extent of measurements of points in one photograph, in pixels of its form. Without any, `least` is above `most`.
struct MeasuredExtent {
  double least_x = 1e300, most_x = -1e300;
  double least_y = 1e300, most_y = -1e300;

  void add(double x, double y);  // ignored unless both are finite
  [[nodiscard]] bool empty() const { return least_x > most_x; }
};

// Returns how many times as wide and as high as the photographs the measured ones were. It is 1, or a whole number up
// to 8 if measurements do not fit into photographs of `sizes` but reach to within 4% of the rim of photographs that are
// larger by this factor. Both lists have one entry per photograph. Measurements are from the middle of the photograph,
// or from its corner if none is negative. Throws InputError that begins with `path` if there is no such number.
[[nodiscard]] std::uint32_t measured_scale(const std::vector<MeasuredExtent>& extents,
                                           const std::vector<ImageSize>& sizes, const std::filesystem::path& path);

// Returns the sentence for Capture::notes that states the assumption of measured_scale().
[[nodiscard]] std::string measured_scale_note(std::uint32_t scale, const std::filesystem::path& path);

}  // namespace lumatlas
