// SPDX-License-Identifier: GPL-3.0-or-later
// Lets a planner's store follow a mesh and poses that change while the stream runs (Erat et al. 2019, section 5).
//
//   GeometryFollower follower(planner);
//   follower.update_surface(grown_surface, *visibility, growth.previous_cell, growth.changed, DepthRenewal::later);
//   while (follower.renew_depth()) offer_what_has_come();
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/cell_pictures.h"
#include "planner/planner.h"

namespace lumatlas {

// The work that a change of the geometry made necessary.
struct SurfaceUpdate {
  std::uint32_t views_seen_again = 0;   // views whose cells were counted again
  std::uint32_t depths_made_again = 0;  // those among them whose depth is now another
};

// When update_surface() makes depths again: at once, or view by view, by GeometryFollower::renew_depth(). A stream uses
// the latter: more urgent work can come between two views, and a view that two surfaces change is renewed once.
enum class DepthRenewal { now, later };

// Keeps nothing of its own: any number of followers of one planner do the same.
class GeometryFollower {
 public:
  // The planner must outlive it.
  explicit GeometryFollower(Planner& planner) : planner_(planner) {}

  // The mesh has changed. `visibility` sees the new one and must outlive the planner, or the next call. `previous_cell`
  // and `changed` say what became of the cells, as CellGrowth does: by cell of the new surface, which one it was, and
  // whether it is as it was. No view slot may be promised (std::logic_error).
  //
  // Views that can see a cell that is new, changed or gone are counted again, at the poses that they are stored with,
  // and their depths and masks are made again; other views stay as they are. References are then those of the new
  // cells. A cell that is new or changed counts the stored views alone as offered. With DepthRenewal::later the views
  // keep the depths and masks of the surface before until renew_depth() makes them again. Throws std::invalid_argument,
  // and changes nothing, if the surface does not fit: see Atlas::replace_surface().
  SurfaceUpdate update_surface(std::shared_ptr<const Surface> surface, const Visibility& visibility,
                               std::span<const CellId> previous_cell, std::span<const std::uint8_t> changed,
                               DepthRenewal depths = DepthRenewal::now);
  // Makes the depth and mask of one view again that update_surface() left for later, the one that has waited longest.
  // Returns false if there was none.
  bool renew_depth();
  // Returns whether renew_depth() may have a view to do.
  [[nodiscard]] bool has_old_depths() const { return !planner_.old_depths_.empty(); }
  // The caller has found other poses for stored views, as a SLAM system does when it closes a loop. `poses` has the
  // poses that the views would be offered with now; what refinement corrected of the former ones is applied to these
  // too. A snapshot has all the new poses or none. Then the cells that the views see are counted again and their depths
  // and masks are made again, view by view, and at the end all references follow at once. No view slot may be promised
  // (std::logic_error). Throws what Atlas::set_poses() throws, and changes nothing then.
  SurfaceUpdate move_views(std::span<const ViewPose> poses);
  // The caller has moved views as above, and the surface with them: `surface` has the cells of the one before, with
  // vertices at other places. A snapshot has all of it or nothing. References, coverage, depths and masks move with the
  // views. Then renew_depth() makes the depths and masks of all views again, and the next update_surface() counts the
  // cells of all views again, because some may have moved as the surface before them has not. Takes the time of
  // Atlas::replace_surface(). No view slot may be promised (std::logic_error). Throws std::invalid_argument, and
  // changes nothing, if a face is of another cell than before, and what Atlas::replace_surface() throws. `visibility`
  // is as for update_surface().
  void move_scene(const std::shared_ptr<const Surface>& surface, const Visibility& visibility,
                  std::span<const ViewPose> poses);

 private:
  [[nodiscard]] std::vector<ViewSlot> views_of_change(std::span<const ChangedSphere> spheres,
                                                      std::span<const CellId> now) const;
  [[nodiscard]] std::vector<ViewPose> refined_from(std::span<const ViewPose> poses) const;
  void tell_refiner(std::span<const ViewPose> given, std::span<const ViewPose> refined);
  bool make_depth_again(ViewSlot slot);
  void count_again(ViewSlot slot, CellPictures& pictures);

  Planner& planner_;
};

}  // namespace lumatlas
