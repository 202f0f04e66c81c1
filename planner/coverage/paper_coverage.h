// SPDX-License-Identifier: GPL-3.0-or-later
// Coverage of cells by the paper's measure, Erat et al. 2019, sections 3.2 and 3.4, with or without departures from the
// print. Its value depends on the order in which views arrive, so no bound holds for choosing by it; every evaluation
// goes back to the definition.
#pragma once

#include <optional>

#include "planner/coverage/cell_coverage.h"

namespace lumatlas {

class PaperCoverage final : public CellCoverage {
 public:
  // Like make_cell_coverage(), for `cells` cells.
  PaperCoverage(std::size_t cells, const CoverageOptions& options, double min_reference_gain);

  [[nodiscard]] std::unique_ptr<CellCoverage> copy() const override { return std::make_unique<PaperCoverage>(*this); }

 private:
  [[nodiscard]] double do_value(CellId cell) const override { return cells_[cell].value; }
  [[nodiscard]] double do_gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                               std::span<double> corrections) const override;
  [[nodiscard]] double do_value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                              const Contribution* newcomer) const override;
  void do_insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) override;
  void do_erase(CellId cell, ViewSlot slot, std::span<double> losses) override;
  [[nodiscard]] std::vector<ViewSlot> do_references(CellId cell) const override;
  void do_follow(const Surface& surface, std::span<const CellId> previous_cell) override;
  [[nodiscard]] bool is_member(CellId cell, ViewSlot slot) const override;

  struct State {
    std::vector<ViewSlot> slots;  // the members' view slots
    std::vector<SetMember> members;
    double value = 0;
  };
  // The effect of adding a view to a cell's references.
  struct Admission {
    bool admitted = false;
    std::optional<std::size_t> victim;  // index among the members
    double gain = 0;
  };
  [[nodiscard]] Admission admit(std::vector<SetMember> members, const Contribution& part) const;
  void refill(State& state) const;
  // Adds `factor` times what the cell would lose without each member; to none if there are no `losses`.
  void add_losses(CellId cell, double factor, std::span<double> losses) const;

  CoverageOptions options_;
  CoverageOptions selection_;  // the same, with fcov over R(b), unclamped: by which references are selected
  double min_reference_gain_;
  std::vector<State> cells_;
};

}  // namespace lumatlas
