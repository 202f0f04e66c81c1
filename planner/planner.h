// SPDX-License-Identifier: GPL-3.0-or-later
// Online view planning: decides for each photograph, as it arrives, whether the store keeps it, in whose place, and
// which cells refer to it. Erat et al. 2019, section 3.2 (candidate view evaluation) and 3.4 (pre-selection).
//
// A dropped view is never looked at again and nothing of it is held. Departure from the print: scov counts a cell's
// references R(b) instead of all stored views that see it, because only references are drawn; a cell that loses a view
// takes the best of the other stored views that see it instead.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility.h"
#include "planner/coverage.h"
#include "planner/refiner.h"

namespace lumatlas {

struct PlannerOptions {
  CoverageOptions coverage;
  ValidityOptions validity;
  RefinementOptions refinement;
  // Delta_scov: a view is kept if it raises scov by more than this share of the number of cells that it sees; >= 0.
  // 0 keeps whatever helps at all; larger keeps fewer views and redoes less.
  double min_view_gain = 0.1;
  double min_reference_gain = 0.01;  // Delta_fcov: by which a full cell's coverage must rise to swap a reference; >= 0
  std::uint32_t victims = 8;         // how many of the lowest-ranked views are considered for replacement, >= 1
  // Longer side of the image that cells are counted in, >= 1; never above the photograph's.
  std::uint32_t visibility_px = 320;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const PlannerOptions& options);

enum class Decision {
  kept,
  replaced,  // kept in the place of another
  rejected,  // would not have added enough
  outlier,   // would have been kept, but its photograph does not agree with the others, whatever its pose
};

// What became of an offered view.
struct Verdict {
  Decision decision = Decision::rejected;
  std::optional<std::uint32_t> slot;    // where it was stored
  std::optional<std::string> replaced;  // the name of the view that it took the place of
  double gain = 0;                      // by which scov rose, or would have risen, in cells
  std::uint32_t cells_seen = 0;
  double visibility_ms = 0;              // wall time of the visibility pass,
  double plan_ms = 0;                    // of the decision,
  double refine_ms = 0;                  // of the refinement,
  double store_ms = 0;                   // and of storing (depth at full resolution)
  std::optional<Refinement> refinement;  // of a view that was to be stored
};

// Median depth, scene units, of what the cameras see: the scene's natural length, for CoverageOptions::ideal_distance.
// Looks at 16 cameras or fewer, evenly spaced, at low resolution. Throws InputError if none of them sees the mesh.
[[nodiscard]] double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility);

class Planner {
 public:
  // Writes to `atlas` alone; both must outlive the planner. The atlas must be empty (std::invalid_argument).
  Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options);

  // The photograph must be as large as its camera says (std::invalid_argument). On return the atlas holds the view or
  // nothing of it.
  Verdict offer(const std::string& name, const Camera& camera, Photograph photograph);

  // One step of joint polishing of all stored views; to be repeated until the residual rests.
  PolishStep polish() { return refiner_.polish(options_.validity); }
  // Makes the masks of all stored views again, now that each has all the others to be judged by.
  void mask() { refiner_.mask(options_.validity); }
  // What the stored views say about their intrinsics, and the step that believes it: see Refiner.
  [[nodiscard]] IntrinsicsEstimate estimate_intrinsics(const IntrinsicsOptions& options = {}) const {
    return refiner_.estimate_intrinsics(options);
  }
  void set_cameras(const IntrinsicsEstimate& estimate) { refiner_.set_cameras(estimate, options_.validity); }

  [[nodiscard]] std::uint32_t stored_views() const { return atlas_.size(); }
  [[nodiscard]] double summed_coverage() const { return summed_coverage_; }  // scov, in cells

 private:
  // One stored view's part in one cell.
  struct Member {
    std::uint32_t slot;
    bool referenced;
    Contribution part;
  };
  struct CellPart {
    std::uint32_t cell;
    Contribution part;
  };
  // What adding a view to a cell's references would do.
  struct Admission {
    bool admitted = false;
    std::optional<std::uint32_t> victim;  // index among the cell's members
    double gain = 0;
  };

  [[nodiscard]] std::vector<CellPart> parts_of(const Camera& camera, Verdict& verdict);
  [[nodiscard]] Admission admit(std::span<const Member> members, const Contribution& part,
                                std::optional<std::uint32_t> without_slot) const;
  [[nodiscard]] double coverage_of(std::span<const Member> members, std::optional<std::uint32_t> without_slot) const;
  [[nodiscard]] double gain_of(std::span<const CellPart> parts, std::optional<std::uint32_t> victim) const;
  [[nodiscard]] std::vector<std::uint32_t> lowest_ranked_slots() const;
  void store(std::uint32_t slot, std::span<const CellPart> parts);
  void evict(std::uint32_t slot);
  void refill(std::uint32_t cell);
  void publish(std::uint32_t cell);
  void update_ranks(std::span<const std::uint32_t> cells);

  Atlas& atlas_;
  const Visibility& visibility_;
  PlannerOptions options_;
  Refiner refiner_;
  VisibilityBuffer buffer_;
  std::vector<std::vector<Member>> members_;          // by cell: every stored view that sees it
  std::vector<std::vector<std::uint32_t>> cells_of_;  // by slot: the cells that its view sees
  std::vector<double> cell_coverage_;                 // fcov(R(b)) by cell
  std::vector<double> loss_;  // by slot: what scov would lose without it, negative if it would rise
  double summed_coverage_ = 0;
};

}  // namespace lumatlas
