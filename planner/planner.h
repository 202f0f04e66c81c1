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

// Returns the photograph of the offered view. Called at most once, before offer() returns.
using PhotographSource = std::function<Photograph()>;

class Planner {
 public:
  // Writes to `atlas` alone. Both must outlive the planner, `visibility` only until GeometryFollower::update_surface()
  // replaces it. The atlas must be empty (std::invalid_argument).
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
  std::vector<ViewSlot> old_depths_;  // views whose depths GeometryFollower is to make again, the oldest first
};

}  // namespace lumatlas
