// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the chunks of a surface that changes, as they are written: those that are as they were under the
// surface before are not made again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "atlas/fade_zones.h"
#include "atlas/grid_chunks.h"
#include "atlas/model/surface/written_mesh.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// A chunk's surface and mesh, the same under all surfaces that the chunk is in. Cells have the chunk's numbers: own
// ones first, then guests, cells of other chunks with which faces of this one fade.
struct LiveChunkForm {
  Surface surface;      // positions less `origin`
  WrittenSurface mesh;  // of it
  glm::dvec3 origin{0.0};
  std::vector<CornerOfCell> sources;  // for each vertex of `surface`, what it copies
  std::vector<std::uint32_t> guests;  // numbers in LiveChunk::around
};

struct LiveChunk {
  std::uint64_t cube = 0;      // see GridChunk
  std::uint64_t content = 0;   // hash_of_chunk()
  std::vector<CellId> cells;   // its own, ascending
  std::vector<CellId> around;  // cells that its form may name, ascending
  std::shared_ptr<const LiveChunkForm> form;
};

struct LiveChunkOptions {
  std::size_t least_faces = 0;  // A surface with fewer faces is not cut.
  double cells_across = 0;      // side of a chunk's cube, in cell sizes, > 0
  double width = 0;             // of the fade between cells, scene units
};

struct LiveChunks {
  LiveChunkOptions options;
  double cell_size = 0;  // of the surface, as the next
  glm::dvec3 offset{0.0};
  FacesOfCells faces;             // of the surface
  std::vector<LiveChunk> chunks;  // in the order of their cubes; none: the surface is not cut
};

// Returns the chunks of a surface, or none if it has few faces, a far sphere, many large cells, or more than 1024 of
// them. `shares_of` returns what share_cells() does with the options' width for a surface, or for a part of one.
// `former`: the chunks of a surface before, or null.
[[nodiscard]] LiveChunks live_chunks(const Surface& surface, const LiveChunkOptions& options,
                                     const std::function<CellShares(const Surface& surface)>& shares_of,
                                     const LiveChunks* former);

// Returns a chunk of the snapshot's surface with its colours and tables, as a model of its own, without views and
// without what a page does not use. `faces`: of the surface.
[[nodiscard]] Snapshot chunk_snapshot(const Snapshot& snapshot, const FacesOfCells& faces, const LiveChunk& chunk);

}  // namespace lumatlas
