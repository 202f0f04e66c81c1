// SPDX-License-Identifier: GPL-3.0-or-later
// Online view planning: decides for each photograph, as it arrives, whether the store keeps it, in whose place, and
// which cells refer to it. Erat et al. 2019, section 3.2 (candidate view evaluation) and 3.4 (pre-selection).
//
// A dropped view is never looked at again and nothing of it is held.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/coverage/coverage_ledger.h"
#include "planner/coverage/offered_coverage.h"
#include "planner/refinement/refiner.h"

namespace lumatlas {

struct PlannerOptions {
  CoverageOptions coverage;
  ValidityOptions validity;
  RefinementOptions refinement;
  // Delta_scov: a view is kept if it raises scov by more than this share of what its cells would be worth, served as
  // well as one can be: their number, or with CoverageOptions::demand the sum of their weights; >= 0.
  // 0 keeps whatever helps at all; larger keeps fewer views and redoes less. For Metric::paper, by which a cell counts
  // up to fcov_max and not up to 1, 0.1 is right.
  double min_view_gain = 0.001;
  // While the store is full: by more than this share of what its views are worth on average, scov / N; >= 0. At 1, with
  // a min_view_gain of 0, without max_bytes and without outliers, a store by Metric::directions is never worth less
  // than a quarter of the best, whatever the stream (see direction_coverage.h).
  double min_exchange_gain = 0.05;
  // Delta_fcov: by which a full cell's coverage must rise to swap a reference; >= 0. For Metric::paper 0.01 is right.
  double min_reference_gain = 0.001;
  // How many of the lowest-ranked views are considered for replacement; 0: all of them.
  std::uint32_t victims = 0;
  // What the stored views may take together, bytes as stored_bytes() counts them; 0: as many as the atlas has slots
  // for.
  std::uint64_t max_bytes = 0;
  // The store grows only while it is predicted to look worse by more than half of this than one of all offered views,
  // and thin() takes views and references away again until it would be more than this: see predicted_loss.h. dB,
  // finite, >= 0; needs Metric::directions. None: bounded by room alone.
  std::optional<double> max_loss_db;
  // Longer side of the image that cells are counted in, >= 1; never above the photograph's.
  std::uint32_t visibility_px = 160;
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
  std::optional<std::uint32_t> slot;  // where it was stored
  std::vector<std::string> replaced;  // the names of the views that it took the place of
  double gain = 0;                    // by which scov rose, or would have risen
  std::uint32_t cells_seen = 0;
  double visibility_ms = 0;              // wall time of the visibility pass,
  double plan_ms = 0;                    // of the decision,
  double refine_ms = 0;                  // of the refinement,
  double store_ms = 0;                   // and of storing (depth at full resolution)
  std::optional<Refinement> refinement;  // of a view that was to be stored
};

// What a view of a camera takes in the store, bytes: colour, depth, trust, validity and rim of each of its pixels.
[[nodiscard]] std::uint64_t stored_bytes(const Camera& camera);

// Median depth, scene units, of what the cameras see: the scene's natural length, for CoverageOptions::ideal_distance.
// Looks at 16 cameras or fewer, evenly spaced, at low resolution; at others only until one sees the mesh, where those
// do not. Above 0. Throws InputError if none does or if the cameras stand on what they see, std::invalid_argument for a
// camera that does not pass check().
[[nodiscard]] double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility);

// What a change of the geometry made necessary.
struct SurfaceUpdate {
  std::uint32_t views_seen_again = 0;   // whose cells were counted anew
  std::uint32_t depths_made_again = 0;  // of those, how many show something else than before
};

// By how much a store is expected to look worse than one of all offered views: see predicted_loss.h.
struct PredictedLoss {
  double gap = 0;            // of coverage, a share
  double reference_gap = 0;  // of the service of cells' references, a share
  double loss_db = 0;        // with both
  std::size_t references_given_up = 0;
  bool short_of_room = false;  // a view was needed for max_loss_db, but the store was full
};

// One step of taking away a store's views, the one that is missed least first.
struct ThinningStep {
  std::uint32_t slot = 0;
  double gap = 0;  // by what share of scov the store falls short of what it was before the first step, in [0, 1]
};

// Gives the photograph of the view that is offered, when it is asked for: at most once, before offer() returns.
using PhotographSource = std::function<Photograph()>;

class Planner {
 public:
  // Writes to `atlas` alone; both must outlive the planner (or, for `visibility`, be replaced by update_surface()). The
  // atlas must be empty (std::invalid_argument).
  Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options);

  // The camera must pass check(), and the photograph be as large as its camera says, with three values a pixel of
  // colour and one or none of the lens's image (std::invalid_argument); it is asked for only if the view is to be
  // stored. On return the atlas holds the view or nothing of it. A view that is larger than max_bytes alone is refused
  // (std::invalid_argument).
  Verdict offer(const std::string& name, const Camera& camera, const PhotographSource& photograph);
  Verdict offer(const std::string& name, const Camera& camera, Photograph photograph);
  // Stores a view that was chosen elsewhere, whatever it adds; there must be room for it (std::invalid_argument). May
  // still be found an outlier.
  Verdict keep(const std::string& name, const Camera& camera, const PhotographSource& photograph);

  // Decides as offer() would if the photograph agreed with the others, without asking for it: a view that is to be
  // stored is promised a slot, in which the store holds it once fill() has brought the photograph. Where all cameras
  // are known beforehand, photographs that would leave again for others are thus never read. Promised views take part
  // in every later decision, and may lose their slot to another. Not with max_loss_db (std::logic_error): what was
  // offered could not be taken back from a promised view that turns out to be an outlier.
  Verdict reserve(const std::string& name, const Camera& camera);
  // Whether the slot is promised to the view of that name, and not filled yet.
  [[nodiscard]] bool is_promised(const std::string& name, std::uint32_t slot) const;
  // Stores the photograph of a view that still has the slot of its verdict, to which this adds what offer() would have
  // told; throws what offer() throws. An outlier gives its slot back, what it asked for does not count, and those whose
  // place it took stay away. Throws std::logic_error unless the verdict's slot is promised to that name.
  void fill(const std::string& name, const PhotographSource& photograph, Verdict& verdict);
  // As offer(), for a view that was rejected or replaced before, where there is room again: what it asks for counts
  // already. Not with max_loss_db (std::logic_error).
  Verdict offer_again(const std::string& name, const Camera& camera, const PhotographSource& photograph);

  // Looks at a view that was not chosen elsewhere: it is not stored, but counts for what the stream asks for.
  void pass_by(const Camera& camera);

  // With max_loss_db: takes stored views away, each time the one that is missed least, as long as their predicted loss
  // stays within a share of the bound, and then gives up references, as long as both together stay within it. With a
  // bound of 0 none. Returns the views' names in that order. To be called when the stream has ended, or rests: what is
  // taken away does not come back. What follows is for those who choose by something better than the prediction.
  std::vector<std::string> thin();
  // In which order stored views would be taken away, down to the last, had those in the slots `absent` never been
  // offered, nor any that is not stored; nothing is changed. No slot may be promised (std::logic_error), here and
  // below.
  [[nodiscard]] std::vector<ThinningStep> thinning_order(std::span<const std::uint32_t> absent = {}) const;
  // What cells would refer to then, were only these views left, and after give_up_references(max_loss_db).
  [[nodiscard]] ReferenceTable references_among(std::span<const std::uint32_t> slots,
                                                std::span<const std::uint32_t> absent = {},
                                                double max_loss_db = 0) const;
  // Each slot must hold a view (std::logic_error; nothing is changed then).
  void take_away(std::span<const std::uint32_t> slots);
  // As long as those given up are predicted to cost at most so much, dB; a cell keeps as many as are blended. None
  // unless that is above 0.
  void give_up_references(double max_loss_db);
  // Of max_loss_db, the part that thin() leaves to references, dB.
  [[nodiscard]] double loss_of_references() const;
  // As the store is now. Needs max_loss_db (std::logic_error).
  [[nodiscard]] PredictedLoss predicted_loss() const;

  // What the camera sees of each cell: what it would add to an empty store.
  [[nodiscard]] std::vector<CellPart> parts_of(const Camera& camera) const;

  // One step of joint polishing of all stored views; to be repeated until the residual rests.
  PolishStep polish() { return refiner_.polish(options_.validity); }
  // The poses of all stored views at once: see Refiner::solve_poses().
  PoseEstimate solve_poses(std::size_t most_points) { return refiner_.solve_poses(most_points, options_.validity); }
  // When the stream has ended, or rests: brings masks, poses and depths in the atlas up to date. Until then its poses
  // may be up to kDepthStandsPx away from the refined ones. See Refiner::settle().
  void settle() { refiner_.settle(options_.validity); }
  // See Refiner::revisited() and at_rest().
  [[nodiscard]] std::uint64_t revisited() const { return refiner_.revisited(); }
  [[nodiscard]] bool at_rest() const { return refiner_.at_rest(); }
  // See Refiner::compared_in_full().
  [[nodiscard]] std::uint64_t compared_in_full() const { return refiner_.compared_in_full(); }
  // What the stored views say about their lenses, and the step that believes it: see Refiner.
  [[nodiscard]] LensEstimates estimate_lenses(const LensOptions& options = {}) const {
    return refiner_.estimate_lenses(options);
  }
  void correct_lenses(const LensEstimates& estimates, const CorrectedPhotograph& corrected) {
    refiner_.correct_lenses(estimates, corrected, options_.validity);
  }

  // How depth edges are masked from now on, where stored views have been replaced by such of another resolution. Throws
  // std::invalid_argument if it does not pass check().
  void mask_edges_by(const ValidityOptions& validity);
  // The mesh has changed. `visibility` sees the new one and is used from here on. `previous_cell` and `changed` say
  // what became of the cells, as CellGrowth does: by cell of the new surface, which one it was, and whether it is as it
  // was. No slot may be promised (std::logic_error). Views that can see a cell that is new, changed or gone are counted
  // again, at the poses that they are stored with, and their depths and masks made again; nothing else is. References
  // are then those of the new cells, and of a cell that is new or changed only the stored views were offered. Throws
  // std::invalid_argument, and changes nothing, if the surface does not fit: see Atlas::replace_surface().
  SurfaceUpdate update_surface(std::shared_ptr<const Surface> surface, const Visibility& visibility,
                               std::span<const std::uint32_t> previous_cell, std::span<const std::uint8_t> changed);

  [[nodiscard]] std::uint32_t stored_views() const { return atlas_.size(); }
  // The name of the view that the slot holds or is promised to; the slot must not be free.
  [[nodiscard]] std::string name_of(std::uint32_t slot) const;
  // Of the stored views as they came; downscaled ones take less.
  [[nodiscard]] std::uint64_t stored_bytes() const { return stored_bytes_; }
  // scov: in cells, or with CoverageOptions::demand in pictures.
  [[nodiscard]] double summed_coverage() const { return ledger_.summed_coverage(); }
  // Each cell's part in it, for what the cell counts: of the directions measure in [0, 1].
  [[nodiscard]] std::vector<float> cell_coverage() const;

 private:
  // A view that has a slot, but no photograph yet.
  struct Promise {
    std::string name;
    Camera camera;
  };
  // What the atlas is about to hold, and which face each pixel shows.
  struct ReadyView {
    TiledView tiled;
    std::vector<std::uint32_t> face;
  };
  // Which views would leave for a view, and by how much scov would rise.
  struct Exchange {
    std::vector<std::uint32_t> victims;
    double gain = 0;
  };

  [[nodiscard]] Camera planning_camera(const Camera& camera) const;
  [[nodiscard]] std::vector<CellPart> parts(const Camera& small, std::span<const CellPixels> seen) const;
  [[nodiscard]] std::vector<CellPart> look(const Camera& camera, Verdict& verdict);
  void note_seen(std::span<const CellPart> seen);
  [[nodiscard]] std::vector<std::uint32_t> stored_slots() const;
  [[nodiscard]] static std::vector<std::uint32_t> lowest_ranked(const CoverageLedger& ledger,
                                                                std::vector<std::uint32_t> slots, std::size_t count);
  [[nodiscard]] std::uint64_t bytes_of(std::uint32_t slot) const { return slot_bytes_[slot]; }
  [[nodiscard]] bool fits(std::uint64_t bytes, std::uint64_t freed_bytes, std::uint32_t freed_slots) const;
  void require_room_for(const std::string& name, const Camera& camera) const;
  [[nodiscard]] Exchange best_exchange(std::span<const CellPart> parts, std::uint64_t bytes) const;
  [[nodiscard]] Exchange joint_exchange(std::span<const CellPart> parts, std::uint64_t bytes) const;
  [[nodiscard]] bool is_worth_it(const Exchange& exchange, std::span<const CellPart> seen) const;
  [[nodiscard]] bool is_needed(std::span<const CellPart> seen) const;
  void count_offered(std::span<const CellPart> seen);
  [[nodiscard]] std::optional<Exchange> exchange_for(const Camera& camera, std::span<const CellPart> seen,
                                                     Verdict& verdict);
  void require_offer(const std::string& name, const Camera& camera, const PhotographSource& photograph) const;
  void decide(const std::string& name, const Camera& camera, const PhotographSource& photograph,
              const std::vector<CellPart>& seen, Verdict& verdict);
  void claim_slot(const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange, Verdict& verdict);
  [[nodiscard]] bool refine(const std::string& name, const Camera& camera, const Photograph& photograph,
                            Verdict& verdict);
  [[nodiscard]] ReadyView ready(const std::string& name, const Camera& camera, Photograph photograph,
                                Verdict& verdict) const;
  void store(ReadyView ready, const Camera& camera, Verdict& verdict);
  void take(const std::string& name, const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange,
            Photograph photograph, Verdict& verdict);
  void evict(std::uint32_t slot);
  [[nodiscard]] std::vector<std::uint32_t> stored_slots_but(std::span<const std::uint32_t> absent) const;
  [[nodiscard]] CoverageLedger ledger_of(std::span<const std::uint32_t> slots,
                                         std::span<const std::uint32_t> offered) const;
  void publish(std::span<const CellPart> cells);
  [[nodiscard]] std::vector<std::uint32_t> views_of_change(std::span<const std::uint32_t> previous_cell,
                                                           std::span<const std::uint8_t> changed,
                                                           const Surface& surface) const;
  void offer_stored_again(std::span<const std::uint32_t> slots, std::span<const std::uint8_t> changed);
  bool make_depth_again(std::uint32_t slot);

  Atlas& atlas_;
  const Visibility* visibility_;
  PlannerOptions options_;
  Refiner refiner_;
  CoverageLedger ledger_;
  std::optional<OfferedCoverage> offered_;        // of max_loss_db
  std::vector<std::optional<Promise>> promised_;  // by slot
  std::vector<std::uint64_t> slot_bytes_;         // of the view that has it, as it came: see stored_bytes()
  bool short_of_room_ = false;
  VisibilityBuffer buffer_;
  std::uint32_t held_views_ = 0;    // stored or promised a slot
  std::uint64_t stored_bytes_ = 0;  // of these
};

}  // namespace lumatlas
