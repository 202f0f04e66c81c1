// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/downscaled_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/lower_resolution.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

std::uint32_t side_of(std::uint32_t side, double share) {
  return std::clamp(static_cast<std::uint32_t>(std::lround(share * side)), 1u, side);
}

// Scales the masks beside depth edges with the photograph, without making them narrower on the surface than they were.
ValidityOptions at_share(ValidityOptions validity, double share) {
  const auto narrowed = [&](std::uint32_t px) { return static_cast<std::uint32_t>(std::ceil(share * px)); };
  validity.edge_radius_px = narrowed(validity.edge_radius_px);
  validity.fade_px = narrowed(validity.fade_px);
  return validity;
}

}  // namespace

void require_share_of_sides(double share) {
  if (share > 0 && share <= 1) return;
  throw std::invalid_argument("downscaled views: the share of their sides is " + std::to_string(share) +
                              ", must be in (0, 1]");
}

ValidityOptions validity_at_scale(const ValidityOptions& validity, double scale) {
  require_share_of_sides(scale);
  return at_share(validity, scale);
}

ScaledViews::ScaledViews(Atlas& atlas, const Visibility& visibility, const ValidityOptions& validity)
    : atlas_(atlas), visibility_(visibility), validity_(validity) {
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) views_.push_back(atlas.view(slot));
}

TiledView ScaledViews::scaled(const StoredView& view, double share) const {
  const std::shared_ptr<const Surface> surface = atlas_.surface();
  const Cells& cells = surface->cells;
  if (share == 1) {
    return make_tiled_view(view.name, view.camera, view.photograph, visibility_.trace_sparsely(view.camera), cells,
                           atlas_.layout(), validity_, view.mask->trust.all());
  }
  const ImageSize from{view.camera.width, view.camera.height};
  const ImageSize to{side_of(from.width, share), side_of(from.height, share)};
  const Camera camera = view.camera.scaled_to(to.width, to.height);
  return make_tiled_view(view.name, camera, at_lower_resolution(view.photograph->whole(), to.width, to.height),
                         visibility_.trace_sparsely(camera), cells, atlas_.layout(), at_share(validity_, share),
                         mask_at_lower_resolution(view.mask->trust.all(), from, to));
}

void ScaledViews::scale_to(double share) {
  require_share_of_sides(share);
  if (share == share_) return;
  share_ = 0;  // until all views are
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    throw_if_interrupted();
    TiledView tiled = scaled(*views_[slot], share);
    atlas_.replace(ViewSlot(static_cast<std::uint32_t>(slot)), std::move(tiled.view), std::move(tiled.shown));
  });
  share_ = share;
}

DownscaledViews downscale_views_within(double max_loss_db, double reference_loss_db, Atlas& atlas,
                                       HeldOutLoss& measured, const Visibility& visibility,
                                       const ValidityOptions& validity, double least) {
  require_share_of_sides(least);
  constexpr int kSteps = 8;  // each by the same factor
  DownscaledViews best;
  ScaledViews views(atlas, visibility, validity);
  int fits = 0, too_far = kSteps + 1;
  try {
    while (too_far - fits > 1) {
      const int now = (fits + too_far) / 2;
      const double scale = std::pow(least, static_cast<double>(now) / kSteps);
      views.scale_to(scale);
      const MeasuredLoss loss = measured.now({{}, reference_loss_db}, max_loss_db);
      (loss.at_most_db() <= max_loss_db ? fits : too_far) = now;
      if (now == fits) best = {scale, loss};
    }
    views.scale_to(best.scale);
  } catch (const GlError&) {
    views.scale_to(1);
    throw;
  }
  return best;
}

}  // namespace lumatlas
