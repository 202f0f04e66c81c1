// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/pruning/pruning.h"

#include <algorithm>
#include <stdexcept>

#include "planner/coverage/predicted_loss.h"
#include "planner/pruning/dispensable_references.h"

namespace lumatlas {

namespace {

// The share of max_loss_db that may be lost by giving up references, and its bound in dB; taking views away may lose
// the rest. References get the small part, because little is enough for most of those that can be given up, and one
// view less saves more bytes than all of them.
constexpr double kShareOfReferences = 0.25;
constexpr double kMostForReferences = 0.025;

double bound_of_references(double bound_db) {
  return std::min(kShareOfReferences * bound_db, kMostForReferences);
}

}  // namespace

std::vector<std::string> Pruning::prune() {
  std::vector<std::string> gone;
  if (!store_.offered()) return gone;
  const double bound = *store_.options().max_loss_db;
  for (std::vector<ViewSlot> slots = store_.held_slots(); !slots.empty();) {
    check_cancelled(store_.options().refinement.cancel_check);
    const ViewSlot least = missed_least(store_.ledger(), slots, 1).front();
    const double gap = store_.offered()->gap_without(store_.ledger(), least);
    if (predicted_loss_db(gap) > bound - bound_of_references(bound)) break;
    gone.push_back(store_.name_of(least));
    store_.evict(least);
    std::erase(slots, least);
  }
  give_up_references(bound > 0 ? bound - predicted_loss_db(store_.offered()->gap(store_.ledger())) : 0);
  return gone;
}

void Pruning::evict(std::span<const ViewSlot> slots) {
  for (const ViewSlot slot : slots) {
    if (slot < store_.ledger().slots() && store_.ledger().stored(slot)) continue;
    throw std::logic_error("planner: slot " + std::to_string(slot) + " holds no view");
  }
  for (const ViewSlot slot : slots) store_.evict(slot);
}

void Pruning::give_up_references(double max_loss_db) {
  const std::vector<std::vector<ViewSlot>> given_up = dispensable_references(store_.ledger(), max_loss_db);
  for (CellId cell{0}; cell < given_up.size(); ++cell) {
    if (!given_up[cell].empty()) store_.give_up(cell, given_up[cell]);
  }
}

double Pruning::loss_of_references() const {
  return store_.offered() ? bound_of_references(*store_.options().max_loss_db) : 0;
}

PredictedLoss Pruning::predicted_loss() const {
  if (!store_.offered()) throw std::logic_error("planner: max_loss_db is not set, no loss is predicted");
  const ReferenceService service = reference_service(store_.ledger());
  PredictedLoss predicted;
  predicted.gap = store_.offered()->gap(store_.ledger());
  predicted.reference_gap = reference_gap(service, 0);
  predicted.loss_db = predicted_loss_db(predicted.gap) + predicted_reference_loss_db(predicted.reference_gap);
  predicted.references_given_up = service.given_up;
  predicted.short_of_room = store_.short_of_room();
  return predicted;
}

}  // namespace lumatlas
