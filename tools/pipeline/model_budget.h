// SPDX-License-Identifier: GPL-3.0-or-later
// The size that a model may have, and the options of a build that keep to it.
#pragma once

#include <cstdint>

#include "atlas/tiles/tiles.h"
#include "tools/pipeline/build_options.h"

namespace lumatlas {

// Pixels of the photographs that the surface may move by where the mesh is to be small: see FaceOptions.
inline constexpr double kFacesPixels = 0.5;

// Gutter of compressed tiles: they have two levels, as others have by default, with twice their gutter.
inline constexpr std::uint32_t kGutterOfBlocks = 4;

// One bound at most is set.
struct ModelBudget {
  bool automatic = false;       // as small as `loss_db` allows
  double loss_db = 0.1;         // PSNR against all photographs, as measured while building; finite and >= 0
  std::uint64_t gpu_bytes = 0;  // on the GPU: mesh and photographs, of whole views the photographs; 0: no bound
  std::uint64_t texels = 0;     // the photographs' on the GPU; 0: no bound

  [[nodiscard]] bool bounds() const { return automatic || gpu_bytes > 0 || texels > 0; }
};

// Returns the same tiles, compressed, with their gutter.
[[nodiscard]] TileOptions compressed_tiles(TileOptions tiles);

// Returns whether a model with this budget has no faces that no picture shows, because its mesh counts.
[[nodiscard]] bool wants_few_faces(const ModelBudget& budget, const TileOptions& tiles);

// Sets what chooses views where only the loss is bounded: the measure and the references that the law of
// planner/coverage/predicted_loss.h is for, and no least gain.
void choose_by_loss(PlannerOptions& planner);

// Sets the bounds of a build. The caller has set the tiles, `tight_tiles`, `least_scale`, `faces`, and
// `planner.max_bytes`, the bytes of photographs that tiles are cut from (0: no bound). Unless `keeps_max_views`,
// `max_views` is none afterwards where something else bounds the photographs. Throws std::invalid_argument for a budget
// smaller than a tile.
void apply_budget(const ModelBudget& budget, bool keeps_max_views, BuildOptions& options);

}  // namespace lumatlas
