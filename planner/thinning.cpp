// SPDX-License-Identifier: GPL-3.0-or-later
// PlannerOptions::max_loss_db: a store that grows only as far as it must, and gives back what it can do without.
#include <algorithm>
#include <stdexcept>

#include "planner/planner.h"
#include "planner/predicted_loss.h"

namespace lumatlas {

namespace {

// Of PlannerOptions::max_loss_db, while the stream goes on: a view that is turned away does not come back, but one that
// is kept can be taken away again, so thin() is to have what it can choose among.
constexpr double kShareWhileGrowing = 0.5;

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
    const std::uint32_t least = lowest_ranked(slots, 1).front();
    if (predicted_loss_db(offered_->gap_without(ledger_, least)) > *options_.max_loss_db) break;
    gone.push_back(atlas_.view(least)->name);
    evict(least);
    std::erase(slots, least);
  }
  return gone;
}

PredictedLoss Planner::predicted_loss() const {
  if (!offered_) throw std::logic_error("planner: max_loss_db is not set, no loss is predicted");
  const double gap = offered_->gap(ledger_);
  return {gap, predicted_loss_db(gap), short_of_room_};
}

}  // namespace lumatlas
