// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/views/parsimony.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "atlas/tiles/tiles.h"
#include "blend/gl/egl_context.h"
#include "blend/gpu_bytes.h"
#include "planner/pruning/pruning.h"
#include "tools/budget/compressed_views.h"
#include "tools/budget/downscaled_views.h"
#include "tools/budget/held_out_loss.h"
#include "tools/budget/thinned_views.h"

namespace lumatlas {

namespace {

Parsimony without_bounds(const Stream& stream, const std::vector<PlannedView>& planned) {
  Parsimony parsimony;
  for (std::size_t place = 0; place < stream.size(); ++place) {
    if (planned[place].verdict.decision == Decision::outlier) continue;
    ++parsimony.views;
    parsimony.references += planned[place].verdict.cells_seen;
  }
  return parsimony;
}

std::uint64_t gpu_bytes_of(const Snapshot& snapshot) {
  return GpuByteCount(snapshot.surface).of(snapshot).sum();
}

// The losses that are allowed, dB, each with all that was lost before it: first by compression and resolution, then by
// faces, then by views. Steps are coarse, so the rest of one bound goes to the next.
struct LossBounds {
  double texels = 0;
  double faces = 0;
  double in_all = 0;
};

// References take few bytes. So they are given up only where the pictures are no worse for it.
double loss_of_references(Planner& planner, HeldOutLoss& measured) {
  const double predicted_db = Pruning(planner).loss_of_references();
  return predicted_db > 0 && measured.now({{}, predicted_db}, 0.0).mean_db <= 0 ? predicted_db : 0;
}

void give_up_texels(double max_loss_db, double reference_loss_db, Atlas& atlas, HeldOutLoss& measured,
                    const Visibility& visibility, BuildResult& result) {
  if (const std::optional<TileOptions>& tight = result.options.tight_tiles) {
    const auto loss = compress_views_within(max_loss_db, reference_loss_db, *tight, atlas, measured, visibility);
    if (loss) {
      result.options.tiles = *tight;
      result.texel_loss_db = loss->mean_db;
    }
  }
  if (result.options.least_scale == 1) return;
  const DownscaledViews downscaled = downscale_views_within(max_loss_db, reference_loss_db, atlas, measured, visibility,
                                                            result.effective.validity, result.options.least_scale);
  if (downscaled.scale == 1) return;
  result.scale = downscaled.scale;
  result.texel_loss_db = downscaled.loss.mean_db;
}

// Returns the cameras of the offered views that were rejected, without outliers.
std::vector<Camera> turned_away(const Stream& stream, const std::vector<PlannedView>& planned, const Atlas& atlas) {
  std::set<std::string> stored;
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
    if (const auto view = atlas.view(slot)) stored.insert(view->name);
  }
  std::vector<Camera> cameras;
  for (std::size_t place = 0; place < stream.size(); ++place) {
    const bool counts = planned[place].verdict.decision != Decision::outlier && !stored.contains(stream[place]->name);
    if (counts) cameras.push_back(stream[place]->camera);
  }
  return cameras;
}

// Gives up faces by the photographs' present resolution.
void give_up_faces(double max_loss_db, double reference_loss_db, const Stream& stream,
                   const MakeVisibility& make_visibility, SeenSurface& seen, const Atlas& atlas, Planner& planner,
                   HeldOutLoss& measured, BuildResult& result) {
  const BuildOptions& options = result.options;
  const auto loss =
      give_up_faces_within({max_loss_db, options.faces.pixels, options.cells}, reference_loss_db,
                           turned_away(stream, result.planned, atlas), make_visibility, seen, atlas, planner, measured);
  if (!loss) return;
  result.face_loss_db = loss->mean_db;
  result.simplified_faces = seen.input.simplified_faces;
  result.simplified_distance = seen.input.simplified_distance;
}

void give_up_by_measurement(Planner& planner, Atlas& atlas, SeenSurface& seen, const MakeVisibility& make_visibility,
                            const Stream& stream, const LossBounds& bounds, BuildStage& stage, BuildResult& result) {
  Parsimony& parsimony = *result.parsimony;
  HeldOutLoss measured(planner, atlas, stage);
  if (!measured.can_tell()) return;
  const double reference_loss_db = loss_of_references(planner, measured);
  if (bounds.texels > 0) give_up_texels(bounds.texels, reference_loss_db, atlas, measured, *seen.visibility, result);
  if (bounds.faces > 0 && result.scale < 1) {
    planner.set_validity(validity_at_scale(result.effective.validity, result.scale));
    give_up_faces(bounds.faces, reference_loss_db, stream, make_visibility, seen, atlas, planner, measured, result);
  }
  ThinnedViews thinned = thin_views_within(bounds.in_all, reference_loss_db, planner, measured);
  parsimony.taken_away = std::move(thinned.taken_away);
  parsimony.measured = thinned.loss;
  Pruning(planner).give_up_references(reference_loss_db);
}

}  // namespace

void give_up_within_loss(Planner& planner, Atlas& atlas, SeenSurface& seen, const MakeVisibility& make_visibility,
                         const Stream& stream, const BuildCallback& callback, BuildResult& result) {
  result.parsimony = without_bounds(stream, result.planned);
  Parsimony& parsimony = *result.parsimony;
  parsimony.gpu_bytes = gpu_bytes_of(atlas.snapshot());
  const double bound_db = *result.effective.max_loss_db + result.options.bound.texel_loss_db();
  // The loss by the views that the stream has rejected, which can only be predicted.
  const double turned_away_db = Pruning(planner).predicted_loss().loss_db;
  const double in_all = bound_db - turned_away_db;
  const LossBounds bounds{std::min(result.options.bound.texel_loss_db(), in_all),
                          std::min(result.options.bound.face_loss_db(), in_all), in_all};
  if (bound_db > 0) {
    BuildStage stage(callback, "measuring what can be given up", 0);
    try {
      give_up_by_measurement(planner, atlas, seen, make_visibility, stream, bounds, stage, result);
    } catch (const GlError& error) {
      result.warnings.push_back(
          std::string("the model is larger than --loss may allow, because its loss cannot be measured: ") +
          error.what());
    }
    stage.finish();
  }
  // Faces may have used up what prediction has for views.
  const bool used_up = result.face_loss_db > result.options.bound.texel_loss_db();
  if (!parsimony.measured && !used_up) parsimony.taken_away = Pruning(planner).prune();
  parsimony.predicted = Pruning(planner).predicted_loss();
  const double of_texels_and_faces = result.face_loss_db != 0 ? result.face_loss_db : result.texel_loss_db;
  parsimony.loss_db = parsimony.measured ? turned_away_db + parsimony.measured->mean_db
                                         : parsimony.predicted.loss_db + of_texels_and_faces;
  if (!result.options.tiles.whole_views()) atlas.choose_tiles_anew();  // fewer views are left than were measured
}

}  // namespace lumatlas
