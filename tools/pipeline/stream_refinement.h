// SPDX-License-Identifier: GPL-3.0-or-later
// What RefineMode::all does while the stream goes on, so that what is stored next is compared with views that are
// right.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/planner.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/lens_refinement.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// As soon as 16 views are stored, and whenever half as many again have come, all of them are polished and their lenses
// looked at, unless views rest. Where nothing is wrong with a lens, the next look waits for twice as many.
class StreamRefinement {
 public:
  // What the references name must outlive this object; `views` and `lenses` as for LensRefinement.
  StreamRefinement(Planner& planner, std::vector<SceneView>& views, std::vector<RefinedLens>& lenses,
                   const BuildOptions& options)
      : planner_(planner), lenses_(lenses), refinement_(planner, views, lenses), options_(options) {}

  // A view is about to be offered: its photograph is to be undistorted by what is known of its lens.
  void before_offer(SceneView& view) const;
  // A view was offered, and is among the views. Throws as LensRefinement::correct().
  void after_offer();

 private:
  Planner& planner_;
  const std::vector<RefinedLens>& lenses_;
  LensRefinement refinement_;
  const BuildOptions& options_;
  std::uint32_t next_polish_ = 16, next_look_ = 16;  // with so many stored views
};

}  // namespace lumatlas
