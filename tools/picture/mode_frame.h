// SPDX-License-Identifier: GPL-3.0-or-later
// The pictures of `lumatlas render --mode` other than colours, pixel by pixel: a number, or why there is none. Paper
// Fig. 1, 7 and 14.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/images/float_image.h"
#include "atlas/images/photograph.h"
#include "blend/diagnosis.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

enum class Mode {
  picture,
  coverage,     // the cell's coverage, by the measure that the views were chosen by
  references,   // how many views the cell refers to
  valid_views,  // how many of those are valid at the pixel
  winner,       // which one weighs most: its slot
  weights,      // the shares of the three best
  trust,        // shift by the surface's deviation, seen from kTrustAngle degrees beside: pixels
  cells,        // number of the cell
  depth,        // z
  error,        // against a photograph: root mean square over R, G and B of the sRGB differences, 8-bit levels
};

inline const std::array<std::pair<std::string, Mode>, 10> kModesByName{{{"picture", Mode::picture},
                                                                        {"coverage", Mode::coverage},
                                                                        {"references", Mode::references},
                                                                        {"valid-views", Mode::valid_views},
                                                                        {"winner", Mode::winner},
                                                                        {"weights", Mode::weights},
                                                                        {"trust", Mode::trust},
                                                                        {"cells", Mode::cells},
                                                                        {"depth", Mode::depth},
                                                                        {"error", Mode::error}}};

// Tells whether a pixel has a number, and if not, why (paper Fig. 1 keeps unseen and untextured apart).
enum class PixelMark : std::uint8_t {
  number,
  no_surface,
  unseen,      // no view that was ever offered saw the cell
  untextured,  // a view saw the cell, but no stored one shows it here
  not_scored,  // outside of what validation counts
};

// Row by row from the top left.
struct ModeFrame {
  std::uint32_t width = 0;       // pixels
  std::uint32_t height = 0;      // pixels
  std::uint32_t channels = 1;    // numbers per pixel
  std::vector<float> values;     // width * height * channels; of a pixel without a number: 0
  std::vector<PixelMark> marks;  // width * height
};

// `value_of_cell` has one entry per cell of the snapshot. With `always`, cells that were never seen, or that refer to
// no view, have their number too. Throws std::invalid_argument for another count.
[[nodiscard]] ModeFrame cell_frame(const VisibilityBuffer& visible, const Snapshot& snapshot,
                                   std::span<const float> value_of_cell, bool always);

// Returns how many views each cell refers to.
[[nodiscard]] std::vector<float> reference_counts(const Snapshot& snapshot);

[[nodiscard]] ModeFrame depth_frame(const VisibilityBuffer& visible);

// Mode::trust. `visible` is what `camera` sees of the near surface. The snapshot must have cell_deviation.
[[nodiscard]] ModeFrame trust_frame(const VisibilityBuffer& visible, const Snapshot& snapshot, const Camera& camera);

// Mode::valid_views, winner or weights; std::invalid_argument for another.
[[nodiscard]] ModeFrame diagnosis_frame(const Diagnosis& diagnosis, Mode mode);

// `mask` and what is scored: as in scores.h, which says what is thrown.
[[nodiscard]] ModeFrame error_frame(const Photograph& rendering, const Photograph& photograph,
                                    std::span<const std::uint8_t> mask);

// The numbers as they are, NaN where there are none.
[[nodiscard]] FloatImage float_image(const ModeFrame& frame, Mode mode);

}  // namespace lumatlas
