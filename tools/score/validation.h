// SPDX-License-Identifier: GPL-3.0-or-later
// Scores a model on photographs that were held out, beside the two baselines, over the pixels where the mesh is seen.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>

#include "atlas/atlas.h"
#include "blend/blend_options.h"
#include "blend/gl/egl_context.h"
#include "tools/scene/scene.h"
#include "tools/score/report/report.h"
#include "tools/texture/placed_photographs.h"

namespace lumatlas {

struct ValidationOptions {
  // Without it, the views with SceneView::held_out are scored; `test` is needed if there are none.
  std::optional<HoldOut> protocol = HoldOut();
  std::optional<SceneViews> test;  // score every view of this workspace, instead of those that the protocol scores
  BlendOptions blend;
  ValidityOptions validity;  // for the unbounded baseline's masks
  bool unbounded = false;    // the baseline of all input views, which needs memory for all of them, and time
  bool texture = false;      // the baseline of a conventional texture for the model's mesh, from its views
  // The same from these photographs too, of which none is scored; empty: no such baseline.
  OfferedPhotographs texture_all;
  bool vertex = true;              // the baseline of averaged vertex colours
  bool aligned = true;             // also score with the held-out pose refined against each method
  std::optional<SceneViews> path;  // consecutive frames with their true pictures: also measure flicker along them
  bool pictures = true;            // write photograph, rendering and error of every scored view
  bool quiet = false;
  // Called, from any thread, with how much of the whole is done. What it throws ends the work. Empty: not called.
  std::function<void(std::size_t done, std::size_t total)> told;
};

// Renders every scored view, and the frames of the path, with each method ("store", "texture", "texture-all",
// "unbounded", "vertex"),
// writes the pictures of the views into `folder`, which must exist, and returns what the report page shows. Needs a GL
// context current on this thread. Throws InputError if the model holds a view that the protocol leaves out, or if
// nothing is left to score, or if the test views are the scene itself.
[[nodiscard]] Report validate_model(const Snapshot& model, const SceneViews& scene, const EglContext& context,
                                    const ValidationOptions& options, const std::filesystem::path& folder);

}  // namespace lumatlas
