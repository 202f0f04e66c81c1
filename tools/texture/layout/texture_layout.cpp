// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/texture_layout.h"

#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_rect_pack.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Sides of rectangles are multiples of this, and so are those of pages: the first coarser levels of a texture then
// begin and end with a chart.
constexpr std::uint32_t kGrid = 4;
constexpr std::uint32_t kPageGrid = 64;

std::uint32_t rounded_up(double texels, std::uint32_t unit) {
  return (static_cast<std::uint32_t>(std::ceil(texels)) + unit - 1) / unit * unit;
}

void require_within(const char* field, std::uint32_t value, std::uint32_t least, std::uint32_t most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(std::string("texture: ") + field + " is " + std::to_string(value) + ", must be in [" +
                              std::to_string(least) + ", " + std::to_string(most) + "]");
}

// Half a texel on either side keeps a chart's outline between the middles of its outermost texels. A chart that is
// longer than a page becomes coarser by itself: one stray vertex shall not make all others as coarse.
std::vector<ChartPlace> rectangles(std::span<const Chart> charts, std::span<const double> densities, double scale,
                                   std::uint32_t gutter_px, std::uint32_t most_side_px) {
  const double most_texels = std::max(most_side_px - 2.0 - 2.0 * gutter_px, 1.0);
  std::vector<ChartPlace> places(charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    places[i].density = std::min(scale * densities[i], most_texels / std::max(charts[i].size.x, charts[i].size.y));
    const glm::dvec2 texels = places[i].density * charts[i].size + 1.0 + 2.0 * gutter_px;
    places[i].width = rounded_up(std::min(texels.x, 1e6), kGrid);
    places[i].height = rounded_up(std::min(texels.y, 1e6), kGrid);
  }
  return places;
}

// Packs what fits on one page of those that have no page yet.
void pack_page(std::vector<ChartPlace>& places, std::vector<stbrp_rect>& left, std::uint32_t page,
               std::uint32_t side_px) {
  const int side = static_cast<int>(side_px / kGrid);
  std::vector<stbrp_node> nodes(static_cast<std::size_t>(side));
  stbrp_context context;
  stbrp_init_target(&context, side, side, nodes.data(), side);
  stbrp_pack_rects(&context, left.data(), static_cast<int>(left.size()));
  for (const stbrp_rect& rect : left) {
    if (!rect.was_packed) continue;
    ChartPlace& place = places[static_cast<std::size_t>(rect.id)];
    place.page = page;
    place.x = static_cast<std::uint32_t>(rect.x) * kGrid;
    place.y = static_cast<std::uint32_t>(rect.y) * kGrid;
  }
  std::erase_if(left, [](const stbrp_rect& rect) { return rect.was_packed != 0; });
}

// Returns how many pages are needed, 0 if more than `most_pages`.
std::uint32_t pack(std::vector<ChartPlace>& places, std::uint32_t side_px, std::uint32_t most_pages) {
  std::vector<stbrp_rect> left(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].width > side_px || places[i].height > side_px) return 0;
    left[i].id = static_cast<int>(i);
    left[i].w = static_cast<stbrp_coord>(places[i].width / kGrid);
    left[i].h = static_cast<stbrp_coord>(places[i].height / kGrid);
  }
  for (std::uint32_t page = 0; page < most_pages; ++page) {
    pack_page(places, left, page, side_px);
    if (left.empty()) return page + 1;
  }
  return 0;
}

double texels_of(std::span<const ChartPlace> places) {
  double texels = 0;
  for (const ChartPlace& place : places) texels += static_cast<double>(place.width) * place.height;
  return texels;
}

// The smallest single page that takes them all, up to the largest one.
std::uint32_t pack_one_small_page(std::vector<ChartPlace>& places, std::uint32_t most_side_px) {
  std::uint32_t side_px = std::max(kPageGrid, rounded_up(std::sqrt(texels_of(places)), kPageGrid));
  for (; side_px <= most_side_px; side_px = std::max(side_px + kPageGrid, rounded_up(1.02 * side_px, kPageGrid))) {
    if (pack(places, side_px, 1) == 1) return side_px;
  }
  return 0;
}

}  // namespace

void check(const LayoutOptions& options) {
  require_within("most_side_px", options.most_side_px, 64, 16384);
  require_within("most_pages", options.most_pages, 1, 64);
  require_within("gutter_px", options.gutter_px, 1, 64);
}

glm::dvec2 TextureLayout::in_rectangle(const Chart& chart, const ChartPlace& place, const glm::dvec3& point) const {
  return place.density * chart.place(point) + 0.5 + static_cast<double>(gutter_px);
}

glm::vec2 TextureLayout::uv(const Chart& chart, const ChartPlace& place, const glm::dvec3& point) const {
  return glm::vec2((in_rectangle(chart, place, point) + glm::dvec2(place.x, place.y)) / static_cast<double>(side_px));
}

TextureLayout lay_out(std::span<const Chart> charts, std::span<const double> densities, const LayoutOptions& options) {
  check(options);
  if (densities.size() != charts.size()) {
    throw std::invalid_argument("texture: " + std::to_string(densities.size()) +
                                " densities, must be one for each of " + std::to_string(charts.size()) + " charts");
  }
  for (std::size_t i = 0; i < densities.size(); ++i) {
    if (densities[i] > 0 && std::isfinite(densities[i])) continue;
    throw std::invalid_argument("texture: density " + std::to_string(i) + " is " + number_text(densities[i]) +
                                ", must be finite and above 0");
  }
  constexpr double kLeastScale = 1e-9;
  const std::uint32_t most_side_px = options.most_side_px / kPageGrid * kPageGrid;
  const double room = static_cast<double>(options.most_pages) * most_side_px * most_side_px;
  TextureLayout layout;
  layout.gutter_px = options.gutter_px;
  for (layout.scale = 1; layout.scale > kLeastScale;) {
    layout.places = rectangles(charts, densities, layout.scale, options.gutter_px, most_side_px);
    layout.side_px = pack_one_small_page(layout.places, most_side_px);
    layout.pages = 1;
    if (layout.side_px > 0) return layout;
    layout.side_px = most_side_px;
    layout.pages = pack(layout.places, most_side_px, options.most_pages);
    if (layout.pages > 0) return layout;
    layout.scale *= std::clamp(std::sqrt(0.95 * room / texels_of(layout.places)), 0.1, 0.97);
  }
  throw ChartsDoNotFit("the surface has " + std::to_string(charts.size()) + " charts, which do not fit on " +
                       std::to_string(options.most_pages) + " pages of " + std::to_string(options.most_side_px) +
                       " texels a side, however coarse: allow larger ones or more (--texture, --pages)");
}

}  // namespace lumatlas
