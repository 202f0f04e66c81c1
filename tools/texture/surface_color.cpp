// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/surface_color.h"

#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

using glm::vec3;

void check(const ColorOptions& options) {
  if (!(options.sharpness >= 0 && options.sharpness <= 16)) {
    throw std::invalid_argument("texture: sharpness is " + number_text(options.sharpness) + ", must be in [0, 16]");
  }
  if (!(options.tolerance > 0 && std::isfinite(options.tolerance))) {
    throw std::invalid_argument("texture: tolerance is " + number_text(options.tolerance) +
                                ", must be finite and above 0");
  }
}

SurfaceColors::SurfaceColors(const SurfacePlaces& places, const TextureViews& views, const ColorOptions& options)
    : places_(places),
      views_(views),
      sharpness_(static_cast<float>(options.sharpness)),
      tolerance_(static_cast<float>(options.tolerance)) {
  check(options);
}

void SurfaceColors::find_shown(FaceId face, const SurfacePlace& place, double density,
                               std::vector<ShownPlace>& shown) const {
  struct Located {
    const TextureView* view;
    TextureView::ImagePoint place;
  };
  thread_local std::vector<Located> located;
  located.clear();
  const CellId cell = places_.surface().cells.cell_of_face[face];
  for (std::uint32_t i = views_.first_seen[cell]; i < views_.first_seen[cell + 1]; ++i) {
    const TextureView& view = views_.views[views_.seen_by[i]];
    TextureView::ImagePoint in_image;
    if (!view.locate(place.point, in_image)) continue;
    view.prefetch(in_image);
    located.push_back({&view, in_image});
  }
  shown.clear();
  for (const Located& at : located) {
    if (!at.view->shows(at.place)) continue;
    if (const auto seen = shown_in(*at.view, place, at.place, density, sharpness_)) shown.push_back(*seen);
  }
}

const std::vector<ShownPlace>& SurfaceColors::look(FaceId face, const SurfacePlace& place, double density,
                                                   Consensus& consensus) const {
  constexpr int kRounds = 4;
  thread_local std::vector<ShownPlace> shown;
  find_shown(face, place, density, shown);
  consensus = {};
  for (int round = 0; round < kRounds; ++round) {
    ConsensusSums sums;
    for (const ShownPlace& view : shown) sums.add(view, consensus);
    consensus = sums.result(tolerance_);
  }
  return shown;
}

Consensus SurfaceColors::consensus(FaceId face, float b, float c, double density) const {
  Consensus consensus;
  (void)look(face, places_.at(face, b, c), density, consensus);
  return consensus;
}

SurfaceColor SurfaceColors::at(FaceId face, float b, float c, double density) const {
  const SurfacePlace place = places_.at(face, b, c);
  Consensus consensus;
  const std::vector<ShownPlace>& shown = look(face, place, density, consensus);
  if (shown.empty()) return {place.stand_in, false};
  vec3 broad(0), detail(0);
  float total = 0, broad_weight = 0, detail_weight = 0;
  for (const ShownPlace& view : shown) {
    const float agreement = consensus.agreement(view.root);
    total += view.base;
    broad += view.base * agreement * view.smooth;
    broad_weight += view.base * agreement;
    detail += view.detail * agreement * (view.color - view.smooth);
    detail_weight += view.detail * agreement;
  }
  vec3 color = broad / broad_weight;
  if (detail_weight > 0) color += detail / detail_weight;
  color = (total * glm::max(color, vec3(0)) + kLeastWeight * place.stand_in) / (total + kLeastWeight);
  return {color, total > kLeastWeight};
}

}  // namespace lumatlas
