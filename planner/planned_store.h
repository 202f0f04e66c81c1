// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps account of the views that the planner has put into the atlas: their slots, their bytes, and their value to the
// cells (Erat et al. 2019, section 3.2).
//
// A slot is free, promised to a view whose photograph has not been read yet, or holds a view. A view counts for
// coverage from the moment at which it has a slot; cells refer to it once the atlas holds it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "planner/coverage/coverage_ledger.h"
#include "planner/coverage/offered_coverage.h"
#include "planner/planner_options.h"
#include "planner/refinement/refiner.h"

namespace lumatlas {

// Returns what a view of a camera takes in the store, bytes: colour, depth, trust, validity and rim of each of its
// pixels.
[[nodiscard]] std::uint64_t stored_bytes(const Camera& camera);

// The caller passes slots below the atlas's capacity; this is not checked.
class PlannedStore {
 public:
  // The three must outlive the store. The atlas must be empty (std::invalid_argument) and the options pass check().
  PlannedStore(Atlas& atlas, Refiner& refiner, const PlannerOptions& options);

  // Views that have a slot, the promised ones among them.
  [[nodiscard]] std::uint32_t held_views() const { return held_views_; }
  [[nodiscard]] std::vector<ViewSlot> held_slots() const;  // ascending
  // Views whose photographs the atlas holds.
  [[nodiscard]] std::uint32_t stored_views() const { return atlas_.size(); }
  // Returns the bytes of the views that have a slot, at the size at which they were offered; downscaled ones take less.
  [[nodiscard]] std::uint64_t stored_bytes() const { return stored_bytes_; }
  [[nodiscard]] std::uint64_t bytes_of(ViewSlot slot) const { return slot_bytes_[slot]; }
  // Returns the name of the view that has the slot, which must not be free.
  [[nodiscard]] std::string name_of(ViewSlot slot) const;
  // Returns the camera that the view of that name was promised the slot with, null if it is not promised to that view
  // or filled already.
  [[nodiscard]] const Camera* promised_camera(const std::string& name, ViewSlot slot) const;
  // Throws std::logic_error if any slot is promised.
  void require_no_promise() const;

  // Returns scov: in cells, or with CoverageOptions::demand in pictures.
  [[nodiscard]] double summed_coverage() const { return ledger_.summed_coverage(); }
  // Returns each cell's part in scov as a share of the most that the cell can count; by Metric::directions in [0, 1].
  [[nodiscard]] std::vector<float> cell_coverage() const;
  [[nodiscard]] const CoverageLedger& ledger() const { return ledger_; }
  // Returns what all offered views would be worth; none without PlannerOptions::max_loss_db.
  [[nodiscard]] const std::optional<OfferedCoverage>& offered() const { return offered_; }
  // Returns whether a view was needed for max_loss_db while there was no room for it.
  [[nodiscard]] bool short_of_room() const { return short_of_room_; }
  [[nodiscard]] const PlannerOptions& options() const { return options_; }
  [[nodiscard]] Atlas& atlas() const { return atlas_; }

  // Returns whether a view of `bytes` has room once `freed_slots` views have left, which take `freed_bytes` together.
  [[nodiscard]] bool fits(std::uint64_t bytes, std::uint64_t freed_bytes = 0, std::uint32_t freed_slots = 0) const;

  // Adds the demand of a view for the cells that it sees (CellDemand), or removes it.
  void add_demand(std::span<const CellPart> seen);
  void remove_demand(std::span<const CellPart> seen);
  // Counts a view, whose demand was added, among the offered ones.
  void count_offered(std::span<const CellPart> seen);
  // Marks the cells in the atlas as seen.
  void note_seen(std::span<const CellPart> seen);
  void note_short_of_room() { short_of_room_ = true; }

  // Gives the lowest free slot to a view and returns it; there must be one.
  ViewSlot claim(const Camera& camera, const std::vector<CellPart>& seen);
  // Promises the slot, which was just claimed, to a view without its photograph.
  void promise(ViewSlot slot, const std::string& name, const Camera& camera);
  // Adds to the edit: the view in its slot, and references of the cells that it sees.
  void put(ViewSlot slot, TiledView tiled, AtlasEdit& edit);
  // Frees the slot here, and adds to the edit that the atlas frees it, with the references that cells then have.
  void evict(ViewSlot slot, AtlasEdit& edit);
  void evict(ViewSlot slot);  // the same, and commits the edit
  // Removes these references of a cell.
  void give_up(CellId cell, std::span<const ViewSlot> slots);

  // For GeometryFollower, in this order. follow() takes the views whose cells are counted again out of the cells that
  // change, and numbers the cells as on the new surface. count_again() counts a view with what it sees there.
  // offer_again() counts these views among the offered ones and brings the references of all cells up to date.
  void follow(const Surface& surface, std::span<const ViewSlot> again, std::span<const CellId> unchanged_cell);
  void count_again(ViewSlot slot, std::vector<CellPart> seen);
  void offer_again(std::span<const ViewSlot> slots, std::span<const std::uint8_t> changed);

 private:
  // A view that has a slot, but no photograph yet.
  struct Promise {
    std::string name;
    Camera camera;
  };

  void publish(std::span<const CellPart> cells, AtlasEdit& edit) const;
  void publish(CellId cell, AtlasEdit& edit) const;

  Atlas& atlas_;
  Refiner& refiner_;
  const PlannerOptions& options_;
  CoverageLedger ledger_;
  std::optional<OfferedCoverage> offered_;
  std::vector<std::optional<Promise>> promised_;  // by slot
  std::vector<std::uint64_t> slot_bytes_;         // of the view that has it, as offered: see lumatlas::stored_bytes()
  std::uint32_t held_views_ = 0;
  std::uint64_t stored_bytes_ = 0;  // of the held views
  bool short_of_room_ = false;
};

}  // namespace lumatlas
