// SPDX-License-Identifier: GPL-3.0-or-later
// The view store that the planner writes and the renderer reads (Erat et al. 2019, Fig. 2): photographs with their
// depth and validity, and per cell the references to them.
//
// The planner and the renderer run at their own rates: the planner changes the atlas view by view, the renderer draws
// from a snapshot, which never changes and keeps alive what it shows.
//
// The life of a store:
//   1. The constructor takes a surface and the largest number of views.
//   2. insert() stores a view.
//   3. mark_seen() notes the cells that the view sees; set_references() says which views each cell is drawn from.
//   4. snapshot() returns what the renderer draws.
//   5. set_poses() moves views, replace_mask() and replace() change them, erase() frees a view slot.
//   6. replace_surface() takes a surface that has grown or been refined.
//   7. retile() cuts views into other tiles, or into none.
// 2 to 7 come in any order, as often as needed; a Planner does 2, 3 and 5. commit() makes several such changes at once.
//
//   Atlas atlas(surface, 100);
//   VisibilityBuffer visible = make_ray_visibility(surface->mesh)->trace(camera);
//   const std::vector<CellPixels> seen = count_cell_pixels(visible, surface->cells);
//   const ViewSlot slot = atlas.insert(make_stored_view("a.jpg", camera, photograph, std::move(visible), {}));
//   atlas.mark_seen(seen);
//   for (const CellPixels& part : seen) atlas.set_references(part.cell, {slot});
//   const Snapshot drawn = atlas.snapshot();
//   atlas.set_poses(std::vector{ViewPose{slot, corrected}});  // `drawn` keeps the pose before
//   for (const CellPixels& part : seen) atlas.set_references(part.cell, {});
//   atlas.erase(slot);
//
// Each method says after "Time:" what it grows with; a call without that takes the same time for any store.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/atlas_edit.h"
#include "atlas/snapshot.h"
#include "atlas/surface.h"
#include "atlas/tiles/tile_policy.h"
#include "atlas/tiles/tiles.h"
#include "atlas/views/stored_view.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

class SnapshotMaker;
struct StoreChanges;

// The pose that the view in a view slot has from now on, and its lens, if that has changed too.
struct ViewPose {
  ViewSlot slot;
  Camera camera;  // its image is as large as before
};

// A store of at most `max_views` views. Every call is safe from any thread, unless it says otherwise. While one thread
// takes a snapshot, other threads wait only if they take one too, or call retile() or set_tile_limit(). What a caller
// hands in is checked before anything is changed: where a call throws, the store is as it was.
class Atlas {
 public:
  // `policy` chooses tiles where the layout's max_tiles are fewer than the references need. Throws
  // std::invalid_argument unless there is a surface that passes check(), max_views >= 1 and the layout passes check().
  // Time: faces of the surface, and view slots.
  Atlas(std::shared_ptr<const Surface> surface, std::uint32_t max_views, const TileOptions& layout = kWholeViews,
        TilePolicy policy = {});
  ~Atlas();

  // Never null. It stays as it is when another thread replaces it.
  [[nodiscard]] std::shared_ptr<const Surface> surface() const;
  [[nodiscard]] std::uint32_t capacity() const { return static_cast<std::uint32_t>(views_.size()); }
  [[nodiscard]] std::uint32_t size() const;  // views stored; time: view slots

  [[nodiscard]] const TileOptions& layout() const { return layout_; }

  // Puts a view in the lowest free view slot, with a gain of 1, and returns the slot. `shown` has the cells of the
  // surface that each of its tiles shows; tiles without any are never resident. Throws std::logic_error if there is no
  // slot, std::invalid_argument unless the view passes check(), `shown` passes require_shown_cells_of() and names cells
  // that the surface has now, which another thread may have replaced since `shown` was made. Time: entries of `shown`,
  // and view slots.
  ViewSlot insert(StoredView view, std::vector<ShownCell> shown = {});
  // Puts a view in a view slot of the caller's choice, which must be free (std::logic_error) and below capacity()
  // (std::invalid_argument). Time: entries of `shown`.
  void insert_at(ViewSlot slot, StoredView view, std::vector<ShownCell> shown = {});
  // Puts a view in the place of the one in a view slot, which must hold one (std::logic_error): the same photograph
  // with another pose or mask. References to the slot and its gain stay; snapshots taken before keep the old view. What
  // is handed in is checked as by insert(). Time: entries of `shown`.
  void replace(ViewSlot slot, StoredView view, std::vector<ShownCell> shown = {});
  // Moves views, all at once: a snapshot has all the new poses or none. Each keeps its photograph, its mask, what its
  // tiles show, its references and its gain; snapshots taken before keep the old poses. Time: poses, whatever the
  // size of their photographs. Throws std::logic_error unless each view slot holds a view; std::invalid_argument unless
  // each comes once and each camera passes check() and has an image of the view's size.
  void set_poses(std::span<const ViewPose> poses);
  // Gives the view in a view slot, which must hold one (std::logic_error), another mask, and the cells that its tiles
  // show with it. All else stays, the photograph and the pose among it. Throws std::invalid_argument unless the mask is
  // one, as large as the view's image, and `shown` is as for insert(). Time: entries of `shown`.
  void replace_mask(ViewSlot slot, std::shared_ptr<const ViewMask> mask, std::vector<ShownCell> shown = {});
  // Frees a view slot, which must hold a view that no cell refers to any more (std::logic_error).
  void erase(ViewSlot slot);
  // Returns the view, or null if the view slot is free. Throws std::invalid_argument unless slot < capacity().
  [[nodiscard]] std::shared_ptr<const StoredView> view(ViewSlot slot) const;
  // Returns which cells the view's tiles show; never null, empty if the view slot is free. Throws as view() does.
  [[nodiscard]] SharedShownCells shown(ViewSlot slot) const;

  // The exposure of the view in a view slot, which must hold one (std::logic_error), see Snapshot::gains. Throws
  // std::invalid_argument unless each channel is within [kLeastExposureGain, kMostExposureGain].
  void set_gain(ViewSlot slot, const glm::dvec3& gain);
  [[nodiscard]] glm::dvec3 gain(ViewSlot slot) const;

  // Replaces the references of one cell. Every view slot must hold a view (std::logic_error). Throws
  // std::invalid_argument unless the surface has the cell and no slot comes twice. Time: the square of the number of
  // slots, which is 16 at most where the planner calls.
  void set_references(CellId cell, std::vector<ViewSlot> slots);
  // Throws std::invalid_argument unless the surface has the cell. Time: the cell's references.
  [[nodiscard]] std::vector<ViewSlot> references(CellId cell) const;
  // Notes that an offered view saw these cells. Throws std::invalid_argument unless the surface has them all. Time:
  // the given cells.
  void mark_seen(std::span<const CellPixels> cells);

  // Makes all changes of an edit, in its order, or none: where one of them throws what the call of the same name does,
  // the store is as it was. A snapshot has all of them or none. Time: the sum of the changes' times.
  void commit(AtlasEdit edit);

  // Replaces the surface under the stored views. `previous_cell` has for each new cell the number of the cell that it
  // was before, or CellId::none: see CellGrowth. A cell inherits the references of that cell, and whether it was seen.
  // A new cell has no references and is unseen. Cells that no new cell names are dropped; several may name one. Views
  // and gains stay as they are: their depth and validity are those of the old surface until replace() replaces each
  // view.
  // Snapshots taken before keep the old surface. Other threads may change views meanwhile, as often as they like. At
  // the end they wait until the views that changed last are renumbered. Throws std::invalid_argument, unless the
  // surface passes check() and has the same offset as the one before, on which the views' cameras depend, and
  // `previous_cell` has one entry per cell, each a cell that was there or CellId::none. `poses` move views in the same
  // change, so that a snapshot has both or neither: see set_poses(), which says what it throws. Time: faces of the
  // surface, cells that the tiles of all stored views show, and poses.
  void replace_surface(std::shared_ptr<const Surface> surface, std::span<const CellId> previous_cell,
                       std::span<const ViewPose> poses = {});

  // Returns the store as it is now. Vertex colours are those of VertexColorMean; they are made when the caller asks for
  // them. Time: view slots, cells and their references, because tables by view slot and by cell are copied; cells shown
  // by the tiles of views that are new or that other cells refer to since the last snapshot; nothing for each vertex,
  // face or pixel. All of it is spent outside the lock that the other calls take. Colours take the time of what has
  // changed since the snapshot whose colours were asked for last, which may be a later one.
  //
  // Tiles that were resident in the snapshot before, and still are, keep their tile places. Where the references need
  // more tiles than the layout has, the policy chooses among them, and the snapshot's references are to those. A view
  // without a resident tile is left out. Throws std::logic_error if there is no policy, if it made a choice that it
  // must not make, or if the policy itself asks for a snapshot, which would wait for itself.
  [[nodiscard]] Snapshot snapshot() const;
  // Lets the policy choose the next snapshot's tiles from all, as for the first one, instead of going on from those
  // that are resident. The next snapshot then takes longer and its tiles serve better: call it when the stream of views
  // rests.
  void choose_tiles_anew();
  // Bounds the tiles of the following snapshots, and lets the policy choose them anew. 0: as many as the references
  // need. No other thread may ask for the layout meanwhile.
  void set_tile_limit(std::uint32_t max_tiles);
  // Sets another layout for the following snapshots. `shown` has what each view slot's tiles show in it; empty for free
  // slots. Views, references and gains stay; tiles are chosen anew. Waits for a snapshot that another thread takes.
  // Returns what the tiles showed before: a call with that and the former layout undoes this one. Throws
  // std::invalid_argument, and changes nothing, unless the layout passes check() and there is for each slot, never
  // null, what insert() would take. No other thread may insert or replace views, or ask for the layout, meanwhile.
  // Time: entries of `shown`.
  std::vector<SharedShownCells> retile(const TileOptions& layout, std::vector<SharedShownCells> shown);

 private:
  void require_slot(ViewSlot slot) const;
  void require_stored(ViewSlot slot) const;
  struct Entry {
    std::shared_ptr<const StoredView> view;
    SharedShownCells shown;
  };
  static void check_change(const AtlasEdit::Change& change, const TileOptions& layout);
  void apply(AtlasEdit::ViewChange& change);
  void apply(AtlasEdit::GainChange& change);
  void apply(AtlasEdit::ReferencesChange& change);
  void apply(AtlasEdit::SeenChange& change);
  void take_back(AtlasEdit::ViewChange& change) noexcept;
  void take_back(AtlasEdit::GainChange& change) noexcept;
  void take_back(AtlasEdit::ReferencesChange& change) noexcept;
  void take_back(AtlasEdit::SeenChange& change) noexcept;
  [[nodiscard]] Entry entry_of(StoredView view, std::vector<ShownCell> shown) const;
  void put(ViewSlot slot, Entry entry);
  [[nodiscard]] std::vector<std::shared_ptr<const StoredView>> stored_at(std::span<const ViewPose> poses) const;
  void keep_up(std::span<const ViewPose> poses, std::span<const std::shared_ptr<const StoredView>> before,
               std::vector<std::shared_ptr<const StoredView>>& after) const;
  void swap_views(std::span<const ViewPose> poses, std::vector<std::shared_ptr<const StoredView>>& after) noexcept;
  void require_cell(CellId cell) const;
  void require_cells_of(const std::string& view, std::span<const ShownCell> shown) const;
  [[nodiscard]] std::pair<std::size_t, std::vector<SharedShownCells>> shown_of_cells() const;
  struct ByCell;
  [[nodiscard]] ByCell by_cell(std::span<const CellId> previous_cell) const;
  [[nodiscard]] std::unique_lock<std::mutex> one_snapshot_at_a_time() const;
  void mark_changed(CellId cell);
  void mark_all_changed() const;
  [[nodiscard]] StoreChanges take_changes() const;

  TileOptions layout_;
  TilePolicy policy_;

  mutable std::mutex mutex_;  // guards all members below, except the maker
  std::shared_ptr<const Surface> surface_;
  std::vector<std::shared_ptr<const StoredView>> views_;
  std::vector<SharedShownCells> shown_;  // one per view slot, never null
  std::vector<glm::dvec3> gains_;
  std::vector<std::uint64_t> tenants_;             // one per view slot: how many views had been inserted before its own
  std::uint64_t inserted_ = 0;                     // views, ever
  std::vector<std::uint32_t> references_to_slot_;  // how many cells refer to each view slot
  std::vector<std::shared_ptr<const std::vector<ViewSlot>>> references_;  // one per cell, never null
  std::vector<std::uint8_t> cell_seen_;

  // The changes since the last snapshot was made.
  mutable bool all_changed_ = true;
  mutable std::vector<CellId> changed_cells_;       // each once
  mutable std::vector<std::uint8_t> cell_changed_;  // one per cell: 1 if it has changed
  mutable std::vector<CellId> newly_seen_;          // cells
  mutable bool choose_tiles_anew_ = false;

  mutable std::mutex snapshot_mutex_;                     // guards the maker; locked before the other
  mutable std::atomic<std::thread::id> snapshot_thread_;  // the one that is in snapshot(); none: a default id
  mutable std::unique_ptr<SnapshotMaker> maker_;
};

}  // namespace lumatlas
