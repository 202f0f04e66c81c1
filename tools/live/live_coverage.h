// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/live/: decides about offered views while the planner, on another thread, still works off the views
// before. It counts what the store covers and what it will cover once all that waits is stored.
//
// The planner decides again when it stores a view, because the surface may have grown and other views may have turned
// out to be outliers. So what is decided here may be out of date, but not wrong for long.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/coverage/coverage_ledger.h"
#include "planner/planner.h"

namespace lumatlas {

// A version of the surface, for pictures of it from any thread.
struct LiveSight {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const Visibility> visibility;
};

// Holds the cells that a camera sees of one version of the surface.
struct Sighting {
  std::vector<CellPart> parts;
  double empty = 1;  // share of the picture without a surface, in [0, 1]
};

// Takes a picture of PlannerOptions::visibility_px.
[[nodiscard]] Sighting sighting_of(const LiveSight& sight, const Camera& camera, const PlannerOptions& options);

// Counts how well stored and waiting views cover one version of the surface. Not safe from several threads.
class LiveCoverage {
 public:
  // Begins with what the store counts, as it is now. `waiting`: views that may wait at once. `options` must outlive
  // this.
  LiveCoverage(const PlannedStore& store, std::uint32_t waiting, const PlannerOptions& options);

  // Returns the share of the picture that the view would show better than what is stored or waits, in [0, 1]: all of
  // what has no surface, and of each cell what it would add to the most that the cell can count.
  [[nodiscard]] double news(const Sighting& seen) const;
  // Decides as Planner does.
  [[nodiscard]] bool is_worth(const Sighting& seen) const;

  // Counts an offered view's demand, see CellDemand.
  void add_demand(const Sighting& seen) { ledger_.add_demand(seen.parts); }
  // Counts a view that waits, and returns its number among them; there must be room.
  std::uint32_t add_waiting(const Sighting& seen);
  void remove_waiting(std::uint32_t number);
  // Counts the view of one slot of the store as the planner does, and returns whether it is another one than before.
  bool follow(const PlannedStore& store, ViewSlot slot);

 private:
  [[nodiscard]] ViewSlot slot_of(std::uint32_t waiting) const { return ViewSlot{max_views_ + waiting}; }
  [[nodiscard]] std::vector<ViewSlot> stored_slots() const;
  [[nodiscard]] std::uint32_t held() const;

  const PlannerOptions& options_;
  std::uint32_t max_views_;
  CoverageLedger ledger_;           // slots of the store, then of the views that wait
  std::vector<std::string> names_;  // by slot of the store
};

}  // namespace lumatlas
