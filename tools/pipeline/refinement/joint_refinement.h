// SPDX-License-Identifier: GPL-3.0-or-later
// Refines all stored views together, and the lenses that took them, once the stream has ended.
#pragma once

#include <vector>

#include "planner/planner.h"
#include "tools/budget/build_progress.h"
#include "tools/pipeline/build_model.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// With RefineMode::joint polishes the stored views once, estimates their lenses and, where one is plainly wrong,
// undistorts its photographs again from the originals. If views have moved it then solves for all poses at once, unless
// the last correction of a lens has done so or there are too many views, and polishes until they rest. With masks,
// masks what they contradict at last. `views` are those of the stream, whose cameras follow the lenses; `result` learns
// what was done. Throws as LensRefinement::correct().
void refine_jointly(Planner& planner, std::vector<SceneView>& views, const BuildOptions& options,
                    const BuildCallback& callback, BuildResult& result);

}  // namespace lumatlas
