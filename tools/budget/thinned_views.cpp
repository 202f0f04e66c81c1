// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/thinned_views.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "planner/pruning/hindsight.h"
#include "planner/pruning/pruning.h"
#include "tools/budget/most_steps_within.h"

namespace lumatlas {

ThinnedViews thin_views_within(double max_loss_db, double reference_loss_db, Planner& planner, HeldOutLoss& measured) {
  ThinnedViews thinned;
  const std::vector<ThinningStep> order = Hindsight(planner).thinning_order();
  const std::size_t close_enough = std::max<std::size_t>(1, order.size() / 64);
  const auto without = [&](std::size_t views) -> HeldOutLoss::GivenUp {
    return {views > 0 ? std::optional(order[views - 1].gap) : std::nullopt, reference_loss_db};
  };
  const auto most_that_fit = [&](std::size_t too_far, std::optional<double> bound_db) {
    return most_steps_within(max_loss_db, too_far, close_enough,
                             [&](std::size_t views) { return measured.now(without(views), bound_db).at_most_db(); });
  };
  std::size_t fits = most_that_fit(order.size(), max_loss_db);
  thinned.loss = measured.now(without(fits));
  if (fits > 0 && thinned.loss.mean_db > max_loss_db) {  // few folds had predicted less
    fits = most_that_fit(fits, {});
    thinned.loss = measured.now(without(fits));
  }
  std::vector<ViewSlot> gone;
  for (std::size_t i = 0; i < fits; ++i) {
    gone.push_back(order[i].slot);
    thinned.taken_away.push_back(planner.store().name_of(order[i].slot));
  }
  Pruning(planner).evict(gone);
  return thinned;
}

}  // namespace lumatlas
