// SPDX-License-Identifier: GPL-3.0-or-later
// The state of a scene at one moment, as the renderer and a model file need it.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/colors/fallback_colors.h"
#include "atlas/earth_frame.h"
#include "atlas/reference_table.h"
#include "atlas/surface.h"
#include "atlas/tiles/tiles.h"
#include "atlas/views/stored_view.h"

namespace lumatlas {

// Every channel of a view's gain is in this range.
inline constexpr double kLeastExposureGain = 1e-6;
inline constexpr double kMostExposureGain = 1e6;

// Immutable once made. With tiles, a view is there only if at least one of its tiles is resident.
struct Snapshot {
  std::shared_ptr<const Surface> surface;
  std::vector<std::shared_ptr<const StoredView>> views;  // one per view slot; null: the view slot shows nothing
  // Exposure by view slot, per channel R G B: linear light of the photograph times this is the model's. 1 where no view
  // is.
  std::vector<glm::dvec3> gains;
  ReferenceTable references;            // to view slots that hold a view
  std::vector<std::uint8_t> cell_seen;  // one per cell, 1: some offered view saw it, kept or not
  // One per vertex: shown where no view is valid. Those of a store are made when they are asked for. Until then they
  // keep alive all views that the store held, also those that the snapshot leaves out.
  FallbackColors vertex_colors;
  TileTable tiles;  // which parts of the views are resident
  // The coverage of each cell by the stored views, by the measure that chose them, >= 0. Not used for drawing. Empty in
  // every snapshot that an atlas makes.
  std::vector<float> cell_coverage;
  // Standard deviation of each cell's surface along a ray, scene units, >= 0: see
  // planner/refinement/surface_deviation.h. The renderer blurs photographs by it in pictures from other directions.
  // Empty: it takes the surface as exact.
  std::vector<float> cell_deviation;
  // Where the coordinates before the surface's offset is subtracted lie on the Earth. Not used for drawing. None: not
  // known, as in every snapshot that an atlas makes.
  std::optional<GeoReference> georeference;
};

// Throws std::invalid_argument naming the table, the index, its value and the rule that it breaks, unless surface and
// views pass their own check() and all tables are as described above. Looks at each face and each reference once.
void check(const Snapshot& snapshot);

// Does what check() does, except for the surface, each of whose faces check() looks at. Call it for a surface that has
// passed before.
void check_but_surface(const Snapshot& snapshot);

// Does the part of check() that concerns gains.
void check_gains(const Snapshot& snapshot);

// Returns the median of the deviations above 0 (Snapshot::cell_deviation), the upper one of two; 0 if there is none.
[[nodiscard]] float median_deviation(const std::vector<float>& cell_deviation);

// Returns the snapshot without the far sphere of its surface.
[[nodiscard]] Snapshot without_far_sphere(const Snapshot& snapshot);

// With tiles, removes the views that have no resident tile, and the references to them. They are not shown, so neither
// memory nor a file need hold their photographs. Slots keep their numbers.
void leave_out_views_without_tiles(Snapshot& snapshot);

}  // namespace lumatlas
