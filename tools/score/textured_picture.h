// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of a textured mesh as a plain viewer draws it: the baseline of a conventional texture.
#pragma once

#include <memory>
#include <vector>

#include "blend/rendering.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "tools/texture/textured_mesh.h"

namespace lumatlas {

// Holds all pages with their coarser levels: four bytes a texel.
class TexturedPicture {
 public:
  // Bakes the texture. Keeps a reference to the mesh.
  explicit TexturedPicture(const TexturedMesh& mesh);

  // Each pixel is the mean, in linear light, of 2 x 2 samples; each of these lies between four texels of the two levels
  // whose texels are about as large as the sample ("trilinear"). No exposure is applied, and all that is not empty
  // counts as textured.
  [[nodiscard]] Rendering render(const Camera& camera) const;

  [[nodiscard]] const TextureFacts& facts() const { return facts_; }

 private:
  struct Level {
    std::uint32_t side = 0;
    std::vector<std::uint8_t> rgb;
  };
  [[nodiscard]] glm::vec3 sample(FaceId face, const glm::dvec3& point, double sample_size) const;
  static Level coarser(const Level& fine);
  static glm::vec3 between_texels(const Level& level, const glm::vec2& uv);

  const TexturedMesh& mesh_;
  std::unique_ptr<Visibility> visibility_;
  std::vector<std::vector<Level>> pages_;  // the levels of each page, the finest first
  TextureFacts facts_;
};

}  // namespace lumatlas
