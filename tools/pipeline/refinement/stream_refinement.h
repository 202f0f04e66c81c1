// SPDX-License-Identifier: GPL-3.0-or-later
// The part of RefineMode::all that runs while the stream goes on, so that later views are compared with corrected ones.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/planner.h"
#include "tools/budget/build_progress.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/refinement/lens_refinement.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// When 16 views are stored, and whenever half as many again have come, all of them are polished and their lenses
// estimated, unless views rest and no lens seems wrong. If no lens is corrected, the poses of all are solved for
// together, and the next estimate of lenses, with the polishing before it, waits for twice as many views. An estimate
// of a lens is exact to first order only: if the last one corrected a lens, finish() polishes and estimates again, at
// most twice.
class StreamRefinement {
 public:
  // The objects that the references name must outlive this object; `views` and `lenses` as for LensRefinement.
  StreamRefinement(Planner& planner, std::vector<SceneView>& views, std::vector<RefinedLens>& lenses,
                   const BuildOptions& options)
      : planner_(planner),
        lenses_(lenses),
        refinement_(planner, views, lenses, warning_of_originals(options)),
        options_(options) {}

  // Prepares a view that is about to be offered: its photograph is undistorted by what is known of its lens.
  void before_offer(SceneView& view) const;
  // A view was offered, and is among the views. Throws as LensRefinement::correct().
  void after_offer();
  // The stream has ended. Throws as LensRefinement::correct(), and BuildStopped.
  void finish(const BuildCallback& callback);

 private:
  bool correct_lenses();

  Planner& planner_;
  const std::vector<RefinedLens>& lenses_;
  LensRefinement refinement_;
  const BuildOptions& options_;
  std::uint32_t next_step_ = 16, next_look_ = 16;  // numbers of stored views
  bool has_corrected_ = false;                     // the last estimate of lenses that may correct any
};

}  // namespace lumatlas
