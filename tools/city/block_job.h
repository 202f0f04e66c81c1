// SPDX-License-Identifier: GPL-3.0-or-later
// The job of one block: from a plan and the scene's photographs to what the joined model holds of the block. It reads
// the block's part of the surface, the parts next to it, and the photographs that see it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"

namespace lumatlas {

// Returns whether the block was made by this plan.
[[nodiscard]] bool is_block_done(const std::filesystem::path& folder, const CityPlan& plan, std::size_t block);

struct BlockFacts {
  std::size_t offered = 0;  // photographs
  std::size_t stored = 0;
  std::uint64_t resident_tiles = 0;
  double total_ms = 0;
};

// Makes the block of that number and puts it, in one step, into block_folder(): a model of the surfaces that the job
// reads, whose cells outside of the block have no references. `plan` is that of the folder. Photographs are planned and
// stored as `build` does; their poses and gains are the plan's. The same bytes whatever other jobs do. Throws as
// build_model(), and std::invalid_argument for a block that the plan has not.
BlockFacts build_block(const std::filesystem::path& folder, const CityPlan& plan, std::size_t number,
                       const BuildCallback& callback);

}  // namespace lumatlas
