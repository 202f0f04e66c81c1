// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of fewer faces than half a pixel of the photographs allows, where its bytes are worth more as photographs, or
// where these were downscaled.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/planner.h"
#include "tools/budget/held_out_loss.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

// Reduces the faces if mesh and tables leave less of `budget_bytes` on the GPU than `photograph_bytes`. They then take
// what the photographs leave, or about a quarter if that is more. At least four faces are kept for each cell, because
// faces larger than a cell would be split again. Where that is too many, cells grow as faces get fewer, to four times
// their size at most, unless `cells` has one. As it is where nothing would be left.
[[nodiscard]] SurfaceInput with_room_for_photographs(const SurfaceInput& input, CellOptions cells,
                                                     std::uint64_t budget_bytes, std::uint64_t photograph_bytes);

// A surface, and who sees it.
struct SeenSurface {
  SurfaceInput input;
  std::shared_ptr<const Visibility> visibility;
};
using MakeVisibility = std::function<std::shared_ptr<const Visibility>(const Surface&)>;

// The limits of give_up_faces_within().
struct FaceLimits {
  double max_loss_db = 0;
  double pixels = 0;  // distance that the surface may move by, in pixels of the stored views as they are now
  CellOptions cells;
};

// Puts a surface of fewer faces under the stored views if the pictures then lose no more than the limits allow, by
// measurement (see HeldOutLoss, which must be able to tell), with references given up too; returns the loss. Else the
// surface is what it was, and none is returned. `turned_away`: cameras of offered views that are not stored, which
// count for coverage. `seen` is what the planner sees, and must outlive it. Throws GlError as HeldOutLoss does; the
// surface is what it was then, too. Throws std::runtime_error where the planner's own views could not be seen again,
// for then it is of no use.
[[nodiscard]] std::optional<MeasuredLoss> give_up_faces_within(const FaceLimits& limits, double reference_loss_db,
                                                               const std::vector<Camera>& turned_away,
                                                               const MakeVisibility& make_visibility, SeenSurface& seen,
                                                               const Atlas& atlas, Planner& planner,
                                                               HeldOutLoss& measured);

}  // namespace lumatlas
