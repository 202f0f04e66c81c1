// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of fewer faces than half a pixel of the photographs allows, where its bytes are worth more as photographs, or
// where these were downscaled.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "atlas/atlas.h"
#include "mesh/visibility.h"
#include "planner/planner.h"
#include "tools/pipeline/held_out_loss.h"
#include "tools/scene/surface_input.h"

namespace lumatlas {

// With fewer faces, so that mesh and tables take a quarter of `budget_bytes` on the GPU at most, or as many as four for
// each cell: those that are larger than a cell would be split again.
[[nodiscard]] SurfaceInput with_room_for_photographs(const SurfaceInput& input, const CellOptions& cells,
                                                     std::uint64_t budget_bytes);

// A surface, and who sees it.
struct SeenSurface {
  SurfaceInput input;
  std::shared_ptr<const Visibility> visibility;
};
using MakeVisibility = std::function<std::shared_ptr<const Visibility>(const Surface&)>;

// Puts a surface of fewer faces under the stored views, which moves by at most `pixels` of theirs as they are now, if
// the pictures then lose at most so much, dB, by measurement (see HeldOutLoss, which must be able to tell); returns the
// loss. Else all is as it was but for rounding, and none is returned. Throws GlError as HeldOutLoss does; all is as it
// was then, too. `seen` is what the planner sees, and must outlive it.
[[nodiscard]] std::optional<MeasuredLoss> give_up_faces_within(double max_loss_db, double reference_loss_db,
                                                               double pixels, const CellOptions& cells,
                                                               const MakeVisibility& make_visibility, SeenSurface& seen,
                                                               const Atlas& atlas, Planner& planner,
                                                               HeldOutLoss& measured);

}  // namespace lumatlas
