// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: what a renderer takes from a snapshot beside its photographs, and makes of it without OpenGL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/exposure.h"
#include "blend/tables/drawn_zones.h"
#include "blend/tables/zone_mesh.h"

namespace lumatlas {

// The parts of a snapshot from which mesh and references are made, for another width too.
struct SnapshotTables {
  std::shared_ptr<const Surface> surface;
  FallbackColors vertex_colors;
  ReferenceTable references;
  std::vector<std::uint8_t> cell_seen;
  std::vector<float> cell_deviation;
  // The cells that may be joined change with every view, and with them the mesh. So once a store or its surface has
  // changed, no cells are joined any more.
  bool changes = false;
  double near_depth = 0;           // of the nearest surface drawn
  double before_far = 0;           // depth_before_far() of the surface, as large as a float can be without a far sphere
  double most_edge_deviation = 0;  // scene units, see soft_edges.h; 0: no edge is soft
  std::uint32_t cubic_levels = 0;  // finest levels that are sampled cubically
  NearbyExposure nearby_exposure;
  std::vector<std::optional<glm::dvec3>> stored_centers;  // of the views' cameras, by slot
};

// What is the same in two snapshots.
struct SameTables {
  bool surface, references, deviation;
};

// Passes the snapshot to check(), and looks at the surface only if `former` has another. `former` is what an earlier
// snapshot gave, or null.
void check_after(const SnapshotTables* former, const Snapshot& snapshot);

[[nodiscard]] SameTables same_tables(const SnapshotTables* former, const Snapshot& snapshot);

// Returns the tables of a snapshot that passes check().
[[nodiscard]] std::shared_ptr<const SnapshotTables> tables_after(const SnapshotTables* former,
                                                                 const Snapshot& snapshot);

// Returns whether a mesh, which may be null, is that of the next snapshot too.
[[nodiscard]] bool stays(const DrawnZones* zones, const SameTables& same);

// Returns the mesh for a width as in BlendOptions. `former`: the mesh of a former snapshot, or null.
[[nodiscard]] MadeZones make_zones(const SnapshotTables& tables, double border_width, bool join_cells,
                                   const DrawnZones* former);

[[nodiscard]] std::shared_ptr<const ZoneReferences> lists_of(const SnapshotTables& tables, const DrawnZones& zones);

}  // namespace lumatlas
