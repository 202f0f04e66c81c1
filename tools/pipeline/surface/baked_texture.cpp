// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/baked_texture.h"

#include <chrono>

#include "tools/base/elapsed.h"
#include "tools/base/process/interrupt.h"
#include "tools/texture/textured_mesh.h"

namespace lumatlas {

namespace {

// Photographs are exact where they must be; this is a mean of them, which JPEG keeps in a tenth of PNG's bytes.
constexpr ImageCoding kCoding{ImageFormat::jpeg, 90};

// Baking takes most of its time for texels, and what stands in for photographs need not be as sharp as they are.
constexpr double kTexelsPerPixel = 0.5;

std::vector<std::array<glm::vec2, 3>> places_of(const TexturedMesh& textured) {
  const Mesh& mesh = textured.mesh();
  std::vector<std::array<glm::vec2, 3>> places(mesh.faces.size());
  for (std::size_t face = 0; face < places.size(); ++face) {
    const std::uint32_t chart = textured.chart_of_face()[face];
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 point(mesh.positions[mesh.faces[face][corner]]);
      places[face][static_cast<std::size_t>(corner)] =
          textured.layout().uv(textured.charts()[chart], textured.layout().places[chart], point);
    }
  }
  return places;
}

}  // namespace

BakedTexture bake_texture(const Snapshot& snapshot, std::uint32_t most_side_px, const BuildCallback& callback) {
  const auto start = std::chrono::steady_clock::now();
  BuildStage stage(callback, "baking the base texture", 0);
  TextureOptions options;
  options.layout.most_side_px = most_side_px;
  options.texels_per_pixel = kTexelsPerPixel;
  const TexturedMesh mesh(snapshot, options);
  stage.tick();
  BakedTexture baked;
  baked.texture.coding = kCoding;
  baked.texture.faces = places_of(mesh);
  baked.charts = mesh.charts().size();
  const auto keep = [&](std::uint32_t, const Photograph& page) { baked.texture.image = page; };
  baked.texels_per_pixel = mesh.bake(keep, throw_if_interrupted).texels_per_pixel;
  baked.bake_ms = ms_since(start);
  stage.finish();
  return baked;
}

}  // namespace lumatlas
