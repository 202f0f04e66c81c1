// SPDX-License-Identifier: GPL-3.0-or-later
// Pinhole views that are cut out of full panoramas.
//
// The panorama's camera looks along z with x to the right and y down. Columns are longitude, from -180 degrees at the
// left over 0 in the middle, where z is, to 180; rows are latitude, from 90 degrees at the top, where -y is. COLMAP's
// EQUIRECTANGULAR, nerfstudio, Metashape and OpenSfM have the same.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// The panorama that a view is cut out of.
struct PanoramaFace {
  ImageSize size;                      // the panorama's, pixels
  glm::dmat3 panorama_from_view{1.0};  // rotates directions of the view's camera into the panorama's
};

// Returns the place, in pixels with (0, 0) at the picture's corner, at which a panorama of this size shows a direction.
// The direction is in the panorama's camera frame and has any length but 0.
[[nodiscard]] glm::dvec2 place_in_panorama(const ImageSize& size, const glm::dvec3& direction);

// Returns the picture that the pinhole camera `view` takes of the panorama, interpolated bilinearly; the pose of `view`
// does not matter. A pixel that shows a masked pixel of the panorama is invalid. Throws std::invalid_argument if the
// panorama has another size than the face says.
[[nodiscard]] Photograph view_of_panorama(const Photograph& panorama, const PanoramaFace& face, const Camera& view);

}  // namespace lumatlas
