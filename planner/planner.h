// SPDX-License-Identifier: GPL-3.0-or-later
// Online view planning: decides for each photograph, as it arrives, whether the store keeps it, in whose place, and
// which cells refer to it. Erat et al. 2019, section 3.2 (candidate view evaluation) and 3.4 (pre-selection).
//
// The planner keeps nothing of a dropped view and never looks at it again. In order of use:
//
//   Planner planner(atlas, *visibility, options);
//   for (const SceneView& view : stream) planner.offer(view.name, view.camera, [&] { return read(view); });
//   planner.refiner().polish();        // as often as it helps: see refiner.h
//   planner.refiner().settle();        // depths and masks follow the last poses
//   Pruning(planner).thin();           // with a bound on the loss: see pruning.h
//   const Snapshot model = atlas.snapshot();
//
// offer() costs a picture of the cells that the view sees, at PlannerOptions::visibility_px, and per cell a comparison
// with the views that serve it; of a view that is stored also its refinement and depth at full resolution.
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

// The decision about an offered view, and what it cost.
struct Verdict {
  Decision decision = Decision::rejected;
  std::optional<ViewSlot> slot;       // where it was stored
  std::vector<std::string> replaced;  // the names of the views that it took the place of
  double gain = 0;                    // rise of scov, or the rise that a rejected view would have brought
  std::uint32_t cells_seen = 0;
  double visibility_ms = 0;              // wall time of the visibility pass,
  double plan_ms = 0;                    // of the decision,
  double refine_ms = 0;                  // of the refinement,
  double store_ms = 0;                   // and of storing (depth at full resolution)
  std::optional<Refinement> refinement;  // of a view that was to be stored
};

// The work that a change of the geometry made necessary.
struct SurfaceUpdate {
  std::uint32_t views_seen_again = 0;   // whose cells were counted anew
  std::uint32_t depths_made_again = 0;  // how many of those have another depth than before
};

// When update_surface() makes depths again: at once, or view by view, by Planner::renew_depth(). The latter is for a
// stream, in which something more urgent comes between two views, and a view that two surfaces change is done once.
enum class DepthRenewal { now, later };

// Returns the photograph of the offered view. Called at most once, before offer() returns.
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
  // Stores the photograph of a view that still has the slot of its verdict, to which this adds what offer() would have
  // told; throws what offer() throws. An outlier gives its slot back, what it asked for does not count, and those whose
  // place it took stay away. Throws std::logic_error unless the verdict's slot is promised to that name.
  void fill(const std::string& name, const PhotographSource& photograph, Verdict& verdict);
  // Does what offer() does for a view that was rejected or replaced before and has room again: its demand counts
  // already. Not with max_loss_db (std::logic_error).
  Verdict offer_again(const std::string& name, const Camera& camera, const PhotographSource& photograph);

  // Looks at a view that was not chosen elsewhere: it is not stored, but counts for what the stream asks for.
  void pass_by(const Camera& camera);

  // Returns what the camera sees of each cell: what it would add to an empty store.
  [[nodiscard]] std::vector<CellPart> parts_of(const Camera& camera) const;

  // Corrects exposures, poses and lenses of the stored views.
  [[nodiscard]] Refiner& refiner() { return refiner_; }
  [[nodiscard]] const Refiner& refiner() const { return refiner_; }
  // Tells which views have which slot, and what they are worth.
  [[nodiscard]] const PlannedStore& store() const { return store_; }

  // How depth edges are masked from now on, where stored views have been replaced by such of another resolution. Throws
  // std::invalid_argument if it does not pass check().
  void mask_edges_by(const ValidityOptions& validity);
  // The mesh has changed. `visibility` sees the new one and is used from here on. `previous_cell` and `changed` say
  // what became of the cells, as CellGrowth does: by cell of the new surface, which one it was, and whether it is as it
  // was. No slot may be promised (std::logic_error). Views that can see a cell that is new, changed or gone are counted
  // again, at the poses that they are stored with, and their depths and masks made again; nothing else is. References
  // are then those of the new cells, and of a cell that is new or changed only the stored views were offered. Throws
  // std::invalid_argument, and changes nothing, if the surface does not fit: see Atlas::replace_surface(). With
  // DepthRenewal::later the views keep the depths and masks of the surface before until renew_depth() makes them again.
  SurfaceUpdate update_surface(std::shared_ptr<const Surface> surface, const Visibility& visibility,
                               std::span<const CellId> previous_cell, std::span<const std::uint8_t> changed,
                               DepthRenewal depths = DepthRenewal::now);
  // Makes the depth and mask of one view again that update_surface() left for later, the one that has waited longest.
  // Returns false if there was none.
  bool renew_depth();
  // Tells whether renew_depth() may have a view to do.
  [[nodiscard]] bool has_old_depths() const { return !old_depths_.empty(); }
  // The caller has found other poses for stored views, as a SLAM system does when it closes a loop. `poses` has the
  // poses that the views would be offered with now; what refinement corrected of the former ones is applied to these
  // too. A snapshot has all the new poses or none. Then the cells that the views see are counted again and their depths
  // and masks are made again, view by view, and at the end all references follow at once. No slot may be promised
  // (std::logic_error). Throws what Atlas::set_poses() throws, and changes nothing then.
  SurfaceUpdate move_views(std::span<const ViewPose> poses);

 private:
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
  [[nodiscard]] std::vector<ViewSlot> views_of_change(std::span<const CellId> previous_cell,
                                                      std::span<const std::uint8_t> changed,
                                                      const Surface& surface) const;
  bool make_depth_again(ViewSlot slot);
  void count_again(ViewSlot slot);

  Atlas& atlas_;
  const Visibility* visibility_;
  PlannerOptions options_;
  Refiner refiner_;
  PlannedStore store_;
  VisibilityBuffer buffer_;
  std::vector<ViewSlot> old_depths_;  // slots whose view may have another depth on this surface, the oldest first
};

}  // namespace lumatlas
