// SPDX-License-Identifier: GPL-3.0-or-later
// A photograph with what its camera sees of the surface: f = (c, e, z) of Erat et al. 2019, section 3.1. Its exposure
// gain is the store's, for gains are found for all views together and change while the views stay.
//
// A view has three parts: the photograph, the state (name and camera), and the mask. Views share photographs and masks,
// which never change once they are in a view, so that a view with another pose is a copy of some hundred bytes.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/images/stored_photograph.h"
#include "atlas/views/validity.h"
#include "atlas/views/view_mask.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

struct StoredView {
  std::string name;
  Camera camera;
  std::shared_ptr<const StoredPhotograph> photograph;  // as large as the camera's image
  std::shared_ptr<const ViewMask> mask;                // as large as the camera's image
};

// Throws std::invalid_argument, naming the view, the list and its size, unless the photograph is as large as its camera
// says, `rgb` has three values per pixel, and `valid` has one per pixel or none.
void require_photograph_of(const std::string& view, const Camera& camera, const Photograph& photograph);
// The same of one that is stored, whose lists have been checked.
void require_photograph_of(const std::string& view, const Camera& camera, const StoredPhotograph& photograph);

// Throws std::invalid_argument, naming the view, the list and its size, unless every list of the mask has one value per
// pixel of the camera's image (`trust` and `rim`: or none).
void require_mask_of(const std::string& view, const Camera& camera, const ViewMask& mask);

// Throws std::invalid_argument, naming the view, unless the camera passes check() and there are a photograph and a mask
// that fit it as above. Looks at sizes, not at pixels.
void check(const StoredView& view);

// Returns the median of the view's depths that are smaller than `below`, from every 16th pixel that has one; scene
// units, 0 if none has.
[[nodiscard]] float median_depth(const StoredView& view, float below = std::numeric_limits<float>::infinity());

// Completes a view with its mask. `visible` is what the camera sees at its own resolution. Throws std::invalid_argument
// unless camera, photograph, `visible` and `trust` (as in ViewMask) are of one size and the options pass check().
[[nodiscard]] StoredView make_stored_view(std::string name, const Camera& camera,
                                          std::shared_ptr<const StoredPhotograph> photograph, VisibilityBuffer visible,
                                          const ValidityOptions& options, std::vector<std::uint8_t> trust = {});
// Makes the stored view of a photograph that no other view has.
[[nodiscard]] StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph,
                                          VisibilityBuffer visible, const ValidityOptions& options,
                                          std::vector<std::uint8_t> trust = {});

}  // namespace lumatlas
