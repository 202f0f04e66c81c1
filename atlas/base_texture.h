// SPDX-License-Identifier: GPL-3.0-or-later
// The texture that a model shows to programs that do not know its extension: one image, and the place of each face in
// it. The renderer has the photographs and does not use it.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

// For each face the corners' places: shares of the image's sides from the top left.
using TexturePlaces = std::vector<std::array<glm::vec2, 3>>;

struct BaseTexture {
  Photograph image;    // sRGB
  ImageCoding coding;  // how the image is coded in a file
  TexturePlaces faces;
};

// Throws std::invalid_argument if the image cannot be coded so, or if one of the `faces` faces does not lie inside it.
void check(const BaseTexture& texture, std::size_t faces);

}  // namespace lumatlas
