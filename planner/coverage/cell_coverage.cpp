// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/cell_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/requirement.h"
#include "planner/coverage/direction_coverage.h"
#include "planner/coverage/paper_coverage.h"

namespace lumatlas {

namespace {

constexpr Requirement cell_coverage_requires{"coverage"};

}  // namespace

CellCoverage::CellCoverage(std::size_t cells, const CoverageOptions& options, double min_reference_gain)
    : slots_of_(cells, 0) {
  check(options);
  cell_coverage_requires(std::isfinite(min_reference_gain) && min_reference_gain >= 0, "min_reference_gain",
                         min_reference_gain, "finite and not negative");
}

void CellCoverage::require_cell(CellId cell) const {
  cell_coverage_requires.is_below(cell, slots_of_.size(), "cell", "the number of cells");
}

void CellCoverage::require_list_by_slot(CellId cell, std::size_t size, const char* list) const {
  if (size >= slots_of_[cell]) return;
  throw std::invalid_argument(std::string("coverage: the size of ") + list + " is " + std::to_string(size) +
                              ", must be more than the largest slot of cell " + std::to_string(cell) + ", " +
                              std::to_string(slots_of_[cell] - 1));
}

double CellCoverage::value(CellId cell) const {
  require_cell(cell);
  return do_value(cell);
}

double CellCoverage::gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                          std::span<double> corrections) const {
  require_cell(cell);
  check(part);
  cell_coverage_requires.has_size(corrections.size(), victims.size(), "corrections", "that of victims");
  if (!victims.empty()) require_list_by_slot(cell, victims.size(), "victims");
  return do_gain(cell, part, victims, corrections);
}

double CellCoverage::value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                         const Contribution* newcomer) const {
  require_cell(cell);
  if (newcomer) check(*newcomer);
  return do_value_by_definition(cell, gone, newcomer);
}

double CellCoverage::change_demand(CellId cell, const Contribution& part, DemandChange change,
                                   std::span<double> losses) {
  require_cell(cell);
  check(part);
  if (!losses.empty()) require_list_by_slot(cell, losses.size(), "losses");
  return do_change_demand(cell, part, change, losses);
}

double CellCoverage::weight(CellId cell) const {
  require_cell(cell);
  return do_weight(cell);
}

double CellCoverage::insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) {
  require_cell(cell);
  cell_coverage_requires.is_below(slot, std::numeric_limits<std::uint32_t>::max(), "slot",
                                  "the largest number that is no slot");
  check(part);
  if (!losses.empty()) {
    require_list_by_slot(cell, losses.size(), "losses");
    cell_coverage_requires.is_below(slot, losses.size(), "slot", "the size of losses");
  }
  if (is_member(cell, slot)) {
    throw std::invalid_argument("coverage: slot is " + std::to_string(slot) + ", must not be a member of cell " +
                                std::to_string(cell) + " yet");
  }
  const double before = do_value(cell);
  do_insert(cell, slot, part, losses);
  slots_of_[cell] = std::max(slots_of_[cell], slot + 1);
  return do_value(cell) - before;
}

double CellCoverage::erase(CellId cell, ViewSlot slot, std::span<double> losses) {
  require_cell(cell);
  if (!losses.empty()) require_list_by_slot(cell, losses.size(), "losses");
  if (!is_member(cell, slot)) {
    throw std::invalid_argument("coverage: slot is " + std::to_string(slot) + ", must be a member of cell " +
                                std::to_string(cell));
  }
  const double before = do_value(cell);
  do_erase(cell, slot, losses);
  return do_value(cell) - before;
}

std::vector<ViewSlot> CellCoverage::references(CellId cell) const {
  require_cell(cell);
  return do_references(cell);
}

std::vector<ReferenceLoss> CellCoverage::reference_losses(CellId cell) const {
  require_cell(cell);
  return do_reference_losses(cell);
}

void CellCoverage::give_up(CellId cell, std::span<const ViewSlot> slots) {
  require_cell(cell);
  do_give_up(cell, slots);
}

ReferenceService CellCoverage::reference_service(CellId cell) const {
  require_cell(cell);
  return do_reference_service(cell);
}

void CellCoverage::follow(const Surface& surface, std::span<const CellId> previous_cell) {
  cell_coverage_requires.has_size(previous_cell.size(), surface.cells.cells.size(), "previous_cell",
                                  "the number of cells");
  for (const std::uint32_t previous : previous_cell) {
    if (previous != CellId::none)
      cell_coverage_requires.is_below(previous, cells(), "previous_cell", "the number of old cells");
  }
  do_follow(surface, previous_cell);
  std::vector<std::uint32_t> slots_of(previous_cell.size(), 0);
  for (std::size_t cell = 0; cell < slots_of.size(); ++cell) {
    if (previous_cell[cell] != CellId::none) slots_of[cell] = slots_of_[previous_cell[cell]];
  }
  slots_of_ = std::move(slots_of);
}

std::unique_ptr<CellCoverage> make_cell_coverage(const Surface& surface, const CoverageOptions& options,
                                                 double min_reference_gain) {
  if (options.metric == CoverageOptions::Metric::paper) {
    return std::make_unique<PaperCoverage>(surface.cells.cells.size(), options, min_reference_gain);
  }
  return std::make_unique<DirectionCoverage>(surface, options, min_reference_gain);
}

}  // namespace lumatlas
