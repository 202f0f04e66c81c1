// SPDX-License-Identifier: GPL-3.0-or-later
// Joins the blocks of a city to one model.
#pragma once

#include <filesystem>

#include "atlas/snapshot.h"
#include "atlas/views/validity.h"
#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"

namespace lumatlas {

struct JoinedCity {
  Snapshot snapshot;         // views sorted by name, each with the tiles that any block needs of it
  ValidityOptions validity;  // of its masks
};

// Reads all blocks of a plan, each of which must be done (InputError naming the first that is not). Cells of
// neighbouring blocks fade into each other as those of one block do, because a joined model does not know blocks.
[[nodiscard]] JoinedCity join_blocks(const std::filesystem::path& folder, const CityPlan& plan,
                                     const BuildCallback& callback);

}  // namespace lumatlas
