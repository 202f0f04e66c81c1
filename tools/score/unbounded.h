// SPDX-License-Identifier: GPL-3.0-or-later
// The baselines that a bounded store is measured against: the lumigraph of all input views without any budget, and the
// mesh's averaged vertex colours; and what tells moved poses from the budget.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/views/validity.h"
#include "mesh/visibility/visibility.h"
#include "tools/base/progress.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Every view of `ranks`, and every cell refers to each view that has a pixel on it at full resolution. Its vertex
// colours are the mean over all of these views, so that without its references it is the baseline of averaged colours.
// Needs memory for all photographs and depths at once, 8 bytes a pixel; with `keep_views` false only the vertex colours
// are made, and no view is held. One tick a view. Throws std::invalid_argument for a surface that is null or does not
// pass check(), and for a rank that is no index into the views.
[[nodiscard]] Snapshot unbounded_lumigraph(std::shared_ptr<const Surface> surface, const std::vector<SceneView>& views,
                                           const std::vector<std::size_t>& ranks, const ValidityOptions& options,
                                           Progress& progress, bool keep_views = true);

// Only the vertex colours of a snapshot: nothing is textured.
[[nodiscard]] Snapshot without_views(const Snapshot& snapshot);

// The views of a snapshot back at the poses that the scene gives them; they keep their gains and their trust. None if
// no view of it was moved. The difference to the snapshot is what refining poses has done.
[[nodiscard]] std::optional<Snapshot> with_given_poses(const Snapshot& snapshot, const std::vector<SceneView>& views,
                                                       const Visibility& visibility, const ValidityOptions& options);

}  // namespace lumatlas
