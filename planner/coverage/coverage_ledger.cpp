// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/coverage_ledger.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

// Cells are worked on in this many parts, whatever the number of threads, and the parts' sums are added in order, so
// that rounding is the same for any number of threads.
constexpr std::size_t kParts = 16;

constexpr Requirement coverage_ledger_requires{"coverage"};

const CoverageOptions& checked(const CoverageOptions& options) {
  check(options);
  return options;
}

std::span<const CellPart> part_of(std::span<const CellPart> parts, std::size_t i) {
  const std::size_t first = parts.size() * i / kParts;
  return parts.subspan(first, parts.size() * (i + 1) / kParts - first);
}

void add_to(std::vector<double>& sums, std::span<const double> terms) {
  for (std::size_t i = 0; i < terms.size(); ++i) sums[i] += terms[i];
}

}  // namespace

CoverageLedger::CoverageLedger(const Surface& surface, std::uint32_t slots, const CoverageOptions& options,
                               double min_reference_gain)
    : coverage_(make_cell_coverage(surface, checked(options), min_reference_gain)),
      has_demand_(has_demand(options)),
      cells_(surface.cells.cells.size()),
      parts_(slots),
      stored_(slots, 0),
      loss_(slots, 0) {}

CoverageLedger::CoverageLedger(const CoverageLedger& other, std::uint32_t more_slots)
    : coverage_(other.coverage_->copy()),
      has_demand_(other.has_demand_),
      cells_(other.cells_),
      parts_(other.parts_),
      stored_(other.stored_),
      loss_(other.loss_),
      summed_coverage_(other.summed_coverage_) {
  coverage_->forget_references();
  parts_.resize(parts_.size() + more_slots);
  stored_.resize(parts_.size(), 0);
  loss_.resize(parts_.size(), 0);
}

void CoverageLedger::require_cells(std::span<const CellPart> parts) const {
  for (const CellPart& entry : parts)
    coverage_ledger_requires.is_below(entry.cell, cells_, "a part's cell", "the number of cells");
}

void CoverageLedger::require_slots(std::span<const ViewSlot> slots) const {
  for (const ViewSlot slot : slots)
    coverage_ledger_requires.is_below(slot, stored_.size(), "slot", "the number of slots");
}

double CoverageLedger::gain(std::span<const CellPart> parts) const {
  require_cells(parts);
  std::array<double, kParts> gains{};
  tbb::parallel_for(std::size_t{0}, kParts, [&](std::size_t i) {
    for (const CellPart& entry : part_of(parts, i)) gains[i] += coverage_->gain(entry.cell, entry.part, {}, {});
  });
  double sum = 0;
  for (const double gain : gains) sum += gain;
  return sum;
}

std::vector<double> CoverageLedger::exchange_gains(std::span<const CellPart> parts,
                                                   std::span<const ViewSlot> victims) const {
  require_cells(parts);
  require_slots(victims);
  std::vector<std::uint8_t> asked(loss_.size(), 0);
  for (const ViewSlot slot : victims) asked[slot] = 1;
  std::array<double, kParts> gains{};
  std::array<std::vector<double>, kParts> corrections;
  tbb::parallel_for(std::size_t{0}, kParts, [&](std::size_t i) {
    corrections[i].resize(loss_.size());
    for (const CellPart& entry : part_of(parts, i)) {
      gains[i] += coverage_->gain(entry.cell, entry.part, asked, corrections[i]);
    }
  });
  double gain = 0;
  std::vector<double> correction(loss_.size(), 0);
  for (std::size_t i = 0; i < kParts; ++i) {
    gain += gains[i];
    add_to(correction, corrections[i]);
  }
  std::vector<double> result;
  result.reserve(victims.size());
  for (const ViewSlot slot : victims) result.push_back(gain + correction[slot] - loss_[slot]);
  return result;
}

double CoverageLedger::joint_exchange_gain(std::span<const CellPart> parts, std::span<const ViewSlot> gone) const {
  require_cells(parts);
  require_slots(gone);
  double gain = 0;
  std::vector<CellId> cells;
  for (const CellPart& entry : parts) {
    gain += coverage_->value_by_definition(entry.cell, gone, &entry.part) - coverage_->value(entry.cell);
    cells.push_back(entry.cell);
  }
  // Add what is lost in the cells that the newcomer does not see. Each counts once, however many of the views see it.
  std::vector<CellId> others;
  for (const ViewSlot slot : gone) {
    for (const CellPart& entry : parts_[slot]) others.push_back(entry.cell);
  }
  std::sort(cells.begin(), cells.end());
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  for (const CellId cell : others) {
    if (std::binary_search(cells.begin(), cells.end(), cell)) continue;
    gain += coverage_->value_by_definition(cell, gone, nullptr) - coverage_->value(cell);
  }
  return gain;
}

// Sums by how much scov and each slot's loss change, for each part of the cells.
struct CoverageLedger::Changes {
  explicit Changes(std::size_t slots) {
    for (std::vector<double>& part : losses) part.resize(slots);
  }
  std::array<double, kParts> rises{};
  std::array<std::vector<double>, kParts> losses;
};

void CoverageLedger::add(const Changes& changes) {
  for (std::size_t i = 0; i < kParts; ++i) {
    summed_coverage_ += changes.rises[i];
    add_to(loss_, changes.losses[i]);
  }
}

// Calls change(), which returns by how much scov rises and adds to the slots' losses, for each of `parts`.
template <typename Change>
void CoverageLedger::change_cells(std::span<const CellPart> parts, const Change& change) {
  Changes changes(loss_.size());
  tbb::parallel_for(std::size_t{0}, kParts, [&](std::size_t i) {
    for (const CellPart& entry : part_of(parts, i)) changes.rises[i] += change(entry, changes.losses[i]);
  });
  add(changes);
}

void CoverageLedger::insert_parts(ViewSlot slot, std::span<const CellPart> parts) {
  change_cells(parts, [&](const CellPart& entry, std::span<double> losses) {
    return coverage_->insert(entry.cell, slot, entry.part, losses);
  });
}

void CoverageLedger::erase_parts(ViewSlot slot, std::span<const CellPart> parts) {
  change_cells(parts, [&](const CellPart& entry, std::span<double> losses) {
    return coverage_->erase(entry.cell, slot, losses);
  });
}

void CoverageLedger::add_demand(std::span<const CellPart> parts) {
  count_demand(parts, DemandChange::add);
}

void CoverageLedger::remove_demand(std::span<const CellPart> parts) {
  count_demand(parts, DemandChange::remove);
}

void CoverageLedger::count_demand(std::span<const CellPart> parts, DemandChange change) {
  require_cells(parts);
  if (!has_demand_) return;
  change_cells(parts, [&](const CellPart& entry, std::span<double> losses) {
    return coverage_->change_demand(entry.cell, entry.part, change, losses);
  });
}

double CoverageLedger::weight(std::span<const CellPart> parts) const {
  require_cells(parts);
  double sum = 0;
  for (const CellPart& entry : parts) sum += coverage_->weight(entry.cell);
  return sum;
}

void CoverageLedger::insert(ViewSlot slot, std::vector<CellPart> parts) {
  require_slots({{slot}});
  require_cells(parts);
  if (stored_[slot] != 0) throw std::logic_error("coverage: slot " + std::to_string(slot) + " holds a view already");
  stored_[slot] = 1;
  parts_[slot] = std::move(parts);
  insert_parts(slot, parts_[slot]);
}

void CoverageLedger::erase(ViewSlot slot) {
  require_stored(slot);
  const std::vector<CellPart> parts = std::move(parts_[slot]);
  parts_[slot].clear();
  stored_[slot] = 0;
  erase_parts(slot, parts);
  loss_[slot] = 0;
}

void CoverageLedger::require_stored(ViewSlot slot) const {
  require_slots({{slot}});
  if (stored_[slot] == 0) throw std::logic_error("coverage: slot " + std::to_string(slot) + " holds no view");
}

void CoverageLedger::enter(ViewSlot slot, std::span<const CellPart> parts) {
  count_demand(parts, DemandChange::add);
  insert_parts(slot, parts);
}

void CoverageLedger::leave(ViewSlot slot, std::span<const CellPart> parts) {
  count_demand(parts, DemandChange::remove);
  erase_parts(slot, parts);
}

void CoverageLedger::keep_cells(ViewSlot slot, std::span<const std::uint8_t> kept) {
  require_stored(slot);
  coverage_ledger_requires.has_size(kept.size(), cells_, "kept", "the number of cells");
  std::vector<CellPart> stay, gone;
  for (const CellPart& entry : parts_[slot]) (kept[entry.cell] != 0 ? stay : gone).push_back(entry);
  leave(slot, gone);
  parts_[slot] = std::move(stay);
}

void CoverageLedger::replace(ViewSlot slot, std::vector<CellPart> parts) {
  require_stored(slot);
  require_cells(parts);
  std::unordered_map<std::uint32_t, const Contribution*> before;
  for (const CellPart& entry : parts_[slot]) before.emplace(entry.cell, &entry.part);
  std::vector<CellPart> more, gone;
  for (const CellPart& entry : parts) {
    const auto same = before.find(entry.cell);
    if (same == before.end()) {
      more.push_back(entry);
      continue;
    }
    if (!(*same->second == entry.part)) {
      gone.push_back({entry.cell, *same->second});
      more.push_back(entry);
    }
    before.erase(same);
  }
  for (const CellPart& entry : parts_[slot]) {
    if (before.contains(entry.cell)) gone.push_back(entry);
  }
  leave(slot, gone);
  enter(slot, more);
  parts_[slot] = std::move(parts);
}

void CoverageLedger::follow(const Surface& surface, std::span<const CellId> previous_cell) {
  coverage_ledger_requires.has_size(previous_cell.size(), surface.cells.cells.size(), "previous_cell",
                                    "the number of cells");
  std::unordered_map<std::uint32_t, std::uint32_t> now;
  for (CellId cell{0}; cell < previous_cell.size(); ++cell) {
    if (previous_cell[cell] != CellId::none) now.emplace(previous_cell[cell], cell);
  }
  for (const std::vector<CellPart>& parts : parts_) {
    const auto lost =
        std::find_if(parts.begin(), parts.end(), [&](const CellPart& entry) { return !now.contains(entry.cell); });
    if (lost != parts.end()) {
      throw std::logic_error("coverage: a stored view sees cell " + std::to_string(lost->cell) + ", which is gone");
    }
  }
  for (std::vector<CellPart>& parts : parts_) {
    for (CellPart& entry : parts) entry.cell = CellId{now.at(entry.cell)};
  }
  coverage_->follow(surface, previous_cell);
  cells_ = surface.cells.cells.size();
}

std::vector<ViewSlot> missed_least(const CoverageLedger& ledger, std::vector<ViewSlot> slots, std::size_t count) {
  if (count >= slots.size()) return slots;
  std::partial_sort(
      slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count), slots.end(),
      [&](ViewSlot a, ViewSlot b) { return std::pair(ledger.loss(a), a) < std::pair(ledger.loss(b), b); });
  slots.resize(count);
  return slots;
}

}  // namespace lumatlas
