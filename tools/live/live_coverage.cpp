// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_coverage.h"

#include <algorithm>
#include <stdexcept>

namespace lumatlas {

Sighting sighting_of(const LiveSight& sight, const Camera& camera, const PlannerOptions& options) {
  const Camera small = camera.shrunk_to(options.visibility_px);
  const VisibilityBuffer visible = sight.visibility->trace(small);
  const Cells& cells = sight.surface->cells;
  Sighting seen;
  seen.parts = cell_parts(cells, small, count_cell_pixels(visible, cells), options.coverage);
  const auto empty = std::count(visible.face.begin(), visible.face.end(), FaceId::none);
  seen.empty = static_cast<double>(empty) / static_cast<double>(visible.face.size());
  return seen;
}

LiveCoverage::LiveCoverage(const PlannedStore& store, std::uint32_t waiting, const PlannerOptions& options)
    : options_(options),
      max_views_(static_cast<std::uint32_t>(store.ledger().slots())),
      ledger_(store.ledger(), waiting),
      names_(max_views_) {
  for (const ViewSlot slot : stored_slots()) names_[slot] = store.name_of(slot);
}

std::vector<ViewSlot> LiveCoverage::stored_slots() const {
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < max_views_; ++slot) {
    if (ledger_.stored(slot)) slots.push_back(slot);
  }
  return slots;
}

std::uint32_t LiveCoverage::held() const {
  std::uint32_t held = 0;
  for (ViewSlot slot{0}; slot < ledger_.slots(); ++slot) held += ledger_.stored(slot);
  return held;
}

double LiveCoverage::news(const Sighting& seen) const {
  const double weight = ledger_.weight(seen.parts);
  const double gain = weight > 0 ? std::clamp(ledger_.gain(seen.parts) / weight, 0.0, 1.0) : 0;
  return seen.empty + (1 - seen.empty) * gain;
}

bool LiveCoverage::is_worth(const Sighting& seen) const {
  const double least = options_.min_view_gain * ledger_.weight(seen.parts);
  const std::uint32_t views = held();
  if (views < max_views_) return ledger_.gain(seen.parts) > least;
  const std::vector<ViewSlot> victims = stored_slots();
  if (victims.empty()) return false;  // all slots are for views that wait
  const std::vector<double> gains = ledger_.exchange_gains(seen.parts, victims);
  return *std::max_element(gains.begin(), gains.end()) >
         std::max(least, options_.min_exchange_gain * ledger_.summed_coverage() / views);
}

std::uint32_t LiveCoverage::add_waiting(const Sighting& seen) {
  std::uint32_t number = 0;
  while (ledger_.stored(slot_of(number))) ++number;
  ledger_.insert(slot_of(number), seen.parts);
  return number;
}

void LiveCoverage::remove_waiting(std::uint32_t number) {
  ledger_.erase(slot_of(number));
}

bool LiveCoverage::follow(const PlannedStore& store, ViewSlot slot) {
  const bool holds = store.ledger().stored(slot);
  const std::string name = holds ? store.name_of(slot) : std::string();
  if (holds == ledger_.stored(slot) && name == names_[slot]) return false;
  if (ledger_.stored(slot)) ledger_.erase(slot);
  names_[slot] = name;
  if (!holds) return true;
  const std::span<const CellPart> parts = store.ledger().parts(slot);
  ledger_.insert(slot, {parts.begin(), parts.end()});
  return true;
}

}  // namespace lumatlas
