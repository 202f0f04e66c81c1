// SPDX-License-Identifier: GPL-3.0-or-later
// NumPy arrays that Python gives, checked. Sentences name the argument, what it is and what it must be. All need
// Python's lock.
#pragma once

#include <pybind11/numpy.h>

#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"

namespace lumatlas::python {

// Returns the pixels of an array of uint8, of the camera's size: (height, width, 3), sRGB. Throws
// std::invalid_argument.
[[nodiscard]] Photograph photograph_of(const std::string& argument, const pybind11::handle& given,
                                       const Camera& camera);

// Returns the mask in an array of bool or uint8 of the camera's size, (height, width): black where pixels are not used,
// which are 0 or False in the array, white elsewhere. Throws std::invalid_argument.
[[nodiscard]] Photograph mask_picture(const std::string& argument, const pybind11::handle& given, const Camera& camera);

// Returns finite points of an array of numbers, (n, 3). Throws std::invalid_argument.
[[nodiscard]] std::vector<glm::dvec3> points_of(const std::string& argument, const pybind11::handle& given);

// Returns faces of an array of whole numbers, (n, 3), each below `vertices`. Throws std::invalid_argument.
[[nodiscard]] std::vector<glm::uvec3> triangles_of(const std::string& argument, const pybind11::handle& given,
                                                   std::size_t vertices);

// Throws std::invalid_argument for a name of a photograph that is empty or leads out of its folder.
void check_name(const std::string& argument, const std::string& name);

}  // namespace lumatlas::python
