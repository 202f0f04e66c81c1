// SPDX-License-Identifier: GPL-3.0-or-later
// A mode's numbers as colours, and the colour bar that says what they mean.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/picture/color_bar.h"
#include "tools/picture/mode_frame.h"

namespace lumatlas {

// Numbers below and above have the colours of the ends.
struct ValueRange {
  double least = 0;
  double most = 1;
};

// Colours of all frames of a run, so that they can be compared.
class ModeColors {
 public:
  // Without a range, the mode has its own. Coverage goes from 0 to 1, or to the best cell's if that is more. References
  // and valid views go from 0 to the most references of a cell. Depth goes from 0 to the depth that 98 % of the stored
  // views' pixels stay below. Error goes from 0 to kErrorFullScale. Throws std::invalid_argument for Mode::picture, for
  // a range that is empty or not finite, and for one where the mode has none (see has_range()).
  ModeColors(const Snapshot& snapshot, Mode mode, const std::optional<ValueRange>& range);

  [[nodiscard]] Photograph paint(const ModeFrame& frame) const;
  [[nodiscard]] const ColorBar& bar() const { return bar_; }

 private:
  [[nodiscard]] Rgb8 color(const float* values) const;

  Mode mode_;
  ColorBar bar_;
  std::vector<Rgb8> ramp_;  // the scale's colours in equal steps
};

[[nodiscard]] bool has_range(Mode mode);

}  // namespace lumatlas
