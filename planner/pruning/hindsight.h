// SPDX-License-Identifier: GPL-3.0-or-later
// Computes what a planner's store would be if other views had been offered or evicted, and changes nothing. Callers
// use it to measure which views a store can do without.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planner/planner.h"

namespace lumatlas {

// One step of taking away a store's views, the one that is missed least first.
struct ThinningStep {
  ViewSlot slot;
  double gap = 0;  // share of scov that is lost since before the first step, in [0, 1]
};

// No slot may be promised (std::logic_error). `absent`: slots of views to count as never offered. Views that are not
// stored count as never offered too.
class Hindsight {
 public:
  // The planner must outlive it.
  explicit Hindsight(const Planner& planner) : store_(planner.store()) {}

  // Returns the order in which stored views would be evicted, down to the last.
  [[nodiscard]] std::vector<ThinningStep> thinning_order(std::span<const ViewSlot> absent = {}) const;
  // Returns what cells would refer to were only these views left, and after Pruning::give_up_references(max_loss_db).
  [[nodiscard]] ReferenceTable references_among(std::span<const ViewSlot> slots, std::span<const ViewSlot> absent = {},
                                                double max_loss_db = 0) const;

 private:
  [[nodiscard]] std::vector<ViewSlot> stored_slots_but(std::span<const ViewSlot> absent) const;
  [[nodiscard]] CoverageLedger ledger_of(std::span<const ViewSlot> slots, std::span<const ViewSlot> offered) const;

  const PlannedStore& store_;
};

}  // namespace lumatlas
