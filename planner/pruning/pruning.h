// SPDX-License-Identifier: GPL-3.0-or-later
// Removes the views and references from a planner's store whose loss costs least, when the stream has ended or rests.
// They do not come back.
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

  // Makes the store as small as PlannerOptions::max_loss_db allows. Evicts views, each time the one whose loss costs
  // least, while the predicted loss stays within a part of the bound; then gives up references while views and
  // references together stay within the bound. With a bound of 0 nothing is removed. Returns the names of the views in
  // the order of their removal. Callers that measure the loss instead use the other functions.
  std::vector<std::string> prune();
  // Evicts the views of these slots. Throws std::logic_error, and changes nothing, unless each slot holds a view.
  void evict(std::span<const ViewSlot> slots);
  // Gives up references while their predicted loss stays within the bound, dB. A cell keeps as many as are blended. A
  // bound of 0 or less gives up none.
  void give_up_references(double max_loss_db);
  // Returns the part of max_loss_db that prune() leaves to references, dB.
  [[nodiscard]] double loss_of_references() const;
  // Returns the loss of the store as it is now. Needs max_loss_db (std::logic_error).
  [[nodiscard]] PredictedLoss predicted_loss() const;

 private:
  PlannedStore& store_;
};

}  // namespace lumatlas
