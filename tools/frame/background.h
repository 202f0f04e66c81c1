// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the background where the model has no surface, and fades the surface's end: within a hundredth of the picture's
// longer side it becomes transparent, so that no hard edge shows where only the mesh ends.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "atlas/images/float_image.h"
#include "atlas/images/photograph.h"
#include "blend/rendering.h"

namespace lumatlas {

struct Background {
  enum class Kind {
    // The colours of the surface beside it, the further away the more blurred. Colours that no photograph shows count
    // for a hundredth.
    blurred,
    transparent,  // alpha tells
    plain,        // one colour
  };
  Kind kind = Kind::blurred;
  std::array<std::uint8_t, 3> color{};  // for plain, sRGB
};

// "alpha", "blur", "black", "white" or "#rrggbb"; none for any other name.
[[nodiscard]] std::optional<Background> background_named(const std::string& name);

// Returns for each pixel, row by row, 0 where there is no surface, rising to 1 with the distance in pixels to the
// nearest such pixel. The surface is taken to go on beyond the picture. Throws std::invalid_argument unless there is a
// state for each pixel.
[[nodiscard]] std::vector<float> soft_coverage(const std::vector<PixelState>& state, std::uint32_t width,
                                               std::uint32_t height);

// A picture whose alpha is not multiplied into the colours. Colours of transparent pixels are blurred from their
// neighbours'.
struct SoftPicture {
  Photograph picture;
  std::vector<std::uint8_t> alpha;  // 255 is opaque; empty: all of it is
};
[[nodiscard]] SoftPicture with_background(const Rendering& rendering, const Background& background);

// Linear light; with alpha, A, which is multiplied into the colours as OpenEXR has it, if the background is
// transparent.
[[nodiscard]] FloatImage with_background(const LinearRendering& rendering, const Background& background);

}  // namespace lumatlas
