// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/pipeline/: `--budget auto`, a model that is as small as a bound on its loss allows. Once the stream
// has ended and all is refined, photographs are compressed and downscaled, faces and photographs taken away as far as
// measurement allows, see held_out_loss.h. Where it cannot tell, for want of OpenGL or of photographs that show the
// same, views and references are given up by prediction alone, see Pruning::prune().
#pragma once

#include "atlas/atlas.h"
#include "planner/planner.h"
#include "tools/budget/build_progress.h"
#include "tools/budget/fewer_faces.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/views/streaming.h"

namespace lumatlas {

// Needs PlannerOptions::max_loss_db. Notes in the result what was given up, and warns there where OpenGL failed. `seen`
// is what the planner sees, and is so afterwards.
void give_up_within_loss(Planner& planner, Atlas& atlas, SeenSurface& seen, const MakeVisibility& make_visibility,
                         const Stream& stream, const BuildCallback& callback, BuildResult& result);

}  // namespace lumatlas
