// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps account of the value of the stored views: scov (Erat et al. 2019, section 3.2), each view's share in it, and
// scov with another view. It is updated view by view and holds no photographs, so the offline planner and the tests use
// it as the online planner does.
//
// A decision costs what the cells cost that the view sees; storing or dropping a view, what the members of these cells
// cost. Nothing depends on the length of the stream.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planner/coverage/cell_coverage.h"
#include "planner/coverage/coverage.h"

namespace lumatlas {

// Cells that the surface does not have, and slots beyond those that there are, are refused (std::invalid_argument)
// where parts or lists of slots are given. What is asked of one cell or slot by its number, in the innermost loops of
// planning, is not checked.
class CoverageLedger {
 public:
  // `slots`: how many views it can hold at once. `min_reference_gain` as in PlannerOptions. Throws
  // std::invalid_argument unless the options pass check().
  CoverageLedger(const Surface& surface, std::uint32_t slots, const CoverageOptions& options,
                 double min_reference_gain);

  // Copies a ledger for decisions, with room for `more_slots` more views: it knows no references unless values depend
  // on them, so that views come and go in a small part of the time. Time: that of copying the members of all cells,
  // which is far less than that of inserting them again.
  CoverageLedger(const CoverageLedger& other, std::uint32_t more_slots);

  [[nodiscard]] std::size_t cells() const { return cells_; }          // how many the surface has
  [[nodiscard]] std::size_t slots() const { return stored_.size(); }  // how many views it can hold

  // Adds the demand of an offered view, stored or not, for the cells that it sees: see CellDemand. remove_demand()
  // removes it, with the same parts. Without CoverageOptions::demand, nothing changes. With it, cells without demand
  // are worth nothing.
  void add_demand(std::span<const CellPart> parts);
  void remove_demand(std::span<const CellPart> parts);
  // Returns the largest scov that the view's cells alone can have.
  [[nodiscard]] double weight(std::span<const CellPart> parts) const;
  [[nodiscard]] double weight(CellId cell) const { return coverage_->weight(cell); }  // the same of one cell

  // Returns by how much scov would rise with the view.
  [[nodiscard]] double gain(std::span<const CellPart> parts) const;
  // Returns the same for each slot in `victims`, if its view left first, less the loss of that view.
  [[nodiscard]] std::vector<double> exchange_gains(std::span<const CellPart> parts,
                                                   std::span<const ViewSlot> victims) const;
  // Returns the same for several views that leave together, computed by the definition.
  [[nodiscard]] double joint_exchange_gain(std::span<const CellPart> parts, std::span<const ViewSlot> gone) const;

  // The slot must be free (std::logic_error).
  void insert(ViewSlot slot, std::vector<CellPart> parts);
  // The slot must not be free (std::logic_error).
  void erase(ViewSlot slot);

  // Removes a stored view's parts in cells that have a 0 in `kept`, with their demand; one entry for each cell
  // (std::invalid_argument). The slot must not be free (std::logic_error).
  void keep_cells(ViewSlot slot, std::span<const std::uint8_t> kept);
  // Gives a stored view other parts, with their demand. Cells in which its part is the same stay as they are, and cost
  // nothing. The slot must not be free (std::logic_error).
  void replace(ViewSlot slot, std::vector<CellPart> parts);

  [[nodiscard]] double summed_coverage() const { return summed_coverage_; }  // scov, by CellCoverage::value()
  [[nodiscard]] double loss(ViewSlot slot) const { return loss_[slot]; }     // what scov would lose without its view
  [[nodiscard]] double coverage(CellId cell) const { return coverage_->value(cell); }  // its part in scov
  [[nodiscard]] std::vector<ViewSlot> references(CellId cell) const { return coverage_->references(cell); }
  // See CellCoverage. Different threads may ask about different cells.
  [[nodiscard]] std::vector<ReferenceLoss> reference_losses(CellId cell) const {
    return coverage_->reference_losses(cell);
  }
  void give_up(CellId cell, std::span<const ViewSlot> slots) { coverage_->give_up(cell, slots); }
  [[nodiscard]] ReferenceService reference_service(CellId cell) const { return coverage_->reference_service(cell); }
  [[nodiscard]] std::span<const CellPart> parts(ViewSlot slot) const { return parts_[slot]; }  // none: free
  [[nodiscard]] bool stored(ViewSlot slot) const { return stored_[slot] != 0; }

  // Follows a change of the geometry that numbers the cells anew, see CellCoverage::follow(); one entry for each
  // (std::invalid_argument). No stored view may see an old cell that no new one takes over (std::logic_error): the
  // caller calls keep_cells() before and replace() after.
  void follow(const Surface& surface, std::span<const CellId> previous_cell);

 private:
  struct Changes;
  void require_cells(std::span<const CellPart> parts) const;
  void require_slots(std::span<const ViewSlot> slots) const;
  void require_stored(ViewSlot slot) const;
  void add(const Changes& changes);
  void count_demand(std::span<const CellPart> parts, DemandChange change);
  // Change the members of cells and their demand, and not `parts_`.
  void enter(ViewSlot slot, std::span<const CellPart> parts);
  void leave(ViewSlot slot, std::span<const CellPart> parts);
  void insert_parts(ViewSlot slot, std::span<const CellPart> parts);  // those of insert() and erase()
  void erase_parts(ViewSlot slot, std::span<const CellPart> parts);
  template <typename Change>
  void change_cells(std::span<const CellPart> parts, const Change& change);

  std::unique_ptr<CellCoverage> coverage_;
  bool has_demand_;
  std::size_t cells_;
  std::vector<std::vector<CellPart>> parts_;  // by slot: what its view adds to the cells that it sees
  std::vector<std::uint8_t> stored_;          // by slot
  std::vector<double> loss_;                  // by slot
  double summed_coverage_ = 0;
};

// Returns the `count` slots whose views scov would lose least without, least loss first. Returns all of them, in the
// given order, if they are no more than `count`.
[[nodiscard]] std::vector<ViewSlot> missed_least(const CoverageLedger& ledger, std::vector<ViewSlot> slots,
                                                 std::size_t count);

}  // namespace lumatlas
