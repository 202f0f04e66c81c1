// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/pruning/dispensable_references.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "planner/coverage/predicted_loss.h"

namespace lumatlas {

namespace {

struct ReferenceInOrder {
  double key;  // what the cell loses with it, or lost with one before, if that was more
  CellId cell;
  std::uint32_t place;  // in the cell's own order
  ViewSlot slot;
  double loss;
};

// All references that cells can give up, the one that is missed least first.
std::vector<ReferenceInOrder> references_in_order(const CoverageLedger& ledger) {
  std::vector<std::vector<ReferenceLoss>> losses(ledger.cells());
  tbb::parallel_for(std::size_t{0}, losses.size(), [&](std::size_t cell) {
    losses[cell] = ledger.reference_losses(CellId(static_cast<std::uint32_t>(cell)));
  });
  std::vector<ReferenceInOrder> order;
  for (CellId cell{0}; cell < losses.size(); ++cell) {
    double key = 0;
    for (std::uint32_t place = 0; place < losses[cell].size(); ++place) {
      const ReferenceLoss& entry = losses[cell][place];
      key = std::max(key, entry.loss);
      order.push_back({key, cell, place, entry.slot, entry.loss});
    }
  }
  std::sort(order.begin(), order.end(), [](const ReferenceInOrder& a, const ReferenceInOrder& b) {
    return std::tie(a.key, a.cell, a.place) < std::tie(b.key, b.cell, b.place);
  });
  return order;
}

}  // namespace

ReferenceService reference_service(const CoverageLedger& ledger) {
  std::vector<ReferenceService> of_cells(ledger.cells());
  tbb::parallel_for(std::size_t{0}, of_cells.size(), [&](std::size_t cell) {
    of_cells[cell] = ledger.reference_service(CellId(static_cast<std::uint32_t>(cell)));
  });
  ReferenceService sum;
  for (const ReferenceService& service : of_cells) {
    sum.of_kept += service.of_kept;
    sum.of_all += service.of_all;
    sum.given_up += service.given_up;
  }
  return sum;
}

double reference_gap(const ReferenceService& service, double lost) {
  if (!(service.of_all > 0)) return 0;
  return std::clamp((service.of_all - service.of_kept + lost) / service.of_all, 0.0, 1.0);
}

std::vector<std::vector<ViewSlot>> dispensable_references(const CoverageLedger& ledger, double max_loss_db) {
  std::vector<std::vector<ViewSlot>> given_up(ledger.cells());
  if (!(max_loss_db > 0)) return given_up;
  const ReferenceService service = reference_service(ledger);
  double lost = 0;
  for (const ReferenceInOrder& next : references_in_order(ledger)) {
    lost += next.loss;
    if (predicted_reference_loss_db(reference_gap(service, lost) + kGapRounding) > max_loss_db) break;
    given_up[next.cell].push_back(next.slot);
  }
  return given_up;
}

}  // namespace lumatlas
