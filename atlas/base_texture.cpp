// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/base_texture.h"

#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

void check(const BaseTexture& texture, std::size_t faces) {
  check(texture.coding);
  const Photograph& image = texture.image;
  if (image.width == 0 || image.height == 0 || image.rgb.size() != std::size_t{3} * image.width * image.height) {
    throw std::invalid_argument("base texture: an image of " + size_text(image.width, image.height) + " with " +
                                std::to_string(image.rgb.size()) +
                                " bytes, must have three for each of at least one pixel");
  }
  if (texture.faces.size() != faces) {
    throw std::invalid_argument("base texture: has places for " + std::to_string(texture.faces.size()) +
                                " faces, must be for each of " + std::to_string(faces));
  }
  for (std::size_t face = 0; face < faces; ++face) {
    for (const glm::vec2& corner : texture.faces[face]) {
      if (corner.x >= 0 && corner.x <= 1 && corner.y >= 0 && corner.y <= 1) continue;
      throw std::invalid_argument("base texture: face " + std::to_string(face) + " has a corner at (" +
                                  number_text(corner.x) + ", " + number_text(corner.y) + "), must be in [0, 1]");
    }
  }
}

}  // namespace lumatlas
