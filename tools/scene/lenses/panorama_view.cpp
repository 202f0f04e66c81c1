// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/lenses/panorama_view.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mesh/base/number_text.h"
#include "tools/scene/lenses/resampling.h"

namespace lumatlas {

glm::dvec2 place_in_panorama(const ImageSize& size, const glm::dvec3& direction) {
  const double longitude = std::atan2(direction.x, direction.z);
  const double latitude = std::atan2(-direction.y, std::hypot(direction.x, direction.z));
  return {(0.5 + longitude / (2 * std::numbers::pi)) * size.width, (0.5 - latitude / std::numbers::pi) * size.height};
}

Photograph view_of_panorama(const Photograph& panorama, const PanoramaFace& face, const Camera& view) {
  if (panorama.width != face.size.width || panorama.height != face.size.height) {
    throw std::invalid_argument("view of a panorama: the panorama is " + size_text(panorama.width, panorama.height) +
                                ", must be " + size_text(face.size.width, face.size.height));
  }
  const std::size_t pixels = std::size_t{view.width} * view.height;
  Photograph out{view.width, view.height, std::vector<std::uint8_t>(3 * pixels), std::vector<std::uint8_t>(pixels)};
  tbb::parallel_for(std::uint32_t{0}, view.height, [&](std::uint32_t row) {
    for (std::uint32_t column = 0; column < view.width; ++column) {
      const glm::dvec3 direction((column + 0.5 - view.cx) / view.fx, (row + 0.5 - view.cy) / view.fy, 1);
      const glm::dvec2 place = place_in_panorama(face.size, face.panorama_from_view * direction);
      const std::size_t pixel = std::size_t{row} * view.width + column;
      if (resample(panorama, place, AtEdges::wrap, &out.rgb[3 * pixel])) out.valid[pixel] = 255;
    }
  });
  if (std::find(out.valid.begin(), out.valid.end(), 0) == out.valid.end()) out.valid.clear();
  return out;
}

}  // namespace lumatlas
