// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/: plans, stores and refines the views of a scene whose surface is ready.
#pragma once

#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "tools/budget/build_progress.h"
#include "tools/budget/fewer_faces.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/views/streaming.h"
#include "tools/pipeline/watched_scene.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// All that is named must outlive the call of plan_views().
struct PlanningInput {
  SceneViews& views;                // their cameras follow what is found of their lenses
  Stream stream;                    // some of `views`, in the order in which they are offered
  SeenSurface& seen;                // may get fewer faces where the options bound the loss
  double usual_distance = 0;        // from camera to surface, scene units, > 0
  std::mt19937_64& random;          // for ViewChoice::random
  WatchedScene* watched = nullptr;  // null: the scene is complete
  // Changes the store before its last snapshot is taken; or empty.
  std::function<void(Atlas& atlas)> last_change = {};
};

// Returns the bad ones among the views.
[[nodiscard]] std::vector<SkippedView> skipped_views(const std::vector<SceneView>& views);

[[nodiscard]] std::shared_ptr<const Visibility> make_visibility(const Surface& surface, VisibilityBy by);

// Fills in what build_model() returns of views and their references, by the result's options. Throws as it does.
void plan_views(const PlanningInput& input, const BuildCallback& callback, const AtlasWatch& watch,
                BuildResult& result);

}  // namespace lumatlas
