// SPDX-License-Identifier: GPL-3.0-or-later
// What a model shows to programs that do not know its extension: one image, and where in it each face lies. The
// renderer has the photographs and does not look at it.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

struct BaseTexture {
  Photograph image;                             // sRGB
  ImageCoding coding;                           // of the image in a file
  std::vector<std::array<glm::vec2, 3>> faces;  // of each, its corners: shares of the image's sides from the top left
};

// Throws std::invalid_argument unless there is an image that can be coded so, and each of so many faces lies inside.
void check(const BaseTexture& texture, std::size_t faces);

}  // namespace lumatlas
