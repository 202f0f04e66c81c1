// SPDX-License-Identifier: GPL-3.0-or-later
// The coverage of a store that had kept every offered view, by the measure of direction_coverage.h. The real store is
// compared with it.
//
// It holds numbers, no photographs. For each cell it keeps only views among the best K + 1 of some direction: at most
// (K + 1) * CoverageOptions::directions, however long the stream is. If a cell's ideal distance changes later, a
// forgotten view does not come back. So with demand the result may be too low, but never below the value of the store
// itself, see gap().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "planner/coverage/coverage_ledger.h"
#include "planner/coverage/direction_coverage.h"

namespace lumatlas {

class OfferedCoverage {
 public:
  // The options must pass check(), and be of Metric::directions. Here and below, std::invalid_argument names what
  // breaks a rule: cells of parts and stores of the surface, view slots of the store.
  OfferedCoverage(const Surface& surface, const CoverageOptions& options);

  // Add or remove the demand of a view, as the store's ledger does: CoverageLedger::add_demand() and remove_demand().
  void add_demand(std::span<const CellPart> parts) { change_demand(parts, DemandChange::add); }
  void remove_demand(std::span<const CellPart> parts) { change_demand(parts, DemandChange::remove); }
  // Counts a view, whose demand was added, from here on, stored or not.
  void add(std::span<const CellPart> parts);

  // Returns by what share the store serves the novel directions worse than all added views would: in [0, 1], and
  // exactly 0 for a store of all of them. `newcomer`: one more view, whose demand was added, and which is not stored.
  [[nodiscard]] double gap(const CoverageLedger& store, std::span<const CellPart> newcomer = {}) const;

  // Returns the same for the store without the view in that view slot.
  [[nodiscard]] double gap_without(const CoverageLedger& store, ViewSlot slot) const;

  // Like CoverageLedger::follow(). A cell that is new starts without the views that were offered before.
  void follow(const Surface& surface, std::span<const CellId> previous_cell);

  // Views that are held of a cell, as numbers.
  [[nodiscard]] std::size_t held(CellId cell) const { return all_.member_count(cell); }

 private:
  void require_cells(std::span<const CellPart> parts) const;
  void change_demand(std::span<const CellPart> parts, DemandChange change);
  struct Sum {
    double all = 0, missing = 0;
    [[nodiscard]] double share() const;
  };
  void count(const CoverageLedger& store, CellId cell, double rise, double sign, Sum& sum) const;
  [[nodiscard]] Sum sum_over_cells(const CoverageLedger& store) const;

  DirectionCoverage all_;
  bool has_demand_;
  std::size_t cells_;
  std::uint32_t views_ = 0;
};

}  // namespace lumatlas
