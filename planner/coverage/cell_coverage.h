// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how well the stored views cover each cell, and follows as views come and go. One interface for both measures
// of planning: the paper's (paper_coverage.h) and the submodular one (direction_coverage.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "planner/coverage/coverage.h"

namespace lumatlas {

// The loss of value of a cell without one of its references, after others that it gave up before, as
// ReferenceService::of_kept has it.
struct ReferenceLoss {
  ViewSlot slot;
  double loss;  // >= 0
};

// The service of the stored cameras that see a cell by its references, weighted as the cell counts: by the references
// that it has, and by these with the ones that it gave up. Both >= 0.
struct ReferenceService {
  double of_kept = 0, of_all = 0;
  std::uint32_t given_up = 0;  // how many
};

enum class DemandChange { add, remove };

// Views are told apart by the view slot that they are stored in; those that see a cell are its members, in order of
// arrival, and up to max_references of them are referenced (R(b) of section 3.4). Different cells may be changed by
// different threads at once.
//
// Every function checks its arguments and throws std::invalid_argument naming the field, its value and the rule: a cell
// is below cells(), a part passes check(), and a list by view slot has an entry for every view slot that ever was a
// member of the cell.
class CellCoverage {
 public:
  virtual ~CellCoverage() = default;
  CellCoverage& operator=(const CellCoverage&) = delete;

  [[nodiscard]] std::size_t cells() const { return slots_of_.size(); }  // how many

  // Returns a copy, which may be changed while another thread changes this.
  [[nodiscard]] virtual std::unique_ptr<CellCoverage> copy() const = 0;

  // Forgets the references and chooses none from now on, unless values depend on them. insert() and erase() then cost a
  // small part of what they do with references.
  virtual void forget_references() {}

  // Returns the cell's value, >= 0: in cells, or in pictures where cells count by demand.
  [[nodiscard]] double value(CellId cell) const;
  // Returns by how much one more view would raise the cell's value. `victims`, if not empty, has a 1 for each view slot
  // that might leave before. For each of these that is a member, the change of the result without it is added to
  // `corrections` (one entry a view slot); for other slots too where that costs nothing.
  [[nodiscard]] double gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                            std::span<double> corrections) const;
  // Returns the cell's value without the members in `gone`, and with `newcomer` if it is not null. Computed by the
  // definition, not from what is kept up to date.
  [[nodiscard]] double value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                           const Contribution* newcomer) const;

  // Adds the demand of an offered view, stored or not, to a measure by which a cell's value depends on all offered
  // views that see it; or removes one that was added before. Returns by how much the cell's value rises. Adds to
  // `losses` (one per view slot; empty: not needed) by how much more the cell loses without each member.
  double change_demand(CellId cell, const Contribution& part, DemandChange change, std::span<double> losses);
  // Returns the cell's weight against other cells; 1 where cells count alike.
  [[nodiscard]] double weight(CellId cell) const;

  // Both return by how much the cell's value rises, and add to `losses`, as change_demand() does, by how much more the
  // cell loses without each member. The view slot must not be a member yet, and be below 2^32 - 1.
  double insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses = {});
  // The view slot must be a member. Another member may take the place of its reference.
  double erase(CellId cell, ViewSlot slot, std::span<double> losses = {});
  [[nodiscard]] std::vector<ViewSlot> references(CellId cell) const;

  // Returns the order in which the cell would give up references, least loss first, down to as many as are blended.
  // Here and below: empty for a measure that cannot tell.
  [[nodiscard]] std::vector<ReferenceLoss> reference_losses(CellId cell) const;
  // The views stay members, and one of them may be referenced again when another member leaves.
  void give_up(CellId cell, std::span<const ViewSlot> slots);
  [[nodiscard]] ReferenceService reference_service(CellId cell) const;

  // The geometry has changed: the new cell k takes over what is known of the old cell previous_cell[k] (CellId::none:
  // empty). One entry for each cell of the surface, each an old cell or CellId::none.
  void follow(const Surface& surface, std::span<const CellId> previous_cell);

 protected:
  // The options must pass check(), and the gain be finite and not negative.
  CellCoverage(std::size_t cells, const CoverageOptions& options, double min_reference_gain);

  CellCoverage(const CellCoverage&) = default;

  void require_cell(CellId cell) const;

 private:
  // The measures. What they are given has been checked.
  [[nodiscard]] virtual double do_value(CellId cell) const = 0;
  [[nodiscard]] virtual double do_gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                                       std::span<double> corrections) const = 0;
  [[nodiscard]] virtual double do_value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                                      const Contribution* newcomer) const = 0;
  virtual double do_change_demand(CellId /*cell*/, const Contribution& /*part*/, DemandChange /*change*/,
                                  std::span<double> /*losses*/) {
    return 0;
  }
  [[nodiscard]] virtual double do_weight(CellId /*cell*/) const { return 1; }
  [[nodiscard]] virtual bool is_member(CellId cell, ViewSlot slot) const = 0;
  virtual void do_insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) = 0;
  virtual void do_erase(CellId cell, ViewSlot slot, std::span<double> losses) = 0;
  [[nodiscard]] virtual std::vector<ViewSlot> do_references(CellId cell) const = 0;
  [[nodiscard]] virtual std::vector<ReferenceLoss> do_reference_losses(CellId /*cell*/) const { return {}; }
  virtual void do_give_up(CellId /*cell*/, std::span<const ViewSlot> /*slots*/) {}
  [[nodiscard]] virtual ReferenceService do_reference_service(CellId /*cell*/) const { return {}; }
  virtual void do_follow(const Surface& surface, std::span<const CellId> previous_cell) = 0;

  void require_list_by_slot(CellId cell, std::size_t size, const char* list) const;

  std::vector<std::uint32_t> slots_of_;  // one per cell: 1 + the largest view slot that ever was a member
};

// `min_reference_gain`: Delta_fcov of section 3.4, by which a full cell's coverage must rise to swap a reference;
// finite and not negative. Throws std::invalid_argument for that, and unless the options pass check().
[[nodiscard]] std::unique_ptr<CellCoverage> make_cell_coverage(const Surface& surface, const CoverageOptions& options,
                                                               double min_reference_gain);

}  // namespace lumatlas
