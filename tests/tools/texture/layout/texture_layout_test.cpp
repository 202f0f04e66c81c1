// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/texture_layout.h"

#include <catch2/catch.hpp>
#include <random>

#include "mesh/base/errors.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/surfaces.h"
#include "tools/texture/layout/chart_texels.h"

namespace lumatlas {
namespace {

// Rectangles alone: what a layout looks at.
std::vector<Chart> charts_of_sizes(std::size_t count, double most, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(0, most);
  std::vector<Chart> charts(count);
  for (Chart& chart : charts) chart.size = {side(random), side(random)};
  return charts;
}

void check_layout(const std::vector<Chart>& charts, const TextureLayout& layout, const LayoutOptions& options) {
  REQUIRE(layout.places.size() == charts.size());
  CHECK(layout.side_px <= options.most_side_px);
  CHECK(layout.pages <= options.most_pages);
  CHECK(layout.pages >= 1);
  std::vector<std::uint8_t> taken(std::size_t{layout.pages} * layout.side_px * layout.side_px, 0);
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const ChartPlace& place = layout.places[i];
    REQUIRE(place.page < layout.pages);
    REQUIRE(place.x + place.width <= layout.side_px);
    REQUIRE(place.y + place.height <= layout.side_px);
    // Half a texel and the gutter on either side.
    REQUIRE(place.width >= place.density * charts[i].size.x + 1 + 2 * layout.gutter_px);
    REQUIRE(place.height >= place.density * charts[i].size.y + 1 + 2 * layout.gutter_px);
    for (std::uint32_t y = place.y; y < place.y + place.height; ++y) {
      for (std::uint32_t x = place.x; x < place.x + place.width; ++x) {
        REQUIRE(taken[(std::size_t{place.page} * layout.side_px + y) * layout.side_px + x]++ == 0);
      }
    }
  }
}

TEST_CASE("rectangles lie apart, on one page that is no larger than needed") {
  const std::vector<Chart> charts = charts_of_sizes(300, 2, 3);
  const std::vector<double> densities(charts.size(), 20.0);
  const TextureLayout layout = lay_out(charts, densities, {});
  check_layout(charts, layout, {});
  CHECK(layout.scale == 1);
  CHECK(layout.pages == 1);
  CHECK(layout.side_px % 64 == 0);
  double texels = 0;
  for (const ChartPlace& place : layout.places) texels += static_cast<double>(place.width) * place.height;
  CHECK(texels > 0.7 * layout.side_px * layout.side_px);
}

TEST_CASE("pages and their size bound the density, which falls no further than it must") {
  const std::vector<Chart> charts = charts_of_sizes(200, 2, 4);
  const std::vector<double> densities(charts.size(), 100.0);
  LayoutOptions options;
  options.most_side_px = 512;
  const TextureLayout one = lay_out(charts, densities, options);
  check_layout(charts, one, options);
  CHECK(one.side_px == 512);
  CHECK(one.scale < 0.3);
  options.most_pages = 4;
  const TextureLayout four = lay_out(charts, densities, options);
  check_layout(charts, four, options);
  CHECK(four.pages == 4);
  CHECK(four.scale > 1.7 * one.scale);
  for (std::size_t i = 0; i < charts.size(); ++i) {
    REQUIRE(four.places[i].density == Approx(four.scale * densities[i]));
  }
}

TEST_CASE("a chart that a stray vertex made long leaves the others their density") {
  std::vector<Chart> charts = charts_of_sizes(50, 2, 6);
  LayoutOptions options;
  options.most_side_px = 512;
  const std::vector<double> all(charts.size() + 1, 20.0);
  const double without = lay_out(charts, std::span(all).first(50), options).scale;
  charts.push_back({});
  charts.back().size = {1e4, 2};
  const TextureLayout layout = lay_out(charts, all, options);
  check_layout(charts, layout, options);
  CHECK(layout.scale > 0.9 * without);
  CHECK(layout.places.back().density * 1e4 > 400);
  CHECK(layout.places.front().density == Approx(20 * layout.scale));
}

TEST_CASE("charts that fit nowhere are refused with what to do") {
  const std::vector<Chart> charts = charts_of_sizes(100, 1, 5);
  LayoutOptions options;
  options.most_side_px = 64;
  CHECK_THROWS_WITH(lay_out(charts, std::vector<double>(100, 1.0), options),
                    Catch::Contains("100 charts") && Catch::Contains("1 pages of 64") && Catch::Contains("--texture"));
}

TEST_CASE("layouts refuse options and densities by name") {
  using Options = LayoutOptions;
  CHECK(refusal<Options>([](Options&) {}) == "accepted");
  CHECK(refusal<Options>([](Options& o) { o.most_side_px = 32; }) ==
        "texture: most_side_px is 32, must be in [64, 16384]");
  CHECK(refusal<Options>([](Options& o) { o.most_pages = 0; }) == "texture: most_pages is 0, must be in [1, 64]");
  CHECK(refusal<Options>([](Options& o) { o.gutter_px = 65; }) == "texture: gutter_px is 65, must be in [1, 64]");
  const std::vector<Chart> charts = charts_of_sizes(2, 1, 6);
  CHECK_THROWS_WITH(lay_out(charts, std::vector<double>{1}, {}),
                    "texture: 1 densities, must be one for each of 2 charts");
  CHECK_THROWS_WITH(lay_out(charts, std::vector<double>{1, 0}, {}),
                    "texture: density 1 is 0, must be finite and above 0");
}

TEST_CASE("every texel of a chart shows one face, at the place that its texture coordinates name") {
  const Mesh mesh = sphere(3);
  CellOptions cell_options;
  cell_options.size = 0.4;
  const std::vector<Chart> charts = make_charts(mesh, make_cells(mesh, cell_options));
  const TextureLayout layout = lay_out(charts, std::vector<double>(charts.size(), 50.0), {});
  double texels = 0, flat_area = 0;
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const ChartPlace& place = layout.places[i];
    const std::vector<ChartTexel> map = chart_texels(mesh, charts[i], place, layout);
    REQUIRE(map.size() == std::size_t{place.width} * place.height);
    for (std::size_t at = 0; at < map.size(); ++at) {
      const ChartTexel& texel = map[at];
      const std::size_t x = at % place.width, y = at / place.width;
      const bool in_gutter = x < layout.gutter_px || y < layout.gutter_px || x >= place.width - layout.gutter_px ||
                             y >= place.height - layout.gutter_px;
      if (texel.face == FaceId::none) continue;
      const glm::uvec3& f = mesh.faces[texel.face];
      const glm::dvec3 a(mesh.positions[f.x]), b(mesh.positions[f.y]), c(mesh.positions[f.z]);
      const double share_b = static_cast<double>(texel.share_b), share_c = static_cast<double>(texel.share_c);
      const glm::dvec3 point = (1 - share_b - share_c) * a + share_b * b + share_c * c;
      const glm::dvec2 shown = layout.in_rectangle(charts[i], place, point);
      const double off = std::hypot(shown.x - (static_cast<double>(x) + 0.5), shown.y - (static_cast<double>(y) + 0.5));
      REQUIRE(off == Approx(static_cast<double>(texel.distance)).margin(1e-3));
      if (texel.distance == 0) {
        ++texels;
        CHECK_FALSE(in_gutter);
      }
    }
    for (const std::uint32_t face : charts[i].faces) {
      const glm::uvec3& f = mesh.faces[face];
      const glm::dvec2 a = charts[i].place(glm::dvec3(mesh.positions[f.x])),
                       b = charts[i].place(glm::dvec3(mesh.positions[f.y])),
                       c = charts[i].place(glm::dvec3(mesh.positions[f.z]));
      flat_area +=
          0.5 * std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) * place.density * place.density;
    }
  }
  CHECK(texels == Approx(flat_area).epsilon(0.01));  // each texel counts once: its middle is on one face
}

}  // namespace
}  // namespace lumatlas
