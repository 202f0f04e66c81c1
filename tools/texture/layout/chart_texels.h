// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the point of the surface that each texel of a chart shows.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "mesh/base/id.h"
#include "mesh/mesh.h"
#include "tools/texture/layout/texture_layout.h"

namespace lumatlas {

// A texel whose middle lies on a face shows that place of it; within kReach texels of the chart it shows the nearest
// place of the chart, so that sampling between texels goes on smoothly up to the chart's outline.
struct ChartTexel {
  FaceId face;                     // FaceId::none: it shows nothing
  float share_b = 0, share_c = 0;  // shares of the face's second and third corner; that of the first is the rest
  float distance = 0;              // from the place, texels; 0: the middle lies on the face

  static constexpr double kReach = 1.5;
};

// Row by row from the top left of the chart's rectangle.
[[nodiscard]] std::vector<ChartTexel> chart_texels(const Mesh& mesh, const Chart& chart, const ChartPlace& place,
                                                   const TextureLayout& layout);

}  // namespace lumatlas
