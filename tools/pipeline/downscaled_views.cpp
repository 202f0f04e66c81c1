// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/downscaled_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/lower_resolution.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

using SharedView = std::shared_ptr<const StoredView>;

// As they were before any was downscaled: filtering twice would blur twice.
std::vector<SharedView> views_of(const Atlas& atlas) {
  std::vector<SharedView> views;
  for (std::uint32_t slot = 0; slot < atlas.capacity(); ++slot) views.push_back(atlas.view(slot));
  return views;
}

std::uint32_t side_of(std::uint32_t side, double share) {
  return std::clamp(static_cast<std::uint32_t>(std::lround(share * side)), 1u, side);
}

// What is masked beside depth edges is as much narrower as all else, but never narrower on the surface than it was.
ValidityOptions at_share(ValidityOptions validity, double share) {
  const auto narrowed = [&](std::uint32_t px) { return static_cast<std::uint32_t>(std::ceil(share * px)); };
  validity.edge_radius_px = narrowed(validity.edge_radius_px);
  validity.fade_px = narrowed(validity.fade_px);
  return validity;
}

TiledView at_share(const StoredView& view, double share, const Atlas& atlas, const Visibility& visibility,
                   const ValidityOptions& validity) {
  const ImageSize from{view.camera.width, view.camera.height};
  const ImageSize to{side_of(from.width, share), side_of(from.height, share)};
  if (share == 1) {  // as it was, to the last bit
    return make_tiled_view(view.name, view.camera, view.photograph, visibility.trace_sparsely(view.camera),
                           atlas.surface().cells, atlas.layout(), validity, view.trust);
  }
  const Camera camera = view.camera.scaled_to(to.width, to.height);
  return make_tiled_view(view.name, camera, at_lower_resolution(view.photograph, to.width, to.height),
                         visibility.trace_sparsely(camera), atlas.surface().cells, atlas.layout(),
                         at_share(validity, share), mask_at_lower_resolution(view.trust, from, to));
}

void downscale_all(Atlas& atlas, const std::vector<SharedView>& originals, double share, const Visibility& visibility,
                   const ValidityOptions& validity) {
  tbb::parallel_for(std::size_t{0}, originals.size(), [&](std::size_t slot) {
    if (!originals[slot]) return;
    throw_if_interrupted();
    TiledView tiled = at_share(*originals[slot], share, atlas, visibility, validity);
    atlas.replace(static_cast<std::uint32_t>(slot), std::move(tiled.view), std::move(tiled.shown));
  });
}

void require_share(double least) {
  if (least > 0 && least <= 1) return;
  throw std::invalid_argument("downscale_views: least is " + std::to_string(least) + ", must be in (0, 1]");
}

}  // namespace

ValidityOptions validity_at_scale(const ValidityOptions& validity, double scale) {
  require_share(scale);
  return at_share(validity, scale);
}

double downscale_views(Atlas& atlas, const GpuBudget& budget, const Visibility& visibility,
                       const ValidityOptions& validity, double least) {
  require_share(least);
  constexpr int kMostTries = 3;  // tiles are whole, so that their number is not quite that of the pixels
  const std::vector<SharedView> originals = views_of(atlas);
  double share = 1;
  for (int tries = 0; tries < kMostTries && share > least; ++tries) {
    const double fits = budget.share_that_fits(atlas);
    if (fits >= 1) break;
    share = std::max(least, share * std::sqrt(fits));
    downscale_all(atlas, originals, share, visibility, validity);
  }
  return share;
}

DownscaledViews downscale_views_within(double max_loss_db, double reference_loss_db, Atlas& atlas,
                                       HeldOutLoss& measured, const Visibility& visibility,
                                       const ValidityOptions& validity, double least) {
  require_share(least);
  constexpr int kSteps = 8;  // each by the same factor
  DownscaledViews best;
  const std::vector<SharedView> originals = views_of(atlas);
  int fits = 0, too_far = kSteps + 1, now = 0;
  try {
    while (too_far - fits > 1) {
      now = (fits + too_far) / 2;
      const double scale = std::pow(least, static_cast<double>(now) / kSteps);
      downscale_all(atlas, originals, scale, visibility, validity);
      const MeasuredLoss loss = measured.now({{}, reference_loss_db}, max_loss_db);
      (loss.at_most_db() <= max_loss_db ? fits : too_far) = now;
      if (now == fits) best = {scale, loss};
    }
    if (now != fits) downscale_all(atlas, originals, best.scale, visibility, validity);
  } catch (const GlError&) {
    downscale_all(atlas, originals, 1, visibility, validity);
    throw;
  }
  return best;
}

}  // namespace lumatlas
