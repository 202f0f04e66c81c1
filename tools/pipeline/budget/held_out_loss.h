// SPDX-License-Identifier: GPL-3.0-or-later
// What a store loses when faces of its mesh are taken away, or its photographs compressed, downscaled or taken away, or
// tiles of them, measured in pictures. The photographs are dealt into folds. Those of a fold are drawn from a store of
// the others, as if they had never been offered, before and after: what is lost in them is what is lost in any picture
// from in between. Only where no view is left to blend, the surface has the averaged colours of all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/images/photograph.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "planner/hindsight.h"
#include "planner/planner.h"
#include "tools/pipeline/budget/measured_loss.h"
#include "tools/pipeline/build_progress.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

class HeldOutLoss {
 public:
  // Draws from what `atlas`, which `planner` fills, holds now, with an OpenGL context of its own; all must outlive it.
  // Throws GlError where there is none, or where it has no room for all views. Each fold that is drawn is a step of
  // `stage`.
  HeldOutLoss(const Planner& planner, const Atlas& atlas, BuildStage& stage);

  // Whether enough photographs show surface that others show too.
  [[nodiscard]] bool can_tell() const;

  // What each fold's store gives up besides.
  struct GivenUp {
    std::optional<double> gap;     // views, as long as ThinningStep::gap stays within this, in [0, 1]
    double reference_loss_db = 0;  // references, for so much predicted loss: see Planner::give_up_references()
    // Tiles, but for this share of those of the whole store, in (0, 1]: see planner/tile_choice.h. Near 1, where a fold
    // has fewer than these, but for about that share of its own.
    double tile_share = 1;
  };
  // Of the views that the atlas holds now, in the slots that they were in then, and of its surface. With `bound_db`
  // only of PSNR, and as exactly as it takes to know whether the loss is within it. Throws std::logic_error unless
  // can_tell(), and for tiles of whole views, and GlError as above.
  [[nodiscard]] MeasuredLoss now(const GivenUp& given_up, std::optional<double> bound_db = {});

 private:
  // A photograph, or a part of it: its camera sees just that.
  struct Picture {
    Camera camera;
    Photograph photograph;             // its colours
    std::vector<std::uint8_t> counts;  // by pixel, 1: it is compared
    Scores whole;                      // of the whole store
  };
  struct Fold {
    std::vector<std::uint32_t> absent;  // the slots of its views
    std::vector<Picture> pictures;      // of some of them
    std::vector<ThinningStep> order;    // of the other folds' views; empty until somebody asks
  };
  [[nodiscard]] static Picture picture_of(const StoredView& view, std::uint32_t side_px, std::size_t index);
  void deal(const std::vector<std::uint32_t>& slots);
  [[nodiscard]] std::vector<std::uint32_t> kept_of(Fold& fold, std::optional<double> gap) const;
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
