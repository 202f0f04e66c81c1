// SPDX-License-Identifier: GPL-3.0-or-later
// Measures in pictures what a store loses when faces of its mesh are removed, or when its photographs or tiles of them
// are compressed, downscaled or removed. The photographs are dealt into folds. Those of a fold are drawn from a
// store of the others, as if they had never been offered, before and after. The loss in them is what any picture in
// between loses. Where no view is left to blend, the surface has the averaged colours of all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/images/photograph.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "planner/planner.h"
#include "planner/pruning/hindsight.h"
#include "tools/budget/build_progress.h"
#include "tools/budget/measured_loss.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

class HeldOutLoss {
 public:
  // Draws the present views of `atlas`, which `planner` fills, with an OpenGL context of its own; all must outlive it.
  // Throws GlError if there is none, or if all views do not fit. Each fold that is drawn is a step of `stage`.
  HeldOutLoss(const Planner& planner, const Atlas& atlas, BuildStage& stage);

  // Returns whether enough photographs show surface that others show too.
  [[nodiscard]] bool can_tell() const;

  // The parts of a model that each fold's store gives up.
  struct GivenUp {
    std::optional<double> gap;     // views, as long as ThinningStep::gap stays within this, in [0, 1]
    double reference_loss_db = 0;  // references, up to this predicted loss: see Pruning::give_up_references()
    // Fraction of the full store's tiles to keep, in (0, 1]: 0.5 keeps half of them, see planner/tile_choice.h. A fold
    // that has fewer tiles than that keeps about this fraction of its own.
    double tile_share = 1;
  };
  // Measures the views that the atlas holds now, in the view slots that they were in then, and its surface. With
  // `bound_db` it measures PSNR alone, only as exactly as it takes to know whether the loss is within the bound. Throws
  // std::logic_error unless can_tell(), and for tiles of whole views, and GlError as above.
  [[nodiscard]] MeasuredLoss now(const GivenUp& given_up, std::optional<double> bound_db = {});

 private:
  // A photograph, or a part of it: its camera sees just that.
  struct Picture {
    Camera camera;
    Photograph photograph;             // its colours
    std::vector<std::uint8_t> counts;  // one per pixel, 1: it is compared
    Scores whole;                      // for the whole store
  };
  struct Fold {
    std::vector<ViewSlot> absent;     // the slots of its views
    std::vector<Picture> pictures;    // some of its pictures
    std::vector<ThinningStep> order;  // order of thinning the other folds' views; empty until it is needed
  };
  [[nodiscard]] static Picture picture_of(const StoredView& view, std::uint32_t side_px, std::size_t index);
  void deal(const std::vector<ViewSlot>& slots);
  [[nodiscard]] std::vector<ViewSlot> kept_of(Fold& fold, std::optional<double> gap) const;
  void load(Fold& fold, const GivenUp& given_up);
  void keep_tiles(double share, Snapshot& store) const;
  void compare_with_whole(Picture& picture);
  [[nodiscard]] Rendering draw(const Picture& picture);
  [[nodiscard]] static double psnr_of(const Picture& picture, const Rendering& drawn);

  const Planner& planner_;
  const Atlas& atlas_;
  BuildStage& stage_;
  Snapshot store_;
  EglContext context_;
  Renderer renderer_;
  std::vector<Fold> folds_;
};

}  // namespace lumatlas
