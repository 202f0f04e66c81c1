// SPDX-License-Identifier: GPL-3.0-or-later
// Lenses that turn out to be wrong while a model is built: photographs are undistorted again, from the originals, and
// so are those that are read afterwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "planner/planner.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/refinement/originals.h"
#include "tools/scene/scene.h"

namespace lumatlas {

class LensRefinement {
 public:
  // `views` holds all that are stored; their corrections follow the lenses. `lenses`: what is known of each. Both must
  // outlive this object, and both may grow. `warn`, which may be empty, is told in a sentence why lenses stay as they
  // are: see correct().
  LensRefinement(Planner& planner, std::vector<SceneView>& views, std::vector<RefinedLens>& lenses,
                 WarnOfOriginals warn)
      : planner_(planner), views_(views), lenses_(lenses), warn_(std::move(warn)) {}

  // A look at few points, which is enough where no view had to move: whether it shows that no lens is wrong. Poses that
  // moved may have taken up most of what a lens gets wrong, and few points then do not show the rest.
  bool seem_right();
  // Returns whether the last estimate was LensEstimates::too_large.
  [[nodiscard]] bool too_large() const { return too_large_; }
  // Estimates the lenses from about `points` points of all stored views together, and undistorts again the photographs
  // of those that are plainly wrong. Returns whether there were any. Throws InputError for a photograph that cannot be
  // read again. With `warn`, all files are looked at first: if one is gone or has another size now, lenses stay as they
  // are from then on. Only damage to pixels, or a file that goes in that moment, still throws.
  bool correct(std::size_t points);

 private:
  [[nodiscard]] RefinedLens& lens_of(const Camera& camera);
  void note(const LensEstimates& estimates);
  bool find_originals(const LensEstimates& estimates);

  Planner& planner_;
  std::vector<SceneView>& views_;
  std::vector<RefinedLens>& lenses_;
  WarnOfOriginals warn_;
  bool lost_originals_ = false, too_large_ = false;
};

// Counts the stored views of each lens.
void count_views(const Atlas& atlas, std::vector<RefinedLens>& lenses);

}  // namespace lumatlas
