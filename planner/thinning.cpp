// SPDX-License-Identifier: GPL-3.0-or-later
// A store that grows only as far as PlannerOptions::max_loss_db says that it must, and gives back what it can do
// without.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

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
// view less saves more bytes than all of them.
constexpr double kShareOfReferences = 0.25;
constexpr double kMostForReferences = 0.025;

double bound_of_references(double bound_db) {
  return std::min(kShareOfReferences * bound_db, kMostForReferences);
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
std::vector<ReferenceInOrder> references_in_order(const CoverageLedger& ledger) {
  std::vector<std::vector<ReferenceLoss>> losses(ledger.cells());
  tbb::parallel_for(std::size_t{0}, losses.size(), [&](std::size_t cell) {
    losses[cell] = ledger.reference_losses(static_cast<std::uint32_t>(cell));
  });
  std::vector<ReferenceInOrder> order;
  for (std::uint32_t cell = 0; cell < losses.size(); ++cell) {
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

// The sum over all cells.
ReferenceService service_of(const CoverageLedger& ledger) {
  std::vector<ReferenceService> of_cells(ledger.cells());
  tbb::parallel_for(std::size_t{0}, of_cells.size(), [&](std::size_t cell) {
    of_cells[cell] = ledger.reference_service(static_cast<std::uint32_t>(cell));
  });
  ReferenceService sum;
  for (const ReferenceService& service : of_cells) {
    sum.of_kept += service.of_kept;
    sum.of_all += service.of_all;
    sum.given_up += service.given_up;
  }
  return sum;
}

// By cell, the slots that it can do without as long as that is predicted to cost at most so much, dB. What a cell loses
// grows from one reference to the next, so the cells' own orders, merged by loss, are the best order of all.
std::vector<std::vector<std::uint32_t>> dispensable_references(const CoverageLedger& ledger, double max_loss_db) {
  std::vector<std::vector<std::uint32_t>> given_up(ledger.cells());
  if (!(max_loss_db > 0)) return given_up;
  const ReferenceService service = service_of(ledger);
  double lost = 0;
  for (const ReferenceInOrder& next : references_in_order(ledger)) {
    lost += next.loss;
    if (predicted_reference_loss_db(reference_gap(service, lost) + kGapRounding) > max_loss_db) break;
    given_up[next.cell].push_back(next.slot);
  }
  return given_up;
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
  const double bound = *options_.max_loss_db;
  for (std::vector<std::uint32_t> slots = stored_slots(); !slots.empty();) {
    may_interrupt(options_.refinement.interruption_point);
    const std::uint32_t least = lowest_ranked(ledger_, slots, 1).front();
    if (predicted_loss_db(offered_->gap_without(ledger_, least)) > bound - bound_of_references(bound)) break;
    gone.push_back(atlas_.view(least)->name);
    evict(least);
    std::erase(slots, least);
  }
  give_up_references(bound > 0 ? bound - predicted_loss_db(offered_->gap(ledger_)) : 0);
  return gone;
}

double Planner::loss_of_references() const {
  return offered_ ? bound_of_references(*options_.max_loss_db) : 0;
}

std::vector<std::uint32_t> Planner::stored_slots_but(std::span<const std::uint32_t> absent) const {
  if (std::any_of(promised_.begin(), promised_.end(), [](const auto& promise) { return promise.has_value(); })) {
    throw std::logic_error("planner: a slot is promised, so it is not known what the store holds");
  }
  std::vector<std::uint32_t> slots = stored_slots();
  std::erase_if(slots,
                [&](std::uint32_t slot) { return std::find(absent.begin(), absent.end(), slot) != absent.end(); });
  return slots;
}

// Of a store that was offered some of the stored views, and holds some of these.
CoverageLedger Planner::ledger_of(std::span<const std::uint32_t> slots, std::span<const std::uint32_t> offered) const {
  CoverageLedger ledger(*atlas_.surface(), atlas_.capacity(), options_.coverage, options_.min_reference_gain);
  for (const std::uint32_t slot : offered) ledger.ask(ledger_.parts(slot));
  for (const std::uint32_t slot : slots) {
    may_interrupt(options_.refinement.interruption_point);
    const std::span<const CellPart> parts = ledger_.parts(slot);
    ledger.insert(slot, {parts.begin(), parts.end()});
  }
  return ledger;
}

std::vector<ThinningStep> Planner::thinning_order(std::span<const std::uint32_t> absent) const {
  std::vector<std::uint32_t> slots = stored_slots_but(absent);
  CoverageLedger ledger = ledger_of(slots, slots);
  const double whole = ledger.summed_coverage();
  std::vector<ThinningStep> order;
  while (!slots.empty()) {
    may_interrupt(options_.refinement.interruption_point);
    const std::uint32_t least = lowest_ranked(ledger, slots, 1).front();
    ledger.erase(least);
    const double gap = whole > 0 ? std::clamp(1 - ledger.summed_coverage() / whole, 0.0, 1.0) : 0;
    order.push_back({least, order.empty() ? gap : std::max(gap, order.back().gap)});  // but for rounding it rises
    std::erase(slots, least);
  }
  return order;
}

ReferenceTable Planner::references_among(std::span<const std::uint32_t> slots, std::span<const std::uint32_t> absent,
                                         double max_loss_db) const {
  CoverageLedger ledger = ledger_of(slots, stored_slots_but(absent));
  const std::vector<std::vector<std::uint32_t>> given_up = dispensable_references(ledger, max_loss_db);
  ReferenceTable table;
  for (std::uint32_t cell = 0; cell < ledger.cells(); ++cell) {
    if (!given_up[cell].empty()) ledger.give_up(cell, given_up[cell]);
    const std::vector<std::uint32_t> references = ledger.references(cell);
    table.views.insert(table.views.end(), references.begin(), references.end());
    table.offsets.push_back(static_cast<std::uint32_t>(table.views.size()));
  }
  return table;
}

void Planner::take_away(std::span<const std::uint32_t> slots) {
  for (const std::uint32_t slot : slots) {
    if (slot < atlas_.capacity() && ledger_.stored(slot)) continue;
    throw std::logic_error("planner: slot " + std::to_string(slot) + " holds no view that could be taken away");
  }
  for (const std::uint32_t slot : slots) evict(slot);
}

void Planner::give_up_references(double max_loss_db) {
  const std::vector<std::vector<std::uint32_t>> given_up = dispensable_references(ledger_, max_loss_db);
  for (std::uint32_t cell = 0; cell < given_up.size(); ++cell) {
    if (given_up[cell].empty()) continue;
    ledger_.give_up(cell, given_up[cell]);
    atlas_.set_references(cell, ledger_.references(cell));
  }
}

PredictedLoss Planner::predicted_loss() const {
  if (!offered_) throw std::logic_error("planner: max_loss_db is not set, no loss is predicted");
  const ReferenceService service = service_of(ledger_);
  PredictedLoss predicted;
  predicted.gap = offered_->gap(ledger_);
  predicted.reference_gap = reference_gap(service, 0);
  predicted.loss_db = predicted_loss_db(predicted.gap) + predicted_reference_loss_db(predicted.reference_gap);
  predicted.references_given_up = service.given_up;
  predicted.short_of_room = short_of_room_;
  return predicted;
}

}  // namespace lumatlas
