// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the legend of a picture below it: a title with the unit, a bar with its numbers, and names of single colours.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "tools/score/report/color_map.h"

namespace lumatlas {

// The numbers that a ramp stands for; least < most, both finite.
struct ColorScale {
  double least = 0;
  double most = 1;
  std::function<Rgb8(double part)> color;  // part is in [0, 1]
  bool whole = false;                      // only whole numbers are named
  bool open = false;                       // the last colour stands for larger values too: its number has a '+'
};

struct NamedColor {
  Rgb8 color;
  std::string name;
};

struct ColorBar {
  std::string title;
  std::optional<ColorScale> scale;
  std::vector<NamedColor> names;
};

// Returns round numbers (1, 2 or 5 times a power of ten apart) in [least, most], ascending: at most `count`, >= 2, and
// at least two if the range has them. With `whole` only whole numbers.
[[nodiscard]] std::vector<double> round_numbers(double least, double most, std::size_t count, bool whole);

// The picture with the bar below it. It keeps its pixels; where it is narrower than the bar needs, the rest on its
// right is background. Letters are larger on larger pictures, two pixels a dot at least. The size depends on the
// picture's size and the bar alone. Throws std::invalid_argument for a scale that is empty or not finite.
[[nodiscard]] Photograph with_color_bar(const Photograph& picture, const ColorBar& bar);

}  // namespace lumatlas
