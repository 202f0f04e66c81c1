// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/textured_mesh.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>

#include "atlas/images/srgb.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/texture/exposure_field.h"
#include "tools/texture/gathered_colors.h"
#include "tools/texture/layout/chart_texels.h"
#include "tools/texture/layout/filled_page.h"

namespace lumatlas {

namespace {

Snapshot checked(const Snapshot& snapshot) {
  check(snapshot);
  return without_far_sphere(snapshot);
}

// Returns the texels per scene unit that each chart should have: the mean over its faces of the density that their
// cells are seen with. Unseen cells need few.
std::vector<double> chart_densities(const Surface& surface, const std::vector<Chart>& charts, const TextureViews& views,
                                    double texels_per_pixel) {
  constexpr double kUnseenShare = 1.0 / 8;
  std::vector<double> seen;
  for (const double density : views.density) {
    if (density > 0) seen.push_back(density);
  }
  // If no view sees anything, any density does, because the colours are those of vertices.
  const double typical = seen.empty() ? 4 / surface.cells.size : median(seen);
  std::vector<double> densities;
  for (const Chart& chart : charts) {
    double sum = 0, count = 0;
    for (const FaceId face : chart.faces) {
      const double density = views.density[surface.cells.cell_of_face[face]];
      sum += density;
      count += density > 0;
    }
    densities.push_back(texels_per_pixel * (count > 0 ? sum / count : kUnseenShare * typical));
  }
  return densities;
}

}  // namespace

void check(const TextureOptions& options) {
  check(options.charts);
  check(options.layout);
  check(options.color);
  if (!(options.texels_per_pixel > 0 && options.texels_per_pixel <= 4)) {
    throw std::invalid_argument("texture: texels_per_pixel is " + number_text(options.texels_per_pixel) +
                                ", must be above 0 and at most 4");
  }
  if (options.most_texels_at_once == 0) {
    throw std::invalid_argument("texture: most_texels_at_once is 0, must be at least 1");
  }
}

TexturedMesh::TexturedMesh(const Snapshot& snapshot, const TextureOptions& options, OfferedPhotographs offered)
    : snapshot_(checked(snapshot)), options_(options), offered_(std::move(offered)) {
  check(options);
  check(offered_);
  const Surface& surface = *snapshot_.surface;
  charts_ = make_charts(surface.mesh, surface.cells, options.charts);
  views_ = texture_views(snapshot_);
  if (!offered_.list.empty()) {
    const std::vector<double> densities = densities_of(offered_, surface);
    for (std::size_t cell = 0; cell < densities.size(); ++cell) {
      if (!(views_.density[cell] > 0)) views_.density[cell] = densities[cell];
    }
  }
  layout_ = lay_out(charts_, chart_densities(surface, charts_, views_, options.texels_per_pixel), options.layout);
  chart_of_face_.resize(surface.mesh.faces.size());
  for (std::uint32_t chart = 0; chart < charts_.size(); ++chart) {
    for (const FaceId face : charts_[chart].faces) chart_of_face_[face] = chart;
  }
}

std::vector<std::uint32_t> TexturedMesh::charts_on(std::uint32_t page) const {
  std::vector<std::uint32_t> charts;
  for (std::uint32_t i = 0; i < charts_.size(); ++i) {
    if (layout_.places[i].page == page) charts.push_back(i);
  }
  return charts;
}

std::vector<std::vector<std::uint32_t>> TexturedMesh::batches_on(std::uint32_t page) const {
  std::vector<std::vector<std::uint32_t>> batches;
  std::uint64_t texels = 0;
  for (const std::uint32_t chart : charts_on(page)) {
    const std::uint64_t more = texels_of(layout_.places[chart]);
    if (batches.empty() || texels + more > options_.most_texels_at_once) {
      batches.emplace_back();
      texels = 0;
    }
    batches.back().push_back(chart);
    texels += more;
  }
  return batches;
}

std::size_t TexturedMesh::ticks() const {
  if (offered_.list.empty()) return charts_.size();
  std::size_t rounds = 1;
  for (std::uint32_t page = 0; page < layout_.pages; ++page) rounds += batches_on(page).size();
  return rounds * PlacedPhotographs::count(snapshot_, offered_);
}

TextureFacts TexturedMesh::bake(const PageSink& sink, const CancelCheck& cancel_check) const {
  TextureFacts facts = offered_.list.empty() ? bake_stored(sink, cancel_check) : bake_offered(sink, cancel_check);
  facts.texels_per_pixel = options_.texels_per_pixel * layout_.scale;
  return facts;
}

TextureFacts TexturedMesh::bake_stored(const PageSink& sink, const CancelCheck& cancel_check) const {
  SurfacePlaces places(snapshot_);
  if (options_.color.exposure == ColorOptions::Exposure::nearby) {
    ExposureField field(mesh());
    for (const TextureView& view : views_.views) field.add(view);
    places.set_exposures(field.factors());
  }
  const SurfaceColors colors(places, views_, options_.color);
  std::atomic<std::uint64_t> texels = 0, unseen_texels = 0;
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    FilledPage filled(layout_.side_px);
    const std::vector<std::uint32_t> on_page = charts_on(page);
    const auto color_chart = [&](std::size_t i) {
      const ChartPlace& place = layout_.places[on_page[i]];
      const std::vector<ChartTexel> map = chart_texels(mesh(), charts_[on_page[i]], place, layout_);
      const auto color_block = [&](const tbb::blocked_range2d<std::uint32_t>& block) {
        std::uint64_t inside = 0, unseen = 0;
        for (std::uint32_t y = block.rows().begin(); y != block.rows().end(); ++y) {
          for (std::uint32_t x = block.cols().begin(); x != block.cols().end(); ++x) {
            const ChartTexel& texel = map[std::size_t{y} * place.width + x];
            if (texel.face == FaceId::none) continue;
            const SurfaceColor color = colors.at(texel.face, texel.share_b, texel.share_c, place.density);
            const glm::vec3 exposure = places.exposure(texel.face, texel.share_b, texel.share_c);
            filled.set(place.x + x, place.y + y, color.color * exposure);
            inside += texel.distance == 0;
            unseen += texel.distance == 0 && !color.seen;
          }
        }
        texels += inside;
        unseen_texels += unseen;
      };
      // Small blocks, so that what views show of one stays in the processor's cache.
      tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, place.height, 16, 0, place.width, 16), color_block,
                        tbb::simple_partitioner());
      check_cancelled(cancel_check);
    };
    tbb::parallel_for(std::size_t{0}, on_page.size(), color_chart);
    sink(page, filled.finish());
  }
  return {.texels = texels, .unseen_texels = unseen_texels, .photographs = views_.views.size()};
}

TextureFacts TexturedMesh::bake_offered(const PageSink& sink, const CancelCheck& cancel_check) const {
  SurfacePlaces places(snapshot_);
  const SurfaceColors stored(places, views_, options_.color);
  const GatheredOn on{places, charts_, layout_, options_.color};
  PlacedPhotographs photographs(snapshot_, views_, stored, offered_);
  ConsensusMap consensus(on, stored);
  ExposureField field(mesh());
  const auto first_look = [&](const TextureView& view) {
    consensus.add(view);
    field.add(view);
  };
  photographs.each(first_look, cancel_check);
  consensus.finish_round();
  if (options_.color.exposure == ColorOptions::Exposure::nearby) places.set_exposures(field.factors());
  TextureFacts facts{.photographs = photographs.used(), .outliers = photographs.outliers()};
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    FilledPage filled(layout_.side_px);
    for (std::vector<std::uint32_t>& charts : batches_on(page)) {
      DetailMap details(on, consensus, std::move(charts));
      photographs.each([&](const TextureView& view) { details.add(view); }, cancel_check);
      const DetailMap::Counts counts = details.color(filled);
      facts.texels += counts.texels;
      facts.unseen_texels += counts.unseen_texels;
    }
    sink(page, filled.finish());
  }
  return facts;
}

}  // namespace lumatlas
