// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/paper_coverage.h"

#include <algorithm>
#include <limits>

namespace lumatlas {

namespace {

std::size_t count_references(std::span<const SetMember> members) {
  return static_cast<std::size_t>(
      std::count_if(members.begin(), members.end(), [](const SetMember& member) { return member.referenced; }));
}

std::vector<SetMember> without(std::vector<SetMember> members, std::size_t index) {
  members.erase(members.begin() + static_cast<std::ptrdiff_t>(index));
  return members;
}

// Options with which set_coverage() is fcov(R(b)). It has no upper bound: the paper clamps in scov only.
CoverageOptions counting_references(CoverageOptions options) {
  options.departures.references = true;
  options.max_cell_coverage = std::numeric_limits<double>::infinity();
  return options;
}

}  // namespace

PaperCoverage::PaperCoverage(std::size_t cells, const CoverageOptions& options, double min_reference_gain)
    : CellCoverage(cells, options, min_reference_gain),
      options_(options),
      selection_(counting_references(options)),
      min_reference_gain_(min_reference_gain),
      cells_(cells) {}

PaperCoverage::Admission PaperCoverage::admit(std::vector<SetMember> members, const Contribution& part) const {
  const double before = set_coverage(members, false, options_);
  const bool full = count_references(members) >= options_.max_references;
  Admission result;
  // Section 3.4 decides by fcov(R(b)), whether or not scov counts R(b) alone. While R(b) is not full, Delta_fcov is 0.
  double least = set_coverage(members, false, selection_) + (full ? min_reference_gain_ : 0);
  members.push_back({part, true});
  if (!full) {
    result.admitted = set_coverage(members, true, selection_) > least;
  } else {
    for (std::size_t i = 0; i + 1 < members.size(); ++i) {
      if (!members[i].referenced) continue;
      members[i].referenced = false;
      const double value = set_coverage(members, true, selection_);
      members[i].referenced = true;
      if (value <= least) continue;
      least = value;
      result.admitted = true;
      result.victim = i;
    }
  }
  members.back().referenced = result.admitted;
  if (result.victim) members[*result.victim].referenced = false;
  result.gain = set_coverage(members, true, options_) - before;
  return result;
}

double PaperCoverage::do_gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                              std::span<double> corrections) const {
  const State& state = cells_[cell];
  const double gain = admit(state.members, part).gain;
  if (victims.empty()) return gain;
  for (std::size_t i = 0; i < state.members.size(); ++i) {
    const ViewSlot slot = state.slots[i];
    if (victims[slot] != 0) corrections[slot] += admit(without(state.members, i), part).gain - gain;
  }
  return gain;
}

void PaperCoverage::add_losses(CellId cell, double factor, std::span<double> losses) const {
  if (losses.empty()) return;  // the caller needs no losses
  const State& state = cells_[cell];
  for (std::size_t i = 0; i < state.members.size(); ++i) {
    losses[state.slots[i]] += factor * (state.value - set_coverage(without(state.members, i), false, options_));
  }
}

double PaperCoverage::do_value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                             const Contribution* newcomer) const {
  const State& state = cells_[cell];
  std::vector<SetMember> members;
  for (std::size_t i = 0; i < state.members.size(); ++i) {
    if (std::find(gone.begin(), gone.end(), state.slots[i]) == gone.end()) members.push_back(state.members[i]);
  }
  const double value = set_coverage(members, false, options_);
  return newcomer ? value + admit(std::move(members), *newcomer).gain : value;
}

void PaperCoverage::do_insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) {
  add_losses(cell, -1, losses);
  State& state = cells_[cell];
  const Admission admission = admit(state.members, part);
  if (admission.victim) state.members[*admission.victim].referenced = false;
  state.slots.push_back(slot);
  state.members.push_back({part, admission.admitted});
  state.value = set_coverage(state.members, false, options_);
  add_losses(cell, 1, losses);
}

void PaperCoverage::do_erase(CellId cell, ViewSlot slot, std::span<double> losses) {
  add_losses(cell, -1, losses);
  State& state = cells_[cell];
  const auto at = std::find(state.slots.begin(), state.slots.end(), slot) - state.slots.begin();
  const bool was_referenced = state.members[static_cast<std::size_t>(at)].referenced;
  state.slots.erase(state.slots.begin() + at);
  state.members.erase(state.members.begin() + at);
  if (was_referenced) refill(state);
  state.value = set_coverage(state.members, false, options_);
  add_losses(cell, 1, losses);
}

bool PaperCoverage::is_member(CellId cell, ViewSlot slot) const {
  const std::vector<ViewSlot>& slots = cells_[cell].slots;
  return std::find(slots.begin(), slots.end(), slot) != slots.end();
}

// Gives a cell that lost a reference the best of the other stored views that see it.
void PaperCoverage::refill(State& state) const {
  SetMember* choice = nullptr;
  double best = set_coverage(state.members, false, selection_);
  for (SetMember& member : state.members) {
    if (member.referenced) continue;
    member.referenced = true;
    const double value = set_coverage(state.members, false, selection_);
    member.referenced = false;
    if (value > best) {
      best = value;
      choice = &member;
    }
  }
  if (choice) choice->referenced = true;
}

std::vector<ViewSlot> PaperCoverage::do_references(CellId cell) const {
  const State& state = cells_[cell];
  std::vector<ViewSlot> slots;
  for (std::size_t i = 0; i < state.members.size(); ++i) {
    if (state.members[i].referenced) slots.push_back(state.slots[i]);
  }
  return slots;
}

void PaperCoverage::do_follow(const Surface&, std::span<const CellId> previous_cell) {
  std::vector<State> cells(previous_cell.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (previous_cell[cell] != CellId::none) cells[cell] = std::move(cells_[previous_cell[cell]]);
  }
  cells_ = std::move(cells);
}

}  // namespace lumatlas
