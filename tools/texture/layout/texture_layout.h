// SPDX-License-Identifier: GPL-3.0-or-later
// The place of each chart in a texture of one or more square pages.
//
// Texture coordinates are texels from a page's top left corner; the middle of the first texel is at (0.5, 0.5). Around
// each chart is a gutter, so that sampling, and coarser levels of the texture, do not show its neighbours.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/mesh.h"
#include "tools/texture/layout/charts.h"

namespace lumatlas {

// Thrown by lay_out() where the charts do not fit even as points.
class ChartsDoNotFit : public InputError {
 public:
  using InputError::InputError;
};

struct LayoutOptions {
  std::uint32_t most_side_px =
      8192;                      // a page's longest side, texels, [64, 16384]; every viewer takes 4096, nearly all 8192
  std::uint32_t most_pages = 1;  // [1, 64]
  // Texels around a chart, so that log2 of it coarser levels show nothing else. [1, 64]
  std::uint32_t gutter_px = 4;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const LayoutOptions& options);

// A chart's rectangle, with its gutter: texels of one page.
struct ChartPlace {
  std::uint32_t page = 0;
  std::uint32_t x = 0, y = 0;  // its top left corner
  std::uint32_t width = 0, height = 0;
  double density = 0;  // texels per scene unit
};

struct TextureLayout {
  std::uint32_t side_px = 0;  // every page's side
  std::uint32_t pages = 0;
  std::uint32_t gutter_px = 0;
  // The share of the requested densities that was reached, (0, 1]: below 1 where the pages bound them. Charts that are
  // longer than a page are coarser than this.
  double scale = 1;
  std::vector<ChartPlace> places;  // one per chart

  // Returns a point of that chart in texels of its rectangle. Add the rectangle's corner for texels of the page.
  [[nodiscard]] glm::dvec2 in_rectangle(const Chart& chart, const ChartPlace& place, const glm::dvec3& point) const;
  // The same of the page, as floats from 0 to 1 over its side.
  [[nodiscard]] glm::vec2 uv(const Chart& chart, const ChartPlace& place, const glm::dvec3& point) const;
};

// Each chart with the density that is wanted for it (texels per scene unit, > 0, one per chart), or as many as a page
// has for its longer side; all by one factor less where the pages are too few. Pages are no larger than needed.
// Rectangles do not overlap. Throws std::invalid_argument for bad options or densities, ChartsDoNotFit.
[[nodiscard]] TextureLayout lay_out(std::span<const Chart> charts, std::span<const double> densities,
                                    const LayoutOptions& options);

}  // namespace lumatlas
