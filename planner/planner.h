// SPDX-License-Identifier: GPL-3.0-or-later
// Online view planning: decides for each photograph, as it arrives, whether the store keeps it, in whose place, and
// which cells refer to it. Erat et al. 2019, section 3.2 (candidate view evaluation) and 3.4 (pre-selection).
//
// The planner keeps nothing of a dropped view and never looks at it again. In order of use:
//
//   Planner planner(atlas, *visibility, options);
//   for (const SceneView& view : stream) planner.offer(view.name, view.camera, [&] { return read(view); });
//   planner.refiner().polish();           // as often as it helps: see refiner.h
//   planner.refiner().publish_refined();  // depths and masks follow the last poses
//   Pruning(planner).prune();             // with a bound on the loss: see pruning.h
//   const Snapshot model = atlas.snapshot();
//
// offer() draws the cells that the view sees, at PlannerOptions::visibility_px, and compares the view in each cell with
// those that serve it. A view that is stored takes longer: it is refined, and its depth is made at full resolution.
// Neither grows with the number of views offered before.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/cell_pictures.h"
#include "planner/planned_store.h"
#include "planner/planner_options.h"
#include "planner/refinement/refiner.h"

namespace lumatlas {

struct Exchange;

enum class Decision {
  kept,
  replaced,  // kept in the place of another
  rejected,  // its gain was too small
  outlier,   // would have been kept, but its photograph does not agree with the others, whatever its pose
};

// The decision about an offered view, and the time that it took.
struct Verdict {
  Decision decision = Decision::rejected;
  std::optional<ViewSlot> slot;       // where it was stored
  std::vector<std::string> replaced;  // the names of the views that it took the place of
  double gain = 0;                    // rise of scov, or the rise that a rejected view would have brought
  std::uint32_t cells_seen = 0;
  // Wall time of the visibility pass, of the decision, of the refinement, and of storing (depth at full resolution).
  double visibility_ms = 0;
  double plan_ms = 0;
  double refine_ms = 0;
  double store_ms = 0;
  std::optional<Refinement> refinement;  // set for a view that was to be stored
};

// Returns the photograph of the offered view. Called at most once, before offer() returns.
using PhotographSource = std::function<Photograph()>;

class Planner {
 public:
  // Writes to `atlas` alone. Both must outlive the planner, `visibility` only until GeometryFollower::update_surface()
  // replaces it. The atlas must be empty (std::invalid_argument).
  Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options);

  // Stores the view if it adds enough coverage, in a full store in the place of others that add less. Calls
  // `photograph` only if the view is to be stored. On return the atlas holds the whole view or nothing of it. Throws
  // std::invalid_argument, and stores nothing, unless the camera passes check(), the photograph has the camera's size,
  // three values of colour a pixel and in `valid` one a pixel or none, and the view alone is within max_bytes.
  Verdict offer(const std::string& name, const Camera& camera, const PhotographSource& photograph);
  Verdict offer(const std::string& name, const Camera& camera, Photograph photograph);
  // Stores a view that the caller has chosen, whatever it adds. An outlier is not stored. Throws std::invalid_argument
  // if there is no room for it.
  Verdict force_store(const std::string& name, const Camera& camera, const PhotographSource& photograph);

  // Decides as offer() would if the photograph agreed with the others, and needs no photograph. A view that is to be
  // stored is promised a view slot; store_reserved() then stores its photograph there. Callers that know all cameras
  // reserve first, and read only the photographs that the store holds at the end. Promised views take part in every
  // later decision, and may lose their slot to another. `sharpness`, in (0, 1]: a blurred photograph counts as if it
  // showed so small a share of each cell. Throws std::logic_error with max_loss_db: a promised view that turns out to
  // be an outlier could not be taken out of what was offered.
  Verdict reserve(const std::string& name, const Camera& camera, double sharpness = 1);
  // Stores the photograph of a view that still has the view slot of its verdict, and completes the verdict as offer()
  // would. An outlier gives its slot back and its demand is removed; views that left for it do not come back. Throws
  // std::logic_error unless the verdict's slot is promised to that name, and what offer() throws.
  void store_reserved(const std::string& name, const PhotographSource& photograph, Verdict& verdict);
  // Does what offer() does, for a view that was rejected or replaced before: its demand is not counted twice. Throws
  // std::logic_error with max_loss_db.
  Verdict offer_again(const std::string& name, const Camera& camera, const PhotographSource& photograph);

  // Counts the demand of a view that the caller does not want stored: see CellDemand.
  void count_demand(const Camera& camera);

  // Returns what the camera sees of each cell.
  [[nodiscard]] std::vector<CellPart> parts_of(const Camera& camera) const;

  // Corrects exposures, poses and lenses of the stored views.
  [[nodiscard]] Refiner& refiner() { return refiner_; }
  [[nodiscard]] const Refiner& refiner() const { return refiner_; }
  // Returns the account of the views that have a view slot, and of their coverage.
  [[nodiscard]] const PlannedStore& store() const { return store_; }

  // Sets how depth edges are masked from now on, after the caller has replaced stored views by ones of another
  // resolution. Throws std::invalid_argument if `validity` does not pass check().
  void set_validity(const ValidityOptions& validity);

 private:
  friend class GeometryFollower;
  friend class Pruning;
  // A view that the atlas is about to hold, and the face that each pixel shows.
  struct ReadyView {
    TiledView tiled;
    std::vector<FaceId> face;
  };

  [[nodiscard]] Camera planning_camera(const Camera& camera) const;
  [[nodiscard]] std::vector<CellPart> parts(const Camera& small, std::span<const CellPixels> seen) const;
  [[nodiscard]] std::vector<CellPart> look(const Camera& camera, Verdict& verdict);
  void require_room_for(const std::string& name, const Camera& camera) const;
  void require_offer(const std::string& name, const Camera& camera, const PhotographSource& photograph) const;
  [[nodiscard]] bool is_worth_it(const Exchange& exchange, std::span<const CellPart> seen) const;
  [[nodiscard]] bool is_needed(std::span<const CellPart> seen) const;
  [[nodiscard]] std::optional<Exchange> exchange_for(const Camera& camera, std::span<const CellPart> seen,
                                                     Verdict& verdict);
  void decide(const std::string& name, const Camera& camera, const PhotographSource& photograph,
              const std::vector<CellPart>& seen, Verdict& verdict);
  void claim_slot(const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange, Verdict& verdict,
                  AtlasEdit& edit);
  [[nodiscard]] bool refine(const std::string& name, const Camera& camera, const Photograph& photograph,
                            Verdict& verdict);
  [[nodiscard]] ReadyView ready(const std::string& name, const Camera& camera, Photograph photograph,
                                Verdict& verdict) const;
  void put(ReadyView ready, const Camera& camera, Verdict& verdict, AtlasEdit edit);
  void take(const std::string& name, const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange,
            Photograph photograph, Verdict& verdict);

  Atlas& atlas_;
  const Visibility* visibility_;
  PlannerOptions options_;
  Refiner refiner_;
  PlannedStore store_;
  VisibilityBuffer buffer_;
  CellPictures pictures_;             // of the views that GeometryFollower has counted
  bool counts_are_old_ = false;       // views may see other cells than they are counted for: see move_scene()
  std::vector<ViewSlot> old_depths_;  // views whose depths GeometryFollower is to make again, the oldest first
};

}  // namespace lumatlas
