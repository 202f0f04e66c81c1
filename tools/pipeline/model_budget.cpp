// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/model_budget.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "planner/coverage/predicted_loss.h"

namespace lumatlas {

namespace {

// Texels of tiles are those of whole slots; of whole views, those of photographs as the planner holds them.
std::uint64_t bytes_of_budget(const ModelBudget& budget, const TileOptions& tiles) {
  if (budget.texels == 0) return budget.gpu_bytes;
  Camera one;
  one.width = one.height = 1;
  if (tiles.whole_views()) return budget.texels * stored_bytes(one);
  const std::uint64_t place_texels = std::uint64_t{tiles.place_px()} * tiles.place_px();
  return std::max<std::uint64_t>(budget.texels / place_texels, 1) * place_bytes(tiles);
}

// Half of the bound is for texels, a quarter, and what they leave, for faces, and the rest for what is left out.
void bound_loss(double loss_db, bool keeps_max_views, BuildOptions& options) {
  const bool texels = !options.tiles.whole_views() && (options.least_scale < 1 || options.tight_tiles);
  options.bound = Bound::of_loss(texels ? loss_db / 2 : 0, options.faces.pixels > 0 ? 0.75 * loss_db : 0);
  options.planner.max_loss_db = loss_db - options.bound.texel_loss_db();
  choose_by_loss(options.planner);
  if (!keeps_max_views) options.max_views.reset();
}

void require_room_for_a_tile(std::uint64_t bytes, const TileOptions& tiles) {
  if (bytes >= place_bytes(tiles)) return;
  throw std::invalid_argument("budget: is " + std::to_string(bytes) + " bytes, less than the " +
                              std::to_string(place_bytes(tiles)) +
                              " of a single tile: give more, or make tiles smaller");
}

}  // namespace

TileOptions compressed_tiles(TileOptions tiles) {
  tiles.texels = TexelFormat::bc7;
  tiles.gutter_px = kGutterOfBlocks;
  return tiles;
}

bool wants_few_faces(const ModelBudget& budget, const TileOptions& tiles) {
  if (budget.automatic) return budget.loss_db > 0;
  return !tiles.whole_views() && budget.gpu_bytes > 0;
}

void choose_by_loss(PlannerOptions& planner) {
  constexpr std::uint32_t kReferences = 64;
  const CoverageOptions wanted = parsimony_coverage(planner.coverage);
  planner.coverage.lambda = wanted.lambda;
  planner.coverage.direction_width = wanted.direction_width;
  planner.coverage.max_references = kReferences;
  planner.min_view_gain = 0;
}

void apply_budget(const ModelBudget& budget, bool keeps_max_views, BuildOptions& options) {
  if (budget.automatic) return bound_loss(budget.loss_db, keeps_max_views, options);
  const std::uint64_t bytes = bytes_of_budget(budget, options.tiles);
  if (options.tiles.whole_views()) {
    options.planner.max_bytes = bytes;
  } else if (budget.bounds()) {
    require_room_for_a_tile(bytes, options.tiles);
    options.bound = budget.gpu_bytes > 0 ? Bound::of_gpu(bytes) : Bound::of_array(bytes);
  }
  if (keeps_max_views) return;
  if (!options.tiles.whole_views() && budget.texels > 0 && options.planner.max_bytes == 0) {
    options.planner.max_bytes = photograph_bytes_for(bytes, options.tiles);
  }
  if (options.planner.max_bytes + options.bound.gpu_bytes() > 0) options.max_views.reset();
}

}  // namespace lumatlas
