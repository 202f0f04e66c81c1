// SPDX-License-Identifier: GPL-3.0-or-later
// Takes those views and references away from a planner's store that are missed least, when the stream has ended or
// rests. They do not come back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planner/planner.h"

namespace lumatlas {

// The expected loss of a store against one of all offered views: see predicted_loss.h.
struct PredictedLoss {
  double gap = 0;            // of coverage, a share
  double reference_gap = 0;  // of the service of cells' references, a share
  double loss_db = 0;        // with both
  std::size_t references_given_up = 0;
  bool short_of_room = false;  // a view was needed for max_loss_db, but the store was full
};

class Pruning {
 public:
  // The planner must outlive it.
  explicit Pruning(Planner& planner) : store_(planner.store_) {}

  // With PlannerOptions::max_loss_db: takes stored views away, each time the one that is missed least, as long as their
  // predicted loss stays within a share of the bound, and then gives up references, as long as both together stay
  // within it. With a bound of 0 none. Returns the views' names in that order. The other functions are for callers that
  // measure what is lost instead.
  std::vector<std::string> thin();
  // Each slot must hold a view (std::logic_error; nothing is changed then).
  void take_away(std::span<const ViewSlot> slots);
  // Gives up references as long as they are predicted to cost at most so much, dB; a cell keeps as many as are blended.
  // None unless that is above 0.
  void give_up_references(double max_loss_db);
  // Returns the part of max_loss_db that thin() leaves to references, dB.
  [[nodiscard]] double loss_of_references() const;
  // Returns the loss of the store as it is now. Needs max_loss_db (std::logic_error).
  [[nodiscard]] PredictedLoss predicted_loss() const;

 private:
  PlannedStore& store_;
};

}  // namespace lumatlas
