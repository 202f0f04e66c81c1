// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/parsimony.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "atlas/tiles.h"
#include "blend/egl_context.h"
#include "tools/pipeline/downscaled_views.h"
#include "tools/pipeline/held_out_loss.h"
#include "tools/pipeline/thinned_views.h"

namespace lumatlas {

namespace {

// What a view would take with all of its tiles resident.
std::uint64_t texels_of(const Camera& camera, const TileOptions& layout) {
  if (layout.whole_views()) return std::uint64_t{camera.width} * camera.height;
  const std::uint64_t tiles = TileGrid(camera.width, camera.height, layout.tile_px).tiles();
  return tiles * layout.slot_px() * layout.slot_px();
}

Parsimony without_bounds(const Stream& stream, const TileOptions& layout, const std::vector<PlannedView>& planned) {
  Parsimony parsimony;
  for (std::size_t place = 0; place < stream.size(); ++place) {
    if (planned[place].verdict.decision == Decision::outlier) continue;
    ++parsimony.views;
    parsimony.references += planned[place].verdict.cells_seen;
    parsimony.texels += texels_of(stream[place]->camera, layout);
  }
  return parsimony;
}

// What may be lost, dB. Resolution has a part of its own, since its steps are coarse; what it leaves of that goes to
// views.
struct LossBounds {
  double scale = 0;
  double in_all = 0;
};

// References take few bytes. So they are given up only where the pictures are no worse for it.
double loss_of_references(const Planner& planner, HeldOutLoss& measured) {
  const double predicted_db = planner.loss_of_references();
  return predicted_db > 0 && measured.now({{}, predicted_db}).mean_db <= 0 ? predicted_db : 0;
}

void give_up_by_measurement(Planner& planner, Atlas& atlas, const Visibility& visibility, const LossBounds& bounds,
                            BuildStage& stage, BuildResult& result) {
  Parsimony& parsimony = *result.parsimony;
  HeldOutLoss measured(planner, atlas, stage);
  if (!measured.can_tell()) return;
  const double reference_loss_db = loss_of_references(planner, measured);
  if (bounds.scale > 0 && result.options.least_scale < 1) {
    const DownscaledViews downscaled =
        downscale_views_within(bounds.scale, reference_loss_db, atlas, measured, visibility, result.effective.validity,
                               result.options.least_scale);
    result.scale = downscaled.scale;
    result.scale_loss_db = downscaled.loss.mean_db;
  }
  ThinnedViews thinned = thin_views_within(bounds.in_all, reference_loss_db, planner, measured);
  parsimony.taken_away = std::move(thinned.taken_away);
  parsimony.measured = thinned.loss;
  planner.give_up_references(reference_loss_db);
}

}  // namespace

void give_up_within_loss(Planner& planner, Atlas& atlas, const Visibility& visibility, const Stream& stream,
                         const BuildCallback& callback, BuildResult& result) {
  result.parsimony = without_bounds(stream, atlas.layout(), result.planned);
  Parsimony& parsimony = *result.parsimony;
  const double bound_db = *result.effective.max_loss_db + result.options.max_scale_loss_db;
  // Of the views that the stream has turned away, which can only be predicted.
  const double turned_away_db = planner.predicted_loss().loss_db;
  const LossBounds bounds{result.options.max_scale_loss_db, bound_db - turned_away_db};
  if (bound_db > 0) {
    BuildStage stage(callback, "measuring what can be given up", 0);
    try {
      give_up_by_measurement(planner, atlas, visibility, bounds, stage, result);
    } catch (const GlError& error) {
      result.warnings.push_back(std::string("less is given up than could be, for what it costs cannot be measured: ") +
                                error.what());
    }
    stage.finish();
  }
  if (!parsimony.measured) parsimony.taken_away = planner.thin();
  parsimony.predicted = planner.predicted_loss();
  parsimony.loss_db = parsimony.measured ? turned_away_db + parsimony.measured->mean_db
                                         : parsimony.predicted.loss_db + result.scale_loss_db;
  if (!result.options.tiles.whole_views()) atlas.choose_tiles_anew();  // of fewer views than were measured
}

}  // namespace lumatlas
