// SPDX-License-Identifier: GPL-3.0-or-later
// PlannerOptions::max_loss_db: a store that grows only as far as it must, and gives back what it can do without.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "planner/planner.h"
#include "planner/predicted_loss.h"

namespace lumatlas {

namespace {

// The share of PlannerOptions::max_loss_db that may be lost while the stream goes on. It is less than all of it,
// because a view that is turned away does not come back while one that is kept can still be taken away: thin() chooses
// better among more views.
constexpr double kShareWhileGrowing = 0.5;
// The share of max_loss_db that may be lost by giving up references, and its bound in dB; taking views away may lose
// the rest. References get the small part, because little is enough for most of those that can be given up, and one
// view less saves more bytes than all of them: see planner/README.md.
constexpr double kShareOfReferences = 0.25;
constexpr double kMostForReferences = 0.025;

double bound_of_views(double bound_db) {
  return bound_db - std::min(kShareOfReferences * bound_db, kMostForReferences);
}

// The share of the service of all references, those that were given up among them, that is missing once the kept ones
// lose `lost` more.
double reference_gap(const ReferenceService& service, double lost) {
  if (!(service.of_all > 0)) return 0;
  return std::clamp((service.of_all - service.of_kept + lost) / service.of_all, 0.0, 1.0);
}

struct ReferenceInOrder {
  double key;  // what the cell loses with it, or lost with one before, if that was more
  std::uint32_t cell;
  std::uint32_t place;  // in the cell's own order
  std::uint32_t slot;
  double loss;
};

// All references that cells can give up, the one that is missed least first.
std::vector<ReferenceInOrder> references_in_order(const CoverageLedger& ledger, std::size_t cells) {
  std::vector<std::vector<ReferenceLoss>> losses(cells);
  tbb::parallel_for(std::size_t{0}, cells, [&](std::size_t cell) {
    losses[cell] = ledger.reference_losses(static_cast<std::uint32_t>(cell));
  });
  std::vector<ReferenceInOrder> order;
  for (std::uint32_t cell = 0; cell < cells; ++cell) {
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

// Whether the store may not do without the view: see PlannerOptions::max_loss_db.
bool Planner::is_needed(std::span<const CellPart> seen) const {
  if (!offered_) return true;
  return predicted_loss_db(offered_->gap(ledger_, seen)) > kShareWhileGrowing * *options_.max_loss_db;
}

void Planner::count_offered(std::span<const CellPart> seen) {
  if (offered_) offered_->add(seen);
}

std::vector<std::string> Planner::thin() {
  std::vector<std::string> gone;
  if (!offered_) return gone;
  for (std::vector<std::uint32_t> slots = stored_slots(); !slots.empty();) {
    may_interrupt(options_.refinement.interruption_point);
    const std::uint32_t least = lowest_ranked(slots, 1).front();
    if (predicted_loss_db(offered_->gap_without(ledger_, least)) > bound_of_views(*options_.max_loss_db)) break;
    gone.push_back(atlas_.view(least)->name);
    evict(least);
    std::erase(slots, least);
  }
  if (*options_.max_loss_db > 0) give_up_references();
  return gone;
}

// The sum over all cells.
ReferenceService Planner::reference_service() const {
  std::vector<ReferenceService> of_cells(atlas_.surface().cells.cells.size());
  tbb::parallel_for(std::size_t{0}, of_cells.size(), [&](std::size_t cell) {
    of_cells[cell] = ledger_.reference_service(static_cast<std::uint32_t>(cell));
  });
  ReferenceService sum;
  for (const ReferenceService& service : of_cells) {
    sum.of_kept += service.of_kept;
    sum.of_all += service.of_all;
    sum.given_up += service.given_up;
  }
  return sum;
}

// What a cell loses grows from one reference to the next, so the cells' own orders, merged by loss, are the best order
// of all.
void Planner::give_up_references() {
  const ReferenceService service = reference_service();
  const double room_db = *options_.max_loss_db - predicted_loss_db(offered_->gap(ledger_));
  std::vector<std::vector<std::uint32_t>> given_up(atlas_.surface().cells.cells.size());
  double lost = 0;
  for (const ReferenceInOrder& next : references_in_order(ledger_, given_up.size())) {
    lost += next.loss;
    if (predicted_reference_loss_db(reference_gap(service, lost) + kGapRounding) > room_db) break;
    given_up[next.cell].push_back(next.slot);
  }
  for (std::uint32_t cell = 0; cell < given_up.size(); ++cell) {
    if (given_up[cell].empty()) continue;
    ledger_.give_up(cell, given_up[cell]);
    atlas_.set_references(cell, ledger_.references(cell));
  }
}

PredictedLoss Planner::predicted_loss() const {
  if (!offered_) throw std::logic_error("planner: max_loss_db is not set, no loss is predicted");
  const ReferenceService service = reference_service();
  PredictedLoss predicted;
  predicted.gap = offered_->gap(ledger_);
  predicted.reference_gap = reference_gap(service, 0);
  predicted.loss_db = predicted_loss_db(predicted.gap) + predicted_reference_loss_db(predicted.reference_gap);
  predicted.references_given_up = service.given_up;
  predicted.short_of_room = short_of_room_;
  return predicted;
}

}  // namespace lumatlas
