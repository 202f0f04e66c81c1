// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs that a rolling shutter read while the camera moved are straightened once all are stored, from the
// originals.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "planner/planner.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/refinement/originals.h"
#include "tools/scene/scene.h"

namespace lumatlas {

class ShutterRefinement {
 public:
  // `views` holds all that are stored; their motions follow. Both references must outlive this object. `warn`, which
  // may be empty, is told in a sentence why photographs stay as they are: see straighten().
  ShutterRefinement(Planner& planner, std::vector<SceneView>& views, WarnOfOriginals warn)
      : planner_(planner), views_(views), warn_(std::move(warn)) {}

  // Estimates the motions from at most `points` points of each stored view, and makes all their photographs again where
  // the views then agree better: see ShutterEstimate::significant. Returns whether it did. Motions add up from one call
  // to the next. Views of panoramas, and all that are stored with one, stay as they are.
  //
  // Throws InputError for a photograph that cannot be read again. With `warn`, all files are looked at first: if one is
  // gone or has another size now, photographs stay as they are. Only damage to pixels, or a file that goes in that
  // moment, still throws.
  bool straighten(std::size_t points);

  [[nodiscard]] const RefinedShutters& refined() const { return refined_; }

 private:
  [[nodiscard]] bool has_originals();
  [[nodiscard]] bool has_panoramas();
  void note(const ShutterEstimate& estimate);

  Planner& planner_;
  std::vector<SceneView>& views_;
  WarnOfOriginals warn_;
  RefinedShutters refined_;
};

}  // namespace lumatlas
