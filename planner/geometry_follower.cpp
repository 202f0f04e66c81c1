// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/geometry_follower.h"

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace lumatlas {

namespace {

ChangedSphere sphere_of(const Cell& cell) {
  return {cell.centroid, cell.radius};
}

// Returns spheres around the places where the geometry has changed: around new and changed cells, as they are now and
// as they were, and around those that are gone.
std::vector<ChangedSphere> spheres_of_change(const Cells& before, const Cells& now,
                                             std::span<const CellId> previous_cell,
                                             std::span<const std::uint8_t> changed) {
  std::vector<std::uint8_t> kept(before.cells.size(), 0);
  std::vector<ChangedSphere> spheres;
  for (std::size_t cell = 0; cell < now.cells.size(); ++cell) {
    if (changed[cell] != 0) {
      spheres.push_back(sphere_of(now.cells[cell]));
    } else {
      kept[previous_cell[cell]] = 1;
    }
  }
  for (std::size_t cell = 0; cell < kept.size(); ++cell) {
    if (kept[cell] == 0) spheres.push_back(sphere_of(before.cells[cell]));
  }
  return spheres;
}

std::vector<CellId> cell_numbers(std::size_t cells) {
  std::vector<CellId> numbers(cells);
  for (CellId cell{0}; cell < cells; ++cell) numbers[cell] = cell;
  return numbers;
}

// The planes of a camera's viewing pyramid through its centre, normals inwards, in the camera frame.
std::array<glm::dvec3, 4> inward_normals(const Camera& camera) {
  const double left = -camera.cx / camera.fx, right = (camera.width - camera.cx) / camera.fx;
  const double top = -camera.cy / camera.fy, bottom = (camera.height - camera.cy) / camera.fy;
  return {glm::normalize(glm::dvec3(1, 0, -left)), glm::normalize(glm::dvec3(-1, 0, right)),
          glm::normalize(glm::dvec3(0, 1, -top)), glm::normalize(glm::dvec3(0, -1, bottom))};
}

// Returns whether a sphere may show in the image; true for each that does.
bool may_show(const Camera& camera, const std::array<glm::dvec3, 4>& normals, const ChangedSphere& sphere) {
  const glm::dvec3 center = camera.cam_from_world_rotation * sphere.center + camera.cam_from_world_translation;
  if (center.z < -sphere.radius) return false;
  return std::all_of(normals.begin(), normals.end(),
                     [&](const glm::dvec3& normal) { return glm::dot(normal, center) >= -sphere.radius; });
}

}  // namespace

// `now`: for each cell before its number now; CellId::none: it is changed or gone.
std::vector<ViewSlot> GeometryFollower::views_of_change(std::span<const ChangedSphere> spheres,
                                                        std::span<const CellId> now) const {
  std::vector<ViewSlot> slots;
  for (const ViewSlot slot : planner_.store_.held_slots()) {
    const Camera& camera = planner_.atlas_.view(slot)->camera;
    const std::array<glm::dvec3, 4> normals = inward_normals(camera);
    const std::span<const CellPart> seen = planner_.store_.ledger().parts(slot);
    // Cells were counted at the given pose, depth was made at a refined one: either may have changed.
    if (std::any_of(seen.begin(), seen.end(), [&](const CellPart& entry) { return now[entry.cell] == CellId::none; }) ||
        std::any_of(spheres.begin(), spheres.end(),
                    [&](const ChangedSphere& sphere) { return may_show(camera, normals, sphere); })) {
      slots.push_back(slot);
    }
  }
  return slots;
}

// Returns whether the view shows something else than before.
bool GeometryFollower::make_depth_again(ViewSlot slot) {
  const std::shared_ptr<const StoredView> old = planner_.atlas_.view(slot);
  VisibilityBuffer visible = planner_.visibility_->trace_sparsely(old->camera);
  const bool same_depth = old->mask->depth == visible.depth;
  if (same_depth && planner_.atlas_.layout().whole_views()) return false;
  TiledView tiled =
      make_tiled_view(old->name, old->camera, old->photograph, std::move(visible), planner_.atlas_.surface()->cells,
                      planner_.atlas_.layout(), planner_.options_.validity, old->mask->trust.all());
  planner_.atlas_.replace_mask(slot, std::move(tiled.view.mask), std::move(tiled.shown));
  planner_.refiner_.refresh(slot);
  return !same_depth;
}

void GeometryFollower::count_again(ViewSlot slot, CellPictures& pictures) {
  const Camera small = planner_.planning_camera(planner_.atlas_.view(slot)->camera);
  const std::vector<CellPixels> seen =
      pictures.count(slot, small, *planner_.visibility_, planner_.atlas_.surface()->cells);
  planner_.atlas_.mark_seen(seen);
  planner_.store_.count_again(slot, planner_.parts(small, seen));
}

bool GeometryFollower::renew_depth() {
  while (!planner_.old_depths_.empty()) {
    const ViewSlot slot = planner_.old_depths_.front();
    planner_.old_depths_.erase(planner_.old_depths_.begin());
    if (planner_.atlas_.view(slot) == nullptr) continue;  // has left the store since
    (void)make_depth_again(slot);
    return true;
  }
  return false;
}

SurfaceUpdate GeometryFollower::update_surface(std::shared_ptr<const Surface> surface, const Visibility& visibility,
                                               std::span<const CellId> previous_cell,
                                               std::span<const std::uint8_t> changed, DepthRenewal depths) {
  if (!surface) throw std::invalid_argument("planner: surface is null");
  if (planner_.store_.held_views() != planner_.atlas_.size())
    throw std::logic_error("planner: the surface changes while slots are promised");
  const std::size_t cells = surface->cells.cells.size();
  if (changed.size() != cells || previous_cell.size() != cells) {
    throw std::invalid_argument("planner: `changed` and `previous_cell` have " + std::to_string(changed.size()) +
                                " and " + std::to_string(previous_cell.size()) + " entries, must have " +
                                std::to_string(cells));
  }
  std::vector<CellId> unchanged(cells, CellId::none);
  const std::shared_ptr<const Surface> before = planner_.atlas_.surface();
  std::vector<CellId> cells_now(before->cells.cells.size(), CellId::none);  // by cell before, of those that stay
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (changed[cell] != 0) continue;
    if (previous_cell[cell] >= cells_now.size()) {
      throw std::invalid_argument("planner: unchanged cell " + std::to_string(cell) +
                                  " was no cell of the surface before");
    }
    if (cells_now[previous_cell[cell]] != CellId::none) {
      throw std::invalid_argument("planner: unchanged cell " + std::to_string(cell) + " was cell " +
                                  std::to_string(previous_cell[cell]) + ", as another cell was");
    }
    unchanged[cell] = previous_cell[cell];
    cells_now[previous_cell[cell]] = CellId(static_cast<std::uint32_t>(cell));
  }
  const std::vector<ChangedSphere> spheres = spheres_of_change(before->cells, surface->cells, previous_cell, changed);
  const std::vector<ViewSlot> again =
      planner_.counts_are_old_ ? planner_.store_.held_slots() : views_of_change(spheres, cells_now);
  planner_.atlas_.replace_surface(std::move(surface), previous_cell);
  // Until all views are counted, the planner has no pictures: they would be of another surface after an exception.
  CellPictures pictures = std::exchange(planner_.pictures_, {});
  const std::shared_ptr<const Surface> now = planner_.atlas_.surface();
  planner_.store_.follow(*now, again, unchanged);
  planner_.visibility_ = &visibility;
  planner_.refiner_.set_visibility(visibility);
  pictures.keep_only(planner_.store_.held_slots());
  pictures.follow(cells_now, spheres);
  SurfaceUpdate update;
  update.views_seen_again = static_cast<std::uint32_t>(again.size());
  for (const ViewSlot slot : again) {
    count_again(slot, pictures);
    if (depths == DepthRenewal::now) {
      update.depths_made_again += make_depth_again(slot);
    } else if (std::find(planner_.old_depths_.begin(), planner_.old_depths_.end(), slot) ==
               planner_.old_depths_.end()) {
      planner_.old_depths_.push_back(slot);
    }
  }
  planner_.pictures_ = std::move(pictures);
  planner_.store_.offer_again(again, changed);
  planner_.counts_are_old_ = false;
  return update;
}

// Applies to poses what refinement corrected of the former ones.
std::vector<ViewPose> GeometryFollower::refined_from(std::span<const ViewPose> poses) const {
  std::vector<ViewPose> refined;
  refined.reserve(poses.size());
  for (const ViewPose& pose : poses) {
    refined.push_back({pose.slot, planner_.refiner_.refined_from(pose.slot, pose.camera)});
  }
  return refined;
}

void GeometryFollower::tell_refiner(std::span<const ViewPose> given, std::span<const ViewPose> refined) {
  for (std::size_t i = 0; i < given.size(); ++i)
    planner_.refiner_.set_pose(given[i].slot, given[i].camera, refined[i].camera);
}

void GeometryFollower::move_scene(const std::shared_ptr<const Surface>& surface, const Visibility& visibility,
                                  std::span<const ViewPose> poses) {
  if (!surface) throw std::invalid_argument("planner: surface is null");
  planner_.store_.require_no_promise();
  const std::shared_ptr<const Surface> before = planner_.atlas_.surface();
  if (surface->cells.cell_of_face != before->cells.cell_of_face) {
    throw std::invalid_argument("planner: the surface that moves has other faces or cells than the one before");
  }
  const std::vector<ViewPose> refined = refined_from(poses);
  const std::vector<CellId> same = cell_numbers(surface->cells.cells.size());
  planner_.atlas_.replace_surface(surface, same, refined);
  tell_refiner(poses, refined);
  planner_.store_.follow(*surface, {}, same);
  planner_.visibility_ = &visibility;
  planner_.refiner_.set_visibility(visibility);
  planner_.pictures_ = {};
  planner_.old_depths_ = planner_.store_.held_slots();
  planner_.counts_are_old_ = true;
}

SurfaceUpdate GeometryFollower::move_views(std::span<const ViewPose> poses) {
  if (planner_.store_.held_views() != planner_.atlas_.size())
    throw std::logic_error("planner: views move while slots are promised");
  std::vector<ViewSlot> moved;
  moved.reserve(poses.size());
  for (const ViewPose& pose : poses) moved.push_back(pose.slot);
  const std::vector<ViewPose> refined = refined_from(poses);
  planner_.atlas_.set_poses(refined);
  tell_refiner(poses, refined);
  const std::shared_ptr<const Surface> surface = planner_.atlas_.surface();
  const std::size_t cells = surface->cells.cells.size();
  planner_.store_.follow(*surface, moved, cell_numbers(cells));
  SurfaceUpdate update;
  update.views_seen_again = static_cast<std::uint32_t>(moved.size());
  for (const ViewSlot slot : moved) {
    count_again(slot, planner_.pictures_);
    update.depths_made_again += make_depth_again(slot);
  }
  planner_.store_.offer_again(moved, std::vector<std::uint8_t>(cells, 0));
  return update;
}

}  // namespace lumatlas
