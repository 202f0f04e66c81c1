// SPDX-License-Identifier: GPL-3.0-or-later
// A photograph with what its camera sees of the surface: f = (c, e, z) of Erat et al. 2019, section 3.1. Its exposure
// gain is the store's, for gains are found for all views together and change while the views stay.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/validity.h"
#include "mesh/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// All lists are row by row from the top left and have one value per pixel of the camera's image.
struct StoredView {
  std::string name;
  Camera camera;
  Photograph photograph;
  std::vector<float> depth;            // z in the camera frame, scene units; infinity where no surface is
  std::vector<std::uint8_t> trust;     // 255 trusted, 0 contradicted by the other views; empty: all are trusted
  std::vector<std::uint8_t> validity;  // see validity_mask()
  std::vector<std::uint8_t> rim;       // see rim_pixels(); empty: no pixel is at a rim

  [[nodiscard]] bool at_rim(std::size_t pixel) const { return !rim.empty() && rim[pixel] != 0; }
};

// Throws std::invalid_argument, naming the view, the list and its size, unless the photograph is as large as its camera
// says, `rgb` has three values per pixel, and `valid` has one per pixel or none.
void require_photograph_of(const std::string& view, const Camera& camera, const Photograph& photograph);

// Throws std::invalid_argument, naming the view, unless the camera passes check(), the photograph fits it as above, and
// every list has one value per pixel (`trust` and `rim`: or none).
void check(const StoredView& view);

// Returns the median of the view's depths that are smaller than `below`, from every 16th pixel that has one; scene
// units, 0 if none has.
[[nodiscard]] float median_depth(const StoredView& view, float below = std::numeric_limits<float>::infinity());

// Completes a view with its depth and its mask. `visible` is what the camera sees at its own resolution. Throws
// std::invalid_argument unless camera, photograph, `visible` and `trust` (as in StoredView) are of one size and the
// options pass check().
[[nodiscard]] StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph,
                                          VisibilityBuffer visible, const ValidityOptions& options,
                                          std::vector<std::uint8_t> trust = {});

}  // namespace lumatlas
