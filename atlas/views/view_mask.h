// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a stored view that depends on the surface: what its camera sees there, and which of its pixels may be
// shown.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "atlas/images/pixel_list.h"
#include "atlas/images/stored_photograph.h"
#include "atlas/views/validity.h"

namespace lumatlas {

// All lists are row by row from the top left and have one value per pixel of the camera's image.
struct ViewMask {
  PixelList<float> depth;            // z in the camera frame, scene units; infinity where no surface is
  PixelList<std::uint8_t> trust;     // 255 trusted, 0 contradicted by the other views; empty: all are trusted
  PixelList<std::uint8_t> validity;  // see validity_mask()
  PixelList<std::uint8_t> rim;       // see rim_pixels(); empty: no pixel is at a rim

  [[nodiscard]] bool at_rim(std::size_t pixel) const { return !rim.empty() && rim[pixel] != 0; }
  // Returns the bytes that the lists take.
  [[nodiscard]] std::size_t bytes() const { return depth.bytes() + trust.bytes() + validity.bytes() + rim.bytes(); }
};

// Returns the mask of a photograph whose camera sees these depths. Throws as validity_mask() does.
[[nodiscard]] std::shared_ptr<const ViewMask> make_view_mask(const StoredPhotograph& photograph,
                                                             std::vector<float> depth, std::vector<std::uint8_t> trust,
                                                             const ValidityOptions& options);

}  // namespace lumatlas
