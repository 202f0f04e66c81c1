// SPDX-License-Identifier: GPL-3.0-or-later
// How well the stored views cover each cell, kept up as views come and go. One interface for the measures that can be
// planned by: the paper's (paper_coverage.h) and the submodular one (direction_coverage.h).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "planner/coverage.h"

namespace lumatlas {

// What a cell would lose with one of its references, after others that it gave up before: of ReferenceService::of_kept.
struct ReferenceLoss {
  std::uint32_t slot;
  double loss;  // >= 0
};

// How well a cell's references serve the stored cameras that see it, for what the cell counts: those that it has, and
// those with the ones that it gave up. Both >= 0.
struct ReferenceService {
  double of_kept = 0, of_all = 0;
  std::uint32_t given_up = 0;  // how many
};

// Views are told apart by the slot that they are stored in; those that see a cell are its members, in order of arrival,
// and up to max_references of them are referenced (R(b) of section 3.4). Different cells may be changed by different
// threads at once.
class CellCoverage {
 public:
  virtual ~CellCoverage() = default;

  // What a cell counts for, >= 0: in cells, or in pictures where cells count by demand.
  [[nodiscard]] virtual double value(std::uint32_t cell) const = 0;
  // By how much a view more would raise the cell's value. `victims`, if not empty, says by slot (1) of which members it
  // is asked by how much less or more that would be if they had left before: added to `corrections` (by slot), for
  // others too where that costs nothing.
  [[nodiscard]] virtual double gain(std::uint32_t cell, const Contribution& part, std::span<const std::uint8_t> victims,
                                    std::span<double> corrections) const = 0;
  // Adds `factor` times what the cell would lose without each member to `losses` (by slot).
  virtual void add_losses(std::uint32_t cell, double factor, std::span<double> losses) const = 0;
  // By definition, not from what is kept up: the cell's value without the members in `gone`, and with `newcomer` if it
  // is not null.
  [[nodiscard]] virtual double value_by_definition(std::uint32_t cell, std::span<const std::uint32_t> gone,
                                                   const Contribution* newcomer) const = 0;

  // A measure by which a cell's value depends on all offered views that see it, stored or not, is told of each;
  // `take_back`: of one that it was told of, which is not to count. Returns by how much the cell's value rises, and
  // adds to `losses` (by slot) by how much more the cell loses without each member.
  virtual double ask(std::uint32_t /*cell*/, const Contribution& /*part*/, bool /*take_back*/,
                     std::span<double> /*losses*/) {
    return 0;
  }
  // What the cell counts for beside others; where cells count alike, 1.
  [[nodiscard]] virtual double weight(std::uint32_t /*cell*/) const { return 1; }

  // A slot is a member at most once.
  virtual void insert(std::uint32_t cell, std::uint32_t slot, const Contribution& part) = 0;
  // The slot must be a member. Another member may take the place of its reference.
  virtual void erase(std::uint32_t cell, std::uint32_t slot) = 0;
  [[nodiscard]] virtual std::vector<std::uint32_t> references(std::uint32_t cell) const = 0;

  // In which order the cell would give up references, each time the one that is missed least, down to as many as are
  // blended. Here and below: nothing, by a measure that cannot say.
  [[nodiscard]] virtual std::vector<ReferenceLoss> reference_losses(std::uint32_t /*cell*/) const { return {}; }
  // The views stay members, and one of them may be referenced again when another member leaves.
  virtual void give_up(std::uint32_t /*cell*/, std::span<const std::uint32_t> /*slots*/) {}
  [[nodiscard]] virtual ReferenceService reference_service(std::uint32_t /*cell*/) const { return {}; }

  // The geometry has changed: the new cell k takes over what is known of the old cell previous_cell[k] (kNoCell:
  // empty).
  virtual void follow(const Surface& surface, std::span<const std::uint32_t> previous_cell) = 0;
};

// `min_reference_gain`: Delta_fcov of section 3.4, by which a full cell's coverage must rise to swap a reference.
[[nodiscard]] std::unique_ptr<CellCoverage> make_cell_coverage(const Surface& surface, const CoverageOptions& options,
                                                               double min_reference_gain);

}  // namespace lumatlas
