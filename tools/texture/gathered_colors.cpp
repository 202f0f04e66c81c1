// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/gathered_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "tools/texture/layout/chart_texels.h"

namespace lumatlas {

namespace {

using glm::dvec2;
using glm::vec3;

constexpr std::uint32_t kNoPlace = ~0u;
constexpr double kCoarser = 4;  // texels for a place of the consensus, along a side
constexpr std::uint32_t kCoarseGutter = 2;

// Returns the texels that each listed chart covers.
GatheredPlaces gathered_places(const GatheredOn& on, const TextureLayout& layout, std::vector<std::uint32_t> charts) {
  std::vector<std::vector<GatheredPlace>> of_chart(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t i) {
    const ChartPlace& place = layout.places[charts[i]];
    const std::vector<ChartTexel> texels = chart_texels(on.places.surface().mesh, on.charts[charts[i]], place, layout);
    for (std::size_t t = 0; t < texels.size(); ++t) {
      const ChartTexel& texel = texels[t];
      if (texel.face == FaceId::none) continue;
      of_chart[i].push_back({texel.face, texel.share_b, texel.share_c, static_cast<std::uint16_t>(t % place.width),
                             static_cast<std::uint16_t>(t / place.width), texel.distance == 0});
    }
  });
  GatheredPlaces gathered;
  gathered.charts = std::move(charts);
  gathered.first.push_back(0);
  for (const auto& places : of_chart) gathered.first.push_back(gathered.first.back() + places.size());
  gathered.places.reserve(gathered.first.back());
  for (auto& places : of_chart) {
    gathered.places.insert(gathered.places.end(), places.begin(), places.end());
    std::vector<GatheredPlace>().swap(places);
  }
  return gathered;
}

// Calls use(chart, number of the place, what the view shows there) for every place that the view shows, on many
// threads.
template <typename Use>
void for_each_shown(const GatheredOn& on, const GatheredPlaces& gathered, const TextureView& view, const Use& use) {
  const Surface& surface = on.places.surface();
  const std::vector<float> densities = densities_in(view, surface);
  const auto sharpness = static_cast<float>(on.options.sharpness);
  const auto look = [&](std::uint32_t chart, std::size_t number) {
    const GatheredPlace& at = gathered.places[number];
    if (!(densities[surface.cells.cell_of_face[at.face]] > 0)) return;
    const SurfacePlace place = on.places.at(at.face, at.share_b, at.share_c);
    const auto shown = shown_in(view, place, on.layout.places[chart].density, sharpness);
    if (shown) use(chart, number, *shown);
  };
  tbb::parallel_for(std::size_t{0}, gathered.charts.size(), [&](std::size_t i) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(gathered.first[i], gathered.first[i + 1], 4096),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t number = range.begin(); number != range.end(); ++number) {
                          look(gathered.charts[i], number);
                        }
                      });
  });
}

// The same charts with fewer texels; rectangles that are not packed.
TextureLayout coarser(const GatheredOn& on) {
  TextureLayout coarse;
  coarse.gutter_px = kCoarseGutter;
  for (std::size_t i = 0; i < on.charts.size(); ++i) {
    ChartPlace place;
    place.density = on.layout.places[i].density / kCoarser;
    const dvec2 texels = glm::ceil(place.density * on.charts[i].size + 1.0 + 2.0 * kCoarseGutter);
    place.width = static_cast<std::uint32_t>(texels.x);
    place.height = static_cast<std::uint32_t>(texels.y);
    coarse.places.push_back(place);
  }
  return coarse;
}

std::vector<std::uint32_t> all_of(const std::vector<Chart>& charts) {
  std::vector<std::uint32_t> numbers(charts.size());
  for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
  return numbers;
}

}  // namespace

std::uint64_t texels_of(const ChartPlace& place) {
  return std::uint64_t{place.width} * place.height;
}

ConsensusMap::ConsensusMap(const GatheredOn& on, const SurfaceColors& stored) : on_(on), coarse_(coarser(on)) {
  gathered_ = gathered_places(on_, coarse_, all_of(on_.charts));
  first_texel_.push_back(0);
  for (const ChartPlace& place : coarse_.places) first_texel_.push_back(first_texel_.back() + texels_of(place));
  number_.assign(first_texel_.back(), kNoPlace);
  consensus_.resize(gathered_.places.size());
  sums_.resize(gathered_.places.size());
  tbb::parallel_for(std::size_t{0}, on_.charts.size(), [&](std::size_t chart) {
    for (std::size_t i = gathered_.first[chart]; i < gathered_.first[chart + 1]; ++i) {
      const GatheredPlace& place = gathered_.places[i];
      number_[first_texel_[chart] + std::size_t{place.y} * coarse_.places[chart].width + place.x] =
          static_cast<std::uint32_t>(i);
      consensus_[i] = stored.consensus(place.face, place.share_b, place.share_c, on_.layout.places[chart].density);
    }
  });
}

void ConsensusMap::add(const TextureView& view) {
  for_each_shown(on_, gathered_, view, [&](std::uint32_t, std::size_t number, const ShownPlace& shown) {
    sums_[number].add(shown, consensus_[number]);
  });
}

void ConsensusMap::finish_round() {
  const auto tolerance = static_cast<float>(on_.options.tolerance);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const Consensus next = std::exchange(sums_[i], {}).result(tolerance);
    if (next.weight > 0) consensus_[i] = next;
  }
}

// Bilinear over the places there are, by their weights where views end.
Consensus ConsensusMap::at(std::uint32_t chart, const dvec2& in_rectangle) const {
  const ChartPlace& place = coarse_.places[chart];
  const dvec2 fine_zero(0.5 + on_.layout.gutter_px), coarse_zero(0.5 + coarse_.gutter_px);
  const double scale = place.density / on_.layout.places[chart].density;
  const dvec2 at = scale * (in_rectangle - fine_zero) + coarse_zero - 0.5;
  const dvec2 base = glm::floor(at), f = at - base;
  Consensus sum;
  float shares = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const int right = corner % 2, below = corner / 2;
    const auto x = static_cast<std::int64_t>(base.x) + right, y = static_cast<std::int64_t>(base.y) + below;
    if (x < 0 || y < 0 || x >= place.width || y >= place.height) continue;
    const std::uint32_t number = number_[first_texel_[chart] + static_cast<std::size_t>(y * place.width + x)];
    if (number == kNoPlace || !(consensus_[number].weight > 0)) continue;
    const auto share = static_cast<float>((right == 1 ? f.x : 1 - f.x) * (below == 1 ? f.y : 1 - f.y)) + 1e-6f;
    const Consensus& one = consensus_[number];
    sum.root += share * one.root;
    sum.broad += share * one.broad;
    sum.tolerance2 += share * one.tolerance2;
    sum.weight += share * one.weight;
    shares += share;
  }
  if (!(shares > 0)) return {};
  return {sum.root / shares, sum.broad / shares, sum.tolerance2 / shares, sum.weight / shares};
}

DetailMap::DetailMap(const GatheredOn& on, const ConsensusMap& consensus, std::vector<std::uint32_t> charts)
    : on_(on), consensus_(consensus), gathered_(gathered_places(on, on.layout, std::move(charts))) {
  sums_.assign(gathered_.places.size(), glm::vec4(0));
}

void DetailMap::add(const TextureView& view) {
  for_each_shown(on_, gathered_, view, [&](std::uint32_t chart, std::size_t number, const ShownPlace& shown) {
    const GatheredPlace& at = gathered_.places[number];
    const float weight = shown.detail * consensus_.at(chart, {at.x + 0.5, at.y + 0.5}).agreement(shown.root);
    sums_[number] += glm::vec4(weight * (shown.color - shown.smooth), weight);
  });
}

DetailMap::Counts DetailMap::color(FilledPage& page) const {
  Counts counts;
  for (std::size_t i = 0; i < gathered_.charts.size(); ++i) {
    const std::uint32_t chart = gathered_.charts[i];
    const ChartPlace& rectangle = on_.layout.places[chart];
    for (std::size_t number = gathered_.first[i]; number < gathered_.first[i + 1]; ++number) {
      const GatheredPlace& at = gathered_.places[number];
      const vec3 stand_in = on_.places.at(at.face, at.share_b, at.share_c).stand_in;
      const Consensus consensus = consensus_.at(chart, {at.x + 0.5, at.y + 0.5});
      vec3 color = consensus.broad;
      if (sums_[number].w > 0) color += vec3(sums_[number]) / sums_[number].w;
      color =
          (consensus.weight * glm::max(color, vec3(0)) + kLeastWeight * stand_in) / (consensus.weight + kLeastWeight);
      page.set(rectangle.x + at.x, rectangle.y + at.y, color * on_.places.exposure(at.face, at.share_b, at.share_c));
      counts.texels += at.inside;
      counts.unseen_texels += at.inside && !(consensus.weight > kLeastWeight);
    }
  }
  return counts;
}

}  // namespace lumatlas
