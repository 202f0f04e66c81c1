// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/pruning/hindsight.h"

#include <algorithm>

#include "planner/pruning/dispensable_references.h"

namespace lumatlas {

std::vector<ViewSlot> Hindsight::stored_slots_but(std::span<const ViewSlot> absent) const {
  store_.require_no_promise();
  std::vector<ViewSlot> slots = store_.held_slots();
  std::erase_if(slots, [&](ViewSlot slot) { return std::find(absent.begin(), absent.end(), slot) != absent.end(); });
  return slots;
}

// Returns the ledger of a store that was offered some of the stored views, and holds some of these.
CoverageLedger Hindsight::ledger_of(std::span<const ViewSlot> slots, std::span<const ViewSlot> offered) const {
  const PlannerOptions& options = store_.options();
  CoverageLedger ledger(*store_.atlas().surface(), store_.atlas().capacity(), options.coverage,
                        options.min_reference_gain);
  for (const ViewSlot slot : offered) ledger.add_demand(store_.ledger().parts(slot));
  for (const ViewSlot slot : slots) {
    check_cancelled(store_.options().refinement.cancel_check);
    const std::span<const CellPart> parts = store_.ledger().parts(slot);
    ledger.insert(slot, {parts.begin(), parts.end()});
  }
  return ledger;
}

std::vector<ThinningStep> Hindsight::thinning_order(std::span<const ViewSlot> absent) const {
  std::vector<ViewSlot> slots = stored_slots_but(absent);
  CoverageLedger ledger = ledger_of(slots, slots);
  const double whole = ledger.summed_coverage();
  std::vector<ThinningStep> order;
  while (!slots.empty()) {
    check_cancelled(store_.options().refinement.cancel_check);
    const ViewSlot least = missed_least(ledger, slots, 1).front();
    ledger.erase(least);
    const double gap = whole > 0 ? std::clamp(1 - ledger.summed_coverage() / whole, 0.0, 1.0) : 0;
    order.push_back({least, order.empty() ? gap : std::max(gap, order.back().gap)});  // rounding may lower it
    std::erase(slots, least);
  }
  return order;
}

ReferenceTable Hindsight::references_among(std::span<const ViewSlot> slots, std::span<const ViewSlot> absent,
                                           double max_loss_db) const {
  CoverageLedger ledger = ledger_of(slots, stored_slots_but(absent));
  const std::vector<std::vector<ViewSlot>> given_up = dispensable_references(ledger, max_loss_db);
  ReferenceTable table;
  for (CellId cell{0}; cell < ledger.cells(); ++cell) {
    if (!given_up[cell].empty()) ledger.give_up(cell, given_up[cell]);
    const std::vector<ViewSlot> references = ledger.references(cell);
    table.views.insert(table.views.end(), references.begin(), references.end());
    table.offsets.push_back(static_cast<std::uint32_t>(table.views.size()));
  }
  return table;
}

}  // namespace lumatlas
