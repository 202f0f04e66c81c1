// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/offered_coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr Requirement offered_coverage_requires{"coverage"};

const CoverageOptions& by_directions(const CoverageOptions& options) {
  if (options.metric == CoverageOptions::Metric::directions) return options;
  throw std::invalid_argument("coverage: metric is Metric::paper, must be Metric::directions for what was offered");
}

// The offered views are never drawn from, so their number of references needs no bound.
CoverageOptions without_reference_limit(CoverageOptions options) {
  options.max_references = std::numeric_limits<std::uint32_t>::max();
  return options;
}

// Runs in parallel, for a change to one cell reads and writes nothing of another.
template <typename Change>
void for_each_part(std::span<const CellPart> parts, const Change& change) {
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) { change(parts[i]); });
}

}  // namespace

OfferedCoverage::OfferedCoverage(const Surface& surface, const CoverageOptions& options)
    : all_(surface, without_reference_limit(by_directions(options)), 0),
      has_demand_(has_demand(options)),
      cells_(surface.cells.cells.size()) {}

void OfferedCoverage::require_cells(std::span<const CellPart> parts) const {
  for (const CellPart& entry : parts) {
    offered_coverage_requires.is_below(entry.cell, cells_, "a part's cell", "the number of cells");
    check(entry.part);
  }
}

void OfferedCoverage::change_demand(std::span<const CellPart> parts, DemandChange change) {
  require_cells(parts);
  if (!has_demand_) return;
  for_each_part(parts, [&](const CellPart& entry) { all_.change_demand(entry.cell, entry.part, change, {}); });
}

void OfferedCoverage::add(std::span<const CellPart> parts) {
  require_cells(parts);
  for_each_part(parts, [&](const CellPart& entry) {
    all_.insert(entry.cell, ViewSlot(views_), entry.part);
    all_.forget_idle(entry.cell);
  });
  ++views_;
}

// Adds `sign` times what all offered views are worth to a cell, which grows by `rise`, and what the store misses of it.
// The former is at least what the store is worth, since views that the store still holds may be forgotten here.
void OfferedCoverage::count(const CoverageLedger& store, CellId cell, double rise, double sign, Sum& sum) const {
  const double kept = store.coverage(cell);
  const double all = std::max(kept, all_.value(cell) + rise);
  sum.all += sign * all;
  sum.missing += sign * (all - kept);
}

double OfferedCoverage::Sum::share() const {
  return all > 0 ? std::clamp(missing / all, 0.0, 1.0) : 0;
}

OfferedCoverage::Sum OfferedCoverage::sum_over_cells(const CoverageLedger& store) const {
  offered_coverage_requires.has_size(store.cells(), cells_, "store", "the number of cells");
  Sum sum;
  for (CellId cell{0}; cell < cells_; ++cell) count(store, cell, 0, 1, sum);
  return sum;
}

double OfferedCoverage::gap(const CoverageLedger& store, std::span<const CellPart> newcomer) const {
  require_cells(newcomer);
  Sum sum = sum_over_cells(store);
  for (const CellPart& entry : newcomer) {
    count(store, entry.cell, 0, -1, sum);
    count(store, entry.cell, all_.gain(entry.cell, entry.part, {}, {}), 1, sum);
  }
  return sum.share();
}

double OfferedCoverage::gap_without(const CoverageLedger& store, ViewSlot slot) const {
  offered_coverage_requires.is_below(slot, store.slots(), "slot", "the number of slots");
  Sum sum = sum_over_cells(store);
  sum.missing += store.loss(slot);
  return sum.share();
}

void OfferedCoverage::follow(const Surface& surface, std::span<const CellId> previous_cell) {
  all_.follow(surface, previous_cell);
  cells_ = previous_cell.size();
}

}  // namespace lumatlas
