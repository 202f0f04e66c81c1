// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs that give up pixels, all alike. Blended from three photographs, and by poses that are never exact, a
// picture shows less detail than each has.
#pragma once

#include <memory>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "tools/budget/held_out_loss.h"

namespace lumatlas {

// Throws std::invalid_argument unless it is in (0, 1].
void require_share_of_sides(double share);

// The stored views at any scale, each made from its original, because filtering twice would blur twice. The atlas must
// not change otherwise meanwhile. It must outlive this object, as `visibility` must.
class ScaledViews {
 public:
  ScaledViews(Atlas& atlas, const Visibility& visibility, const ValidityOptions& validity);

  // In (0, 1] (std::invalid_argument), 1 at first; with 1 they are as they were, to the last bit.
  void scale_to(double share);

 private:
  [[nodiscard]] TiledView scaled(const StoredView& view, double share) const;

  Atlas& atlas_;
  const Visibility& visibility_;
  ValidityOptions validity_;
  double share_ = 1;  // scale of the sides, as the views are now; 0: only some were scaled
  std::vector<std::shared_ptr<const StoredView>> views_;  // one per view slot
};

// Returns the options by which depth edges are masked in views that are downscaled by `scale`, (0, 1]
// (std::invalid_argument): as wide on the surface as before, rounded up to a pixel.
[[nodiscard]] ValidityOptions validity_at_scale(const ValidityOptions& validity, double scale);

struct DownscaledViews {
  double scale = 1;   // scale of a photograph's sides
  MeasuredLoss loss;  // only as exactly as it took to decide; 0 at full resolution, whatever the references and texels
};
// Downscales the views as far as the pictures lose at most this many dB by measurement, with references given up too
// (see HeldOutLoss), but not below `least`, in (0, 1] (std::invalid_argument); in eight steps. `measured` was made of
// the views as they are now, and must be able to tell. Throws GlError as it does, and has then changed nothing.
[[nodiscard]] DownscaledViews downscale_views_within(double max_loss_db, double reference_loss_db, Atlas& atlas,
                                                     HeldOutLoss& measured, const Visibility& visibility,
                                                     const ValidityOptions& validity, double least);

}  // namespace lumatlas
