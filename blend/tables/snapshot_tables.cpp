// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/snapshot_tables.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <limits>
#include <utility>

#include "blend/sampling/cubic_kernel.h"
#include "blend/soft_edges.h"
#include "blend/tables/fade_zone_shares.h"

namespace lumatlas {

namespace {

// The nearest surface drawn, as a share of the mesh's box, which stray faces may make far larger than the scene. Depth
// is reversed and a float, so its relative precision is the same however small this is.
constexpr double kNearShare = 1e-8;

}  // namespace

void check_after(const SnapshotTables* former, const Snapshot& snapshot) {
  if (former != nullptr && snapshot.surface && former->surface == snapshot.surface) {
    check_but_surface(snapshot);
  } else {
    check(snapshot);
  }
}

SameTables same_tables(const SnapshotTables* former, const Snapshot& snapshot) {
  const bool surface = former != nullptr && former->surface == snapshot.surface;
  return {surface,
          surface && former->references.offsets == snapshot.references.offsets &&
              former->references.views == snapshot.references.views && former->cell_seen == snapshot.cell_seen,
          surface && former->cell_deviation == snapshot.cell_deviation};
}

std::shared_ptr<const SnapshotTables> tables_after(const SnapshotTables* former, const Snapshot& snapshot) {
  const SameTables same = same_tables(former, snapshot);
  auto tables = std::make_shared<SnapshotTables>();
  tables->surface = snapshot.surface;
  tables->vertex_colors = snapshot.vertex_colors;  // they are made when they are drawn
  tables->references = snapshot.references;
  tables->cell_seen = snapshot.cell_seen;
  tables->cell_deviation = snapshot.cell_deviation;
  tables->changes = former != nullptr && (former->changes || !same.surface || !same.references);
  if (same.surface) {
    tables->near_depth = former->near_depth;
    tables->before_far = former->before_far;
  } else {
    const Bounds box = bounds(near_surface(*snapshot.surface).mesh);
    tables->near_depth = kNearShare * glm::length(box.max - box.min);
    tables->before_far =
        static_cast<double>(std::min(depth_before_far(*snapshot.surface), std::numeric_limits<float>::max()));
  }
  tables->most_edge_deviation = kMostOfMedian * static_cast<double>(median_deviation(snapshot.cell_deviation));
  tables->cubic_levels = cubic_levels(snapshot.tiles.options);
  if (former != nullptr) tables->nearby_exposure = former->nearby_exposure;
  tables->nearby_exposure.follow(snapshot);
  tables->stored_centers.resize(snapshot.views.size());
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) tables->stored_centers[slot] = snapshot.views[slot]->camera.center();
  }
  return tables;
}

bool stays(const DrawnZones* zones, const SameTables& same) {
  return zones != nullptr && same.surface && (same.references || !zones->is_joined);
}

MadeZones make_zones(const SnapshotTables& tables, double border_width, bool join_cells, const DrawnZones* former) {
  ZoneOptions options;
  options.border_width = border_width;
  options.will_change = tables.changes;
  if (join_cells && border_width > 0 && !tables.changes) {
    options.stands_for = first_of_same_references(tables.references);
  }
  return make_zones(tables.surface, options, former);
}

std::shared_ptr<const ZoneReferences> lists_of(const SnapshotTables& tables, const DrawnZones& zones) {
  return std::make_shared<const ZoneReferences>(
      zone_references(zones.cells, tables.references, tables.cell_seen, tables.cell_deviation));
}

}  // namespace lumatlas
