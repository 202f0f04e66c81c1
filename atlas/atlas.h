// SPDX-License-Identifier: GPL-3.0-or-later
// The view store that the planner writes and the renderer reads (Erat et al. 2019, Fig. 2): photographs with their
// depth and validity, and per cell the references to them.
//
// The planner and the renderer run at their own rates: the planner changes the atlas view by view, the renderer draws
// from a snapshot, which never changes and keeps alive what it shows.
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/photograph.h"
#include "atlas/tiles.h"
#include "atlas/validity.h"
#include "mesh/camera.h"
#include "mesh/cells.h"
#include "mesh/mesh.h"
#include "mesh/visibility.h"

namespace lumatlas {

// The geometry that a store belongs to.
struct Surface {
  Mesh mesh;
  Cells cells;
  glm::dvec3 offset{0.0};  // what was subtracted from the input's coordinates
};

// f = (c, e, z) of section 3.1. Its exposure gain is the store's, for gains are found for all views together and change
// while the views stay.
struct StoredView {
  std::string name;
  Camera camera;
  Photograph photograph;
  std::vector<float> depth;            // z at the photograph's resolution, infinity where no surface is
  std::vector<std::uint8_t> trust;     // 255 trusted, 0 contradicted by the other views; empty: all trusted
  std::vector<std::uint8_t> validity;  // see validity_mask()
  std::vector<std::uint8_t> rim;       // see rim_pixels(); empty: none

  [[nodiscard]] bool at_rim(std::size_t pixel) const { return !rim.empty() && rim[pixel] != 0; }
};

// Throws std::invalid_argument, naming the view, unless the photograph is as large as its camera says.
void require_photograph_of(const std::string& view, const Camera& camera, const Photograph& photograph);

// Completes a view with its depth and its mask. Throws std::invalid_argument if photograph and camera differ in size,
// or if `trust`, as in StoredView, is neither empty nor of one value per pixel. `visible` is what the camera sees at
// its own resolution.
[[nodiscard]] StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph,
                                          VisibilityBuffer visible, const ValidityOptions& options,
                                          std::vector<std::uint8_t> trust = {});

// The same, and which cells each of its tiles shows.
struct TiledView {
  StoredView view;
  std::vector<ShownCell> shown;
};
[[nodiscard]] TiledView make_tiled_view(std::string name, const Camera& camera, Photograph photograph,
                                        VisibilityBuffer visible, const Cells& cells, const TileOptions& layout,
                                        const ValidityOptions& options, std::vector<std::uint8_t> trust = {});

// Every channel of a view's gain is in this range.
inline constexpr double kLeastExposureGain = 1e-6;
inline constexpr double kMostExposureGain = 1e6;

// Which slots of the store each cell refers to: of cell k, views[offsets[k]] up to views[offsets[k + 1]].
struct ReferenceTable {
  std::vector<std::uint32_t> offsets{0};  // one more than there are cells
  std::vector<std::uint32_t> views;       // slots

  [[nodiscard]] std::span<const std::uint32_t> of_cell(std::size_t cell) const {
    return std::span(views).subspan(offsets[cell], offsets[cell + 1] - offsets[cell]);
  }
};

// What the renderer needs to know of a scene at one moment. Immutable once made.
struct Snapshot {
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;  // by slot; null: the slot is free
  // Exposure by slot, per channel R G B: linear light of the photograph times this is the model's. 1: the slot is free.
  std::vector<glm::dvec3> gains;
  ReferenceTable references;
  std::vector<std::uint8_t> cell_seen;     // 1: some offered view saw the cell, kept or not
  std::vector<glm::u8vec3> vertex_colors;  // sRGB, one per vertex: shown where no view is valid
  TileTable tiles;                         // which parts of the views are resident
  // How well the stored views cover each cell by the measure that they were chosen by, >= 0; not for drawing. Empty:
  // nobody has said, as in every snapshot that an atlas gives.
  std::vector<float> cell_coverage;
};

// A store of at most `max_views` views. Every call is safe from any thread.
class Atlas {
 public:
  // Throws std::invalid_argument unless max_views >= 1 and the layout passes check().
  Atlas(std::shared_ptr<const Surface> surface, std::uint32_t max_views, const TileOptions& layout = kWholeViews);

  // Good until the next replace_surface(): for the thread that calls that one, and for those that it waits for. Any
  // other looks at a snapshot's.
  [[nodiscard]] const Surface& surface() const;
  [[nodiscard]] std::uint32_t capacity() const { return static_cast<std::uint32_t>(views_.size()); }
  [[nodiscard]] std::uint32_t size() const;  // views stored

  [[nodiscard]] const TileOptions& layout() const { return layout_; }

  // Puts a view in the lowest free slot, with a gain of 1, and returns the slot. `shown` has the cells of the surface
  // that each of its tiles shows; tiles without any are never resident. Throws std::logic_error if there is no slot.
  std::uint32_t insert(StoredView view, std::vector<ShownCell> shown = {});
  // Puts a view in the place of the one in a slot, which must hold one (std::logic_error): the same photograph with
  // another pose or mask. References to the slot and its gain stay; snapshots taken before keep the old view.
  void replace(std::uint32_t slot, StoredView view, std::vector<ShownCell> shown = {});
  // Frees a slot. References to it must have been replaced before (std::logic_error).
  void erase(std::uint32_t slot);
  [[nodiscard]] std::shared_ptr<const StoredView> view(std::uint32_t slot) const;  // null: free

  // The exposure of the view in a slot, which must hold one (std::logic_error), see Snapshot::gains. Throws
  // std::invalid_argument unless each channel is within [kLeastExposureGain, kMostExposureGain].
  void set_gain(std::uint32_t slot, const glm::dvec3& gain);
  [[nodiscard]] glm::dvec3 gain(std::uint32_t slot) const;

  // Replaces the references of one cell; every slot must hold a view (std::logic_error).
  void set_references(std::uint32_t cell, std::vector<std::uint32_t> slots);
  [[nodiscard]] std::vector<std::uint32_t> references(std::uint32_t cell) const;
  void mark_seen(std::span<const CellPixels> cells);

  // Puts another surface under the stored views. `previous_cell` says for each of its cells which one it was, or
  // kNoCell: see CellGrowth. A cell takes the references of the one that it was, and whether it was seen; a new one has
  // none and is unseen; what no cell of the new surface was, is dropped. Several cells may have been one. Views and
  // gains stay as they are: their depth and validity are those of the old surface until each is replaced by replace().
  // Snapshots taken before keep the old surface. Throws std::invalid_argument, and changes nothing, if `previous_cell`
  // has not one entry per cell, names a cell that is not there, or if the surfaces differ in offset, on which the
  // views' cameras depend.
  void replace_surface(std::shared_ptr<const Surface> surface, std::span<const std::uint32_t> previous_cell);

  // Vertex colours are the mean of the stored views' colours (see vertex_colors.h), which costs a pass over them all.
  // Tiles that were resident in the snapshot before, and still are, keep their slots. If the tiles that the references
  // need are more than the layout has, those are resident that serve the stored cameras best, and the snapshot's
  // references are to them: see tile_choice.h.
  [[nodiscard]] Snapshot snapshot() const;

 private:
  void require_stored(std::uint32_t slot) const;
  void assign_tiles(Snapshot& snapshot) const;

  mutable std::mutex mutex_;
  std::shared_ptr<const Surface> surface_;
  TileOptions layout_;
  std::vector<std::shared_ptr<const StoredView>> views_;
  std::vector<glm::dvec3> gains_;
  std::vector<std::uint32_t> references_to_slot_;  // how many cells refer to each slot
  std::vector<std::vector<std::uint32_t>> references_;
  std::vector<std::uint8_t> cell_seen_;
  std::vector<std::vector<ShownCell>> shown_;    // by slot
  mutable std::optional<TileSlots> tile_slots_;  // of the last snapshot; none: whole views
};

}  // namespace lumatlas
