// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/planned_store.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "atlas/tiles/texel_format.h"

namespace lumatlas {

std::uint64_t stored_bytes(const Camera& camera) {
  return kStoredPixelBytes * camera.width * camera.height;
}

PlannedStore::PlannedStore(Atlas& atlas, Refiner& refiner, const PlannerOptions& options)
    : atlas_(atlas),
      refiner_(refiner),
      options_(options),
      ledger_(*atlas.surface(), atlas.capacity(), options.coverage, options.min_reference_gain),
      promised_(atlas.capacity()),
      slot_bytes_(atlas.capacity(), 0) {
  if (atlas.size() != 0) throw std::invalid_argument("planner: the atlas holds views already, must be empty");
  if (options.max_loss_db) offered_.emplace(*atlas.surface(), options.coverage);
}

std::vector<ViewSlot> PlannedStore::held_slots() const {
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < atlas_.capacity(); ++slot) {
    if (ledger_.stored(slot)) slots.push_back(slot);
  }
  return slots;
}

std::string PlannedStore::name_of(ViewSlot slot) const {
  return promised_[slot] ? promised_[slot]->name : atlas_.view(slot)->name;
}

const Camera* PlannedStore::promised_camera(const std::string& name, ViewSlot slot) const {
  const bool is_promised = slot < promised_.size() && promised_[slot] && promised_[slot]->name == name;
  return is_promised ? &promised_[slot]->camera : nullptr;
}

void PlannedStore::require_no_promise() const {
  if (std::any_of(promised_.begin(), promised_.end(), [](const auto& promise) { return promise.has_value(); })) {
    throw std::logic_error("planner: a slot is promised, so it is not known what the store holds");
  }
}

std::vector<float> PlannedStore::cell_coverage() const {
  std::vector<float> coverage(ledger_.cells());
  for (CellId cell{0}; cell < coverage.size(); ++cell) {
    const double weight = ledger_.weight(cell);
    coverage[cell] = weight > 0 ? static_cast<float>(ledger_.coverage(cell) / weight) : 0.0f;
  }
  return coverage;
}

bool PlannedStore::fits(std::uint64_t bytes, std::uint64_t freed_bytes, std::uint32_t freed_slots) const {
  if (held_views_ - freed_slots >= atlas_.capacity()) return false;
  return options_.max_bytes == 0 || stored_bytes_ - freed_bytes + bytes <= options_.max_bytes;
}

void PlannedStore::add_demand(std::span<const CellPart> seen) {
  ledger_.add_demand(seen);
  if (offered_) offered_->add_demand(seen);
}

void PlannedStore::remove_demand(std::span<const CellPart> seen) {
  ledger_.remove_demand(seen);
  if (offered_) offered_->remove_demand(seen);
}

void PlannedStore::count_offered(std::span<const CellPart> seen) {
  if (offered_) offered_->add(seen);
}

void PlannedStore::note_seen(std::span<const CellPart> seen) {
  std::vector<CellPixels> cells;
  cells.reserve(seen.size());
  for (const CellPart& part : seen) cells.push_back({part.cell, 1});
  atlas_.mark_seen(cells);
}

ViewSlot PlannedStore::claim(const Camera& camera, const std::vector<CellPart>& seen) {
  ViewSlot slot{0};
  while (ledger_.stored(slot)) ++slot;
  ledger_.insert(slot, seen);
  ++held_views_;
  slot_bytes_[slot] = lumatlas::stored_bytes(camera);
  stored_bytes_ += slot_bytes_[slot];
  return slot;
}

void PlannedStore::promise(ViewSlot slot, const std::string& name, const Camera& camera) {
  promised_[slot] = Promise{name, camera};
}

void PlannedStore::put(ViewSlot slot, TiledView tiled, AtlasEdit& edit) {
  edit.insert_at(slot, std::move(tiled.view), std::move(tiled.shown));
  promised_[slot].reset();
  publish(ledger_.parts(slot), edit);
}

void PlannedStore::evict(ViewSlot slot, AtlasEdit& edit) {
  const std::vector<CellPart> seen(ledger_.parts(slot).begin(), ledger_.parts(slot).end());
  const bool promised = promised_[slot].has_value();
  stored_bytes_ -= bytes_of(slot);
  --held_views_;
  ledger_.erase(slot);
  promised_[slot].reset();
  publish(seen, edit);
  if (promised) return;
  refiner_.remove(slot);
  edit.erase(slot);
}

void PlannedStore::evict(ViewSlot slot) {
  AtlasEdit edit;
  evict(slot, edit);
  atlas_.commit(std::move(edit));
}

void PlannedStore::give_up(CellId cell, std::span<const ViewSlot> slots) {
  ledger_.give_up(cell, slots);
  AtlasEdit edit;
  publish(cell, edit);
  atlas_.commit(std::move(edit));
}

void PlannedStore::publish(std::span<const CellPart> cells, AtlasEdit& edit) const {
  for (const CellPart& entry : cells) publish(entry.cell, edit);
}

// Views that are promised a slot have nothing yet to refer to.
void PlannedStore::publish(CellId cell, AtlasEdit& edit) const {
  std::vector<ViewSlot> references = ledger_.references(cell);
  std::erase_if(references, [&](ViewSlot slot) { return promised_[slot].has_value(); });
  edit.set_references(cell, std::move(references));
}

void PlannedStore::follow(const Surface& surface, std::span<const ViewSlot> again,
                          std::span<const CellId> unchanged_cell) {
  std::vector<std::uint8_t> kept(ledger_.cells(), 0);
  for (const CellId before : unchanged_cell) {
    if (before != CellId::none) kept[before] = 1;
  }
  for (const ViewSlot slot : again) ledger_.keep_cells(slot, kept);
  ledger_.follow(surface, unchanged_cell);
  if (offered_) offered_->follow(surface, unchanged_cell);
}

void PlannedStore::count_again(ViewSlot slot, std::vector<CellPart> seen) {
  ledger_.replace(slot, std::move(seen));
}

// Views that were offered and are not stored are unknown here, so only the stored ones count for the changed cells.
void PlannedStore::offer_again(std::span<const ViewSlot> slots, std::span<const std::uint8_t> changed) {
  if (offered_) {
    std::vector<std::vector<CellPart>> views;
    for (const ViewSlot slot : slots) {
      std::vector<CellPart>& view = views.emplace_back();
      const std::span<const CellPart> seen = ledger_.parts(slot);
      std::copy_if(seen.begin(), seen.end(), std::back_inserter(view),
                   [&](const CellPart& entry) { return changed[entry.cell] != 0; });
    }
    // The demand of all comes first: what a view is worth depends on it.
    for (const std::vector<CellPart>& view : views) offered_->add_demand(view);
    for (const std::vector<CellPart>& view : views) offered_->add(view);
  }
  AtlasEdit edit;
  for (CellId cell{0}; cell < ledger_.cells(); ++cell) publish(cell, edit);
  atlas_.commit(std::move(edit));
}

}  // namespace lumatlas
