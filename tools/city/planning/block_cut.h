// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: cuts a surface in chunks into blocks, and finds what the job of each block needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"

namespace lumatlas {

// Chunks of a surface are smaller than blocks, so that a job need not read all of its neighbours.
inline constexpr std::size_t kChunksPerBlock = 8;

// The number of photographs that a cell lists for its block: those in which it has most pixels. It is more than a cell
// refers to, because several photographs may show the cell from the same side.
inline constexpr std::size_t kViewsPerCell = 24;

// Calls use() with the number of each camera and what it sees of a city: the faces of all chunks in their order, then
// those of the far sphere.
using LookAtCity = std::function<void(
    std::span<const Camera> cameras, const std::function<void(std::size_t camera, const VisibilityBuffer& seen)>& use)>;

struct SeenCity {
  LookAtCity look;
  std::vector<CellId> cell_of_face;
  ChunkCounts far;  // 0 where there is no far sphere
};

// Returns the memory that the job of a block takes at most, by what jobs of measured districts took; bytes. `faces`:
// those that it reads.
[[nodiscard]] std::uint64_t job_bytes(std::size_t faces, std::uint64_t memory);

// Fills in the plan's blocks; its chunks, views, memory and build options are there. Chunks that follow each other, as
// the writer of surfaces cuts them, are near each other: a block is as many of them as have at most `block_faces` faces
// and need no more than the plan's memory, or one. The far sphere is the last block. A job reads the chunks that a
// photograph shows where it shows a chunk of the block, or would without them.
void cut_into_blocks(const SeenCity& city, std::size_t block_faces, const BuildCallback& callback, CityPlan& plan);

}  // namespace lumatlas
