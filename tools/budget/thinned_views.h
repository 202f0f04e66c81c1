// SPDX-License-Identifier: GPL-3.0-or-later
// Takes photographs away that a model can do without: those that coverage misses least, as many as the loss of
// pictures allows.
#pragma once

#include <string>
#include <vector>

#include "planner/planner.h"
#include "tools/budget/held_out_loss.h"

namespace lumatlas {

struct ThinnedViews {
  std::vector<std::string> taken_away;  // names, the one that is missed least first
  MeasuredLoss loss;                    // with what was lost before
};
// Removes stored views as long as the pictures lose at most this many dB by measurement, including the losses since
// `measured` was made of the same store, and with references given up too (see HeldOutLoss). At least one view stays.
// The number of views is found to one in 64, or to four fifths of the bound. `measured` must be able to tell. Throws
// GlError as it does; nothing was changed then.
[[nodiscard]] ThinnedViews thin_views_within(double max_loss_db, double reference_loss_db, Planner& planner,
                                             HeldOutLoss& measured);

}  // namespace lumatlas
