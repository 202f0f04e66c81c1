// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: mesh and references as the shaders read them, by zones. A zone here is what all its faces have in
// common: the cells that share them, and the cell that they are of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "atlas/grid_chunks.h"
#include "atlas/reference_table.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/mesh.h"

namespace lumatlas {

// The shader is compiled for zones of at most this many cells each, because one for fewer cells is shorter.
inline constexpr std::array<std::uint32_t, 3> kCellsOfShader{1, 2, 4};

// All that references are listed by.
struct ZoneCells {
  std::vector<std::uint32_t> cell;         // one per zone: the cell of its faces
  std::vector<std::uint32_t> combination;  // one per zone: the combination of cells that its faces fade between
  std::vector<CellShares::Zone> combinations;
};

// A mesh with a vertex for each zone that it is a corner of, because its shares are in the order of the zone's cells,
// and because a flat attribute tells the shader which zone a face has.
struct ZoneMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::u8vec3> colors;
  std::vector<glm::u16vec4> shares;  // 65535 is 1
  std::vector<std::uint32_t> zones;  // one per vertex
  // Sorted by how many cells they have (kCellsOfShader), then so that faces near each other here are so in space.
  std::vector<glm::uvec3> faces;
  std::array<std::size_t, kCellsOfShader.size()> face_counts{};
};

// The mesh of the faces of some cells. Zones and combinations are those of these cells alone; they name cells of the
// surface.
struct ChunkMesh {
  std::vector<glm::vec3> positions;
  std::vector<CornerOfCell> sources;  // for each vertex, what it copies
  std::vector<glm::u16vec4> shares;
  std::vector<std::uint32_t> zones;
  std::array<std::vector<glm::uvec3>, kCellsOfShader.size()> faces;
  ZoneCells zone_cells;
};

// `faces` are of all cells of the mesh, `shares` has one for each face.
[[nodiscard]] ChunkMesh chunk_mesh(const Mesh& mesh, const FacesOfCells& faces, std::span<const CellId> cells,
                                   const CellShares& shares);

// The tables that shaders/tables.glsl reads.
struct ZoneReferences {
  std::vector<glm::uvec4> zones;          // references from and to, the faces' cell, deviation_bits() of that
  std::vector<glm::uvec4> cells;          // references from and to, 1 if an offered view saw it, 0
  std::vector<std::uint32_t> references;  // view slot; from bit 28 on, which of the zone's cells refer to it
  std::vector<glm::uvec2> ranges;         // of each combination of cells, its references, from and to; none overlap
};

// Returns the view slot of an entry of ZoneReferences::references.
[[nodiscard]] constexpr std::uint32_t slot_of(std::uint32_t reference) {
  return reference & 0x0FFFFFFFu;
}

// A deviation (Snapshot::cell_deviation) as shaders read it: the upper half of its bits. It loses 1 in 128 at most.
[[nodiscard]] std::uint32_t deviation_bits(float deviation);

// Views that several cells of a zone refer to are listed once for it. `cell_seen` and `cell_deviation` as in Snapshot.
// Throws GlError for more than 2^28 view slots.
[[nodiscard]] ZoneReferences zone_references(const ZoneCells& zones, const ReferenceTable& references,
                                             const std::vector<std::uint8_t>& cell_seen,
                                             const std::vector<float>& cell_deviation);

}  // namespace lumatlas
