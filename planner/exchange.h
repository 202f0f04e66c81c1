// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the stored views that leave for an offered one while the store is full (Erat et al. 2019, section 3.2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planner/coverage/coverage_ledger.h"
#include "planner/planned_store.h"

namespace lumatlas {

struct Exchange {
  std::vector<ViewSlot> victims;  // slots of the views that leave; none where there is room
  double gain = 0;                // rise of scov
};

// Returns the exchange that raises scov most, for a view that sees `parts` and takes `bytes`. The view must not be
// larger than PlannerOptions::max_bytes, so that it has room once all others have left.
[[nodiscard]] Exchange best_exchange(const PlannedStore& store, std::span<const CellPart> parts, std::uint64_t bytes);

}  // namespace lumatlas
